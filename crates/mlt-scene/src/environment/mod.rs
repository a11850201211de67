//! Light from all around a scene, as its user asks for it.

mod image;

use crate::{Loaded, SceneError};
use mlt_core::memory::Memory;
use mlt_core::transport::Rgb;
use mlt_core::transport::scene::Environment;
use std::{fmt, path::PathBuf};

/// Where light from all around comes from.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum EnvironmentSource {
    /// That of the file; a neutral sky where nothing in the file gives light.
    #[default]
    AsNeeded,
    /// Nothing, even where all is dark then.
    None,
    /// A neutral sky.
    Sky,
    /// The same radiance from everywhere.
    Constant(Rgb),
    /// An equirectangular image, Radiance HDR or OpenEXR, its top being the scene's.
    Image(PathBuf),
}

/// As it is asked for; empty if it is not.
impl fmt::Display for EnvironmentSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AsNeeded => Ok(()),
            Self::None => f.write_str("none"),
            Self::Sky => f.write_str("sky"),
            Self::Constant(Rgb { x, y, z }) => write!(f, "{x},{y},{z}"),
            Self::Image(path) => write!(f, "{}", path.display()),
        }
    }
}

/// Light from all around a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentOptions {
    /// Where it comes from.
    pub source: EnvironmentSource,
    /// Angle by which it is turned anticlockwise, seen from above, degrees.
    pub rotation: f64,
    /// Factor of its radiance.
    pub strength: f32,
    /// Whether the camera sees it.
    pub visible: bool,
}

impl Default for EnvironmentOptions {
    fn default() -> Self {
        Self { source: EnvironmentSource::default(), rotation: 0.0, strength: 1.0, visible: true }
    }
}

/// Puts the environment around a scene.
pub(crate) fn surround(loaded: &mut Loaded, options: &EnvironmentOptions, memory: &Memory) -> Result<(), SceneError> {
    let environment = match &options.source {
        EnvironmentSource::AsNeeded => {
            loaded.neutral_sky = !loaded.description.is_lit();
            if loaded.neutral_sky { Some(Environment::sky()) } else { loaded.description.environment.take() }
        }
        EnvironmentSource::None => None,
        EnvironmentSource::Sky => Some(Environment::sky()),
        EnvironmentSource::Constant(radiance) => Some(Environment::constant(*radiance)),
        EnvironmentSource::Image(path) => {
            let (environment, hash) = image::load(path, memory, &mut loaded.warnings)?;
            loaded.digest = blake3::hash(&[loaded.digest.as_bytes(), hash.as_bytes()].concat()).to_hex().to_string();
            Some(environment)
        }
    };
    loaded.description.environment = environment.map(|mut environment| {
        environment.rotation = options.rotation.to_radians();
        environment.strength *= options.strength;
        environment.visible = options.visible;
        environment
    });
    Ok(())
}
