# SPDX-License-Identifier: MIT
"""Shows images and progress."""

import bpy

NAME = "mlt"


def image(context, path, packed):
    """Loads an image as the data block `mlt`, kept in the .blend file if so wished, and shows it in an image editor."""
    made = bpy.data.images.get(NAME)
    if made is None:
        made = bpy.data.images.load(str(path))
        made.name = NAME
    else:
        if made.packed_file:
            made.unpack(method="REMOVE")
        made.filepath = str(path)
        made.reload()
    made.use_view_as_render = True
    if packed:
        made.pack()
    if not bpy.app.background:
        editor(context).image = made


def editor(context):
    """An image editor that is open, or the one that Blender shows renders in."""
    find = lambda: (area for window in context.window_manager.windows for area in window.screen.areas if area.type == "IMAGE_EDITOR")
    if next(find(), None) is None:
        bpy.ops.render.view_show("INVOKE_DEFAULT")
    return next(find()).spaces.active


def redraw(context):
    """Draws the panels again that show how far a render is."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "PROPERTIES":
                area.tag_redraw()
