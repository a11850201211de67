//! Surfaces whose parameters vary.

use super::worlds::{Builder, World, map, textured_quad, varying};
use crate::engine::{Purpose, generator};
use crate::transport::bsdf::{Anisotropy, MetallicRoughness};
use crate::transport::colour::Rgb;
use crate::transport::scene::{
    Alpha, ChannelMap, Encoding, Filter, Maps, Material, NormalMap, Pixels, Resolved, Texture, Wrap,
};
use glam::{DVec3, Vec3A, Vec4};

/// A texture of one value.
fn uniform_texture(rgba: [u8; 4]) -> Texture {
    let pixels = Pixels::new([1, 1], 4, rgba.to_vec()).expect("one pixel");
    Texture::new(pixels.into(), [Wrap::Repeat; 2], Filter::Bilinear, Encoding::Linear)
}

/// A quad in the xy plane that faces a camera on +z, under a lamp.
fn seen_quad(material: Material, texture: Texture, tangents: Vec<Vec4>) -> World {
    let v = DVec3::new;
    let quad = textured_quad([v(-1., -1., 0.), v(1., -1., 0.), v(1., 1., 0.), v(-1., 1., 0.)]);
    let lamp = textured_quad([v(-1., 3., -1.), v(1., 3., -1.), v(1., 3., 1.), v(-1., 3., 1.)]);
    Builder::default()
        .mesh(crate::transport::geometry::Mesh { tangents, ..quad }, material)
        .light(lamp, Rgb::ONE, false)
        .with_textures(vec![texture])
        .seen(v(0., 0., 3.), DVec3::ZERO, 40.0, [4, 4])
}

fn normal_mapped(rgb: [u8; 3], tangents: Vec<Vec4>) -> Vec3A {
    let maps = Maps { normal: Some(NormalMap { map: map(0), scale: 1.0 }), ..Maps::default() };
    let material = varying(MetallicRoughness::default(), maps, Alpha::Opaque);
    let world = seen_quad(material, uniform_texture([rgb[0], rgb[1], rgb[2], 255]), tangents);
    let lens = world.camera.vertex();
    world.scene.trace(&lens, Vec3A::new(0.01, 0.02, -1.0).normalize()).expect("the quad").shading_normal
}

/// x of a normal map leads along u, and y upwards in the image, whether the file has tangents or not.
#[test]
fn normals_lean_as_their_map_says() {
    let along = vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 4];
    for tangents in [Vec::new(), along] {
        let [right, up, flat] =
            [[228, 128, 220], [128, 228, 220], [128, 128, 255]].map(|rgb| normal_mapped(rgb, tangents.clone()));
        assert!(right.x > 0.5 && right.y.abs() < 0.01 && right.z > 0.5, "{right}");
        assert!(up.y > 0.5 && up.x.abs() < 0.01 && up.z > 0.5, "{up}");
        assert!(flat.z > 0.999, "{flat}");
    }
    // A tangent against u turns x about, and with its sign the bitangent.
    let turned = vec![Vec4::new(-1.0, 0.0, 0.0, -1.0); 4];
    let (right, up) = (normal_mapped([228, 128, 220], turned.clone()), normal_mapped([128, 228, 220], turned));
    assert!(right.x < -0.5 && up.y > 0.5, "{right} {up}");
}

/// However far a map leans, its normal stays above the surface.
#[test]
fn no_normal_leaves_its_hemisphere() {
    for rgb in [[255, 128, 0], [0, 0, 128], [0, 0, 0], [255, 255, 255], [128, 128, 0]] {
        let normal = normal_mapped(rgb, Vec::new());
        assert!(normal.z > 0.02 && normal.is_normalized(), "{rgb:?}: {normal}");
    }
}

