//! Renders a glTF or OBJ file, or a built-in scene, to a portable float map: `render_gltf SCENE FILE.pfm`.

use mlt_core::transport::render::{Counts, Method, Renderer, Settings};
use mlt_core::transport::scene::{Scene, View};
use std::{error::Error, fs, ops::ControlFlow};

fn main() -> Result<(), Box<dyn Error>> {
    let [scene, file] = [(1, "cornell"), (2, "")].map(|(i, usual)| std::env::args().nth(i).unwrap_or(usual.into()));
    let description = mlt_scene::open(scene)?.description;
    let pose = description.cameras.first().ok_or("the scene has no camera")?.clone();
    let scene = Scene::new(description)?;
    let camera = scene.camera(&pose, [64, 48]);
    let renderer = Renderer::new(View { scene: &scene, camera: &camera }, Settings::new(Method::Auto, 4.0));
    let (mut film, mut counts) = (renderer.film(), Counts::default());
    renderer.render(0..16, &mut film, &mut counts, &mut |_, _| ControlFlow::Continue(()));
    counts.chains.warnings().iter().for_each(|warning| eprintln!("warning: {warning}"));
    let rows = (0..48).rev().flat_map(|row| 64 * row..64 * row + 64); // from the bottom up
    let pixels = rows.flat_map(|i| film.mean(i)).flat_map(|value| (value as f32).to_le_bytes());
    let image: Vec<u8> = "PF\n64 48\n-1.0\n".bytes().chain(pixels).collect();
    if file.is_empty() {
        println!("{} bytes", image.len())
    } else {
        fs::write(file, image)?
    }
    Ok(())
}

#[test]
fn it_renders() {
    main().expect("the built-in scene");
}
