"""Renders a scene of the race by Cycles and prints the processor's seconds: `by_cycles.py NAME FOLDER SAMPLES SEED OUTPUT`."""

import sys
import time
from pathlib import Path

import bpy

sys.path.append(str(Path(__file__).parents[1]))
import make


def main():
    name, folder, samples, seed, output = sys.argv[1], Path(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4]), sys.argv[5]
    bpy.ops.wm.open_mainfile(filepath=str(folder / f"{name}.blend"))
    bpy.context.scene.cycles.seed = seed
    bpy.context.scene.render.threads_mode, bpy.context.scene.render.threads = "FIXED", 1
    start = time.process_time()
    make.render(output, samples)
    print(f"\nseconds {time.process_time() - start}")


if __name__ == "__main__":
    main()
