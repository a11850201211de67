"""What turns Mitsuba's microfacets into those of `mlt`, by formulas of the literature and Mitsuba's own D and G₁.

Mitsuba masks each direction by itself, G = G₁(l) G₁(e); `mlt` correlates heights where light is reflected, G₂ = 1/(1/G₁(l) + 1/G₁(e) − 1)
[Heitz 2014]. `mlt` also adds what microfacets reflect more than once [Kulla & Conty 2017].
"""

import functools

import mitsuba as mi
import numpy as np

NORMALS = 4096


def distribution(along, across):
    """GGX with visible normals."""
    return mi.MicrofacetDistribution(mi.MicrofacetType.GGX, along, across, True)


def halves(rows):
    """Unit half vectors, on the front."""
    sums = rows[:, :3] + rows[:, 3:6]
    sums /= np.linalg.norm(sums, axis=1, keepdims=True)
    return sums * np.sign(sums[:, 2:])


def masked(facets, directions, normals):
    """G₁ of each direction on the front."""
    return np.array([facets.smith_g1(mi.Vector3f(*v), mi.Vector3f(*m)) for v, m in zip(directions, normals)])


def heights_correlated(made, rows, along, across):
    """Values with G₂ in place of the product of two G₁, where light is reflected."""
    mirrored = np.flatnonzero((rows[:, 2] * rows[:, 5] > 0) & (made[:, 0] > 0))
    facets, picked = distribution(along, across), rows[mirrored]
    front = np.sign(picked[:, 2:3])
    normals = halves(picked * np.where(np.arange(rows.shape[1]) < 6, front, 1.0))
    eye, light = (masked(facets, front * picked[:, part], normals) for part in (slice(0, 3), slice(3, 6)))
    made[mirrored, 0] /= eye + light - eye * light
    return made


@functools.cache
def lacking(alpha, cosine):
    """m = 1 − E: what leaves towards a direction after more than one meeting, where nothing is absorbed.

    E = ∫ G₂/G₁ over visible normals, which a lattice in the unit square is turned into by Mitsuba.
    """
    facets = distribution(alpha, alpha)
    eye = mi.Vector3f(float(np.sqrt(1.0 - cosine**2)), 0.0, cosine)
    kept = 0.0
    for i in range(NORMALS):
        normal, _ = facets.sample(eye, mi.Point2f((i + 0.5) / NORMALS, (i * 0.6180339887498949) % 1.0))
        light = mi.reflect(eye, normal)
        if light[2] > 0.0:
            g_eye, g_light = facets.smith_g1(eye, normal), facets.smith_g1(light, normal)
            kept += g_light / (g_eye + g_light - g_eye * g_light)
    return 1.0 - kept / NORMALS


@functools.cache
def mean_lacking(alpha):
    """∫ m 2μ dμ by Gauss and Legendre, in √μ since m is steep at grazing angles."""
    nodes, weights = np.polynomial.legendre.leggauss(24)
    roots = 0.5 * (nodes + 1.0)
    return sum(2.0 * w * x**3 * lacking(alpha, float(x * x)) for x, w in zip(roots, weights))


def met_again(rows, reflectance, alpha):
    """cosθ F_m m(e) m(l)/(π m̄), F_m = F̄² Ē/(1 − F̄ m̄), Ē = 1 − m̄, F̄ = F₀ + (1 − F₀)/21."""
    mean, average = mean_lacking(alpha), reflectance + (1.0 - reflectance) / 21.0
    share = average**2 * (1.0 - mean) / (1.0 - average * mean)
    eye, light = ([lacking(alpha, float(round(cos, 6))) for cos in rows[:, column]] for column in (2, 5))
    return rows[:, 5] * share * np.array(eye) * np.array(light) / (np.pi * mean)
