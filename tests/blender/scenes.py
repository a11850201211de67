"""Scenes as Blender's users build them: one function each, with the bound on how far `mlt` may be from Cycles.

Every scene is built from nothing by a function that `scene` registers. A function may return options of `mlt render` for
what Blender's exporter cannot write.
"""

import math
from dataclasses import dataclass
from typing import Callable

import bpy
import numpy as np

DIFFUSE, GLOSSY, GLASS = 0.01, 0.03, 0.03


@dataclass
class Case:
    """A scene, and how far the images of two right renderers may be apart."""

    name: str
    build: Callable[[], list[str] | None]
    bound: float
    samples: int
    lacks: str


CASES: list[Case] = []


def scene(bound: float, samples: int = 256, lacks: str = ""):
    """Registers a function that builds a scene; `lacks` names what of it `mlt` does not render."""

    def register(build):
        CASES.append(Case(build.__name__, build, bound, samples, lacks))
        return build

    return register


# Parts


def material(name="material", **inputs):
    """A Principled material: matt grey but for the inputs that are named, blanks written as underscores."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    values = {"Base_Color": (0.5, 0.5, 0.5), "Roughness": 1.0, "Specular_IOR_Level": 0.0} | inputs
    for key, value in values.items():
        socket(made, key).default_value = (*value, 1.0) if isinstance(value, tuple) else value
    return made


def socket(made, name):
    """An input of a material's Principled node."""
    return made.node_tree.nodes["Principled BSDF"].inputs[name.replace("_", " ")]


def image(name, pixels, data=False):
    """An image packed into the scene, from an array of height × width × channels in [0, 1], first row at the bottom."""
    height, width, channels = pixels.shape
    made = bpy.data.images.new(name, width, height, alpha=channels == 4, is_data=data)
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :channels] = pixels
    made.pixels.foreach_set(rgba.ravel())
    made.pack()
    return made


def texture(made, pixels, data=False):
    """A texture node of a material, over the mesh's own UVs."""
    node = made.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = image(made.name, pixels, data)
    return node


def link(made, source, target):
    """Joins two sockets of a material."""
    made.node_tree.links.new(source, target)


def checker(first, second, tiles=4, size=512):
    """A chequered image of two colours. Cycles filters colours as they are encoded, glTF asks for linear ones: edges have to be few."""
    index = (np.arange(size) * tiles) // size
    odd = (index[:, None] + index[None, :]) % 2 == 1
    return np.where(odd[..., None], np.float32(second), np.float32(first))


def give(made):
    """Gives the active object a material."""
    bpy.context.object.data.materials.append(made)
    return bpy.context.object


def floor(made=None, size=8):
    """A square floor at height 0."""
    bpy.ops.mesh.primitive_plane_add(size=size)
    return give(made or material("floor"))


def ball(made, at=(0, 0, 1), radius=1.0):
    """A smooth ball."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=radius, location=at)
    bpy.ops.object.shade_smooth()
    return give(made)


def box(made, at=(0, 0, 1), size=1.5):
    """A cube, turned a little."""
    bpy.ops.mesh.primitive_cube_add(size=size, location=at, rotation=(0, 0, 0.5))
    return give(made)


def panel(strength=8.0, at=(0, 0, 5), size=2.0, color=(1.0, 1.0, 1.0)):
    """An emissive square that faces the floor: what stands for an area lamp in glTF."""
    bpy.ops.mesh.primitive_plane_add(size=size, location=at, rotation=(math.pi, 0, 0))
    lamp = material("lamp", Base_Color=(0.0, 0.0, 0.0), Emission_Color=color, Emission_Strength=strength)
    return give(lamp)


def lamp(kind, energy, at=(2, -2, 4), **properties):
    """A lamp of Blender's that looks at the origin."""
    data = bpy.data.lights.new(kind.lower(), kind)
    data.energy = energy
    for key, value in properties.items():
        setattr(data, key, value)
    made = bpy.data.objects.new(kind.lower(), data)
    bpy.context.collection.objects.link(made)
    look(made, at, (0, 0, 0))
    return made


def look(made, at, target):
    """Turns an object's −Z towards a point."""
    from mathutils import Vector

    made.location = at
    made.rotation_euler = (Vector(target) - Vector(at)).to_track_quat("-Z", "Y").to_euler()


