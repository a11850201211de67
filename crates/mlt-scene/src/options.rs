//! How a scene is read.

use crate::Glass;
use crate::environment::EnvironmentOptions;

/// Choices that a file leaves open, or that its user makes otherwise.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadOptions {
    /// Scene of a glTF file to show, by its name; `None`: the file's default one.
    pub scene: Option<String>,
    /// Time in a glTF file's animations, s; `None`: as it stands without them.
    pub time_in_animation: Option<f64>,
    /// How to take surfaces of a glTF file that transmit light.
    pub glass: Glass,
    /// Light from all around.
    pub environment: EnvironmentOptions,
    /// Units of point, spot and directional lights in a glTF file; `None`: those of the program that wrote the
    /// file, photometric ones if that is not Blender.
    pub light_units: Option<LightUnits>,
    /// How to hold meshes of a glTF file that stand in several places.
    pub copies: Copies,
}

/// How to hold meshes that stand in several places; the image is the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Copies {
    /// Once where that saves much memory.
    #[default]
    Auto,
    /// Once each.
    Shared,
    /// As often as they stand somewhere.
    Baked,
}

/// Units of point, spot and directional lights in a glTF file, beside the radiance of its emissive materials.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LightUnits {
    /// Candela and lux for Blender's watts, at 683 lm/W: radiance in W/(sr m²), as Blender's own is.
    Blender,
    /// Candela and lux: radiance in cd/m², as the specification has it. Also what Blender calls unitless.
    Photometric,
    /// Watts of points and spots, W/m² of directions, without any conversion, as Blender can write them.
    Raw,
}
