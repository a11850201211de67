# SPDX-License-Identifier: MIT
"""What the user chooses: the program in the preferences, the rest in each scene."""

import bpy
from bpy.props import EnumProperty, FloatProperty, IntProperty, StringProperty


class Preferences(bpy.types.AddonPreferences):
    """Where the program is."""

    bl_idname = __package__

    program: StringProperty(
        name="mlt",
        description="The program mlt; looked for on PATH and in ~/.cargo/bin if not given",
        subtype="FILE_PATH",
    )

    def draw(self, _context):
        self.layout.prop(self, "program")


class Settings(bpy.types.PropertyGroup):
    """Options of `mlt render`."""

    limit: EnumProperty(
        name="Until",
        description="What ends the render",
        items=(
            ("ERROR", "Error", "Stop when the estimated relative error is this"),
            ("TIME", "Time", "Stop after this time"),
            ("SAMPLES", "Samples", "Stop after this many samples per pixel"),
        ),
    )
    error: FloatProperty(name="Error", description="Relative error", subtype="PERCENTAGE", default=2.0, min=0.01, max=100.0)
    seconds: IntProperty(name="Seconds", description="Time, in seconds", default=60, min=1)
    samples: IntProperty(name="Samples", description="Samples per pixel", default=256, min=1)
    method: EnumProperty(
        name="Method",
        description="How light is computed",
        items=(
            ("auto", "Automatic", "Independent samples where they are better, Metropolis where it pays"),
            ("mlt", "Metropolis", "Stratified Metropolis light transport: light that is hard to find"),
            ("bdpt", "Bidirectional", "Bidirectional path tracing: a second opinion"),
            ("pt", "Path tracing", "Light that is easy to find"),
            ("pssmlt", "Primary sample space", "Metropolis over random numbers of bidirectional samples"),
            ("mmlt", "Multiplexed", "Metropolis over random numbers of single paths"),
        ),
    )
    threads: IntProperty(name="Threads", description="0 for all processors", default=0, min=0)
    seed: IntProperty(name="Seed", description="Same seed, same image", default=0, min=0)
    world_width: IntProperty(
        name="World",
        description="Width in pixels of the image of a world that is neither one colour nor an image file",
        default=2048,
        min=16,
        max=16384,
    )
