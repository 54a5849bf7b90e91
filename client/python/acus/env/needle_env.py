# SPDX-License-Identifier: MIT
"""A task as an environment with Gymnasium's interface."""

import numpy as np

from ..distributions import draw
from ..errors import EnvError
from . import force_limit, needle_order, reach
from .interface import Box, Discrete, Env
from .render import picture
from .world import make_world

TASKS = {"reach": reach.Reach, "force_limit": force_limit.ForceLimit, "needle_order": needle_order.NeedleOrder}
POLICIES = {"reach": reach.policy, "force_limit": force_limit.policy, "needle_order": needle_order.policy}


class NeedleEnv(Env):
    """`task` is a name of TASKS or a Task. `randomise` draws parameters of the scene for each episode: True for the
    task's own ranges, or {place: (low, high)}. `on`: "engine" runs it in this process, "server" in a server of its own;
    by itself the engine where it is and no further arguments are given, which are those of Server. An episode is the
    same, bit by bit, for the same seed and the same actions, on either. `render_mode`: "rgb_array" for render().

    reset(seed, options): options may hold "parameters", {place: value} in place of drawn ones, and what the task takes
    as its goal. info: "success", "tick", "parameters" after reset, and what the task adds.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 20}

    def __init__(self, task="reach", *, randomise=None, on=None, render_mode=None, **server):
        if isinstance(task, str) and task not in TASKS:
            raise EnvError(f"task: expected one of {', '.join(TASKS)}, found '{task}'")
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise EnvError(f"render_mode: expected None or 'rgb_array', found {render_mode!r}")
        self.render_mode = render_mode
        self.task = TASKS[task]() if isinstance(task, str) else task
        self.action_space = self.task.action_space
        self.observation_space = self.task.observation_space
        self.ranges = dict(self.task.ranges if randomise is True else randomise or {})
        self.scene = self.task.scene()
        self.parameters = {}  # of the scene that is loaded, where it is not the task's
        self._steps = None  # of the episode, once there is one
        self.world = make_world(self.scene, self.task.topics, on, **server)

    def reset(self, *, seed=None, options=None):
        self._open()
        options = dict(options or {})
        known = ("parameters", *self.task.options)
        if unknown := [name for name in options if name not in known]:
            raise EnvError(f"options: expected {' or '.join(known)}, found '{unknown[0]}'")
        self.task.check(options)
        super().reset(seed=seed)
        parameters = {**draw(self.ranges, self.np_random), **options.pop("parameters", {})}
        if parameters == self.parameters:
            self.world.begin()
        else:
            self._load(parameters)
        self._steps = 0
        self.task.begin(self.world, self.np_random, options)
        return self._observation(), {"success": False, "tick": self.world.states.tick, "parameters": parameters}

    def step(self, action):
        """An action beyond the bounds of a Box counts as one at them."""
        self._open()
        if self._steps is None:
            raise EnvError("step: no episode has begun, or it is over; reset() begins one")
        self.task.act(self.world, checked(action, self.action_space))
        self._steps += 1
        outcome = self.task.judge(self.world)
        truncated = not outcome.terminated and self._steps >= self.task.steps
        info = {"success": outcome.success, "tick": self.world.states.tick, **outcome.info}
        if outcome.terminated or truncated:
            self._steps = None
        return self._observation(), float(outcome.reward), bool(outcome.terminated), truncated, info

    def render(self):
        """With render_mode="rgb_array": a cut along the first needle as red, green, blue (480, 640, 3), with the target if
        there is one. On the engine; needs matplotlib."""
        self._open()
        if self.render_mode != "rgb_array":
            raise EnvError("render: make the environment with render_mode='rgb_array'")
        if not hasattr(self.world, "model"):
            raise EnvError("render: it needs an environment on the engine, on='engine'")
        target = getattr(self.task, "target", None)
        return picture(self.world.model, self.world.state, self.world.needles[0], target, self.world.guides)

    def close(self):
        world, self.world = self.world, None
        if world is not None:
            world.close()

    def _open(self):
        if self.world is None:
            raise EnvError("the environment is closed; make another one")

    def _load(self, parameters):
        scene = self.scene.copy()
        for place, value in parameters.items():
            scene[place] = value
        self.world.load(scene)
        self.parameters = parameters

    def _observation(self):
        return np.asarray(self.task.observe(self.world), dtype=self.observation_space.dtype)


def checked(action, space):
    """The action as one of the space, or EnvError."""
    if isinstance(space, Discrete):
        if not space.contains(action):
            raise EnvError(f"action: expected an integer from 0 to {space.n - 1}, found {action}")
        return int(action)
    if not isinstance(space, Box):
        return action  # of a task that has spaces of its own
    array = np.asarray(action, dtype=float)
    if array.shape != space.shape or not np.all(np.isfinite(array)):
        raise EnvError(f"action: expected {' x '.join(map(str, space.shape))} finite numbers, found {action}")
    return np.clip(array, space.low, space.high)
