# SPDX-License-Identifier: MIT
"""The cases of a study: what each is, and how one runs. Nothing here depends on which worker runs it, or when."""

import contextlib
import functools
import os
import platform
import signal
import time
import traceback

import numpy as np

from .. import engine
from ..errors import SceneError, StudyError
from ..scene import Scene
from .motions import check_motion_name, motion_names, with_values
from .outputs import Result, flattened
from .values import digest
from .world import World

MODELS = 2  # that a worker keeps, newest first
RESULT = ("ticks", "flags", "hash", "seed", "error")  # of each case, beside parameters and outputs
MEASURED = ("version", "build", "processor", "calibration", "load_time", "wall_time", "tick_p50", "tick_p99")  # not reproducible
RESERVED = {"case", "traceback", *RESULT, *MEASURED}
MOTION = "motion."


class Definition:
    """Constant; goes to every worker. `outputs` are {name: function}, `prepare(scene, values)` changes a case's scene after
    its parameters, and takes those that are no fields of it."""

    def __init__(self, scene, motion, design, outputs, seed=0, prepare=None):
        self.scene, self.motion, self.design = scene, motion, design
        self.outputs, self.seed, self.prepare = outputs, seed, prepare
        if isinstance(seed, bool) or not isinstance(seed, int):
            raise StudyError(f"seed: expected a whole number, found {seed!r}")
        self.kinds = {name: kind_of(name, scene, motion, prepare) for name in design.names}
        check_columns(scene, design.names, self.kinds, outputs)

    def __len__(self):
        return len(self.design)

    @functools.cached_property
    def constant_digest(self):
        return digest(self.scene.text(), mesh_digest(self.scene), self.motion, self.outputs, self.prepare, engine.build(), package_digest())

    @functools.cached_property
    def repetitions(self):
        """Of each case, how often the same values have come before."""
        seen, numbers = {}, []
        for case in range(len(self)):
            values = repr(sorted(self.design[case].items()))
            numbers.append(seen.get(values, 0))
            seen[values] = numbers[-1] + 1
        return numbers

    def seed_of(self, case):
        """By the case's values, so that it stays where others come before it; in a Saltelli sample by its row, so that what
        is drawn does not count as an influence."""
        if self.design.base:
            return int(digest(self.seed, case % self.design.base)[:13], 16)
        return int(digest(self.seed, self.design[case], self.repetitions[case])[:13], 16)

    def key_of(self, case):
        """Changes with all that the results depend on."""
        return digest(self.constant_digest, self.design[case], self.seed_of(case), self._mesh_of(case))[:32]

    def _mesh_of(self, case):
        """What its mesh file holds, where it may be another than the study's."""
        if not self.prepare and not any(name.startswith("tissue.mesh") for name in self.design.names):
            return None
        try:
            return mesh_digest(self.scene_of(case))
        except Exception:  # pylint: disable=broad-except  # whatever prepare raises: the case tells it when it runs
            return None

    def part_of(self, case, kind):
        """Parameters of the motion (without `motion.`), or of the scene."""
        return {name.removeprefix(MOTION): value for name, value in self.design[case].items() if self.kinds[name] == kind}

    def flat_values(self, case):
        """Parameters as cells of a table."""
        return {name: value if isinstance(value, (bool, int, float, str)) or value is None else repr(value)
                for name, value in self.design[case].items()}

    def scene_of(self, case):
        scene = self.scene.copy()
        for place, value in self.part_of(case, "scene").items():
            scene[place] = value
        if self.prepare:
            changed = self.prepare(scene, self.design[case])
            if changed is not None and not isinstance(changed, Scene):
                raise StudyError(f"prepare: expected that it returns nothing or a Scene, found {type(changed).__name__}")
            scene = scene if changed is None else changed
        return scene

    def motion_of(self, case):
        return with_values(self.motion, self.part_of(case, "motion"))


def kind_of(name, scene, motion, prepare):
    """Of a parameter: "motion", "scene", or "free", for `prepare` and a policy that is a function. Raises StudyError."""
    if not isinstance(name, str):
        raise StudyError(f"parameters: expected the name of a field, found {name!r}")
    if name in RESERVED:
        raise StudyError(f"parameters: '{name}' is the name of a column of the table; take another one")
    if name.startswith(MOTION):
        check_motion_name(motion, name.removeprefix(MOTION))
        return "motion"
    free = prepare or not motion_names(motion)
    if free and "." not in name and "[" not in name and name not in Scene.schema()["properties"]:
        return "free"
    try:
        scene.schema_at(name)
    except SceneError as error:
        other = "" if "." in name or "[" in name else "; a name of your own is for prepare=, or for a motion that is a function"
        raise StudyError(f"parameters: {error}{other}") from None
    return "scene"


def check_columns(scene, names, kinds, outputs):
    """No two parameters mean one field, and no output has the name of another column."""
    places = {}
    for name in names:
        if kinds[name] == "scene" and (other := places.setdefault(scene.counted(name), name)) != name:
            raise StudyError(f"parameters: '{other}' and '{name}' are the same field")
    for name in outputs:
        if name in RESERVED or name in names:
            raise StudyError(f"outputs: '{name}' is the name of another column of the table; give names, {{name: output}}")


def output_columns(row, parameters):
    """Of a row those of outputs, tip.x and such."""
    known = {"case", "traceback", *parameters, *RESULT, *MEASURED}
    return [name for name in row if name not in known]


