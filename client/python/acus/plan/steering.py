# SPDX-License-Identifier: MIT
"""Closed loop: an insertion that is corrected while it goes in, from measured tips."""

import dataclasses
import math

import numpy as np

from ..errors import PlanError
from ..study import Insertion
from ..study.case import Models
from ..study.study import scene_of
from ..study.values import check_vector
from ..study.world import World
from .approach import TissuePoint
from .checks import check_positive
from .uncertain import FACTORS, Factors

BELIEFS = ({}, {"stiffness": 0.25}, {"stiffness": 0.5}, {"stiffness": 2.0}, {"stiffness": 4.0}, {"bevel": 0.75}, {"bevel": 1.33})
TURN_RATE = 4 * math.pi  # rad/s of a bevel that is turned at rest
WINDOW = 0.02  # m of the way, over which measured tips are compared
SLOPE = 0.01  # of differences over the way, standard deviation before anything is measured
LEAST_NOISE = 2e-5  # m, of measured tips
HEADING = 5e-3  # m of the newest way, whose direction is that of the tip
GOOD = 1e-4  # m: a miss that needs no correction
TURN, SHIFT = 0.3, 3e-3  # rad, m: of bevel and flip, by which is found what they change
MOST_TURN, MOST_SHIFT = 1.5, 0.02  # rad, m of a correction
LAST = 5e-3  # m before the end, in which nothing flips: a tip springs aside when its bevel turns
LEAST_WAY = 1e-6  # m of a stride
FREE = 5e-3  # m of the needle that stays outside


class Steering:
    """Receding horizon on branches of worlds of what is believed.

    `scene`: what is believed of tissue and needle; coarser and slower ticks do. `motion`: the planned Insertion. One world goes
    along for each of `beliefs`, factors "stiffness", "friction", "bevel" by which the truth may differ. Each `stride` (m),
    next() is told where the tip was measured; the world that was nearest to it over the last 20 mm counts. What is measured
    differs from that one, too, by a + b s over the commanded way s (least squares), which is taken to go on. From `start` (m
    behind the entry) on, branches of that world go on to the target: as is intended, with the bevel turned a little, and with
    the next flip a little later. The turn and the flip with which the tip meets the target follow (Gauss-Newton). Raises
    PlanError, SceneError.
    """

    def __init__(self, scene, target, motion, *, beliefs=BELIEFS, stride=5e-3, start=0.01):
        for name, value in (("stride", stride), ("start", start)):
            check_positive(name, value)
        if not isinstance(motion, Insertion) or motion.entry is None or motion.direction is None:
            raise PlanError(f"motion: expected an Insertion with entry and direction, such as a Plan's, found {motion!r}")
        if motion.spin_rate:
            raise PlanError("motion: expected one that does not spin all the way: what goes straight cannot be steered")
        self.beliefs = [Belief(scene_of(scene), factors, target, motion) for factors in checked(beliefs)]
        self.stride, self.start = stride, motion.clearance + start
        world = self.beliefs[0].world
        self.course = Course(0.0, 0.0, tuple(motion.clearance + flip for flip in motion.flips), motion.speed * world.time_step, world.time_step)
        self.done, self.expected, self.reached = False, None, False

    # ---- For who steers ----

    def next(self, measured=()):
        """[(advance in m, spin in rad)], what to command in the next ticks, of the believed scene's rate; empty at the
        target. `measured`: [(count, tip)] or [(count, tip, target)] that have come since the last call: how many of all places
        had been commanded by then, and (3,) m, world. A target that is measured, too, may move otherwise than is believed.
        `expected` is then the miss (3,) m that is left, as far as is known, `reached` whether the needle comes to the target."""
        measured = list(measured)
        for belief in self.beliefs:
            belief.compare(measured)
        self.done = self.done or self.course.way >= self.beliefs[0].longest - LEAST_WAY
        if self.done:
            return []
        best = self._corrected()
        self.course, turn, end = best.course, best.turn, best.end
        self.expected, self.reached = best.miss, best.passed
        places, self.course, self.done = self.course.stride(self.stride, turn, end)
        for belief in self.beliefs:
            belief.go(places)
        return places

    @property
    def belief(self):
        """The Belief that is nearest to what was measured."""
        return min(self.beliefs, key=lambda each: each.error)

    # ---- Parts ----

    def _corrected(self):
        """The best Trial."""
        belief = self.belief
        best = Trial(belief, self.course, 0.0, self.stride)
        if best.size > GOOD and self.start <= self.course.way + 1e-9 < best.end - self.stride:
            best = min([best, *self._corrections(belief, best)], key=lambda each: (not each.passed, each.size))
        return best

    def _corrections(self, belief, now):
        """Trials of the whole and half the correction that follows from how turn and flip change the miss."""
        flip, latest = (*now.course.flips, now.end)[0], now.end - LAST
        shift = SHIFT if flip + SHIFT < latest else min(flip, latest) - SHIFT - flip
        turned = Trial(belief, now.course, TURN, self.stride)
        shifted = Trial(belief, now.course.with_flip(flip + shift, latest), 0.0, self.stride)
        changes = np.stack([(turned.miss - now.miss) / TURN, (shifted.miss - now.miss) / shift * SHIFT], axis=1)  # per rad, per 3 mm
        turn, shifts = np.linalg.lstsq(changes.T @ changes + 1e-10 * np.eye(2), -changes.T @ now.miss, rcond=None)[0]
        yield turned
        yield shifted
        for share in (1.0, 0.5):
            at = flip + float(np.clip(share * shifts * SHIFT, -MOST_SHIFT, MOST_SHIFT))
            course = now.course.with_flip(max(at, now.course.way), latest)
            yield Trial(belief, course, float(np.clip(share * turn, -MOST_TURN, MOST_TURN)), self.stride)