/// Factors times a uniform texture are those of a uniform surface.
#[test]
fn a_uniform_texture_is_a_factor() {
    let factors = MetallicRoughness {
        metallic: 0.5,
        roughness: 0.9,
        transmission: 0.6,
        thin: false,
        ..MetallicRoughness::default()
    };
    let channel = |channel| Some(ChannelMap { map: map(0), channel });
    let maps = Maps { base_color: Some(map(0)), metallic: channel(2), roughness: channel(1), ..Maps::default() };
    let world =
        seen_quad(varying(factors.clone(), maps, Alpha::Opaque), uniform_texture([51, 128, 153, 255]), Vec::new());
    let product = MetallicRoughness {
        base_color: Rgb::new(51.0, 128.0, 153.0) / 255.0,
        metallic: 0.5 * 153.0 / 255.0,
        roughness: 0.9 * 128.0 / 255.0,
        ..factors
    };
    let plain =
        seen_quad(Material { bsdf: product.bsdf(), ..Material::default() }, uniform_texture([0; 4]), Vec::new());
    let mut rng = generator(3, Purpose::Sample, 0, 0, 0);
    let at = |world: &World| {
        world.scene.trace(&world.camera.vertex(), Vec3A::new(0.1, 0.05, -1.0).normalize()).expect("the quad")
    };
    let (varied, constant) = (at(&world), at(&plain));
    let mut room = [Resolved::default(), Resolved::default()];
    let [at_varied, at_constant] = &mut room;
    let (varied, constant) = (world.scene.surface(&varied, at_varied), plain.scene.surface(&constant, at_constant));
    let to_eye = Vec3A::new(-0.1, -0.05, 1.0).normalize();
    let mut met = 0;
    for _ in 0..1000 {
        let Some(to_light) = varied.sample(to_eye, &mut rng) else { continue };
        let (Some(a), Some(b)) = (varied.evaluate(to_light, to_eye), constant.evaluate(to_light, to_eye)) else {
            continue;
        };
        let relative = (a.value - b.value).abs().max_element() / b.value.max_element();
        assert!(relative < 2e-2 && (a.pdf_to_light / b.pdf_to_light - 1.0).abs() < 2e-2, "{a:?} {b:?}");
        met += 1;
    }
    assert!(met > 800, "{met}");
}

/// f_s of brushed metal on the quad where the half vector leans along x, and where it leans along y.
fn brushed(rotation: f32, direction: Option<[u8; 3]>) -> [f32; 2] {
    let maps = Maps { anisotropy: direction.map(|_| map(0)), ..Maps::default() };
    let anisotropy = Anisotropy { strength: 0.7, rotation, ..Anisotropy::default() };
    let factors = MetallicRoughness { roughness: 0.4, anisotropy, ..MetallicRoughness::default() };
    let [r, g, b] = direction.unwrap_or_default();
    let world = seen_quad(varying(factors, maps, Alpha::Opaque), uniform_texture([r, g, b, 255]), Vec::new());
    let towards = Vec3A::new(0.01, 0.02, -1.0).normalize();
    let vertex = world.scene.trace(&world.camera.vertex(), towards).expect("the quad");
    let mut room = Resolved::default();
    let surface = world.scene.surface(&vertex, &mut room);
    [Vec3A::X, Vec3A::Y].map(|aside| {
        let to_light = (Vec3A::Z + 0.8 * aside).normalize();
        surface.evaluate(to_light, Vec3A::Z).expect("lit").value.x
    })
}

/// Streaks lead along u, are turned towards what is up in the image, and follow the texture, whose blue is a factor on their strength.
#[test]
fn streaks_lie_as_their_texture_says() {
    let quarter = std::f32::consts::FRAC_PI_2;
    for (rotation, direction, along_x) in [
        (0.0, None, true),
        (quarter, None, false),
        (0.0, Some([255, 128, 255]), true),
        (0.0, Some([128, 255, 255]), false),
        (-quarter, Some([128, 255, 255]), true),
    ] {
        let [x, y] = brushed(rotation, direction);
        let ratio = if along_x { x / y } else { y / x };
        assert!(ratio > 3.0, "{rotation}, {direction:?}: {x} along x, {y} along y");
    }
    let [x, y] = brushed(0.0, Some([255, 128, 0]));
    assert!((x / y - 1.0).abs() < 0.01, "{x} and {y} where the texture says that nothing is brushed");
}

/// Without a map of its own a clear coat is smooth, whatever the base's normal map says; with one it leans as that does.
#[test]
fn a_coat_has_the_normal_of_its_own_map() {
    let shine = |maps: Maps| {
        let factors = MetallicRoughness {
            base_color: Rgb::ZERO,
            metallic: 0.0,
            specular: 0.0,
            clearcoat: 1.0,
            clearcoat_roughness: 0.3,
            ..MetallicRoughness::default()
        };
        // Leans towards +x by about 27°.
        let leaning = uniform_texture([185, 128, 242, 255]);
        let world = seen_quad(varying(factors, maps, Alpha::Opaque), leaning, Vec::new());
        let towards = Vec3A::new(0.01, 0.02, -1.0).normalize();
        let vertex = world.scene.trace(&world.camera.vertex(), towards).expect("the quad");
        let mut room = Resolved::default();
        let surface = world.scene.surface(&vertex, &mut room);
        [0.0, 54f32].map(|degrees| {
            let to_light = Vec3A::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos());
            surface.evaluate(to_light, Vec3A::Z).map_or(0.0, |found| found.value.x)
        })
    };
    let bent = Some(NormalMap { map: map(0), scale: 1.0 });
    let [straight, aside] = shine(Maps { normal: bent, ..Maps::default() });
    assert!(straight > 20.0 * aside, "{straight} {aside}");
    let [straight, aside] = shine(Maps { clearcoat_normal: bent, ..Maps::default() });
    assert!(aside > 20.0 * straight, "{straight} {aside}");
}
