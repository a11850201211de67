//! The textures of MTL's materials, as the renderer reads them.

use super::gloss;
use super::texture::{PREFIX, READ, Statement};
use crate::{SceneError, images::Images, source::Source};
use mlt_core::transport::scene::{ChannelMap, Encoding, Map, Maps, NormalMap, Pixels};
use std::{borrow::Cow, collections::BTreeMap};

/// Slope of a bump map whose height changes by 1 between two pixels, for `-bm 1`: MTL names no unit.
const BUMP: f32 = 4.0;

/// A material's texture statements.
pub(super) struct Statements<'a> {
    folder: &'a str,
    statements: BTreeMap<&'static str, Statement>,
}

impl<'a> Statements<'a> {
    /// Of a material without textures.
    #[cfg(test)]
    pub(super) const NONE: Self = Self { folder: "", statements: BTreeMap::new() };

    /// Of a material whose library lies in `folder`.
    pub(super) fn of(material: &tobj::Material, folder: &'a str) -> Self {
        let find = |key: &'static str| {
            let rest = material.unknown_param.get(&format!("{PREFIX}{key}"))?;
            Some((key, Statement::parse(rest)?))
        };
        Self { folder, statements: READ.into_iter().filter_map(find).collect() }
    }

    /// Whether there is such a statement.
    pub(super) fn has(&self, key: &str) -> bool {
        self.statements.contains_key(key)
    }

    /// Adds the content of each file, by name, or why there is none.
    pub(super) fn read(&self, source: &Source, contents: &mut BTreeMap<String, Result<Cow<[u8]>, String>>) {
        for statement in self.statements.values() {
            let content = || statement.content(source, self.folder).map(Cow::Owned).map_err(|error| error.to_string());
            contents.entry(self.name(statement)).or_insert_with(content);
        }
    }

    fn name(&self, statement: &Statement) -> String {
        format!("`{}{}`", self.folder, statement.file)
    }

    /// The maps; `exponent`: of gloss, which `map_Ns` is a factor on; `mirror`: `map_Ks` is the colour of all that is reflected.
    pub(super) fn maps(&self, images: &mut Images, exponent: Option<f32>, mirror: bool) -> Maps {
        let colour = |key: &str, images: &mut Images| {
            let statement = self.statements.get(key)?;
            self.map(statement, &self.name(statement), Encoding::Srgb, images)
        };
        let number = |key: &str, images: &mut Images| {
            let statement = self.statements.get(key)?;
            let name = self.name(statement);
            let channel = statement.channel.unwrap_or(default_channel(key, images.pixels(&name)?));
            Some(ChannelMap { map: self.map(statement, &name, Encoding::Linear, images)?, channel })
        };
        let specular_color = colour("map_ks", images);
        Maps {
            base_color: if mirror { specular_color } else { colour("map_kd", images) },
            metallic: number("map_pm", images),
            roughness: number("map_pr", images).or_else(|| self.roughness(images, exponent?)),
            emission: colour("map_ke", images),
            opacity: number("map_d", images),
            specular_color: if mirror { None } else { specular_color },
            normal: self.normal(images),
            ..Maps::default()
        }
    }

    fn map(&self, statement: &Statement, name: &str, encoding: Encoding, images: &mut Images) -> Option<Map> {
        let texture = images.texture(name, statement.sampler, encoding)?;
        Some(Map { texture, set: 0, transform: statement.transform })
    }

    /// Roughness of `map_Ns`.
    fn roughness(&self, images: &mut Images, exponent: f32) -> Option<ChannelMap> {
        let statement = self.statements.get("map_ns")?;
        let channel = usize::from(statement.channel.unwrap_or(0));
        let kind = format!("roughness by {exponent} in channel {channel}");
        let roughness = |rgba: [u8; 4]| {
            let share = f32::from(rgba[channel]) / 255.0;
            (255.0 * gloss::roughness(exponent * share)).round() as u8
        };
        let name = images.derived(&self.name(statement), &kind, |pixels| {
            Pixels::new(pixels.size().into(), 1, pixels.iter().map(roughness).collect())
        })?;
        Some(ChannelMap { map: self.map(statement, &name, Encoding::Linear, images)?, channel: 0 })
    }

    /// The normals of `norm`, of a bump map that holds normals, as Blender writes them, or of its heights.
    fn normal(&self, images: &mut Images) -> Option<NormalMap> {
        if let Some(statement) = self.statements.get("norm") {
            let map = self.map(statement, &self.name(statement), Encoding::Linear, images)?;
            return Some(NormalMap { map, scale: 1.0 });
        }
        let statement = self.statements.get("map_bump").or_else(|| self.statements.get("bump"))?;
        let name = self.name(statement);
        if holds_normals(images.pixels(&name)?) {
            let map = self.map(statement, &name, Encoding::Linear, images)?;
            return Some(NormalMap { map, scale: statement.bump });
        }
        let name = images.derived(&name, &format!("normals by {}", statement.bump), |p| normals(p, statement.bump))?;
        Some(NormalMap { map: self.map(statement, &name, Encoding::Linear, images)?, scale: 1.0 })
    }
}

