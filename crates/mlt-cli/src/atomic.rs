//! Files that are written whole or not at all.

use std::{
    collections::BTreeSet,
    fs::{self, File},
    io::Write,
    path::{Path, PathBuf},
    process,
    sync::{Mutex, MutexGuard, PoisonError},
};

use anyhow::Context;
use tempfile::NamedTempFile;

/// Puts `bytes` at `path`; see [`write_with`].
pub fn write(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    write_with(path, |file| Ok(file.write_all(bytes)?))
}

/// Puts what `content` writes at `path`: into a temporary file beside it, to the disk, then renamed.
///
/// On failure the error names the file, what stood at `path` stays, and nothing new is left behind. A file that is
/// replaced keeps its permissions; a new one gets the usual ones. A symbolic link is followed, not replaced, whether there is a file at
/// its end or not.
pub fn write_with(path: &Path, content: impl FnOnce(&mut File) -> anyhow::Result<()>) -> anyhow::Result<()> {
    replace(path, content).with_context(|| format!("{}: cannot be written", path.display()))
}

/// Ends the program at once, in the middle of whatever it writes: all files stay as they were, and no temporary file is left behind.
pub fn exit(code: i32) -> ! {
    // It stays locked: no file is begun or ended any more.
    let unfinished = unfinished();
    unfinished.iter().for_each(|path| drop(fs::remove_file(path)));
    process::exit(code)
}

/// Temporary files that are there.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn unfinished() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The name of a temporary file, which [`exit`] removes as long as this lives.
struct Listed(PathBuf);

impl Drop for Listed {
    fn drop(&mut self) {
        unfinished().remove(&self.0);
    }
}

/// A new temporary file, listed from when it is there.
fn listed_in(folder: &Path) -> std::io::Result<(Listed, NamedTempFile)> {
    let mut unfinished = unfinished();
    let file = temporary_in(folder)?;
    unfinished.insert(file.path().to_path_buf());
    Ok((Listed(file.path().to_path_buf()), file))
}

fn replace(path: &Path, content: impl FnOnce(&mut File) -> anyhow::Result<()>) -> anyhow::Result<()> {
    let target = followed(path)?;
    let folder = folder_of(&target);
    let (_listed, mut file) = listed_in(&folder)?;
    if let Ok(existing) = fs::metadata(&target) {
        file.as_file().set_permissions(existing.permissions())?;
    }
    content(file.as_file_mut())?;
    file.as_file().sync_all()?;
    file.persist(&target).map_err(|error| error.error)?;
    // The rename itself reaches the disk with the folder; where a folder cannot be synchronised it still happened.
    let _ = File::open(&folder).and_then(|folder| folder.sync_all());
    Ok(())
}

/// Most symbolic links on the way to a file, as Linux has it.
const MOST_LINKS: usize = 40;

/// Where a file of this name lies or would lie, with the path's last part no symbolic link.
pub(crate) fn followed(path: &Path) -> std::io::Result<PathBuf> {
    let mut target = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        match fs::read_link(&target) {
            // A link says where its end is as seen from its own folder.
            Ok(end) => target = folder_of(&target).join(end),
            Err(_) => return Ok(target),
        }
    }
    Err(std::io::Error::new(std::io::ErrorKind::InvalidInput, "too many symbolic links"))
}

/// The folder that a file of this name lies in; the current one for a bare name.
pub(crate) fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

#[cfg(unix)]
fn temporary_in(folder: &Path) -> std::io::Result<NamedTempFile> {
    use std::os::unix::fs::PermissionsExt;
    // Temporary files are private by default; an image is to be as readable as any other new file (the umask applies).
    tempfile::Builder::new().prefix(".mlt-").permissions(fs::Permissions::from_mode(0o666)).tempfile_in(folder)
}

#[cfg(not(unix))]
fn temporary_in(folder: &Path) -> std::io::Result<NamedTempFile> {
    tempfile::Builder::new().prefix(".mlt-").tempfile_in(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).expect("readable");
        entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect()
    }

    #[test]
    fn a_file_is_written_and_replaced() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("image.exr");
        write(&path, b"first").expect("written");
        write(&path, b"second").expect("replaced");
        assert_eq!(fs::read(&path).expect("there"), b"second");
        assert_eq!(names(folder.path()), ["image.exr"]);
    }

    #[test]
    fn a_failed_write_names_the_file_and_leaves_nothing() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a".repeat(300) + ".exr");
        let message = format!("{:#}", write(&path, b"bytes").expect_err("the name is too long"));
        assert!(message.contains("aaa.exr: cannot be written: ") && message.contains("too long"), "{message}");
        assert!(names(folder.path()).is_empty());
        assert!(write(&folder.path().join("none/a.exr"), b"bytes").is_err());
        assert!(write(folder.path(), b"bytes").is_err());
    }

    #[test]
    fn a_bare_name_is_in_the_current_folder() {
        assert_eq!(folder_of(Path::new("a.exr")), Path::new("."));
        assert_eq!(folder_of(Path::new("b/a.exr")), Path::new("b"));
        assert_eq!(folder_of(Path::new("/a.exr")), Path::new("/"));
    }

    #[cfg(unix)]
    #[test]
    fn permissions_are_the_usual_ones_or_kept() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().expect("a folder");
        let mode = |path: &Path| fs::metadata(path).expect("there").permissions().mode() & 0o777;
        let (plain, image) = (folder.path().join("plain"), folder.path().join("image.exr"));
        fs::write(&plain, b"").expect("written");
        write(&image, b"").expect("written");
        assert_eq!(mode(&image), mode(&plain));

        fs::set_permissions(&image, fs::Permissions::from_mode(0o640)).expect("set");
        write(&image, b"again").expect("replaced");
        assert_eq!(mode(&image), 0o640);
    }

    #[cfg(unix)]
    #[test]
    fn a_symbolic_link_is_followed() {
        let folder = tempfile::tempdir().expect("a folder");
        let (link, real) = (folder.path().join("link.exr"), folder.path().join("real.exr"));
        fs::write(&real, b"old").expect("written");
        std::os::unix::fs::symlink(&real, &link).expect("linked");
        write(&link, b"new").expect("written");
        assert_eq!(fs::read(&real).expect("there"), b"new");
        assert!(fs::symlink_metadata(&link).expect("there").is_symlink());
    }

    #[cfg(unix)]
    #[test]
    fn a_link_to_nothing_yet_is_followed_too_and_a_ring_of_links_is_refused() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().expect("a folder");
        let [first, second, sub] = ["first.exr", "second.exr", "sub"].map(|name| folder.path().join(name));
        fs::create_dir(&sub).expect("made");
        symlink("sub/second.exr", &first).expect("linked");
        symlink("../real.exr", sub.join("second.exr")).expect("linked");
        write(&first, b"new").expect("written");
        assert_eq!(fs::read(folder.path().join("real.exr")).expect("there"), b"new");
        assert!(fs::symlink_metadata(&first).expect("there").is_symlink());

        symlink(&second, &second).expect("linked");
        let message = format!("{:#}", write(&second, b"new").expect_err("refused"));
        assert!(message.contains("too many symbolic links"), "{message}");
    }
}
