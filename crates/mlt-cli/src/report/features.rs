//! Features that a scene has or lacks, and the work that is therefore done or left out.

use mlt_core::transport::scene::{Lens, Needs};
use serde::Serialize;

/// A feature that a scene may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Feature {
    /// Its name.
    pub name: &'static str,
    /// Whether the scene has it.
    pub present: bool,
    /// The consequence: work that is done or left out.
    pub therefore: &'static str,
}

/// Name of each feature, in the order of [`Needs`], and the consequences of having it and of lacking it.
const FEATURES: [(&str, [&str; 2]); 12] = [
    (
        "mirrors and clear glass",
        [
            "chains perturb caustics, and images of lights are a part of path space",
            "no caustic perturbation, no parts of path space for images of lights",
        ],
    ),
    (
        "light that only chance meets",
        [
            "chains of it start from rays of its own, which photons and glimpses guide",
            "no rays look for what only chance meets",
        ],
    ),
    ("narrow gloss", ["chains keep the slope at which a narrow lobe mirrors", "chains turn all directions by angles"]),
    ("transparency", ["shadow rays ask the opacity of what they meet", "shadow rays end at the first surface"]),
    ("light from all around", ["rays that leave the scene bring light", "rays that leave the scene end there"]),
    (
        "lamps with a cone",
        ["what such a lamp emits depends on the direction", "surfaces emit alike into all directions"],
    ),
    ("coloured glass", ["light weakens on its way through solids", "no ray asks what it goes through"]),
    (
        "points, spots and suns without size",
        ["paths are connected to them, since no ray can meet them", "every light can be met by a ray"],
    ),
    (
        "suns with a size",
        [
            "rays that leave the scene may meet them, and their discs are cut into strata",
            "no ray looks for a sun's disc",
        ],
    ),
    ("textures", ["materials are looked up at every point", "materials are constants"]),
    ("normal maps", ["shading normals are bent by images", "shading normals are those of the meshes"]),
    ("depth of field", ["paths draw a point on the lens", "no number is drawn for the lens"]),
];

/// All features.
pub fn features(needs: Needs, lens: &Lens) -> Vec<Feature> {
    // A need that is not named here does not compile.
    let Needs {
        specular,
        met_by_chance,
        narrow,
        veils,
        environment,
        cones,
        absorbs,
        punctual,
        suns,
        textured,
        normal_maps,
    } = needs;
    let depth = matches!(lens, Lens::Thin { .. });
    let present = [
        specular,
        met_by_chance,
        narrow,
        veils,
        environment,
        cones,
        absorbs,
        punctual,
        suns,
        textured,
        normal_maps,
        depth,
    ];
    let features = FEATURES.into_iter().zip(present);
    features
        .map(|((name, [has, lacks]), present)| Feature { name, present, therefore: if present { has } else { lacks } })
        .collect()
}

/// The names of those that a scene has.
pub fn names(features: &[Feature]) -> String {
    let present: Vec<_> = features.iter().filter(|feature| feature.present).map(|feature| feature.name).collect();
    if present.is_empty() { "nothing but opaque surfaces".into() } else { present.join(", ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn features_that_are_there_are_named() {
        let pinhole = Lens::Pinhole { vertical_fov: 1.0 };
        assert_eq!(names(&features(Needs::default(), &pinhole)), "nothing but opaque surfaces");
        let lens = Lens::Thin { vertical_fov: 1.0, radius: 0.1, focus: 1.0 };
        let found = features(Needs { textured: true, ..Needs::default() }, &lens);
        assert_eq!(names(&found), "textures, depth of field");
        assert!(found.iter().all(|feature| !feature.therefore.is_empty()));
    }
}
