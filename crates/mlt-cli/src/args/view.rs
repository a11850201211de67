//! Where a scene is seen from.

use clap::Args;
use serde::Serialize;

use super::values::{Size, angle, point};

/// The camera and its image.
#[derive(Args, Clone, Debug, PartialEq, Serialize)]
pub struct ViewOptions {
    /// Size of the image in pixels; if not given, 512 along the longer side, of the camera's aspect ratio
    #[arg(long, value_name = "WxH", help_heading = "Camera")]
    pub size: Option<Size>,
    /// The scene's camera of this name. Its first one if not given; a scene without any is framed whole
    #[arg(long, value_name = "NAME", help_heading = "Camera", conflicts_with_all = ["camera_from", "camera_to", "fov"])]
    pub camera: Option<String>,
    /// Where the camera stands
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, requires = "camera_to")]
    #[arg(help_heading = "Camera")]
    pub camera_from: Option<[f64; 3]>,
    /// The point that the camera looks at
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, requires = "camera_from")]
    #[arg(help_heading = "Camera")]
    pub camera_to: Option<[f64; 3]>,
    /// The camera's full vertical opening angle
    #[arg(long, value_name = "DEGREES", value_parser = angle, help_heading = "Camera")]
    pub fov: Option<f64>,
}
