# SPDX-License-Identifier: MIT
"""The camera: the one that is active, and its lens."""

import bpy

from .for_now import change, tag


def prepare(later, scene):
    """Leaves the active camera alone in the scene and gives it its lens; returns warnings."""
    active = scene.camera
    if active is None:
        raise ValueError("the scene has no camera")
    if active.data.type not in {"PERSP", "ORTHO"}:
        raise ValueError(f"{active.name}: mlt has perspective and orthographic cameras only")
    for other in scene.objects:
        if other.type == "CAMERA":
            change(later, other, "hide_render", other != active)
    focus(later, active)
    if active.data.shift_x or active.data.shift_y:
        return [f"{active.name}: its shift is not exported"]
    return []


def focus(later, camera):
    """Depth of field, by the names that mlt reads in a camera's extras."""
    dof = camera.data.dof
    if dof.use_dof and camera.data.type == "PERSP":
        tag(later, camera.data, "aperture_fstop", dof.aperture_fstop)
        tag(later, camera.data, "focus_distance", distance(camera))
        tag(later, camera.data, "lens", camera.data.lens)


def distance(camera):
    """Distance of what is in focus, along the viewing direction."""
    target = camera.data.dof.focus_object
    if target is None:
        return camera.data.dof.focus_distance
    depsgraph = bpy.context.evaluated_depsgraph_get()
    place = target.evaluated_get(depsgraph).matrix_world.translation
    return abs((camera.evaluated_get(depsgraph).matrix_world.inverted() @ place).z)
