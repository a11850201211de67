//! One part of a render on a farm.
//!
//! It may be run again, by a scheduler that lost it, and in two places at once: a part appears whole or not at all, its bits are the same
//! whoever makes it, and a checkpoint of whichever copy is as good a start as any.

use std::{fs, path::Path};

use anyhow::Context;

use super::job::{check_words, options_of, parts_folder};
use crate::{
    Failure,
    args::{farm::TaskOptions, kept::KeptOptions, render::RenderOptions},
    kept,
    output::{Format, OutputFile},
    print, render,
};

/// Makes the part, unless it is there.
pub(super) fn run(options: &TaskOptions) -> Result<(), Failure> {
    let mut render = options_of(options.shard, &options.render)?;
    check_words(&render)?;
    let folder = parts_folder(&options.render, &render);
    fs::create_dir_all(&folder).with_context(|| format!("{}: cannot be made", folder.display()))?;
    let file = |kind: &str| folder.join(format!("{kind}-{}.mltp", options.shard.number()));
    let (part, checkpoint) = (file("part"), file("checkpoint"));
    render.outputs = vec![OutputFile { path: part.clone(), format: Format::Sums }];
    let (path, pilot) = (Some(checkpoint.clone()), Some(folder.join("pilot.mltp")));
    render.keeping = KeptOptions { checkpoint: path, pilot, ..render.keeping };
    render.check()?;
    if is_done(&render, &part)? {
        return Ok(print(&format!("{} is there and whole\n", part.display()))?);
    }
    render::go_on(&render, kept::if_whole(&checkpoint))?;
    // It is of no use any more, and another copy of the task may have removed it.
    let _ = fs::remove_file(checkpoint);
    Ok(())
}

/// Whether the part holds all its rounds. One of another render is refused.
fn is_done(options: &RenderOptions, part: &Path) -> Result<bool, Failure> {
    kept::if_whole(part).map_or(Ok(false), |kept| render::is_done(options, &kept))
}
