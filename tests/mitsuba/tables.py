"""Compares scattering functions pair by pair: `tables.py PROGRAM`, which is the example bsdf_table of mlt-core.

Of a surface with values a (Mitsuba) and b (`mlt`) the difference is max |a − b| / max(|a|, 10⁻³ max |a|) over the pairs of directions; so it is of
densities. Of metal and glass with light that meets them more than once, which `mlt` interpolates, it is max |a − b| / (|a| + cosθ/π), the error beside
a white diffuse surface. As a control each surface is compared with one whose roughness, index of refraction or reflectance is 5 % greater, which has to
be further apart than the bound: infinitely where light is refracted into another direction.

Exit codes: 0 all are as near as their bounds say and all controls are not, 1 otherwise.
"""

import subprocess
import sys
from collections import defaultdict

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")

import microfacets

# f32 has 6·10⁻⁸; the normal that refracts one direction into another loses a hundred times that.
ROUNDING = 1e-4
# Of the tables of what meets a surface more than once: docs/theory-surfaces.md.
TABLE = 3e-3
TABULATED = ("metal", "whole_glass")


def read(program):
    """Surfaces by kind and parameters, each with its rows: eye, light, value, density."""
    table = defaultdict(list)
    for line in subprocess.run([program], check=True, capture_output=True, text=True).stdout.splitlines():
        kind, *numbers = line.split("\t")
        numbers = [float(number) for number in numbers]
        table[kind, *numbers[:4]].append(numbers[4:])
    return {surface: np.array(rows) for surface, rows in table.items()}


def interaction(eye):
    """A hit on a surface whose normal is z."""
    hit = mi.SurfaceInteraction3f()
    hit.wi = mi.Vector3f(*eye)
    return hit


def evaluated(bsdf, rows):
    """Values f |cosθ| and densities by Mitsuba, which has radiance go from wo to wi."""
    context = mi.BSDFContext()
    pairs = [(interaction(row[:3]), mi.Vector3f(*row[3:6])) for row in rows]
    return np.array([[bsdf.eval(context, hit, light)[0], bsdf.pdf(context, hit, light)] for hit, light in pairs])


def drawn(bsdf, rows):
    """Share of radiance and probability of each event of a smooth surface; nan where the direction is another one."""
    made = []
    for row in rows:
        both, one = mi.BSDFContext(), mi.BSDFContext()
        one.component = 0 if row[2] * row[5] > 0 else 1
        sample, weight = bsdf.sample(one, interaction(row[:3]), 0.5, mi.Point2f(0.5, 0.5))
        apart = np.abs(np.array(sample.wo) - row[3:6]).max()
        reflected, _ = bsdf.sample(both, interaction(row[:3]), 0.0, mi.Point2f(0.5, 0.5))
        chance = reflected.pdf if one.component == 0 else 1.0 - reflected.pdf
        made.append([weight[0], chance] if apart < 1e-5 else [np.nan, np.nan])
    return np.array(made)


def described(surface):
    """The surface as Mitsuba wants it."""
    kind, along, across, ior, reflectance = surface
    colour = {"type": "rgb", "value": reflectance}
    interface = {"int_ior": ior, "ext_ior": 1.0}
    glass = {"type": "roughdielectric", "distribution": "ggx", "alpha": along, **interface}
    metal = {"type": "principled", "base_color": colour, "metallic": 1.0, "roughness": along**0.5}
    return {
        "lambert": {"type": "diffuse", "reflectance": colour},
        "facets": {"type": "roughconductor", "material": "none", "distribution": "ggx", "alpha_u": along, "alpha_v": across},
        "schlick": metal,
        "metal": metal,
        "rough_glass": glass,
        "whole_glass": glass,
        "glass": {"type": "dielectric", **interface},
        "wall": {"type": "thindielectric", **interface},
    }[kind]


def by_mitsuba(surface, rows):
    """Values and densities of a surface of the table."""
    kind, along, across, ior, reflectance = surface
    bsdf = mi.load_dict(described(surface))
    if kind in ("glass", "wall"):
        return drawn(bsdf, rows)
    made = evaluated(bsdf, rows)
    if kind != "lambert":
        made = microfacets.heights_correlated(made, rows, along, across)
    if kind == "metal":
        made[:, 0] += microfacets.reflected_again(rows, reflectance, along)
    if kind == "whole_glass":
        made[:, 0] += microfacets.met_again(rows, ior, along)
    return made


def apart(kind, truth, rows):
    """The greatest relative difference of values and of densities; those of light that is met more than once are left out."""
    (a, p), (b, q) = truth.T, rows[:, 6:].T
    beside = lambda a: np.maximum(np.abs(a), max(1e-3 * np.abs(a).max(), 1e-30))
    worst = lambda off: np.nan_to_num(off, nan=np.inf).max()
    if kind in TABULATED:
        return worst(np.abs(a - b) / (np.abs(a) + np.abs(rows[:, 5]) / np.pi)), 0.0
    return worst(np.abs(a - b) / beside(a)), worst(np.abs(p - q) / beside(p))


def detuned(surface):
    """The surface of the control: 5 % rougher, or of another index, or brighter."""
    kind, along, across, ior, reflectance = surface
    if kind == "lambert":
        return kind, along, across, ior, 1.05 * reflectance
    if kind in ("glass", "wall"):
        return kind, along, across, 1.05 * ior, reflectance
    return kind, 1.05 * along, 1.05 * across, ior, reflectance


def judge(surface, rows):
    """Compares a surface; prints a line; returns whether it and its control are as they should be."""
    kind, along, across, ior, reflectance = surface
    values, densities = apart(kind, by_mitsuba(surface, rows), rows)
    control, _ = apart(kind, by_mitsuba(detuned(surface), rows), rows)
    bound = TABLE if kind in TABULATED else ROUNDING
    right = max(values, densities) <= bound < control
    line = f"{kind} α {along:g}×{across:g} η {ior:g} ρ {reflectance:g}".ljust(34) + f" {'right' if right else 'WRONG'} {len(rows):5} pairs"
    print(f"{line}  f {values:.0e}  p {densities:.0e}  of {bound:.0e}  control {control:.0e}", flush=True)
    return right


def main():
    table = read(sys.argv[1])
    right = sum([judge(surface, rows) for surface, rows in table.items()])
    print(f"{right} of {len(table)} surfaces are right")
    sys.exit(int(not table or right != len(table)))


if __name__ == "__main__":
    main()
