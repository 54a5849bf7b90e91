# SPDX-License-Identifier: MIT
"""One scene and motion in many cases."""

import functools
import math
import os
import re
import threading
from collections import Counter

import numpy as np

from .. import own_files
from ..errors import StudyError
from ..programs import scene_path
from ..scene import Scene
from . import pictures
from .case import MEASURED, RESULT, Definition, Models, evaluate, output_columns, simulate
from .dask_engine import SCHEME, RemoteWork, dask_rows
from .designs import design_of
from .motions import policy_of
from .outputs import outputs_of
from .progress import Progress
from .sensitivity import Saltelli, sobol_indices
from .store import Store, is_table, remove
from .um_bridge import PORT, ModelServer
from .values import digest
from .workers import limit_of, local_rows, processors

LONGEST_NAME = 60  # characters of a folder


class Study:
    """Runs every case of a design and keeps a row of each.

    `scene`: a Scene, a scene file, or the name of one of the project. `motion`: an Insertion, a Trajectory or its path, or
    a policy, a function of a World. `parameters`: {name: list of values}, all of whose combinations are cases, or a Design;
    names are fields of the scene, or of the motion as `motion.NAME`; other ones are for `prepare(scene, values)`, which
    changes a case's scene, or for a policy. `outputs`: names of study.OUTPUTS, functions of a Result, {name: either}.
    `folder` keeps the rows, by default studies/SCENE: what is there already does not run again. Raises StudyError,
    SceneError.
    """

    def __init__(self, scene, motion, parameters, outputs=("peak_force", "tip"), *, folder=None, seed=0, prepare=None):
        scene = scene_of(scene)
        self.definition = Definition(scene, policy_of(motion), design_of(parameters), outputs_of(outputs), seed, prepare)
        self.folder = os.path.abspath(folder or os.path.join("studies", name_of(scene)))
        self._store = Store(self.folder)
        self._rows = None

    def __len__(self):
        """Of cases."""
        return len(self.definition)

    def __repr__(self):
        rows = self.rows
        failed = sum(bool(row["error"]) for row in rows)
        return f"<study of {len(self)} cases in {self.folder}: {len(rows)} have run, {failed} of them failed>"

    @property
    def parameters(self):
        """Names."""
        return self.definition.design.names

    @functools.cached_property
    def keys(self):
        """Of each case, what its row is found by."""
        return [self.definition.key_of(case) for case in range(len(self))]

    @property
    def rows(self):
        """Dictionaries, of the cases that have run, in their order."""
        if self._rows is None:
            self._rows = self._store.read()
        # The numbers of cases may have changed since.
        return [{**self._rows[key], "case": case} for case, key in enumerate(self.keys) if key in self._rows]

    def run(self, *, on=None, workers=None, failed=False, timeout=None, recordings=False, progress=True):
        """Runs what has no row yet, on so many processes, by default one for each processor, with 0 in the program itself;
        with `failed` also what has failed. A case that takes longer than `timeout` (s) fails. `recordings` keeps that of every
        case, not only of those that fail. `on`: the scheduler of a Dask cluster, dask://HOST:PORT, that runs the cases instead, by default
        $ACUS_STUDY_ON. The study itself. An interrupt keeps all rows that have come."""
        if workers is not None and not (isinstance(workers, int) and workers >= 0):
            raise StudyError(f"workers: expected a whole number, found {workers!r}")
        if on is None and workers is None:
            on = os.environ.get("ACUS_STUDY_ON") or None
        if on is not None and not (isinstance(on, str) and on.startswith(SCHEME) and workers is None):
            raise StudyError(f"on: expected dask://HOST:PORT, and no number of workers with it, found {on!r}")
        if timeout is not None and not timeout > 0:
            raise StudyError(f"timeout: expected seconds above 0, found {timeout!r}")
        if timeout is not None and workers == 0 and threading.current_thread() is not threading.main_thread():
            raise StudyError("timeout: in a thread it needs workers, that is workers=1 or more")
        with self._store as store:
            self._rows = store.read()
            missing = [case for case, key in enumerate(self.keys)
                       if key not in self._rows or (failed and self._rows[key]["error"])
                       or (recordings and not self._rows[key]["error"] and not os.path.exists(store.recording(key)))]
            self._note_definition()
            shown = Progress(len(self), len(self) - len(missing), progress)
            cases, limit = self._in_order(missing), limit_of(timeout)
            if on:
                answers = dask_rows(RemoteWork(self.definition, timeout, recordings), cases, on, limit, shown.note)
            else:
                work = LocalWork(self.definition, self.folder, timeout, recordings)
                count = processors() if workers is None else workers
                answers = local_rows(work, cases, count, limit) if count else ((case, work(case)) for case in cases)
            for case, answer in answers:
                if answer is None:
                    store.keep_part(self.keys[case])
                row, recording = answer or (self._row_of_dead_worker(case), None)
                self._keep(store, case, row, recording, recordings)
                shown.add(failed=bool(self._rows[self.keys[case]]["error"]))
            shown.end(self.failures())
            self.write(os.path.join(self.folder, "table.csv"))
        return self

    def serve(self, port=PORT, *, host="127.0.0.1", workers=None, timeout=None):
        """Answers requests of UM-Bridge until it is interrupted: inputs are the parameters, outputs the outputs."""
        with self.model_server(port, host=host, workers=workers, timeout=timeout) as server:
            try:
                server.serve_forever()
            except KeyboardInterrupt:
                pass

    def model_server(self, port=PORT, *, host="127.0.0.1", workers=None, timeout=None):
        """Likewise, as a server of http.server that listens: a `with` block, serve_forever(), `server_port`. Port 0: any."""
        return ModelServer(self.definition, host, port, workers or processors(), timeout)

    def failures(self):
        """{error: how many cases have it}, the most frequent first; numbers in it count as alike."""
        errors, first = Counter(), {}
        for row in self.rows:
            if row["error"]:
                kind = re.sub(r"0x[0-9a-f]+|[-+.\d]+(e[-+]?\d+)?", "0", row["error"])
                errors[kind] += 1
                first.setdefault(kind, row["error"])
        return {first[kind]: count for kind, count in errors.most_common()}

    def case(self, case, recording=None):
        """Runs one here and now, keeps nothing, and lets its error through. A Result. `recording`: path of a new file,
        which acus-view shows and acus-export reads."""
        return simulate(self.definition, case, Models().load(self.scene(case)), recording)

    def scene(self, case):
        """The Scene of a case."""
        return self.definition.scene_of(self._checked(case))

    def recording(self, case):
        """The path of the recording that a case left; None if there is none."""
        path = self._store.recording(self.keys[self._checked(case)])
        return path if os.path.exists(path) else None

    @property
    def _output_columns(self):
        """Those of outputs, of any row."""
        return list(dict.fromkeys(name for row in self.rows for name in output_columns(row, self.parameters)))

    @property
    def columns(self):
        """Of the table: case, parameters, outputs, results, and measurements, which differ from run to run."""
        return ["case", *self.parameters, *self._output_columns, *RESULT, *MEASURED]

    @property
    def table(self):
        """A pandas DataFrame, a row for each case that has run. Needs pandas."""
        try:
            import pandas  # pylint: disable=import-outside-toplevel  # takes a second, for some users only
        except ImportError:
            raise StudyError("a DataFrame needs pandas (apt install python3-pandas); rows and table.csv do not") from None
        return pandas.DataFrame(self.rows, columns=self.columns)

    def values(self, output):
        """A column of numbers as an array, by case; NaN where a case has not run, failed, or has none."""
        if output not in self.columns:
            raise StudyError(f"'{output}': no column of the table; it has {', '.join(self._output_columns) or 'no outputs'}")
        values = np.full(len(self), np.nan)
        for row in self.rows:
            value = row.get(output)
            if row["error"]:
                continue
            if isinstance(value, str):
                raise StudyError(f"'{output}': expected a column of numbers, found the text '{value[:100]}'")
            if value is not None:
                values[row["case"]] = value
        return values

    def indices(self, output, confidence=0.95):
        """Sobol indices of an output, a sensitivity.Index for each parameter; for the design saltelli()."""
        design = self.definition.design
        if not isinstance(design, Saltelli):
            raise StudyError(f"Sobol indices need the cases of study.saltelli(), not of a {design.kind}")
        return sobol_indices(design.names, self.values(output), confidence)

    def draw(self, path, outputs=None):
        """A picture (.png, .svg, .pdf) of what outputs depend on, by default all numbers: for each a tornado and the cases
        over each parameter. Needs matplotlib."""
        outputs = [outputs] if isinstance(outputs, str) else outputs
        numbers = [name for name in self._output_columns if self._has_numbers(name)]
        chosen = numbers[:pictures.MOST_OUTPUTS] if outputs is None else list(outputs)
        if not chosen:
            raise StudyError("a picture needs an output that is a number, and cases that have run")
        values = {output: self.values(output) for output in chosen}
        for output, each in values.items():
            if not np.isfinite(each).any():
                raise StudyError(f"'{output}': no case has a finite number for it")
        pictures.draw_sensitivity(self, os.fspath(path), values, len(numbers) if outputs is None else len(chosen))

    def draw_spread(self, path, output="tip"):
        """A picture of where a point of all cases is, from three sides. Needs matplotlib."""
        pictures.draw_spread(self, os.fspath(path), output)

    @property
    def digest(self):
        """A hash (hex) of all but the measurements: the same on any number of workers."""
        known = [name for name in self.columns if name not in MEASURED]
        return digest([[row.get(name) for name in known] for row in self.rows])

    def write(self, path):
        """The table as CSV, or, where the name ends so, as Parquet, which needs pandas and pyarrow."""
        path = os.fspath(path)
        if not path.endswith((".csv", ".parquet")):
            raise StudyError(f"{path}: expected a name that ends with .csv or .parquet")
        try:
            if path.endswith(".parquet"):
                data = self.table.to_parquet()
            else:
                data = own_files.table_of(self.columns, ([row.get(name) for name in self.columns] for row in self.rows))
            own_files.write(path, data, is_table, StudyError)
        except ImportError:
            raise StudyError(f"{path}: Parquet needs pyarrow; a name that ends with .csv needs nothing") from None

    # ---- Parts of run() ----

    def _keep(self, store, case, row, recording, recordings):
        """`recording`: its bytes, of a case that ran elsewhere. `recordings`: those of cases that succeed are kept."""
        key, text = self.keys[case], row.pop("traceback", row["error"])
        self._rows[key] = row
        if recording is not None:
            store.keep_recording(key, recording)
        if row["error"]:
            store.note_failure(key, text)
        else:
            store.forget(key, recording=not recordings)
        store.write(key, row)

    def _row_of_dead_worker(self, case):
        error = "the process died: of a crash, for want of memory, of its time, or with its machine"
        return {"case": case, **self.definition.flat_values(case), "error": error, "seed": self.definition.seed_of(case)}

    def _in_order(self, cases):
        """Those with the same scene one after the other: a worker loads it once."""
        order = {}
        scenes = {case: order.setdefault(repr(self.definition.part_of(case, "scene")), len(order)) for case in cases}
        return sorted(cases, key=scenes.get)

    def _note_definition(self):
        told = {"cases": len(self), "design": self.definition.design.kind, "parameters": self.parameters,
                "motion": repr(self.definition.motion), "outputs": list(self.definition.outputs),
                "seed": self.definition.seed}
        self._store.note_definition(told, self.definition.scene.text())

    def _has_numbers(self, output):
        return any(isinstance(row.get(output), (bool, int, float)) and math.isfinite(row[output]) and not row["error"]
                   for row in self.rows)

    def _checked(self, case):
        if not isinstance(case, (int, np.integer)) or not 0 <= case < len(self):
            raise StudyError(f"case: expected 0 to {len(self) - 1}, found {case!r}")
        return case


class LocalWork:
    """(row, None) of a case, whose recording lies in the folder; that of one that succeeds is removed unless it is to be
    kept."""

    def __init__(self, definition, folder, timeout, recordings):
        self._definition, self._store, self._timeout, self._recordings = definition, Store(folder), timeout, recordings
        self._models = Models()  # of each worker

    def __call__(self, case):
        key = self._definition.key_of(case)
        part = self._store.part(key)
        os.makedirs(os.path.dirname(part), exist_ok=True)
        remove(part)
        row = evaluate(self._definition, case, self._models, part, self._timeout)
        if row["error"] or self._recordings:
            self._store.keep_part(key)
        else:
            remove(part)
        return row, None


def scene_of(given):
    if isinstance(given, Scene):
        return given.copy()
    return Scene.read(scene_path(given))


def name_of(scene):
    """As part of a path."""
    return re.sub(r"\W+", "_", str(scene.fields.get("name", "scene"))).strip("_")[:LONGEST_NAME] or "scene"
