# SPDX-License-Identifier: MIT
"""What a planner found."""

import os

import numpy as np

from ..study.case import Models, carried_out
from ..study.study import scene_of
from .commands import placed_scene, write_motion
from .uncertain import wilson


class Plans(list):
    """Of acus.plan, the best first. `cases`: how many insertions were simulated; `target` (3,) m."""

    def __init__(self, question, cases, plans, error=""):
        """`error`: of a sample that failed."""
        super().__init__(plans)
        self.cases, self.target, self.radius, self.problem = cases, question.problem.target, question.problem.radius, question.problem
        self.folder, self._error = question.folder, error

    def __str__(self):
        names = [name for name, _ in self.problem.avoid]
        header = ["plan", "succeeds", "(95 %)", "hits", "clear", "miss mm", *(f"to {name} mm" for name in names), "force N",
                  "entry mm", "depth mm", "tilt deg", "turn deg", "flips mm", "spins"]
        rows = [header] + [[str(number), *plan.cells()] for number, plan in enumerate(self)]
        widths = [max(map(len, column)) for column in zip(*rows)]
        return "\n".join(["  ".join(cell.rjust(width) for cell, width in zip(row, widths)) for row in rows] + self.notes)

    @property
    def notes(self):
        """Sentences on why nothing succeeds, where that is so."""
        if not self or self[0].probability > 0:
            return []
        reasons = [(all(not any(plan.outcomes) for plan in self), f"all samples failed: {self._error}"),
                   (max(plan.entered for plan in self) == 0,
                    "in no plan the tip goes in where it should: it slips, or does not get through the surface"),
                   (max(plan.hit for plan in self) == 0, f"in no plan the tip comes within {1e3 * self.radius:g} mm of the target"),
                   (max(plan.clear for plan in self) == 0, "no plan keeps clear of " + ", ".join(name for name, _ in self.problem.avoid))]
        return ["no plan succeeds in any sample; " + next((text for holds, text in reasons if holds), "those that hit are not clear")
                + "; a larger tilt, entry_region or cases may help"]

    def draw(self, path, number=0):
        """A picture (.png, .svg, .pdf) of a plan from two sides: what its needle cuts in all samples, the target, what is to
        be avoided. Needs matplotlib."""
        from .pictures import draw  # pylint: disable=import-outside-toplevel
        draw(self, self[number], os.fspath(path))


class Plan:
    """An insertion and how it goes: `motion`, an Insertion; `probability` that it succeeds, and its `interval` of 95 %; the shares
    `entered`, that it goes in where it should, `hit`, that it ends within the radius of the target, `clear`, that it keeps
    away from all that is to be avoided; `miss`, mean distance from the tip to the target, m; `clearance`, {name: smallest of all
    samples, m}; `force`, the largest, N; `outcomes` of the samples, None where one failed, and `nominal`, of the scene as it
    is."""

    def __init__(self, question, motion, outcomes):
        self._question, self.motion = question, motion
        self.nominal = outcomes[0]
        self.outcomes = outcomes[1:] or outcomes
        known = [each for each in self.outcomes if each is not None]
        count, self.failed = len(self.outcomes), len(self.outcomes) - len(known)
        succeed = sum(map(self.succeeds, known))
        self.probability, self.interval = succeed / count, wilson(succeed, count)
        self.entered = sum(map(self._enters, known)) / count
        self.hit, self.clear = sum(map(self._hits, known)) / count, sum(each.margin > 0 for each in known) / count
        self.miss = float(np.mean([np.linalg.norm(each.miss) for each in known])) if known else np.nan
        self.force = max((each.force for each in known), default=np.nan)
        self.clearance = {name: min((each.clearance[name] for each in known), default=np.nan) for name, _ in question.problem.avoid}

    def succeeds(self, outcome):
        """Whether one of the outcomes enters, hits and is clear."""
        return self._enters(outcome) and self._hits(outcome) and outcome.margin > 0

    def _enters(self, outcome):
        return outcome.enters(np.array(self.motion.entry), self.motion.direction)

    def _hits(self, outcome):
        return bool(np.linalg.norm(outcome.miss) <= self._question.problem.radius)

    @property
    def margin(self):
        """m, the smallest clearance of all."""
        return min(self.clearance.values(), default=np.inf)

    @property
    def tilt(self):
        """rad, from the scene's direction."""
        return float(np.arccos(np.clip(np.array(self.motion.direction) @ self._question.problem.axis, -1, 1)))

    def __repr__(self):
        low, high = self.interval
        return f"<plan: succeeds with {self.probability:.2f} ({low:.2f} to {high:.2f}), misses by {1e3 * self.miss:.2f} mm>"

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
        recording = None if recording is None else os.fspath(recording)
        return carried_out(self.motion, Models().load(self._question.scene), recording=recording)

    def place(self, scene=None):
        """A copy of the planned scene, or of another one with this needle, with needle and guides where the plan begins."""
        return placed_scene(self._question.scene if scene is None else scene_of(scene), self.motion)

    def write(self, path):
        """`path`.yaml, place(), and `path`.csv, the plan's trajectory: for acus-server and acus-replay as they are. Both
        paths."""
        return write_motion(path, self._question.scene, self.motion)
