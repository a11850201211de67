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
    if not areas(context, "IMAGE_EDITOR"):
        bpy.ops.render.view_show("INVOKE_DEFAULT")
    return areas(context, "IMAGE_EDITOR")[0].spaces.active


def redraw(context):
    """Draws the panels again that show how far a render is."""
    for area in areas(context, "PROPERTIES"):
        area.tag_redraw()


def areas(context, kind):
    """All areas of a kind, in all windows."""
    return [area for window in context.window_manager.windows for area in window.screen.areas if area.type == kind]
