//! Embree, the yardstick of ray tracing, loaded while the program runs: nothing here needs it to build.
//!
//! Versions 3 and 4 hand over the same structures in a different order of arguments. The library is the one that
//! `MLT_EMBREE` names, else the newest that the system has.
#![allow(unsafe_code, reason = "calls of a C library")]

use crate::tracer::Tracer;
use glam::Vec3;
use libloading::{Library, Symbol};
use mlt_core::transport::geometry::Ray;
use std::ffi::{CStr, c_int, c_void};
use std::ptr::null_mut;

type Object = *mut c_void;
type Make = unsafe extern "C" fn(Object) -> Object;
type Act = unsafe extern "C" fn(Object);
type Set = unsafe extern "C" fn(Object, c_int);
/// Scene, context and ray in version 3; scene, ray and arguments in version 4.
type Trace = unsafe extern "C" fn(Object, Object, Object);

/// `RTCRayHit`, with room behind it for what newer versions add.
#[repr(C, align(16))]
struct RayHit {
    origin: [f32; 3],
    near: f32,
    direction: [f32; 3],
    time: f32,
    far: f32,
    mask: u32,
    id: u32,
    flags: u32,
    normal: [f32; 3],
    weights: [f32; 2],
    /// Primitive, geometry, instances.
    ids: [u32; 7],
}

const _: () = assert!(size_of::<RayHit>() == 96);

impl RayHit {
    #[inline(always)]
    fn new(ray: &Ray) -> Self {
        Self {
            origin: ray.origin.to_array(),
            near: 0.0,
            direction: ray.direction.to_array(),
            time: 0.0,
            far: ray.t_max,
            mask: u32::MAX,
            id: 0,
            flags: 0,
            normal: [0.0; 3],
            weights: [0.0; 2],
            ids: [u32::MAX; 7],
        }
    }
}

/// `RTCIntersectContext` of version 3.
#[repr(C)]
struct Context {
    flags: c_int,
    filter: Object,
    instances: [u32; 2],
}

/// The shared library and a device that uses one thread; both stay until the program ends, for threads of the library may
/// outlive the device.
pub struct Embree {
    device: Object,
    version: isize,
    library: Library,
}

impl Embree {
    /// Loads the library; `None`, and one sentence on standard error, if there is none.
    pub fn load() -> Option<&'static Self> {
        let named = std::env::var_os("MLT_EMBREE");
        let names = named.map_or_else(|| vec!["libembree4.so.4".into(), "libembree3.so.3".into()], |name| vec![name]);
        // SAFETY: what the library runs as it is loaded is Embree's own set-up, which asks nothing of its host.
        let library = names.iter().find_map(|name| unsafe { Library::new(name).ok() });
        let embree = library.and_then(|library| Self::new(library).ok());
        if embree.is_none() {
            eprintln!(
                "EMBREE SKIPPED: {names:?} cannot be loaded, so there is nothing to compare with; on Debian, `apt-get install \
                 libembree-dev`, or name the library in MLT_EMBREE."
            );
        }
        embree.map(|embree| &*Box::leak(Box::new(embree)))
    }

    fn new(library: Library) -> Result<Self, libloading::Error> {
        // SAFETY: the types are those of rtcore_device.h in versions 3 and 4; 0 is RTC_DEVICE_PROPERTY_VERSION; the device
        // is released in `drop`.
        unsafe {
            let make: Symbol<unsafe extern "C" fn(*const i8) -> Object> = library.get(b"rtcNewDevice")?;
            let property: Symbol<unsafe extern "C" fn(Object, c_int) -> isize> =
                library.get(b"rtcGetDeviceProperty")?;
            let device = make(c"threads=1".as_ptr().cast());
            let version = property(device, 0);
            Ok(Self { device, version, library })
        }
    }

    /// Such as "Embree 4.4.0".
    pub fn name(&self) -> String {
        format!("Embree {}.{}.{}", self.version / 10_000, self.version / 100 % 100, self.version % 100)
    }

    /// A function by its name.
    ///
    /// # Safety
    /// `F` must be its type.
    unsafe fn function<F: Copy>(&self, name: &CStr) -> F {
        // SAFETY: the caller's promise. The copy is used only while `self` keeps the library loaded.
        *unsafe { self.library.get::<F>(name.to_bytes_with_nul()) }.expect("a function of Embree's interface")
    }
}

