"""Renders scenes by Blender's extension, which is installed from its zip: `extension.py MLT FOLDER`.

Each image has to have the bits of the one that `mlt` makes of the exported file with the same options, written here by hand, and has to look as
Cycles shows the scene, by the measure of compare.py. As a control, an image without what the exporter drops must not.
"""

import json
import math
import subprocess
import sys
import time
from pathlib import Path

import bpy
import numpy as np
import OpenEXR

import make
import scenes
from compare import difference, luminance

SIZE, SAMPLES = 48, 128
SOURCE = Path(__file__).parents[2] / "integrations" / "blender"
BOUND = 0.02


def zipped(folder):
    """The extension's zip, built and checked by Blender's own program, which `blender --command extension build` is."""
    import bl_pkg

    builder = Path(bl_pkg.__file__).parent / "cli" / "blender_ext.py"
    command = [sys.executable, builder, "build", "--source-dir", SOURCE, "--output-filepath", folder / "mlt.zip"]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return folder / "mlt.zip"


def install(archive, program):
    """Installs the extension, and tells it where the program is."""
    bpy.ops.extensions.package_install_files(filepath=str(archive), repo="user_default", enable_on_install=True)
    bpy.context.preferences.addons["bl_ext.user_default.mlt"].preferences.program = str(program)


def lamp_and_lens():
    """An area lamp that is stretched and coloured by its temperature, a world of one colour, a camera in focus on an object."""
    scenes.floor()
    for i, at in enumerate([(-1.5, -2, 0.7), (0, 0, 0.7), (1.5, 3, 0.7)]):
        scenes.ball(scenes.material("ball", Base_Color=(0.2 + 0.3 * i, 0.4, 0.8 - 0.3 * i)), at=at, radius=0.7)
    target = bpy.context.object
    lamp = scenes.lamp("AREA", 250, at=(2, -2, 4), shape="ELLIPSE", size=1.0, size_y=2.0, use_temperature=True, temperature=3000)
    lamp.scale = (2.0, 1.0, 1.0)
    lens = scenes.camera().data.dof
    lens.use_dof, lens.focus_object, lens.aperture_fstop = True, target, 0.2
    return scenes.world((0.3, 0.4, 0.5), 0.5)


def image_of_the_world(folder):
    """A world that is an image file, turned."""
    scenes.floor(), scenes.camera()
    scenes.ball(scenes.material("metal", Base_Color=(0.9, 0.9, 0.9), Metallic=1.0, Roughness=0.3))
    x, y = np.meshgrid(np.linspace(0, 1, 64), np.linspace(1, 0, 32))
    channels = {"R": 4 * x**4, "G": y, "B": 1 - x}
    picture = folder / "sky.exr"
    OpenEXR.File({}, {name: values.astype(np.float32) for name, values in channels.items()}).write(str(picture))
    scenes.world()
    nodes = bpy.context.scene.world.node_tree
    sky, turn, origin = (nodes.nodes.new(f"ShaderNode{kind}") for kind in ("TexEnvironment", "Mapping", "TexCoord"))
    sky.image = bpy.data.images.load(str(picture))
    turn.inputs["Rotation"].default_value = (0.0, 0.0, math.radians(50))
    nodes.links.new(origin.outputs["Generated"], turn.inputs["Vector"])
    nodes.links.new(turn.outputs["Vector"], sky.inputs["Vector"])
    nodes.links.new(sky.outputs["Color"], nodes.nodes["Background"].inputs["Color"])
    nodes.nodes["Background"].inputs["Strength"].default_value = 0.5
    return [f"--environment={picture}", "--environment-rotation=-50", "--environment-strength=0.5"]


def world_of_nodes(folder):
    """A world that only Blender can compute, and modifiers that are stronger in renders."""
    scenes.floor(), scenes.camera()
    box = scenes.box(scenes.material("soft", Base_Color=(0.6, 0.6, 0.2)))
    smooth = box.modifiers.new("smooth", "SUBSURF")
    smooth.levels, smooth.render_levels = 0, 3
    scenes.world()
    nodes = bpy.context.scene.world.node_tree
    sky, origin = (nodes.nodes.new(f"ShaderNode{kind}") for kind in ("TexGradient", "TexCoord"))
    nodes.links.new(origin.outputs["Generated"], sky.inputs["Vector"])
    nodes.links.new(sky.outputs["Color"], nodes.nodes["Background"].inputs["Color"])
    bpy.context.scene.mlt.world_width = 64
    return [f"--environment={folder / 'world.exr'}"]


