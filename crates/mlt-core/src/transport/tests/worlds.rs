//! Small scenes for tests.

use crate::transport::bsdf::{Anisotropy, Bsdf, Lambert, MetallicRoughness};
use crate::transport::colour::Rgb;
use crate::transport::geometry::Mesh;
use crate::transport::scene::{
    Alpha, Camera, CameraPose, ChannelMap, Cone, Encoding, Environment, Filter, Lens, Map, Maps, Material, NormalMap,
    Pixels, Punctual, PunctualLight, Scene, SceneDescription, Texture, View, Wrap,
};
use glam::{Affine2, DVec3, Vec2, Vec3};
use std::f64::consts::{PI, TAU};

/// A scene with a camera.
pub(crate) struct World {
    pub scene: Scene,
    pub camera: Camera,
}

impl World {
    pub(crate) fn view(&self) -> View<'_> {
        View { scene: &self.scene, camera: &self.camera }
    }
}

/// A description that grows mesh by mesh.
#[derive(Default)]
pub(crate) struct Builder(SceneDescription);

impl Builder {
    /// A surface that only scatters.
    pub(crate) fn surface(self, mesh: Mesh, bsdf: Bsdf) -> Self {
        self.mesh(mesh, Material { bsdf, ..Material::default() })
    }

    /// A surface that only emits.
    pub(crate) fn light(self, mesh: Mesh, emission: Rgb, emits_both_sides: bool) -> Self {
        self.mesh(mesh, Material { emission, emits_both_sides, ..Material::default() })
    }

    pub(crate) fn with_textures(mut self, textures: Vec<Texture>) -> Self {
        self.0.textures = textures;
        self
    }

    pub(crate) fn mesh(mut self, mesh: Mesh, material: Material) -> Self {
        self.0.meshes.push(Mesh { material: self.0.materials.len() as u32, ..mesh });
        self.0.materials.push(material);
        self
    }

    /// Under light from all around.
    pub(crate) fn under(mut self, environment: Environment) -> Self {
        self.0.environment = Some(environment);
        self
    }

    /// Lit by lights without a surface.
    pub(crate) fn lit_by(mut self, lights: impl IntoIterator<Item = (Rgb, Punctual)>) -> Self {
        let light = |(emission, kind)| PunctualLight { name: String::new(), emission, kind };
        self.0.punctual.extend(lights.into_iter().map(light));
        self
    }

    /// Seen from `from` towards `to`.
    pub(crate) fn seen(self, from: DVec3, to: DVec3, fov: f32, size: [u32; 2]) -> World {
        self.seen_through(Lens::Pinhole { vertical_fov: fov.to_radians() }, [from, to], size)
    }

    /// Seen from the first point towards the second.
    pub(crate) fn seen_through(self, lens: Lens, [from, to]: [DVec3; 2], size: [u32; 2]) -> World {
        let forward = (to - from).as_vec3().normalize();
        let side = forward.cross(if forward.y.abs() < 0.9 { Vec3::Y } else { Vec3::NEG_Z }).normalize();
        let pose = CameraPose {
            name: String::new(),
            position: from,
            forward,
            up: side.cross(forward),
            lens,
            aspect_ratio: None,
        };
        let scene = Scene::new(self.0).unwrap();
        let camera = scene.camera(&pose, size);
        World { scene, camera }
    }
}

pub(crate) fn lambert(reflectance: Rgb) -> Bsdf {
    Bsdf::Lambert(Lambert { reflectance })
}

/// Two triangles, counter-clockwise seen from where a, b, c, d are.
pub(crate) fn quad(corners: [DVec3; 4]) -> Mesh {
    Mesh::quad(corners)
}

