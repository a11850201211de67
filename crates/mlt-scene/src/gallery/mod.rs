//! Hard scenes, made by code: what light transport methods are known to fail at, each small enough to be rendered many
//! times over.
//!
//! The files below `scenes/stability`, `scenes/door-ajar` and `scenes/lights-200` are what [`HardScene::write`] writes; one
//! that is large is not stored.

mod document;
mod rooms;
mod shapes;
mod surfaces;

pub(crate) use document::Shape;
pub(crate) use shapes::ball;

use document::Document;
use std::{
    fs, io,
    path::{Path, PathBuf},
};

/// Right outcome of rendering a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RightOutcome {
    /// An image.
    Image,
    /// A black image.
    Black,
    /// An error, since there is nothing to see by.
    Refused,
}

/// A scene of the gallery.
#[derive(Clone, Copy, Debug)]
pub struct HardScene {
    /// Its name, which is its folder's.
    pub name: &'static str,
    /// The difficulty, in a few words.
    pub stresses: &'static str,
    /// The right outcome.
    pub outcome: RightOutcome,
    /// The folder that keeps it, from the root of the repository; `None`: too large to be kept.
    pub folder: Option<&'static str>,
    files: fn() -> Vec<(&'static str, Vec<u8>)>,
}

impl HardScene {
    /// Its files, the scene file first.
    pub fn files(&self) -> Vec<(&'static str, Vec<u8>)> {
        (self.files)()
    }

    /// Writes its files into a folder, which has to exist; gives the scene file's path.
    pub fn write(&self, folder: &Path) -> io::Result<PathBuf> {
        let files = self.files();
        for (name, content) in &files {
            fs::write(folder.join(name), content)?;
        }
        Ok(folder.join(files.first().map_or("", |(name, _)| name)))
    }
}

/// The scene of that name.
pub fn find(name: &str) -> Option<&'static HardScene> {
    SCENES.iter().find(|scene| scene.name == name)
}

fn one(document: Document) -> Vec<(&'static str, Vec<u8>)> {
    vec![("scene.gltf", document.text().into_bytes())]
}

macro_rules! scene {
    ($name:literal, $stresses:literal, $make:expr) => {
        scene!($name, $stresses, $make, RightOutcome::Image)
    };
    ($name:literal, $stresses:literal, $make:expr, $outcome:expr) => {
        HardScene {
            name: $name,
            stresses: $stresses,
            outcome: $outcome,
            folder: Some(concat!("scenes/stability/", $name)),
            files: || one($make),
        }
    };
}

/// All scenes, the ordinary one first.
pub const SCENES: &[HardScene] = &[
    scene!("plain", "nothing: the control", surfaces::plain()),
    scene!("islands", "chains that never cross from one keyhole to the other", rooms::islands()),
    HardScene {
        name: "door-ajar",
        stresses: "all light comes through a gap of 2.7 cm",
        outcome: RightOutcome::Image,
        folder: Some("scenes/door-ajar"),
        files: || vec![("door-ajar.gltf", rooms::door_ajar().text().into_bytes())],
    },
    HardScene {
        name: "caustic",
        stresses: "light gathered by a ball of glass",
        outcome: RightOutcome::Image,
        folder: Some("scenes/caustic"),
        files: || {
            vec![
                ("caustic.gltf", include_bytes!("../../scenes/caustic/caustic.gltf").to_vec()),
                ("caustic.bin", include_bytes!("../../scenes/caustic/caustic.bin").to_vec()),
            ]
        },
    },
    scene!("window", "a room lit by the sky through its window", rooms::window()),
    scene!("pool", "light that goes through the water both ways", rooms::pool()),
    scene!("occluded", "a sealed light a million times as strong as the one seen", rooms::occluded()),
    HardScene {
        name: "confetti",
        stresses: "100,000 emissive triangles",
        outcome: RightOutcome::Image,
        folder: None,
        files: || one(rooms::confetti()),
    },
    HardScene {
        name: "lights-200",
        stresses: "200 lights, powers from 1 to 500",
        outcome: RightOutcome::Image,
        folder: Some("scenes/lights-200"),
        files: || vec![("lights-200.gltf", rooms::lights_200().text().into_bytes())],
    },
    scene!("gloss", "metals of roughness 0.05 to 0.001", surfaces::gloss()),
    scene!("touching", "lights that touch the walls", surfaces::touching()),
    scene!("tiny-and-huge", "a light a millionth of the room, a sky a thousand times it", surfaces::tiny_and_huge()),
    scene!("duct", "no path of fewer than 12 edges", rooms::duct()),
    scene!("scale-small", "the control in units of 10^-4", surfaces::scaled(1e-4)),
    scene!("scale-large", "the control in units of 10^5", surfaces::scaled(1e5)),
    scene!("offset", "the control, 10^5 of its sizes from the origin", surfaces::moved(1e5)),
    scene!("broken", "the control in slivers, doubled, inside out", surfaces::broken()),
    scene!("camera-in-glass", "the camera is inside a ball of glass", rooms::camera_in_glass()),
    scene!("camera-on-light", "the camera is on the lamp", surfaces::camera_on_light()),
    scene!("camera-sees-nothing", "the camera is turned away", surfaces::camera_sees_nothing(), RightOutcome::Black),
    scene!("no-light", "no light", surfaces::no_light(), RightOutcome::Refused),
];
