//! A scene of a study, with the image that is taken for true.

use std::path::Path;

use anyhow::{Context, bail};
use mlt_core::measure::{Measures, REL_MSE_EPSILON};
use mlt_core::transport::luminance;

use super::{
    folder::{Folder, WithErrors},
    row::Errors,
    study::Truth,
};
use crate::{
    Failure,
    args::{
        bench::{BenchOptions, Budget},
        contestant::Contestant,
        values::Size,
    },
    diff,
    image::Image,
    interrupt::Interrupt,
    output::{self, Format, exr},
    render::{self, Plan, Rendered, Setup},
};

/// Side of the images when nothing says otherwise, pixels.
const USUAL_SIDE: usize = 256;
/// Size of the larger of the renders that count rays, as a share of the run.
const TRIAL: f64 = 0.125;
/// Fewest mutations or samples per pixel of a run.
const LEAST: f64 = 1.0 / 64.0;

/// A scene, loaded.
pub(super) struct Subject {
    /// As named on the command line.
    pub name: String,
    /// The scene and the camera to render.
    pub setup: Setup,
    /// Words of the command line that all renders of it share.
    words: Vec<String>,
}

impl Subject {
    /// Loads the scene; `reference`: the image whose size it takes if the options name none.
    pub(super) fn load(scene: &Path, options: &BenchOptions, reference: Option<&Image>) -> Result<Self, Failure> {
        let from_image = |image: &Image| Size { width: image.width, height: image.height };
        let usual = Size { width: USUAL_SIDE, height: USUAL_SIDE };
        let size = options.size.or(reference.map(from_image)).unwrap_or(usual);
        let mut words = options.reading.words()?;
        words.push(format!("--size={size}"));
        words.extend(options.max_length.map(|edges| format!("--max-length={edges}")));
        let setup = Setup::new(&options.reference_method.render_options(scene, &words).map_err(Failure::run)?)?;
        Ok(Self { name: scene.display().to_string(), setup, words })
    }

    /// Renders on the current rayon pool; `None` when a signal stopped it.
    pub(super) fn render(
        &self,
        method: &Contestant,
        budget: Budget,
        seed: u64,
        interrupt: &Interrupt,
    ) -> Result<Option<Rendered>, Failure> {
        let budget = match budget {
            Budget::Rays(rays) => match self.per_pixel(method, rays, interrupt)? {
                Some(per_pixel) => Budget::PerPixel(per_pixel),
                None => return Ok(None),
            },
            other => other,
        };
        let mut words = self.words.clone();
        words.push(format!("--seed={seed}"));
        let parse = |words: &[String]| method.render_options(Path::new(&self.name), words).map_err(Failure::run);
        let end = match budget {
            Budget::Time(time) => format!("--time {}s", time.as_secs_f64()),
            Budget::PerPixel(n) | Budget::Rays(n) => Plan::budget_option(parse(&words)?.method(), n, 1),
        };
        words.extend(end.split_whitespace().map(str::to_owned));
        match render::in_memory(&parse(&words)?, &self.setup, interrupt) {
            Ok(rendered) if rendered.report.interrupted => Ok(None),
            Err(Failure::InterruptedEarly(_)) => Ok(None),
            other => other.map(Some),
        }
    }

    /// Mutations or samples per pixel for so many rays per pixel, on the line through two small renders: each round has
    /// a cost of its own. The same on every machine. `None` when a signal stopped it.
    fn per_pixel(&self, method: &Contestant, rays: f64, interrupt: &Interrupt) -> Result<Option<f64>, Failure> {
        let pixels = f64::from(self.setup.camera.pixels());
        let count = |per_pixel: f64| -> Result<Option<f64>, Failure> {
            let trial = self.render(method, Budget::PerPixel(per_pixel), 0, interrupt)?;
            Ok(trial.map(|trial| trial.report.rays as f64 / pixels))
        };
        let Some(first) = count(1.0)? else { return Ok(None) };
        let size = (TRIAL * rays / first.max(1.0)).max(2.0);
        let Some(second) = count(size)? else { return Ok(None) };
        let each = ((second - first) / (size - 1.0)).max(f64::MIN_POSITIVE);
        Ok(Some((1.0 + (rays - first) / each).clamp(LEAST, rays.max(LEAST))))
    }

    /// Finds the reference in the folder, or renders it; `None` when a signal stopped that.
    pub(super) fn reference(
        &self,
        truth: &Truth,
        file: Option<WithErrors>,
        method: &Contestant,
        folder: &Folder,
        interrupt: &Interrupt,
    ) -> Result<Option<Reference>, Failure> {
        let name = format!("{}-reference", self.name);
        let (origin, found) = match (truth, file) {
            (Truth::File(path), file) => (path.display().to_string(), file),
            (Truth::Render(budget), _) => {
                let origin = format!("{method}, {budget}");
                let identity = format!("{} {} {origin}", self.name, self.words.join(" "));
                let found = match folder.kept(&name, &identity) {
                    Some(kept) => Some(kept),
                    None => match self.render(method, *budget, 0, interrupt)? {
                        Some(Rendered { image, stderr, .. }) => {
                            folder.keep(&name, &identity, &image, stderr.as_deref())?;
                            Some((image, stderr))
                        }
                        None => None,
                    },
                };
                (origin, found)
            }
        };
        let [width, height] = self.setup.camera.size().map(|n| n as usize);
        Ok(found.map(|found| Reference::new(found, origin, width, height)).transpose()?)
    }
}

