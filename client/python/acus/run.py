# SPDX-License-Identifier: MIT
"""A run that is over: forces, events and shapes as arrays.

Read from what acus-replay --out (or acus-export --csv) wrote, NAME.csv, with NAME.events.csv and NAME.shapes beside it;
from a recording of the server, which acus-export makes these of; or from States that a client has kept. Files are read
when they are asked for, columns become arrays when they are used.
"""

import difflib
import os
import subprocess
import tempfile
import warnings
from functools import cached_property

import numpy as np

from .errors import RunError
from .messages import Event, Force, array_fields
from .programs import find_program
from .rotation import axis_of
from .shapes import Shapes
from .table import WITH_COMMA, read_table

UNITS = ("", "_s", "_m", "_rad", "_N", "_Nm")  # what may end the name of a column
IN_PART = (4, 5)  # statuses of acus-export: it came out otherwise, as on another processor; the end is damaged
ZSTD = b"\x28\xb5\x2f\xfd"  # what a recording of the server begins with
TYPES = {"needle": str, "phase": str, "solver": str, "epoch": int, "tick": int, "seq": int, "lost": int,
         "reordered": int, "limited": int, "flags": int, "stale": bool}


class Run:
    """`needles` are the names, run[name] the Track of one. May be used in a `with` block: `shapes` keeps a file open.

    A run in which the simulation began anew (reset, restore, load) has several epochs, in which time runs anew; `shapes`
    are those of the last one. of_epoch() is one of them alone.
    """

    def __init__(self, path, shapes=None):
        self.path = os.fspath(path)
        self._shapes_path = shapes
        self._epoch = None  # whose shapes are meant, None: the last
        self._folder = None  # of what acus-export wrote
        self._csv = self.path
        self._whole = None  # whose part this is, and whose folder it reads

    @classmethod
    def of_states(cls, states):
        """Of States, as Client.trace() gives them or as they were collected from step() and wait()."""
        run = cls("states of a client")
        states = list(states)
        run._tracks = {name: Track(name, StatesTable([each[name] for each in states if name in each], run.path))
                       for name in (states[0] if states else ())}
        run.events = [event for each in states for event in each.events]
        return run

    def __repr__(self):
        tracks = ", ".join(f"{name} ({len(track)} ticks)" for name, track in self._tracks.items())
        return f"<Run of {self.path}: {tracks or 'no ticks'}; {len(self.events)} events>"

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        if "shapes" in self.__dict__:
            self.shapes.close()
        if self._folder:
            self._folder.cleanup()

    @property
    def needles(self):
        return list(self._tracks)

    def __getitem__(self, needle):
        if needle not in self._tracks:
            raise RunError(f"{self.path}: no needle '{needle}'; its needles are {', '.join(sorted(self._tracks))}")
        return self._tracks[needle]

    def __iter__(self):
        return iter(self._tracks)

    def __len__(self):
        return len(self._tracks)

    @cached_property
    def epochs(self):
        """Their numbers, in order."""
        epochs = [track.epochs() for track in self._tracks.values()]
        return sorted(set().union(*epochs))

    def of_epoch(self, epoch):
        """A Run, of use until this one is closed."""
        part = Run(self.path, self._shapes_path)
        part._tracks = {name: track.of_epoch(epoch) for name, track in self._tracks.items()}
        part.events = [event for event in self.events if event.epoch == epoch]
        part._csv, part._epoch, part._whole = self._csv, epoch, self
        return part

    def to_dataframe(self):
        """A pandas DataFrame, a row for each tick and needle, with the columns of Track.to_dataframe(). Needs pandas."""
        import pandas  # pylint: disable=import-outside-toplevel  # takes a second, for some users only
        return pandas.concat([track.to_dataframe() for track in self._tracks.values()], ignore_index=True)

    @cached_property
    def events(self):
        """Event of each, all needles; none if there is no file of them."""
        path = os.path.splitext(self._exported())[0] + ".events.csv"
        return [event_of(row) for row in read_dictionaries(path)] if os.path.exists(path) else []

    @cached_property
    def shapes(self):
        """Shapes: those beside the run, unless others were given."""
        return Shapes(self._shapes_path or os.path.splitext(self._exported())[0] + ".shapes", self._epoch)

    @cached_property
    def _tracks(self):
        header, columns = read_columns(self._exported(), self.path)
        names = np.array(columns[header.index("needle")])
        rows = {name: np.flatnonzero(names == name) for name in dict.fromkeys(names.tolist())}
        table = dict(zip(header, columns))
        return {name: Track(name, CsvTable(table, chosen, self.path)) for name, chosen in rows.items()}

    def _exported(self):
        """The CSV: that of the run, or what acus-export makes of a recording."""
        if self._csv is self.path and is_recording(self.path):
            self._folder = tempfile.TemporaryDirectory(prefix="acus-run-")
            self._csv = os.path.join(self._folder.name, "run.csv")
            shapes = os.path.join(self._folder.name, "run.shapes")
            done = subprocess.run([find_program("acus-export"), self.path, "--csv", self._csv, "--shapes", shapes,
                                   "--quiet"], capture_output=True, text=True, check=False)
            told = f"{self.path}: acus-export ended with status {done.returncode}: {done.stderr.strip()}"
            if done.returncode in IN_PART:
                warnings.warn(told)
            elif done.returncode != 0:
                raise RunError(told)
        return self._csv


