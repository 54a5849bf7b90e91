# SPDX-License-Identifier: MIT
"""What NeedleEnv asks of a task. A task of one's own is a subclass, given to NeedleEnv as an object."""

from typing import NamedTuple


class Outcome(NamedTuple):
    reward: float
    terminated: bool
    success: bool
    info: dict


class Task:
    """`steps` end an episode at the latest; `topics` are those of Client; `ranges` what NeedleEnv(randomise=True)
    draws, by place in the scene: (low, high) or a function of a numpy Generator; `options` the names that begin() knows."""

    name = ""
    steps = 100
    topics = ("force",)
    action_space = None
    observation_space = None
    ranges = {}
    options = ()

    def scene(self):
        """A Scene."""
        raise NotImplementedError

    def check(self, options):
        """Raises EnvError for options that begin() cannot use; nothing has changed yet."""

    def begin(self, world, random, options):
        """An episode begins: chooses its goal by the Generator, or as the options of reset() say."""
        raise NotImplementedError

    def act(self, world, action):
        """Commands needles and runs ticks."""
        raise NotImplementedError

    def observe(self, world):
        """An array of observation_space."""
        raise NotImplementedError

    def judge(self, world):
        """Outcome of the step."""
        raise NotImplementedError
