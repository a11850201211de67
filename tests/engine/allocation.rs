//! A chain that is warm allocates nothing.

use glam::{Affine2, DVec3, Vec2, Vec3};
use mlt_core::engine::{Chain, Mixture, Purpose, Sink, Stratum, generator};
use mlt_core::primary::{PrimaryImportance, PrimaryMutation, PrimaryPath, PrimaryStratum, Tracer};
use mlt_core::transport::Rgb;
use mlt_core::transport::bsdf::{Bsdf, MetallicRoughness, Mirror};
use mlt_core::transport::geometry::Mesh;
use mlt_core::transport::lights::{LightStrata, Stratification};
use mlt_core::transport::methods::metropolis::{LightStratum, PathMutation};
use mlt_core::transport::methods::primary::{AllConnections, Multiplexed, Part, Techniques};
use mlt_core::transport::paths::{LightPath, Luminance};
use mlt_core::transport::scene::{
    Alpha, CameraPose, ChannelMap, Encoding, Filter, Lens, Map, Maps, Material, NormalMap, Pixels, Scene,
    SceneDescription, Texture, View, Wrap,
};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// The system's allocator, which counts the calls of each thread.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: every call goes to the system's allocator unchanged.
#[allow(unsafe_code, reason = "an allocator is unsafe to implement")]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: the caller's promises are those of this call.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: as above.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocations(work: impl FnOnce()) -> u64 {
    let before = ALLOCATIONS.get();
    work();
    ALLOCATIONS.get() - before
}

#[test]
fn what_is_allocated_and_what_grows_is_counted() {
    let mut list = Vec::new();
    assert_eq!(allocations(|| list.reserve_exact(3)), 1);
    list.extend([1, 2, 3]);
    assert_eq!(allocations(|| list.reserve_exact(1000)), 1);
    assert_eq!((list.as_slice(), allocations(|| drop(list.clone()))), (&[1, 2, 3][..], 1));
}

/// Forgets what it is given.
struct Nowhere;

impl<S> Sink<S> for Nowhere {
    fn deposit(&mut self, _: S, _: f64) {}
}

/// An image of 4 × 4 pixels.
fn texture(encoding: Encoding) -> Texture {
    let pixels = Pixels::new([4, 4], 3, (0..48).map(|i| i * 89 % 251).collect()).unwrap();
    Texture::new(pixels.into(), [Wrap::Repeat; 2], Filter::Bilinear, encoding)
}

/// A coat over a base, glass and metal, of all of which the shares vary.
fn varying() -> Material {
    let map = |texture| Map { texture, set: 0, transform: Affine2::IDENTITY };
    let channel = |channel| Some(ChannelMap { map: map(1), channel });
    let maps = Maps {
        base_color: Some(map(0)),
        metallic: channel(0),
        roughness: channel(1),
        transmission: channel(2),
        opacity: channel(0),
        normal: Some(NormalMap { map: map(1), scale: 0.2 }),
        ..Maps::default()
    };
    let factors = MetallicRoughness { transmission: 0.5, thin: false, ..MetallicRoughness::default() };
    Material::default().scattering(factors, maps, Alpha::Blend)
}

/// A floor of varying colour, gloss and normals, and a mirror under a light.
fn scene() -> SceneDescription {
    let quad = |material, corners: [[f64; 3]; 4]| Mesh {
        material,
        uv: [corners.map(|[x, _, z]| Vec2::new(x as f32, z as f32)).to_vec(), Vec::new()],
        ..Mesh::quad(corners.map(DVec3::from_array))
    };
    let material = |bsdf, emission| Material { bsdf, emission, ..Material::default() };
    SceneDescription {
        meshes: vec![
            quad(0, [[-1., 0., 1.], [1., 0., 1.], [1., 0., -1.], [-1., 0., -1.]]),
            quad(1, [[-1., 0., -1.], [1., 0., -1.], [1., 2., -1.], [-1., 2., -1.]]),
            quad(2, [[-0.3, 2., -0.3], [0.3, 2., -0.3], [0.3, 2., 0.3], [-0.3, 2., 0.3]]),
        ],
        materials: vec![
            varying(),
            material(Bsdf::Mirror(Mirror { f0: Rgb::splat(0.9) }), Rgb::ZERO),
            material(Bsdf::Black, Rgb::splat(4.0)),
        ],
        textures: vec![texture(Encoding::Srgb), texture(Encoding::Linear)],
        cameras: vec![CameraPose {
            name: String::new(),
            position: DVec3::new(0.1, 1.0, 4.0),
            forward: Vec3::NEG_Z,
            up: Vec3::Y,
            lens: Lens::Pinhole { vertical_fov: 0.7 },
            aspect_ratio: None,
        }],
        ..SceneDescription::default()
    }
}

