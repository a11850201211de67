"""Builds one scene, exports it twice and renders it by Cycles: `make.py NAME FOLDER`."""

import sys
from pathlib import Path

import bpy

import scenes

SIZE = 96


def empty():
    """A scene without anything in it; the exporter takes the camera's angle from the image's shape."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.resolution_x = bpy.context.scene.render.resolution_y = SIZE


def export(path, **settings):
    """Writes a binary glTF file."""
    bpy.ops.export_scene.gltf(filepath=str(path), export_format="GLB", **settings)


def render(path, samples):
    """Renders by Cycles: box filter, nothing clamped, no shortcut taken, linear."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.filepath = str(path)
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    cycles = scene.cycles
    cycles.samples = samples
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.pixel_filter_type = "BOX"
    cycles.blur_glossy = cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = 64
    cycles.transmission_bounces = cycles.transparent_max_bounces = 64
    bpy.ops.render.render(write_still=True)


def main():
    name, folder = sys.argv[1], Path(sys.argv[2])
    case = next(case for case in scenes.CASES if case.name == name)
    empty()
    options = case.build() or []
    export(folder / f"{name}.default.glb")
    export(folder / f"{name}.glb", export_cameras=True, export_lights=True, export_extras=True, export_apply=True)
    (folder / f"{name}.options").write_text("\n".join(options))
    render(folder / f"{name}.cycles.exr", case.samples)


if __name__ == "__main__":
    main()
