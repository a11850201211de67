//! A method that is set up, by a pilot or by what one found before.

use anyhow::anyhow;
use mlt_core::engine::{DecodeError, Key, Watch};
use mlt_core::transport::render::{Renderer, Settings};
use mlt_core::transport::scene::View;

use crate::{
    Failure,
    args::kept::KeptOptions,
    kept::{Kept, pilot::Pilot},
    warn,
};

/// The renderer of a view, whose rounds have this key. The pilot's outcome is taken from rounds that the render goes on from, or from the
/// file that was named; if there is no such file yet, it is written.
pub(super) fn renderer<'a>(
    view: View<'a>,
    settings: Settings,
    (kept, options): (Option<&Kept>, &KeptOptions),
    key: &Key,
    watch: Watch,
) -> Result<Renderer<'a>, Failure> {
    if let Some((kept, found)) = kept.and_then(|kept| Some((kept, kept.pilot.as_ref()?))) {
        return Renderer::following(view, settings, found).map_err(|error| unfit(&kept.path.display(), error));
    }
    let known = options.pilot.as_ref().map(|path| Pilot::of(path, key)).transpose()?.flatten();
    if let Some(pilot) = known {
        let renderer = Renderer::following(view, settings, &pilot.found);
        return renderer.map_err(|error| unfit(&pilot.path.display(), error));
    }
    let renderer = Renderer::watched(view, settings, watch).ok_or_else(Failure::too_early)?;
    if let (Some(path), Some(found)) = (&options.pilot, renderer.pilot()) {
        // The next part has to run the pilot again; this one does not need the file.
        let written = Pilot { path: path.clone(), key: key.clone(), found }.write();
        written.unwrap_or_else(|error| warn(&format!("{error:#}; the render goes on")));
    }
    Ok(renderer)
}

fn unfit(file: &dyn std::fmt::Display, error: DecodeError) -> Failure {
    Failure::Usage(anyhow!("{file}: what its pilot found is not of this render: {error}"))
}