/// A ball, with smooth shading normals on few flat faces.
pub(crate) fn ball(centre: DVec3, radius: f64, smooth: bool) -> Mesh {
    let (rows, columns) = (6u32, 9u32);
    let direction = |i: u32, j: u32| {
        let (theta, phi) = (PI * f64::from(i) / f64::from(rows), TAU * f64::from(j) / f64::from(columns));
        DVec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin())
    };
    let grid = || (0..=rows).flat_map(|i| (0..columns).map(move |j| (i, j)));
    let index = |i: u32, j: u32| i * columns + j % columns;
    let faces = (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j)));
    let triangles = faces.flat_map(|(i, j)| {
        let [a, b, c, d] = [index(i, j), index(i, j + 1), index(i + 1, j + 1), index(i + 1, j)];
        let upper = (i > 0).then_some([a, b, c]);
        upper.into_iter().chain((i + 1 < rows).then_some([a, c, d]))
    });
    Mesh {
        positions: grid().map(|(i, j)| centre + radius * direction(i, j)).collect(),
        normals: if smooth { grid().map(|(i, j)| direction(i, j).as_vec3()).collect() } else { Vec::new() },
        triangles: triangles.collect(),
        ..Mesh::default()
    }
}

/// A box open to the camera, with coloured walls and a rectangular light under its ceiling.
pub(crate) fn walls() -> Builder {
    let v = DVec3::new;
    let white = || lambert(Rgb::splat(0.7));
    Builder::default()
        .surface(quad([v(-1., -1., 1.), v(1., -1., 1.), v(1., -1., -1.), v(-1., -1., -1.)]), white())
        .surface(quad([v(-1., 1., -1.), v(1., 1., -1.), v(1., 1., 1.), v(-1., 1., 1.)]), white())
        .surface(quad([v(-1., -1., -1.), v(1., -1., -1.), v(1., 1., -1.), v(-1., 1., -1.)]), white())
        .surface(
            quad([v(-1., -1., 1.), v(-1., -1., -1.), v(-1., 1., -1.), v(-1., 1., 1.)]),
            lambert(Rgb::new(0.6, 0.1, 0.1)),
        )
        .surface(
            quad([v(1., -1., -1.), v(1., -1., 1.), v(1., 1., 1.), v(1., 1., -1.)]),
            lambert(Rgb::new(0.1, 0.5, 0.1)),
        )
        .light(
            quad([v(-0.4, 0.95, -0.3), v(0.4, 0.95, -0.3), v(0.4, 0.95, 0.3), v(-0.4, 0.95, 0.3)]),
            Rgb::new(5.0, 4.0, 3.0),
            false,
        )
}

/// The box with a ball of some material in it.
pub(crate) fn room(bsdf: Bsdf, smooth: bool) -> World {
    see(walls().surface(ball(DVec3::new(0.1, -0.35, 0.1), 0.5, smooth), bsdf))
}

