"""Renders a scene of the race by Mitsuba 3 and prints the processor's seconds: `by_mitsuba.py NAME FOLDER SAMPLES SEED OUTPUT`.

Its path tracer, vectorised by LLVM, with multi-jittered numbers, in passes that fit into memory.
"""

import json
import sys
import time
from pathlib import Path

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")
import drjit as dr

SIZE, PASS = 256, 64


def surface(shape, picture):
    """A material, alike on both sides: glass, matt, else Disney's."""
    if shape["glass"]:
        return {"type": "dielectric", "int_ior": shape["glass"], "ext_ior": 1.0}
    colour = {"type": "rgb", "value": shape["colour"]}
    if not shape["colour"]:
        colour = {"type": "bitmap", "filename": picture, "to_uv": mi.ScalarTransform3f().scale([1, -1])}
    matt = {"type": "diffuse", "reflectance": colour}
    metal = {"type": "principled", "base_color": colour, "metallic": shape["metallic"], "roughness": shape["roughness"]}
    return {"type": "twosided", "bsdf": metal if shape["metallic"] else matt}


def described(told, picture):
    """The scene as Mitsuba wants it."""
    turn = mi.ScalarTransform4f(np.array(told["camera"])) @ mi.ScalarTransform4f().rotate([0, 1, 0], 180)
    sensor = {
        "type": "perspective", "fov": told["angle"], "to_world": turn,
        "film": {"type": "hdrfilm", "width": SIZE, "height": SIZE, "rfilter": {"type": "box"}, "component_format": "float32"},
        "sampler": {"type": "multijitter", "sample_count": PASS},
    }
    scene = {"type": "scene", "sensor": sensor, "integrator": {"type": "path", "max_depth": 65}}
    for i, shape in enumerate(told["shapes"]):
        made = {"type": "ply", "filename": shape["file"], "face_normals": shape["flat"], "bsdf": surface(shape, picture)}
        if max(shape["emission"]) > 0:
            made["emitter"] = {"type": "area", "radiance": {"type": "rgb", "value": shape["emission"]}}
        scene[f"shape{i}"] = made
    if told["sun"]:
        scene["sun"] = {"type": "directional", "direction": told["sun"]["to"], "irradiance": {"type": "rgb", "value": told["sun"]["energy"]}}
    if isinstance(told["world"], str):
        upright = mi.ScalarTransform4f().rotate([0, 0, 1], 90).rotate([1, 0, 0], 90)
        scene["world"] = {"type": "envmap", "filename": told["world"], "to_world": upright}
    elif told["world"]:
        scene["world"] = {"type": "constant", "radiance": {"type": "rgb", "value": told["world"]}}
    return scene


def main():
    name, folder, samples, seed, output = sys.argv[1], Path(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4]), sys.argv[5]
    dr.set_thread_count(2)
    scene = mi.load_dict(described(json.loads((folder / f"{name}.json").read_text()), str(folder / f"{name}.png")))
    passes = max(1, samples // PASS)
    mi.render(scene, spp=PASS, seed=0).numpy()  # compiles
    start = time.process_time()
    images = (mi.render(scene, spp=PASS, seed=1 + seed * 100_000 + i).numpy() for i in range(passes))
    image = sum(images) / passes
    print(f"seconds {time.process_time() - start}")
    mi.Bitmap(image[..., :3].astype(np.float32)).write(output)


if __name__ == "__main__":
    main()
