# SPDX-License-Identifier: MIT
"""The operators: rendering the scene, and exporting it to be rendered elsewhere."""

import shlex
import tempfile
from pathlib import Path

import bpy
from bpy.props import BoolProperty, StringProperty
from bpy_extras.io_utils import ExportHelper

from . import command, show, world
from .export import export
from .process import Process


class Render(bpy.types.Operator):
    """Render the scene with mlt"""

    bl_idname = "mlt.render"
    bl_label = "Render with mlt"

    filepath: StringProperty(
        name="Image", description="The .exr file to write; a temporary one if not given", subtype="FILE_PATH", options={"SKIP_SAVE"}
    )

    # The run of the operator that the user has started, for the panel.
    running = None

    @classmethod
    def poll(cls, _context):
        return cls.running is None

    def execute(self, context):
        """Renders and waits."""
        if not self.begin(context):
            return {"CANCELLED"}
        self.process.wait()
        return self.end(context)

    def invoke(self, context, _event):
        """Renders while the user works on; Escape ends it early."""
        if not self.begin(context):
            return {"CANCELLED"}
        Render.running = self.process
        self.timer = context.window_manager.event_timer_add(0.25, window=context.window)
        context.window_manager.progress_begin(0.0, 1.0)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self.process.stop()
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        context.window_manager.progress_update(self.process.share)
        show.redraw(context)
        if not self.process.is_done():
            return {"PASS_THROUGH"}
        Render.running = None
        context.window_manager.event_timer_remove(self.timer)
        context.window_manager.progress_end()
        return self.end(context)

    def begin(self, context):
        """Exports the scene and starts mlt; returns whether it runs."""
        folder = Path(tempfile.mkdtemp(prefix="mlt-", dir=bpy.app.tempdir))
        self.image = Path(bpy.path.abspath(self.filepath)) if self.filepath else folder / "mlt.exr"
        scene = folder / "scene.glb"
        try:
            program = command.program(context)
            warn(self, export(context, scene))
            line = [program, *command.words(context, scene, world.options(context.scene, folder), self.image)]
            self.process = Process(line)
        except (OSError, RuntimeError, ValueError) as error:
            self.report({"ERROR"}, str(error))
            return False
        return True

    def end(self, context):
        """Reports what mlt said and shows its image."""
        code = self.process.wait()
        failed = [message for message in self.process.messages if message.startswith("error: ")]
        warn(self, [message.removeprefix("warning: ") for message in self.process.messages if message not in failed])
        if failed or not self.image.is_file():
            self.report({"ERROR"}, "; ".join(message.removeprefix("error: ") for message in failed) or f"mlt ended with code {code} and wrote no image")
            return {"CANCELLED"}
        show.image(context, self.image, packed=not self.filepath)
        return {"FINISHED"}


class Export(bpy.types.Operator, ExportHelper):
    """Write the scene for mlt: with lamps of an area, the lens, and an image of the world beside it where it needs one"""

    bl_idname = "mlt.export"
    bl_label = "Export for mlt"

    filename_ext = ".glb"
    filter_glob: StringProperty(default="*.glb", options={"HIDDEN"})
    animation: BoolProperty(name="Animation", description="Write what moves, for mlt's options of time", default=False)

    def execute(self, context):
        path = Path(self.filepath)
        try:
            warn(self, export(context, path, self.animation))
            beside = world.options(context.scene, path.parent)
        except (RuntimeError, ValueError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        line = ["mlt", *command.words(context, path, beside, path.with_suffix(".exr"))]
        self.report({"INFO"}, f"Written. To render it: {shlex.join(line)}")
        return {"FINISHED"}


def warn(operator, messages):
    """Reports messages."""
    for message in messages:
        operator.report({"WARNING"}, message)
