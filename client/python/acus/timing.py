# SPDX-License-Identifier: MIT
"""How punctual a run in real time was: the two files that acus-replay --timing NAME.csv writes, as arrays."""

import os

import numpy as np

from .errors import RunError
from .table import number_of, read_table


class Timing:
    """trips["round_trip_s"] and the other columns of NAME.csv, a row per pose; stats[...] those of NAME.stats.csv, a
    row per second. Raises RunError."""

    def __init__(self, path):
        path = os.fspath(path)
        self.trips = Columns(path)
        self.stats = Columns(os.path.splitext(path)[0] + ".stats.csv")


class Columns:
    """The columns of a CSV of numbers, by name."""

    def __init__(self, path):
        table = read_table(path, RunError)
        if not table.rows:
            raise RunError(f"{path}: expected a table written by acus-replay --timing, found no rows")
        self.path, self._names = path, table.header
        for line, row in zip(table.lines, table.rows):
            if len(row) != len(self._names):
                raise RunError(f"{path}:{line}: expected {len(self._names)} cells, found {len(row)}")
        comma = table.has_decimal_comma(range(len(self._names)))
        self._values = np.array([[number_of(cell, comma) for cell in row] for row in table.rows])

    def __getitem__(self, name):
        if name not in self._names:
            raise RunError(f"{self.path}: expected a column '{name}'; was it written by acus-replay --timing?")
        return self._values[:, self._names.index(name)]
