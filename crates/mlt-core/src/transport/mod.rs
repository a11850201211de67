//! The renderer: scenes of triangles, bidirectional path tracing, path-space mutations.

pub mod accel;
pub mod adapt;
pub mod auto;
pub mod bdpt;
mod blur;
pub mod bsdf;
pub mod camera;
pub mod classes;
mod connect;
pub mod description;
mod edge;
mod hilbert;
pub mod importance;
pub mod independent;
pub mod kind;
pub mod light;
pub mod light_tree;
pub mod lights;
pub mod low_discrepancy;
pub mod material;
pub mod math;
pub mod mesh;
mod mis;
pub mod mutate;
pub mod next_event;
pub mod path;
pub mod primary;
mod primitive;
pub mod pt;
pub mod ray;
pub mod region;
pub mod render;
pub mod scene;
mod space;
pub mod strata;
pub mod stratum;
mod subpath;
mod surface;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
mod ties;
pub mod vertex;

/// Linear Rec. 709 colour: radiance in W·sr⁻¹·m⁻², or a dimensionless reflectance.
pub type Rgb = glam::Vec3;

/// Luminance of a linear Rec. 709 colour (ITU-R BT.709).
#[inline]
pub fn luminance(c: Rgb) -> f32 {
    c.dot(Rgb::new(0.2126, 0.7152, 0.0722))
}