/// The channel that holds a number: of opacity alpha, if there is one, else the first.
fn default_channel(key: &str, pixels: &Pixels) -> u8 {
    if key == "map_d" && matches!(pixels.channels(), 2 | 4) { 3 } else { 0 }
}

/// Whether an image is one of normals: on average nearly (½, ½, 1).
fn holds_normals(pixels: &Pixels) -> bool {
    let count = f64::from(pixels.size().x) * f64::from(pixels.size().y);
    let mut sums = [0u64; 3];
    pixels.iter().for_each(|rgba| (0..3).for_each(|k| sums[k] += u64::from(rgba[k])));
    let [x, y, z] = sums.map(|sum| sum as f64 / (255.0 * count));
    pixels.channels() >= 3 && (x - 0.5).abs() < 0.1 && (y - 0.5).abs() < 0.1 && z > 0.7
}

/// Normals of heights, by central differences.
fn normals(heights: &Pixels, scale: f32) -> Option<Pixels> {
    let size = heights.size();
    let height = |x: u32, y: u32| f32::from(heights.at(glam::UVec2::new(x % size.x, y % size.y))[0]) / 255.0;
    let mut bytes = Vec::with_capacity(3 * size.x as usize * size.y as usize);
    for (y, x) in (0..size.y).flat_map(|y| (0..size.x).map(move |x| (y, x))) {
        let along = 0.5 * (height(x + 1, y) - height(x + size.x - 1, y));
        let up = 0.5 * (height(x, y + size.y - 1) - height(x, y + 1));
        let normal = glam::Vec3::new(-BUMP * scale * along, -BUMP * scale * up, 1.0).normalize();
        bytes.extend((127.5 * (normal + 1.0)).round().to_array().map(|c| c as u8));
    }
    Pixels::new(size.into(), 3, bytes)
}

/// The images of the materials in use.
pub(super) fn decode<'a>(
    source: &Source,
    materials: impl Iterator<Item = Statements<'a>>,
    warnings: &mut Vec<String>,
) -> Result<Images, SceneError> {
    let mut contents = BTreeMap::new();
    materials.for_each(|statements| statements.read(source, &mut contents));
    Images::decode(source, contents, warnings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slope_of_heights_leans_against_it() {
        // Rises along x, and towards the top.
        let heights = Pixels::new([3, 3], 1, vec![100, 150, 200, 50, 100, 150, 0, 50, 100]).unwrap();
        let [x, y, z, _] = normals(&heights, 1.0).unwrap().at([1, 1].into());
        assert!(x < 100 && y < 100 && z > 128, "{x} {y} {z}");
        assert_eq!((x, y), (y, x));
        let flat = normals(&Pixels::new([2, 2], 1, vec![9; 4]).unwrap(), 1.0).unwrap();
        assert_eq!(flat.at([0, 0].into()), [128, 128, 255, 255]);
        assert!(holds_normals(&flat) && !holds_normals(&heights));
    }
}
