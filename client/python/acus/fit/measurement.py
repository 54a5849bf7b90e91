# SPDX-License-Identifier: MIT
"""Measured curves: how they are read, and how much each of their points counts."""

import csv
import dataclasses
import math
import os
import re

import numpy as np

from ..errors import FitError

BACK = 0.05  # of the range of x, from which a way in has ended
SHARES = 200  # of the range of x that count alike
OVER = {"time": "s", "travel": "m"}  # what a curve may be over: the abscissa
OF = {"force": "N", "deflection": "m"}
NAMES = {"t": "time", "depth": "travel", "displacement": "travel", "f": "force"}  # as they may be called, too
SCALES = {"s": 1.0, "ms": 1e-3, "m": 1.0, "mm": 1e-3, "um": 1e-6, "n": 1.0, "mn": 1e-3}
COLUMN = re.compile(r"([a-z]+)[_ ]?[\[(]?\s*([a-z]+)\s*[\])]?", re.IGNORECASE)


@dataclasses.dataclass(frozen=True)
class Measurement:
    """A curve y(x), in SI units: `of` "force" (N, axial resistance at the base) or "deflection" (m, of the tip from the base's first
    axis), `over` "time" (s) or "travel" (m, of the base along its first axis, on its first way in). `motion`, as
    acus.Study takes it, is that of the experiment; it begins at x = 0, or at the parameter data.shift of a fit. `until`:
    what is beyond this x is not fitted, but predicted. `scene`: another Scene than the fit's."""

    x: np.ndarray
    y: np.ndarray
    over: str
    of: str
    motion: object
    name: str = "data"
    until: float = math.inf
    scene: object = None
    weights: np.ndarray = dataclasses.field(init=False, repr=False, default=None)

    def __post_init__(self):
        x, y = np.array(self.x, dtype=float), np.array(self.y, dtype=float)
        if x.ndim != 1 or x.shape != y.shape or len(x) < 4:
            raise FitError(f"{self.name}: expected at least 4 pairs of numbers, found shapes {x.shape} and {y.shape}")
        if not (np.all(np.isfinite(x)) and np.all(np.isfinite(y))):
            raise FitError(f"{self.name}: a number is not finite")
        for value, known, what in ((self.over, OVER, "over"), (self.of, OF, "of")):
            if value not in known:
                raise FitError(f"{self.name}: {what}: expected {' or '.join(known)}, found {value!r}")
        if self.over == "travel":
            way_in = first_way_in(x)
            x, y = x[way_in], y[way_in]
        order = np.argsort(x, kind="stable")
        x, y = x[order], y[order]
        if math.isfinite(self.until) and x[-1] <= self.until:
            raise FitError(f"{self.name}: until {self.until:g} {OVER[self.over]}: all data are before it, they end at {x[-1]:g} {OVER[self.over]}")
        if np.count_nonzero(x <= self.until) < 4:
            raise FitError(f"{self.name}: until {self.until:g}: fewer than 4 points are before it")
        if np.ptp(y[x <= self.until]) == 0 or np.ptp(x[x <= self.until]) == 0:
            raise FitError(f"{self.name}: all values are alike; there is nothing to fit")
        object.__setattr__(self, "x", x)
        object.__setattr__(self, "y", y)
        object.__setattr__(self, "weights", even_weights(x))

    @property
    def fitted(self):
        """Whether each point is for the fit, not to be predicted."""
        return self.x <= self.until

    @property
    def size(self):
        """Of the values that are fitted, from the lowest to the highest: what misfits are shares of."""
        return float(np.ptp(self.y[self.fitted]))


def first_way_in(x):
    """The points before x first falls by more than a twentieth of its range: digitised ones may jitter."""
    back = np.maximum.accumulate(x) - x > BACK * np.ptp(x)
    return slice(None, int(np.argmax(back)) if np.any(back) else len(x))


def shares_of(x):
    """Of each point, which share of the range of x it lies in."""
    return np.minimum((SHARES * (x - x[0]) / max(np.ptp(x), 1e-300)).astype(int), SHARES - 1)


def even_weights(x):
    """Of the points, so that each share of the range of x counts alike: a digitised curve has many points where it is
    steep."""
    place = shares_of(x)
    return 1.0 / np.bincount(place, minlength=SHARES)[place]


def read_measurement(path, motion, columns=None, **settings):
    """Of a CSV file whose header names two columns with their units, `travel_mm,force_N`: time or t, travel or depth, and force
    or deflection; s, ms, m, mm, um, N, mN. `columns`: the two that count where there are more, or the names of all of a file
    without a header. Commas, semicolons or tabs stand between; lines that begin with # are left out. `settings`: of
    Measurement. Raises FitError."""
    path = os.fspath(path)
    lines = read_lines(path)
    header, given = lines[0][1], [cell.strip() for cell in columns or ()]
    if all(is_number(cell) for cell in header):
        if not given:
            raise FitError(f"{path}: its first line has no names of columns; give them: time_s,force_N")
        header = given
    else:
        lines = lines[1:]
        if missing := [name for name in given if name not in header]:
            raise FitError(f"{path}: it has no column {missing[0]}; it has {', '.join(header)}")
    known = [meaning_of(cell) if not given or cell in given else None for cell in header]
    over = [i for i, each in enumerate(known) if each and each[0] in OVER]
    of = [i for i, each in enumerate(known) if each and each[0] in OF]
    if len(over) != 1 or len(of) != 1:
        raise FitError(f"{path}: expected one column of {' or '.join(OVER)} and one of {' or '.join(OF)}, with units, such as "
                       f"travel_mm,force_N; found {', '.join(header)}")
    x, y = (numbers(path, lines, i, header[i]) * known[i][1] for i in (over[0], of[0]))
    settings.setdefault("name", os.path.basename(path))
    return Measurement(x, y, known[over[0]][0], known[of[0]][0], motion, **settings)


def read_lines(path):
    """[(number of the line, cells)] of those that have any."""
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            lines = [(number, line) for number, line in enumerate(file.read().splitlines(), 1) if line.strip() and not line.startswith("#")]
    except OSError as error:
        raise FitError(f"{path}: {error.strerror}") from None
    except ValueError:
        raise FitError(f"{path}: it is no text in UTF-8") from None
    if not lines:
        raise FitError(f"{path}: it has no rows")
    between = max(",;\t", key=lines[0][1].count)
    return [(number, [cell.strip() for cell in next(csv.reader([line], delimiter=between))]) for number, line in lines]


def is_number(text):
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def meaning_of(column):
    """(name, scale) of a column's name with its unit; None for another one."""
    found = COLUMN.fullmatch(column)
    if not found:
        return None
    name = NAMES.get(found[1].lower(), found[1].lower())
    unit, given = {**OVER, **OF}.get(name), found[2].lower()
    if unit is None or given not in SCALES or given[-1] != unit.lower()[-1]:
        return None
    return name, SCALES[given]


def numbers(path, lines, column, name):
    values = []
    for number, cells in lines:
        if column >= len(cells) or not is_number(cells[column]):
            found = repr(cells[column]) if column < len(cells) else "none"
            raise FitError(f"{path}:{number}: column {name}: expected a number, found {found}")
        values.append(float(cells[column]))
    return np.array(values)
