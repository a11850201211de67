//! Values of options, from text.

use std::{fmt, num::NonZeroUsize, str::FromStr, time::Duration};

use mlt_core::transport::lights::Stratification;
use mlt_core::transport::paths::Classes;
use serde::{Serialize, Serializer};

use crate::output::MAX_SIDE;

/// Most cells along one side of a light; more would leave no samples for each.
const MAX_CELLS: u32 = 1024;
/// Most strata over the lights.
const MAX_STRATA: u32 = 65_536;
/// Most tiles along one side of the image.
const MAX_TILES: u32 = 64;

/// Most threads; each takes memory for what it deposits.
const MAX_THREADS: usize = 1024;

/// Width and height of an image, pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (width, height) = pair(text).ok_or_else(|| {
            let samples = if text.parse::<f64>().is_ok() { " (samples per pixel are --spp)" } else { "" };
            format!("give width and height in pixels, as in 640x480{samples}")
        })?;
        let valid = 1..=MAX_SIDE as u64;
        if !valid.contains(&width) || !valid.contains(&height) {
            return Err(format!("width and height have to be between 1 and {MAX_SIDE}"));
        }
        Ok(Self { width: width as usize, height: height as usize })
    }
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

impl Serialize for Size {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_str(self)
    }
}

/// How path space is cut into strata.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Strata {
    /// Over the lights.
    pub lights: Stratification,
    /// Over path lengths and the image.
    pub classes: Classes,
}

const STRATA_HELP: &str = "give 'none', 'auto', a number of strata, or the cells of each light, as in 4x4; then, if you \
                           like, ',length' and ',tiles:2x2'";

impl FromStr for Strata {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        // A plus sign is for lists of methods, which commas part.
        let mut parts = text.split([',', '+']);
        let mut strata = Self { lights: lights(parts.next().unwrap_or_default())?, classes: Classes::default() };
        for part in parts {
            match part.strip_prefix("tiles:") {
                None if part == "length" => strata.classes.lengths = true,
                None => return Err(STRATA_HELP.into()),
                Some(tiles) => strata.classes.tiles = sides(tiles, MAX_TILES)?.into(),
            }
        }
        Ok(strata)
    }
}

fn lights(text: &str) -> Result<Stratification, String> {
    match text {
        "none" => Ok(Stratification::None),
        "auto" => Ok(Stratification::Auto),
        _ if text.bytes().all(|byte| byte.is_ascii_digit()) && !text.is_empty() => match text.parse() {
            Ok(count @ 1..=MAX_STRATA) => Ok(Stratification::Count(count)),
            _ => Err(format!("there have to be between 1 and {MAX_STRATA} strata")),
        },
        _ => sides(text, MAX_CELLS).map(|(columns, rows)| Stratification::Grid(columns, rows)),
    }
}

/// Columns and rows, each between 1 and `most`.
fn sides(text: &str, most: u32) -> Result<(u32, u32), String> {
    let (columns, rows) = pair(text).ok_or(STRATA_HELP)?;
    let side = |n: u64| u32::try_from(n).ok().filter(|n| (1..=most).contains(n));
    side(columns).zip(side(rows)).ok_or(format!("each side has to have between 1 and {most} cells"))
}

impl fmt::Display for Strata {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.lights)?;
        if self.classes.lengths {
            write!(f, ",length")?;
        }
        match self.classes.tiles {
            [1, 1] => Ok(()),
            [columns, rows] => write!(f, ",tiles:{columns}x{rows}"),
        }
    }
}

impl Serialize for Strata {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_str(self)
    }
}

/// "4x3" as its two numbers.
fn pair(text: &str) -> Option<(u64, u64)> {
    let (first, second) = text.split_once(['x', 'X'])?;
    let number = |digits: &str| digits.bytes().all(|byte| byte.is_ascii_digit()).then(|| digits.parse().ok())?;
    Some((number(first)?, number(second)?))
}

