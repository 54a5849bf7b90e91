# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of acus-evidence in and out: lists of dictionaries, numbers where a cell is one."""

import csv
import glob
import os


def _value(text):
    try:
        return float(text)
    except ValueError:
        return text


class Folder:
    """Where the tables are and the plots go."""

    def __init__(self, path):
        self.path = path

    def file(self, name):
        return os.path.join(self.path, name)

    def read(self, name):
        """The rows of a table; empty where there is none."""
        try:
            with open(self.file(name), newline="", encoding="utf-8") as file:
                return [{key: _value(text) for key, text in row.items()} for row in csv.DictReader(file)]
        except FileNotFoundError:
            return []

    def read_all(self, pattern):
        names = sorted(glob.glob(self.file(pattern)))
        return [row for name in names for row in self.read(os.path.basename(name))]

    def write(self, name, rows):
        if not rows:
            return
        with open(self.file(name), "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
            writer.writeheader()
            for row in rows:
                writer.writerow({key: f"{v:.6g}" if isinstance(v, float) else v for key, v in row.items()})


def where(rows, **wanted):
    """The rows that have these values; a list or tuple stands for any of its members."""

    def fits(row):
        return all(row[key] in value if isinstance(value, (list, tuple)) else row[key] == value
                   for key, value in wanted.items())

    return [row for row in rows if fits(row)]


def values(rows, key):
    """Distinct values of a column, in order of appearance."""
    return list(dict.fromkeys(row[key] for row in rows))
