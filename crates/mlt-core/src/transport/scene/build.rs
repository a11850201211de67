//! How a scene is made of its description.

use super::check::{check, drop_invisible, drop_unusable};
use super::copies::Shape;
use super::textures::Attributes;
use super::triangles::Triangles;
use super::{Lights, Material, Needs, Prototype, Scene, SceneDescription, UnusableScene};
use crate::transport::accel::Accel;
use crate::transport::geometry::{Space, Sphere, points};
use glam::Vec3;

/// Triangles, and the acceleration structure that was built for them.
#[derive(Debug)]
pub struct SceneGeometry {
    triangles: Vec<[Vec3; 3]>,
    accel: Accel,
}

impl Scene {
    /// Builds the acceleration structure and finds the lights.
    ///
    /// # Errors
    /// If there is no triangle or no light, or a mesh refers to what is not there.
    pub fn new(description: SceneDescription) -> Result<Self, UnusableScene> {
        Self::with_geometry(description, None)
    }

    /// The same of another scene's acceleration structure, if that was built for the same triangles.
    ///
    /// # Errors
    /// As for [`new`](Self::new).
    pub fn with_geometry(
        mut description: SceneDescription,
        geometry: Option<SceneGeometry>,
    ) -> Result<Self, UnusableScene> {
        check(&description)?;
        let dropped = description.all_meshes_mut().map(drop_unusable).sum();
        drop_invisible(&mut description);
        let needs = Needs::of(&description);
        let of_copies = description.prototypes.iter().flat_map(Prototype::corners);
        let space = Space::around(points(&description.meshes).chain(of_copies.clone()));
        let triangles = Triangles::new(&description.meshes, &description.materials, &space);
        if triangles.primitives.is_empty() && description.prototypes.is_empty() {
            return Err(UnusableScene::NoTriangle);
        }
        let corners = triangles.corners();
        let of_copies = of_copies.map(|corner| space.point(corner));
        let sphere = Sphere::around(corners.iter().flatten().copied().chain(of_copies));
        let overlaps = triangles.overlaps().map(|pair| pair.map(|mesh| description.surface_name(mesh))).collect();
        let background = !needs.environment || description.environment.as_ref().is_none_or(|light| light.visible);
        let lights = lights(&mut description, &needs, &corners, (&space, sphere))?;
        let (shapes, copies) = Shape::all(&description, &space, corners.len() as u32);
        let attributes =
            if needs.textured { Attributes::take(description.all_meshes_mut()) } else { Attributes::default() };
        let SceneDescription { materials, textures, .. } = without_meshes(description);
        Ok(Self {
            accel: structure(geometry, &corners).with_copies(copies),
            triangles,
            shapes,
            materials: materials_in(&space, materials, &needs),
            textures,
            attributes,
            lights,
            space,
            sphere,
            background,
            overlaps,
            dropped,
            needs,
        })
    }

    /// Keeps the triangles and their acceleration structure, for a scene that may have the same; `None` of one with copies.
    pub fn into_geometry(self) -> Option<SceneGeometry> {
        self.shapes.is_empty().then(|| SceneGeometry { triangles: self.triangles.corners(), accel: self.accel })
    }
}

/// All lights; the environment is taken out of the description.
fn lights(
    description: &mut SceneDescription,
    needs: &Needs,
    corners: &[[Vec3; 3]],
    (space, sphere): (&Space, Sphere),
) -> Result<Lights, UnusableScene> {
    let environment = description.environment.take().filter(|_| needs.environment);
    let SceneDescription { meshes, materials, textures, punctual, .. } = description;
    let lights = Lights::new(meshes, materials, textures, corners);
    if lights.lights.is_empty() && !needs.light_without_surface() {
        return Err(UnusableScene::NoLight);
    }
    let lights = lights.and_punctual(punctual, space, sphere);
    Ok(match environment {
        Some(environment) => lights.surrounded(environment, sphere),
        None => lights,
    })
}

/// Frees the memory of the meshes.
fn without_meshes(description: SceneDescription) -> SceneDescription {
    SceneDescription { meshes: Vec::new(), prototypes: Vec::new(), ..description }
}

/// Materials with lengths of the scene's own, and one for lights without a surface, if there are some.
fn materials_in(space: &Space, mut materials: Vec<Material>, needs: &Needs) -> Vec<Material> {
    materials.iter_mut().for_each(|material| material.absorption /= space.length(1.0));
    if needs.light_without_surface() {
        materials.push(Material::default());
    }
    materials
}

/// The structure over these triangles: the given one if it is that.
fn structure(geometry: Option<SceneGeometry>, corners: &[[Vec3; 3]]) -> Accel {
    match geometry {
        Some(SceneGeometry { triangles, accel }) if triangles == corners => accel,
        _ => Accel::new(corners),
    }
}
