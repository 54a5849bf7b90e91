# SPDX-License-Identifier: MIT
"""Where a needle should go in: acus.plan()."""

import dataclasses
import math
import os
import sys

import numpy as np

from ..errors import PlanError
from ..study import Insertion, Study, table
from ..study.workers import processors
from .approach import Approach, Judged, JudgedEnds
from .candidates import Candidate, Outcome, follow, score
from .entries import entries_of
from .plans import Plan, Plans
from .question import Question, is_bevel
from .uncertain import Factors, neutral

SHARES = {"coarse": 0.2, "search": 0.3}  # of all cases; the rest are samples
TURNS = 8  # sides of a bevel that a coarse search tries
FLIPS = (0.25, 0.5, 0.75)  # of the way to the target
PITCH = 2.5e-3  # m of way in which a needle that is to go straight makes a turn
ROUND, PARENTS = 12, 4  # cases of a round of the search; whose neighbours it tries
MOST_PLANS = 8
BEYOND = 0.012  # m that an approach may go deeper than the target at rest
CLOSE = 0.25  # of the radius: a miss that needs no correction
LEAST, IDLE = 20, 0.85  # cases; of the time, which they take
LEAST_COARSE = 4  # insertions


def plan(scene, target, entry_region=None, avoid=None, samples=30, *, radius=2e-3, uncertain=None, tilt=0.6, speed=0.02, needle=None,
         cases=400, minutes=None, seed=0, folder=None, on=None, workers=None, progress=True):
    """Plans of how a needle meets a target, the best first.

    scene: a Scene, a scene file, or the name of one of the project. target: m, world, a point of the tissue as it lies at rest,
    or the name of a region, whose centroid it is. entry_region: part of the surface where the tip may go in, a shape as
    scenes have it, {"sphere": {"center": [0, 0, 0.06], "radius": 0.01}}, in the world; None: everywhere. avoid: shapes or
    names of regions, in a list or {name: each}. samples: cases in which each plan is tried.

    radius: m around the target that counts as hit. uncertain: {name: range or distribution} of fields of the scene, or of
    the factors "stiffness", "friction", "bevel"; by default these three, see uncertain.FACTORS; {}: nothing. tilt: rad, how
    far the direction may be from the scene's; 0: the direction stays, and the entry moves. speed: m/s. cases or minutes: how
    much is simulated. folder, on, workers, progress: as Study and its run() have them. Raises PlanError, SceneError,
    StudyError.
    """
    question = Question(scene, target, entry_region, avoid, samples, radius=radius, uncertain=uncertain, tilt=tilt, speed=speed,
                        needle=needle, cases=cases, minutes=minutes, seed=seed, folder=folder, on=on, workers=workers, progress=progress)
    return Planner(question).run()


