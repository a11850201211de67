# SPDX-License-Identifier: MIT
"""The command line of `mlt render`."""

import os
import shutil
from pathlib import Path

import bpy


def program(context):
    """The program that the preferences name, or the one that is found."""
    chosen = context.preferences.addons[__package__].preferences.program
    places = os.pathsep.join((os.environ.get("PATH", ""), str(Path.home() / ".cargo" / "bin")))
    found = shutil.which(bpy.path.abspath(chosen) if chosen else "mlt", path=places)
    if found is None:
        raise ValueError(f"{chosen or 'mlt'} is not a program here: name mlt in Preferences > Add-ons > mlt, or put it on PATH")
    return found


def words(context, scene_file, world, image):
    """The words behind `mlt`: a scene's file, options of its world, and the image to write."""
    render, chosen = context.scene.render, context.scene.mlt
    width, height = (max(1, side * render.resolution_percentage // 100) for side in (render.resolution_x, render.resolution_y))
    threads = [f"--threads={chosen.threads}"] if chosen.threads else []
    options = [f"--size={width}x{height}", f"--method={chosen.method}", f"--seed={chosen.seed}", limit(chosen)]
    return ["render", str(scene_file), *options, *threads, *world, f"--output={image}"]


def limit(chosen):
    """The option that says when the render is done."""
    return {
        "ERROR": f"--error={chosen.error:.6g}%",
        "TIME": f"--time={chosen.seconds}s",
        "SAMPLES": f"--samples-per-pixel={chosen.samples}",
    }[chosen.limit]
