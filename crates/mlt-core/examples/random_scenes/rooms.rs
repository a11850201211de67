//! Random rooms.

use super::dice::Dice;
use super::shapes::{ball, cuboid, rectangle};
use super::surfaces::{any, wide};
use mlt_core::glam::{DAffine3, DQuat, DVec3, Vec3};
use mlt_core::transport::Rgb;
use mlt_core::transport::geometry::Mesh;
use mlt_core::transport::scene::{
    CameraPose, Environment, Lens, Material, Prototype, Punctual, PunctualLight, SceneDescription,
};

/// Least half side of a lamp among surfaces that are not wide: path tracing has to meet it by chance.
const LARGE: f64 = 0.3;

/// A room with its camera.
#[derive(Debug)]
pub(crate) struct Room {
    pub(crate) description: SceneDescription,
    pub(crate) pose: CameraPose,
    pub(crate) max_edges: Option<usize>,
}

impl Room {
    /// The room of this number: walls from −1 to 1, lamps, boxes, panes and balls, of any size in all.
    pub(crate) fn new(number: u64) -> Self {
        let mut builder = Builder { dice: Dice::of(number), description: SceneDescription::default(), sharp: false };
        builder.sharp = builder.dice.chance(0.5);
        builder.walls();
        (0..=builder.dice.up_to(2)).for_each(|_| builder.lamp());
        (0..builder.dice.up_to(3)).for_each(|_| builder.thing());
        if builder.dice.chance(0.1) {
            builder.copies();
        }
        if builder.dice.chance(0.15) {
            builder.surroundings();
        }
        if !builder.sharp && builder.dice.chance(0.2) {
            builder.punctual();
        }
        if builder.dice.chance(0.2) {
            builder.stray();
        }
        let pose = builder.camera();
        let scale = if builder.dice.chance(0.4) { 1.0 } else { builder.dice.magnitude(-4.0, 6.0) };
        let max_edges = builder.dice.chance(0.2).then(|| 1 + builder.dice.up_to(5));
        Self { description: builder.description, pose, max_edges }.scaled(scale)
    }

    /// The same room of another size, which looks the same.
    fn scaled(mut self, scale: f64) -> Self {
        let SceneDescription { meshes, prototypes, materials, punctual, .. } = &mut self.description;
        meshes.iter_mut().flat_map(|mesh| &mut mesh.positions).for_each(|position| *position *= scale);
        for place in prototypes.iter_mut().flat_map(|prototype| &mut prototype.places) {
            *place = DAffine3::from_scale(DVec3::splat(scale)) * *place;
        }
        materials.iter_mut().for_each(|material| material.absorption /= scale as f32);
        for PunctualLight { emission, kind, .. } in punctual {
            if let Punctual::Point { position } | Punctual::Spot { position, .. } = kind {
                *position *= scale;
                *emission *= (scale * scale) as f32;
            }
        }
        self.pose.position *= scale;
        match &mut self.pose.lens {
            Lens::Thin { radius, focus, .. } => (*radius, *focus) = (*radius * scale, *focus * scale),
            Lens::Orthographic { height } => *height *= scale,
            _ => {}
        }
        self
    }
}

struct Builder {
    dice: Dice,
    description: SceneDescription,
    /// Surfaces may be mirrors and glass.
    sharp: bool,
}

impl Builder {
    fn add(&mut self, mesh: Mesh, material: Material) {
        let name = format!("surface {}", self.description.materials.len());
        self.description.meshes.push(Mesh { material: self.description.materials.len() as u32, ..mesh });
        self.description.materials.push(Material { name, ..material });
    }

    fn material(&mut self) -> Material {
        if self.sharp { any(&mut self.dice) } else { wide(&mut self.dice) }
    }

    fn walls(&mut self) {
        let walls = [DVec3::Y, DVec3::NEG_Y, DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::NEG_Z];
        let closed = self.dice.chance(0.3);
        for normal in walls {
            let open = if normal == DVec3::NEG_Z { 1.0 } else { 0.1 };
            if closed || !self.dice.chance(open) {
                let material = if self.dice.chance(0.1) { self.material() } else { wide(&mut self.dice) };
                self.add(rectangle(-normal, normal, [1.0, 1.0]), material);
            }
        }
    }

