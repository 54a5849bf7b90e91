# SPDX-License-Identifier: MIT
"""Measured curves: how they are read, and how much each of their points counts."""

import dataclasses
import math
import os
import re

import numpy as np

from ..errors import FitError
from ..table import is_absent, number_of, read_table

BACK = 0.05  # of the range of x, from which a way in has ended
EARLY = 0.2  # of the largest size, up to which signs are looked at
SHARES = 200  # of the range of x that count alike
OVER = {"time": "s", "travel": "m"}  # what a curve may be over: the abscissa
OF = {"force": "N", "deflection": "m"}
NAMES = {"t": "time", "depth": "travel", "displacement": "travel", "extension": "travel", "f": "force", "load": "force"}  # as they may be called, too
PLAIN = {"axial", "base", "insertion", "needle"}  # words before a name that change nothing
SCALES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "\u00b5s": 1e-6, "\u03bcs": 1e-6, "m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "\u00b5m": 1e-6, "\u03bcm": 1e-6,
          "n": 1.0, "mn": 1e-3, "kn": 1e3}


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
    told: str = dataclasses.field(repr=False, default="")  # how a file was read
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
    or deflection; s, ms, m, cm, mm, um, N, mN. `columns`: the two that count where there are more, or the names of all of a
    file without a header. Cells, numbers and comments may be as acus.table says; rows without a value are left out. What is
    negative while the needle goes in is turned. `told` says all that in a line. `settings`: of Measurement. Raises
    FitError."""
    table, given = read_table(path, FitError), [cell.strip() for cell in columns or ()]
    name_columns(table, given)
    meanings = [meaning_of(cell) if not given or cell in given else None for cell in table.header]
    over = [i for i, each in enumerate(meanings) if each and each[0] in OVER]
    of = [i for i, each in enumerate(meanings) if each and each[0] in OF]
    if len(over) != 1 or len(of) != 1:
        raise FitError(f"{table.path}: expected one column of {' or '.join(OVER)} and one of {' or '.join(OF)}, with units, such as "
                       f"travel_mm,force_N; found {', '.join(table.header)}")
    columns = [over[0], of[0]]
    comma = table.has_decimal_comma(columns)
    lines, values = numbers(table, columns, comma)
    values *= [meanings[i][1] for i in columns]
    names = [table.header[i] for i in columns]
    signs = turn(values, names, meanings[over[0]][0])
    used, order = told_order(table.path, lines, values[:, 0], meanings[over[0]][0], names[0])
    absent = len(table.rows) - len(lines)
    told = [f"{used} of {len(table.rows)} rows" + (f" ({absent} without a value)" if absent else "") + f", {table.told(comma)}", signs, order]
    if meanings[over[0]][0] == "travel":
        told.append(f"{names[0]} counts from where the motion begins" + (
            "; if it is measured from the skin, free data.shift below 0, to find how far above that is" if "depth" in names[0].lower() else ""))
    settings.setdefault("name", os.path.basename(table.path))
    return Measurement(*values.T, meanings[over[0]][0], meanings[of[0]][0], motion, told=f"{table.path}: " + "; ".join(told), **settings)


def name_columns(table, given):
    """The header where there is none, or where the units stand in a line of their own."""
    if not table.header:
        raise FitError(f"{table.path}: it has no rows")
    if all(is_number(cell) for cell in table.header):
        if not given:
            raise FitError(f"{table.path}: its first line has no names of columns; give them: time_s,force_N")
        table.rows.insert(0, table.header)
        table.lines.insert(0, table.header_line)
        table.header = given
        return
    units = [cell.strip("[]()").lower() for cell in table.rows[0]] if table.rows else []
    if units and len(units) == len(table.header) and all(unit in SCALES or not unit for unit in units):
        table.header = [f"{name}_{unit}" if unit else name for name, unit in zip(table.header, units)]
        del table.rows[0], table.lines[0]
    if missing := [name for name in given if name not in table.header]:
        raise FitError(f"{table.path}: it has no column {missing[0]}; it has {', '.join(table.header)}")


def turn(values, names, over):
    """Turns what is negative while the needle goes in, in place; says so."""
    turned, in_use = [], slice(None)
    for k, name in enumerate(names):
        if (k > 0 or over == "travel") and begins_negative(values[in_use, k]):
            values[:, k] *= -1
            turned.append(name)
        in_use = first_way_in(values[:, 0]) if over == "travel" else in_use
    return f"{' and '.join(turned)} turned: negative while the needle goes in" if turned else "signs as they are"


def begins_negative(y):
    """Up to where it first is a fifth as large as it ever is: later, when a needle comes out, signs change."""
    size = np.abs(y)
    first = y[:int(np.argmax(size >= EARLY * size.max())) + 1]
    return bool(first.sum() < 0)


def told_order(path, lines, x, over, name):
    """How many rows count, and in which order. Raises FitError where they are of several experiments."""
    way_in = first_way_in(x)
    end = way_in.stop or len(x)
    if end < len(x) and (over == "time" or end < 4):
        raise FitError(f"{path}:{lines[end]}: column {name}: it goes back to {x[end]:g} {OVER[over]}, after {x[:end].max():g} {OVER[over]}; leave one "
                       f"experiment in a file, its rows in order, {over} rising from the first")
    falls = np.count_nonzero(np.diff(x[way_in]) < 0)
    order = f"sorted by {name}, which goes back {falls} times" if falls else f"in order of {name}"
    return end, order if end == len(x) else f"{order}, up to line {lines[end - 1]}, where the first way in ends"


def is_number(text):
    return math.isfinite(number_of(text, comma="," in text))


def meaning_of(column):
    """(name, scale) of a column's name with its unit; None for another one."""
    *words, given = re.findall(r"[^\W\d_]+", column.lower()) or [""]
    words = [word for word in words if word not in PLAIN and word != "in"]
    name = NAMES.get(words[0], words[0]) if len(words) == 1 else None
    unit = {**OVER, **OF}.get(name)
    if unit is None or given not in SCALES or given[-1] != unit.lower()[-1]:
        return None
    return name, SCALES[given]


def numbers(table, columns, comma):
    """(lines, values (n, columns)) of the rows that have a value in each of the columns."""
    lines, values = [], []
    for line, cells in zip(table.lines, table.rows):
        check_cells(table, line, cells, columns)
        if not any(is_absent(cells[i]) for i in columns):
            lines.append(line)
            values.append([number_in(table, line, cells, i, comma) for i in columns])
    if not values:
        raise FitError(f"{table.path}: it has no rows with numbers")
    return lines, np.array(values)


def check_cells(table, line, cells, columns):
    for i in columns:
        if i >= len(cells):
            raise FitError(f"{table.path}:{line}: column {table.header[i]}: expected a number, found none")
    unnamed = sum(map(bool, cells[len(table.header):]))
    if unnamed and (len(cells) >= 2 * len(table.header) or len(cells) != len(table.rows[0])):  # not a column without a name
        raise FitError(f"{table.path}:{line}: it has {len(cells)} cells, the header {len(table.header)}; where numbers have a decimal comma, "
                       f"separate cells by semicolons")


def number_in(table, line, cells, i, comma):
    value = number_of(cells[i], comma)
    if math.isnan(value):
        raise FitError(f"{table.path}:{line}: column {table.header[i]}: expected a number, found {cells[i]!r}"
                       + ("; write it without grouping its digits" if re.fullmatch(r"[+-]?\d{1,3}([., '\u00a0\u202f]\d{3})+([.,]\d*)?", cells[i]) else ""))
    return value
