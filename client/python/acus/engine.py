# SPDX-License-Identifier: MIT
"""The simulation in this process, without a server: models, states that are values, and steps.

    model = engine.load("insertion_pullback")
    state = model.start()
    needle = model.needles[0]
    report = engine.step(model, state, {"needle": (position, orientation, spin)})
    print(report["needle"].base_force, report.events)

It is the module acus_engine, compiled from the server's code (GPL-3.0-or-later): scripts/build makes it where pybind11 is
installed, and the Debian package python3-acus-engine has it. `available()` tells whether it is there.
"""

import functools
import glob
import hashlib
import importlib.util
import operator
import os
import sys
import threading

from .errors import ProgramNotFound, SceneError
from .messages import Guide, Needle
from .programs import CHECKOUT, find_program, find_server
from .scene import Scene, counted_in_words, file_of

MODULE = "acus_engine"
_LOCK = threading.RLock()
NEEDED = {"avx2", "bmi2", "fma"}  # of the processor: it is compiled for the level x86-64-v3


def _find():
    """The module's file: of the build that the server is of, or as Python finds it; None if it is not there."""
    try:
        build = os.path.dirname(os.path.dirname(os.path.realpath(find_server())))
    except ProgramNotFound:
        build = os.path.join(CHECKOUT, "build", "release")
    built = glob.glob(os.path.join(build, "python", MODULE + ".*.so"))
    return importlib.util.spec_from_file_location(MODULE, built[0]) if built else importlib.util.find_spec(MODULE)


def _processor_can():
    try:
        with open("/proc/cpuinfo", encoding="ascii", errors="replace") as file:
            flags = next((line for line in file if line.startswith("flags")), "")
    except OSError:
        return True
    return not flags or NEEDED <= set(flags.split())


def available():
    """Whether the compiled module is there, and this processor can run it."""
    return (MODULE in sys.modules or _find() is not None) and _processor_can()


def version():
    """Of the compiled engine. Raises ProgramNotFound."""
    return _module().version


@functools.cache
def build():
    """A hash (hex) of the compiled engine: with the same one, the same scene and commands give the same bits on the same
    kind of processor. Raises ProgramNotFound."""
    with open(_module().__file__, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()[:16]


def _module():
    """Loaded when it is needed first. Raises ProgramNotFound."""
    with _LOCK:
        return sys.modules.get(MODULE) or _import()


def _import():
    found = _find()
    if found is None:
        raise ProgramNotFound("the compiled engine is not there; install pybind11-dev and python3-dev and run "
                              "scripts/build, or install the package python3-acus-engine")
    if not _processor_can():
        raise ProgramNotFound("the compiled engine needs a processor of the level x86-64-v3 (AVX2, FMA)")
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    try:
        module.use_mesh_program(find_program("acus-mesh"))
    except ProgramNotFound:
        pass  # a scene with a mesh file says so
    sys.modules[MODULE] = module
    return module


class Model:
    """A loaded scene, which states share; any number of threads may use it. `needles` and `guides` as in `hello`."""

    def __init__(self, loaded):
        self._loaded = loaded
        self.name, self.rate, self.time_step = loaded.name, loaded.rate, loaded.time_step
        self.needles = [Needle(each) for each in loaded.needles]
        self.guides = [Guide(each) for each in loaded.guides]
        self.regions = loaded.regions
        self.tetrahedra = loaded.tetrahedra  # nodes of each, n x 4
        self.tetrahedron_regions = loaded.tetrahedron_regions  # number of the region of each
        self.rest_positions = loaded.rest_positions  # m, nodes x 3

    def __repr__(self):
        told = [counted_in_words(*each) for each in ((len(self.rest_positions), "node"), (len(self.regions), "region"), (len(self.needles), "needle"))]
        return f"<Model of {self.name!r}: {', '.join(told)}, {self.rate:g} Hz>"

    def start(self, bodies=None):
        """The state after loading. `bodies`, {name: (position, orientation)}, puts needles and guides elsewhere, as if
        the scene had them there. Raises ValueError or KeyError, also for a tip inside the tissue."""
        return self._loaded.start(bodies or {})

    def state(self, snapshot):
        """Of the bytes of a state, or of a snapshot of a server with the same scene. Raises ValueError."""
        if not isinstance(snapshot, (bytes, bytearray, memoryview)):
            raise TypeError(f"a snapshot: expected bytes, found {type(snapshot).__name__}")
        return self._loaded.state(bytes(snapshot))

    def adopt(self, state):
        """A copy of a state of another scene, to go on in this one, which differs in numbers alone: materials,
        interactions, a bevel's direction, the rate. Raises ValueError for what differs in more."""
        return self._loaded.adopt(state)


def load(scene):
    """Model of a Scene, a scene file, a scene of the project by its name, or YAML with more than one line. Raises SceneError, ProgramNotFound."""
    module = _module()
    try:
        with _LOCK:  # one at a time: OpenBLAS without threads may not be called by several
            if isinstance(scene, Scene):
                return Model(module.Model.parse(scene.text(), scene.folder or ""))
            text = os.fsdecode(scene)
            return Model(module.Model.parse(text) if "\n" in text else module.Model.read(file_of(text)))
    except module.SceneError as error:
        raise SceneError(str(error)) from None


def step(model, state, commands=None, ticks=1):
    """Moves the state on by so many ticks, and returns the Report of the last. `commands` are taken in by the first of
    them: {name: (position, orientation)} or (position, orientation, spin), as `pose` has them; a body without one keeps
    its last. The interpreter's lock is released meanwhile. Raises ValueError or KeyError for a command that cannot be
    used; the state is as it was."""
    if not isinstance(state, _module().State):
        raise TypeError(f"a state: expected what Model.start() returns, found {type(state).__name__}")
    if state.model is not model._loaded:  # pylint: disable=protected-access
        raise ValueError("the state is of another model")
    return state.step(commands or {}, operator.index(ticks))
