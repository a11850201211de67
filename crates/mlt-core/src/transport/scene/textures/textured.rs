//! Materials whose parameters vary over a surface.

use super::coordinates::Coordinates;
use super::texture::Texture;
use crate::transport::bsdf::{Anisotropy, Bsdf, Directions, MetallicRoughness, Varying};
use crate::transport::colour::Rgb;
use glam::{Affine2, Vec2, Vec3A, Vec4, Vec4Swizzles};

/// Where a parameter finds its texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Map {
    /// Index into the scene's textures.
    pub texture: u32,
    /// Set of texture coordinates, 0 or 1.
    pub set: u8,
    /// From the mesh's coordinates to the texture's.
    pub transform: Affine2,
}

/// A single number of a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelMap {
    /// The texture.
    pub map: Map,
    /// 0 … 3: red, green, blue, alpha.
    pub channel: u8,
}

/// A normal map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalMap {
    /// The texture: (n + 1)/2 of a normal n in the tangents' frame, y upwards in the image.
    pub map: Map,
    /// Factor on x and y.
    pub scale: f32,
}

/// How the opacity that textures and vertices give is meant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Alpha {
    /// Not at all: the surface is there.
    #[default]
    Opaque,
    /// The surface is there where it is at least so large.
    Mask(f32),
    /// The share of the surface that is there.
    Blend,
}

/// Textures of a material, each a factor on a parameter of its own.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Maps {
    /// On the base colour.
    pub base_color: Option<Map>,
    /// On the metalness.
    pub metallic: Option<ChannelMap>,
    /// On the roughness.
    pub roughness: Option<ChannelMap>,
    /// On the transmission.
    pub transmission: Option<ChannelMap>,
    /// On the specular factor.
    pub specular: Option<ChannelMap>,
    /// On the specular colour.
    pub specular_color: Option<Map>,
    /// On the share of the clear coat.
    pub clearcoat: Option<ChannelMap>,
    /// On the clear coat's roughness.
    pub clearcoat_roughness: Option<ChannelMap>,
    /// Of the clear coat's normal.
    pub clearcoat_normal: Option<NormalMap>,
    /// On the sheen's colour.
    pub sheen_color: Option<Map>,
    /// On the sheen's roughness.
    pub sheen_roughness: Option<ChannelMap>,
    /// Of the anisotropy: red and green are its direction between tangent and bitangent, (d + 1)/2, blue is on its strength.
    pub anisotropy: Option<Map>,
    /// On the emission.
    pub emission: Option<Map>,
    /// On the opacity.
    pub opacity: Option<ChannelMap>,
    /// Of the shading normal.
    pub normal: Option<NormalMap>,
    /// Whether the vertices' colours are a factor on base colour and opacity.
    pub vertex_colours: bool,
    /// Whether they are one on the emission.
    pub emissive_vertices: bool,
}

/// A surface's parameters, each a factor times a texture.
#[derive(Clone, Debug)]
pub struct Textured {
    factors: MetallicRoughness,
    pub(crate) maps: Maps,
    alpha: Alpha,
    varying: Varying,
}

impl Map {
    /// RGBA at a point.
    #[inline]
    fn at(&self, textures: &[Texture], place: &Coordinates) -> Vec4 {
        textures[self.texture as usize].at(self.transform.transform_point2(place.uv[usize::from(self.set)]))
    }
}

impl ChannelMap {
    #[inline]
    fn at(&self, textures: &[Texture], place: &Coordinates) -> f32 {
        self.map.at(textures, place)[usize::from(self.channel)]
    }
}

/// Value of a texture, or 1 without one.
#[inline]
fn number(map: Option<ChannelMap>, textures: &[Texture], place: &Coordinates) -> f32 {
    map.map_or(1.0, |map| map.at(textures, place))
}