def camera(at=(0, -7, 3), target=(0, 0, 0.8), **properties):
    """The scene's camera."""
    data = bpy.data.cameras.new("camera")
    for key, value in properties.items():
        setattr(data, key, value)
    made = bpy.data.objects.new("camera", data)
    bpy.context.collection.objects.link(made)
    look(made, at, target)
    bpy.context.scene.camera = made
    return made


def world(color=(1.0, 1.0, 1.0), strength=1.0):
    """A world of one colour, and the option that tells `mlt` of it."""
    made = bpy.data.worlds.new("world")
    made.use_nodes = True
    background = made.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (*color, 1.0)
    background.inputs["Strength"].default_value = strength
    bpy.context.scene.world = made
    return ["--environment", ",".join(str(strength * c) for c in color)]


# Lights


@scene(DIFFUSE)
def area_lit():
    floor(), panel(), camera()
    ball(material("red", Base_Color=(0.7, 0.1, 0.1)), at=(-1.2, 0, 1))
    box(material("blue", Base_Color=(0.1, 0.2, 0.7)), at=(1.4, 0.3, 0.75))


@scene(DIFFUSE)
def room():
    panel(strength=6.0, at=(0, 0, 3.9), size=1.5), camera(at=(0, -3.6, 2), target=(0, 0, 2), angle=1.4)
    bpy.ops.mesh.primitive_cube_add(size=4, location=(0, 0, 2))
    bpy.ops.object.shade_flat()
    walls = give(material("walls", Base_Color=(0.7, 0.6, 0.5)))
    walls.scale = (1, 2, 1)
    box(material("box", Base_Color=(0.3, 0.7, 0.3)), at=(0.5, 0.5, 0.75))


@scene(DIFFUSE)
def world_of_one_colour():
    floor(), camera()
    ball(material("ball", Base_Color=(0.8, 0.4, 0.2)))
    return world((0.5, 0.7, 1.0), 1.5)


@scene(DIFFUSE)
def point_lamp():
    floor(), camera(), lamp("POINT", 800, shadow_soft_size=0.0)
    ball(material("ball"))


@scene(DIFFUSE)
def point_lamp_with_a_radius():
    floor(), camera()
    # A soft falloff is 1/(d² + r²); a ball's is 1/d².
    data = lamp("POINT", 800, shadow_soft_size=0.5, use_soft_falloff=False).data
    data["shadow_soft_size"] = 0.5
    ball(material("ball"))


@scene(DIFFUSE)
def spot_lamp():
    floor(), camera(), lamp("SPOT", 1500, shadow_soft_size=0.0, spot_size=0.8, spot_blend=0.0)
    ball(material("ball"))


@scene(DIFFUSE)
def spot_lamp_with_a_radius():
    floor(), camera()
    data = lamp("SPOT", 1500, shadow_soft_size=0.5, spot_size=0.8, spot_blend=0.0, use_soft_falloff=False).data
    data["shadow_soft_size"] = 0.5
    ball(material("ball"))


@scene(DIFFUSE)
def sun():
    floor(), camera(), lamp("SUN", 3.0, angle=0.0)
    box(material("box"))


@scene(DIFFUSE)
def sun_with_an_angle():
    floor(), camera()
    data = lamp("SUN", 3.0, angle=0.2).data
    data["angle"] = 0.2
    box(material("box"))


@scene(DIFFUSE)
def sun_and_sky():
    floor(material("ground", Base_Color=(0.3, 0.25, 0.2))), camera(), lamp("SUN", 2.0, angle=0.0)
    ball(material("ball", Base_Color=(0.2, 0.6, 0.3)))
    return world((0.4, 0.6, 1.0), 0.6)


@scene(DIFFUSE)
def textured_emitter():
    floor(), camera()
    screen = material("screen", Base_Color=(0.0, 0.0, 0.0), Emission_Strength=4.0)
    bpy.ops.mesh.primitive_plane_add(size=3, location=(0, 1.5, 1.6), rotation=(math.pi / 2, 0, 0))
    give(screen)
    link(screen, texture(screen, checker((1.0, 0.1, 0.1), (0.0, 0.0, 0.2), 3)).outputs["Color"], socket(screen, "Emission_Color"))
    ball(material("ball"), at=(0, -0.5, 0.6), radius=0.6)


