//! The scene file and the files beside it; nothing outside of its folder is ever read.

use crate::{SceneError, names, text::shown};
use mlt_core::memory::Memory;
use std::{
    collections::BTreeMap,
    fs,
    path::{Component, Path, PathBuf},
    sync::Mutex,
};

/// The largest file that is read, bytes.
const MAX_FILE: u64 = 8 << 30;

/// Files that are part of the program: name and content.
pub(crate) type Embedded = &'static [(&'static str, &'static [u8])];

/// Where a scene comes from, and how much memory it may take.
pub(crate) struct Source<'a> {
    /// The scene file, for messages; on disk it is also what is read.
    pub path: PathBuf,
    embedded: Option<Embedded>,
    memory: &'a Memory,
    /// Hashes of the files that were read, by their names.
    hashes: Mutex<Hashes>,
}

/// Hashes of files, by their names.
pub(crate) type Hashes = BTreeMap<String, blake3::Hash>;

impl<'a> Source<'a> {
    /// A file on disk.
    pub(crate) fn file(path: &Path, memory: &'a Memory) -> Self {
        Self { path: path.to_owned(), embedded: None, memory, hashes: Mutex::default() }
    }

    /// The first of `files`; the others lie beside it.
    pub(crate) fn embedded(files: Embedded, memory: &'a Memory) -> Self {
        let path = files.first().map_or_else(PathBuf::new, |f| f.0.into());
        Self { path, embedded: Some(files), memory, hashes: Mutex::default() }
    }

    /// The scene file's content.
    pub(crate) fn read(&self) -> Result<Vec<u8>, SceneError> {
        match self.embedded {
            Some(_) => self.read_beside(&self.path.to_string_lossy()),
            None => Ok(self.noted("", self.read_file(&self.path)?)),
        }
    }

    /// Tells the scene by the contents of all files of it that were read, whatever their order and wherever they lie.
    pub(crate) fn digest(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        for (name, hash) in self.hashes.lock().expect("no thread has failed").iter() {
            hasher.update(&(name.len() as u64).to_le_bytes()).update(name.as_bytes()).update(hash.as_bytes());
        }
        hasher.finalize().to_hex().to_string()
    }

    /// The hashes of the files that were read.
    pub(crate) fn hashes(&self) -> Hashes {
        self.hashes.lock().expect("no thread has failed").clone()
    }

    /// Counts files as read that were read before, when they had these hashes.
    pub(crate) fn note(&self, hashes: &Hashes) {
        self.hashes.lock().expect("no thread has failed").extend(hashes.clone());
    }

    /// The content of a file, once it is in the digest.
    fn noted(&self, name: &str, content: Vec<u8>) -> Vec<u8> {
        let hash = blake3::hash(&content);
        self.hashes.lock().expect("no thread has failed").insert(name.to_owned(), hash);
        content
    }

    /// The content of the file at the relative path `name` below the scene's folder.
    pub(crate) fn read_beside(&self, name: &str) -> Result<Vec<u8>, SceneError> {
        let name = name.replace('\\', "/");
        if has_scheme(&name) || leaves_folder(Path::new(&name)) {
            return Err(self.outside(&name));
        }
        if let Some(files) = self.embedded {
            let found = files.iter().find(|f| f.0 == name);
            let content = found
                .map(|f| f.1.to_vec())
                .ok_or_else(|| SceneError::NotFound { name: name.clone(), hint: String::new() })?;
            return Ok(self.noted(&name, content));
        }
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let path = folder.join(&name);
        let real = |p: &Path| p.canonicalize().map_err(|cause| SceneError::Read { path: p.to_owned(), cause });
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        if !real(&path)?.starts_with(real(folder)?) {
            return Err(self.outside(&name));
        }
        Ok(self.noted(&name, self.read_file(&path)?))
    }

    fn read_file(&self, path: &Path) -> Result<Vec<u8>, SceneError> {
        let failed = |cause| SceneError::Read { path: path.to_owned(), cause };
        let metadata = fs::metadata(path).map_err(failed)?;
        if !metadata.is_file() {
            return Err(SceneError::NotAFile { path: path.to_owned() });
        }
        if metadata.len() > MAX_FILE {
            let place = "the file".to_owned();
            return Err(SceneError::TooLarge { path: path.to_owned(), place, what: "bytes", limit: MAX_FILE });
        }
        self.take(metadata.len(), "the file")?;
        fs::read(path).map_err(failed)
    }

    /// Takes the memory that `what` is about to fill, or refuses the scene.
    pub(crate) fn take(&self, bytes: u64, what: impl Into<String>) -> Result<(), SceneError> {
        let refused = |shortage| SceneError::Memory { path: self.path.clone(), what: what.into(), shortage };
        self.memory.take(bytes).map_err(refused)
    }

    /// The error that a reference leaves the scene's folder.
    pub(crate) fn outside(&self, uri: &str) -> SceneError {
        SceneError::Outside { path: self.path.clone(), uri: shown(uri) }
    }

    /// The error that no scene has this name, but some have these.
    pub(crate) fn no_scene(&self, name: &str, known: &[&str]) -> SceneError {
        SceneError::NoScene { path: self.path.clone(), name: shown(name), hint: names::instead_of(name, known) }
    }

    /// The error that geometry is compressed by an extension.
    pub(crate) fn compressed(&self, extension: &str) -> SceneError {
        SceneError::Compressed { path: self.path.clone(), extension: extension.to_owned() }
    }

    /// The error that `place` cannot be because of `reason`.
    pub(crate) fn invalid(
        &self,
        place: impl Into<String>,
        reason: impl Into<String>,
        remedy: &'static str,
    ) -> SceneError {
        SceneError::Invalid { path: self.path.clone(), place: place.into(), reason: reason.into(), remedy }
    }

    /// The error that `place` has more than `limit` of `what`.
    pub(crate) fn too_large(&self, place: impl Into<String>, what: &'static str, limit: usize) -> SceneError {
        SceneError::TooLarge { path: self.path.clone(), place: place.into(), what, limit: limit as u64 }
    }
}

/// Whether `uri` starts like `file:` or `https:`.
pub(crate) fn has_scheme(uri: &str) -> bool {
    let is_scheme = |s: &str| {
        s.starts_with(|c: char| c.is_ascii_alphabetic())
            && s.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '+' | '-' | '.'))
    };
    uri.split_once(':').is_some_and(|(head, _)| is_scheme(head))
}

/// Whether a path is absolute or climbs above where it starts.
fn leaves_folder(path: &Path) -> bool {
    let mut depth = 0;
    for component in path.components() {
        match component {
            Component::Normal(_) => depth += 1,
            Component::CurDir => {}
            Component::ParentDir => depth -= 1,
            Component::RootDir | Component::Prefix(_) => return true,
        }
        if depth < 0 {
            return true;
        }
    }
    false
}