/// Colour of a texture, or white without one.
#[inline]
fn colour(map: Option<Map>, textures: &[Texture], place: &Coordinates) -> Rgb {
    map.map_or(Rgb::ONE, |map| map.at(textures, place).xyz())
}

impl Maps {
    /// Every texture in use.
    pub(crate) fn all(&self) -> impl Iterator<Item = Map> {
        // Without "..": a map that is forgotten here is not checked.
        let &Self {
            base_color,
            metallic,
            roughness,
            transmission,
            specular,
            specular_color,
            clearcoat,
            clearcoat_roughness,
            clearcoat_normal,
            sheen_color,
            sheen_roughness,
            anisotropy,
            emission,
            opacity,
            normal,
            vertex_colours: _,
            emissive_vertices: _,
        } = self;
        let base = [metallic, roughness, transmission, specular, opacity];
        let channels = base.into_iter().chain([clearcoat, clearcoat_roughness, sheen_roughness]);
        let normals = [normal, clearcoat_normal].map(|normal| normal.map(|normal| normal.map));
        let colours = [base_color, specular_color, sheen_color, anisotropy, emission];
        channels.map(|channel| channel.map(|channel| channel.map)).chain(colours).chain(normals).flatten()
    }

    /// Whether nothing varies.
    pub fn is_empty(&self) -> bool {
        self.all().next().is_none() && !self.vertex_colours
    }
}

impl Textured {
    /// Factors with their textures.
    pub fn new(factors: MetallicRoughness, maps: Maps, alpha: Alpha) -> Self {
        let lobes = maps.metallic.is_some() || maps.transmission.is_some();
        let varying = Varying::new(&factors, lobes, maps.roughness.is_some());
        Self { factors, maps, alpha, varying }
    }

    /// The same as the surface of a solid instead of a thin wall; `None`: it is no such wall.
    pub(crate) fn solid(&self) -> Option<Self> {
        let wall = self.factors.thin && self.factors.transmission > 0.0;
        wall.then(|| Self::new(MetallicRoughness { thin: false, ..self.factors.clone() }, self.maps, self.alpha))
    }

    /// Whether the BSDF at some point may let light pass.
    pub(crate) fn may_transmit(&self) -> bool {
        self.factors.transmission > 0.0
    }

    /// The BSDF where no texture changes a factor: it is delta where those at all points are.
    pub fn representative(&self) -> Bsdf {
        self.varying.bsdf(&self.factors, Directions::default())
    }

    /// The set of coordinates that the tangents of a brushed surface follow; `None`: it is not brushed.
    pub(crate) fn brushed_along(&self) -> Option<usize> {
        let map = self.maps.anisotropy.or(self.maps.normal.map(|normal| normal.map));
        self.factors.is_brushed().then(|| map.map_or(0, |map| usize::from(map.set)))
    }

    /// Whether a clear coat has another normal than the base, and its normal map if it has one.
    pub(crate) fn coat_normal(&self) -> Option<Option<NormalMap>> {
        let maps = &self.maps;
        let bent = maps.normal.is_some() || maps.clearcoat_normal.is_some();
        (self.factors.clearcoat > 0.0 && bent).then_some(maps.clearcoat_normal)
    }