@dataclasses.dataclass(frozen=True)
class Course:
    """What is intended: from a way (m) and spin (rad) on, flips at ways; it goes forward by `feed` (m) a tick of `step` (s)."""

    way: float
    spin: float
    flips: tuple
    feed: float
    step: float

    def with_flip(self, way, latest=math.inf):
        """The next one there; none where that is later than `latest`."""
        return dataclasses.replace(self, flips=tuple(each for each in (way, *self.flips[1:]) if way <= each <= latest))

    def stride(self, length, turn=0.0, end=None):
        """([(advance, spin)], the Course after that, whether it has come to `end`): turned first, at rest."""
        way, spin, flips, places = self.way, self.spin, list(self.flips), []
        goal = self.way + length if end is None else min(self.way + length, end)
        places += self._turning(way, spin, turn)
        spin += turn
        while way < goal - 1e-9:
            if flips and way >= flips[0] - 1e-9:
                flips.pop(0)
                places += self._turning(way, spin, math.pi)
                spin += math.pi
            way = min(way + self.feed, goal)
            places.append((way, spin))
        return places, dataclasses.replace(self, way=way, spin=spin, flips=tuple(flips)), end is not None and way >= end - 1e-9

    def _turning(self, way, spin, turn):
        ticks = math.ceil(abs(turn) / (TURN_RATE * self.step) - 1e-9)
        return [(way, spin + turn * tick / ticks) for tick in range(1, ticks + 1)]


