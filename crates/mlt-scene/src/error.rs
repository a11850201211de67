//! Errors of scene files.

use crate::builtin::BUILTIN;
use mlt_core::memory::Shortage;
use std::{io, path::PathBuf};

/// Why a scene was not loaded: one sentence that names the file, the place and the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// Neither a file nor a built-in scene.
    #[error(
        "`{name}` is neither a file nor a built-in scene; {hint}give a .gltf, .glb or .obj file, or one of {}",
        BUILTIN.iter().map(|scene| scene.name).collect::<Vec<_>>().join(", ")
    )]
    NotFound {
        /// As the caller wrote it.
        name: String,
        /// The one that may have been meant.
        hint: String,
    },
    /// No file where a scene file is to be.
    #[error("{path}: there is no such file; {hint}check its name and folder")]
    Missing {
        /// The file.
        path: PathBuf,
        /// The one that may have been meant.
        hint: String,
    },
    /// No scene of the file has the name that was asked for.
    #[error("{path}: there is no scene \"{name}\"; {hint}")]
    NoScene {
        /// The file.
        path: PathBuf,
        /// The name.
        name: String,
        /// The names that there are.
        hint: String,
    },
    /// The operating system refused.
    #[error("{path}: cannot be read ({cause}); check that it exists and may be read")]
    Read {
        /// The file.
        path: PathBuf,
        /// The operating system's error.
        cause: io::Error,
    },
    /// A folder, a device or a pipe.
    #[error("{path}: not a regular file; name a file and no folder or device")]
    NotAFile {
        /// The path.
        path: PathBuf,
    },
    /// An extension that no loader knows.
    #[error("{path}: the format is not known by its extension; convert the scene to .gltf, .glb or .obj")]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// A file of light from all around whose extension no decoder knows.
    #[error("{path}: no image of an environment by its extension; give an .hdr or .exr file")]
    NoEnvironment {
        /// The file.
        path: PathBuf,
    },
    /// An image does not decode.
    #[error("{path}: cannot be read as {format} ({reason}); save the image again")]
    Image {
        /// The file.
        path: PathBuf,
        /// The format that its extension promises.
        format: &'static str,
        /// The decoder's words.
        reason: String,
    },
    /// The file does not parse.
    #[error("{path}: does not parse as {format} ({reason}); export the scene again or repair the file there")]
    Syntax {
        /// The file.
        path: PathBuf,
        /// The format that its extension promises.
        format: &'static str,
        /// The parser's words, with the position where it knows it.
        reason: String,
    },
    /// The file parses, but what it says cannot be.
    #[error("{path}: {place}: {reason}; {remedy}")]
    Invalid {
        /// The file.
        path: PathBuf,
        /// The element at fault.
        place: String,
        /// The fault.
        reason: String,
        /// The remedy.
        remedy: &'static str,
    },
    /// Geometry in an encoding that is not read.
    #[error(
        "{path}: the meshes are compressed by {extension}, which is not supported; export the scene again without \
         compression (in Blender's glTF export: Data > Compression off)"
    )]
    Compressed {
        /// The file.
        path: PathBuf,
        /// The extension's name.
        extension: String,
    },
    /// A reference that leaves the scene's folder.
    #[error(
        "{path}: `{uri}` lies outside of the scene's folder; put the file beside the scene and name it by a relative path"
    )]
    Outside {
        /// The scene file.
        path: PathBuf,
        /// The reference.
        uri: String,
    },
    /// More than this program will try to hold.
    #[error("{path}: {place}: {what} exceed the limit of {limit}; split or simplify the scene")]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// The element at fault.
        place: String,
        /// The thing that there is too much of.
        what: &'static str,
        /// How much is read at most.
        limit: u64,
    },
    /// More memory than there is.
    #[error("{path}: {what} {shortage}; simplify the scene, or render it where more memory is free")]
    Memory {
        /// The file.
        path: PathBuf,
        /// The purpose of the memory.
        what: String,
        /// How much is missing.
        shortage: Shortage,
    },
    /// A parser gave up on the input by panicking.
    #[error(
        "{path}: the parser failed on this file ({reason}); export the scene again, with another program if need be"
    )]
    Parser {
        /// The file.
        path: PathBuf,
        /// The panic's message.
        reason: String,
    },
}
