# SPDX-License-Identifier: GPL-3.0-or-later
"""One insertion at a random place: a scene and the motion of its needle's base, of a number."""

import dataclasses
import os

import numpy as np

import acus
from acus.plan.tissue import boundary_of
from acus.rotation import orientation_along
from acus.scene import yaml

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
LIVER = os.path.join(os.path.dirname(ROOT), "shared", "data", "meshes", "sofa_liver.msh")
PROSTATE = os.path.join(ROOT, "scenes", "meshes", "prostate.msh")

EASE = 0.1  # s, of a change of speed: a hand's, so that what jumps is not the motion
AIR = 4e-3  # m, from the skin to the tip at the start


@dataclasses.dataclass
class Insertion:
    """What is run: `moves` are those of the base from tick to tick (n x 3, m, world)."""
    number: int
    scene: str  # YAML
    base: np.ndarray  # m
    orientation: np.ndarray  # w, x, y, z
    moves: np.ndarray
    about: dict  # of the draw, for tables


def draw(number):
    """The insertion of a number. Raises acus.SceneError where the tissue's mesh cannot be read."""
    random = np.random.default_rng(number)
    young, poisson = _log(random, 2e3, 200e3), float(random.uniform(0.3, 0.49))
    tissue, entry, normal, about = _body(random)
    tilt, azimuth = np.radians(random.uniform(0, 70)), random.uniform(0, 2 * np.pi)
    direction = _tilted(-normal, tilt, azimuth)
    diameter, length = _log(random, 0.3e-3, 2e-3), float(random.uniform(0.08, 0.15))
    rate, speed = int(random.choice([150, 250, 500, 1000])), _log(random, 0.02, 0.3)
    puncture = young * about["edge"] ** 2 * _log(random, 3e-3, 5)
    rung = "exact" if random.random() < 0.05 else "warped" if random.random() < 0.6 else "refined"
    regions = [_region(random, young, poisson, puncture)]
    if about["mesh"] == "box" and random.random() < 0.3:
        regions.append({"name": "below", "half_space": {"point": entry - normal * random.uniform(5e-3, 20e-3), "normal": -normal},
                        **_region(random, young * _log(random, 0.2, 5), poisson, puncture * _log(random, 0.3, 3))})
    elif about["mesh"] == "prostate":
        for name in ("prostate", "target"):
            regions.append({"name": name, "physical_group": name,
                            **_region(random, young * _log(random, 0.5, 5), poisson, puncture * _log(random, 0.3, 3))})
    if rung == "exact":  # which has no relaxation
        for region in regions:
            region["material"].pop("relaxation", None)
    relaxes = any("relaxation" in region["material"] for region in regions)
    tissue = {"rung": rung, **tissue, "regions": regions}
    if random.random() < 0.5:
        tissue["element"] = "nodal_pressure"
    elif rung == "warped" and not relaxes and random.random() < 0.2:
        tissue["window"] = int(random.choice([4, 8, 16]))
    tip = str(random.choice(["blunt", "bevel", "pencil", "trocar"]))
    needle = {"name": "n", "rung": str(random.choice(["rigid", "flexible", "flexible"])), "length": length, "beams": int(random.choice([10, 20, 30])),
              "outer_diameter": diameter, "tip": tip}
    if random.random() < 0.3:
        needle["material"] = {"young_modulus": 60e9, "poisson_ratio": 0.33, "density": 6450}
    base, orientation = entry - direction * (length + AIR), orientation_along(direction)
    needle["base"] = {"position": base, "orientation": orientation}
    scene = {"acus_scene": 1, "name": f"insertion {number}", "rate": rate, "tissue": tissue, "needles": [needle]}
    moves = _moves(random, direction, speed, rate)
    about = {**about, "young": young, "poisson": poisson, "tilt": float(np.degrees(tilt)), "diameter": diameter, "needle": needle["rung"],
             "tip": tip, "rate": rate, "speed": speed, "puncture": puncture, "puncture_ea2": puncture / (young * about["edge"] ** 2),
             "rung": rung, "element": tissue.get("element", "linear"), "window": tissue.get("window", 0),
             "relaxes": relaxes, "layers": len(regions)}
    return Insertion(number, yaml(scene), base, orientation, moves, about)


def _log(random, low, high):
    return float(np.exp(random.uniform(np.log(low), np.log(high))))


