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
mod environment;
mod error;
pub mod gallery;
mod geometry;
mod glass;
mod gltf_file;
mod guard;
mod images;
mod missing;
mod moving;
mod names;
mod obj_file;
mod options;
mod outline;
mod range;
mod source;
mod tangents;
mod text;
mod winding;

use gltf_file::Kept;
use mlt_core::memory::Memory;
use mlt_core::transport::scene::SceneDescription;
use source::Source;
use std::path::Path;

pub use builtin::{BUILTIN, BuiltIn, builtin};
pub use camera::{bounds, camera_framing};
pub use environment::{EnvironmentOptions, EnvironmentSource};
pub use error::SceneError;
pub use glass::Glass;
pub use missing::{SCENE_EXTENSIONS, is_scene_file};
pub use moving::MovingScene;
pub use names::{instead_of, meant};
pub use options::{Copies, LightUnits, LoadOptions};
pub use outline::Entry;
pub use text::{MOST_OF_A_MESSAGE, printable};

/// A scene, and what could not be taken over from its file.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The file's name without folder and extension, or the built-in scene's name.
    pub name: String,
    /// The scene, for the renderer.
    pub description: SceneDescription,
    /// The nodes of the file that are shown, depth first; of an OBJ file its meshes.
    pub outline: Vec<Entry>,
    /// One sentence each, for the user.
    pub warnings: Vec<String>,
    /// A hash of the files that it was read from, in hexadecimal digits: scenes of different files have different ones.
    pub digest: String,
    /// Whether a neutral sky was put around the scene because nothing in it gives light.
    pub neutral_sky: bool,
}

impl Loaded {
    /// Leaves nothing in names and warnings that would control a terminal. Cameras keep their names, to be chosen by.
    fn make_printable(&mut self) {
        self.description.all_meshes_mut().for_each(|mesh| mesh.name = text::shown(&mesh.name));
        self.description.materials.iter_mut().for_each(|material| material.name = text::shown(&material.name));
        self.warnings.iter_mut().for_each(|warning| *warning = printable(warning, MOST_OF_A_MESSAGE));
    }
}

/// Loads a `.gltf`, `.glb` or `.obj` file, of any size.
pub fn load(path: &Path) -> Result<Loaded, SceneError> {
    load_within(path, &LoadOptions::default(), &Memory::unlimited(), &mut Kept::default())
}

/// Loads a `.gltf`, `.glb` or `.obj` file, and takes the memory that it needs here and in the renderer's scene.
fn load_within(path: &Path, options: &LoadOptions, memory: &Memory, kept: &mut Kept) -> Result<Loaded, SceneError> {
    if is_scene_file(path) && !path.exists() {
        return Err(SceneError::Missing { path: path.to_owned(), hint: missing::hint(path) });
    }
    let source = Source::file(path, memory);
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    let parsed = guard::catch(|| match extension.as_deref() {
        Some("gltf" | "glb") => gltf_file::load(&source, options, kept),
        Some("obj") => obj_file::load(&source, options),
        _ => Err(SceneError::UnknownFormat { path: path.to_owned() }),
    });
    let mut loaded = parsed.map_err(|reason| SceneError::Parser { path: path.to_owned(), reason })??;
    glass::settle(&mut loaded.description, options.glass, &mut loaded.warnings);
    winding::follow_normals(&mut loaded.description, &mut loaded.warnings);
    environment::surround(&mut loaded, &options.environment, memory)?;
    loaded.make_printable();
    Ok(loaded)
}

/// Loads a file, or else the built-in scene of that name, of any size.
pub fn open(name_or_path: impl AsRef<Path>) -> Result<Loaded, SceneError> {
    open_within(name_or_path, &LoadOptions::default(), &Memory::unlimited())
}

/// The same as `options` say and within a budget of memory, from which everything is taken that the scene will need, here and as a
/// [`Scene`](mlt_core::transport::scene::Scene).
pub fn open_within(
    name_or_path: impl AsRef<Path>,
    options: &LoadOptions,
    memory: &Memory,
) -> Result<Loaded, SceneError> {
    open_keeping(name_or_path.as_ref(), options, memory, &mut Kept::default())
}

/// The same with what stays the same at other times in animations.
fn open_keeping(path: &Path, options: &LoadOptions, memory: &Memory, kept: &mut Kept) -> Result<Loaded, SceneError> {
    let name = path.to_string_lossy();
    if path.is_file() || path.extension().is_some() {
        return load_within(path, options, memory, kept);
    }
    let loaded = builtin::read(&name, options, kept).unwrap_or_else(|| match path.exists() {
        true => Err(SceneError::NotAFile { path: path.to_owned() }),
        false => Err(SceneError::NotFound { name: name.into_owned(), hint: missing::hint(path) }),
    });
    let mut loaded = loaded?;
    environment::surround(&mut loaded, &options.environment, memory)?;
    Ok(loaded)
}
