//! Headings that the options stand under in `--help`, in their order.

/// Options of the picture's look.
pub const IMAGE: &str = "Image";
/// Where it is seen from.
pub const CAMERA: &str = "Camera";
/// When the render is done.
pub const BUDGET: &str = "Budget";
/// How light is computed.
pub const METHOD: &str = "Method";
/// Options of the files that are written.
pub const OUTPUT: &str = "Output";
/// Where options come from besides.
pub const OPTIONS: &str = "Options from a file";
/// Options of the scene and its light.
pub const SCENE: &str = "Scene";
/// Many images of what moves.
pub const ANIMATION: &str = "Animation";
/// How files of other programs are read.
pub const FILES: &str = "Files of Blender and other programs";
/// Renders that outlive their process.
pub const PARTS: &str = "Checkpoint and parts";
/// For those who study the methods.
pub const RESEARCH: &str = "Research";
