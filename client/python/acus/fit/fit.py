# SPDX-License-Identifier: MIT
"""The fit: which values of a scene's parameters give the measured curves.

Four stages, each from the answer of the one before: cases spread over all ranges (a Latin hypercube), judged by the
features of their curves; least squares of the features; least squares of the points' distances from the curves
(curve.py), in which points that are far off count less (soft L1); a search along the directions that these slopes give. A
puncture happens in one tick or the next: misfits go in stairs, on which slopes end too soon and a search does not.

Parameters go from 0 to 1 over their range, by the logarithm where it is a LogUniform or wide. Slopes are differences of
whole runs, made side by side on all processors.
"""

import concurrent.futures
import dataclasses
import math
import sys
import threading

import numpy as np

from ..distributions import LogUniform, Uniform
from ..errors import AcusError, FitError
from ..study.case import MOTION
from ..study.designs import latin_hypercube
from ..study.motions import check_motion_name, policy_of, with_values
from ..study.pictures import short
from ..study.study import scene_of
from ..study.workers import processors
from .curve import LOOKS
from .features import features, misfit
from .fitted import Fitted
from .identify import doubts, identify, independent_points
from .measurement import OVER, Measurement, shares_of
from .simulated import simulated_curve

SHIFT = "data.shift"  # s or m: where the measured curve has the beginning of the motion
WIDE = 3.0  # high/low, from which a range above 0 goes by the logarithm
SPREAD = 8  # cases of the first stage, per parameter
STEP = 0.03  # of slopes, in units of the range
MOST = 12  # steps of a stage
FURTHEST = 0.15  # of a step of the search, in units of the range
SMALLEST = 0.1  # at which it ends, as a share of its first steps,
SEARCHED, FEWEST_ROUNDS = 100, 4  # or after so many runs, but as many rounds
NEAR = 0.05  # of a curve's size: misfits below count by their squares
WIDENED, WIDER = 6, 1.5  # times, by so much each, an interval at most
NARROWEST = 1e-3  # half of an interval, in units of the range
BEYOND = 0.2  # of the range of x, that data may go on after the motion has ended
FAILED = 10.0  # misfit of a run that fails, in sizes of the curve


