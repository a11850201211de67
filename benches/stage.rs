//! Scenes for rays: triangles, an eye and a lamp.

use glam::Vec3;
use mlt_core::transport::scene::CameraPose;
use std::f32::consts::{PI, TAU};

/// Triangles, and where rays come from and go to.
pub struct Stage {
    /// For tables.
    pub name: &'static str,
    /// The geometry that rays hit.
    pub triangles: Vec<[Vec3; 3]>,
    /// The camera.
    pub eye: Eye,
    /// Where shadow rays end.
    pub lamp: Vec<[Vec3; 3]>,
}

/// A pinhole that takes in a square.
#[derive(Clone, Copy)]
pub struct Eye {
    /// Where it is.
    pub position: Vec3,
    /// Unit vector into the scene.
    pub forward: Vec3,
    /// Half of the image's side on the plane at distance 1, to the right.
    pub right: Vec3,
    /// The same downwards.
    pub down: Vec3,
}

impl Eye {
    fn new(position: Vec3, forward: Vec3, up: Vec3, half: f32) -> Self {
        let right = forward.cross(up).normalize();
        Self { position, forward, right: half * right, down: half * forward.cross(right) }
    }
}

impl From<&CameraPose> for Eye {
    fn from(pose: &CameraPose) -> Self {
        Self::new(pose.position.as_vec3(), pose.forward, pose.up, (0.5 * pose.lens.vertical_fov().unwrap_or(0.7)).tan())
    }
}

impl Stage {
    /// From a few dozen triangles to a million.
    pub fn all() -> [fn() -> Self; 4] {
        [|| Self::builtin("cornell"), || Self::builtin("suzanne"), Self::interior, Self::million]
    }

    /// A built-in scene.
    fn builtin(name: &'static str) -> Self {
        let description = mlt_scene::open(name).expect("a built-in scene").description;
        let (mut triangles, mut lamp) = (Vec::new(), Vec::new());
        for mesh in &description.meshes {
            let corners = |t: &[u32; 3]| t.map(|i| mesh.positions[i as usize].as_vec3());
            triangles.extend(mesh.triangles.iter().map(corners));
            if description.materials[mesh.material as usize].emission.max_element() > 0.0 {
                lamp.extend(mesh.triangles.iter().map(corners));
            }
        }
        Self { name, triangles, eye: (&description.cameras[0]).into(), lamp }
    }

    /// The room with shelves of small blobs: a mixture of huge and tiny triangles, 57,636 in all.
    fn interior() -> Self {
        let mut triangles = room();
        for k in 0..16 {
            let (x, y, z) = (k % 4, k / 4 % 2, k / 8);
            let centre = Vec3::new(0.45 * x as f32 - 0.7, 0.5 * y as f32 + 0.2, 0.8 * z as f32 - 0.6);
            triangles.extend(blob(30, centre, 0.15));
        }
        Self::room("interior", triangles)
    }

    /// One blob of a million triangles in the room.
    pub fn million() -> Self {
        Self::room("million", [room(), blob(500, Vec3::new(0.0, 0.2, -0.1), 0.5)].concat())
    }

    fn room(name: &'static str, triangles: Vec<[Vec3; 3]>) -> Self {
        let eye = Eye::new(Vec3::new(0.0, 0.0, 0.95), Vec3::NEG_Z, Vec3::Y, 0.7);
        let at = |x: f32, z: f32| Vec3::new(x, 0.95, z);
        let [a, b, c, d] = [at(-0.1, -0.1), at(0.1, -0.1), at(0.1, 0.1), at(-0.1, 0.1)];
        Self { name, triangles, eye, lamp: vec![[a, b, c], [a, c, d]] }
    }
}

/// A smooth closed surface of 4n² triangles about `centre`, its radius a few waves; seen whole from the centre.
pub fn blob(n: usize, centre: Vec3, radius: f32) -> Vec<[Vec3; 3]> {
    let point = |i: usize, j: usize| {
        let (theta, phi) = (PI * i as f32 / n as f32, TAU * (j % (2 * n)) as f32 / (2 * n) as f32);
        // At a pole all are one point, to the bit: else the surface would have a hole there.
        let ring = if i.is_multiple_of(n) { 0.0 } else { theta.sin() };
        let direction = Vec3::new(ring * phi.cos(), theta.cos(), ring * phi.sin());
        centre + radius * (1.0 + 0.2 * (5.0 * theta).sin() * (3.0 * phi).cos()) * direction
    };
    let quad = |(i, j): (usize, usize)| {
        let (a, b, c, d) = (point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1));
        [[a, b, c], [a, c, d]]
    };
    (0..n).flat_map(|i| (0..2 * n).map(move |j| (i, j))).flat_map(quad).collect()
}

/// The twelve triangles of a box turned about the vertical.
pub fn cuboid(centre: Vec3, half: Vec3, angle: f32) -> Vec<[Vec3; 3]> {
    let turn = glam::Mat3::from_rotation_y(angle);
    let corner = |signs: Vec3| centre + turn * (half * signs);
    (0..6)
        .flat_map(|face| {
            let (axis, side) = (face / 2, if face % 2 == 0 { 1.0 } else { -1.0 });
            let at = |u: f32, v: f32| {
                let mut signs = Vec3::splat(side);
                (signs[(axis + 1) % 3], signs[(axis + 2) % 3]) = (u, v);
                corner(signs)
            };
            let [a, b, c, d] = [at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)];
            [[a, b, c], [a, c, d]]
        })
        .collect()
}

/// A room with two blocks, 36 triangles.
fn room() -> Vec<[Vec3; 3]> {
    let walls = cuboid(Vec3::ZERO, Vec3::ONE, 0.0);
    let tall = cuboid(Vec3::new(-0.35, -0.4, -0.3), Vec3::new(0.3, 0.6, 0.3), 0.3);
    let low = cuboid(Vec3::new(0.35, -0.7, 0.3), Vec3::splat(0.3), -0.3);
    [walls, tall, low].concat()
}