/// A time with its unit: `30s`, `1.5s`, `500ms`, `5m`, `1h`.
pub fn duration(text: &str) -> Result<Duration, String> {
    const HELP: &str = "give a number and a unit, as in 30s, 5m or 1.5h";
    let unit_at = text.find(|c: char| c.is_ascii_alphabetic()).ok_or(HELP)?;
    let (number, unit) = text.split_at(unit_at);
    let seconds_per_unit = match unit {
        "ms" => 1e-3,
        "s" => 1.0,
        "m" | "min" => 60.0,
        "h" => 3600.0,
        _ => return Err(HELP.into()),
    };
    let seconds = number.parse::<f64>().map_err(|_| HELP)? * seconds_per_unit;
    match Duration::try_from_secs_f64(seconds) {
        Ok(duration) if !duration.is_zero() => Ok(duration),
        _ => Err("the time has to be more than zero and less than the age of the universe".into()),
    }
}

/// A relative error as a fraction in (0, 1]: `2%` or `0.02`.
pub fn relative_error(text: &str) -> Result<f64, String> {
    let (number, scale) = text.strip_suffix('%').map_or((text, 1.0), |number| (number, 0.01));
    match number.trim_end().parse::<f64>().map(|number| number * scale) {
        Ok(error) if error > 0.0 && error <= 1.0 => Ok(error),
        Ok(_) => Err("the error has to be more than 0 and at most 100%, as in 2% or 0.02".into()),
        Err(_) => Err("give a relative error, as in 2% or 0.02".into()),
    }
}

/// Three finite numbers: `x,y,z`.
pub fn point(text: &str) -> Result<[f64; 3], String> {
    let numbers: Vec<f64> = text.split(',').map_while(|part| part.trim().parse().ok()).collect();
    match numbers[..] {
        [x, y, z] if text.matches(',').count() == 2 && numbers.iter().all(|n| n.is_finite()) => Ok([x, y, z]),
        _ => Err("give three numbers, as in 0,1.5,-4".into()),
    }
}

/// An opening angle in degrees, between 0 and 180, both left out.
pub fn angle(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(degrees) if degrees > 0.0 && degrees < 180.0 => Ok(degrees),
        _ => Err("give an angle of more than 0 and less than 180 degrees".into()),
    }
}

/// A finite number.
pub fn finite(text: &str) -> Result<f64, String> {
    text.parse::<f64>().ok().filter(|number| number.is_finite()).ok_or_else(|| "give a number".into())
}

/// A finite number that is not negative.
pub fn not_negative(text: &str) -> Result<f64, String> {
    finite(text).ok().filter(|&number| number >= 0.0).ok_or_else(|| "give a number that is not negative".into())
}

/// A finite number greater than zero.
pub fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number > 0.0 && number.is_finite() => Ok(number),
        _ => Err("give a number greater than zero".into()),
    }
}

/// Mutations or samples per pixel: greater than zero, and at most 10⁹, so that their number over all pixels can be
/// counted.
pub fn per_pixel(text: &str) -> Result<f64, String> {
    match positive(text) {
        Ok(number) if number <= 1e9 => Ok(number),
        _ => Err("give a number greater than 0 and at most 1e9".into()),
    }
}

/// Width or height of an image, pixels.
pub fn side(text: &str) -> Result<usize, String> {
    let side = text.parse().ok().filter(|side| (1..=MAX_SIDE).contains(side));
    side.ok_or_else(|| format!("give a number of pixels between 1 and {MAX_SIDE}"))
}

/// A number of threads.
pub fn threads(text: &str) -> Result<NonZeroUsize, String> {
    match text.parse::<NonZeroUsize>() {
        Ok(number) if number.get() <= MAX_THREADS => Ok(number),
        _ => Err(format!("give a number between 1 and {MAX_THREADS}, or leave it out for all processors")),
    }
}

