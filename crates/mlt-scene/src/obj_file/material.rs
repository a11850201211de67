//! MTL's materials.

use super::gloss::roughness;
use super::maps::Statements;
use crate::{images::Images, range::Range};
use mlt_core::transport::Rgb;
use mlt_core::transport::bsdf::MetallicRoughness;
use mlt_core::transport::scene::{Alpha, Maps, Material};

/// Reflectance of the surface that stands in for a missing material.
const GREY: Rgb = Rgb::splat(0.5);

/// Reflectance at normal incidence of a dielectric with glTF's index of refraction, 1.5.
const F0: f32 = 0.04;

/// Substitute for a material that is not defined; under `coloured` vertices it is white.
pub(super) fn grey(coloured: bool) -> Material {
    let maps = Maps { vertex_colours: coloured, ..Maps::default() };
    let base = if coloured { Rgb::ONE } else { GREY };
    Material { name: "grey".to_owned(), ..Material::default() }.scattering(diffuse(base), maps, Alpha::Opaque)
}

/// Sources of a material's textures.
pub(super) struct Textures<'a> {
    pub statements: &'a Statements<'a>,
    pub images: &'a mut Images,
    /// A mesh of it has vertex colours.
    pub coloured: bool,
}

/// A material, which emits `Ke` as radiance from its front.
pub(super) fn material(source: &tobj::Material, textures: Textures, warnings: &mut Vec<String>) -> Material {
    let name = source.name.clone();
    let mut range = Range { material: &name, warnings };
    let statements = textures.statements;
    let glows = statements.has("map_ke").then_some(Rgb::ONE);
    let emission = rgb(source.emissive).or(glows).map_or(Rgb::ZERO, |c| range.colour("Ke", c, 1e12));
    let factors = layered(source, parameters(source, &textures, &mut range), &mut range);
    let opacity = if is_glass(source) { 1.0 } else { opacity(source, &mut range) };
    let unread = unread(source);
    if !unread.is_empty() {
        warnings.push(format!("material `{name}`: not supported and left out: {}", unread.join(", ")));
    }
    match opacity {
        0.0 => warnings.push(format!("material `{name}`: its opacity is 0, so it is invisible; `illum 7` makes glass")),
        o if o < 1.0 => {
            warnings.push(format!("material `{name}`: blended by its opacity of {o}; `illum 7` makes glass"))
        }
        _ => {}
    }
    let exponent = (factors.metallic < 1.0).then_some(source.shininess).flatten().map(|n| n as f32);
    let mirror = is_mirror(source);
    let maps = Maps { vertex_colours: textures.coloured, ..statements.maps(textures.images, exponent, mirror) };
    // The colour of an image that is lost says nothing.
    let emission = if statements.has("map_ke") && maps.emission.is_none() { Rgb::ZERO } else { emission };
    let factors = match maps.roughness {
        Some(_) if !statements.has("map_pr") => MetallicRoughness { roughness: 1.0, ..factors },
        _ => factors,
    };
    let alpha = if maps.opacity.is_some() { Alpha::Blend } else { Alpha::Opaque };
    let plain = Material { name, emission, opacity, ..Material::default() };
    plain.scattering(factors, maps, alpha)
}

/// Whether the illumination model is one of those with "glass on" or refraction.
fn is_glass(source: &tobj::Material) -> bool {
    matches!(source.illumination_model, Some(4 | 6 | 7 | 9))
}

/// Whether the illumination model reflects without any gloss, and does not let light pass.
fn is_mirror(source: &tobj::Material) -> bool {
    matches!(source.illumination_model, Some(3 | 5))
}

/// `d`, or else 1 − `Tr`.
fn opacity(source: &tobj::Material, range: &mut Range) -> f32 {
    match (source.dissolve, number(source, "Tr")) {
        (Some(d), _) => range.number("d", d as f32, [0.0, 1.0]),
        (None, Some(tr)) => 1.0 - range.number("Tr", tr, [0.0, 1.0]),
        _ => 1.0,
    }
}

