//! One part of a render on a farm, or one frame.
//!
//! It may be run again, by a scheduler that lost it, and in two places at once: a file appears whole or not at all, its bits are the same
//! whoever makes it, and a checkpoint of whichever copy is as good a start as any.

use std::{fs, path::Path};

use anyhow::{Context, anyhow};

use super::job::{check_words, options_of, parts_folder};
use crate::{
    Failure,
    args::{
        farm::TaskOptions,
        kept::{KeptOptions, Shard},
        render::RenderOptions,
    },
    kept,
    output::{Format, OutputFile},
    print, render,
};

/// Makes a part or a frame.
pub(super) fn run(options: &TaskOptions) -> Result<(), Failure> {
    let render = options_of(options.shard, &options.render)?;
    check_words(&render)?;
    let folder = parts_folder(&options.render, &render);
    fs::create_dir_all(&folder).with_context(|| format!("{}: cannot be made", folder.display()))?;
    match (options.shard, options.frame) {
        (Some(shard), _) => part(shard, render, &folder),
        (None, Some(number)) => frame(number, &render, &folder),
        (None, None) => Ok(()),
    }
}

/// Makes the part, unless it is there.
fn part(shard: Shard, mut render: RenderOptions, folder: &Path) -> Result<(), Failure> {
    let file = |kind: &str| folder.join(format!("{kind}-{}.mltp", shard.number()));
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

/// Makes a frame's images from the sums that are kept of it, as far as they are there.
fn frame(number: u32, render: &RenderOptions, folder: &Path) -> Result<(), Failure> {
    if !render.frames.frames.as_ref().is_some_and(|frames| frames.0.contains(&number)) {
        return Err(Failure::Usage(anyhow!("--frame {number}: it is none of the render's --frames")));
    }
    let mut render = render.of_frame(number);
    let sums = folder.join(format!("frame-{number}.mltp"));
    render.keeping.checkpoint = Some(sums.clone());
    render.check()?;
    render::go_on(&render, kept::if_whole(&sums))
}

/// Whether the part holds all its rounds. One of another render is refused.
fn is_done(options: &RenderOptions, part: &Path) -> Result<bool, Failure> {
    kept::if_whole(part).map_or(Ok(false), |kept| render::is_done(options, &kept))
}