/// An image that is taken for true.
pub(super) struct Reference {
    /// Its pixels.
    pub image: Image,
    /// Luminance of each.
    pub luminance: Vec<f32>,
    /// The method that it was made by.
    pub origin: String,
    /// The same for the same pixels.
    pub fingerprint: String,
    /// relMSE that its own standard errors add to every image's; `None` where they are unknown.
    pub own_error: Option<f64>,
}

impl Reference {
    /// Reads the file, with the standard errors that an OpenEXR file of ours holds.
    pub(super) fn read(path: &Path) -> anyhow::Result<WithErrors> {
        let (image, format) = output::read_image(path)?;
        let stderr = if format == Format::Exr { exr::read(path)?.stderr } else { None };
        if let Some((x, y)) = image.first_non_finite() {
            bail!("{}: pixel ({x}, {y}) is NaN or infinite, so it cannot be a reference", path.display());
        }
        Ok((image, stderr))
    }

    fn new((image, stderr): WithErrors, origin: String, width: usize, height: usize) -> anyhow::Result<Self> {
        if (image.width, image.height) != (width, height) {
            bail!("{origin}: {}x{} pixels, but the renders have {width}x{height}", image.width, image.height);
        }
        let luminance = image.luminance();
        if luminance.iter().all(|&a| a <= 0.0) {
            bail!("{origin}: the reference is black, so nothing can be measured against it");
        }
        let own_error = stderr.map(|stderr| own_error(&luminance, &stderr)).filter(|error| error.is_finite());
        Ok(Self { fingerprint: fingerprint(&image), luminance, origin, own_error, image })
    }

    /// How far an image of the same size is from it.
    pub(super) fn errors(&self, image: &Image) -> anyhow::Result<Errors> {
        let Measures { relative_diff, rel_mse, mape, mean_ratio } =
            Measures::between(&self.luminance, &image.luminance()).context("the sizes of the images differ")?;
        if ![relative_diff, rel_mse, mape, mean_ratio].iter().all(|value| value.is_finite()) {
            bail!("the image or its reference has values that are too large to be measured");
        }
        let flip = diff::hdr_flip(&self.image, image).ok().map(|map| map.statistics().mean);
        Ok(Errors { relative_diff, rel_mse, mape, mean_ratio, flip })
    }
}

/// mean σ² / (a² + 10⁻²), σ the standard error of the luminance, taken as if the errors of the channels were the same.
fn own_error(luminances: &[f32], stderr: &[[f32; 3]]) -> f64 {
    let term = |(&a, &stderr): (&f32, &[f32; 3])| {
        let (a, sigma) = (f64::from(a), f64::from(luminance(stderr.into())));
        sigma * sigma / (a * a + REL_MSE_EPSILON)
    };
    luminances.iter().zip(stderr).map(term).sum::<f64>() / luminances.len() as f64
}

/// FNV-1a, 64 bits, over the bits of all values.
fn fingerprint(image: &Image) -> String {
    let bytes = image.rgb.as_flattened().iter().flat_map(|value| value.to_bits().to_le_bytes());
    let hash =
        bytes.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
    format!("{hash:016x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(values: &[f32]) -> Image {
        Image::new(values.len(), 1, values.iter().map(|&value| [value; 3]).collect()).expect("pixels")
    }

    #[test]
    fn the_reference_knows_its_own_error() {
        let reference = Reference::new((grey(&[2.0, 0.0]), Some(vec![[0.1; 3]; 2])), "a".into(), 2, 1).expect("valid");
        let expected = 0.5 * (0.01 / 4.01 + 0.01 / 0.01);
        assert!((reference.own_error.expect("known") - expected).abs() < 1e-6);
        assert_eq!(reference.errors(&grey(&[2.0, 0.0])).expect("measured").rel_mse, 0.0);
    }

    #[test]
    fn a_reference_of_no_use_is_refused() {
        let message = |image, width| match Reference::new((image, None), "a.exr".into(), width, 1) {
            Err(error) => error.to_string(),
            Ok(_) => panic!("accepted"),
        };
        assert!(message(grey(&[1.0, 2.0]), 3).contains("a.exr: 2x1 pixels, but the renders have 3x1"));
        assert!(message(grey(&[0.0, 0.0]), 2).contains("black"));
    }

    #[test]
    fn the_fingerprint_tells_images_apart() {
        assert_eq!(fingerprint(&grey(&[1.0, 2.0])), fingerprint(&grey(&[1.0, 2.0])));
        assert_ne!(fingerprint(&grey(&[1.0, 2.0])), fingerprint(&grey(&[2.0, 1.0])));
    }
}
