"""Things of flat triangles, written for both programs: triangles are n × 3 × 3, y is up, normals point outwards."""

import base64
import json

import numpy as np


def square(half, height):
    """A square that faces up."""
    a, b, c, d = (np.array([x, height, z]) for x, z in [(-half, half), (half, half), (half, -half), (-half, -half)])
    return np.array([[a, b, c], [a, c, d]])


def ball(radius, centre, rings=24):
    """A closed ball of facets."""
    turns = np.linspace(0.0, 2.0 * np.pi, 2 * rings + 1)
    turns[-1] = 0.0
    theta, phi = np.meshgrid(np.linspace(0.0, np.pi, rings + 1), turns, indexing="ij")
    theta[-1] = np.pi
    at = centre + radius * np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), -np.sin(theta) * np.sin(phi)], axis=-1)
    a, b, c, d = at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]
    lower, upper = np.stack([a, b, c], axis=2)[:-1], np.stack([a, c, d], axis=2)[1:]
    return np.concatenate([lower.reshape(-1, 3, 3), upper.reshape(-1, 3, 3)])


def write_ply(path, triangles):
    """For Mitsuba."""
    points = triangles.reshape(-1, 3).astype(np.float32)
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\nproperty float x\nproperty float y\nproperty float z\n"
    header += f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    faces = np.zeros(len(triangles), dtype=[("n", "u1"), ("corners", "<i4", 3)])
    faces["n"], faces["corners"] = 3, np.arange(len(points)).reshape(-1, 3)
    path.write_bytes(header.encode() + points.tobytes() + faces.tobytes())


def material(surface):
    """A surface in glTF: diffuse, or smooth glass."""
    colour = [surface["colour"]] * 3 + [1.0]
    made = {"pbrMetallicRoughness": {"baseColorFactor": colour, "metallicFactor": 0.0, "roughnessFactor": 0.0}}
    if surface["kind"] == "diffuse":
        return {**made, "extensions": {"KHR_materials_specular": {"specularFactor": 0.0}}}
    index = {"KHR_materials_ior": {"ior": surface["ior"]}}
    return {**made, "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1.0}, **index}}


def node_of_sun(sun):
    """A node that holds a sun whose light goes down at an angle, towards −z, and the lamp."""
    half = 0.5 * np.radians(sun["angle"])
    node = {"rotation": [-np.sin(half), 0.0, 0.0, np.cos(half)], "extensions": {"KHR_lights_punctual": {"light": 0}}}
    return node, {"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": sun["irradiance"]}]}}


def write_gltf(path, things, sun):
    """For `mlt`: triangles with surfaces, and a sun or none."""
    points = [triangles.reshape(-1, 3).astype(np.float32) for triangles, _ in things]
    starts = np.cumsum([0] + [p.nbytes for p in points])
    data = base64.b64encode(b"".join(p.tobytes() for p in points)).decode()
    nodes, extensions = [{"mesh": i} for i in range(len(things))], {}
    if sun:
        node, extensions = node_of_sun(sun)
        nodes.append(node)
    told = {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_ior", "KHR_materials_specular", "KHR_materials_transmission"],
        "extensions": extensions,
        "scene": 0,
        "scenes": [{"nodes": list(range(len(nodes)))}],
        "nodes": nodes,
        "materials": [material(surface) for _, surface in things],
        "meshes": [{"primitives": [{"attributes": {"POSITION": i}, "material": i}]} for i in range(len(things))],
        "accessors": [
            {"bufferView": i, "componentType": 5126, "count": len(p), "type": "VEC3", "min": p.min(0).tolist(), "max": p.max(0).tolist()}
            for i, p in enumerate(points)
        ],
        "bufferViews": [{"buffer": 0, "byteOffset": int(start), "byteLength": p.nbytes} for start, p in zip(starts, points)],
        "buffers": [{"byteLength": int(starts[-1]), "uri": f"data:application/octet-stream;base64,{data}"}],
    }
    path.write_text(json.dumps(told))