class Belief:
    """A World that goes along, of a scene changed by factors; how it compares to what is measured."""

    def __init__(self, scene, factors, target, motion):
        Factors(motion.needle)(scene, factors)
        model = Models().load(scene)
        self.factors, self.world = factors, World(model, bodies=motion.bodies(model))
        self.needle = self.world.needle(motion.needle)
        self.target = TissuePoint(model, check_vector("target", target), "target")
        self.longest = motion.clearance + self.needle.length - FREE  # m of way
        self.track = Track()
        self.track.add(0.0, self.world, self)
        self._differences = []  # (way, measured - believed)
        self._fit = (0.0, np.zeros(3), np.zeros(3))  # way, difference there, its slope

    @property
    def error(self):
        """m, root mean square of the differences over the window."""
        return float(np.sqrt(np.mean([each @ each for _, each in self._differences]))) if self._differences else float(len(self.factors))

    def difference(self, way):
        """(3,) m, from the believed tip to where it is; where targets are measured, less what they differ by."""
        middle, mean, slope = self._fit
        return mean + slope * (way - middle)

    def compare(self, measured):
        for count, tip, *target in measured:
            tick = min(max(0, int(count)), len(self.track.tips) - 1)
            difference = np.array(check_vector("tip", tip)) - self.track.tips[tick]
            if target:
                difference -= np.array(check_vector("target", target[0])) - self.track.targets[tick]
            self._differences.append((self.track.ways[tick], difference))
        if not self._differences:
            return
        newest = self._differences[-1][0]
        self._differences = [(way, each) for way, each in self._differences if newest - way < WINDOW]
        ways, values = map(np.array, zip(*self._differences))
        middle, mean = ways.mean(), values.mean(axis=0)
        spread, product = np.sum((ways - middle)**2), (ways - middle) @ (values - mean)
        rest = values - mean - np.outer(ways - middle, product / max(spread, 1e-12))
        slope = product / (spread + (np.mean(rest**2) + LEAST_NOISE**2) / SLOPE**2)
        self._fit = (middle, mean, slope)

    def go(self, places):
        for place in places:
            self.step(self.world, place)
            self.track.add(place[0], self.world, self)
        self.world.reports, self.world.tick_times = [], []  # nobody looks at them, and branches copy them

    def step(self, world, place):
        world.drive(self.needle, *place)
        world.step()


class Trial:
    """A course, with a turn first, in a branch of a belief, to the target: `miss` (3,) m, what is left across the tip's way when
    it passes; `end`: the way (m) of the base then."""

    def __init__(self, belief, course, turn, stride):
        self.course, self.turn = course, turn
        self._belief, self._track = belief, Track()
        world = belief.world.branch()
        places, _, _ = course.stride(belief.longest - course.way, turn)
        self.passed = False
        for place in places:
            belief.step(world, place)
            self._track.add(place[0], world, belief)
            self.passed = self._passes(stride)
            if self.passed:
                break
        left, heading = self._left(), self._heading()
        self.miss = left - (left @ heading) * heading
        self.end = max(place[0] + min(0.0, float(left @ heading)), course.way)  # not as far beyond as a tick goes
        self.size = float(np.linalg.norm(self.miss))

    def _passes(self, near):
        left = self._left()
        return left @ self._belief.needle.axis < near and left @ self._heading() <= 0

    def _left(self):
        """From the tip to the target, as far as is known."""
        return self._track.targets[-1] - self._track.tips[-1] - self._belief.difference(self._track.ways[-1])

    def _heading(self):
        """Where the tip goes, of its last 5 mm, with the slope of the difference."""
        before, now = self._belief.track, self._track
        ways, tips = [*before.ways[-HEADING_TICKS:], *now.ways], [*before.tips[-HEADING_TICKS:], *now.tips]
        back = max((i for i, way in enumerate(ways) if ways[-1] - way >= HEADING), default=0)
        heading = tips[-1] - tips[back] + self._belief.difference(ways[-1]) - self._belief.difference(ways[back])
        length = np.linalg.norm(heading)
        return heading / length if length > 0 else self._belief.needle.axis


HEADING_TICKS = 1000  # of what was before a trial


class Track:
    """Of each tick: commanded way (m), tip and target (3,) m."""

    def __init__(self):
        self.ways, self.tips, self.targets = [], [], []

    def add(self, way, world, belief):
        self.ways.append(way)
        self.tips.append(np.array(world.state.needle_positions(belief.needle.name)[-1]))
        self.targets.append(belief.target.at(world.state))


def checked(beliefs):
    if not isinstance(beliefs, (list, tuple)) or not beliefs:
        raise PlanError(f"beliefs: expected a list of {{factor: value}}, found {beliefs!r}")
    for each in beliefs:
        if not isinstance(each, dict) or set(each) - set(FACTORS):
            raise PlanError(f"beliefs: expected {{factor: value}} of {', '.join(FACTORS)}, found {each!r}")
        for name, value in each.items():
            check_positive(f"beliefs: {name}", value)
    return beliefs