# Surfaces


@scene(GLOSSY)
def rough_metal():
    floor(), camera(), panel()
    ball(material("metal", Base_Color=(0.9, 0.6, 0.3), Metallic=1.0, Roughness=0.4))
    return world((0.3, 0.3, 0.3))


@scene(GLOSSY)
def mirror():
    floor(material("floor", Base_Color=(0.6, 0.2, 0.2))), camera(), panel()
    ball(material("mirror", Base_Color=(0.9, 0.9, 0.9), Metallic=1.0, Roughness=0.0))
    return world((0.3, 0.4, 0.5))


@scene(GLOSSY)
def plastic():
    floor(), camera(), panel()
    ball(material("plastic", Base_Color=(0.1, 0.3, 0.7), Roughness=0.3, Specular_IOR_Level=0.5))
    return world((0.3, 0.3, 0.3))


@scene(GLOSSY)
def default_material():
    floor(), camera(), panel()
    box(bpy.data.materials.new("default"))
    bpy.context.object.data.materials[0].use_nodes = True
    return world((0.05, 0.05, 0.05))


@scene(GLOSSY)
def clear_coat():
    floor(), camera(), panel()
    paint = material("paint", Base_Color=(0.6, 0.05, 0.05), Roughness=0.8, Coat_Weight=1.0, Coat_Roughness=0.1)
    ball(paint)
    return world((0.3, 0.3, 0.3))


@scene(GLOSSY)
def sheen():
    floor(), camera(), panel()
    ball(material("cloth", Base_Color=(0.1, 0.1, 0.3), Sheen_Weight=1.0, Sheen_Roughness=0.5))
    return world((0.3, 0.3, 0.3))


@scene(GLOSSY)
def brushed_metal():
    floor(), camera(), panel()
    ball(material("brushed", Base_Color=(0.8, 0.8, 0.8), Metallic=1.0, Roughness=0.4, Anisotropic=0.7))
    return world((0.3, 0.3, 0.3))


@scene(GLASS, samples=1024)
def glass():
    floor(material("floor", Base_Color=(0.6, 0.4, 0.2))), camera(), panel(size=4.0, strength=3.0)
    glass_of = dict(Base_Color=(1.0, 1.0, 1.0), Transmission_Weight=1.0, Roughness=0.0, IOR=1.45, Specular_IOR_Level=0.5)
    ball(material("glass", **glass_of))
    return world((0.5, 0.5, 0.5))


@scene(GLASS, samples=1024)
def rough_glass():
    floor(material("floor", Base_Color=(0.6, 0.4, 0.2))), camera(), panel(size=4.0, strength=3.0)
    glass_of = dict(Base_Color=(0.9, 1.0, 0.9), Transmission_Weight=1.0, Roughness=0.4, IOR=1.45, Specular_IOR_Level=0.5)
    ball(material("frosted", **glass_of))
    return world((0.5, 0.5, 0.5))


# Textures


@scene(DIFFUSE)
def textured_floor():
    made = material("tiles")
    floor(made), camera(), panel()
    link(made, texture(made, checker((0.8, 0.7, 0.6), (0.1, 0.2, 0.1), 8)).outputs["Color"], socket(made, "Base_Color"))
    ball(material("ball"))


@scene(GLOSSY)
def textured_roughness():
    made = material("worn", Base_Color=(0.9, 0.8, 0.6), Metallic=1.0)
    floor(), camera(), panel()
    node = texture(made, checker((1.0, 0.2, 1.0), (1.0, 0.7, 0.3), 6), data=True)
    split = made.node_tree.nodes.new("ShaderNodeSeparateColor")
    link(made, node.outputs["Color"], split.inputs["Color"])
    link(made, split.outputs["Green"], socket(made, "Roughness"))
    link(made, split.outputs["Blue"], socket(made, "Metallic"))
    ball(made)
    return world((0.3, 0.3, 0.3))


