# SPDX-License-Identifier: MIT
"""The panel among the render properties, and entries of menus."""

import bpy

from .operators import Export, Render

LIMITS = {"ERROR": "error", "TIME": "seconds", "SAMPLES": "samples"}


class Panel(bpy.types.Panel):
    """Options of mlt"""

    bl_idname = "RENDER_PT_mlt"
    bl_label = "mlt"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, chosen = self.layout, context.scene.mlt
        layout.use_property_split = True
        for name in ("limit", LIMITS[chosen.limit], "method", "threads", "seed", "world_width"):
            layout.prop(chosen, name)
        layout.operator(Render.bl_idname)
        if Render.running:
            layout.progress(factor=Render.running.share, text=Render.running.progress or "Starting")
            layout.label(text="Escape ends it early")


def render_menu(menu, _context):
    menu.layout.operator(Render.bl_idname)


def export_menu(menu, _context):
    menu.layout.operator(Export.bl_idname, text="glTF 2.0 for mlt (.glb)")
