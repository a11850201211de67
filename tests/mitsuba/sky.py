"""A sky with a bright patch to one side, as a function of direction and as the picture that each program reads."""

import numpy as np
import OpenEXR

HEIGHT = 256
# From the centre of the scene towards the patch, and its standard deviation in radians.
PATCH, WIDTH = np.array([0.55, 0.6, -0.58]), 0.2


def radiance(directions):
    """Red, green and blue: blue above, brown below, and the patch, which is 30 at its centre."""
    up = directions[..., 1:2]
    cosine = np.clip(directions @ (PATCH / np.linalg.norm(PATCH)), -1.0, 1.0)[..., None]
    patch = 30.0 * np.exp(-0.5 * (np.arccos(cosine) / WIDTH) ** 2)
    return 0.1 + (0.5 + 0.5 * up) * [0.2, 0.35, 0.6] + (0.5 - 0.5 * up) * [0.3, 0.2, 0.1] + patch * [1.0, 0.9, 0.7]


def picture(path, inclinations):
    """Writes the sky with rows at these angles from +y and columns whose first one is towards −x, then −z."""
    azimuths = 2.0 * np.pi * (np.arange(2 * HEIGHT) + 0.5) / (2 * HEIGHT)
    theta, phi = np.meshgrid(inclinations, azimuths, indexing="ij")
    directions = np.stack([-np.sin(theta) * np.cos(phi), np.cos(theta), -np.sin(theta) * np.sin(phi)], axis=-1)
    channels = np.moveaxis(radiance(directions).astype(np.float32), -1, 0)
    OpenEXR.File({}, {name: np.ascontiguousarray(c) for name, c in zip("RGB", channels)}).write(str(path))
    return path


def pictures(folder):
    """The picture for `mlt`, whose rows are where their pixels' centres are, and for Mitsuba, whose first and last row are the poles."""
    mlt = picture(folder / "sky.mlt.exr", np.pi * (np.arange(HEIGHT) + 0.5) / HEIGHT)
    return mlt, picture(folder / "sky.mitsuba.exr", np.pi * np.arange(HEIGHT) / (HEIGHT - 1))
