# SPDX-License-Identifier: MIT
"""Changes of Blender's data that are taken back: each is undone when an `ExitStack` is closed."""

from copy import copy


def change(later, target, name, value):
    """Gives a property of `target` another value."""
    later.callback(setattr, target, name, copy(getattr(target, name)))
    setattr(target, name, value)


def tag(later, target, name, value):
    """Gives `target` a custom property, which the exporter writes as extras; one that it has already stands."""
    if name not in target:
        target[name] = value
        later.callback(target.__delitem__, name)


def keep(later, collection, made):
    """Removes a data block that was made from a collection of `bpy.data`; returns it."""
    later.callback(collection.remove, made)
    return made
