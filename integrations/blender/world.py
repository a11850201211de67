# SPDX-License-Identifier: MIT
"""The world, as options of `mlt`: one colour, the image file that it shows, or else an image of it that Cycles makes."""

import math
from contextlib import ExitStack
from pathlib import Path

import bpy

from .for_now import keep

SAMPLES = 16


def options(scene, folder):
    """Options of `mlt render` that say what the scene's world is; an image of it may be written into the folder."""
    background = [] if is_seen(scene) else ["--background=black"]
    world = scene.world
    if world is None:
        return ["--environment=none"]
    colour = plain(world)
    if colour is not None:
        return ["--environment=" + ",".join(f"{c:.9g}" for c in colour), *background]
    return (shown(world) or [f"--environment={baked(scene, folder)}"]) + background


def is_seen(scene):
    """Whether the camera sees the world."""
    rays = getattr(scene.world, "cycles_visibility", None)
    return not scene.render.film_transparent and getattr(rays, "camera", True)


def plain(world):
    """The world's radiance if it is the same from everywhere."""
    if not world.use_nodes:
        return world.color
    inputs = background(world)
    if inputs is None or inputs["Color"].is_linked or inputs["Strength"].is_linked:
        return None
    return [inputs["Strength"].default_value * c for c in inputs["Color"].default_value[:3]]


def background(world):
    """Inputs of the Background node that is all of the world, if one is."""
    outputs = [node for node in world.node_tree.nodes if node.type == "OUTPUT_WORLD" and node.is_active_output]
    node = source(outputs[0].inputs["Surface"], "BACKGROUND") if outputs else None
    return node and node.inputs


def source(socket, kind):
    """The node that an input is linked to, if it is of this kind."""
    node = socket.links[0].from_node if socket.is_linked else None
    return node if node and node.type == kind else None


def shown(world):
    """Options for a world that is an image file as it is, turned about the vertical at most."""
    inputs = background(world)
    node = inputs and not inputs["Strength"].is_linked and source(inputs["Color"], "TEX_ENVIRONMENT")
    path = node and file(node)
    degrees = node and rotation(node.inputs["Vector"])
    if not path or degrees is None:
        return None
    strength = inputs["Strength"].default_value
    return [f"--environment={path}", f"--environment-rotation={degrees:.6g}", f"--environment-strength={strength:.9g}"]


def file(node):
    """The file of a linear, equirectangular image."""
    image = node.image
    if node.projection != "EQUIRECTANGULAR" or image is None or image.source != "FILE" or image.packed_file:
        return None
    if image.colorspace_settings.name not in {"Linear Rec.709", "Non-Color"}:
        return None
    path = Path(bpy.path.abspath(image.filepath, library=image.library))
    return path if path.suffix.lower() in {".hdr", ".exr"} and path.is_file() else None


def rotation(vector):
    """Degrees by which an image is turned, anticlockwise as seen from above; None for any other map of directions."""
    if not vector.is_linked:
        return 0.0
    node = source(vector, "MAPPING")
    if node is None or node.vector_type not in {"POINT", "TEXTURE"}:
        return None
    inputs = node.inputs
    origin = source(inputs["Vector"], "TEX_COORD")
    if origin is None or inputs["Vector"].links[0].from_socket.name != "Generated":
        return None
    if any(inputs[name].is_linked for name in ("Location", "Rotation", "Scale")):
        return None
    x, y, z = inputs["Rotation"].default_value
    if any(inputs["Location"].default_value) or tuple(inputs["Scale"].default_value) != (1.0, 1.0, 1.0) or x or y:
        return None
    # A point's map turns the directions that look the image up, a texture's the image.
    return math.degrees(z if node.vector_type == "TEXTURE" else -z)


def baked(scene, folder):
    """An image of the world in all directions, by Cycles: +x in its middle."""
    path = Path(folder) / "world.exr"
    with ExitStack() as later:
        studio = keep(later, bpy.data.scenes, bpy.data.scenes.new("mlt world"))
        lens = keep(later, bpy.data.cameras, bpy.data.cameras.new("mlt world"))
        camera = keep(later, bpy.data.objects, bpy.data.objects.new("mlt world", lens))
        studio.collection.objects.link(camera)
        studio.camera, studio.world = camera, scene.world
        camera.rotation_euler = (0.5 * math.pi, 0.0, -0.5 * math.pi)
        lens.type = "PANO"
        panorama = lens if hasattr(lens, "panorama_type") else lens.cycles
        panorama.panorama_type = "EQUIRECTANGULAR"
        studio.frame_set(scene.frame_current)
        picture(studio, scene.mlt.world_width, path)
        bpy.ops.render.render(scene=studio.name, write_still=True)
    return path


def picture(studio, width, path):
    """Settings of Cycles for a linear image as it is."""
    studio.render.engine = "CYCLES"
    studio.cycles.samples = SAMPLES
    studio.cycles.use_adaptive_sampling = studio.cycles.use_denoising = False
    studio.cycles.pixel_filter_type = "BOX"
    studio.render.resolution_x, studio.render.resolution_y = width, width // 2
    studio.render.filepath = str(path)
    studio.render.image_settings.file_format = "OPEN_EXR"
    studio.render.image_settings.color_depth = "32"
