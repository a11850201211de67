"""Renders scenes by Mitsuba and by `mlt`, and judges how far the two are apart: `images.py MLT FOLDER [NAME …]`.

Each program renders each scene with R seeds. Of a tile of 4 × 4 pixels, which keeps every tone and leaves noise out, let a (Mitsuba) and b (`mlt`) be
the means over the seeds, and v the variances of these means, found from the seeds. Then S = mean over the tiles of (a − b)² − v_a − v_b is the
mean squared difference of what the programs converge to. It may be four of its standard errors, found from the scatter over the tiles, and 0.1 %
of the image's mean, squared, for rounding and the picture of the sky. So may be the difference of the images' means. Of the single pixels at least
93 % have to be as near as 95 % intervals say. A small deliberate error of each scene has to pass the bound of S.

Exit codes: 0 all scenes are as near as that and all errors are found out, 1 otherwise.
"""

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import mitsuba as mi
import numpy as np
import OpenEXR

mi.set_variant("scalar_rgb")

import meshes
import scenes
import sky

SIZE, TILE, SEEDS = 48, 4, 8
FLOOR, ERRORS, WITHIN = 1e-3, 4.0, 0.93
# Half a 95 % interval of Student's distribution with SEEDS − 1 degrees of freedom, in standard errors.
STUDENT = 2.365
FROM, TO, ANGLE = [0.0, 2.5, 5.0], [0.0, -0.2, 0.0], 35.0


def surface(told):
    """A surface as Mitsuba wants it."""
    colour = {"type": "rgb", "value": told["colour"]}
    if told["kind"] == "diffuse":
        return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": colour}}
    kind = {"solid": "dielectric", "thin": "thindielectric"}[told["kind"]]
    return {"type": kind, "int_ior": told["ior"], "ext_ior": 1.0, "specular_transmittance": colour}


def light(told, picture):
    """A light as Mitsuba wants it; its pictures of the sky begin a quarter of a turn later."""
    if told == "sky":
        return {"type": "envmap", "filename": str(picture), "to_world": mi.ScalarTransform4f().rotate([0, 1, 0], 90)}
    if isinstance(told, float):
        return {"type": "constant", "radiance": {"type": "rgb", "value": told}}
    angle = np.radians(told["angle"])
    down = [0.0, -np.sin(angle), -np.cos(angle)]
    return {"type": "directional", "direction": down, "irradiance": {"type": "rgb", "value": told["irradiance"]}}


def by_mitsuba(case, folder, picture):
    """Images of all seeds."""
    film = {"type": "hdrfilm", "width": SIZE, "height": SIZE, "rfilter": {"type": "box"}, "component_format": "float32"}
    turn = mi.ScalarTransform4f().look_at(origin=FROM, target=TO, up=[0, 1, 0])
    sensor = {"type": "perspective", "fov": ANGLE, "to_world": turn, "film": film}
    scene = {"type": "scene", "sensor": sensor, "light": light(case.light, picture)}
    scene["integrator"] = {"type": "path", "max_depth": case.edges or -1}
    for i, (triangles, told) in enumerate(case.things):
        path = folder / f"{i}.ply"
        meshes.write_ply(path, triangles)
        scene[f"thing{i}"] = {"type": "ply", "filename": str(path), "face_normals": True, "bsdf": surface(told)}
    made = mi.load_dict(scene)
    return np.stack([np.array(mi.render(made, spp=case.samples, seed=seed))[..., :3] for seed in range(SEEDS)]).astype(np.float64)


