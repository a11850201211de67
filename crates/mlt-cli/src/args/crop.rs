//! A part of the image.

use std::{fmt, str::FromStr};

use anyhow::bail;
use serde::{Serialize, Serializer};

/// Corners of a rectangle of the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Crop {
    /// In pixels; the second is the first pixel beyond it.
    Pixels([[u32; 2]; 2]),
    /// In shares of the image's sides.
    Shares([[f64; 2]; 2]),
}

/// Pixels of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// The first one.
    pub corner: [u32; 2],
    /// Columns and rows.
    pub size: [u32; 2],
}

impl Crop {
    /// The pixels of an image of this size that it covers: those nearest to its corners, one at least.
    pub fn window(&self, [width, height]: [u32; 2]) -> anyhow::Result<Window> {
        let share = |x: f64, side: u32| (x * f64::from(side)).round() as u32;
        let [[x0, y0], [x1, y1]] = match *self {
            Self::Pixels(corners) => corners,
            Self::Shares([[x0, y0], [x1, y1]]) => {
                let (left, top) = (share(x0, width).min(width - 1), share(y0, height).min(height - 1));
                [[left, top], [share(x1, width).max(left + 1), share(y1, height).max(top + 1)]]
            }
        };
        if x1 > width || y1 > height {
            bail!("--crop {self}: the image has {width}x{height} pixels; name a part of it");
        }
        Ok(Window { corner: [x0, y0], size: [x1 - x0, y1 - y0] })
    }
}

impl FromStr for Crop {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts: Vec<_> = text.split(',').map(str::trim).collect();
        let crop = if text.contains('.') {
            numbers(&parts).map(Self::Shares).filter(|crop| match crop {
                Self::Shares(corners) => corners.as_flattened().iter().all(|share| (0.0..=1.0).contains(share)),
                Self::Pixels(_) => true,
            })
        } else {
            numbers(&parts).map(Self::Pixels)
        };
        let ordered = |crop: &Self| match crop {
            Self::Pixels([low, high]) => low[0] < high[0] && low[1] < high[1],
            Self::Shares([low, high]) => low[0] < high[0] && low[1] < high[1],
        };
        crop.filter(ordered).ok_or_else(|| {
            "give the left, top, right and bottom edge, in pixels as in 100,50,300,200 or in parts of the image as in \
             0.25,0.1,0.75,0.5"
                .into()
        })
    }
}

/// Two corners.
fn numbers<T: FromStr + Copy>(parts: &[&str]) -> Option<[[T; 2]; 2]> {
    let numbers: Vec<T> = parts.iter().map(|part| part.parse().ok()).collect::<Option<_>>()?;
    let &[x0, y0, x1, y1] = &numbers[..] else { return None };
    Some([[x0, y0], [x1, y1]])
}

impl fmt::Display for Crop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Pixels([[x0, y0], [x1, y1]]) => write!(f, "{x0},{y0},{x1},{y1}"),
            // With a point, that whole numbers are shares, too.
            Self::Shares([[x0, y0], [x1, y1]]) => write!(f, "{x0:?},{y0:?},{x1:?},{y1:?}"),
        }
    }
}

impl Serialize for Crop {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_str(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn window(text: &str) -> Option<Window> {
        text.parse::<Crop>().ok()?.window([40, 20]).ok()
    }

    #[test]
    fn edges_are_pixels_or_shares() {
        let some = |corner, size| Some(Window { corner, size });
        assert_eq!(window("10,5,18,15"), some([10, 5], [8, 10]));
        assert_eq!(window("0.25, 0.25, 0.45, 0.75"), some([10, 5], [8, 10]));
        assert_eq!([window("0,0,1,1"), window("0,0,1.0,1")], [some([0, 0], [1, 1]), some([0, 0], [40, 20])]);
        // A part that is smaller than a pixel is one.
        assert_eq!(window("0.999,0.0,1.0,0.001"), some([39, 0], [1, 1]));
        for bad in [
            "",
            "1,2,3",
            "1,2,3,4,5",
            "5,5,5,9",
            "9,5,5,9",
            "0,0,41,9",
            "0.0,0,1.5,1",
            "-1,0,3,3",
            "0.0,nan,1,1",
            "a,b,c,d",
        ] {
            assert_eq!(window(bad), None, "{bad}");
        }
    }

    #[test]
    fn text_leads_back() {
        for text in ["10,5,18,15", "0.0,0.0,1.0,1.0", "0.25,0.1,0.75,0.5"] {
            assert_eq!(text.parse::<Crop>().map(|crop| crop.to_string()), Ok(text.to_owned()));
        }
    }
}
