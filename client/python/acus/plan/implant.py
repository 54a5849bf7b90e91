# SPDX-License-Identifier: MIT
"""Seeds laid by several needles: in which order the needles go in, and how far beside and beyond the targets they have to
aim, since each moves the tissue that the others are in."""

import dataclasses
import os
import sys

import numpy as np

from ..errors import PlanError
from ..study import Study, table
from ..study.case import Models
from ..study.motions import Insertion
from ..study.values import check_vector
from ..study.world import needle_of
from .approach import TissuePoint
from .checks import check_range, check_whole, named
from .commands import write_motion
from .question import folder_of, scene_named, uncertainties
from .tissue import Deformed
from .uncertain import Factors, draws_of, neutral


@dataclasses.dataclass(frozen=True)
class Implantation:
    """The needles go in one after the other, each to its deepest seed; then each, in the same order, lays its seeds on the way
    out. `world.notes["seeds"]` has where, {name: (seeds, 3)} m, at rest; NaN outside the tissue."""

    order: tuple  # names
    shifts: tuple  # (3,) m of each in that order, from where the scene has them
    depths: tuple  # of each: m along its axis from there, the deepest first
    speed: float

    def bodies(self, model):
        needles = {each.name: each for each in model.needles}
        return {name: (needles[name].base_position + shift, needles[name].base_orientation) for name, shift in zip(self.order, self.shifts)}

    def __call__(self, world):
        seeds = {}
        for name, depths in zip(self.order, self.depths):
            Insertion.check_base(world, world.needle(name), depths[0])
            go(world, name, 0.0, depths[0], self.speed)
        for name, depths in zip(self.order, self.depths):
            laid = []
            for before, depth in zip((depths[0], *depths), depths):
                go(world, name, before, depth, self.speed)
                tip = world.state.needle_positions(name)[-1]
                inside = world.report[name].depth > 0  # a tip that presses on the surface is not
                laid.append(Deformed(world.model, world.state.tissue_positions).at_rest([tip])[0] if inside else np.full(3, np.nan))
            seeds[name] = np.array(laid)
            go(world, name, depths[-1], 0.0, self.speed)
        world.notes["seeds"] = seeds


def go(world, name, begin, end, speed):
    """From one advance (m) to another, and rests there."""
    ticks, needle = max(1, world.ticks_of(abs(end - begin) / speed)), world.needle(name)
    for tick in range(1, ticks + 1):
        world.drive(needle, begin + (end - begin) * tick / ticks)
        world.step()
    world.settle(needle)


def laid(result):
    """Where the seeds are, m, at rest: {needle: {number: (3,)}}."""
    return {name: {str(i): point for i, point in enumerate(points)} for name, points in result.world.notes["seeds"].items()}


class Implant:
    """`order` of the needles; `motion`, an Implantation; `errors` (seeds,) m, how far each seed is from its target, in tissue at
    rest, and `straight`, of needles that aim at the targets as if nothing moved, in the scene's order; `samples` and
    `straight_samples` (samples, seeds), likewise under uncertainty."""

    def __init__(self, scene, motion, straight, errors, straight_samples, samples):
        self._scene, self.motion, self.order = scene, motion, list(motion.order)
        self.straight, self.errors, self.straight_samples, self.samples = straight, errors, straight_samples, samples

    def __repr__(self):
        return (f"<implant of {len(self.errors)} seeds by {len(self.order)} needles: mean error {1e3 * self.errors.mean():.2f} mm, "
                f"straight {1e3 * self.straight.mean():.2f} mm>")

    def write(self, path):
        """`path`.yaml and `path`.csv, for acus-server and acus-replay. Both paths."""
        return write_motion(path, self._scene, self.motion)