def by_mlt(program, case, folder, picture, colours=1.0, options=()):
    """Images of all seeds, with colours times a factor and with further options."""
    things = [(triangles, {**told, "colour": colours * told["colour"]}) for triangles, told in case.things]
    has_sun = isinstance(case.light, dict)
    meshes.write_gltf(folder / "scene.gltf", things, case.light if has_sun else None)
    around = "none" if has_sun else picture if case.light == "sky" else ",".join([str(case.light)] * 3)
    camera = ["--camera-from", ",".join(map(str, FROM)), "--camera-to", ",".join(map(str, TO)), "--fov", str(ANGLE)]
    wall = any(told["kind"] == "thin" for _, told in case.things)
    command = [program, "render", folder / "scene.gltf", *camera, f"--environment={around}", "--light-units", "raw"]
    command += ["--glass", "thin" if wall else "solid", "--size", f"{SIZE}x{SIZE}", "--samples-per-pixel", str(case.samples)]
    command += ["--method", "pt", "-q", "--force", "-o", folder / "mlt.exr", *options]
    command += ["--max-length", str(case.edges)] if case.edges else []
    return np.stack([one_seed(command, seed, folder / "mlt.exr") for seed in range(SEEDS)])


def one_seed(command, seed, image):
    """An image, height × width × 3."""
    subprocess.run([*command, "--seed", str(seed)], check=True, stderr=subprocess.PIPE)
    channels = OpenEXR.File(str(image), separate_channels=True).channels()
    return np.stack([channels[name].pixels for name in "RGB"], axis=-1).astype(np.float64)


def tiles(images):
    """Means over tiles."""
    seeds, height, width, channels = images.shape
    return images.reshape(seeds, height // TILE, TILE, width // TILE, TILE, channels).mean(axis=(2, 4))


def apart(truth, images):
    """Difference of means over seeds, and its variance."""
    variance = (truth.var(axis=0, ddof=1) + images.var(axis=0, ddof=1)) / SEEDS
    return images.mean(axis=0) - truth.mean(axis=0), variance


@dataclass
class Difference:
    """Of two programs, relative to the mean of the image."""

    # √S and its bound.
    tones: float
    tones_bound: float
    # The difference of means and its bound.
    mean: float
    mean_bound: float
    # Share of pixels as near as their intervals say.
    pixels: float

    def is_small(self):
        return self.tones <= self.tones_bound and abs(self.mean) <= self.mean_bound and self.pixels >= WITHIN


def difference(truth, images):
    """How far two programs are apart."""
    mean = truth.mean()
    off, variance = apart(tiles(truth), tiles(images))
    squares = (off**2 - variance).mean(axis=2)
    bound = np.sqrt(ERRORS * squares.std() / np.sqrt(squares.size) + (FLOOR * mean) ** 2)
    whole, error2 = apart(truth.mean(axis=(1, 2, 3)), images.mean(axis=(1, 2, 3)))
    off, variance = apart(truth, images)
    within = np.abs(off) <= STUDENT * np.sqrt(variance) + FLOOR * mean
    tones = np.sqrt(max(squares.mean(), 0.0))
    return Difference(tones / mean, bound / mean, whole / mean, ERRORS * np.sqrt(error2) / mean + FLOOR, within.mean())


def judge(program, case, folder, pictures):
    """Renders and compares one scene; prints a line; returns whether it and its control are as they should be."""
    truth = by_mitsuba(case, folder, pictures[1])
    found = difference(truth, by_mlt(program, case, folder, pictures[0]))
    control = difference(truth, by_mlt(program, case, folder, pictures[0], case.wrong_colours, case.wrong_options))
    right = found.is_small() and control.tones > found.tones_bound
    line = f"{case.name:31} {'right' if right else 'WRONG':5}  tones {found.tones:.2%} of {found.tones_bound:.2%}"
    line += f"  mean {found.mean:+.3%} of {found.mean_bound:.3%}  pixels {found.pixels:.1%}"
    print(f"{line}  control {control.tones:.2%}", flush=True)
    return right


def main():
    program, folder, names = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve(), sys.argv[3:]
    folder.mkdir(parents=True, exist_ok=True)
    cases = [case for case in scenes.CASES if not names or case.name in names]
    pictures = sky.pictures(folder)
    right = sum([judge(program, case, folder, pictures) for case in cases])
    print(f"{right} of {len(cases)} scenes are right")
    sys.exit(int(not cases or right != len(cases)))


if __name__ == "__main__":
    main()
