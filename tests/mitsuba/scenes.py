"""The scenes: what stands in them, what lights them, how often light may be reflected, and the small error that must be found out."""

from dataclasses import dataclass, field

import numpy as np

import meshes

CENTRE = np.zeros(3)


def pot(radius):
    """The lower part of a ball, seen from inside."""
    ball = meshes.ball(radius, CENTRE)
    return ball[ball[:, :, 1].max(axis=1) < 0.3][:, ::-1]


def diffuse(colour):
    return {"kind": "diffuse", "colour": colour}


def glass(kind, colour, ior=1.5):
    """Kind `solid`, or `thin` for a wall."""
    return {"kind": kind, "colour": colour, "ior": ior}


@dataclass
class Case:
    """A scene; `light` is `sky`, a radiance from everywhere, or a sun."""

    name: str
    things: list
    light: object
    # Edges from light to lens; None: no limit.
    edges: int | None
    samples: int
    # Options of `mlt`, or the factor on every colour, that make another image.
    wrong_options: list = field(default_factory=list)
    wrong_colours: float = 1.0


STRONGER = dict(wrong_options=["--environment-strength", "1.02"])
TURNED = dict(wrong_options=["--environment-rotation", "2"])
BRIGHTER = dict(wrong_colours=1.02)
FLOOR, BALL = meshes.square(3.0, -1.0), meshes.ball(1.0, CENTRE)
ON_FLOOR = [(FLOOR, diffuse(0.6)), (BALL, diffuse(0.5))]
IN_POT = [(pot(1.8), diffuse(0.8)), (meshes.ball(0.6, CENTRE - [0.0, 0.6, 0.0]), diffuse(0.6))]
SUN = {"irradiance": 3.0, "angle": 60.0}

CASES = [
    Case("sky on a floor", [(FLOOR, diffuse(0.6))], "sky", 2, 64, **STRONGER),
    Case("sky on a ball, once", ON_FLOOR, "sky", 2, 128, **TURNED),
    Case("sky on a ball, again and again", ON_FLOOR, "sky", None, 128, **TURNED),
    Case("sky through a ball of glass", [(BALL, glass("solid", 0.9))], "sky", None, 512, **TURNED),
    Case("sky through a thin ball", [(BALL, glass("thin", 0.8))], "sky", None, 512, **TURNED),
    Case("furnace, pot and ball", IN_POT, 1.0, None, 256, **BRIGHTER),
    Case("furnace, ball of glass", [(BALL, glass("solid", 0.8))], 1.0, None, 512, **BRIGHTER),
    Case("furnace, thin ball", [(BALL, glass("thin", 0.6, 2.0))], 1.0, None, 128, **BRIGHTER),
    Case("sun, once", ON_FLOOR, SUN, 2, 32, **BRIGHTER),
]
