"""Equal time beside Cycles and Mitsuba: `race.py MLT FOLDER [SCENE …] [--seconds 60] [--seeds 2]`.

Each program renders each scene with several seeds for about so many seconds of one processor. The noise of a program is the mean squared
difference of two of its own images over two, relative to the square of the image: no reference is needed, and no program is blamed for what it
models in another way. How far the programs' images are apart is printed beside it, by the measure of compare.py.
"""

import argparse
import itertools
import json
import resource
import subprocess
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
sys.path.append(str(HERE.parent))
from compare import luminance, tiles

SCENES = ["sky", "sun_and_texture", "interior", "glass"]


def by_script(script):
    """A program that a script runs, which prints its seconds."""

    def render(scene, folder, samples, seed, output):
        command = [sys.executable, HERE / script, scene, folder, str(samples), str(seed), output]
        done = subprocess.run(command, capture_output=True, text=True, cwd=HERE)
        lines = [line for line in done.stdout.splitlines() if line.startswith("seconds ")]
        if done.returncode or not lines:
            sys.exit(done.stdout[-2000:] + done.stderr[-2000:])
        return float(lines[-1].split()[1])

    return render


def by_mlt(program):
    """`mlt` as it is by itself: the method auto. The whole command counts."""

    def render(scene, folder, samples, seed, output):
        options = (folder / f"{scene}.options").read_text().split()
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        command = [program, "render", folder / f"{scene}.glb", "--size", "256x256", "--samples-per-pixel", str(samples)]
        subprocess.run([*command, "--seed", str(seed), "--threads", "1", "-q", "--force", "-o", output, *options], check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    return render


def at_equal_time(render, scene, folder, name, seconds, seeds, step):
    """Images of several seeds, each of about so many seconds, and the seconds."""
    trial, took, samples = folder / "trial.exr", 0.0, step
    while took < seconds / 20:
        samples *= 4
        took = render(scene, folder, samples, 99, trial)
    samples = max(step, round(samples * seconds / took / step) * step)
    images = [folder / f"{scene}.{name}.{seed}.exr" for seed in range(seeds)]
    spent = [render(scene, folder, samples, seed, image) for seed, image in enumerate(images)]
    return [luminance(image) for image in images], np.mean(spent), samples


def noise(images, weight):
    """Relative mean squared error of one image, from pairs of them."""
    pairs = [np.mean(weight * (a - b) ** 2) / 2 for a, b in itertools.combinations(images, 2)]
    return float(np.mean(pairs))


def race(program, scene, folder, seconds, seeds):
    """One scene; returns the rows of its table."""
    subprocess.run([sys.executable, HERE / "build.py", scene, folder], check=True, capture_output=True, cwd=HERE)
    racers = {"mlt": (by_mlt(program), 16), "cycles": (by_script("by_cycles.py"), 4), "mitsuba": (by_script("by_mitsuba.py"), 64)}
    made = {name: at_equal_time(render, scene, folder, name, seconds, seeds, step) for name, (render, step) in racers.items()}
    means = {name: np.mean(images, axis=0) for name, (images, _, _) in made.items()}
    mean = np.mean(list(means.values()), axis=0)
    weight = 1.0 / (mean**2 + (0.1 * mean.mean()) ** 2)
    rows = []
    for name, (images, spent, samples) in made.items():
        apart = np.abs(tiles(means[name]) - tiles(means["mlt"])).mean() / mean.mean()
        rows.append({"scene": scene, "program": name, "samples": samples, "seconds": spent, "relMSE": noise(images, weight), "apart": apart})
        print("{scene:16} {program:8} {samples:6} samples {seconds:6.1f} s  relMSE {relMSE:.3g}  apart {apart:.2%}".format(**rows[-1]), flush=True)
    return rows


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=Path), parser.add_argument("folder", type=Path)
    parser.add_argument("scenes", nargs="*", default=SCENES)
    parser.add_argument("--seconds", type=float, default=60.0), parser.add_argument("--seeds", type=int, default=2)
    asked = parser.parse_args()
    folder = asked.folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    rows = [row for scene in asked.scenes for row in race(asked.program.resolve(), scene, folder, asked.seconds, asked.seeds)]
    (folder / "race.json").write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
