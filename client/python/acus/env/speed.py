# SPDX-License-Identifier: MIT
"""How many steps a second an environment makes, and what they are spent on: python3 -m acus.env.speed [TASK...]

The scripted policy plays episodes, once timed and once recorded. acus-export then makes the same ticks of the recording
again, in process and without sockets: what is left of the time in the client's step is that of ipc, with packing and
unpacking at both ends; the rest is the task's own Python.
"""

import argparse
import os
import subprocess
import tempfile
import time

from ..programs import find_program
from .needle_env import POLICIES, TASKS, NeedleEnv

EPISODES = 3
RECORDING, NOTHING = "episodes.acus", "nothing.acus"


class Stopwatch:
    """Seconds and calls of a function of an object that stands in for it."""

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


def record(env, task, name, episodes):
    env.world.client.record(name)
    play(env, task, episodes)
    env.world.client.end_recording()


def seconds_in_process(recording):
    """That acus-export takes for a recording, the loading included."""
    begun = time.perf_counter()
    subprocess.run([find_program("acus-export"), recording, "--quiet"], check=True)
    return time.perf_counter() - begun


def measure(task, episodes=EPISODES):
    """A dictionary: steps, ticks, seconds, steps_per_second, ticks_per_second, and the shares of the time: in_process,
    ipc, python."""
    with tempfile.TemporaryDirectory(prefix="acus-speed-") as folder:
        env = NeedleEnv(task, options=["--recordings", folder])
        try:
            client = env.world.client
            record(env, task, NOTHING, 0)
            play(env, task, 1)  # the first is not counted
            client.step, client.trace, client.restore = (
                Stopwatch(function) for function in (client.step, client.trace, client.restore))
            begun = time.perf_counter()
            steps, ticks = play(env, task, episodes)
            seconds = time.perf_counter() - begun
            served = sum(each.seconds for each in (client.step, client.trace, client.restore))
            record(env, task, RECORDING, episodes)
        finally:
            env.close()
        ticked = seconds_in_process(os.path.join(folder, RECORDING)) - seconds_in_process(os.path.join(folder, NOTHING))
    return {"task": task, "steps": steps, "ticks": ticks, "seconds": seconds, "steps_per_second": steps / seconds,
            "ticks_per_second": ticks / seconds, "in_process": ticked / seconds, "ipc": (served - ticked) / seconds,
            "python": 1 - served / seconds}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tasks", nargs="*", default=list(TASKS), help=f"default: all of {', '.join(TASKS)}")
    parser.add_argument("--episodes", type=int, default=EPISODES, help="of each (default: %(default)s)")
    arguments = parser.parse_args()
    print(f"{'task':14}{'steps/s':>9}{'ticks/s':>9}{'ticks in process':>18}{'ipc':>7}{'Python':>8}")
    for task in arguments.tasks:
        found = measure(task, arguments.episodes)
        print(f"{task:14}{found['steps_per_second']:9.0f}{found['ticks_per_second']:9.0f}{found['in_process']:17.0%} "
              f"{found['ipc']:7.0%}{found['python']:8.0%}")


if __name__ == "__main__":
    main()
