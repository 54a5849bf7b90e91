# SPDX-License-Identifier: MIT
"""What a study tells of a case: numbers, texts, vectors or dictionaries of these, by functions of a Result.

Those of OUTPUTS go by name, "peak_force", with a needle's name in brackets where it is not the motion's own or the first:
"peak_force[left]".
"""

import dataclasses
import math
import re
from functools import cached_property

import numpy as np

from ..errors import StudyError
from ..messages import flag_names
from ..own_files import write_image
from ..run import Run
from ..scene import plain
from ..tissue_points import TissuePoints
from .values import check_vector


class Result:
    """A case that has run: `parameters`, {name: value}; `world`, as its policy left it; `model` and `state` of acus.engine;
    `run`, a Run of all ticks; `track`, the Track of the needle that the motion names, or of the first; `needle` likewise."""

    def __init__(self, world, needle=None):
        self.world, self.parameters, self.model, self.state = world, world.parameters, world.model, world.state
        self.needle = world.needle(needle)

    @cached_property
    def run(self):
        if not self.world.reports:
            raise StudyError("the motion has made no tick")
        return Run.of_states([Tick(report, self.world.needles) for report in self.world.reports])

    @cached_property
    def track(self):
        return self.run[self.needle.name]

    def of(self, needle):
        """The same, of another needle."""
        other = Result(self.world, needle)
        other.__dict__["run"] = self.run
        return other

    def draw(self, path, target=None):
        """A picture of the end (.png): a cut along the needle, with a target (m, world). Needs matplotlib and pillow."""
        from PIL import Image  # pylint: disable=import-outside-toplevel  # with matplotlib
        from ..env.render import picture  # pylint: disable=import-outside-toplevel
        pixels = picture(self.model, self.state, self.needle, target, self.world.guides)
        write_image(path, Image.fromarray(pixels), StudyError)

    @property
    def flags(self):
        """The names of all that were set, in any tick."""
        every = 0
        for report in self.world.reports:
            every |= report.flags
        return flag_names(every)


class Tick(dict):
    """The report of a tick as Run takes it."""

    def __init__(self, report, needles):
        super().__init__({needle.name: report[needle.name] for needle in needles})
        self.events = report.events


def first_event(result, kind):
    """Of the needle; None if there was none."""
    return next((each for each in result.run.events if each.kind == kind and each.needle == result.needle.name), None)


def travel_at(result, event):
    """m, of the base along its first axis, in the tick of an event."""
    return float(result.track.travel[int(np.searchsorted(result.track.tick, event.tick))])


def peak_force(result):
    """N, the largest axial resistance at the base."""
    return float(np.max(result.track.axial_resistance))


def end_force(result):
    """N, axial resistance at the end."""
    return float(result.track.axial_resistance[-1])


def puncture_force(result):
    """N, at the tip in the first puncture; NaN without one."""
    event = first_event(result, "puncture")
    return event.force if event else math.nan


def puncture_travel(result):
    """m, way of the base from the first contact to the first puncture: how far the tissue gave way; NaN without one."""
    contact, puncture = first_event(result, "contact"), first_event(result, "puncture")
    return travel_at(result, puncture) - travel_at(result, contact) if contact and puncture else math.nan


def work(result):
    """J, of the holder on the needle: the integral of -(force . velocity) at the base, without turning."""
    way = np.diff(result.track.base_position, axis=0)
    force = 0.5 * (result.track.base_force[1:] + result.track.base_force[:-1])
    return float(-np.sum(force * way))


def depth(result):
    """m, of the needle inside the tissue at the end."""
    return float(result.track.depth[-1])


def tip(result):
    """(3,) m, at the end."""
    return result.track.tip_position[-1]


def deflection(result):
    """m, from the axis that the base had first to the tip at the end."""
    start, axis = result.needle.base_position, result.needle.axis
    way = result.track.tip_position[-1] - start
    return float(np.linalg.norm(way - (way @ axis) * axis))


