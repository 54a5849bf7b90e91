# SPDX-License-Identifier: MIT
"""The scenes of the tasks: coarser than those of scenes/, at 100 to 200 Hz. Only that of needle_order is made of one."""

import math

from ..programs import find_scene
from ..scene import Scene

DOWN = [0.70710678, 0, 0.70710678, 0]  # an orientation: +x points down
SMOOTHING = 5e-3  # s: what an action tells is done before the next observation


def steering():
    """A nitinol needle with a bevel above a gel that is held at bottom and sides; after scenes/steering.yaml."""
    half, depth = 0.04, 0.06
    return Scene({
        "name": "reach",
        "rate": 100,
        "tissue": {
            "mesh": {"box": {"size": [2 * half, 2 * half, 2 * depth], "cells": [5, 5, 8]}},
            "regions": [{
                "name": "gel",
                "material": {"young_modulus": 30e3, "poisson_ratio": 0.45, "rayleigh_stiffness": 0.01},
                "interaction": {"puncture_force": 0.4, "cutting_force": 0.3, "pressure": 5e3, "friction_dynamic": 0.3,
                                "friction_static": 0.35, "friction_viscous": 50},
            }],
            "fixed": [{"box": {"max": [math.inf, math.inf, -depth]}},
                      {"box": {"max": [-half, math.inf, math.inf]}}, {"box": {"min": [half, -math.inf, -math.inf]}},
                      {"box": {"max": [math.inf, -half, math.inf]}}, {"box": {"min": [-math.inf, half, -math.inf]}}],
        },
        "needles": [{
            "name": "needle", "length": 0.16, "beams": 30, "outer_diameter": 0.8e-3, "torsional_friction": 1,
            "material": {"young_modulus": 60e9, "poisson_ratio": 0.33, "density": 6450, "rayleigh_stiffness": 1e-3},
            "cutting_direction": [1, 0.1, 0],
            "smoothing": SMOOTHING,
            "base": {"position": [0, 0, 0.23], "orientation": DOWN},
        }],
        "guides": [{"name": "template", "needle": "needle", "pose": {"position": [0, 0, 0.065], "orientation": DOWN}}],
    })


def layers():
    """Skin, fat and muscle, with friction that grows with speed; after scenes/layers.yaml."""
    def region(name, young_modulus, top, **interaction):
        shape = {} if top is None else {"half_space": {"point": [0, 0, top], "normal": [0, 0, -1]}}
        material = {"young_modulus": young_modulus, "poisson_ratio": 0.45, "rayleigh_stiffness": 0.01}
        return {"name": name, **shape, "material": material, "interaction": interaction}

    return Scene({
        "name": "force limit",
        "rate": 200,
        "tissue": {
            "mesh": {"box": {"size": [0.08, 0.08, 0.06], "cells": [6, 6, 12]}},
            "regions": [
                region("muscle", 30e3, None, puncture_force=0.7, cutting_force=0.4, pressure=6e3, friction_dynamic=0.4,
                       friction_static=0.45, friction_viscous=150),
                region("fat", 5e3, 0.005, puncture_force=0.45, cutting_force=0.15, pressure=2e3, friction_dynamic=0.2,
                       friction_static=0.25, friction_viscous=50),
                region("skin", 100e3, 0.025, puncture_force=0.9, cutting_force=0.3, pressure=10e3, friction_dynamic=0.3,
                       friction_static=0.35, friction_viscous=150),
            ],
            "fixed": [{"box": {"max": [math.inf, math.inf, -0.03]}}],
        },
        "needles": [{"name": "needle", "length": 0.1, "beams": 20, "outer_diameter": 1.2e-3, "smoothing": SMOOTHING,
                     "base": {"position": [0.003, 0.002, 0.14], "orientation": DOWN}}],
    })


def brachytherapy():
    """Six needles and the prostate of scenes/brachytherapy.yaml, at half its rate."""
    scene = Scene.read(find_scene("brachytherapy"))
    scene["rate"] = 100
    for needle in scene["needles"]:
        needle["beams"] = 15
    return scene
