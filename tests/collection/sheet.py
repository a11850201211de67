"""Renders every glTF and OBJ file below some folders and puts the images on one sheet: `sheet.py MLT SHEET.jpg FOLDER …`.

Prints a line a file: the exit code, the mean of the image, and what the program says. A file that is not an image is a grey square.
"""

import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from PIL import Image, ImageDraw, ImageStat

SIZE, COLUMNS, LABEL = 96, 12, 12
SCENES = {".gltf", ".glb", ".obj"}


def render(program, scene, image):
    """Renders one file; returns the exit code and the messages."""
    command = [program, "render", scene, "--size", f"{SIZE}x{SIZE}", "--samples-per-pixel", "32", "--threads", "1", "-o", image, "-q", "--force"]
    try:
        done = subprocess.run(command, stderr=subprocess.PIPE, text=True, timeout=120, errors="replace")
    except subprocess.TimeoutExpired:
        return 124, "no image within two minutes"
    return done.returncode, done.stderr.strip()


def tile(image, name):
    """An image above its name."""
    made = Image.new("RGB", (SIZE, SIZE + LABEL), "black")
    made.paste(Image.open(image).convert("RGB") if image.exists() else Image.new("RGB", (SIZE, SIZE), "grey"))
    ImageDraw.Draw(made).text((1, SIZE), name[:16], fill="white")
    return made


def main():
    program, sheet, folders = Path(sys.argv[1]).resolve(), sys.argv[2], map(Path, sys.argv[3:])
    scenes = sorted(path for folder in folders for path in folder.rglob("*") if path.suffix.lower() in SCENES)
    with tempfile.TemporaryDirectory() as made, ThreadPoolExecutor(2) as pool:
        images = [Path(made) / f"{i}.png" for i in range(len(scenes))]
        results = list(pool.map(lambda job: render(program, *job), zip(scenes, images)))
        tiles = [tile(image, scene.stem) for image, scene in zip(images, scenes)]
        means = [round(ImageStat.Stat(Image.open(i).convert("L")).mean[0]) if i.exists() else "-" for i in images]
    rows = -(-len(tiles) // COLUMNS)
    whole = Image.new("RGB", (COLUMNS * SIZE, rows * (SIZE + LABEL)), "black")
    for i, made in enumerate(tiles):
        whole.paste(made, (i % COLUMNS * SIZE, i // COLUMNS * (SIZE + LABEL)))
    whole.save(sheet, quality=90)
    for scene, (code, message), mean in zip(scenes, results, means):
        print(f"{scene}\t{code}\t{mean}\t{message.replace(chr(10), ' | ')}")
    print(f"{sum(code == 0 for code, _ in results)} of {len(scenes)} files give an image", file=sys.stderr)


main()
