//! Where a scene is seen from.

use clap::Args;
use serde::Serialize;

use super::{
    aperture::Aperture,
    values::{Size, angle, point, positive},
};

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
    /// The camera's lens: its diameter in the scene's units, as in 0.05, or its f-number, as in f/2.8, in a scene of metres and for
    /// film 36 mm wide; 0 for a pinhole. What the file says if not given
    #[arg(long, value_name = "F", help_heading = "Camera")]
    pub aperture: Option<Aperture>,
    /// Distance of what is in focus, along the viewing direction, in the scene's units; if not given, what the file says, or that of
    /// --camera-to
    #[arg(long, value_name = "DISTANCE", value_parser = positive, help_heading = "Camera")]
    pub focus: Option<f64>,
}
