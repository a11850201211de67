"""What turns Mitsuba's microfacets into those of `mlt`, by formulas of the literature and Mitsuba's own D and G₁.

Mitsuba masks each direction by itself, G = G₁(l) G₁(e); `mlt` correlates heights where light is reflected, G₂ = 1/(1/G₁(l) + 1/G₁(e) − 1)
[Heitz 2014]. `mlt` also adds what microfacets reflect more than once [Kulla & Conty 2017].
"""

import functools

import mitsuba as mi
import numpy as np

NORMALS = 2048


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
def lacking(alpha, cosine, index):
    """m = 1 − E: what leaves towards a direction after more than one meeting, where nothing is absorbed.

    E = ∫ F G₂/G₁(e) + (1 − F) G₁(t) over visible normals, which a lattice in the unit square is turned into by Mitsuba. `index`: that of the far
    side over that of the near one; infinite where all is reflected.
    """
    facets = distribution(alpha, alpha)
    eye = mi.Vector3f(float(np.sqrt(1.0 - cosine**2)), 0.0, cosine)
    kept = 0.0
    for i in range(NORMALS):
        normal, _ = facets.sample(eye, mi.Point2f((i + 0.5) / NORMALS, (i * 0.6180339887498949) % 1.0))
        met = sum(eye[k] * normal[k] for k in range(3))
        reflected, cosine_far, _, inverse = (1.0, 0.0, 0.0, 0.0) if np.isinf(index) else mi.fresnel(met, index)
        light, far = mi.reflect(eye, normal), mi.refract(eye, normal, cosine_far, inverse)
        if light[2] > 0.0:
            g_eye, g_light = facets.smith_g1(eye, normal), facets.smith_g1(light, normal)
            kept += reflected * g_light / (g_eye + g_light - g_eye * g_light)
        if reflected < 1.0 and far[2] < 0.0:
            kept += (1.0 - reflected) * facets.smith_g1(-far, normal)
    return 1.0 - kept / NORMALS


def mean(curve):
    """∫ · 2μ dμ by Gauss and Legendre, in √μ since curves are steep at grazing angles."""
    nodes, weights = np.polynomial.legendre.leggauss(24)
    return sum(2.0 * w * x**3 * curve(float(x * x)) for x, w in zip(0.5 * (nodes + 1.0), weights))


@functools.cache
def mean_lacking(alpha, index):
    """m̄."""
    return mean(lambda cosine: lacking(alpha, cosine, index))


def of_pairs(rows, alpha, front):
    """m of the direction to the eye and of that to the light; `front`: the index behind the surface."""
    index = lambda cosine: front if cosine > 0.0 else 1.0 / front
    return [np.array([lacking(alpha, abs(float(round(c, 6))), index(c)) for c in rows[:, column]]) for column in (2, 5)]


def reflected_again(rows, reflectance, alpha):
    """cosθ F_m m(e) m(l)/(π m̄), F_m = F̄² Ē/(1 − F̄ m̄), Ē = 1 − m̄, F̄ = F₀ + (1 − F₀)/21."""
    missing, average = mean_lacking(alpha, np.inf), reflectance + (1.0 - reflectance) / 21.0
    share = average**2 * (1.0 - missing) / (1.0 - average * missing)
    eye, light = of_pairs(rows, alpha, np.inf)
    return rows[:, 5] * share * eye * light / (np.pi * missing)


def met_again(rows, index, alpha):
    """cosθ ηₑ² m(e) m(l)/π times (1 − X/M)/M on one side and X/(M M') between two; M = η² m̄, X = (1 − F̄) min(M, M')."""
    rarer = max(index, 1.0 / index)
    passed = 1.0 - mean(lambda cosine: mi.fresnel(cosine, rarer)[0])
    front, back = mean_lacking(alpha, index), index**2 * mean_lacking(alpha, 1.0 / index)
    exchanged = passed * min(front, back)
    above, one_side = rows[:, 2] > 0.0, rows[:, 2] * rows[:, 5] > 0.0
    own = np.where(above, front, back)
    share = np.where(one_side, (1.0 - exchanged / own) / own, exchanged / (front * back))
    eye, light = of_pairs(rows, alpha, index)
    return np.abs(rows[:, 5]) * share * np.where(above, 1.0, index**2) * eye * light / np.pi
