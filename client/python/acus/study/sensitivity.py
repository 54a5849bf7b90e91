# SPDX-License-Identifier: MIT
"""Which parameters an output depends on.

Sobol indices of f(x), x independent, with V its variance (Sobol 1993; Saltelli et al. 2010, Comput. Phys. Commun. 181):

    first order  S_i = V[E[f | x_i]] / V       share of V that x_i makes alone       sum of all <= 1
    total        T_i = 1 - V[E[f | x_~i]] / V  share with all its interactions        T_i >= S_i

From two samples A and B and, for each i, AB_i, which is A with column i of B:

    S_i ~ mean(f_B (f_ABi - f_A)) / V     (Saltelli 2010)      T_i ~ mean((f_A - f_ABi)^2) / 2 V     (Jansen 1999)

Intervals are percentiles of estimates with the rows of A and B drawn again (bootstrap). A case that failed, or whose output
is no finite number, leaves its row of A, B and all AB_i out. An estimate may be a little below 0 or above 1.
"""

import dataclasses

import numpy as np

from ..errors import StudyError
from .designs import Design, counted, drawn, quantiles_of, sobol_points

RESAMPLES = 1000
LEAST = 8  # rows


class Saltelli(Design):
    """All rows of A, then of B, then of each AB_i."""

    def __init__(self, design, base):
        super().__init__(design.kind, design.names, design.rows)
        self.base = base


def saltelli(distributions, count, seed=0):
    """The cases that Sobol indices need: count (d + 2) of them for d parameters, {name: (low, high) or a distribution};
    `count` best a power of 2. Needs scipy."""
    distributions = quantiles_of(distributions)
    size = len(distributions)
    points = sobol_points(2 * size, counted(count), seed)
    return Saltelli(drawn("Saltelli sample", distributions, saltelli_points(points[:, :size], points[:, size:])), count)


def saltelli_points(a, b):
    """A, B, AB_1 ... AB_d one below the other."""
    mixed = []
    for i in range(a.shape[1]):
        mixed.append(a.copy())
        mixed[-1][:, i] = b[:, i]
    return np.concatenate([a, b, *mixed])


@dataclasses.dataclass(frozen=True)
class Index:
    """Of one parameter: first order and total, each with its interval (low, high)."""

    name: str
    first: float
    first_interval: tuple
    total: float
    total_interval: tuple

    def __str__(self):
        return (f"{self.name}: first order {self.first:.2f} ({self.first_interval[0]:.2f} to {self.first_interval[1]:.2f}), "
                f"total {self.total:.2f} ({self.total_interval[0]:.2f} to {self.total_interval[1]:.2f})")


def sobol_indices(names, values, confidence=0.95, seed=0):
    """An Index for each name. `values`: of a Saltelli sample, in its order, n (d + 2) numbers; NaN where there is none."""
    if not 0 < confidence < 1:
        raise StudyError(f"confidence: expected a share between 0 and 1, found {confidence!r}")
    if not np.size(values) or np.size(values) % (len(names) + 2):
        raise StudyError(f"Sobol indices: expected n ({len(names)} + 2) values of a Saltelli sample, found {np.size(values)}")
    rows = np.asarray(values, dtype=float).reshape(len(names) + 2, -1)
    rows = rows[:, np.all(np.isfinite(rows), axis=0)]
    count = rows.shape[1]
    if count < LEAST:
        raise StudyError(f"Sobol indices: expected at least {LEAST} whole rows of the sample, found {count}")
    if np.var(rows[:2]) == 0:
        raise StudyError("Sobol indices: the output is the same in all cases")
    first, total = estimates(rows)
    random = np.random.default_rng(seed)
    again = np.array([estimates(rows[:, random.integers(count, size=count)]) for _ in range(RESAMPLES)])
    tails = 100 * np.array([(1 - confidence) / 2, (1 + confidence) / 2])
    low, high = np.nanpercentile(again, tails, axis=0)
    return [Index(name, float(first[i]), (float(low[0, i]), float(high[0, i])), float(total[i]),
                  (float(low[1, i]), float(high[1, i]))) for i, name in enumerate(names)]


def estimates(rows):
    """S and T, (d,) each."""
    a, b, mixed = rows[0], rows[1], rows[2:]
    mean, variance = np.mean(rows[:2]), np.var(rows[:2])
    with np.errstate(invalid="ignore", divide="ignore"):  # of a resample that happens to be constant
        return (np.mean((b - mean) * (mixed - a), axis=1) / variance, np.mean((mixed - a) ** 2, axis=1) / 2 / variance)


def swings(columns, values, share=0.1):
    """{name: (low, high)}: the mean of the output over the cases with the lowest and with the highest values of each
    parameter, a `share` of all cases or those with the same value. What is no number is left out."""
    found = {}
    values = np.asarray(values, dtype=float)
    for name, column in columns.items():
        if not all(isinstance(each, (int, float)) and not isinstance(each, bool) for each in column):
            continue
        column = np.asarray(column, dtype=float)
        known = np.isfinite(column) & np.isfinite(values)
        if not known.any() or np.ptp(column[known]) == 0:
            continue
        ordered = np.sort(column[known])
        count = max(1, round(share * ordered.size))
        low, high = ordered[count - 1], ordered[-count]
        found[name] = (float(values[known & (column <= low)].mean()), float(values[known & (column >= high)].mean()))
    return found
