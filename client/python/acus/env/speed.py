# SPDX-License-Identifier: MIT
"""How many steps a second environments make: python3 -m acus.env.speed [TASK...]

The scripted policy plays episodes: in this process and with a server, alone and in as many worlds as there are processors.
`in ticks` is the share of the time that the engine's ticks take; the rest is Python's.
"""

import argparse
import os
import time

import numpy as np

from .. import engine
from .needle_env import POLICIES, TASKS, NeedleEnv
from .vector_env import VectorEnv

EPISODES = 3
TOGETHER = {"reach": 300, "force_limit": 300, "needle_order": 6}  # steps of every world


class Stopwatch:
    """Seconds of a function that stands in for it."""

    def __init__(self, function):
        self.function = function
        self.seconds = 0.0

    def __call__(self, *arguments, **named):
        begun = time.perf_counter()
        try:
            return self.function(*arguments, **named)
        finally:
            self.seconds += time.perf_counter() - begun


def play(env, task, episodes):
    """Steps and ticks of the policy's episodes."""
    steps = ticks = 0
    for seed in range(episodes):
        observation, info = env.reset(seed=seed)
        begun, over = info["tick"], False
        while not over:
            observation, _, terminated, truncated, info = env.step(POLICIES[task](observation))
            steps += 1
            over = terminated or truncated
        ticks += info["tick"] - begun
    return steps, ticks


def measure(task, on, episodes=EPISODES):
    """A dictionary: task, on, steps, ticks, seconds, steps_per_second, ticks_per_second, and in_ticks, the share of the
    time that the world takes for them, with its way there and back."""
    env = NeedleEnv(task, on=on)
    try:
        play(env, task, 1)  # the first is not counted
        env.world.step, env.world.trace = watches = Stopwatch(env.world.step), Stopwatch(env.world.trace)
        begun = time.perf_counter()
        steps, ticks = play(env, task, episodes)
        seconds = time.perf_counter() - begun
    finally:
        env.close()
    return {"task": task, "on": on, "steps": steps, "ticks": ticks, "seconds": seconds, "steps_per_second": steps / seconds,
            "ticks_per_second": ticks / seconds, "in_ticks": sum(each.seconds for each in watches) / seconds}


def measure_together(task, on, worlds, steps=None):
    """Steps a second of all worlds together."""
    steps = steps or TOGETHER[task]
    with VectorEnv(worlds, task, on=on) as env:
        observations, _ = env.reset(seed=0)
        begun = time.perf_counter()
        for _ in range(steps):
            observations = env.step([POLICIES[task](np.asarray(each)) for each in observations])[0]
        return worlds * steps / (time.perf_counter() - begun)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tasks", nargs="*", default=list(TASKS), help=f"default: all of {', '.join(TASKS)}")
    parser.add_argument("--episodes", type=int, default=EPISODES, help="of each (default: %(default)s)")
    arguments = parser.parse_args()
    worlds = os.cpu_count() or 1
    print(f"{'task':14}{'on':>8}{'steps/s':>9}{'ticks/s':>9}{'in ticks':>10}{f'steps/s of {worlds} worlds':>22}")
    for task in arguments.tasks:
        for on in ("engine", "server") if engine.available() else ("server",):
            found = measure(task, on, arguments.episodes)
            print(f"{task:14}{on:>8}{found['steps_per_second']:9.0f}{found['ticks_per_second']:9.0f}"
                  f"{found['in_ticks']:10.0%}{measure_together(task, on, worlds):22.0f}", flush=True)


if __name__ == "__main__":
    main()