/// The model that a material's parameters ask for, in this order: glass, the `Pr`/`Pm` extension, mirror, gloss, diffuse.
fn parameters(source: &tobj::Material, textures: &Textures, range: &mut Range) -> MetallicRoughness {
    let shown = source.illumination_model.unwrap_or(2);
    let (has, white) = (|key| textures.statements.has(key), Some(Rgb::ONE));
    if is_glass(source) {
        return glass(source, range);
    }
    let absent = match source.emissive {
        _ if has("map_kd") || textures.coloured => Rgb::ONE,
        Some(_) => Rgb::ZERO,
        None => GREY,
    };
    let base_color = range.colour("Kd", rgb(source.diffuse).unwrap_or(absent), 1.0);
    let (metallic, roughness) = (number(source, "Pm"), number(source, "Pr"));
    if metallic.is_some() || roughness.is_some() || has("map_pm") || has("map_pr") {
        let unset = f32::from(u8::from(has("map_pm")));
        return MetallicRoughness {
            base_color,
            metallic: range.number("Pm", metallic.unwrap_or(unset), [0.0, 1.0]),
            roughness: range.number("Pr", roughness.unwrap_or(1.0), [0.0, 1.0]),
            ..MetallicRoughness::default()
        };
    }
    let specular =
        range.colour("Ks", rgb(source.specular).or(white.filter(|_| has("map_ks"))).unwrap_or(Rgb::ZERO), 1.0);
    match source.shininess {
        _ if specular == Rgb::ZERO => diffuse(base_color),
        _ if is_mirror(source) => {
            MetallicRoughness { base_color: specular, roughness: 0.0, ..MetallicRoughness::default() }
        }
        Some(exponent) if shown >= 2 => glossy(base_color, specular, range.number("Ns", exponent as f32, [0.0, 1e6])),
        _ => diffuse(base_color),
    }
}

/// The same under the clear coat and the sheen of the `Pr`/`Pm` extension; sheen has the roughness that Blender gives it.
fn layered(source: &tobj::Material, base: MetallicRoughness, range: &mut Range) -> MetallicRoughness {
    let mut share = |key| range.number(key, number(source, key).unwrap_or(0.0), [0.0, 1.0]);
    MetallicRoughness {
        clearcoat: share("Pc"),
        clearcoat_roughness: share("Pcr"),
        sheen_color: Rgb::splat(share("Ps")),
        sheen_roughness: 0.5,
        ..base
    }
}

/// A diffuse surface without any reflection above it.
fn diffuse(base_color: Rgb) -> MetallicRoughness {
    MetallicRoughness { base_color, metallic: 0.0, specular: 0.0, ..MetallicRoughness::default() }
}

/// A solid dielectric, tinted by the transmission filter.
fn glass(source: &tobj::Material, range: &mut Range) -> MetallicRoughness {
    MetallicRoughness {
        base_color: range.colour("Tf", filter(source).unwrap_or(Rgb::ONE), 1.0),
        metallic: 0.0,
        roughness: range.number("Pr", number(source, "Pr").unwrap_or(0.0), [0.0, 1.0]),
        ior: range.number("Ni", source.optical_density.map_or(1.5, |n| n as f32), [1.0, 100.0]),
        transmission: 1.0,
        thin: false,
        ..MetallicRoughness::default()
    }
}

/// A diffuse base under a reflection that is `specular` at normal incidence.
fn glossy(base_color: Rgb, specular: Rgb, exponent: f32) -> MetallicRoughness {
    MetallicRoughness {
        base_color,
        metallic: 0.0,
        roughness: roughness(exponent),
        specular_color: specular / F0,
        ..MetallicRoughness::default()
    }
}

/// The transmission filter, as three numbers.
fn filter(source: &tobj::Material) -> Option<Rgb> {
    let mut words = source.unknown_param.get("Tf")?.split_whitespace().map(|w| w.parse().ok());
    Some(Rgb::new(words.next()??, words.next()??, words.next()??))
}

/// The first number of a statement that the parser does not know.
fn number(source: &tobj::Material, key: &str) -> Option<f32> {
    source.unknown_param.get(key)?.split_whitespace().next()?.parse().ok()
}

fn rgb(colour: Option<[f64; 3]>) -> Option<Rgb> {
    colour.map(|c| Rgb::from_array(c.map(|x| x as f32)))
}

