//! Scenes for `mlt-core`: glTF 2.0, OBJ and the built-in ones.
//!
//! Every loader turns a file into a [`SceneDescription`], which is what the renderer starts from. Whatever a file asks for
//! that the description cannot say becomes a warning that names it; whatever makes the file unusable becomes a
//! [`SceneError`]. No input makes a loader panic, and none makes it read outside of the scene's folder.
//!
//! ```
//! let cornell = mlt_scene::open("cornell")?;
//! assert_eq!(cornell.description.cameras.len(), 1);
//! # Ok::<(), mlt_scene::SceneError>(())
//! ```

mod builtin;
mod camera;
mod error;
pub mod gallery;
mod geometry;
mod gltf_file;
mod guard;
mod obj_file;
mod range;
mod source;

use mlt_core::transport::description::SceneDescription;
use source::Source;
use std::path::Path;

pub use builtin::{BUILTIN, builtin};
pub use camera::{bounds, camera_framing, camera_look_at};
pub use error::SceneError;

/// A scene, and what could not be taken over from its file.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The file's name without folder and extension, or the built-in scene's name.
    pub name: String,
    /// What the renderer starts from.
    pub description: SceneDescription,
    /// One sentence each, for the user.
    pub warnings: Vec<String>,
}

/// Loads a `.gltf`, `.glb` or `.obj` file.
pub fn load(path: &Path) -> Result<Loaded, SceneError> {
    let source = Source::file(path);
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    let parse = match extension.as_deref() {
        Some("gltf" | "glb") => gltf_file::load,
        Some("obj") => obj_file::load,
        _ => return Err(SceneError::UnknownFormat { path: path.to_owned() }),
    };
    guard::catch(|| parse(&source)).unwrap_or_else(|reason| Err(SceneError::Parser { path: path.to_owned(), reason }))
}

/// Loads a file, or else the built-in scene of that name.
pub fn open(name_or_path: impl AsRef<Path>) -> Result<Loaded, SceneError> {
    let path = name_or_path.as_ref();
    let name = path.to_string_lossy();
    if path.is_file() || path.extension().is_some() {
        return load(path);
    }
    builtin(&name).unwrap_or_else(|| match path.exists() {
        true => Err(SceneError::NotAFile { path: path.to_owned() }),
        false => Err(SceneError::NotFound { name: name.into_owned() }),
    })
}