    fn lamp(&mut self) {
        let sizes: &[f64] = if self.sharp { &[LARGE, 0.6, 0.95] } else { &[1e-3, 0.01, 0.1, LARGE, 0.6, 0.95] };
        let (size, shape) = (self.dice.pick(sizes), self.dice.pick(&[1.0, 1.0, 0.5]));
        let strength = self.dice.pick(&[1.0, 1.0, 100.0]) * (LARGE / size).powi(2).max(1.0);
        let emission = (self.dice.colour(0.0, 1.0) * strength as f32).max(Rgb::splat(1e-3));
        let under_ceiling = self.dice.chance(0.6);
        let (centre, normal) = match under_ceiling {
            true => (DVec3::new(self.dice.between(-0.5, 0.5), 0.96, self.dice.between(-0.5, 0.5)), DVec3::NEG_Y),
            false => (self.dice.point(0.9), self.dice.direction()),
        };
        let scatters = self.dice.chance(0.3);
        let surface = if scatters { wide(&mut self.dice) } else { Material::default() };
        let opacity = self.dice.pick(&[1.0, 1.0, 1.0, 0.5, 0.05]);
        let emits_both_sides = self.dice.chance(0.4);
        let mesh = match self.dice.chance(0.15) {
            true => cuboid(centre, DVec3::splat(0.5 * size)),
            false => rectangle(centre, normal, [size, shape * size]),
        };
        self.add(mesh, Material { emission, opacity, emits_both_sides, ..surface });
    }

    /// A box, a pane, a ball or a wall somewhere.
    fn thing(&mut self) {
        let (material, centre) = (self.material(), self.dice.point(0.7));
        let half = DVec3::from_array([(); 3].map(|()| self.dice.between(0.05, 0.6)));
        let mesh = match self.dice.up_to(4) {
            0 | 1 => cuboid(centre, half),
            2 => cuboid(centre, half.with_y(self.dice.pick(&[1e-4, 1e-3, 0.01, 0.05]))),
            3 => ball(centre, half.x, self.dice.chance(0.5)),
            _ => rectangle(centre, self.dice.direction(), [half.x, half.z]),
        };
        self.add(mesh, material);
    }

    fn copies(&mut self) {
        let material = self.description.materials.len() as u32;
        let half = DVec3::from_array([(); 3].map(|()| self.dice.between(0.05, 0.3)));
        let mesh = Mesh { material, ..cuboid(DVec3::ZERO, half) };
        let place = |dice: &mut Dice| {
            let turned = DQuat::from_vec4(dice.point(1.0).extend(dice.between(0.1, 1.0))).normalize();
            DAffine3::from_rotation_translation(turned, dice.point(0.7))
        };
        let places = (0..3).map(|_| place(&mut self.dice)).collect();
        let made = self.material();
        self.description.materials.push(made);
        self.description.prototypes.push(Prototype { meshes: vec![mesh], places });
    }

    fn surroundings(&mut self) {
        let pixels = (0..8).map(|_| self.dice.colour(0.0, 1.0)).collect();
        self.description.environment = Environment::image([4, 2], pixels).map(|(environment, _)| environment);
    }

    fn punctual(&mut self) {
        let (position, axis) = (self.dice.point(0.8), self.dice.direction().as_vec3());
        let kind = match self.dice.up_to(3) {
            0 => Punctual::Point { position },
            1 => Punctual::Spot { position, axis, cone: [0.3, 0.8] },
            2 => Punctual::Directional { along: axis, angle: 0.0 },
            _ => Punctual::Directional { along: axis, angle: 0.1 },
        };
        let emission = self.dice.colour(0.1, 1.0);
        self.description.punctual.push(PunctualLight { name: String::new(), emission, kind });
    }

    /// A triangle far away, of the first wall or the first lamp.
    fn stray(&mut self) {
        let far = self.dice.magnitude(1.0, 5.0);
        let corners = [[1.0, 0.0, 0.1], [1.0, 0.5, 0.0], [1.0, 0.0, 0.7], [1.0, 0.0, 0.7]];
        let material = self.dice.up_to(self.description.meshes.len() - 1) as u32;
        let mesh = Mesh::quad(corners.map(|corner| far * DVec3::from_array(corner)));
        self.description.meshes.push(Mesh { material, triangles: vec![[0, 1, 2]], ..mesh });
    }

    fn camera(&mut self) -> CameraPose {
        let inside = self.dice.chance(0.5);
        let position = match inside {
            true => self.dice.point(0.9),
            false => DVec3::new(self.dice.between(-1.0, 1.0), self.dice.between(-0.8, 0.8), 3.4),
        };
        let forward = (self.dice.point(0.5) - position).normalize();
        let vertical_fov = (if inside { self.dice.pick(&[38.0, 60.0, 100.0]) } else { 38.0f32 }).to_radians();
        let lens = match self.dice.up_to(9) {
            0 => Lens::Thin { vertical_fov, radius: 0.1, focus: 1.0 },
            1 => Lens::Orthographic { height: 1.5 },
            _ => Lens::Pinhole { vertical_fov },
        };
        let up = forward.any_orthonormal_vector().as_vec3();
        let forward: Vec3 = forward.as_vec3();
        CameraPose { name: String::new(), position, forward, up, lens, aspect_ratio: None }
    }
}