#[test]
fn a_mutation_allocates_nothing() {
    let description = scene();
    let pose = description.cameras[0].clone();
    let scene = Scene::new(description).unwrap();
    let camera = scene.camera(&pose, [32, 32]);
    let view = View { scene: &scene, camera: &camera };
    let strata = LightStrata::new(scene.lights(), Stratification::Grid(2, 2));
    let strata = LightStratum::all(&strata, view, 6);
    let mixture = Mixture::new(PathMutation::all(view));
    let mut rng = generator(1, Purpose::Chain, 0, 0, 0);
    for stratum in &strata {
        let mut start = None::<LightPath>;
        while start.is_none() {
            stratum.sample(&mut rng, &mut |path, _| start = Some(path.clone()));
        }
        let mut chain = Chain::new(&mixture, &Luminance, stratum, start.unwrap()).unwrap();
        let mut steps = |n| (0..n).for_each(|_| chain.step(&mut Nowhere, 1.0, &mut rng));
        assert!(allocations(|| steps(1_000_000)) > 0, "the count works: a chain grows its states");
        assert_eq!(allocations(|| steps(20_000)), 0);
    }
}

#[test]
fn a_step_in_primary_sample_space_allocates_nothing() {
    let description = scene();
    let pose = description.cameras[0].clone();
    let scene = Scene::new(description).unwrap();
    let camera = scene.camera(&pose, [32, 32]);
    let strata = LightStrata::new(scene.lights(), Stratification::None);
    let view = View { scene: &scene, camera: &camera };
    let part = Part { view, strata: &strata, index: 0, max_edges: 6, importance: &Luminance };
    let techniques = Techniques::new(part.max_edges);
    steps_allocate_nothing(Multiplexed { part, techniques: &techniques });
    steps_allocate_nothing(AllConnections { part });
}

fn steps_allocate_nothing<T: Tracer<N>, const N: usize>(tracer: T) {
    let stratum = &PrimaryStratum { tracer, power: 1.0 };
    let mixture = Mixture::new(PrimaryMutation::both(0.3));
    let mut rng = generator(3, Purpose::Chain, 0, 0, 0);
    let mut start = None::<PrimaryPath<T::Output, N>>;
    while start.is_none() {
        stratum.sample(&mut rng, &mut |path, _| start = Some(path.clone()));
    }
    let mut chain = Chain::new(&mixture, &PrimaryImportance, stratum, start.unwrap()).unwrap();
    let mut steps = |n| (0..n).for_each(|_| chain.step(&mut Nowhere, 1.0, &mut rng));
    assert!(allocations(|| steps(1_000_000)) > 0, "the count works: a chain grows its states");
    assert_eq!(allocations(|| steps(20_000)), 0);
}

#[test]
fn an_independent_sample_allocates_nothing() {
    let description = scene();
    let pose = description.cameras[0].clone();
    let scene = Scene::new(description).unwrap();
    let camera = scene.camera(&pose, [32, 32]);
    let strata = LightStrata::new(scene.lights(), Stratification::None);
    let [stratum] = &LightStratum::all(&strata, View { scene: &scene, camera: &camera }, 6)[..] else { panic!() };
    let mut rng = generator(2, Purpose::Sample, 0, 0, 0);
    let mut samples = |n| (0..n).for_each(|_| stratum.sample(&mut rng, &mut |_, _| ()));
    assert!(allocations(|| samples(50_000)) > 0, "the count works: the first samples make room");
    assert_eq!(allocations(|| samples(50_000)), 0);
}