/// The box with two balls and a second light, a two-sided triangle.
pub(crate) fn two_lights(left: Bsdf, right: Bsdf) -> World {
    let v = DVec3::new;
    let triangle = Mesh {
        positions: vec![v(-0.8, -0.2, -0.8), v(-0.3, -0.2, -0.9), v(-0.6, 0.3, -0.7)],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    see(walls()
        .surface(ball(v(-0.4, -0.6, 0.2), 0.35, true), left)
        .surface(ball(v(0.45, -0.5, 0.0), 0.4, false), right)
        .light(triangle, Rgb::new(2.0, 3.0, 6.0), true))
}

/// The box with a ball that emits and reflects.
pub(crate) fn glowing() -> World {
    let material = Material { emission: Rgb::new(2.0, 3.0, 6.0), ..veil(lambert(Rgb::splat(0.7)), 1.0) };
    see(walls().mesh(ball(DVec3::new(0.2, -0.3, 0.1), 0.5, true), material))
}

/// The box with a small ball of light in one corner, a large panel that faces away from it, and one with two faces.
pub(crate) fn lamps() -> World {
    let panel = |x: f64, z: f64| -> [DVec3; 4] {
        [[x, 0.2, z], [x, 0.2, z + 0.5], [x, 0.7, z + 0.5], [x, 0.7, z]].map(DVec3::from_array)
    };
    walls()
        .light(ball(DVec3::new(0.2, 0.3, -0.4), 0.05, false), Rgb::new(5.0, 4.0, 3.0), false)
        .light(quad(panel(0.9, 0.1)), Rgb::ONE, false)
        .light(quad(panel(-0.3, -0.7)), Rgb::splat(2.0), true)
        .surface(ball(DVec3::new(-0.2, 0.0, 0.3), 0.2, true), lambert(Rgb::splat(0.5)))
        .seen(DVec3::new(0.0, 0.4, 0.9), DVec3::ZERO, 60.0, [8, 8])
}

/// An overcast sky, brighter above, with a coloured sun of 12 by 9 degrees that holds half of its power, over a dark ground.
pub(crate) fn cloudy() -> Environment {
    let pixel = |i: u32, j: u32| match (i, j) {
        (20, 5) => Rgb::new(260.0, 220.0, 120.0),
        (_, 0..10) => Rgb::new(1.0, 1.2, 1.6) * (2.0 - 0.1 * j as f32),
        _ => Rgb::new(0.2, 0.15, 0.1),
    };
    let pixels = (0..20).flat_map(|j| (0..30).map(move |i| pixel(i, j))).collect();
    let (mut environment, _) = Environment::image([30, 20], pixels).expect("as many pixels as it says");
    environment.rotation = 0.4;
    environment
}

/// A floor with a ball of some material and a diffuse one beside it, under a cloudy sky that the camera sees.
pub(crate) fn outdoors(bsdf: Bsdf) -> World {
    let v = DVec3::new;
    Builder::default()
        .surface(quad([v(-2., 0., 2.), v(2., 0., 2.), v(2., 0., -2.), v(-2., 0., -2.)]), lambert(Rgb::splat(0.6)))
        .surface(ball(v(-0.5, 0.6, 0.1), 0.5, true), bsdf)
        .surface(ball(v(0.7, 0.5, 0.0), 0.4, false), lambert(Rgb::new(0.7, 0.3, 0.2)))
        .under(cloudy())
        .seen(v(0.3, 0.9, 3.6), v(0.0, 0.6, 0.0), 42.0, [16, 16])
}

/// The box with lamps behind a thin curtain, open to a sky that the camera does not see. All τ are powers of two.
pub(crate) fn lamps_and_sky() -> World {
    let v = DVec3::new;
    let mut sky = cloudy();
    (sky.visible, sky.strength) = (false, 0.5);
    walls()
        .light(ball(v(0.2, 0.3, -0.4), 0.05, false), Rgb::new(5.0, 4.0, 3.0), false)
        .mesh(curtain(0.7), veil(lambert(Rgb::splat(0.5)), 0.5))
        .surface(ball(v(-0.2, -0.4, 0.1), 0.4, true), glass(0.0))
        .under(sky)
        .seen(v(0.2, 0.1, 3.4), DVec3::ZERO, 44.0, [16, 16])
}

/// Water under a bright ceiling, from steep to grazing angles: nothing is seen but what the Fresnel term reflects.
pub(crate) fn pond() -> World {
    let v = DVec3::new;
    Builder::default()
        .surface(quad([v(-20., 0., 20.), v(20., 0., 20.), v(20., 0., -20.), v(-20., 0., -20.)]), glass(0.0))
        .light(quad([v(-20., 3., -20.), v(20., 3., -20.), v(20., 3., 20.), v(-20., 3., 20.)]), Rgb::ONE, false)
        .seen(v(0., 1., 4.), v(0., 0., 3.), 80.0, [16, 16])
}

/// The box behind a wall that is open at one side: light comes to the front through the opening alone.
pub(crate) fn door() -> World {
    let v = DVec3::new;
    let wall = quad([v(-1., -1., 0.4), v(0.2, -1., 0.4), v(0.2, 1., 0.4), v(-1., 1., 0.4)]);
    see(walls().surface(wall, lambert(Rgb::splat(0.5))))
}

/// A material that is there for the share `opacity`.
pub(crate) fn veil(bsdf: Bsdf, opacity: f32) -> Material {
    Material { bsdf, opacity, ..Material::default() }
}

/// A curtain across the box, parallel to its back.
pub(crate) fn curtain(z: f64) -> Mesh {
    let v = DVec3::new;
    quad([v(-1., -1., z), v(1., -1., z), v(1., 1., z), v(-1., 1., z)])
}

/// The box with a thin curtain, a faint ball of gloss and one of mirror, and a faint lamp. All τ are powers of two.
pub(crate) fn veils() -> World {
    let v = DVec3::new;
    let lamp = Material { emission: Rgb::new(2.0, 3.0, 6.0), emits_both_sides: true, ..veil(Bsdf::Black, 0.5) };
    see(walls()
        .mesh(curtain(0.5), veil(lambert(Rgb::splat(0.5)), 0.5))
        .mesh(ball(v(-0.4, -0.5, 0.2), 0.4, true), veil(glossy(), 0.75))
        .mesh(ball(v(0.45, -0.5, 0.0), 0.4, true), veil(mirror(), 0.5))
        .mesh(ball(v(-0.5, 0.5, -0.5), 0.2, false), lamp))
}

/// The box with a point, a spot and a sun that shines in from the front; no other light.
pub(crate) fn points() -> World {
    let v = DVec3::new;
    let axis = Vec3::new(-0.5, -1.0, -0.2).normalize();
    let mut builder = walls().surface(ball(v(0.1, -0.35, 0.1), 0.5, true), glass(0.0));
    builder.0.materials.iter_mut().for_each(|material| material.emission = Rgb::ZERO);
    let along = Vec3::new(0.1, -0.4, -1.0).normalize();
    see(builder.lit_by([
        (Rgb::new(0.5, 0.4, 0.3), Punctual::Point { position: v(-0.6, 0.5, 0.2) }),
        (Rgb::ONE, Punctual::Spot { position: v(0.7, 0.8, 0.3), axis, cone: [0.3, 0.6] }),
        (Rgb::new(0.3, 0.4, 1.0), Punctual::Directional { along, angle: 0.0 }),
    ]))
}

/// The box with a ball of glass and two more lamps, balls that emit into cones, of which the wide one reflects, too.
pub(crate) fn beams() -> World {
    let v = DVec3::new;
    let lamp = |bsdf: Bsdf, emission: Rgb, [x, y, z]: [f32; 3], angles: [f32; 2]| {
        let cone = Some(Cone::new(Vec3::new(x, y, z).normalize(), angles));
        Material { bsdf, emission, cone, ..Material::default() }
    };
    see(walls()
        .surface(ball(v(0.3, -0.6, 0.3), 0.35, true), glass(0.0))
        .mesh(ball(v(0.6, 0.6, 0.2), 0.12, false), lamp(Bsdf::Black, Rgb::splat(60.0), [-0.2, -1.0, 0.1], [0.2, 0.4]))
        .mesh(
            ball(v(-0.6, 0.0, -0.2), 0.2, true),
            lamp(lambert(Rgb::splat(0.5)), Rgb::new(4.0, 6.0, 9.0), [1.0, -0.5, 0.5], [0.0, 1.4]),
        ))
}

/// A floor with a ball of some material and a diffuse one beside it, under two suns that are seen in part in the same directions, one of
/// which sets, and a faint sky.
pub(crate) fn suns(bsdf: Bsdf) -> World {
    let v = DVec3::new;
    let sun = |x: f32, y: f32, angle: f32| Punctual::Directional { along: -Vec3::new(x, y, 0.4).normalize(), angle };
    Builder::default()
        .surface(quad([v(-2., 0., 2.), v(2., 0., 2.), v(2., 0., -2.), v(-2., 0., -2.)]), lambert(Rgb::splat(0.6)))
        .surface(ball(v(-0.5, 0.6, 0.1), 0.5, true), bsdf)
        .surface(ball(v(0.7, 0.5, 0.0), 0.4, false), lambert(Rgb::new(0.7, 0.3, 0.2)))
        .lit_by([
            (Rgb::new(1.0, 0.8, 0.5), sun(0.3, 1.0, 0.3)),
            (Rgb::new(0.5, 0.6, 1.0), sun(0.5, 1.0, 0.6)),
            (Rgb::new(1.5, 0.5, 0.2), sun(-1.0, 0.1, 0.5)),
        ])
        .under(Environment::constant(Rgb::splat(0.2)))
        .seen(v(0.3, 0.9, 3.6), v(0.0, 0.6, 0.0), 42.0, [16, 16])
}

/// A pane between two suns, which a texture makes metal or frosted glass. It is metal where no texture changes a factor.
pub(crate) fn spotted_pane() -> World {
    let v = DVec3::new;
    let factors = MetallicRoughness { roughness: 0.7, transmission: 1.0, thin: true, ..MetallicRoughness::default() };
    let spots = Maps { metallic: Some(ChannelMap { map: map(0), channel: 0 }), ..Maps::default() };
    let pane = varying(factors, spots, Alpha::Opaque);
    assert!(!pane.bsdf.is_transmissive());
    let sun = |z: f32| Punctual::Directional { along: Vec3::new(-0.3, -0.6, z).normalize(), angle: 0.4 };
    Builder::default()
        .mesh(textured_quad([v(-1., -1., 0.), v(1., -1., 0.), v(1., 1., 0.), v(-1., 1., 0.)]), pane)
        .lit_by([(Rgb::new(1.0, 0.8, 0.5), sun(1.0)), (Rgb::new(0.5, 0.6, 1.0), sun(-1.0))])
        .with_textures(vec![texture(3, Encoding::Linear)])
        .under(Environment::constant(Rgb::splat(0.2)))
        .seen(v(0.2, 0.1, 3.0), DVec3::ZERO, 34.0, [16, 16])
}

/// The box seen through a lens that blurs its light and most of its balls.
pub(crate) fn blurred() -> World {
    let lens = Lens::Thin { vertical_fov: 38f32.to_radians(), radius: 0.3, focus: 2.6 };
    balls().seen_through(lens, [DVec3::new(0.2, 0.1, 3.4), DVec3::ZERO], [16, 16])
}

/// The box by parallel rays, whose rectangle cuts it open.
pub(crate) fn parallel() -> World {
    let lens = Lens::Orthographic { height: 1.8 };
    balls().seen_through(lens, [DVec3::new(0.2, 0.3, 0.9), DVec3::new(-0.1, -0.1, -1.0)], [16, 16])
}

/// The box with a ball of glass, and lamps to choose from.
fn balls() -> Builder {
    walls().surface(ball(DVec3::new(0.1, -0.35, 0.1), 0.5, true), glass(0.0)).light(
        ball(DVec3::new(-0.5, 0.3, -0.4), 0.05, false),
        Rgb::new(9.0, 9.0, 3.0),
        false,
    )
}

/// The view into the box.
fn see(builder: Builder) -> World {
    builder.seen(DVec3::new(0.2, 0.1, 3.4), DVec3::ZERO, 38.0, [16, 16])
}

fn material(parameters: MetallicRoughness) -> Bsdf {
    parameters.bsdf()
}

pub(crate) fn mirror() -> Bsdf {
    material(MetallicRoughness { roughness: 0.0, base_color: Rgb::new(0.9, 0.8, 0.6), ..Default::default() })
}

pub(crate) fn rough_metal() -> Bsdf {
    material(MetallicRoughness { roughness: 0.5, base_color: Rgb::new(0.9, 0.8, 0.6), ..Default::default() })
}

pub(crate) fn glossy() -> Bsdf {
    material(MetallicRoughness {
        roughness: 0.4,
        metallic: 0.0,
        base_color: Rgb::new(0.2, 0.3, 0.6),
        ..Default::default()
    })
}

/// Glass, or frosted glass with a positive roughness.
pub(crate) fn glass(roughness: f32) -> Bsdf {
    material(MetallicRoughness { roughness, metallic: 0.0, transmission: 1.0, thin: false, ..Default::default() })
}

/// A texture of 4 × 4 pixels of some channels, all of them different.
pub(crate) fn texture(channels: usize, encoding: Encoding) -> Texture {
    let bytes = (0..16 * channels).map(|i| (i * 89 % 251) as u8).collect();
    let pixels = Pixels::new([4, 4], channels, bytes).expect("as many bytes as pixels");
    Texture::new(pixels.into(), [Wrap::Repeat; 2], Filter::Bilinear, encoding)
}

/// A texture read as it lies.
pub(crate) fn map(texture: u32) -> Map {
    Map { texture, set: 0, transform: Affine2::IDENTITY }
}

/// A material of parameters that vary.
pub(crate) fn varying(factors: MetallicRoughness, maps: Maps, alpha: Alpha) -> Material {
    Material::default().scattering(factors, maps, alpha)
}

/// A quad with the texture's corners at its own, the first one below on the left.
pub(crate) fn textured_quad(corners: [DVec3; 4]) -> Mesh {
    let uv = [[0., 1.], [1., 1.], [1., 0.], [0., 0.]].map(Vec2::from_array).to_vec();
    Mesh { uv: [uv, Vec::new()], ..quad(corners) }
}

/// The box with a curtain of varying colour with holes, a ball of varying metal and one that is bumpy, and a lamp that shines
/// unevenly. Half of the lamp's front is dark.
pub(crate) fn textured() -> World {
    let v = DVec3::new;
    let red = MetallicRoughness { base_color: Rgb::new(0.9, 0.4, 0.3), ..MetallicRoughness::default() };
    let plain = MetallicRoughness { metallic: 0.0, ..red.clone() };
    let channel = |texture, channel| Some(ChannelMap { map: map(texture), channel });
    let cloth = Maps { base_color: Some(map(0)), opacity: channel(0, 3), ..Maps::default() };
    let metal = Maps { metallic: channel(1, 2), roughness: channel(1, 1), ..Maps::default() };
    let bumps = Maps { normal: Some(NormalMap { map: map(2), scale: 0.7 }), ..Maps::default() };
    let glow = Maps { emission: Some(map(0)), ..Maps::default() };
    let lamp = Material { emission: Rgb::splat(6.0), ..varying(plain.clone(), glow, Alpha::Opaque) };
    let builder = walls()
        .mesh(
            textured_quad([v(-1., -1., 0.5), v(1., -1., 0.5), v(1., 1., 0.5), v(-1., 1., 0.5)]),
            varying(plain.clone(), cloth, Alpha::Mask(0.5)),
        )
        .mesh(round(v(-0.4, -0.5, 0.2), 0.4), varying(red, metal, Alpha::Opaque))
        .mesh(round(v(0.45, -0.5, 0.0), 0.4), varying(plain, bumps, Alpha::Opaque))
        .mesh(textured_quad([v(-0.9, -0.2, -0.8), v(-0.3, -0.2, -0.9), v(-0.3, 0.6, -0.9), v(-0.9, 0.6, -0.8)]), lamp);
    see(builder.with_textures(vec![texture(4, Encoding::Srgb), texture(3, Encoding::Linear), normal_map()]))
}

/// A smooth ball with texture coordinates.
fn round(centre: DVec3, radius: f64) -> Mesh {
    let ball = ball(centre, radius, true);
    let uv = ball.normals.iter().map(|n| Vec2::new(n.x + n.z, n.y)).collect();
    Mesh { uv: [uv, Vec::new()], ..ball }
}

/// The box with a ball of brushed metal whose streaks a texture turns, one of brushed plastic, and a bumpy coat over a smooth base.
pub(crate) fn brushed() -> World {
    let v = DVec3::new;
    let parameters = |metallic, roughness, strength| MetallicRoughness {
        base_color: Rgb::new(0.9, 0.7, 0.5),
        metallic,
        roughness,
        anisotropy: Anisotropy { strength, rotation: 0.5, ..Anisotropy::default() },
        ..MetallicRoughness::default()
    };
    let turning = Maps { anisotropy: Some(map(0)), ..Maps::default() };
    let bumps = Maps { clearcoat_normal: Some(NormalMap { map: map(1), scale: 0.5 }), ..Maps::default() };
    let coated =
        MetallicRoughness { clearcoat: 1.0, clearcoat_roughness: 0.5, metallic: 0.0, ..MetallicRoughness::default() };
    see(walls()
        .mesh(round(v(-0.4, -0.5, 0.2), 0.4), varying(parameters(1.0, 0.5, 0.8), turning, Alpha::Opaque))
        .mesh(round(v(0.45, -0.5, 0.0), 0.4), varying(parameters(0.0, 0.4, 0.9), Maps::default(), Alpha::Opaque))
        .mesh(round(v(0.0, 0.2, -0.3), 0.4), varying(coated, bumps, Alpha::Opaque))
        .with_textures(vec![texture(3, Encoding::Linear), normal_map()]))
}

/// The box with a ball of glass that absorbs, and one of velvet under a coat.
fn layers() -> World {
    let v = DVec3::new;
    let amber =
        |roughness| Material { bsdf: glass(roughness), absorption: Rgb::new(0.5, 2.0, 8.0), ..Material::default() };
    let velvet = material(MetallicRoughness {
        base_color: Rgb::new(0.2, 0.1, 0.4),
        metallic: 0.3,
        roughness: 0.5,
        clearcoat: 0.8,
        clearcoat_roughness: 0.3,
        sheen_color: Rgb::new(0.8, 0.4, 0.4),
        sheen_roughness: 0.5,
        ..MetallicRoughness::default()
    });
    see(walls()
        .mesh(ball(v(-0.5, -0.5, 0.2), 0.4, false), amber(0.0))
        .mesh(ball(v(0.0, 0.3, 0.0), 0.3, false), amber(0.4))
        .surface(ball(v(0.5, -0.5, 0.0), 0.4, true), velvet))
}

/// Normals that lean by up to half a right angle.
fn normal_map() -> Texture {
    let leaning =
        |i: usize| [128 + [0, 60, 0, 196][i % 4], 128 + [50, 0, 206, 0][i / 4], 220].map(|x: i32| (x % 256) as u8);
    let pixels = Pixels::new([4, 4], 3, (0..16).flat_map(leaning).collect()).expect("as many bytes as pixels");
    Texture::new(pixels.into(), [Wrap::Mirror; 2], Filter::Bilinear, Encoding::Linear)
}

/// Every kind of surface that a ball may be of, by name.
pub(crate) fn worlds() -> Vec<(&'static str, World)> {
    vec![
        ("diffuse", room(lambert(Rgb::splat(0.5)), false)),
        ("shading normals", room(lambert(Rgb::splat(0.5)), true)),
        ("mirror", room(mirror(), true)),
        ("rough metal", room(rough_metal(), true)),
        ("coated", room(glossy(), false)),
        ("glass", room(glass(0.0), false)),
        ("glass with shading normals", room(glass(0.0), true)),
        ("frosted glass", room(glass(0.4), false)),
        ("two lights", two_lights(glass(0.0), mirror())),
        ("veils", veils()),
        ("glowing ball", glowing()),
        ("lamps", lamps()),
        ("sky", outdoors(glass(0.0))),
        ("sky on gloss", outdoors(glossy())),
        ("lamps and sky", lamps_and_sky()),
        ("points and a sun", points()),
        ("suns", suns(glass(0.0))),
        ("beams", beams()),
        ("thin lens", blurred()),
        ("orthographic camera", parallel()),
        ("textured", textured()),
        ("brushed", brushed()),
        ("layers and absorbing glass", layers()),
    ]
}
