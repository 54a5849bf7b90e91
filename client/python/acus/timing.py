# SPDX-License-Identifier: MIT
"""How punctual a run in real time was: the two files that acus-replay --timing NAME.csv writes, as arrays."""

import os

import numpy as np

from .errors import RunError


class Timing:
    """trips["round_trip_s"] and the other columns of NAME.csv, a row per pose; stats[...] those of NAME.stats.csv, a
    row per second. Raises RunError."""

    def __init__(self, path):
        path = os.fspath(path)
        self.trips = Table(path)
        self.stats = Table(os.path.splitext(path)[0] + ".stats.csv")


class Table:
    """The columns of a CSV of numbers, by name."""

    def __init__(self, path):
        self.path = path
        try:
            self._columns = np.genfromtxt(path, delimiter=",", names=True, ndmin=1)
        except (OSError, ValueError) as error:
            raise RunError(f"{path}: {error}") from None
        if self._columns.size == 0 or self._columns.dtype.names is None:
            raise RunError(f"{path}: expected a table written by acus-replay --timing, found no rows")

    def __getitem__(self, name):
        if name not in self._columns.dtype.names:
            raise RunError(f"{self.path}: expected a column '{name}'; was it written by acus-replay --timing?")
        return self._columns[name]