class Implanter:
    def __init__(self, scene, seeds, *, orders, rounds, samples, uncertain, speed, seed, folder, on, workers, progress):
        self.scene = scene_named("scene", scene)
        self.model = Models().load(self.scene)
        check_range("speed", speed, 1e-6, 10.0)
        for name, value, least in (("orders", orders, 1), ("rounds", rounds, 0), ("samples", samples, 1), ("seed", seed, 0)):
            check_whole(name, value, least)
        if not isinstance(seeds, dict) or not seeds:
            raise PlanError(f"seeds: expected {{needle: targets}}, found {seeds!r}")
        self.needles, self.targets = {}, {}
        for name, targets in seeds.items():
            place = f"seeds[{name}]"
            self.needles[name] = named(place, lambda name=name: needle_of(self.model.needles, name))
            points = named(place, lambda place=place, targets=targets: np.array([check_vector(place, each) for each in targets]).reshape(-1, 3))
            if not len(points):
                raise PlanError(f"seeds[{name}]: expected one target or more")
            for point in points:
                TissuePoint(self.model, point, place)
            self.targets[name] = points[np.argsort(-(points @ self.needles[name].axis), kind="stable")]  # the deepest first
        self.orders, self.rounds, self.speed, self.seed = orders, rounds, speed, seed
        self.uncertain = uncertainties(uncertain)
        self.draws = draws_of(self.uncertain, samples, self.scene, seed)
        self.on, self.workers, self.progress = on, workers, progress
        self.folder = folder_of(self.scene, folder)

    def run(self):
        straight = self._straight()
        orders = self._some_orders(straight)
        first = self._errors("orders", [self._ordered(straight, order) for order in orders])
        # All orders are corrected once: what the tissue does to the first needles can be foreseen, what is left counts.
        corrected = [self._corrected(self._ordered(straight, order), error) for order, error in zip(orders, first)]
        errors = self._errors("corrected orders", corrected)
        best = int(np.argmin([mean_of(each) for each in errors]))
        if not np.isfinite(mean_of(errors[best])):
            raise PlanError(self._lost(errors[best]))
        motion, error = corrected[best], errors[best]
        for number in range(self.rounds):
            tried = self._corrected(motion, error)
            found, = self._errors(f"correction, round {number + 1}", [tried])
            if mean_of(found) >= mean_of(error):
                break
            motion, error = tried, found
        count, every = len(self.draws), self._errors("samples", [straight, motion], self.draws)
        before, after = every[:count], every[count:]
        samples = [np.array([distances_of(each) for each in every[1:] or every]) for every in (before, after)]
        return Implant(self.scene, motion, distances_of(first[0]), distances_of(error), *samples)

    # ---- Parts ----

    def _straight(self):
        """Each needle on the mean line of its targets, in the scene's order."""
        order = tuple(each.name for each in self.model.needles if each.name in self.needles)
        shifts, depths = [], []
        for name in order:
            needle, targets = self.needles[name], self.targets[name]
            ways = targets - needle.tip_position
            along = ways @ needle.axis
            shifts.append(tuple((ways - along[:, None] * needle.axis).mean(axis=0)))
            depths.append(tuple(along))
        return Implantation(order, tuple(shifts), tuple(depths), self.speed)

    def _some_orders(self, straight):
        """The scene's first, and others by chance."""
        random, found = np.random.default_rng(self.seed), [straight.order]
        for _ in range(20 * self.orders):
            order = tuple(random.permutation(straight.order).tolist())
            if len(found) < self.orders and order not in found:
                found.append(order)
        return found

    @staticmethod
    def _ordered(motion, order):
        at = [motion.order.index(name) for name in order]
        shifts, depths = (tuple(each[i] for i in at) for each in (motion.shifts, motion.depths))
        return dataclasses.replace(motion, order=tuple(order), shifts=shifts, depths=depths)

    def _corrected(self, motion, errors):
        """By the errors (seeds, 3) of each needle: aside by their mean, along its axis each seed by its own."""
        shifts, depths = [], []
        for name, shift, way in zip(motion.order, motion.shifts, motion.depths):
            axis, error = self.needles[name].axis, np.nan_to_num(errors[name])  # what lies nowhere corrects nothing
            along = error @ axis
            shifts.append(tuple(np.array(shift) - (error - along[:, None] * axis).mean(axis=0)))
            depths.append(tuple(sorted(np.array(way) - along, reverse=True)))
        return dataclasses.replace(motion, shifts=tuple(shifts), depths=tuple(depths))

    def _errors(self, label, motions, draws=({},)):
        """{needle: (seeds, 3) m, from target to seed} of each motion, in each draw."""
        names = sorted(self.uncertain) if len(draws) > 1 else []
        rows = [{**{f"motion.{field}": getattr(motion, field) for field in ("order", "shifts", "depths")}, "draw": number,
                 **{name: draw.get(name, neutral(name, self.scene)) for name in names}}
                for motion in motions for number, draw in enumerate(draws)]
        folder = os.path.join(self.folder, label.split(",")[0].replace(" ", "_"))
        study = Study(self.scene, motions[0], table(rows), {"laid": laid}, folder=folder, seed=self.seed, prepare=Factors())
        if self.progress:
            sys.stderr.write(f"{label}: {len(rows)} implants of {sum(map(len, self.targets.values()))} seeds\n")
        study.run(on=self.on, workers=self.workers, progress=self.progress)
        if study.failures():
            raise PlanError(f"{label}: {sum(study.failures().values())} of {len(rows)} failed: {next(iter(study.failures()))}")
        return [{name: np.array([[row[f"laid.{name}.{i}.{axis}"] for axis in "xyz"] for i in range(len(targets))]) - targets
                 for name, targets in self.targets.items()} for row in study.rows]

    def _lost(self, errors):
        """Of a seed that came to lie outside the tissue."""
        name = next(name for name, each in errors.items() if not np.all(np.isfinite(each)))
        target = self.targets[name][np.flatnonzero(~np.all(np.isfinite(errors[name]), axis=1))[0]]
        return (f"seeds[{name}]: that for {target.tolist()} comes to lie outside the tissue in every order: does '{name}' enter, and is the "
                "target deep enough?")


def distances_of(errors):
    """m, of all seeds; NaN of one outside the tissue."""
    return np.concatenate([np.linalg.norm(each, axis=1) for each in errors.values()])


def mean_of(errors):
    """m; infinite where a seed is outside the tissue."""
    mean = float(np.mean(distances_of(errors)))
    return mean if np.isfinite(mean) else np.inf


def implant(scene, seeds, *, orders=24, rounds=3, samples=8, uncertain=None, speed=0.05, seed=0, folder=None, on=None, workers=None,
            progress=True):
    """An Implant: several needles lay seeds near targets, which they move.

    seeds: {needle: [(3,) m, world, at rest]}. Needles keep their directions; they go in one after the other, and lay their seeds
    on the way out. `orders` of the needles are tried, straight and corrected by what the seeds missed; the best is corrected in
    at most `rounds` more. samples, uncertain, folder, on, workers, progress as in acus.plan. Raises PlanError, SceneError.
    """
    return Implanter(scene, seeds, orders=orders, rounds=rounds, samples=samples, uncertain=uncertain, speed=speed, seed=seed, folder=folder,
                     on=on, workers=workers, progress=progress).run()
