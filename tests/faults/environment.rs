//! Light from all around: where it comes from, what the camera sees of it, and what is refused.

use std::{fs, path::Path};

use exr::prelude::{SpecificChannels, WritableImage};

use super::support::{Render, refusal, render};

const METHODS: [(&str, &str); 7] = [
    ("pt", "--samples-per-pixel 64"),
    ("bdpt", "--samples-per-pixel 64"),
    ("mlt", "--mutations-per-pixel 512"),
    ("mlt", "--mutations-per-pixel 512 --strata 4x4"),
    ("pssmlt", "--mutations-per-pixel 128"),
    ("mmlt", "--mutations-per-pixel 512"),
    ("auto", "--samples-per-pixel 64"),
];

/// A white floor that fills the image, with a wall at its end, behind the camera, where `walled`.
fn scene(folder: &Path, walled: bool) -> String {
    let wall = "v -9 0 5\nv 9 0 5\nv 9 9 5\nv -9 9 5\nf 5 6 7 8\n";
    let floor = "v -9 0 9\nv 9 0 9\nv 9 0 -9\nv -9 0 -9\nf 1 2 3 4\n";
    let obj = format!("mtllib s.mtl\nusemtl white\n{floor}usemtl black\n{}", if walled { wall } else { "" });
    fs::write(folder.join("s.obj"), obj).expect("written");
    fs::write(folder.join("s.mtl"), "newmtl white\nKd .5 .5 .5\nnewmtl black\nKd 0 0 0\n").expect("written");
    folder.join("s.obj").to_string_lossy().into_owned()
}

/// The same seen from above, or along the floor so that half of the image is sky.
const DOWN: &str = "--camera-from 0.1,2,0.2 --camera-to 0,0,0 --fov 30 --size 8x8";
const ALONG: &str = "--camera-from 0,0.5,4.9 --camera-to 0,0.5,-100 --fov 60 --size 8x8";

/// An image as Radiance HDR: shared exponents, without run lengths.
fn hdr(path: &Path, [width, height]: [u32; 2], pixel: impl Fn(u32, u32) -> [u8; 4]) {
    let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
    (0..height).flat_map(|j| (0..width).map(move |i| (i, j))).for_each(|(i, j)| bytes.extend(pixel(i, j)));
    fs::write(path, bytes).expect("written");
}

/// Radiance 2 above the horizon and 0 below, but a little blurred there.
fn upper_half(_: u32, j: u32) -> [u8; 4] {
    if j < 128 { [128, 128, 128, 130] } else { [0; 4] }
}

fn seen(scene: &str, view: &str, environment: &Path, more: &str) -> Render {
    render(scene, &format!("{view} --environment={} {more}", environment.display()))
}

#[test]
fn a_file_without_light_gets_a_sky_that_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = scene(folder.path(), false);
    // 0.5 (5 + 4 · ⅔ · 0.8004)/9
    for (method, budget) in METHODS {
        let found = render(&scene, &format!("{DOWN} --method {method} {budget}"));
        found.expect_b(0.3964, 1e-3);
        let words = "nothing in the file gives light, so a neutral sky does; --environment chooses another, or none";
        assert!(found.said.contains(words), "{}", found.said);
    }
    let dark = refusal(&scene, &format!("{DOWN} --environment none"));
    assert!(dark.contains("s.obj: the scene has no light") && dark.contains("Include > Punctual Lights"), "{dark}");
    assert_eq!(dark.lines().count(), 1, "{dark}");
    let lit = render(&scene, &format!("{DOWN} --environment 2,2,2 --samples-per-pixel 16 --method pt"));
    lit.expect_b(1.0, 1e-3);
    assert!(!lit.said.contains("sky"), "{}", lit.said);
}

#[test]
fn images_of_either_format_light_alike() {
    let folder = tempfile::tempdir().expect("a folder");
    let (scene, at) = (scene(folder.path(), false), |name: &str| folder.path().join(name));
    hdr(&at("half.hdr"), [512, 256], upper_half);
    let radiance = |at: exr::math::Vec2<usize>| if at.y() < 128 { (2f32, 2f32, 2f32) } else { (0.0, 0.0, 0.0) };
    exr::image::Image::from_channels((512, 256), SpecificChannels::rgb(radiance))
        .write()
        .to_file(at("half.exr"))
        .expect("written");
    let of = |name: &str, more: &str| seen(&scene, DOWN, &at(name), more);
    let [hdr, exr] = ["half.hdr", "half.exr"].map(|name| of(name, "--method pt --samples-per-pixel 64"));
    assert_eq!(hdr.b(), exr.b());
    hdr.expect_b(1.0, 2e-3);
    of("half.hdr", "--method bdpt --samples-per-pixel 64 --environment-strength 0.25").expect_b(0.25, 1e-3);
}

