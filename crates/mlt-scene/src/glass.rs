//! Whether glass is a thin wall or the surface of a solid.
//!
//! glTF takes a transmissive surface for a thin wall unless KHR_materials_volume says otherwise, and few files say so: Blender's author sees
//! solid glass and exports a wall. A wall needs no inside; a closed mesh has one. So by default glass is solid where its mesh is closed.

use glam::DVec3;
use mlt_core::transport::geometry::Mesh;
use mlt_core::transport::scene::{Material, SceneDescription};
use std::collections::HashMap;

/// How to take surfaces that transmit light, where a file does not say that they bound a volume.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Glass {
    /// Solids where their meshes are closed, else thin walls.
    #[default]
    Auto,
    /// Thin walls, as glTF says.
    Thin,
    /// Solids.
    Solid,
}

/// Makes thin walls solid where `glass` says so; tells of those that it chose by itself.
pub(crate) fn settle(scene: &mut SceneDescription, glass: Glass, warnings: &mut Vec<String>) {
    if glass == Glass::Thin {
        return;
    }
    let mut solids: HashMap<u32, Option<u32>> = HashMap::new();
    let SceneDescription { meshes, prototypes, materials, .. } = scene;
    for mesh in meshes.iter_mut().chain(prototypes.iter_mut().flat_map(|prototype| &mut prototype.meshes)) {
        let thin = mesh.material;
        let passes_light = materials[thin as usize].transmits();
        if !passes_light || (glass == Glass::Auto && !is_closed(mesh)) {
            continue;
        }
        let known = *solids.entry(thin).or_insert_with(|| {
            let solid = materials[thin as usize].solid()?;
            materials.push(solid);
            Some(materials.len() as u32 - 1)
        });
        mesh.material = known.unwrap_or(thin);
    }
    if glass == Glass::Auto {
        warnings.extend(notes(scene, &solids));
    }
}

/// One sentence for each material that became solid on some mesh.
fn notes(scene: &SceneDescription, solids: &HashMap<u32, Option<u32>>) -> Vec<String> {
    let is_used = |solid: u32| scene.all_meshes().any(|mesh| mesh.material == solid);
    let mut used: Vec<_> = solids.values().filter_map(|&solid| solid.filter(|&solid| is_used(solid))).collect();
    used.sort_unstable();
    let name = |solid: u32| -> &Material { &scene.materials[solid as usize] };
    let note = |solid| {
        let name = &name(solid).name;
        format!("material `{name}`: solid glass where its meshes are closed; `--glass thin` makes thin walls of them")
    };
    used.into_iter().map(note).collect()
}

/// Whether the mesh bounds a solid: its triangles run through each edge as often in one direction as in the other.
fn is_closed(mesh: &Mesh) -> bool {
    // Adding zero makes −0 a +0.
    let place = |i: u32| (mesh.positions[i as usize] + DVec3::ZERO).to_array().map(f64::to_bits);
    let mut balance: HashMap<[[u64; 3]; 2], i32> = HashMap::new();
    for &[a, b, c] in &mesh.triangles {
        for [from, to] in [[a, b], [b, c], [c, a]].map(|edge| edge.map(place)) {
            match from.cmp(&to) {
                std::cmp::Ordering::Less => *balance.entry([from, to]).or_default() += 1,
                std::cmp::Ordering::Greater => *balance.entry([to, from]).or_default() -= 1,
                std::cmp::Ordering::Equal => {}
            }
        }
    }
    !mesh.triangles.is_empty() && balance.values().all(|&passes| passes == 0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Affine2;
    use mlt_core::transport::bsdf::{Bsdf, MetallicRoughness};
    use mlt_core::transport::scene::{Alpha, ChannelMap, Map, Maps};

    /// A tetrahedron; its last triangle turned round or left out.
    fn tetrahedron(last: Option<[u32; 3]>) -> Mesh {
        let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2]].into_iter().chain(last).collect();
        Mesh { positions, triangles, ..Mesh::default() }
    }

    fn settled(mesh: Mesh, roughness: f32, glass: Glass) -> (Bsdf, usize) {
        let wall = MetallicRoughness { metallic: 0.0, transmission: 1.0, roughness, ..MetallicRoughness::default() };
        settled_of(mesh, Material { bsdf: wall.bsdf(), ..Material::default() }, glass)
    }

    fn settled_of(mesh: Mesh, material: Material, glass: Glass) -> (Bsdf, usize) {
        let mut scene =
            SceneDescription { meshes: vec![mesh], materials: vec![material], ..SceneDescription::default() };
        let mut warnings = Vec::new();
        settle(&mut scene, glass, &mut warnings);
        (scene.materials[scene.meshes[0].material as usize].bsdf, warnings.len())
    }

    #[test]
    fn closed_meshes_are_solid() {
        let closed = || tetrahedron(Some([1, 2, 3]));
        assert!(is_closed(&closed()));
        for open in [tetrahedron(None), tetrahedron(Some([1, 3, 2])), Mesh::default()] {
            assert!(!is_closed(&open));
        }
        assert!(matches!(settled(closed(), 0.0, Glass::Auto), (Bsdf::Dielectric(_), 1)));
        assert!(matches!(settled(closed(), 0.5, Glass::Auto), (Bsdf::RoughDielectric(_), 1)));
        assert!(matches!(settled(tetrahedron(None), 0.0, Glass::Auto), (Bsdf::Thin(_), 0)));
        assert!(matches!(settled(closed(), 0.0, Glass::Thin), (Bsdf::Thin(_), 0)));
        assert!(matches!(settled(tetrahedron(None), 0.0, Glass::Solid), (Bsdf::Dielectric(_), 0)));
    }

    /// Glass that a texture makes of metal is glass; metal is not.
    #[test]
    fn closed_meshes_are_solid_where_a_texture_makes_glass_of_them() {
        let map = ChannelMap { map: Map { texture: 0, set: 0, transform: Affine2::IDENTITY }, channel: 2 };
        let told = |metallic| {
            let factors = MetallicRoughness { transmission: 1.0, ..MetallicRoughness::default() };
            let material = Material::default().scattering(factors, Maps { metallic, ..Maps::default() }, Alpha::Opaque);
            settled_of(tetrahedron(Some([1, 2, 3])), material, Glass::Auto).1
        };
        assert_eq!([told(Some(map)), told(None)], [1, 0]);
    }
}