def settings():
    """A small image and few samples."""
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 2 * SIZE, 2 * SIZE
    scene.render.resolution_percentage = 50
    scene.mlt.limit, scene.mlt.samples, scene.mlt.method, scene.mlt.threads = "SAMPLES", SAMPLES, "pt", 1


def by_program(program, scene, image, *options):
    """An image by the program alone."""
    usual = ["--size", f"{SIZE}x{SIZE}", "--method", "pt", "--samples-per-pixel", str(SAMPLES), "--quiet"]
    subprocess.run([program, "render", scene, *usual, *options, "--force", "-o", image], check=True, stderr=subprocess.DEVNULL)
    return image


def judge(build, program, folder):
    """Renders a scene three times and compares; prints a line; returns whether it is right."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    name = build.__name__
    options = build(folder) if build.__code__.co_argcount else build()
    settings()
    mine, scene = folder / f"{name}.extension.exr", folder / f"{name}.extension.glb"
    before = census()
    bpy.ops.mlt.render(filepath=str(mine))
    bpy.ops.mlt.export(filepath=str(scene))
    tidy = census() == before
    same = np.array_equal(luminance(mine), luminance(by_program(program, scene, folder / f"{name}.cli.exr", *options)))
    shown = is_loaded(bpy.data.images["mlt"])
    make.render(folder / f"{name}.extension.cycles.exr", 128)
    apart, worst, ratio = difference(folder / f"{name}.extension.cycles.exr", mine)
    bare = by_program(program, scene, folder / f"{name}.bare.exr", "--aperture=0", "--environment=0.1,0.1,0.1")
    control = difference(folder / f"{name}.extension.cycles.exr", bare)[0] > BOUND
    right = tidy and same and shown and control and apart <= BOUND
    print(f"{name:20} {'right' if right else 'WRONG':6} {100 * apart:5.2f} %, worst {100 * worst:5.2f} %, mean x {ratio:.4f};", end=" ")
    print(f"same bits {same}, as it was {tidy}, loaded {shown}, control {control}", flush=True)
    return right


def census():
    """What is in Blender's data, and what the extension changes for a while."""
    data = bpy.data
    counted = [len(kind) for kind in (data.objects, data.meshes, data.materials, data.cameras, data.scenes, data.worlds)]
    lights = [(tuple(light.color), sorted(light.keys())) for light in data.lights]
    return counted, lights, [sorted(camera.keys()) for camera in data.cameras]


def is_loaded(image):
    """Whether Blender reads an image's file, and its error bars as a layer; it does when pixels are asked for, of which layered images have none."""
    return len(image.pixels) == 0 and image.type == "MULTILAYER"


def sizes_are_written(folder):
    """A sun has its angle in the exported file, a point its radius, and neither has it in Blender's scene."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scenes.camera(), scenes.lamp("SUN", 1.0, angle=0.2), scenes.lamp("POINT", 1.0, shadow_soft_size=0.5)
    bpy.ops.mlt.export(filepath=str(folder / "sizes.glb"))
    data = (folder / "sizes.glb").read_bytes()
    told = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])
    lights = {light["name"]: light["extras"] for light in told["extensions"]["KHR_lights_punctual"]["lights"]}
    found = [round(lights["sun"]["angle"], 6), round(lights["point"]["shadow_soft_size"], 6)]
    return found == [0.2, 0.5] and not any(light.keys() for light in bpy.data.lights)


def a_stopped_render_has_an_image(program, folder):
    """A run that is ended early tells how far it is, and writes the image as far as it has come."""
    from bl_ext.user_default.mlt.process import Process

    image = folder / "stopped.exr"
    image.unlink(missing_ok=True)
    run = Process([program, "render", "cornell", "--size=16x16", "--threads=1", "--method=pt", "--time=10m", f"--output={image}"])
    while not run.progress:
        time.sleep(0.1)
    for _ in ("a key is pressed", "and released"):
        run.stop()
    return run.wait() == 143 and 0.0 <= run.share < 0.1 and image.is_file()


def failure_is_told():
    """A scene without a camera is an error in words."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    try:
        bpy.ops.mlt.render()
    except RuntimeError as error:
        return "no camera" in str(error)
    return False


def main():
    program, folder = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
    make.empty()
    install(zipped(folder), program)
    right = [judge(build, program, folder) for build in (lamp_and_lens, image_of_the_world, world_of_nodes)]
    right += [sizes_are_written(folder), a_stopped_render_has_an_image(program, folder), failure_is_told()]
    print(f"{sum(right)} of {len(right)} checks of the extension are right")
    sys.exit(int(not all(right)))


if __name__ == "__main__":
    main()