/// An exposure in stops, -100 to 100.
pub fn exposure(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(stops) if (-100.0..=100.0).contains(&stops) => Ok(stops),
        _ => Err("give stops between -100 and 100, as in 1.5".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        assert_eq!("640x480".parse(), Ok(Size { width: 640, height: 480 }));
        assert_eq!("65536X1".parse(), Ok(Size { width: 65536, height: 1 }));
        for bad in ["", "640", "x", "640x", "0x1", "1x0", "65537x1", "-1x4", "+1x4", "1x2x3", "9e9x1", "1 x1"] {
            assert!(bad.parse::<Size>().is_err(), "{bad}");
        }
        assert_eq!("640x480".parse::<Size>().map(|size| size.to_string()), Ok("640x480".into()));
    }

    #[test]
    fn strata() {
        let plain = |lights| Ok(Strata { lights, classes: Classes::default() });
        assert_eq!("none".parse(), plain(Stratification::None));
        assert_eq!("auto".parse(), plain(Stratification::Auto));
        assert_eq!("4x3".parse(), plain(Stratification::Grid(4, 3)));
        assert_eq!("65536".parse(), plain(Stratification::Count(65_536)));
        let classes = Classes { lengths: true, tiles: [3, 2] };
        assert_eq!("8,length,tiles:3x2".parse(), Ok(Strata { lights: Stratification::Count(8), classes }));
        assert_eq!("8+length+tiles:3x2".parse::<Strata>(), "8,length,tiles:3x2".parse());
        for bad in [
            "",
            "None",
            "0",
            "65537",
            "-1",
            "0x4",
            "4x0",
            "1025x1",
            "99999999999x1",
            "axb",
            "4x4,",
            "4x4,tile:2x2",
            "length",
            "4,tiles:65x1",
            "4,tiles:2",
        ] {
            assert!(bad.parse::<Strata>().is_err(), "{bad}");
        }
        for text in ["none", "auto", "7", "4x3", "none,length", "4x4,length,tiles:2x3", "auto,tiles:1x2"] {
            assert_eq!(text.parse::<Strata>().map(|strata| strata.to_string()), Ok(text.into()));
        }
    }

    #[test]
    fn durations() {
        let cases = [("30s", 30.0), ("5m", 300.0), ("1h", 3600.0), ("1.5s", 1.5), ("500ms", 0.5), (".5h", 1800.0)];
        for (text, seconds) in cases {
            assert_eq!(duration(text), Ok(Duration::from_secs_f64(seconds)), "{text}");
        }
        for bad in ["", "30", "s", "0s", "-1s", "1d", "1m30s", "infs", "nans", "1e300h", "1 fortnight"] {
            assert!(duration(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn relative_errors() {
        assert_eq!(relative_error("2%"), Ok(0.02));
        assert_eq!(relative_error("0.02"), Ok(0.02));
        assert_eq!(relative_error("100 %"), Ok(1.0));
        for bad in ["", "%", "0", "-1%", "2", "101%", "nan", "inf%", "2%%"] {
            assert!(relative_error(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn points() {
        assert_eq!(point("0,1.5,-4"), Ok([0.0, 1.5, -4.0]));
        assert_eq!(point("-1, 2, 3e1"), Ok([-1.0, 2.0, 30.0]));
        for bad in ["", "1,2", "1,2,3,4", "1,2,x", "1,2,3,x", "1,2,nan", "inf,0,0", "1 2 3"] {
            assert!(point(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn single_numbers() {
        assert_eq!(angle("40.5"), Ok(40.5));
        assert_eq!(positive("0.5"), Ok(0.5));
        assert_eq!(exposure("-2"), Ok(-2.0));
        for bad in ["", "0", "180", "nan", "inf", "-5", "x"] {
            assert!(angle(bad).is_err(), "{bad}");
        }
        for bad in ["", "0", "-1", "nan", "inf", "x"] {
            assert!(positive(bad).is_err() && per_pixel(bad).is_err(), "{bad}");
        }
        for bad in ["", "nan", "inf", "x"] {
            assert!(finite(bad).is_err() && not_negative(bad).is_err(), "{bad}");
        }
        assert_eq!((finite("-2.5"), not_negative("-2.5").is_err(), not_negative("0")), (Ok(-2.5), true, Ok(0.0)));
        for bad in ["", "0", "-1", "1.5", "1025", "x"] {
            assert!(threads(bad).is_err(), "{bad}");
        }
        assert_eq!(threads("32").map(NonZeroUsize::get), Ok(32));
        assert_eq!((per_pixel("0.5"), per_pixel("1.1e9").is_err()), (Ok(0.5), true));
        for bad in ["", "101", "nan", "x"] {
            assert!(exposure(bad).is_err(), "{bad}");
        }
    }
}