class Track:
    """A needle's forces over the run: an attribute for each field of Force, an array with a row per tick. Vectors have
    3 columns, orientations 4 (w, x, y, z). SI units, world frame unless a name says otherwise."""

    def __init__(self, needle, table):
        self.needle = needle
        self._table = table

    def __len__(self):
        return len(self._table)

    def __repr__(self):
        return f"<Track of {self.needle}: {len(self)} ticks" + (f", {self.time[0]:g} to {self.time[-1]:g} s>" if len(self) else ">")

    def __dir__(self):
        return sorted({*super().__dir__(), *Force.field_names()})

    def __getattr__(self, name):
        if name not in Force.field_names():
            close = difflib.get_close_matches(name, Force.field_names(), 3)
            raise AttributeError(f"a Track has no '{name}'" + (f"; did you mean {' or '.join(close)}?" if close else ""))
        values = self._table.values(name)
        self.__dict__[name] = values
        return values

    def column(self, name):
        """A column by its name in the file, such as received_s, as numbers."""
        return self._table.column(name)

    def epochs(self):
        """The numbers of those that it has rows of."""
        return set(self.epoch.tolist()) if self._table.has("epoch") else {0}

    def of_epoch(self, epoch):
        """A Track."""
        if not self._table.has("epoch"):
            return self
        return Track(self.needle, self._table.only(np.flatnonzero(self.epoch == epoch)))

    def to_dataframe(self):
        """A pandas DataFrame, a row for each tick: the fields that the run has, vectors as base_force_x and so on, and
        axial_resistance. Needs pandas."""
        import pandas  # pylint: disable=import-outside-toplevel  # takes a second, for some users only
        columns, components = {}, array_fields(Force)
        for name in Force.field_names():
            try:
                values = getattr(self, name)
            except (RunError, AttributeError):
                continue  # an older file, or ticks of acus.engine, do not have it
            if name in components:
                columns.update({f"{name}_{axis}": values[:, i] for i, axis in enumerate(components[name])})
            else:
                columns[name] = values
        return pandas.DataFrame({**columns, "axial_resistance": self.axial_resistance})

    def plot(self, x="depth", axes=None):
        """Axial resistance (N) against "depth" or "travel" (mm) or "time" (s), into axes of matplotlib, new ones by
        default. The axes. Needs matplotlib."""
        scales = {"depth": (1e3, "depth (mm)"), "travel": (1e3, "way of the base (mm)"), "time": (1.0, "time (s)")}
        if x not in scales:
            raise ValueError(f"x: expected {', '.join(scales)}, found {x!r}")
        if axes is None:
            import matplotlib.pyplot  # pylint: disable=import-outside-toplevel  # takes a second, for some users only
            axes = matplotlib.pyplot.figure(layout="constrained").subplots()
        scale, label = scales[x]
        axes.plot(scale * getattr(self, x), self.axial_resistance, label=self.needle)
        axes.set_xlabel(label)
        axes.set_ylabel("axial resistance (N)")
        axes.grid(True, color="#dddddd", linewidth=0.6)
        return axes

    @cached_property
    def axis(self):
        """Unit vectors along the needle at its base, n x 3."""
        return axis_of(self.base_orientation)

    @cached_property
    def travel(self):
        """m, how far the base has gone along the axis that it had first."""
        return np.sum((self.base_position - self.base_position[0]) * self.axis[0], axis=1)

    @cached_property
    def axial_resistance(self):
        """N, what the holder feels along the needle; positive when the tissue resists going in."""
        return self.along_axis("base_force")

    def along_axis(self, force):
        """The part of a force against the direction of the needle (N), by the name of its field."""
        return -np.sum(getattr(self, force) * self.axis, axis=1)

    @cached_property
    def touched(self):
        """Whether the tip has touched the tissue by then."""
        return np.logical_or.accumulate(self.phase != "free")


