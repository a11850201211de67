//! The width of a lens, from text.

use std::{fmt, str::FromStr};

use serde::{Serialize, Serializer};

/// Width of the image in a camera whose f-number is given, in metres along the longer side: that of 35 mm film, and what Blender
/// takes for granted.
const SENSOR: f64 = 0.036;
/// Largest width, and largest f-number.
const MOST: f64 = 1e6;

/// The width of a lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aperture {
    /// Diameter, in the scene's units.
    Diameter(f64),
    /// Focal length over diameter, in a scene whose unit is the metre.
    FNumber(f64),
}

impl Aperture {
    /// Radius of the lens in the scene's units; `fov`: the opening angle along the image's longer side, radians.
    ///
    /// The focal length of a sensor of width w that sees an angle φ is w / (2 tan(φ/2)).
    pub fn radius(self, fov: f64) -> f64 {
        match self {
            Self::Diameter(diameter) => 0.5 * diameter,
            Self::FNumber(n) => 0.5 * SENSOR / (2.0 * libm::tan(0.5 * fov)) / n,
        }
    }
}

impl FromStr for Aperture {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let f_number = text.strip_prefix("f/").or_else(|| text.strip_prefix("F/"));
        match (f_number.unwrap_or(text).parse::<f64>(), f_number) {
            (Ok(n), Some(_)) if n > 0.0 && n <= MOST => Ok(Self::FNumber(n)),
            (Ok(diameter), None) if (0.0..=MOST).contains(&diameter) => Ok(Self::Diameter(diameter)),
            _ => Err("give the lens's diameter in the scene's units, as in 0.05, or its f-number, as in f/2.8".into()),
        }
    }
}

/// As on the command line.
impl fmt::Display for Aperture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Diameter(diameter) => write!(f, "{diameter}"),
            Self::FNumber(n) => write!(f, "f/{n}"),
        }
    }
}

impl Serialize for Aperture {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_str(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_are_diameters_or_f_numbers() {
        assert_eq!("0.05".parse(), Ok(Aperture::Diameter(0.05)));
        assert_eq!("f/2.8".parse(), Ok(Aperture::FNumber(2.8)));
        for bad in ["", "f2.8", "f/0", "-1", "nan", "f/inf", "2.8x"] {
            assert!(bad.parse::<Aperture>().expect_err(bad).contains("f/2.8"), "{bad}");
        }
        for text in ["0", "0.05", "f/2.8"] {
            assert_eq!(text.parse::<Aperture>().map(|aperture| aperture.to_string()), Ok(text.into()));
        }
    }

    /// 50 mm at f/2 is a lens of 25 mm.
    #[test]
    fn an_f_number_is_that_of_a_35_mm_camera() {
        let fov = 2.0 * libm::atan(0.018 / 0.050);
        assert!((Aperture::FNumber(2.0).radius(fov) - 0.0125).abs() < 1e-12);
        assert_eq!(Aperture::Diameter(0.5).radius(fov), 0.25);
    }
}
