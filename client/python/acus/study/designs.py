# SPDX-License-Identifier: MIT
"""Which cases a study has: each a value for every parameter.

    grid({"motion.speed": [0.01, 0.02], "motion.depth": [0.03, 0.05]})              all combinations, the last name fastest
    latin_hypercube({"motion.speed": (0.01, 0.05)}, 100)                            each value's range in 100 even parts
    sobol({"tissue.regions[0].material.young_modulus": LogUniform(5e3, 5e4)}, 128)  a sequence that fills the space evenly
    table([{"motion.speed": 0.01}, {"motion.speed": 0.03}])                         as given; a CSV file, a DataFrame
"""

import csv
import itertools
import math
import os

import numpy as np

from ..distributions import Distribution, Uniform, distribution_of
from ..errors import StudyError
from ..scene import plain

MOST = 10_000_000  # cases


class Design:
    """`names` of parameters; a case is a dictionary. `kind` says how it was made. `base`: rows of A of a Saltelli sample."""

    base = 0

    def __init__(self, kind, names, rows):
        self.kind, self.names, self.rows = kind, list(names), [list(row) for row in rows]
        if not self.names or not self.rows:
            raise StudyError("parameters: expected at least one parameter and one case")
        if len(set(self.names)) != len(self.names):
            raise StudyError("parameters: a name is there twice")

    def __len__(self):
        return len(self.rows)

    def __getitem__(self, case):
        return dict(zip(self.names, self.rows[case]))

    def __repr__(self):
        return f"<{self.kind} of {len(self)} cases: {', '.join(self.names)}>"


def grid(values):
    """All combinations of {name: list of values}."""
    columns = {name: values_of(name, each) for name, each in values.items()}
    if math.prod(map(len, columns.values())) > MOST:
        raise StudyError(f"parameters: a grid of more than {MOST} cases")
    return Design("grid", columns, itertools.product(*columns.values()))


def latin_hypercube(distributions, count, seed=0):
    """{name: (low, high) or a distribution}; each of `count` equal shares of every parameter has one case."""
    distributions = quantiles_of(distributions)
    random = np.random.default_rng(seed)
    shares = [(random.permutation(counted(count)) + random.uniform(size=count)) / count for _ in distributions]
    return drawn("Latin hypercube", distributions, np.transpose(shares))


def sobol(distributions, count, seed=0):
    """Likewise, `count` points of a scrambled Sobol sequence; best a power of 2. A longer one begins with the same cases.
    Needs scipy."""
    distributions = quantiles_of(distributions)
    return drawn("Sobol sequence", distributions, sobol_points(len(distributions), counted(count), seed))


def table(rows):
    """The cases as they stand: a list of dictionaries, a DataFrame, {name: column}, or the path of a CSV file."""
    if isinstance(rows, (str, os.PathLike)):
        rows = read_csv(os.fspath(rows))
    elif hasattr(rows, "to_dict"):
        rows = rows.to_dict("records")
    elif isinstance(rows, dict):
        columns = {name: values_of(name, each) for name, each in rows.items()}
        if len(set(map(len, columns.values()))) > 1:
            raise StudyError("parameters: columns of a table have different lengths")
        rows = [dict(zip(columns, row)) for row in zip(*columns.values())]
    try:
        rows = [dict(row) for row in rows]
    except (TypeError, ValueError):
        raise StudyError(f"parameters: expected a table, that is a list of dictionaries, a dictionary of columns, a DataFrame or a "
                         f"CSV file, found {type(rows).__name__}") from None
    names = list(rows[0]) if rows else []
    for number, row in enumerate(rows):
        if set(row) != set(names):
            raise StudyError(f"parameters: row {number} has other names than the first")
    return Design("table", names, [[plain(row[name]) for name in names] for row in rows])


def design_of(parameters):
    """Of what Study takes: a Design, or {name: values}, a grid; a single value stands for itself."""
    if isinstance(parameters, Design):
        return parameters
    if not isinstance(parameters, dict):
        return table(parameters)
    return grid({name: each if isinstance(each, (list, np.ndarray, range)) else [each]
                 for name, each in parameters.items()})


# ---- Parts ----


def sobol_points(dimensions, count, seed):
    """count x dimensions, in [0, 1)."""
    try:
        from scipy.stats import qmc  # pylint: disable=import-outside-toplevel  # takes a second, for some users only
    except ImportError:
        raise StudyError("Sobol sequences need scipy (apt install python3-scipy)") from None
    sequence = qmc.Sobol(dimensions, seed=seed)
    whole = sequence.random_base2(math.ceil(math.log2(count)))  # no warning about others than powers of 2
    return whole[:count]


def drawn(kind, distributions, shares):
    rows = [[plain(each.at(float(u))) for each, u in zip(distributions.values(), row)] for row in shares]
    return Design(kind, distributions, rows)


def quantiles_of(distributions):
    """{name: what has at(u)}."""
    found = {}
    for name, given in distributions.items():
        try:
            each = distribution_of(given)
        except (TypeError, ValueError) as error:
            raise StudyError(f"{name}: {error}") from None
        if hasattr(each, "ppf"):
            each = OfScipy(each)
        if not isinstance(each, Distribution):
            raise StudyError(f"{name}: expected a range (low, high) or a distribution, found {given!r}")
        if isinstance(each, Uniform) and not math.isfinite(each.low + each.high):
            raise StudyError(f"{name}: expected a finite range, found {given!r}")
        found[name] = each
    if not found:
        raise StudyError("parameters: expected at least one")
    return found


class OfScipy(Distribution):
    """A distribution of scipy.stats."""

    def __init__(self, frozen):
        self.frozen = frozen

    def at(self, u):
        return float(self.frozen.ppf(u))


def values_of(name, given):
    if isinstance(given, str) or not hasattr(given, "__iter__"):
        raise StudyError(f"{name}: expected a list of values, found {given!r}")
    values = [plain(each) for each in given]
    if not values:
        raise StudyError(f"{name}: expected at least one value")
    return values


def counted(count):
    if not isinstance(count, (int, np.integer)) or not 0 < count <= MOST:
        raise StudyError(f"count: expected a whole number from 1 to {MOST}, found {count!r}")
    return int(count)


def read_csv(path):
    """Cells that are numbers or true and false become that; other ones stay texts."""
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            header, *rows = [row for row in csv.reader(file) if row] or [[]]
    except (OSError, ValueError) as error:
        raise StudyError(f"{path}: {getattr(error, 'strerror', error)}") from None
    for number, row in enumerate(rows, 2):
        if len(row) != len(header):
            raise StudyError(f"{path}:{number}: expected {len(header)} cells, found {len(row)}")
    return [dict(zip(header, map(value_of, row))) for row in rows]


def value_of(cell):
    if cell.lower() in ("true", "false"):
        return cell.lower() == "true"
    for kind in (int, float):
        try:
            return kind(cell)
        except ValueError:
            pass
    return cell
