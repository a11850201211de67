"""Builds a scene of the race and writes what each program reads: `build.py NAME FOLDER`.

NAME.glb and NAME.options are for `mlt`, NAME.blend for Cycles, NAME.json with one PLY file an object for Mitsuba.
"""

import json
import math
import sys
from pathlib import Path

import bpy
import numpy as np
import OpenEXR
from mathutils import Vector

sys.path.append(str(Path(__file__).parents[1]))
import make
import scenes

SIZE = 256


def sky_picture(folder):
    """A sky as an image: blue above, brown below, with a sun of eight degrees whose radiance is 200."""
    x, y = np.meshgrid(np.linspace(-1, 1, 512), np.linspace(1, -1, 256))
    longitude, latitude = math.pi * x, 0.5 * math.pi * y
    blue = np.clip(0.3 + 0.7 * y, 0.05, 1.0)
    near = np.cos(latitude) * np.cos(longitude - 0.6) * math.cos(0.7) + np.sin(latitude) * math.sin(0.7)
    sun = np.where(near > math.cos(math.radians(4)), 200.0, 0.0)
    channels = {"R": 0.5 * blue + sun, "G": 0.7 * blue + 0.9 * sun, "B": blue + 0.7 * sun}
    picture = folder / "sky.exr"
    OpenEXR.File({}, {name: values.astype(np.float32) for name, values in channels.items()}).write(str(picture))
    return picture


def under_sky(folder):
    """Gives the world that picture; returns the option that tells `mlt` of it."""
    picture = sky_picture(folder)
    scenes.world()
    nodes = bpy.context.scene.world.node_tree
    sky = nodes.nodes.new("ShaderNodeTexEnvironment")
    sky.image = bpy.data.images.load(str(picture))
    nodes.links.new(sky.outputs["Color"], nodes.nodes["Background"].inputs["Color"])
    return [f"--environment={picture}"]


def sky(folder):
    scenes.floor(scenes.material("ground", Base_Color=(0.4, 0.35, 0.3))), scenes.camera()
    scenes.ball(scenes.material("red", Base_Color=(0.7, 0.1, 0.1)), at=(-1.2, 0, 1))
    scenes.box(scenes.material("metal", Base_Color=(0.8, 0.7, 0.5), Metallic=1.0, Roughness=0.4), at=(1.4, 0.3, 0.75))
    return under_sky(folder)


def sun_and_texture(_):
    tiles = scenes.material("tiles")
    scenes.floor(tiles), scenes.camera(), scenes.lamp("SUN", 3.0, angle=0.0)
    colours = scenes.checker((0.8, 0.7, 0.6), (0.1, 0.2, 0.1), 8)
    scenes.link(tiles, scenes.texture(tiles, colours).outputs["Color"], scenes.socket(tiles, "Base_Color"))
    scenes.ball(scenes.material("ball", Base_Color=(0.2, 0.6, 0.3)), at=(-1.2, 0, 1))
    scenes.box(scenes.material("box", Base_Color=(0.7, 0.5, 0.2)), at=(1.4, 0.3, 0.75))
    return scenes.world((0.4, 0.6, 1.0), 0.4)


def block(made, at, size):
    """A box along the axes."""
    bpy.ops.mesh.primitive_cube_add(size=1, location=at, scale=size)
    bpy.ops.object.shade_flat()
    return scenes.give(made)


def interior(_):
    """A room whose lamp is half sunk into the ceiling: what Mitsuba's emitters send backwards does not matter."""
    scenes.camera(at=(0, -3.6, 2), target=(0, 0, 2), angle=1.4)
    block(scenes.material("walls", Base_Color=(0.7, 0.6, 0.5)), (0, 0, 2), (4, 8, 4))
    black = dict(Base_Color=(0.0, 0.0, 0.0), Emission_Color=(1.0, 1.0, 1.0), Emission_Strength=6.0)
    block(scenes.material("lamp", **black), (0, 0, 4), (1.5, 1.5, 0.2))
    scenes.box(scenes.material("box", Base_Color=(0.3, 0.7, 0.3)), at=(0.5, 0.5, 0.8))
    return []


def glass(folder):
    scenes.floor(scenes.material("floor", Base_Color=(0.6, 0.4, 0.2))), scenes.camera()
    inputs = dict(Base_Color=(1.0, 1.0, 1.0), Transmission_Weight=1.0, Roughness=0.0, IOR=1.45, Specular_IOR_Level=0.5)
    scenes.ball(scenes.material("glass", **inputs))
    return under_sky(folder)


SCENES = {made.__name__: made for made in (sky, sun_and_texture, interior, glass)}


def write_shape(thing, folder, name):
    """One object as a PLY file; returns what Mitsuba has to know of it."""
    bpy.ops.object.select_all(action="DESELECT")
    thing.select_set(True)
    path = folder / f"{name}.{thing.name}.ply"
    axes = dict(forward_axis="Y", up_axis="Z", export_triangulated_mesh=True)
    bpy.ops.wm.ply_export(filepath=str(path), export_selected_objects=True, export_uv=True, export_normals=True, ascii_format=False, **axes)
    surface = thing.data.materials[0]
    value = lambda key: scenes.socket(surface, key).default_value
    textured = scenes.socket(surface, "Base_Color").is_linked
    return {
        "file": str(path),
        "flat": not thing.data.polygons[0].use_smooth,
        "colour": None if textured else list(value("Base_Color"))[:3],
        "metallic": value("Metallic"),
        "roughness": value("Roughness"),
        "glass": value("IOR") if value("Transmission_Weight") > 0 else None,
        "emission": [value("Emission_Strength") * c for c in list(value("Emission_Color"))[:3]],
    }


def write_texture(folder, name):
    """The one image of a chequered floor, for Mitsuba."""
    for image in bpy.data.images:
        if image.packed_file:
            image.save(filepath=str(folder / f"{name}.png"))


def told_of_sun(sun):
    """Direction and irradiance of a sun, if there is one."""
    return sun and {"to": list(sun.matrix_world.to_3x3() @ Vector((0, 0, -1))), "energy": sun.data.energy}


def write_for_mitsuba(name, folder, options):
    """All that Mitsuba has to know; the world is a picture, a colour or nothing."""
    camera = bpy.context.scene.camera
    world = options[-1].removeprefix("--environment=") if options else None
    told = {
        "shapes": [write_shape(thing, folder, name) for thing in list(bpy.data.objects) if thing.type == "MESH"],
        "camera": [list(row) for row in camera.matrix_world],
        "angle": math.degrees(camera.data.angle),
        "sun": told_of_sun(bpy.data.objects.get("sun")),
        "world": [float(c) for c in world.split(",")] if world and "," in world else world,
    }
    write_texture(folder, name)
    (folder / f"{name}.json").write_text(json.dumps(told))


def main():
    name, folder = sys.argv[1], Path(sys.argv[2])
    make.SIZE = SIZE
    make.empty()
    options = SCENES[name](folder)
    make.export(folder / f"{name}.glb", export_cameras=True, export_lights=True, export_extras=True, export_apply=True)
    (folder / f"{name}.options").write_text("\n".join(options))
    write_for_mitsuba(name, folder, options)
    bpy.ops.file.pack_all()
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / f"{name}.blend"))


if __name__ == "__main__":
    main()
