# SPDX-License-Identifier: MIT
"""Live uncertainty: worlds of what may be true, that go along with one that runs."""

import numpy as np

from .. import engine
from ..errors import PlanError
from ..study.study import scene_of
from .checks import check_positive, check_whole
from .uncertain import FACTORS, Factors, draws_of

RATE = 100.0  # Hz


class Cloud:
    """The tips of so many `worlds` of a scene with values drawn for what is `uncertain` (as in acus.plan: factors and fields).

    Each world branches from a state of the scene, at any rate, by begin(), and gets the same commands from then on: step()
    is one tick of `rate` (Hz) of each. The first one has nothing changed: how far its tip is from the running one's is
    what the cloud's slower ticks cost. `draws`: {name: value} of each. `told`, if given, is called with (done, worlds) as
    they are loaded. Raises PlanError, SceneError.
    """

    def __init__(self, scene, uncertain=None, worlds=8, *, rate=RATE, seed=0, told=None):
        check_whole("worlds", worlds, 2)
        check_positive("rate", rate)
        self.scene = scene_of(scene)
        self.draws = draws_of(FACTORS if uncertain is None else dict(uncertain), worlds - 1, self.scene, seed)
        if len(self.draws) < worlds:
            raise PlanError("uncertain: expected something that is, found nothing: all worlds would be the same")
        self.models = []
        for draw in self.draws:
            self.models.append(engine.load(self._changed(draw, rate)))
            if told:
                told(len(self.models), worlds)
        self.states, self.time_step = [], self.models[0].time_step
        for model in self.models:
            engine.step(model, model.start())  # makes the memory of its ticks, while nobody waits

    def _changed(self, draw, rate):
        scene = self.scene.copy()
        scene["rate"] = rate
        scene["tissue.window"] = 0  # which adopts states of any
        for name, value in draw.items():
            if name not in FACTORS:
                scene[name] = value
        Factors()(scene, draw)
        return scene

    def __len__(self):
        """How many worlds go along."""
        return len(self.states)

    @property
    def time(self):
        """s of simulation, of the worlds."""
        return self.states[0].time

    def begin(self, state):
        """All go on from a state of acus.engine, of the same scene at any rate. Raises ValueError."""
        self.states = [model.adopt(state) for model in self.models]

    def step(self, commands):
        """One tick of each, with the same commands, as acus.engine takes them."""
        for model, state in zip(self.models, self.states):
            engine.step(model, state, commands)

    def tips(self, needle):
        """(worlds, 3) m."""
        return np.array([state.needle_positions(needle)[-1] for state in self.states])

    def leave_out(self):
        """The last world until the next begin(), to be faster."""
        del self.states[-1:]


def spread_of(tips):
    """m: root mean square of the distances of tips (worlds, 3) from their mean."""
    return float(np.sqrt(np.mean(np.sum((tips - tips.mean(axis=0)) ** 2, axis=1))))
