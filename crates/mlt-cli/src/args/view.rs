//! Where a scene is seen from.

use clap::Args;
use serde::Serialize;

use super::{
    aperture::Aperture,
    crop::Crop,
    heading,
    values::{Size, angle, point, positive, side},
};
use crate::output::{Frame, MAX_SIDE};

/// Side of an image whose size is not given, pixels.
const USUAL_SIDE: f64 = 512.0;
/// Largest aspect ratio that an image gets by itself, and one over the smallest.
const LONGEST: f64 = 16.0;

/// The camera and its image.
#[derive(Args, Clone, Debug, PartialEq, Serialize)]
pub struct ViewOptions {
    /// Size of the image in pixels, as in 1920x1080
    ///
    /// If not given, 512 along the longer side, of the camera's aspect ratio.
    #[arg(short, long, visible_alias = "resolution", value_name = "WxH", help_heading = heading::IMAGE)]
    pub size: Option<Size>,
    /// Width of the image in pixels; alone, the height follows from the camera's aspect ratio
    #[arg(long, value_name = "PIXELS", value_parser = side, conflicts_with = "size", help_heading = heading::IMAGE)]
    #[arg(hide_short_help = true)]
    pub width: Option<usize>,
    /// Height of the image in pixels; alone, the width follows from the camera's aspect ratio
    #[arg(long, value_name = "PIXELS", value_parser = side, conflicts_with = "size", help_heading = heading::IMAGE)]
    #[arg(hide_short_help = true)]
    pub height: Option<usize>,
    /// Render only a part of the image, as in 100,50,300,200
    ///
    /// Its left, top, right and bottom edge, in pixels or, with a point as in 0.25,0.1,0.75,0.5, in parts of the image.
    #[arg(long, value_name = "X0,Y0,X1,Y1", hide_short_help = true, help_heading = heading::IMAGE)]
    pub crop: Option<Crop>,
    /// The scene's camera of this name; its first one if not given
    ///
    /// A scene without any is framed whole. 'mlt inspect SCENE' lists the cameras.
    #[arg(long, value_name = "NAME", conflicts_with_all = ["camera_from", "camera_to", "fov"])]
    #[arg(help_heading = heading::CAMERA)]
    pub camera: Option<String>,
    /// Where the camera stands
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, requires = "camera_to")]
    #[arg(help_heading = heading::CAMERA)]
    #[arg(hide_short_help = true)]
    pub camera_from: Option<[f64; 3]>,
    /// The point that the camera looks at
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, requires = "camera_from")]
    #[arg(help_heading = heading::CAMERA)]
    #[arg(hide_short_help = true)]
    pub camera_to: Option<[f64; 3]>,
    /// The camera's full vertical opening angle
    #[arg(long, value_name = "DEGREES", value_parser = angle, help_heading = heading::CAMERA)]
    pub fov: Option<f64>,
    /// The camera's lens: its f-number, as in f/2.8, or its diameter
    ///
    /// An f-number is for a scene of metres and film 36 mm wide; a diameter is in the scene's units, as in 0.05; 0 is a pinhole.
    /// The file decides if not given.
    #[arg(long, value_name = "F", help_heading = heading::CAMERA)]
    #[arg(hide_short_help = true)]
    pub aperture: Option<Aperture>,
    /// Distance of what is in focus, in the scene's units
    ///
    /// It is measured along the viewing direction. If not given, what the file says, or that of --camera-to.
    #[arg(long, value_name = "DISTANCE", value_parser = positive, help_heading = heading::CAMERA)]
    #[arg(hide_short_help = true)]
    pub focus: Option<f64>,
}

impl ViewOptions {
    /// Width and height if both are given.
    pub fn given_size(&self) -> Option<Size> {
        self.size.or_else(|| Some(Size { width: self.width?, height: self.height? }))
    }

    /// The image's size for a camera of this aspect ratio: as given, with what is not given to match.
    pub fn size_for(&self, aspect_ratio: f64) -> Size {
        let aspect = aspect_ratio.clamp(1.0 / LONGEST, LONGEST);
        let whole = |side: f64| (side.round() as usize).clamp(1, MAX_SIDE);
        match (self.given_size(), self.width, self.height) {
            (Some(size), ..) => size,
            (_, Some(width), _) => Size { width, height: whole(width as f64 / aspect) },
            (.., Some(height)) => Size { width: whole(height as f64 * aspect), height },
            _ => Size { width: whole(USUAL_SIDE * aspect.min(1.0)), height: whole(USUAL_SIDE / aspect.max(1.0)) },
        }
    }

    /// The same view with this size.
    pub fn sized(&self, size: Size) -> Self {
        Self { size: Some(size), width: None, height: None, ..self.clone() }
    }

    /// The image, if it is a part of a larger one whose size is given.
    pub fn frame(&self) -> anyhow::Result<Option<Frame>> {
        let (Some(crop), Some(Size { width, height })) = (self.crop, self.size) else { return Ok(None) };
        let window = crop.window([width, height].map(|side| side as u32))?;
        Ok(Some(Frame { size: [width, height], corner: window.corner.map(|x| x as usize) }))
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Debug, Parser)]
    struct Line {
        #[command(flatten)]
        options: ViewOptions,
    }

    #[test]
    fn a_size_is_given_in_any_of_the_usual_ways() {
        let size = |line: &str| {
            let words = std::iter::once("mlt").chain(line.split_whitespace());
            Line::try_parse_from(words).map(|line| line.options.size_for(2.0).to_string()).ok()
        };
        for (line, expected) in [
            ("", "512x256"),
            ("--size 640x480", "640x480"),
            ("-s 640x480", "640x480"),
            ("--resolution 640x480", "640x480"),
            ("--width 640 --height 480", "640x480"),
            ("--width 640", "640x320"),
            ("--height 480", "960x480"),
            ("--width 1", "1x1"),
            ("--height 65536", "65536x65536"),
        ] {
            assert_eq!(size(line).as_deref(), Some(expected), "{line}");
        }
        for bad in ["--size 64", "--width 0", "--width 65537", "--size 4x4 --width 4", "--height x"] {
            assert_eq!(size(bad), None, "{bad}");
        }
    }
}
