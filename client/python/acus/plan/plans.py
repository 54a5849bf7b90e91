# SPDX-License-Identifier: MIT
"""What a planner found."""

import csv
import os

import numpy as np

from ..errors import PlanError
from ..scene import plain
from ..study.case import Models
from ..study.outputs import Result
from ..study.study import scene_of
from ..study.world import World
from .uncertain import wilson

COLUMNS = ("t", "needle", "x", "y", "z", "qw", "qx", "qy", "qz", "spin")
REST = 0.5  # s at the end of a trajectory, in which a base that lags arrives


class Plans(list):
    """Of acus.plan, the best first. `cases`: how many insertions were simulated; `target` (3,) m."""

    def __init__(self, planner, plans):
        super().__init__(plans)
        self.cases, self.target, self.radius, self.problem = planner.done, planner.problem.target, planner.problem.radius, planner.problem
        self.folder = planner.folder

    def __str__(self):
        names = [name for name, _ in self.problem.avoid]
        header = ["plan", "succeeds", "(95 %)", "hits", "clear", "miss mm", *(f"to {name} mm" for name in names), "force N",
                  "entry mm", "depth mm", "tilt deg", "turn deg", "flips mm", "spins"]
        rows = [header] + [[str(number), *plan.cells()] for number, plan in enumerate(self)]
        widths = [max(map(len, column)) for column in zip(*rows)]
        return "\n".join("  ".join(cell.rjust(width) for cell, width in zip(row, widths)) for row in rows)

    def draw(self, path, number=0):
        """A picture (.png, .svg, .pdf) of a plan from two sides: what its needle cuts in all samples, the target, what is to
        be avoided. Needs matplotlib."""
        from .pictures import draw  # pylint: disable=import-outside-toplevel
        draw(self, self[number], os.fspath(path))


class Plan:
    """An insertion and how it goes: `motion`, an Insertion; `probability` that it hits the target within the radius and stays
    clear of all that is to be avoided, and its `interval` of 95 %; `hit` and `clear`, each alone; `miss`, mean distance from
    the tip to the target, m; `clearance`, {name: smallest of all samples, m}; `force`, the largest, N; `outcomes` of the
    samples, None where one failed, and `nominal`, of the scene as it is."""

    def __init__(self, planner, motion, outcomes):
        self._planner, self.motion = planner, motion
        self.nominal = outcomes[0]
        self.outcomes = outcomes[1:] or outcomes
        radius, known = planner.problem.radius, [each for each in self.outcomes if each is not None]
        hits = [each is not None and np.linalg.norm(each.miss) <= radius for each in self.outcomes]
        clear = [each is not None and each.margin > 0 for each in self.outcomes]
        both = sum(a and b for a, b in zip(hits, clear))
        self.hit, self.clear, self.probability = np.mean(hits), np.mean(clear), both / len(self.outcomes)
        self.interval = wilson(both, len(self.outcomes))
        self.failed = len(self.outcomes) - len(known)
        self.miss = float(np.mean([np.linalg.norm(each.miss) for each in known])) if known else np.nan
        self.force = max((each.force for each in known), default=np.nan)
        self.clearance = {name: min((each.clearance[name] for each in known), default=np.nan) for name, _ in planner.avoid}

    @property
    def margin(self):
        """m, the smallest clearance of all."""
        return min(self.clearance.values(), default=np.inf)

    @property
    def tilt(self):
        """rad, from the scene's direction."""
        return float(np.arccos(np.clip(np.array(self.motion.direction) @ self._planner.problem.axis, -1, 1)))

    def __repr__(self):
        return f"<plan: succeeds with {self.probability:.2f} ({self.interval[0]:.2f} to {self.interval[1]:.2f}), misses by {1e3 * self.miss:.2f} mm>"

    def cells(self):
        motion = self.motion
        turn = (np.degrees(motion.turn) + 180) % 360 - 180
        return [f"{self.probability:.2f}", f"{self.interval[0]:.2f}-{self.interval[1]:.2f}", f"{self.hit:.2f}", f"{self.clear:.2f}",
                f"{1e3 * self.miss:.2f}", *(f"{1e3 * each:.1f}" for each in self.clearance.values()), f"{self.force:.2f}",
                ", ".join(f"{1e3 * each:.1f}" for each in motion.entry), f"{1e3 * motion.depth:.1f}", f"{np.degrees(self.tilt):.1f}",
                f"{turn:.0f}", " ".join(f"{1e3 * each:.1f}" for each in motion.flips) or "-", "yes" if motion.spin_rate else "no"]

    def run(self, recording=None):
        """Simulates it in the scene as it is: a Result of acus.study. `recording`: the path of a new file, which acus-view
        shows."""
        model = Models().load(self._planner.scene)
        world = World(model, bodies=self.motion.bodies(model))
        if recording:
            world.state.record(os.fspath(recording))
        try:
            self.motion(world)
        finally:
            world.state.end_recording()
        return Result(world, self.motion.needle)

    def place(self, scene=None):
        """A copy of the planned scene, or of another one with this needle, with needle and guides where the plan begins."""
        scene = self._planner.scene.copy() if scene is None else scene_of(scene)
        model = Models().load(scene)
        world = World(model, bodies=self.motion.bodies(model))
        for number, needle in enumerate(world.needles):
            if needle.name == self.motion.needle:
                scene[f"needles[{number}].base.position"] = plain(needle.base_position)
                scene[f"needles[{number}].base.orientation"] = plain(needle.base_orientation)
        for number, guide in enumerate(world.guides):
            if guide.needle == self.motion.needle:
                scene[f"guides[{number}].pose.position"] = plain(guide.position)
                scene[f"guides[{number}].pose.orientation"] = plain(guide.orientation)
        return scene

    def write(self, path):
        """`path`.yaml, place(), and `path`.csv, the plan's trajectory: for acus-server and acus-replay as they are. Both
        paths."""
        path, scene = os.path.splitext(os.fspath(path))[0], self.place()
        model = Models().load(self._planner.scene)
        world = World(model, bodies=self.motion.bodies(model))
        needle = world.needle(self.motion.needle)
        try:
            scene.save(f"{path}.yaml")
            with open(f"{path}.csv", "w", newline="", encoding="utf-8") as file:
                writer = csv.writer(file, lineterminator="\n")
                writer.writerow(COLUMNS)
                places = [(0.0, 0.0), *self.motion.places(world)]
                times = [tick * world.time_step for tick in range(len(places))]
                for time, (advance, spin) in zip([*times, times[-1] + REST], [*places, places[-1]]):
                    position = needle.base_position + advance * needle.axis
                    writer.writerow([repr(time), needle.name, *map(repr, plain(position)),
                                     *map(repr, plain(needle.base_orientation)), repr(float(spin or 0))])
        except OSError as error:
            raise PlanError(f"{path}: {error.strerror}") from None
        return f"{path}.yaml", f"{path}.csv"