/// A scene of triangles, built with Embree's default quality.
pub struct EmbreeScene {
    scene: Object,
    intersect: Trace,
    occluded: Trace,
    embree: &'static Embree,
}

impl EmbreeScene {
    /// Builds over `triangles`; `robust` asks for tests that are accurate at edges (`RTC_SCENE_FLAG_ROBUST`).
    pub fn new(embree: &'static Embree, triangles: &[[Vec3; 3]], robust: bool) -> Self {
        // SAFETY: the types are those of rtcore_scene.h in versions 3 and 4; 4 is RTC_SCENE_FLAG_ROBUST there. The scene
        // keeps the geometry alive and is released in `drop`.
        unsafe {
            let scene = embree.function::<Make>(c"rtcNewScene")(embree.device);
            embree.function::<Set>(c"rtcSetSceneFlags")(scene, if robust { 4 } else { 0 });
            let geometry = geometry(embree, triangles);
            let attach: unsafe extern "C" fn(Object, Object) -> u32 = embree.function(c"rtcAttachGeometry");
            attach(scene, geometry);
            embree.function::<Act>(c"rtcReleaseGeometry")(geometry);
            embree.function::<Act>(c"rtcCommitScene")(scene);
            let (intersect, occluded) = (embree.function(c"rtcIntersect1"), embree.function(c"rtcOccluded1"));
            Self { scene, intersect, occluded, embree }
        }
    }

    #[inline(always)]
    fn trace(&self, function: Trace, ray: &Ray) -> RayHit {
        let mut hit = RayHit::new(ray);
        let ray: Object = (&raw mut hit).cast();
        // SAFETY: the scene is committed; `hit` and `context` have the layouts of rtcore_ray.h and rtcore_common.h (an
        // RTCRay is the first part of an RTCRayHit) and outlive the call; version 4 takes a null pointer for no arguments.
        unsafe {
            if self.embree.version < 40_000 {
                let mut context = Context { flags: 0, filter: null_mut(), instances: [u32::MAX; 2] };
                function(self.scene, (&raw mut context).cast(), ray);
            } else {
                function(self.scene, ray, null_mut());
            }
        }
        hit
    }
}

/// A committed mesh of triangles that share no vertices.
///
/// # Safety
/// The caller releases it.
unsafe fn geometry(embree: &Embree, triangles: &[[Vec3; 3]]) -> Object {
    let [triangle_mesh, index_buffer, vertex_buffer] = [0, 0, 1];
    let indices: Vec<u32> = (0..3 * triangles.len() as u32).collect();
    // SAFETY: the types and the constants are those of rtcore_geometry.h and rtcore_buffer.h in versions 3 and 4. Embree
    // allocates each buffer for the items that it is asked for, and exactly those are written: three u32 an index triple,
    // three f32 a vertex, which is what an array of `Vec3` holds.
    unsafe {
        let make: unsafe extern "C" fn(Object, c_int) -> Object = embree.function(c"rtcNewGeometry");
        let buffer: unsafe extern "C" fn(Object, c_int, u32, c_int, usize, usize) -> Object =
            embree.function(c"rtcSetNewGeometryBuffer");
        let geometry = make(embree.device, triangle_mesh);
        let vertices = buffer(geometry, vertex_buffer, 0, 0x9003, 12, 3 * triangles.len());
        vertices.cast::<[Vec3; 3]>().copy_from_nonoverlapping(triangles.as_ptr(), triangles.len());
        let triples = buffer(geometry, index_buffer, 0, 0x5003, 12, triangles.len());
        triples.cast::<u32>().copy_from_nonoverlapping(indices.as_ptr(), indices.len());
        embree.function::<Act>(c"rtcCommitGeometry")(geometry);
        geometry
    }
}

impl Tracer for EmbreeScene {
    #[inline(always)]
    fn nearest(&self, ray: &Ray) -> Option<f32> {
        let hit = self.trace(self.intersect, ray);
        (hit.ids[1] != u32::MAX).then_some(hit.far)
    }

    #[inline(always)]
    fn occluded(&self, ray: &Ray) -> bool {
        self.trace(self.occluded, ray).far == f32::NEG_INFINITY
    }
}

impl Drop for EmbreeScene {
    fn drop(&mut self) {
        // SAFETY: the type is that of rtcore_scene.h; the scene was made in `new`.
        unsafe { self.embree.function::<Act>(c"rtcReleaseScene")(self.scene) }
    }
}
