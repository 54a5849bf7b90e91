# SPDX-License-Identifier: MIT
"""What a planner does not know exactly: factors of a whole scene, or values of single fields."""

import dataclasses

import numpy as np

from ..distributions import LogUniform
from ..errors import PlanError, SceneError
from ..study.designs import latin_hypercube, quantiles_of

FACTORS = {"stiffness": LogUniform(0.8, 1.25), "friction": LogUniform(0.8, 1.25), "bevel": LogUniform(0.9, 1.1)}
UNNAMED = "needle"  # the name of a needle without one
FRICTION = ("friction_static", "friction_dynamic", "friction_viscous")


@dataclasses.dataclass(frozen=True)
class Factors:
    """A study's `prepare`: multiplies Young's moduli of all regions ("stiffness"), friction of all ("friction"), and how far a
    needle's cutting direction, or the point of its bevel, is off its axis ("bevel")."""

    needle: str = None

    def __call__(self, scene, values):
        for region in range(len(scene["tissue.regions"] or ())):
            scale(scene, f"tissue.regions[{region}].material.young_modulus", values.get("stiffness", 1))
            for name in FRICTION:
                scale(scene, f"tissue.regions[{region}].interaction.{name}", values.get("friction", 1))
        for number, needle in enumerate(scene["needles"]):
            if self.needle not in (None, needle.get("name", UNNAMED)):
                continue
            places = [f"cutting_direction[{axis}]" for axis in (1, 2) if "cutting_direction" in needle]
            for place in places + ["point_offset"] * ("point_side" in needle):
                scale(scene, f"needles[{number}].{place}", values.get("bevel", 1))


def number_of(scene, name):
    """Of a needle in the scene."""
    return next(number for number, each in enumerate(scene["needles"]) if each.get("name", UNNAMED) == name)


def scale(scene, place, factor):
    """Also of fields that the scene leaves at their defaults."""
    if factor != 1 and (value := scene[place]):
        scene[place] = float(value) * factor


def draws_of(uncertain, count, scene, seed):
    """[{name: value}]: nothing changed, then `count` cases that cover the distributions evenly. Raises PlanError."""
    for name in uncertain:
        if name in FACTORS:
            check_factor(name, uncertain[name])
            continue
        try:
            scene.schema_at(name)
        except SceneError as error:
            raise PlanError(f"uncertain: expected {', '.join(FACTORS)} or a field; {error}") from None
    if not uncertain:
        return [{}]
    design = latin_hypercube(uncertain, count, seed)
    return [{}, *(design[case] for case in range(count))]


def neutral(name, scene):
    """The value of a factor or a field that changes nothing."""
    return 1.0 if name in FACTORS else scene[name]


def check_factor(name, given):
    if any(quantiles_of({name: given})[name].at(u) <= 0 for u in (0.0, 0.001, 0.5)):
        raise PlanError(f"uncertain: {name}: expected factors above 0, found {given!r}")


def wilson(hits, count, z=1.96):
    """The interval of 95 % of a share, of so many hits in `count`: Wilson (1927)."""
    if not count:
        return 0.0, 1.0
    share, spread = hits / count, z * z / count
    middle = (share + spread / 2) / (1 + spread)
    half = z / (1 + spread) * np.sqrt(share * (1 - share) / count + spread / (4 * count))
    # Exact at its ends, where rounding would leave out the share itself.
    return (float(middle - half) if hits else 0.0), (float(middle + half) if hits < count else 1.0)