/// Statements that change the image and are not read.
fn unread(source: &tobj::Material) -> Vec<String> {
    const UNREAD: [&str; 5] = ["disp", "refl", "decal", "aniso", "anisor"];
    let is_unread = |key: &&String| key.starts_with("map_") || UNREAD.contains(&key.as_str());
    let mut names: Vec<_> = source.unknown_param.keys().filter(is_unread).cloned().collect();
    names.sort();
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No textures.
    fn plain(images: &mut Images) -> Textures<'_> {
        Textures { statements: &NO_STATEMENTS, images, coloured: false }
    }

    static NO_STATEMENTS: Statements = Statements::NONE;

    fn parsed(mtl: &str) -> MetallicRoughness {
        let text = format!("newmtl m\n{mtl}");
        let (materials, _) = tobj::load_mtl_buf(&mut text.as_bytes()).unwrap();
        let mut warnings = Vec::new();
        let parameters = parameters(
            &materials[0],
            &plain(&mut Images::default()),
            &mut Range { material: "m", warnings: &mut warnings },
        );
        assert!(warnings.is_empty(), "{warnings:?}");
        parameters
    }

    #[test]
    fn plain_colours_are_diffuse() {
        let red = diffuse(Rgb::X);
        for mtl in ["Kd 1 0 0", "Kd 1 0 0\nKs 0 0 0\nNs 100", "Kd 1 0 0\nKs 1 1 1", "Kd 1 0 0\nKs 1 1 1\nNs 9\nillum 1"]
        {
            assert_eq!(parsed(mtl), red, "{mtl}");
        }
        assert_eq!(parsed("Ke 1 1 1").base_color, Rgb::ZERO);
        assert_eq!(parsed("illum 2").base_color, GREY);
    }

    #[test]
    fn gloss_takes_its_width_from_the_exponent() {
        let gloss = parsed("Kd 0.5 0 0\nKs 0.2 0.2 0.2\nNs 198");
        assert!((gloss.roughness - 0.1f32.sqrt()).abs() < 1e-6);
        let at_normal_incidence =
            ((gloss.ior - 1.0) / (gloss.ior + 1.0)).powi(2) * gloss.specular * gloss.specular_color;
        assert!(at_normal_incidence.distance(Rgb::splat(0.2)) < 1e-6);
        assert_eq!((gloss.metallic, gloss.transmission), (0.0, 0.0));
    }

    #[test]
    fn mirrors_and_glass_are_smooth() {
        for illum in [3, 5] {
            let mirror = parsed(&format!("Kd 1 0 0\nKs 0.9 0.8 0.7\nillum {illum}"));
            assert_eq!((mirror.metallic, mirror.roughness, mirror.base_color), (1.0, 0.0, Rgb::new(0.9, 0.8, 0.7)));
        }
        for mtl in ["illum 4", "illum 6", "illum 7", "illum 9", "d 0.1\nillum 7"] {
            let glass = parsed(&format!("Ni 1.7\nTf 0.5 1 1\n{mtl}"));
            assert_eq!((glass.transmission, glass.roughness, glass.ior, glass.thin), (1.0, 0.0, 1.7, false), "{mtl}");
            assert_eq!(glass.base_color, Rgb::new(0.5, 1.0, 1.0));
        }
    }

    #[test]
    fn opacity_is_d_or_what_tr_leaves() {
        for (mtl, opacity, count) in [
            ("Kd 1 0 0", 1.0, 0),
            ("d 0.25", 0.25, 1),
            ("Tr 0.25", 0.75, 1),
            ("d 1\nTr 1", 1.0, 0),
            ("Tr 0\nd 0", 0.0, 1),
            ("d 0.25\nillum 7", 1.0, 0),
            ("d 1.5", 1.0, 1),
            ("Tr -1", 1.0, 1),
            ("d nan", 0.0, 2),
        ] {
            let text = format!("newmtl m\n{mtl}");
            let (materials, _) = tobj::load_mtl_buf(&mut text.as_bytes()).unwrap();
            let mut warnings = Vec::new();
            assert_eq!(material(&materials[0], plain(&mut Images::default()), &mut warnings).opacity, opacity, "{mtl}");
            assert_eq!(warnings.len(), count, "{mtl}: {warnings:?}");
        }
    }

    #[test]
    fn the_extension_names_metalness_and_roughness() {
        let metal = parsed("Kd 1 0 0\nPr 0.25\nPm 0.75");
        assert_eq!((metal.base_color, metal.metallic, metal.roughness), (Rgb::X, 0.75, 0.25));
    }
}
