# SPDX-License-Identifier: MIT
"""What a fit has found: values, how well they are known, curves, and what it foretells of other data."""

import dataclasses
import math
import os

import numpy as np

from .. import own_files
from ..errors import FitError
from .identify import CONFIDENCE

COLUMNS = ("data", "x", "measured", "simulated", "fitted")
RESULTS = {"fit.json": own_files.is_signed, "scene.yaml": own_files.is_sealed, "curves.csv": own_files.has_columns(COLUMNS, ()),
           "fit.png": own_files.is_picture}  # files, and what shows that one is of a fit
DRAWN = 12  # sets of values that the data allow, for the spread of a prediction


@dataclasses.dataclass
class Prediction:
    """Of a curve that was not fitted, with the values of all parameters, also of motions and data: root mean square misfit (curve.py), in the unit of y and as a share of the curve's
    size; share of the points within the `low` and `high` of the curves that the fit allows, widened by twice its own misfit."""

    name: str
    x: np.ndarray
    y: np.ndarray  # measured
    simulated: np.ndarray
    low: np.ndarray
    high: np.ndarray
    rms: float
    relative: float
    within: float

    def __str__(self):
        return (f"{self.name}: predicted with {self.rms:.3g} rms, {self.relative:.1%} of its range; {self.within:.0%} of the points are "
                f"within its spread")