class Fit:
    """`measurements`: a Measurement or several, fitted together. `parameters`: {name: range}, a range (low, high),
    Uniform or LogUniform; names are fields of the scene, parameters of the motions, motion.speed, and data.shift. Raises
    FitError, SceneError."""

    def __init__(self, scene, measurements, parameters):
        self.scene = scene_of(scene)
        self.measurements = [measurements] if isinstance(measurements, Measurement) else list(measurements)
        if not self.measurements:
            raise FitError("measurements: expected at least one")
        self.parameters = {name: Parameter(name, given) for name, given in dict(parameters).items()}
        if not self.parameters:
            raise FitError("parameters: expected at least one")
        self._motions = [policy_of(each.motion) for each in self.measurements]
        places = {}
        for name, parameter in self.parameters.items():
            self._check(name, parameter)
            place = name if name == SHIFT or name.startswith(MOTION) else (self.measurements[0].scene or self.scene).counted(name)
            if (other := places.setdefault(place, name)) != name:
                raise FitError(f"parameters: '{other}' and '{name}' are the same field")
        self._cache, self._lock, self._workers = {}, threading.Lock(), processors()
        self.runs = 0

    def _check(self, name, parameter):
        if name == SHIFT:
            return
        for each, motion in zip(self.measurements, self._motions):
            if name.startswith(MOTION):
                check_motion_name(motion, name.removeprefix(MOTION))
            else:
                check_range(name, (each.scene or self.scene).schema_at(name), parameter.range)

    @property
    def names(self):
        return list(self.parameters)

    def values(self, place):
        """{name: value} at a place, 0 to 1 for each parameter."""
        return {name: parameter.at(u) for (name, parameter), u in zip(self.parameters.items(), place)}

    def curves(self, values):
        """A simulated Curve for each measurement. Raises AcusError."""
        return [self._curve(each, motion, values) for each, motion in zip(self.measurements, self._motions)]

    def _curve(self, measurement, motion, values):
        scene = (measurement.scene or self.scene).copy()
        for name, value in values.items():
            if name != SHIFT and not name.startswith(MOTION):
                scene[name] = value
        moved = with_values(motion, {name.removeprefix(MOTION): value for name, value in values.items() if name.startswith(MOTION)})
        curve = simulated_curve(scene, moved, measurement.over, measurement.of).shifted(values.get(SHIFT, 0.0))
        if measurement.x[-1] > curve.x[-1] + BEYOND * np.ptp(measurement.x):
            unit = OVER[measurement.over]
            raise FitError(f"{measurement.name}: the data go on to {measurement.x[-1]:g} {unit}, the motion ends at {curve.x[-1]:g} {unit}; "
                           f"let it go as far, or leave out what is beyond")
        return curve

    # ---- Runs ----

    def _run(self, place):
        """Curves at a place, or the error."""
        key = tuple(np.round(place, 12))
        with self._lock:
            found = self._cache.get(key)
        if found is None:
            try:
                found = self.curves(self.values(place))
            except AcusError as error:
                found = error
            with self._lock:
                self._cache[key] = found
                self.runs += 1
        return found

    def _run_all(self, places):
        """The same of several, side by side."""
        with concurrent.futures.ThreadPoolExecutor(self._workers) as pool:
            return list(pool.map(self._run, places))

    def runs_that_can_be(self, places):
        """Curves of each place of several that can be run."""
        return [each for each in self._run_all(places) if not isinstance(each, AcusError)]

    def _residuals(self, stage, found):
        if isinstance(found, AcusError):
            return np.full(self._count(stage), FAILED)
        if stage == "features":
            parts = [misfit(wanted, features(*fitted_part(each, curve.at(each.x))))
                     for wanted, curve, each in zip(self._features, found, self.measurements)]
        else:
            parts = []
            for curve, each in zip(found, self.measurements):
                weights = each.weights[each.fitted]
                parts.append(softened(curve.misfit(each, each.fitted)) * np.sqrt(0.5 * weights / np.sum(weights)))
                parts.append(softened(curve.excess(each, each.fitted)) * math.sqrt(0.5 / LOOKS))
        return np.concatenate(parts)

    def _count(self, stage):
        if stage == "features":
            return sum(map(len, self._features))
        return sum(np.count_nonzero(each.fitted) + LOOKS for each in self.measurements)

    def _slopes(self, stage, place, both_sides=False):
        """d residuals / d place, by differences: to the side, or sides, where a run can be made; 0 where none can."""
        ways = [[sign * STEP for sign in (1, -1) if 0 <= q + sign * STEP <= 1] for q in place]
        sides = [(k, way) for k, each in enumerate(ways) for way in (each if both_sides else each[:1])]
        values = self._differences(stage, place, sides)
        left = [(k, way) for k, each in enumerate(ways) for way in each if not any(each_k == k for each_k, _ in values)]
        values.update(self._differences(stage, place, left))
        here, columns = self._residuals(stage, self._run(place)), []
        for k in range(len(place)):
            found = {way: value for (each, way), value in values.items() if each == k}
            if len(found) == 2:
                columns.append((found[STEP] - found[-STEP]) / (2 * STEP))
            else:
                columns.append(next(((value - here) / way for way, value in found.items()), np.zeros(len(here))))
        return np.column_stack(columns)

    def _differences(self, stage, place, sides):
        """{(parameter, way): residuals} of the runs beside a place that can be made."""
        found = self._run_all([place + way * np.eye(len(place))[k] for k, way in sides])
        return {side: self._residuals(stage, each) for side, each in zip(sides, found) if not isinstance(each, AcusError)}

    # ---- The stages ----

    def run(self, *, seed=0, spread=None, workers=None, progress=True):
        """A Fitted. `spread`: cases of the first stage (8 for each parameter); `workers`: runs at once (one for each
        processor). Raises FitError if no case can be run."""
        try:
            import scipy.optimize  # pylint: disable=import-outside-toplevel,unused-import  # takes a second
        except ImportError:
            raise FitError("a fit needs scipy (apt install python3-scipy)") from None
        self._workers = workers or self._workers
        self._features = [features(*fitted_part(each, each.y)) for each in self.measurements]
        tell = Teller(self, progress)
        place = self._spread_out(SPREAD * len(self.parameters) if spread is None else spread, seed, tell)
        for stage in ("features", "curves"):
            place = self._descend(stage, place, tell)
        place = self._search(place, tell)
        tell.end()
        return self._fitted(place)

    def _spread_out(self, count, seed, tell):
        design = latin_hypercube({name: (0.0, 1.0) for name in self.names}, max(1, count), seed)
        places = [np.full(len(self.names), 0.5)] + [np.array([design[i][name] for name in self.names]) for i in range(count)]
        best, least, errors = None, math.inf, []
        for begin in range(0, len(places), 2 * self._workers):
            batch = places[begin:begin + 2 * self._workers]
            for place, found in zip(batch, self._run_all(batch)):
                if isinstance(found, AcusError):
                    errors.append(found)
                    continue
                cost = float(np.sum(self._residuals("features", found)**2))
                if cost < least:
                    best, least = place, cost
            tell("spread", f"{min(begin + len(batch), len(places))} of {len(places)}", best, least)
        if best is None:
            raise FitError(f"no case of {len(places)} could be run, the first one: {errors[0]}")
        return best

    def _descend(self, stage, place, tell):
        from scipy.optimize import least_squares  # pylint: disable=import-outside-toplevel
        steps = []

        def slopes(q):
            steps.append(q)
            tell(stage, f"step {len(steps)}", q, self._cost(stage, q))
            return self._slopes(stage, q)

        answer = least_squares(lambda q: self._residuals(stage, self._run(q)), np.clip(place, 1e-6, 1 - 1e-6), slopes, bounds=(0, 1),
                               max_nfev=MOST, xtol=1e-4, ftol=1e-4)
        return np.clip(answer.x, 0, 1)

    def _cost(self, stage, place):
        return float(np.sum(self._residuals(stage, self._run(place))**2))

    def _search(self, place, tell):
        """To and fro along the singular directions of the slopes, and to some places at random, as far as the misfit allows,
        then less and less."""
        best, rounds, size, random = self._cost("curves", place), 0, 1.0, np.random.default_rng(len(place))
        _, strengths, directions = np.linalg.svd(self._slopes("curves", place, both_sides=True), full_matrices=False)
        reach = np.minimum(math.sqrt(best) / np.maximum(strengths, 1e-12), FURTHEST)
        most = max(FEWEST_ROUNDS, SEARCHED // (3 * len(place) + 1))
        while size > SMALLEST and rounds < most:
            rounds += 1
            moves = [sign * size * length * direction for length, direction in zip(reach, directions) for sign in (1, -1)]
            moves += [size * (random.normal(size=len(reach)) * reach) @ directions for _ in place]
            places = [np.clip(place + move, 0, 1) for move in moves]
            self._run_all(places)
            costs = [self._cost("curves", each) for each in places]
            together = np.clip(place + sum((move for move, cost in zip(moves, costs) if cost < best), np.zeros(len(place))), 0, 1)
            places.append(together)
            costs.append(self._cost("curves", together))
            nearest = int(np.argmin(costs))
            if costs[nearest] < (1 - 1e-3) * best:
                place, best = places[nearest], costs[nearest]
            else:
                size /= 2
            tell("search", f"round {rounds}", place, best)
        return place

    def _fitted(self, place):
        found = self._run(place)
        if isinstance(found, AcusError):
            raise FitError(f"the best case cannot be run: {found}")
        residuals = self._residuals("curves", found)
        independent = sum(independent_points(shares_of(each.x)[each.fitted], found[k].misfit(each, each.fitted))
                          for k, each in enumerate(self.measurements))
        slopes = self._slopes("curves", place, both_sides=True)
        known = identify(residuals, slopes, independent)
        (low, open_low), (high, open_high) = (self._end(place, known, residuals, sign) for sign in (-1, 1))
        why = doubts(self.names, place, low, high, known.correlation, slopes, residuals)
        for k in open_low + open_high:
            why.setdefault(self.names[k], "misfits do not rise where its interval should end")
        return Fitted(self, place, found, known, low, high, why)

    def _end(self, place, known, residuals, sign):
        """Of all intervals, to one side: as far as linear theory says, and on to where misfits have really risen by as much;
        and the parameters for which that is nowhere near."""
        wanted, reach = residuals @ residuals + known.rise, np.maximum(known.half_width, NARROWEST)
        going_on = list(range(len(place)))
        for widened in range(WIDENED + 1):
            places = [np.clip(place + sign * reach[k] * known.towards(k), 0, 1) for k in going_on]
            self._run_all(places)
            costs = [self._cost("curves", each) for each in places]
            going_on = [k for k, cost in zip(going_on, costs) if cost < wanted and 0 < place[k] + sign * reach[k] < 1]
            for k in going_on if widened < WIDENED else ():
                reach[k] *= WIDER
        return np.clip(place + sign * reach, 0, 1), going_on


@dataclasses.dataclass(frozen=True)
class Parameter:
    name: str
    range: object

    def __post_init__(self):
        given = self.range
        try:
            low, high = (given.low, given.high) if isinstance(given, Uniform | LogUniform) else map(float, given)
        except (TypeError, ValueError):
            raise FitError(f"{self.name}: expected a range (low, high), found {given!r}") from None
        if not (math.isfinite(low) and math.isfinite(high) and low < high):
            raise FitError(f"{self.name}: expected a range from low to high, found {low:g} to {high:g}")
        logarithmic = isinstance(given, LogUniform) or (not isinstance(given, Uniform) and low > 0 and high / low >= WIDE)
        object.__setattr__(self, "range", (LogUniform if logarithmic else Uniform)(low, high))

    def at(self, u):
        return self.range.at(float(u))


def check_range(name, schema, given):
    """That a field takes any number of a range, by its schema."""
    if schema.get("type") != "number":
        raise FitError(f"{name}: expected a field that is a number, found one of the type {schema.get('type', 'map or list')}")
    least = max(schema.get("minimum", -math.inf), schema.get("exclusiveMinimum", -math.inf))
    most = min(schema.get("maximum", math.inf), schema.get("exclusiveMaximum", math.inf))
    if given.low < least or given.high > most or given.low == schema.get("exclusiveMinimum") or given.high == schema.get("exclusiveMaximum"):
        raise FitError(f"{name}: expected a range within {least:g} to {most:g}, found {given.low:g} to {given.high:g}")


def softened(misfits):
    """Whose squares grow like misfits where these are above NEAR (soft L1)."""
    return np.sign(misfits) * NEAR * np.sqrt(2 * (np.sqrt(1 + (misfits / NEAR)**2) - 1))


def fitted_part(measurement, y):
    return measurement.x[measurement.fitted], np.asarray(y)[measurement.fitted]


class Teller:
    """A line about each step, on a terminal in place of the one before."""

    def __init__(self, fit, shown):
        self._fit, self._shown, self._terminal = fit, shown, sys.stderr.isatty()

    def __call__(self, stage, how_far, place, cost):
        if not self._shown:
            return
        values = ", ".join(f"{short(name)} {value:.4g}" for name, value in self._fit.values(place).items()) if place is not None else ""
        line = f"{stage}: {how_far}, {self._fit.runs} runs, misfit {math.sqrt(cost):.4f}  {values}"
        sys.stderr.write(f"\r{line[:150]:<150}" if self._terminal else line + "\n")
        sys.stderr.flush()

    def end(self):
        if self._shown and self._terminal:
            sys.stderr.write("\n")
