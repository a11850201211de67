//! Files that are there already.
//!
//! Renders are made again and again under one name, so a file that this program has made is overwritten without a question, as every renderer does
//! it. A photograph, a texture or an image that was worked on since is not.

use std::{
    fs::{self, File},
    io::Read,
    path::Path,
};

use anyhow::{Context, bail};

use super::{Format, OutputFile};

/// The beginning of all names of attributes in images of this program.
const MARK: &[u8] = b"mlt.";
/// Bytes of a file in which its attributes begin.
const HEADER: u64 = 1 << 16;

/// Refuses targets that hold what this program has not made.
pub fn check_existing(targets: impl IntoIterator<Item = OutputFile>) -> anyhow::Result<()> {
    for OutputFile { path, .. } in targets.into_iter().filter(|target| !target.is_stdout()) {
        if !is_ours(&path).with_context(|| path.display().to_string())? {
            bail!(
                "{}: is there already, and mlt did not make it; choose another name, or add --force to overwrite it",
                path.display()
            );
        }
    }
    Ok(())
}

/// Whether nothing is lost that this program could not make again: it has made the file, or nothing is in it.
fn is_ours(path: &Path) -> std::io::Result<bool> {
    if !fs::metadata(path).is_ok_and(|metadata| metadata.is_file()) {
        return Ok(true);
    }
    let mut start = Vec::new();
    File::open(path)?.take(HEADER).read_to_end(&mut start)?;
    let has_mark = || start.windows(MARK.len()).any(|bytes| bytes == MARK);
    Ok(start.is_empty() || Format::of_start(&start) == Some(Format::Sums) || has_mark())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_files_of_others_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let refused = |name: &str, content: &[u8]| {
            let path = folder.path().join(name);
            fs::write(&path, content).expect("written");
            check_existing([path.to_str().expect("text").parse().expect("a target")]).err().map(|e| e.to_string())
        };
        assert_eq!(refused("empty.png", b""), None);
        assert_eq!(refused("part.mltp", b"mlt-kept"), None);
        assert_eq!(refused("image.exr", b"\x76\x2f\x31\x01 mlt.b"), None);
        let message = refused("photo.png", b"\x89PNG a photograph").expect("refused");
        assert!(message.contains("photo.png: is there already") && message.contains("--force"), "{message}");
        let new: OutputFile = folder.path().join("new.exr").to_str().expect("text").parse().expect("a target");
        assert!(check_existing([new]).is_ok());
    }
}