class Planner:
    def __init__(self, question):
        self.question, self.problem, self.draws = question, question.problem, question.draws
        self.scene, self.needle, self.avoid = question.scene, question.needle, question.problem.avoid
        self.speed, self.cases = question.speed, question.cases
        self.random = np.random.default_rng(question.seed)
        self.done = 0  # cases
        self._first_error = ""

    # ---- The course of it ----

    def run(self):
        try:
            if self.question.minutes is not None:
                self.cases = self._cases_in(60 * self.question.minutes)
                self.question.check_cases(self.cases, "minutes")
            return self._sampled(self._chosen(self._search(self._coarse())))
        except KeyboardInterrupt:
            self._tell(f"interrupted after {self.done} insertions; the same call goes on from {self.question.folder}")
            raise

    def _coarse(self):
        """Straight towards the target from places all over the entry region, the bevel to all sides; branches of each flip on
        the way. Candidates whose paths follow from theirs."""
        bevel = is_bevel(self.needle)
        total = max(LEAST_COARSE, int(SHARES["coarse"] * self.cases))
        candidates = self._coarse_bevel(total) if bevel else [Candidate(entry, self._towards(entry)) for entry in self._entries(total)]
        found = self._approach("coarse search", candidates, branch=bevel)
        if not found:
            raise PlanError("no insertion of the coarse search went well; " + self._first_error)
        if not any(len(each.end.cut) for each in found):
            raise PlanError(f"the tip of '{self.needle.name}' enters the tissue nowhere; the largest force was "
                            f"{max(each.end.force for each in found):.3g} N: is the puncture_force of a region larger?")
        made = [follow(self.problem, each) for each in found]
        made += [follow(self.problem, each, turn) for each in found if bevel and not each.spin_rate
                 for turn in (2 * math.pi / TURNS, math.pi / TURNS)]
        made = [each for each in made if each is not None]
        if not made:
            raise PlanError(f"tilt: no direction within {self.problem.tilt:.3g} rad of the scene's needle leads from the entry region "
                            "to the target; give a larger tilt or another entry_region")
        return made

    def _coarse_bevel(self, total):
        """Where straight ways are free of walls, a third of the insertions spins along them."""
        free = []
        if self.problem.walls:
            free = [entry for entry in self._entries(max(1, total // 3)) if self.problem.corridor(entry) > 0]
        spun = [Candidate(entry, self._towards(entry), spin_rate=self.spin_rate) for entry in free]
        count = max(LEAST_COARSE, int((total - len(spun)) / (1 + len(FLIPS) / 2)))
        entries = self._entries(max(3, count // (TURNS // 2 + 1)))
        straight = [Candidate(entry, self._towards(entry)) for entry in entries]
        sides = [np.roll(np.arange(TURNS), -number)[::2 if len(entries) > 1 else 1] for number in range(len(entries))]
        ways = [[dataclasses.replace(each, turn=2 * math.pi * side / TURNS) for side in sides[number]] for number, each in enumerate(straight)]
        bent = [way for kind in zip(*ways) for way in kind]  # of each entry one, then another of each
        spun = spun or [dataclasses.replace(each, spin_rate=self.spin_rate) for each in straight][:max(1, count // (TURNS // 2 + 1))]
        return [*bent[:count - (0 if free else len(spun))], *spun]

    @property
    def spin_rate(self):
        """rad/s, of a needle that is to go straight."""
        return min(2 * math.pi * self.speed / PITCH, 0.9 * self.question.max_spin)

    def _search(self, pool):
        """Rounds of simulated candidates: the best so far are corrected by their miss, and their neighbours tried."""
        simulated, corrected, budget = [], set(), self.done + SHARES["search"] * self.cases
        batch = spread_out(self.problem, pool, ROUND)
        number = 0
        while self.done < budget or not simulated:
            number += 1
            simulated += self._approach(f"search, round {number}", batch[:max(1, min(ROUND, int(budget - self.done)))])
            if not simulated and number > 2:
                raise PlanError("no insertion of the search went well; " + self._first_error)
            batch = self._next(spread_out(self.problem, simulated, PARENTS), corrected) or spread_out(self.problem, pool, ROUND)
        return simulated

    def _next(self, parents, corrected):
        """`corrected`: ids of those that were; each is once."""
        missed = [each for each in parents if np.linalg.norm(each.end.miss) > CLOSE * self.problem.radius and id(each) not in corrected]
        corrected.update(map(id, missed))
        batch = [made for made in (follow(self.problem, each) for each in missed) if made is not None]
        for _ in range(20 * ROUND):
            if len(batch) >= ROUND:
                break
            parent = parents[self.random.integers(len(parents))]
            tried = [self._neighbour(parent) for _ in range(4)]
            tried = [each for each in tried if each is not None]
            if tried:
                batch.append(max(tried, key=lambda each: score(self.problem, each)))
        return batch

    def _neighbour(self, parent):
        random, entry = self.random, None
        if self.problem.tilt:
            moved = parent.entry + random.normal(scale=3e-3, size=3)
            found = self.problem.surface.hit(moved, parent.direction)
            entry = parent.entry if found is None else found[0]
        flips = tuple(sorted(max(1e-3, flip + random.normal(scale=4e-3)) for flip in parent.flips))
        return follow(self.problem, parent, random.normal(scale=0.3) if not parent.spin_rate else 0.0, entry, flips)

    def _chosen(self, simulated):
        """The best ones."""
        left = max(1, (self.cases - self.done) // self.question.samples_of_plan)
        return spread_out(self.problem, simulated, min(left, MOST_PLANS))

    def _sampled(self, chosen):
        """Plans: each runs in the same draws. After the first ones it is aimed at where these came out on average."""
        first = self._sample("first samples", [(each, each.end.depth) for each in chosen], self.question.first) if self.question.first else {}
        aimed = []
        for number, candidate in enumerate(chosen):
            misses = [outcome.miss for outcome in first.get(number, []) if outcome is not None]
            aimed.append(self._aimed(candidate, np.mean(misses, axis=0)) if misses else (candidate, candidate.end.depth))
        outcomes = self._sample("samples", aimed, self.draws)
        plans = [Plan(self.question, self._motion(candidate, depth), outcomes[number]) for number, (candidate, depth) in enumerate(aimed)]
        return Plans(self.question, self.done, sorted(plans, key=rank), self._first_error)

    def _aimed(self, candidate, miss):
        """(candidate, depth), by the mean miss of samples."""
        made = follow(self.problem, dataclasses.replace(candidate, end=dataclasses.replace(candidate.end, miss=miss)))
        if made is None:
            return candidate, candidate.end.depth
        along = miss + (candidate.entry - made.entry if not self.problem.tilt else 0.0)  # an entry that moves on slanted skin
        return made, candidate.end.depth + float(along @ candidate.direction)

    # ---- Parts ----

    def _approach(self, label, candidates, branch=False):
        """Those of the candidates that end well, with their ends; with `branch` those that flip on the way, too."""
        rows = []
        for each in candidates:
            way = float(np.linalg.norm(self.problem.target - each.entry))
            depth = min(way + BEYOND, self.problem.longest)
            tries = tuple(share * way for share in FLIPS) if branch and not each.spin_rate else ()
            rows.append({**each.values(), "depth": depth, "stop": each.stop, "tries": tries})
        motion = Approach(1.0, self.speed, needle=self.needle.name, clearance=self.question.clearance, target=tuple(self.problem.target))
        study = self._study(label, motion, rows, JudgedEnds(self._judged()))
        found = []
        for row in study.rows:
            if row["error"]:
                continue
            candidate = candidates[row["case"]]
            for number in range(1 + len(rows[row["case"]]["tries"])):
                if f"end.{number}.depth" in row:
                    end = Outcome.of(row, f"end.{number}", self.avoid)
                    flip = row[f"end.{number}.flip"]
                    flips = candidate.flips if flip is None else (flip,)
                    found.append(dataclasses.replace(candidate, flips=flips, end=end))
        return found

    def _sample(self, label, plans, draws):
        """{number of the plan: [Outcome of each draw, None where it failed]}"""
        rows, names = [], sorted(self.question.uncertain)
        for number, (candidate, depth) in enumerate(plans):
            for draw in draws:
                values = {name: draw.get(name, neutral(name, self.scene)) for name in names}
                rows.append({**candidate.values(), "depth": max(depth, 1e-3), "plan": number, **values})
        motion = Insertion(1.0, self.speed, needle=self.needle.name, clearance=self.question.clearance)
        study = self._study(label, motion, rows, self._judged(), names)
        found = {number: [None] * len(draws) for number in range(len(plans))}
        for row in study.rows:
            number, draw = divmod(row["case"], len(draws))
            if not row["error"]:
                found[number][draw] = Outcome.of(row, "end", self.avoid, plans[number][1])
        return found

    def _study(self, label, motion, rows, output, names=()):
        rows = [{name if name in names or name == "plan" else "motion." + name: value for name, value in row.items()} for row in rows]
        folder = os.path.join(self.question.folder, label.split(",")[0].replace(" ", "_"))
        prepare = Factors(self.needle.name) if "plan" in rows[0] else None
        study = Study(self.scene, motion, table(rows), {"end": output}, folder=folder, seed=self.question.seed, prepare=prepare)
        self._tell(f"{label}: {len(rows)} insertions")
        study.run(on=self.question.on, workers=self.question.workers, progress=self.question.progress)
        self.done += len(rows)
        self._first_error = next((row["error"] for row in study.rows if row["error"]), "")
        self._wall_time = study.rows[0]["wall_time"]
        return study

    def _judged(self):
        return Judged(tuple(self.problem.target), self.avoid)

    def _motion(self, candidate, depth):
        return Insertion(max(depth, 1e-3), self.speed, needle=self.needle.name, clearance=self.question.clearance, **candidate.values())

    def _towards(self, entry):
        if not self.problem.tilt:
            return self.problem.axis
        way = self.problem.target - entry
        return way / np.linalg.norm(way)

    def _entries(self, count):
        return entries_of(self.problem, count, self.question.seed)

    def _tell(self, text):
        if self.question.progress:
            sys.stderr.write(text + "\n")

    def _cases_in(self, seconds):
        """By the time of a first insertion, of which the row tells when it is there already."""
        entry, workers = self._entries(1)[0], self.question.workers
        self._approach("first insertion", [Candidate(entry, self._towards(entry))])
        return max(LEAST, int(IDLE * seconds / self._wall_time * (processors() if workers is None else max(1, workers))))


def rank(plan):
    """What succeeds more often, then what has more clearance, then what takes less force."""
    return -plan.probability, -np.nan_to_num(min(plan.margin, 1.0), nan=-1.0), np.nan_to_num(plan.force, nan=np.inf)


def spread_out(problem, candidates, count):
    """The best, of which no two are nearly alike, and no kind has more than half of the places as long as others have good
    ones."""
    chosen, kinds = [], {}
    ordered = sorted(candidates, key=lambda each: -score(problem, each))
    for limit in (max(1, count // 2), count):
        for each in ordered:
            if len(chosen) == count:
                break
            if kinds.get(each.kind, 0) >= limit or any(alike(each, other) for other in chosen):
                continue
            chosen.append(each)
            kinds[each.kind] = kinds.get(each.kind, 0) + 1
    return chosen


def alike(a, b):
    turn = abs((a.turn - b.turn + math.pi) % (2 * math.pi) - math.pi)
    return (a.kind == b.kind and np.linalg.norm(a.entry - b.entry) < 2e-3 and (a.spin_rate or turn < 0.2)
            and all(abs(x - y) < 5e-3 for x, y in zip(a.flips, b.flips)))
