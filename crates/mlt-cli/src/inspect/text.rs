//! The content of a scene, for reading.

use std::fmt;

use mlt_core::memory::Size;

use super::{Inspection, MemoryUse};
use crate::args::written::shell_word;

/// Nodes that the text lists; JSON has them all.
const NODES_SHOWN: usize = 40;

impl fmt::Display for Inspection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { scene, triangles, materials, textures, .. } = self;
        let parts = [(*triangles, "triangle"), (*materials, "material"), (*textures, "texture")];
        writeln!(f, "{scene}: {}\n\nNodes", parts.map(|(count, name)| counted(count, name)).join(", "))?;
        for node in self.nodes.iter().take(NODES_SHOWN) {
            let parts = if node.parts.is_empty() { String::new() } else { format!("  ({})", node.parts.join("; ")) };
            writeln!(f, "{}{}{parts}", "  ".repeat(node.depth + 1), node.name)?;
        }
        match self.nodes.len().saturating_sub(NODES_SHOWN) {
            0 => writeln!(f)?,
            more => writeln!(f, "  and {more} more, which --json lists\n")?,
        }
        self.write_cameras(f)?;
        write!(f, "Lights\n{}\nFeatures (what a scene lacks costs nothing)\n", self.lights)?;
        let widest = self.features.iter().map(|feature| feature.name.chars().count()).max().unwrap_or(0);
        for feature in &self.features {
            let has = if feature.present { "has" } else { "no " };
            writeln!(f, "  {has} {:<widest$}  {}", feature.name, feature.therefore)?;
        }
        let [width, height] = self.size;
        write!(f, "\nMemory at {width}x{height}\n{}\n", self.memory)?;
        if !self.warnings.is_empty() {
            writeln!(f, "Warnings")?;
            self.warnings.iter().try_for_each(|warning| writeln!(f, "  {warning}"))?;
            writeln!(f)?;
        }
        writeln!(f, "Render it:  mlt render {}", shell_word(scene))
    }
}

/// A number of things, as in `1 light` and `2 lights`.
pub(super) fn counted(count: usize, name: &str) -> String {
    format!("{count} {name}{}", if count == 1 { "" } else { "s" })
}

impl Inspection {
    fn write_cameras(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "Cameras")?;
        for camera in &self.cameras {
            writeln!(f, "  \"{}\"  {}", camera.name, camera.lens)?;
        }
        writeln!(f, "  a render takes {}\n", self.camera)
    }
}

impl fmt::Display for MemoryUse {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [geometry, acceleration, textures] =
            [self.geometry, self.acceleration, self.textures].map(|n| Size(n as u64));
        writeln!(f, "  geometry {geometry}, acceleration structure {acceleration}, textures {textures}")?;
        writeln!(
            f,
            "  image {}; all together {} at most, of {}",
            Size(self.image),
            Size(self.peak),
            Size(self.available)
        )
    }
}
