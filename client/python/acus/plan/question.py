# SPDX-License-Identifier: MIT
"""What a planner is asked for, checked."""

import math
import os

import numpy as np

from ..errors import PlanError
from ..scene import Scene
from ..study.case import Models
from ..study.motions import HALF_TURN
from ..study.study import name_of, scene_of
from ..study.values import check_vector
from ..study.world import needle_of
from .approach import TissuePoint
from .candidates import Problem
from .checks import check_range, check_whole, named
from .shapes import FIELDS, Place
from .tissue import Surface, centroid_of
from .uncertain import FACTORS, draws_of, number_of

FIRST = 8  # samples after which a plan is aimed once more
FREE = 5e-3  # m of the needle that stays outside
FAR = 0.05  # m: a tip that is farther from the tissue in the scene begins nearer
NEAR = 5e-3  # m
SAMPLES = 0.5  # of the cases, at least
LEAST_SPIN = math.pi / HALF_TURN  # rad/s


class Question:
    """The arguments of acus.plan(), as it has them; `problem`, a Problem; `draws`, the samples. Raises PlanError, SceneError."""

    def __init__(self, scene, target, entry_region, avoid, samples, *, radius, uncertain, tilt, speed, needle, cases, minutes, seed,
                 folder, on, workers, progress):
        self.scene = scene_named("scene", scene)
        model = Models().load(self.scene)
        if not len(model.tetrahedra):
            raise PlanError("scene: it has no tissue that moves (tissue.rung: none)")
        self.needle = named("needle", lambda: needle_of(model.needles, needle))
        check_range("radius", radius, 1e-6, 1.0)
        check_range("tilt", tilt, 0, 1.5)
        check_range("speed", speed, 1e-6, radius * model.rate)  # a tick goes a radius at most
        for name, value, least in (("samples", samples, 1), ("cases", cases, 20), ("seed", seed, 0)):
            check_whole(name, value, least)
        if minutes is not None:
            check_range("minutes", minutes, 1e-3, 1e6)
        self.max_spin = self.scene[f"needles[{number_of(self.scene, self.needle.name)}].max_spin_speed"]
        if is_bevel(self.needle) and self.max_spin < LEAST_SPIN:
            raise PlanError(f"scene: the needle's max_spin_speed is {self.max_spin:g} rad/s; half a turn in {HALF_TURN} s takes "
                            f"{LEAST_SPIN:.3g} rad/s")
        if folder is not None and not str(folder):
            raise PlanError("folder: expected a path, found nothing")
        self.radius, self.speed, self.cases, self.minutes, self.seed = radius, speed, cases, minutes, seed
        self.uncertain = uncertainties(uncertain)
        self.problem = problem_of(self.scene, model, self.needle, target, entry_region, avoid, tilt, radius)
        self.clearance = clearance_of(self.needle, self.problem.surface)
        self.draws = draws_of(self.uncertain, samples, self.scene, seed)
        self.first = self.draws[:FIRST + 1] if len(self.draws) > FIRST + 1 else []
        if minutes is None:
            self.check_cases(cases, "cases")
        self.on, self.workers, self.progress = on, workers, progress
        self.folder = folder_of(self.scene, folder)

    @property
    def samples_of_plan(self):
        """How many insertions it takes to try a plan."""
        return len(self.first) + len(self.draws)

    def check_cases(self, cases, name):
        if self.samples_of_plan > SAMPLES * cases:
            raise PlanError(f"{name}: {cases} insertions are too few; to try one plan in its samples takes {self.samples_of_plan}, and half "
                            f"of all are for the search: give at least {math.ceil(self.samples_of_plan / SAMPLES)}, or fewer samples")


def problem_of(scene, model, needle, target, entry_region, avoid, tilt, radius):
    aimed_at = target if isinstance(target, str) else None
    if isinstance(target, str):
        if target not in model.regions:
            raise PlanError(f"target: the tissue has no region '{target}'; it has {', '.join(model.regions)}")
        target = centroid_of(model, target)
    target = np.array(named("target", lambda: check_vector("target", target)))
    TissuePoint(model, target, "target")
    places = tuple((name, Place(f"avoid[{name}]", given)) for name, given in each_of(avoid).items())
    entries = None if entry_region is None else Place("entry_region", entry_region)
    for place in [*(place for _, place in places), *([entries] if entries else [])]:
        place.check(model)
    problem = Problem(model, Surface(model), target, places, entries, needle.axis, tilt, radius, needle.length - FREE, needle.diameter / 2,
                      places + impassable(scene, {aimed_at, *(place.region for _, place in places)}))
    for name, clearance in problem.clearances(target[None]).items():
        if clearance <= 0:
            raise PlanError(f"avoid[{name}]: the target {target.tolist()} lies in it, or too near for the needle")
    return problem


def impassable(scene, left_out):
    """Regions that no force punctures, but for those named: ((name, Place), ...)."""
    regions = [f"tissue.regions[{number}]" for number in range(len(scene["tissue.regions"] or ()))]
    names = [scene[region + ".name"] for region in regions if scene[region + ".interaction.puncture_force"] == math.inf]
    return tuple((name, Place("scene", name)) for name in names if name not in left_out)


def is_bevel(needle):
    return bool(np.linalg.norm(np.asarray(needle.cutting_direction)[1:]) > 1e-6)


def clearance_of(needle, surface):
    """m from the tip to the tissue, as in the scene."""
    found = surface.hit(needle.tip_position, needle.axis)
    way = 0.0 if found is None else float((found[0] - needle.tip_position) @ needle.axis)
    return way if 0 < way < FAR else NEAR


def each_of(avoid):
    """{name: shape or region}."""
    if avoid is None:
        return {}
    if isinstance(avoid, str) or (isinstance(avoid, dict) and avoid and set(avoid) <= set(FIELDS)):
        avoid = [avoid]
    if isinstance(avoid, dict):
        return {str(name): each for name, each in avoid.items()}
    if not isinstance(avoid, (list, tuple)):
        raise PlanError(f"avoid: expected shapes or names of regions, or {{name: either}}, found {avoid!r}")
    return {each if isinstance(each, str) else f"shape {number}": each for number, each in enumerate(avoid, 1)}


# ---- Parts that other planners check, too ----


def scene_named(name, given):
    if not isinstance(given, (Scene, str, os.PathLike)):
        raise PlanError(f"{name}: expected a Scene, a file, or the name of a project scene, found {type(given).__name__}")
    return scene_of(given)


def folder_of(scene, folder):
    return os.path.abspath(folder or os.path.join("plans", name_of(scene)))


def uncertainties(given):
    """{name: range}; factors are above 0."""
    if given is None:
        return FACTORS
    if not isinstance(given, dict):
        raise PlanError(f"uncertain: expected {{name: range}}, found {given!r}")
    return dict(given)
