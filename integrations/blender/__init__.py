# SPDX-License-Identifier: MIT
"""Renders Blender's scene with the program `mlt`."""

import bpy

from . import operators, panel, settings

CLASSES = (
    settings.Preferences,
    settings.Settings,
    operators.Render,
    operators.Export,
    panel.Panel,
)


def register():
    for each in CLASSES:
        bpy.utils.register_class(each)
    bpy.types.Scene.mlt = bpy.props.PointerProperty(type=settings.Settings)
    bpy.types.TOPBAR_MT_render.append(panel.render_menu)
    bpy.types.TOPBAR_MT_file_export.append(panel.export_menu)


def unregister():
    bpy.types.TOPBAR_MT_file_export.remove(panel.export_menu)
    bpy.types.TOPBAR_MT_render.remove(panel.render_menu)
    del bpy.types.Scene.mlt
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