/// A wall behind the camera hides what lies in +z. The image is bright in its left half: azimuths from −x over −z to +x.
#[test]
fn an_environment_is_turned_about_the_vertical() {
    let folder = tempfile::tempdir().expect("a folder");
    let (scene, image) = (scene(folder.path(), true), folder.path().join("side.hdr"));
    hdr(&image, [512, 256], |i, _| if i < 256 { [128, 128, 128, 130] } else { [0; 4] });
    let b = |degrees: f64| {
        seen(&scene, DOWN, &image, &format!("--method pt --samples-per-pixel 64 --environment-rotation={degrees}"))
            .b()
            .0
    };
    let [front, back, left, right] = [0.0, 180.0, 90.0, -90.0].map(b);
    assert!(front > 1.2 * left && left > 1.2 * back, "{front} {left} {right} {back}");
    assert!((left / right - 1.0).abs() < 0.05, "{left} {right}");
}

#[test]
fn the_background_is_seen_or_not_and_lights_in_either_case() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = scene(folder.path(), false);
    for (method, budget) in METHODS {
        let of = |background: &str| {
            render(&scene, &format!("{ALONG} --environment 2,2,2 --background {background} --method {method} {budget}"))
        };
        // The floor ends 0.5/13.9 under the horizon, of 1/√3 to the image's edge.
        let sky = 0.5 + 0.5 * 0.5 / 13.9 * 3f64.sqrt();
        of("visible").expect_b(2.0 * sky + 1.0 * (1.0 - sky), 2e-3);
        of("black").expect_b(1.0 - sky, 2e-3);
    }
}

/// The control: half of the light, or a sky that is seen where it should not be, is told.
#[test]
#[should_panic = "b = "]
fn a_wrong_radiance_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = scene(folder.path(), false);
    render(&scene, &format!("{DOWN} --environment 1.98,1.98,1.98 --method pt --samples-per-pixel 1024"))
        .expect_b(1.0, 1e-3);
}

#[test]
fn threads_change_no_bit_under_a_sky() {
    let folder = tempfile::tempdir().expect("a folder");
    let (scene, image) = (scene(folder.path(), true), folder.path().join("half.hdr"));
    hdr(&image, [64, 32], |i, j| if (i, j) == (9, 7) { [200, 180, 90, 140] } else { [90, 110, 140, 128] });
    for options in
        ["--method pt --samples-per-pixel 8", "--mutations-per-pixel 64 --strata 4x4", "--samples-per-pixel 8"]
    {
        let of = |threads: u32| {
            let report = seen(&scene, ALONG, &image, &format!("{options} --threads {threads}")).report;
            ["b", "b_stderr", "relative_error"].map(|name| report[name].clone())
        };
        assert_eq!([of(2), of(8)], [of(1), of(1)], "{options}");
    }
}

#[test]
fn a_bad_environment_is_one_sentence() {
    let folder = tempfile::tempdir().expect("a folder");
    let (scene, at) = (scene(folder.path(), false), |name: &str| folder.path().join(name));
    fs::write(at("noise.exr"), [7; 999]).expect("written");
    fs::write(at("huge.hdr"), "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60000 +X 60000\n").expect("written");
    hdr(&at("short.hdr"), [16, 8], upper_half);
    let whole = fs::read(at("short.hdr")).expect("written");
    fs::write(at("short.hdr"), &whole[..whole.len() - 9]).expect("written");
    fs::create_dir(at("folder.hdr")).expect("made");
    for (name, part) in [
        ("missing.hdr", "missing.hdr: cannot be read"),
        ("noise.exr", "noise.exr: cannot be read as OpenEXR"),
        ("huge.hdr", "60000x60000 pixels are more than"),
        ("short.hdr", "short.hdr: cannot be read as Radiance HDR"),
        ("folder.hdr", "folder.hdr: not a regular file"),
    ] {
        let said = refusal(&scene, &format!("{DOWN} --environment={}", at(name).display()));
        assert!(said.contains(part) && said.lines().count() == 1, "{name}: {said}");
    }
    for (option, part) in [
        ("--environment photo.jpg", "give an .hdr or .exr image, sky, none, or a radiance as in 1,1,1"),
        ("--environment 1,-1,1", "radiance is not negative"),
        ("--environment-strength -1", "give a number that is not negative"),
    ] {
        let said = refusal(&scene, &format!("{DOWN} {option}"));
        assert!(said.contains(part), "{option}: {said}");
    }
}

/// A number that no radiance can be becomes 0, an image of another shape is stretched, and both are said.
#[test]
fn a_strange_image_is_taken_with_a_warning() {
    let folder = tempfile::tempdir().expect("a folder");
    let (scene, path) = (scene(folder.path(), false), folder.path().join("odd.exr"));
    let radiance = |at: exr::math::Vec2<usize>| {
        if at == exr::math::Vec2(3, 60) { (f32::NAN, -1.0, 2.0) } else { (2f32, 2.0, 2.0) }
    };
    exr::image::Image::from_channels((64, 64), SpecificChannels::rgb(radiance))
        .write()
        .to_file(&path)
        .expect("written");
    let found = seen(&scene, DOWN, &path, "--method pt --samples-per-pixel 64");
    found.expect_b(1.0, 1e-3);
    assert!(found.said.contains("1 pixels have a value that is negative or no number"), "{}", found.said);
    assert!(
        found.said.contains("64x64 pixels, while an image of all directions is twice as wide as high"),
        "{}",
        found.said
    );
}