class CsvTable:
    """The rows of one needle in columns of text."""

    def __init__(self, columns, rows, path):
        self._columns = columns
        self._rows = rows
        self._path = path

    def __len__(self):
        return len(self._rows)

    def has(self, field):
        return field in self._columns

    def only(self, rows):
        return CsvTable(self._columns, self._rows[rows], self._path)

    def column(self, name, kind=float):
        if name not in self._columns:
            raise RunError(f"{self._path}: the run has no column '{name}'")
        cells = self._columns[name]
        if kind is str:
            return np.array([cells[row] for row in self._rows])
        try:
            return np.array([int(cells[row]) if kind in (int, bool) else float(cells[row]) for row in self._rows], kind)
        except ValueError as error:
            raise RunError(f"{self._path}: not a whole run of acus-replay: column '{name}': {error}") from None

    def values(self, field):
        components = array_fields(Force).get(field)
        if components is None:
            return self.column(self._name_of(field), TYPES.get(field, float))
        return np.stack([self.column(self._name_of(f"{field}_{component}")) for component in components], axis=1)

    def _name_of(self, stem):
        found = [stem + unit for unit in UNITS if stem + unit in self._columns]
        if not found:
            raise RunError(f"{self._path}: the run has no column '{stem}'")
        return found[0]


class StatesTable:
    """Forces of one needle, as objects."""

    def __init__(self, forces, path):
        self._forces = forces
        self._path = path

    def __len__(self):
        return len(self._forces)

    def has(self, field):  # pylint: disable=unused-argument
        return True

    def only(self, rows):
        return StatesTable([self._forces[row] for row in rows], self._path)

    def values(self, field):
        return np.array([getattr(force, field) for force in self._forces])

    def column(self, name):
        raise RunError(f"{self._path} have no column '{name}'")


def is_recording(path):
    try:
        with open(path, "rb") as file:
            return file.read(len(ZSTD)) == ZSTD
    except OSError as error:
        raise RunError(f"{path}: {error.strerror}") from None


def read_columns(path, shown):
    """Header and columns of text, decimal commas as points."""
    table = read_table(path, RunError)
    if not table.rows or "needle" not in table.header:
        raise RunError(f"{shown}: expected a run written by acus-replay, found no rows or no column 'needle'")
    if twice := [name for k, name in enumerate(table.header) if name in table.header[:k]]:
        raise RunError(f"{shown}: a second column '{twice[0]}'")
    for line, row in zip(table.lines, table.rows):
        if len(row) != len(table.header):
            raise RunError(f"{shown}:{line}: expected {len(table.header)} cells, found {len(row)}")
    return table.header, [with_points(name, cells) for name, cells in zip(table.header, zip(*table.rows))]


def with_points(name, cells):
    """The cells of a column, its numbers with decimal points."""
    if TYPES.get(name) is str or not any("," in cell for cell in cells):
        return cells
    return [cell.replace(",", ".") if WITH_COMMA.fullmatch(cell) else cell for cell in cells]


def read_dictionaries(path):
    table = read_table(path, RunError)
    columns = [with_points(name, cells) for name, cells in zip(table.header, zip(*table.rows))]
    return [dict(zip(table.header, row)) for row in zip(*columns)]


def event_of(row):
    """Of a file that may have fewer columns."""
    def number(name):
        return float(row.get(name) or "nan")

    return Event({"epoch": int(row.get("epoch") or 0), "tick": int(row.get("tick") or 0), "time": number("time_s"),
                  "needle": row["needle"], "kind": row["kind"], "region": row.get("region") or "",
                  "position": [number(f"position_{c}_m") for c in "xyz"], "force": number("force_N")})
