"""Renders every scene by Cycles and by `mlt`, and judges how far the two are apart: `compare.py MLT FOLDER [NAME …]`.

Per tile of 8 × 8 pixels the mean luminances a (Cycles) and b (`mlt`) are compared; the difference of two images is
mean |a − b| / mean a over the tiles. Tiles leave the noise of single pixels out and keep every tone; the worst tile is shown, too, since a
mean hides what is small.

Exit codes: 0 all scenes but those that are known to lack something agree within their bounds, 1 some do not.
"""

import subprocess
import sys
from pathlib import Path

import numpy as np
import OpenEXR

import scenes

TILE = 8
LUMINANCE = {"R": 0.2126, "G": 0.7152, "B": 0.0722}
HERE = Path(__file__).parent


def luminance(path):
    """A linear image's luminance, height × width."""
    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    return sum(weight * channels[name].pixels.astype(np.float64) for name, weight in LUMINANCE.items())


def tiles(image):
    """Means over the tiles of an image."""
    height, width = image.shape
    return image.reshape(height // TILE, TILE, width // TILE, TILE).mean(axis=(1, 3))


def difference(truth, image):
    """|a − b| / mean a in the mean over the tiles and in the worst of them, and the mean of b over that of a."""
    a, b = tiles(luminance(truth)), tiles(luminance(image))
    apart = np.abs(a - b) / a.mean()
    return apart.mean(), apart.max(), b.mean() / a.mean()


def made_by_blender(case, folder):
    """Builds, exports and renders a scene in a process of its own, unless that is done."""
    if not (folder / f"{case.name}.cycles.exr").exists():
        command = [sys.executable, HERE / "make.py", case.name, folder]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=HERE)
    return (folder / f"{case.name}.options").read_text().split()


def made_by_mlt(program, case, folder, options):
    """Renders a scene by `mlt`; returns the image."""
    scene, image = folder / f"{case.name}.glb", folder / f"{case.name}.mlt.exr"
    command = [program, "render", scene, "--size", "96x96", "--samples-per-pixel", "2048", "-q", "--force", "-o", image, *options]
    subprocess.run(command, check=True, stderr=subprocess.PIPE, text=True)
    return image


def default_export_renders(program, case, folder):
    """What Blender exports by default, without camera and lamps, gives an image all the same."""
    command = [program, "render", folder / f"{case.name}.default.glb", "--size", "32x32", "--samples-per-pixel", "4", "-q", "--force"]
    done = subprocess.run([*command, "-o", folder / f"{case.name}.default.png"], stderr=subprocess.PIPE, text=True)
    return done.returncode == 0


def judge(program, case, folder):
    """Renders and compares one scene; prints a line; returns whether it is right, which one that lacks something never is."""
    options = made_by_blender(case, folder)
    try:
        image = made_by_mlt(program, case, folder, options)
    except subprocess.CalledProcessError as error:
        print(f"{case.name:28} FAILS     {error.stderr.strip()}", flush=True)
        return False
    apart, worst, ratio = difference(folder / f"{case.name}.cycles.exr", image)
    default = default_export_renders(program, case, folder)
    right = apart <= case.bound and default and not case.lacks
    verdict = "right" if right else f"LACKS {case.lacks}:" if case.lacks else "WRONG" if default else "NO IMAGE OF THE DEFAULT EXPORT"
    apart, bound, worst = 100 * apart, 100 * case.bound, 100 * worst
    print(f"{case.name:28} {verdict:9} {apart:6.2f} % of {bound:.0f} %, worst {worst:5.2f} %, mean x {ratio:.4f}", flush=True)
    return right


def main():
    program, folder, names = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve(), sys.argv[3:]
    folder.mkdir(parents=True, exist_ok=True)
    cases = [case for case in scenes.CASES if not names or case.name in names]
    right = sum([judge(program, case, folder) for case in cases])
    lacking = sum(bool(case.lacks) for case in cases)
    print(f"{right} of {len(cases)} scenes are right; {lacking} lack something that mlt does not render")
    sys.exit(int(right != len(cases) - lacking))


if __name__ == "__main__":
    main()