def _region(random, young, poisson, puncture):
    material = {"young_modulus": young, "poisson_ratio": poisson, "rayleigh_stiffness": _log(random, 1e-3, 3e-2)}
    if random.random() < 0.15:
        material["relaxation"] = [{"ratio": float(random.uniform(0.2, 1)), "time": _log(random, 0.02, 1)}]
    friction = float(random.uniform(0.1, 0.5))
    interaction = {"puncture_force": puncture, "cutting_force": puncture * float(random.uniform(0, 0.6)),
                   "friction_dynamic": friction, "friction_static": friction * float(random.uniform(1, 1.3)),
                   "friction_contact": float(random.choice([0, 0.3, 1.0]))}
    if random.random() < 0.5:
        interaction["pressure"] = young * float(random.uniform(0.05, 0.6))
    return {"material": material, "interaction": interaction}


def _body(random):
    """(fields of tissue, entry on its surface (m), normal out of it, what it is)."""
    kind = random.random()
    if kind < 0.15 and os.path.isfile(LIVER):
        return _of_file(random, "liver", LIVER, 0.034)
    if kind < 0.25:
        size, cells = np.array([0.08, 0.07, 0.085]), "file"
        tissue = {"mesh": {"gmsh": {"file": PROSTATE, "metres_per_unit": 0.001}},
                  "fixed": [{"box": {"max": [np.inf, np.inf, -0.0449]}}, {"box": {"min": [-np.inf, 0.0349, -np.inf]}}]}
        kind, half = "prostate", size / 2
        half[2] = 0.04
        edge = 8e-3
    else:
        size = random.uniform(0.04, 0.08, 3)
        cells = [int(each) for each in random.integers(4, 10, 3)]
        half, kind, edge = size / 2, "box", float(max(size / cells))
        tissue = {"mesh": {"box": {"size": size, "cells": cells}},
                  "fixed": [{"half_space": {"point": [0, 0, float(-half[2] + 1e-4)], "normal": [0, 0, 1]}}]}
    entry = np.array([*random.uniform(-0.7, 0.7, 2) * half[:2], half[2]])
    return tissue, entry, np.array([0, 0, 1.0]), {"mesh": kind, "edge": edge}


def _of_file(random, name, file, unit):
    """Of a mesh file, an entry anywhere on its surface that is not fixed."""
    mesh = {"gmsh": {"file": file, "metres_per_unit": unit}}
    loaded = acus.engine.load(yaml({"acus_scene": 1, "tissue": {"mesh": mesh, "regions": [{}]}, "needles": [{"name": "n", "length": 0.1, "base": {"position": [9, 9, 9]}}]}))
    nodes = loaded.rest_positions
    low, high = nodes.min(axis=0), nodes.max(axis=0)
    level = float(low[1] + 0.2 * (high[1] - low[1]))
    triangles = boundary_of(loaded.tetrahedra)
    corners = nodes[triangles]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sizes = np.linalg.norm(areas, axis=1) * (corners[:, :, 1].min(axis=1) > level + 5e-3)
    chosen = random.choice(len(triangles), p=sizes / sizes.sum())
    weights = random.dirichlet([1, 1, 1])
    tissue = {"mesh": mesh, "fixed": [{"half_space": {"point": [0, level, 0], "normal": [0, 1, 0]}}]}
    return tissue, weights @ corners[chosen], areas[chosen] / np.linalg.norm(areas[chosen]), {"mesh": name, "edge": float(np.sqrt(sizes[sizes > 0].mean()))}


def _tilted(axis, angle, azimuth):
    aside = np.cross(axis, [1.0, 0, 0] if abs(axis[0]) < 0.9 else [0, 1.0, 0])
    aside /= np.linalg.norm(aside)
    return np.cos(angle) * axis + np.sin(angle) * (np.cos(azimuth) * aside + np.sin(azimuth) * np.cross(axis, aside))


def _moves(random, direction, speed, rate):
    """In, in some aside, at rest, out."""
    deep = AIR + random.uniform(10e-3, 50e-3)
    aside = _tilted(direction, np.pi / 2, random.uniform(0, 2 * np.pi))
    parts = [(direction * speed, deep / speed), (0 * direction, random.uniform(0.05, 0.3))]
    if random.random() < 0.4:
        parts += [(aside * random.uniform(5e-3, 30e-3), random.uniform(0.1, 0.3)), (0 * direction, 0.05)]
    parts += [(-direction * speed, 1.1 * deep / speed), (0 * direction, 0.1)]
    velocities = np.concatenate([np.tile(velocity, (max(1, round(time * rate)), 1)) for velocity, time in parts])
    kernel = np.hanning(round(EASE * rate) + 2)
    kernel /= kernel.sum()
    eased = np.stack([np.convolve(velocities[:, axis], kernel) for axis in range(3)], axis=1)
    return eased / rate