    /// The BSDF at a point, where a brushed surface has these unit tangents at a right angle to its normal, and a clear coat this normal.
    pub(crate) fn bsdf(
        &self,
        textures: &[Texture],
        place: &Coordinates,
        tangents: Option<[Vec3A; 2]>,
        coat_normal: Option<Vec3A>,
    ) -> Bsdf {
        let (maps, factors) = (&self.maps, &self.factors);
        let streaks = tangents.map(|tangents| self.streaks(textures, place, tangents));
        let (anisotropy, streak) = streaks.unzip();
        let directions = Directions { streak, coat_normal };
        let mut base_color = factors.base_color * colour(maps.base_color, textures, place);
        if maps.vertex_colours {
            base_color *= place.rgb();
        }
        self.varying.bsdf(
            &MetallicRoughness {
                base_color,
                metallic: factors.metallic * number(maps.metallic, textures, place),
                roughness: factors.roughness * number(maps.roughness, textures, place),
                transmission: factors.transmission * number(maps.transmission, textures, place),
                specular: factors.specular * number(maps.specular, textures, place),
                specular_color: factors.specular_color * colour(maps.specular_color, textures, place),
                clearcoat: factors.clearcoat * number(maps.clearcoat, textures, place),
                clearcoat_roughness: factors.clearcoat_roughness * number(maps.clearcoat_roughness, textures, place),
                sheen_color: factors.sheen_color * colour(maps.sheen_color, textures, place),
                sheen_roughness: factors.sheen_roughness * number(maps.sheen_roughness, textures, place),
                anisotropy: anisotropy.unwrap_or(factors.anisotropy),
                ..*factors
            },
            directions,
        )
    }

    /// Anisotropy at a point, and the unit tangent along which the surface is rougher.
    fn streaks(&self, textures: &[Texture], place: &Coordinates, [t, b]: [Vec3A; 2]) -> (Anisotropy, Vec3A) {
        let Anisotropy { strength, rotation, .. } = self.factors.anisotropy;
        let read = self.maps.anisotropy.map(|map| map.at(textures, place));
        let (direction, factor) = read.map_or((Vec2::X, 1.0), |read| (2.0 * read.xy() - 1.0, read.z));
        let turned = Vec2::new(libm::cosf(rotation), libm::sinf(rotation)).rotate(direction);
        let streak = (turned.x * t + turned.y * b).normalize_or(t);
        (Anisotropy { strength: strength * factor, ..self.factors.anisotropy }, streak)
    }

    /// Factor on the emission at a point.
    pub(crate) fn emission(&self, textures: &[Texture], place: &Coordinates) -> Rgb {
        let vertex = if self.maps.emissive_vertices { place.rgb() } else { Rgb::ONE };
        vertex * colour(self.maps.emission, textures, place)
    }

    /// Whether the emission varies.
    pub(crate) fn has_emission(&self) -> bool {
        self.maps.emission.is_some() || self.maps.emissive_vertices
    }

    /// Whether the opacity varies.
    pub(crate) fn has_opacity(&self) -> bool {
        self.alpha != Alpha::Opaque
    }

    /// The share of the surface that is there at a point, given that of the material.
    pub(crate) fn opacity(&self, factor: f32, textures: &[Texture], place: &Coordinates) -> f32 {
        let vertex = if self.maps.vertex_colours { place.colour.w } else { 1.0 };
        let alpha = factor * vertex * number(self.maps.opacity, textures, place);
        match self.alpha {
            Alpha::Opaque => 1.0,
            Alpha::Mask(least) => f32::from(u8::from(alpha >= least)),
            Alpha::Blend => alpha.clamp(0.0, 1.0),
        }
    }
}

impl NormalMap {
    /// The normal at a point between these tangents and `normal`, kept above the horizon of the geometric normal. The tangents
    /// may have any length and lie across the normal.
    pub(crate) fn normal(
        &self,
        textures: &[Texture],
        place: &Coordinates,
        [tangent, bitangent]: [Vec3A; 2],
        [normal, geometric]: [Vec3A; 2],
    ) -> Vec3A {
        /// Least cosine to the geometric normal.
        const LEAST: f32 = 0.05;
        let [x, y, z, _] = (2.0 * self.map.at(textures, place) - 1.0).to_array();
        let across = |v: Vec3A| (v - normal * normal.dot(v)).normalize_or_zero();
        let (x, y) = (self.scale * x, self.scale * y);
        let bent = (x * across(tangent) + y * across(bitangent) + z.max(0.0) * normal).normalize_or(normal);
        let cos = bent.dot(geometric);
        if cos >= LEAST { bent } else { (bent + geometric * (LEAST - cos)).normalize_or(geometric) }
    }
}
