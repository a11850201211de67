# SPDX-License-Identifier: MIT
"""Writes the scene as a glTF file that has all that `mlt` reads."""

from contextlib import ExitStack

import bpy

from . import lamps, lens
from .for_now import change


def export(context, path, animation=False):
    """Writes a binary glTF file of the scene that is active; returns warnings.

    Without animation meshes are as they stand in this frame, with all modifiers; with it skins and morph targets move in `mlt`.
    """
    if not hasattr(bpy.types, "EXPORT_SCENE_OT_gltf"):
        raise ValueError("enable the add-on glTF 2.0 format: it writes the scene")
    scene = context.scene
    context.view_layer.update()
    with ExitStack() as later:
        warnings = lens.prepare(later, scene) + lamps.prepare(later, scene)
        as_rendered(later, scene)
        bpy.ops.export_scene.gltf(
            filepath=str(path),
            export_format="GLB",
            use_active_scene=True,
            use_renderable=True,
            export_cameras=True,
            export_lights=True,
            export_import_convert_lighting_mode="SPEC",
            export_extras=True,
            export_apply=not animation,
            export_skins=animation,
            export_morph=True,
            export_animations=animation,
            export_current_frame=not animation,
        )
    return warnings


def as_rendered(later, scene):
    """Modifiers as they are rendered: the exporter takes what the viewport shows."""
    for each in scene.objects:
        for modifier in each.modifiers:
            change(later, modifier, "show_viewport", modifier.show_render)
            if hasattr(modifier, "levels") and hasattr(modifier, "render_levels"):
                change(later, modifier, "levels", modifier.render_levels)
