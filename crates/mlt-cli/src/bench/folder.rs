//! The folder of a study.

use std::{
    fs,
    path::{Path, PathBuf},
};

use anyhow::Context;

use crate::{atomic, image::Image, output::exr};

/// Attribute of an image that says what it shows.
const IDENTITY: &str = "mlt.bench";

/// Where results go.
#[derive(Clone, Debug)]
pub(super) struct Folder(PathBuf);

/// An image and, where known, the standard errors of its values.
pub(super) type WithErrors = (Image, Option<Vec<[f32; 3]>>);

impl Folder {
    /// Creates the folder and its folders of images and charts, if they are not there.
    pub(super) fn create(path: &Path) -> anyhow::Result<Self> {
        for inner in ["images", "charts"] {
            fs::create_dir_all(path.join(inner)).with_context(|| format!("{}: cannot be created", path.display()))?;
        }
        Ok(Self(path.to_owned()))
    }

    /// A file in it.
    pub(super) fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Writes a file whole or not at all.
    pub(super) fn write(&self, name: &str, bytes: &[u8]) -> anyhow::Result<()> {
        atomic::write(&self.file(name), bytes)
    }

    /// Keeps an image under a name; `identity`: everything that decides its pixels.
    pub(super) fn keep(
        &self,
        name: &str,
        identity: &str,
        image: &Image,
        stderr: Option<&[[f32; 3]]>,
    ) -> anyhow::Result<()> {
        let bytes = exr::encode(image, stderr, &[(IDENTITY.to_owned(), identity.to_owned())])?;
        atomic::write(&self.image(name), &bytes)
    }

    /// The image kept under this name; `None` if there is none, or it is of another identity or damaged.
    pub(super) fn kept(&self, name: &str, identity: &str) -> Option<WithErrors> {
        let file = exr::read(&self.image(name)).ok()?;
        let same = file.attributes.iter().any(|(name, value)| name == IDENTITY && value == identity);
        same.then_some((file.image, file.stderr))
    }

    /// Writes a chart.
    pub(super) fn chart(&self, name: &str, svg: &str) -> anyhow::Result<()> {
        atomic::write(&self.0.join("charts").join(plain(name) + ".svg"), svg.as_bytes())
    }

    fn image(&self, name: &str) -> PathBuf {
        self.0.join("images").join(plain(name) + ".exr")
    }
}

/// A name that any system takes for a file.
fn plain(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() || "-_.=".contains(c) { c } else { '_' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_image_is_kept_with_its_identity() {
        let parent = tempfile::tempdir().expect("a folder");
        let folder = Folder::create(&parent.path().join("a/b")).expect("created");
        let image = Image::new(1, 1, vec![[0.5; 3]]).expect("one pixel");
        folder.keep("../é scene", "seed 1", &image, None).expect("kept");
        assert_eq!(folder.kept("../é scene", "seed 1"), Some((image, None)));
        assert_eq!(folder.kept("../é scene", "seed 2"), None);
        assert_eq!(folder.kept("other", "seed 1"), None);
        assert_eq!(fs::read_dir(parent.path().join("a/b/images")).expect("readable").count(), 1);
    }
}
