//! Renders a glTF or OBJ file, or a built-in scene, to a portable float map: `render_gltf SCENE FILE.pfm`.

use mlt_core::transport::render::{Method, Renderer, Settings};
use mlt_core::transport::scene::{Scene, View};
use std::{error::Error, fs, ops::ControlFlow};

fn main() -> Result<(), Box<dyn Error>> {
    let [scene, file] = [(1, "cornell"), (2, "")].map(|(i, usual)| std::env::args().nth(i).unwrap_or(usual.into()));
    let description = mlt_scene::open(scene)?.description;
    let pose = description.cameras.first().ok_or("the scene has no camera")?.clone();
    let scene = Scene::new(description)?;
    let camera = scene.camera(&pose, [64, 48]);
    let renderer = Renderer::new(View { scene: &scene, camera: &camera }, Settings::new(Method::Auto, 4.0));
    let mut sums = renderer.sums();
    renderer.render(0..16, &mut sums, &mut |_, _| ControlFlow::Continue(()));
    sums.tally().chains().warnings().iter().for_each(|warning| eprintln!("warning: {warning}"));
    let image = sums.film().means();
    let rows = (0..48).rev().flat_map(|row| 64 * row..64 * row + 64); // from the bottom up
    let pixels = rows.flat_map(|i| image[i]).flat_map(f32::to_le_bytes);
    let bytes: Vec<u8> = "PF\n64 48\n-1.0\n".bytes().chain(pixels).collect();
    if file.is_empty() {
        println!("{} bytes", bytes.len())
    } else {
        fs::write(file, bytes)?
    }
    Ok(())
}

#[test]
fn it_renders() {
    main().expect("the built-in scene");
}