COMPANIONS = {".ele": ".node", ".node": ".ele"}  # TetGen's meshes are two files of one name


def mesh_digest(scene):
    """Of the content of a scene's mesh file; None where it has none, or there is no such file."""
    try:
        path = os.path.join(scene.folder or "", scene.fields["tissue"]["mesh"]["gmsh"]["file"])
        stem, ending = os.path.splitext(path)
        companion = stem + COMPANIONS[ending] if ending in COMPANIONS else None
        digests = [file_digest(each, os.stat(each).st_mtime_ns, os.stat(each).st_size) for each in (path, companion) if each]
        return digest(digests) if companion else digests[0]
    except (KeyError, TypeError, OSError):
        return None


@functools.lru_cache(64)
def file_digest(path, *_):
    """`_`: what changes when the file does."""
    with open(path, "rb") as file:
        return digest(file.read())


@functools.cache
def package_digest():
    """Of the sources of this package."""
    folder = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    paths = sorted(os.path.join(where, name) for where, _, names in os.walk(folder) for name in names if name.endswith(".py"))
    return digest([(os.path.relpath(path, folder), file_digest(path)) for path in paths])


class Models:
    """Loaded scenes by their text: a case with the same scene as one before finds its mesh and factor ready."""

    def __init__(self, most=MODELS):
        self._most, self._loaded = most, {}

    def load(self, scene):
        text = scene.text()
        key = (text, mesh_digest(scene))
        model = self._loaded.pop(key, None) or engine.load(text)
        self._loaded[key] = model
        while len(self._loaded) > self._most:
            del self._loaded[next(iter(self._loaded))]
        return model


def simulate(definition, case, model, recording=None):
    """The Result of a case on the model of its scene. `recording`: the path of a new file."""
    return carried_out(definition.motion_of(case), model, definition.design[case], definition.seed_of(case), recording)


def carried_out(motion, model, parameters=None, seed=0, recording=None):
    """The Result of a motion."""
    bodies = motion.bodies(model) if hasattr(motion, "bodies") else None
    world = World(model, parameters, seed, bodies)
    if recording:
        world.state.record(recording)
    try:
        motion(world)
    finally:
        world.state.end_recording()
    return Result(world, getattr(motion, "needle", None))


def evaluate(definition, case, models, recording=None, timeout=None):
    """The row of a case, {column: value}; of one that fails, or takes longer than `timeout` (s), with `error` and
    `traceback`. A timeout is for the main thread of a process."""
    begin = time.perf_counter()
    row = {"case": case, **definition.flat_values(case)}
    times = {}
    try:
        with limited(timeout):
            run(definition, case, models, recording, row, times)
        row["error"] = ""
    except (Exception, SystemExit, CaseTimeout) as error:  # pylint: disable=broad-except  # a case that fails is a result, too
        kind = TimeoutError if isinstance(error, CaseTimeout) else type(error)
        row["error"] = f"{kind.__name__}: {error}".strip().replace("\n", " ")
        row["traceback"] = traceback.format_exc()
    row["seed"] = definition.seed_of(case)
    row.update({"version": engine.version(), "build": engine.build(), "processor": processor(),
                "calibration": calibration()}, **times)
    row["wall_time"] = time.perf_counter() - begin
    return row


def run(definition, case, models, recording, row, times):
    """Adds to row and times."""
    begin = time.perf_counter()
    model = models.load(definition.scene_of(case))
    times["load_time"] = time.perf_counter() - begin
    result = simulate(definition, case, model, recording)
    for name, output in definition.outputs.items():
        columns = flattened(name, output(result))
        if taken := [column for column in columns if column in row or column in RESERVED]:
            raise StudyError(f"outputs: '{name}': there is a column '{taken[0]}' already")
        row.update(columns)
    row["ticks"], row["flags"] = result.state.tick, " ".join(result.flags)
    row["hash"] = f"{result.state.hash:016x}"
    times.update(tick_times(result.world.tick_times))


class CaseTimeout(BaseException):
    """No Exception: a motion that catches those does not go on."""


@contextlib.contextmanager
def limited(timeout):
    """Raises CaseTimeout inside it after so many seconds, and again each second."""
    def over(*_):
        raise CaseTimeout(f"the case took longer than {timeout:g} s")

    if timeout is None:
        yield
        return
    before = signal.signal(signal.SIGALRM, over)
    signal.setitimer(signal.ITIMER_REAL, timeout, 1.0)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def tick_times(times):
    """s"""
    if not times:
        return {}
    return dict(zip(("tick_p50", "tick_p99"), map(float, np.percentile(times, [50, 99]))))


# ---- The machine ----


@functools.cache
def processor():
    try:
        with open("/proc/cpuinfo", encoding="ascii", errors="replace") as file:
            name = next((line.partition(":")[2].strip() for line in file if line.startswith("model name")), "")
    except OSError:
        name = ""
    return name or platform.processor() or platform.machine()


@functools.cache
def calibration_work():
    return np.random.default_rng(0).uniform(size=(1000, 1000)), np.ones(1000)


def calibration():
    """s, of a product of a 1000 x 1000 matrix and a vector, the fastest of five: how fast this processor was just now."""
    matrix, vector = calibration_work()
    times = []
    for _ in range(5):
        begin = time.perf_counter()
        matrix @ vector  # pylint: disable=pointless-statement
        times.append(time.perf_counter() - begin)
    return min(times)
