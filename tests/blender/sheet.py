"""All scenes on one sheet, each by Cycles above and by `mlt` below: `sheet.py FOLDER SHEET.jpg`, after compare.py."""

import sys
from pathlib import Path

import numpy as np
import OpenEXR
from PIL import Image, ImageDraw

import scenes

SIZE, COLUMNS, LABEL = 96, 10, 12


def picture(path):
    """A linear image as one for the eye; grey where there is none."""
    if not path.exists():
        return Image.new("RGB", (SIZE, SIZE), "grey")
    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    linear = np.stack([channels[name].pixels for name in "RGB"], -1)
    return Image.fromarray((255.0 * np.clip(linear, 0.0, 1.0) ** (1.0 / 2.2)).astype(np.uint8))


def main():
    folder, sheet = Path(sys.argv[1]), sys.argv[2]
    height = 2 * SIZE + LABEL
    whole = Image.new("RGB", (COLUMNS * SIZE, -(-len(scenes.CASES) // COLUMNS) * height), "black")
    for i, case in enumerate(scenes.CASES):
        x, y = i % COLUMNS * SIZE, i // COLUMNS * height
        for row, program in enumerate(["cycles", "mlt"]):
            whole.paste(picture(folder / f"{case.name}.{program}.exr"), (x, y + row * SIZE))
        ImageDraw.Draw(whole).text((x + 1, y + 2 * SIZE), case.name[:16], fill="white")
    whole.save(sheet, quality=90)


main()
