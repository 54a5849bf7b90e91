# SPDX-License-Identifier: MIT
"""Several worlds at once: on the engine each has a thread of this process, else a process of its own, with a server of its
own."""

import multiprocessing
import traceback
from concurrent.futures import ThreadPoolExecutor, wait

import numpy as np

from ..errors import AcusError, EnvError
from .needle_env import NeedleEnv, checked
from .world import is_on_engine

JOINING = 15  # s that a process may take to end its server


class VectorEnv:
    """NeedleEnv's arguments after the number of worlds; `make` (a function without arguments, of a module) makes other
    environments, in processes. As in Gymnasium's vector environments, arrays have a row per world, and an episode that is
    over begins anew by itself: the step that ends it returns the first observation of the next one, with the last one and
    its info in infos[i]["final_observation"] and infos[i]["final_info"].

    Threads step side by side, since a tick does not hold the interpreter's lock; after an interrupt call reset(). Processes
    are spawned: a program that makes a VectorEnv with them does so below `if __name__ == "__main__":`.
    """

    def __init__(self, count, task="reach", *, make=None, on=None, **arguments):
        if count < 1:
            raise EnvError(f"count: expected at least 1 world, found {count}")
        if make is None and is_on_engine(on, set(arguments) - {"randomise"}):
            self._worlds = Threads(count, lambda: NeedleEnv(task, on="engine", **arguments))
        else:
            self._worlds = Processes(count, make, task, {"on": on, **arguments})
        self.num_envs = count
        self.single_action_space, self.single_observation_space = self._worlds.spaces

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def reset(self, *, seed=None, options=None):
        """World i gets seed + i, or the i-th of a list. Observations and infos."""
        seeds = [None] * self.num_envs if seed is None else \
            [seed + i for i in range(self.num_envs)] if isinstance(seed, int) else list(seed)
        results = self._ask("reset", [{"seed": each, "options": options} for each in seeds])
        return np.stack([observation for observation, _ in results]), [info for _, info in results]

    def step(self, actions):
        """Observations, rewards, terminated, truncated (arrays with a row per world), infos (a list)."""
        # All before any world steps.
        results = self._ask("step", [checked(action, self.single_action_space) for action in actions])
        observations, rewards, terminated, truncated, infos = zip(*results)
        return np.stack(observations), np.array(rewards), np.array(terminated), np.array(truncated), list(infos)

    def close(self):
        worlds, self._worlds = self._worlds, None
        if worlds is not None:
            worlds.close()

    def _ask(self, what, values):
        if self._worlds is None:
            raise EnvError("the environments are closed; make others")
        if len(values) != self.num_envs:
            raise EnvError(f"expected {self.num_envs} of them, found {len(values)}")
        return without_trouble(self._worlds.ask(what, values))


def without_trouble(answers):
    """The results of (succeeded, result) of all worlds; raises AcusError where one has trouble."""
    trouble = [f"world {i}: {result}" for i, (succeeded, result) in enumerate(answers) if not succeeded]
    if trouble:
        raise AcusError(trouble[0])
    return [result for _, result in answers]


class Threads:
    """An environment each, stepped side by side. ask() answers (succeeded, result) of every world."""

    def __init__(self, count, make):
        self._pool = ThreadPoolExecutor(count, thread_name_prefix="acus-world")
        self._envs = [None] * count
        try:
            self._envs = without_trouble(self._all(lambda _: make(), range(count)))
        except BaseException:
            self.close()
            raise
        self.spaces = (self._envs[0].action_space, self._envs[0].observation_space)

    def ask(self, what, values):
        def one(env, value):
            return env.reset(**value) if what == "reset" else step(env, value)

        return self._all(lambda pair: one(*pair), zip(self._envs, values))

    def close(self):
        self._pool.shutdown()
        for env in self._envs:
            if env:
                env.close()
        self._envs = []

    def _all(self, function, values):
        def answer(value):
            try:
                return True, function(value)
            except Exception:  # pylint: disable=broad-except  # told to who asked, whatever it is
                return False, traceback.format_exc()

        answers = [self._pool.submit(answer, value) for value in values]
        try:
            return [each.result() for each in answers]
        except BaseException:  # an interrupt: none goes on behind the caller's back
            wait(answers)
            raise


class Processes:
    """Likewise, each in a process."""

    def __init__(self, count, make, task, arguments):
        context = multiprocessing.get_context("spawn")
        self._pipes, self._processes = [], []
        for _ in range(count):
            here, there = context.Pipe()
            process = context.Process(target=work, args=(there, make, task, arguments), daemon=True)
            process.start()
            there.close()
            self._pipes.append(here)
            self._processes.append(process)
        try:
            self.spaces = without_trouble(self._gather())[0]
        except BaseException:
            self.close()
            raise

    def ask(self, what, values):
        for pipe, value in zip(self._pipes, values):
            try:
                pipe.send((what, value))
            except OSError:
                pass  # its process has ended, which the answer tells
        return self._gather()

    def close(self):
        for pipe in self._pipes:
            try:
                pipe.send(("close", None))
            except OSError:
                pass  # it has ended
            pipe.close()
        for process in self._processes:
            process.join(JOINING)
            if process.is_alive():
                process.terminate()
        self._pipes, self._processes = [], []

    def _gather(self):
        """Of all worlds, also where one has trouble: answers and questions keep their order."""
        return [self._answer(pipe) for pipe in self._pipes]

    @staticmethod
    def _answer(pipe):
        try:
            return pipe.recv()
        except (EOFError, OSError):
            return False, "its process has ended"


def work(pipe, make, task, arguments):
    """In a process of its own, until the other end says so or is gone."""
    env = None
    try:
        env = make() if make else NeedleEnv(task, **arguments)
        pipe.send((True, (env.action_space, env.observation_space)))
        while True:
            what, value = pipe.recv()
            if what == "close":
                break
            pipe.send((True, env.reset(**value) if what == "reset" else step(env, value)))
    except (EOFError, BrokenPipeError, ConnectionResetError, KeyboardInterrupt):
        pass  # the other end is gone, or wants no more
    except Exception:  # pylint: disable=broad-except  # told at the other end, whatever it is
        pipe.send((False, traceback.format_exc()))
    finally:
        if env:
            env.close()


def step(env, action):
    observation, reward, terminated, truncated, info = env.step(action)
    if terminated or truncated:
        first, first_info = env.reset()
        info = {**first_info, "final_observation": observation, "final_info": info}
        observation = first
    return observation, reward, terminated, truncated, info