class Fitted:
    """`values`, `intervals` {name: (low, high)} of 95 % (never beyond the ranges), `doubts` {name: why it cannot be
    identified} of some, `correlation` (parameters x parameters), `runs`; for each measurement its Curve in `curves`, and the
    root mean square misfit (curve.py) of its fitted points in `rms`, in `relative` as a share of its size. `predictions`, of
    the points beyond `until`."""

    def __init__(self, fit, place, curves, known, low, high, doubts):
        self.fit, self.place, self.curves, self.known = fit, place, curves, known
        self.names, self.runs, self.correlation = fit.names, fit.runs, known.correlation
        self.values = fit.values(place)
        self.intervals = {name: (fit.parameters[name].at(low[k]), fit.parameters[name].at(high[k])) for k, name in enumerate(self.names)}
        self.doubts = doubts
        self.rms = [rms_of(each, each.fitted, curve) for each, curve in zip(fit.measurements, curves)]
        self.relative = [rms / each.size for rms, each in zip(self.rms, fit.measurements)]
        self._low, self._high, self._spread = low, high, None
        self.predictions = [self._predicted(k, ~each.fitted) for k, each in enumerate(fit.measurements) if not np.all(each.fitted)]

    @property
    def patch(self):
        """{field of the scene: value}, without those of motions and data."""
        return {name: value for name, value in self.values.items() if not name.startswith(("motion.", "data."))}

    def scene(self):
        """The scene with the values."""
        scene = self.fit.scene.copy()
        for name, value in self.patch.items():
            scene[name] = float(f"{value:.6g}")
        return scene

    def predict(self, measurement):
        """The Prediction of a Measurement that was not fitted."""
        other = type(self.fit)(self.fit.scene, measurement, {name: each.range for name, each in self.fit.parameters.items()})
        curves = [other.curves(self.values)[0], *(each[0] for each in other.runs_that_can_be(self._allowed()))]
        return predicted(measurement, np.ones(len(measurement.x), bool), curves, self._rms_like(measurement))

    def _rms_like(self, measurement):
        """Of the fitted curves of the same quantity."""
        return max((rms for rms, each in zip(self.rms, self.fit.measurements) if each.of == measurement.of), default=0.0)

    def _allowed(self):
        """Places that the data allow, drawn by correlations and intervals."""
        deviation = (self._high - self._low) / 4  # of an interval of 95 %
        covariance = np.outer(deviation, deviation) * self.known.correlation
        drawn = np.random.default_rng(0).multivariate_normal(self.place, covariance, DRAWN, check_valid="ignore")
        return list(np.clip(drawn, 0, 1))

    def _predicted(self, k, points):
        if self._spread is None:
            self._spread = self.fit.runs_that_can_be(self._allowed())
        return predicted(self.fit.measurements[k], points, [self.curves[k], *(each[k] for each in self._spread)], self.rms[k])

    def __str__(self):
        width = max(map(len, self.names))
        lines = [f"{'parameter':<{width}}  {'value':>10}  {CONFIDENCE:.0%} interval"]
        for name in self.names:
            low, high = self.intervals[name]
            lines.append(f"{name:<{width}}  {self.values[name]:>10.4g}  {low:.4g} to {high:.4g}"
                         + (f"  cannot be identified: {self.doubts[name]}" if name in self.doubts else ""))
        strongest = [(abs(self.correlation[i][j]), i, j) for i in range(len(self.names)) for j in range(i)]
        if strongest:
            _, i, j = max(strongest)
            lines.append(f"strongest correlation: {self.correlation[i][j]:+.2f}, of {self.names[j]} and {self.names[i]}")
        for each, rms, relative in zip(self.fit.measurements, self.rms, self.relative):
            lines.append(f"{each.name}: fitted with {rms:.3g} rms, {relative:.1%} of its range")
        lines += map(str, self.predictions)
        return "\n".join([*lines, f"{self.runs} runs, {self.known.independent:.0f} independent points"])

    def write(self, folder):
        """fit.json, scene.yaml, curves.csv and fit.png (needs matplotlib) in a folder, which is made."""
        make_folder(folder)
        contents = {"fit.json": own_files.signed(self.told()), "scene.yaml": own_files.sealed(self.scene().text()),
                    "curves.csv": own_files.table_of(COLUMNS, self._points())}
        for name, data in contents.items():
            own_files.write(os.path.join(folder, name), data, RESULTS[name], FitError)
        self.draw(os.path.join(folder, "fit.png"))

    def _points(self):
        """Rows of curves.csv."""
        for each, curve in zip(self.fit.measurements, self.curves):
            for x, y, simulated, used in zip(each.x, each.y, curve.at(each.x), each.fitted):
                yield each.name, f"{x:.9g}", f"{y:.9g}", f"{simulated:.9g}", int(used)

    def told(self):
        """As fit.json has it."""
        return {
            "patch": self.patch,
            "parameters": {name: {"value": self.values[name], "interval": list(self.intervals[name]),
                                  "identified": name not in self.doubts, "doubt": self.doubts.get(name, "")} for name in self.names},
            "correlation": {a: {b: float(self.correlation[i][j]) for j, b in enumerate(self.names)} for i, a in enumerate(self.names)},
            "fitted": [{"data": each.name, "rms": rms, "relative": relative}
                       for each, rms, relative in zip(self.fit.measurements, self.rms, self.relative)],
            "predicted": [{"data": each.name, "rms": each.rms, "relative": each.relative, "within": each.within} for each in self.predictions],
            "runs": self.runs, "independent_points": self.known.independent}

    def draw(self, path, predictions=()):
        """A picture of the curves, measured, fitted and predicted, and of the correlations. Needs matplotlib."""
        from .pictures import draw_fit  # pylint: disable=import-outside-toplevel  # with matplotlib
        draw_fit(self, path, [*self.predictions, *predictions])


def make_folder(folder):
    """For results. Raises FitError for one that cannot be written into, or where files stand that would be lost."""
    try:
        os.makedirs(folder, exist_ok=True)
    except OSError as error:
        raise FitError(f"{error.filename or folder}: {error.strerror}") from None
    if not os.access(folder, os.W_OK | os.X_OK):
        raise FitError(f"{folder}: it cannot be written into")
    for name, is_own in RESULTS.items():
        own_files.check(os.path.join(folder, name), is_own, FitError, "give another folder")


def rms_of(measurement, points, curve):
    return float(np.sqrt(np.average(curve.misfit(measurement, points)**2, weights=measurement.weights[points]))) * measurement.size


def predicted(measurement, points, curves, noise):
    x, y = measurement.x[points], measurement.y[points]
    values = np.array([curve.at(x) for curve in curves])
    low, high = values.min(axis=0) - 2 * noise, values.max(axis=0) + 2 * noise
    rms = rms_of(measurement, points, curves[0])
    return Prediction(measurement.name, x, y, values[0], low, high, rms, rms / float(np.ptp(measurement.y)), float(np.mean((y >= low) & (y <= high))))