def path_length(result):
    """m, of all that tips have cut, as it lies and is published at the end: from the mouth in the mesh, 1 to 3 mm shorter
    than `depth` of the needle in it."""
    return float(sum(np.sum(np.linalg.norm(np.diff(path, axis=0), axis=1)) for path in result.state.paths))


def swept_volume(result):
    """m^3, of all paths: their length times the needle's cross-section."""
    diameters = {needle.diameter for needle in result.world.needles}
    if len(diameters) > 1:
        raise StudyError("swept_volume: the scene's needles have different diameters; use path_length")
    return path_length(result) * math.pi / 4 * diameters.pop() ** 2


OUTPUTS = {each.__name__: each for each in (peak_force, end_force, puncture_force, puncture_travel, work, depth, tip,
                                            deflection, path_length, swept_volume)}


@dataclasses.dataclass(frozen=True)
class Distance:
    """m, from the tip at the end to a target (m, world, before anything moves). One that moves is a point of the tissue,
    which takes it along; else it stays where it is."""

    target: tuple
    moves: bool = True
    needle: str = None

    def __post_init__(self):
        object.__setattr__(self, "target", check_vector("Distance", self.target))

    def __call__(self, result):
        result = result.of(self.needle) if self.needle else result
        target = moved(result, np.array(self.target)) if self.moves else np.array(self.target)
        return float(np.linalg.norm(tip(result) - target))


def moved(result, point):
    """Where a point of the tissue is at the end."""
    points = TissuePoints(result.model, [point]) if len(result.model.tetrahedra) else None
    if points is None or points.outside[0]:
        raise StudyError(f"Distance: the target {point.tolist()} is not inside the tissue; moves=False keeps it in its place")
    return points.at(result.state.tissue_positions)[0]


# ---- What a study does with them ----


@dataclasses.dataclass(frozen=True)
class OfNeedle:
    output: object
    needle: str

    def __call__(self, result):
        return self.output(result.of(self.needle))


def outputs_of(given):
    """{name: function} of a name, a list of names and functions, or {name: name or function}."""
    if isinstance(given, str) or callable(given):
        given = [given]
    if not isinstance(given, (dict, list, tuple)):
        raise StudyError(f"outputs: expected names and functions, found {given!r}")
    pairs = given.items() if isinstance(given, dict) else [(name_of(each), each) for each in given]
    outputs = {}
    for name, each in pairs:
        if name in outputs:
            raise StudyError(f"outputs: '{name}' is there twice; give names, {{name: output}}")
        outputs[str(name)] = output_of(each)
    return outputs


def name_of(output):
    return output if isinstance(output, str) else getattr(output, "__name__", type(output).__name__.lower())


def output_of(given):
    if callable(given):
        return given
    found = re.fullmatch(r"(\w+)(?:\[(.+)\])?", given) if isinstance(given, str) else None
    if not found or found[1] not in OUTPUTS:
        raise StudyError(f"outputs: no output '{given}'; there are {', '.join(OUTPUTS)}, and your own functions of a Result")
    return OfNeedle(OUTPUTS[found[1]], found[2]) if found[2] else OUTPUTS[found[1]]


def flattened(name, value):
    """{column: number, text or truth}: name.x, name.y and name.z of a vector, name[i] of other lists, name.key of maps."""
    value = plain(value)
    if isinstance(value, dict):
        inside = {f"{name}.{key}": each for key, each in value.items()}
    elif isinstance(value, list):
        inside = dict(zip([f"{name}.{axis}" for axis in "xyz"] if len(value) == 3 else
                          [f"{name}[{i}]" for i in range(len(value))], value))
    elif value is None or isinstance(value, (bool, int, float, str)):
        return {name: value}
    else:
        raise StudyError(f"outputs: '{name}': expected numbers, texts, vectors or maps of them, found {value!r}")
    return {column: each for key, part in inside.items() for column, each in flattened(key, part).items()}