@scene(DIFFUSE)
def normal_map():
    made = material("waves")
    floor(made), camera(), panel(at=(2, 0, 4))
    x = np.linspace(0, 8 * math.pi, 128, endpoint=False)
    slope = 0.35 * np.cos(x)[None, :] * np.ones((128, 1))
    normal = np.stack([-slope, np.zeros_like(slope), np.ones_like(slope)], -1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    bend = made.node_tree.nodes.new("ShaderNodeNormalMap")
    link(made, texture(made, 0.5 + 0.5 * normal, data=True).outputs["Color"], bend.inputs["Color"])
    link(made, bend.outputs["Normal"], socket(made, "Normal"))


@scene(DIFFUSE)
def vertex_colours():
    made = material("painted")
    floor(), camera(), panel()
    made_of = ball(made)
    colours = made_of.data.color_attributes.new("Color", "FLOAT_COLOR", "POINT")
    for vertex, colour in zip(made_of.data.vertices, colours.data):
        colour.color = (0.5 + 0.4 * vertex.co.x, 0.5 + 0.4 * vertex.co.y, 0.5 + 0.4 * vertex.co.z, 1.0)
    node = made.node_tree.nodes.new("ShaderNodeVertexColor")
    node.layer_name = "Color"
    link(made, node.outputs["Color"], socket(made, "Base_Color"))


@scene(DIFFUSE)
def leaf():
    made = material("leaf")
    floor(), camera(), panel(size=0.8, strength=30.0)
    disc = np.hypot(*np.meshgrid(np.linspace(-1, 1, 64), np.linspace(-1, 1, 64))) < 0.8
    pixels = np.dstack([np.full((64, 64, 3), (0.2, 0.6, 0.1)), disc]).astype(np.float32)
    node = texture(made, pixels)
    cut = made.node_tree.nodes.new("ShaderNodeMath")
    cut.operation = "ROUND"
    link(made, node.outputs["Color"], socket(made, "Base_Color"))
    link(made, node.outputs["Alpha"], cut.inputs[0])
    link(made, cut.outputs[0], socket(made, "Alpha"))
    bpy.ops.mesh.primitive_plane_add(size=2, location=(0, 0, 1.5))
    give(made)


@scene(DIFFUSE)
def veil():
    floor(), camera(), panel()
    bpy.ops.mesh.primitive_plane_add(size=2.5, location=(0, 0, 1.5), rotation=(0.4, 0, 0))
    give(material("veil", Base_Color=(0.8, 0.2, 0.2), Alpha=0.4))


# Cameras and geometry


@scene(DIFFUSE)
def depth_of_field():
    floor(), panel()
    made = camera()
    made.data.dof.use_dof = True
    made.data.dof.focus_distance = 7.0
    made.data.dof.aperture_fstop = 0.2
    for i, at in enumerate([(-1.5, -2, 0.7), (0, 0, 0.7), (1.5, 3, 0.7)]):
        ball(material("ball", Base_Color=(0.2 + 0.3 * i, 0.4, 0.8 - 0.3 * i)), at=at, radius=0.7)
    radius = 0.5 * made.data.lens / 1000.0 / made.data.dof.aperture_fstop
    return ["--aperture", str(2.0 * radius), "--focus", "7"]


@scene(DIFFUSE)
def orthographic():
    floor(), panel(), camera(type="ORTHO", ortho_scale=6.0)
    box(material("box", Base_Color=(0.2, 0.5, 0.6)))


@scene(DIFFUSE)
def instances():
    floor(), panel(size=4), camera()
    first = box(material("brick", Base_Color=(0.6, 0.3, 0.2)), at=(0, -2.2, 0.25), size=0.5)
    for i in range(24):
        copy = bpy.data.objects.new(f"copy {i}", first.data)
        copy.location = (-2 + (i % 6) * 0.8, -1 + (i // 6) * 0.9, 0.25)
        copy.rotation_euler = (0, 0, 0.3 * i)
        bpy.context.collection.objects.link(copy)


@scene(DIFFUSE)
def modifiers():
    floor(), panel(), camera()
    made = box(material("soft", Base_Color=(0.6, 0.6, 0.2)))
    made.modifiers.new("bevel", "BEVEL").width = 0.2
    made.modifiers.new("smooth", "SUBSURF").levels = 2
    made.modifiers["smooth"].render_levels = 2
