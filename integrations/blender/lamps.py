# SPDX-License-Identifier: MIT
"""Lamps: what glTF's exporter leaves out of them."""

import math

import bpy
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Vector

from .for_now import change, keep, tag

# Corners of the polygon that stands for a disc, which has the disc's area.
CORNERS = 64


def prepare(later, scene):
    """Makes the scene's lamps such that the exporter writes all of them; returns warnings."""
    warnings = []
    for lamp in [each for each in scene.objects if each.type == "LIGHT" and not each.hide_render]:
        sizes(later, lamp.data)
        temperature(later, lamp.data)
        if lamp.data.type == "AREA":
            area(later, lamp)
        warnings += differences(scene, lamp)
    return warnings


def sizes(later, light):
    """Angle of a sun, radius of a point or spot, which glTF's lights do not have."""
    if light.type == "SUN":
        tag(later, light, "angle", light.angle)
    elif light.type in {"POINT", "SPOT"}:
        tag(later, light, "shadow_soft_size", light.shadow_soft_size)


def temperature(later, light):
    """A colour temperature becomes part of the colour. The exporter would multiply the lamp's own colour by it, at each export."""
    if getattr(light, "use_temperature", False):
        change(later, light, "color", [a * b for a, b in zip(light.color, light.temperature_color)])
        change(later, light, "use_temperature", False)


def area(later, lamp):
    """Hangs a mesh of the lamp's shape and power on it."""
    mesh = keep(later, bpy.data.meshes, bpy.data.meshes.new(lamp.name))
    corners = outline(lamp.data)
    mesh.from_pydata([(x, y, 0.0) for x, y in corners], [], [range(len(corners))])
    mesh.materials.append(emitter(later, lamp))
    made = keep(later, bpy.data.objects, bpy.data.objects.new(lamp.name, mesh))
    made.parent = lamp
    for collection in lamp.users_collection:
        collection.objects.link(made)


def outline(light):
    """Corners of an area lamp, in its own coordinates, clockwise as seen from +z, since it shines along −z."""
    width, height = light.size, light.size
    if light.shape in {"RECTANGLE", "ELLIPSE"}:
        height = light.size_y
    if light.shape in {"SQUARE", "RECTANGLE"}:
        return [(0.5 * width * x, 0.5 * height * y) for x, y in ((-1, -1), (-1, 1), (1, 1), (1, -1))]
    step = 2.0 * math.pi / CORNERS
    radius = 0.5 * math.sqrt(step / math.sin(step))
    return [(radius * width * math.cos(i * step), -radius * height * math.sin(i * step)) for i in range(CORNERS)]


def emitter(later, lamp):
    """A black, one-sided material of the lamp's radiance."""
    material = keep(later, bpy.data.materials, bpy.data.materials.new(lamp.name))
    if not material.node_tree:
        material.use_nodes = True
    material.use_backface_culling = True
    inputs = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED").inputs
    inputs["Base Color"].default_value = (0.0, 0.0, 0.0, 1.0)
    inputs["Specular IOR Level"].default_value = 0.0
    inputs["Roughness"].default_value = 1.0
    inputs["Emission Color"].default_value = (*lamp.data.color, 1.0)
    inputs["Emission Strength"].default_value = radiance(lamp)
    return material


def radiance(lamp):
    """Φ/(π A) of a lamp of Φ watts, in W/(m² sr), before its colour."""
    light = lamp.data
    power = light.energy * 2.0 ** getattr(light, "exposure", 0.0)
    if not getattr(light, "normalize", True):
        return power / math.pi
    corners = [lamp.matrix_world.to_3x3() @ Vector((x, y, 0.0)) for x, y in outline(light)]
    turns = (a.cross(b) for a, b in zip(corners, corners[1:] + corners[:1]))
    size = 0.5 * sum(turns, Vector((0.0, 0.0, 0.0))).length
    return power / (math.pi * size) if size > 0.0 else 0.0


def differences(scene, lamp):
    """What of a lamp comes out otherwise than in Blender."""
    light = lamp.data
    if light.type == "AREA" and light.spread < 3.14:
        yield f"{lamp.name}: its spread is not exported; the lamp shines to all sides of its front"
    if light.type == "AREA" and light.use_nodes:
        yield f"{lamp.name}: its nodes are not exported; the lamp has its plain colour and power"
    if is_in_picture(scene, lamp):
        yield f"{lamp.name}: the lamp is in the picture, where mlt shows it; Blender hides lamps from the camera"


def is_in_picture(scene, lamp):
    """Whether the camera looks at a lamp that has an extent."""
    light = lamp.data
    if light.type == "SUN" or (light.type != "AREA" and light.shadow_soft_size == 0.0):
        return False
    corners = outline(light) if light.type == "AREA" else [(0.0, 0.0)]
    places = [world_to_camera_view(scene, scene.camera, lamp.matrix_world @ Vector((x, y, 0.0))) for x, y in corners]
    return any(0.0 < at.x < 1.0 and 0.0 < at.y < 1.0 and at.z > 0.0 for at in places)
