# SPDX-License-Identifier: MIT
"""A Cloud that goes along with a running server: it branches from the server's state when an epoch begins, and gets the
commands that the server's forces tell of."""

import os
import time
from collections import deque

import numpy as np
import zmq

from acus import engine
from acus.client import Client
from acus.errors import AcusError, KeysRefused, PlanError, Vanished
from acus.link import Link
from acus.messages import decode
from acus.plan.cloud import Cloud, spread_of
from acus.programs import find_scene
from acus.study.study import scene_of

PATIENCE = 5.0  # s for an answer
AGAIN = 1.0  # s until what did not work is tried once more
KEPT = 100_000  # states that may wait
LATE, TOO_LATE = 0.25, 5.0  # s behind a server in real time: from where on there are fewer worlds; they begin anew
LEAST = 2  # worlds
SHOWN = 60.0  # Hz of simulation time, of messages, at most


class Follower:
    """Call poll() again and again. `cloud`: None while there is nothing to follow, `why` says why not. `share` of real time
    that the worlds take.

    `scene`: Scene, file or name of what the server simulates; None: of its file's name, if it is one of the project.
    `settings`: of Cloud, with `rate` (Hz) to be met nearly.
    """

    def __init__(self, commands, states, keys=None, scene=None, *, rate, **settings):
        self.cloud, self.why, self.share = None, "", 0.0
        self._endpoints, self._keys, self._scene, self._rate, self._settings = (commands, states), keys, scene, rate, settings
        self._context = zmq.Context()
        self._states = Link(self._context, zmq.SUB, states, keys, [(zmq.RCVHWM, KEPT)])
        self._states.socket.subscribe("force")
        self._client, self._first = None, None  # the name of the scene's file at first
        self._loaded, self._base, self._made = None, None, None  # what of the server; its Model; a Cloud of it
        self._epoch, self._reached, self._newest = None, 0, 0  # that is followed, None: none; ticks of the worlds, the server
        self._passed = False  # whether the server's forces are past the state that the worlds branched from
        self._due, self._coming = deque(), (0, {})  # (tick, {needle: force}) to be reached; that is coming in
        self._tried = self._told = self._looked = -np.inf  # times
        self._before = 0.0  # s behind, when that was looked at
        self._busy = deque(maxlen=200)  # s of each of the worlds' ticks

    def close(self):
        self._forget_client()
        self._context.destroy(linger=0)

    @property
    def behind(self):
        """s of simulation time that the worlds are behind the server."""
        return max(0.0, (self._newest - self._reached) * self._base.time_step) if self.cloud else 0.0

    def poll(self, timeout):
        """Waits for the server at most `timeout` (s), and does a tick of the worlds if one is due. A message when it is time
        for one, and when the worlds have branched: the fields of protocol/README.md, "cloud"; else None. Raises PlanError,
        KeysRefused."""
        if self._epoch is None:
            return self._begin(timeout)
        if not self._due:
            self._states.socket.poll(1000 * timeout)
        self._take_forces()
        return self._tick() if self._due else None

    # ---- The server's scene and state ----

    def _begin(self, timeout):
        left = self._tried + AGAIN - time.monotonic()
        if left > 0:
            time.sleep(min(left, timeout))
            return None
        self._tried, self.cloud = time.monotonic(), None
        self._take_forces()  # of what is not followed: they would fill the queue
        try:
            return self._branch()
        except (PlanError, KeysRefused):
            raise  # waiting mends neither
        except (AcusError, ValueError, OSError) as error:
            self.why = str(error)
            if isinstance(error, Vanished):
                self._forget_client()
            return None

    def _forget_client(self):
        if self._client:
            self._client.close()
        self._client = None

    def _branch(self):
        self._client = self._client or Client(*self._endpoints, keys=self._keys, topics=(), timeout=PATIENCE)
        hello = self._client.refresh()
        loaded = (hello.instance, hello.scene, hello.file, hello.rate)
        if loaded != self._loaded:
            self._load(hello)
        snapshot = self._client.snapshot()
        self._made.begin(self._base.state(snapshot.snapshot))  # ValueError if it is another scene after all
        self._loaded = loaded
        self._epoch, self._reached, self._newest = snapshot.epoch, snapshot.tick, snapshot.tick
        self._passed = False
        self._due.clear()
        self.cloud, self.why, self._told = self._made, "", -np.inf
        needles = [self._needle(each.name, self.cloud.tips(each.name)[0]) for each in self._base.needles]
        return self._message(snapshot.tick, self.cloud.time, needles)  # a server in lockstep may not go on for long

    def _load(self, hello):
        scene = scene_of(self._scene_of(hello))
        scene["rate"] = hello.rate
        self._loaded, self._base = None, engine.load(scene)
        self._made = Cloud(scene, rate=hello.rate / self._stride, **self._settings)

    @property
    def _stride(self):
        """Ticks of the server in one of the worlds."""
        return max(1, round(self._base.rate / self._rate))

    def _scene_of(self, hello):
        """What was given, or another one beside it that the server has loaded meanwhile."""
        name = hello.file or ""
        self._first = self._first or name
        if self._scene is None:
            return find_scene(name.removesuffix(".yaml"))
        if name == self._first or not isinstance(self._scene, (str, os.PathLike)):
            return self._scene
        beside = os.path.join(os.path.dirname(self._scene), name)
        return beside if os.path.isfile(beside) else find_scene(name.removesuffix(".yaml"))

    # ---- Its forces ----

    def _take_forces(self):
        for _ in range(KEPT):
            try:
                force = decode(self._states.socket.recv_multipart(zmq.NOBLOCK)[-1])
            except zmq.Again:
                return
            except AcusError:
                continue
            if force["type"] == "force" and self._epoch is not None and force["epoch"] >= self._epoch:
                self._take(force)

    def _take(self, force):
        tick = force["tick"]
        same = force["epoch"] == self._epoch
        if same and not self._passed and tick <= self._reached:  # was on its way when the state was told
            return
        self._passed = True
        if not same or tick + self._stride < self._newest:  # a reset; another start of the server
            self._leave()
            return
        self._newest = max(self._newest, tick)
        if self._coming[0] != tick:
            self._coming = (tick, {})
        self._coming[1][force["needle"]] = force
        before = self._due[-1][0] if self._due else self._reached
        if len(self._coming[1]) == len(self._base.needles) and tick >= before + self._stride:
            self._due.append(self._coming)

    def _leave(self):
        self._epoch, self._tried, self._coming = None, -np.inf, (0, {})
        self._due.clear()

    # ---- The worlds ----

    def _tick(self):
        tick, forces = self._due.popleft()
        commands = {name: (force["commanded_position"], force["commanded_orientation"], force["spin"]) for name, force in forces.items()}
        for _ in range(max(1, round((tick - self._reached) / self._stride))):  # more than one where states were lost
            began = time.perf_counter()
            self.cloud.step(commands)
            self._busy.append(time.perf_counter() - began)
        self._reached, self.share = tick, float(np.mean(self._busy)) / self.cloud.time_step
        self._keep_up()
        first = next(iter(forces.values()))
        if first["time"] < self._told + 1 / SHOWN - 1e-9:
            return None
        self._told = first["time"]
        return self._message(tick, first["time"], [self._needle(name, force["tip_position"]) for name, force in forces.items()])

    def _keep_up(self):
        """A server in real time does not wait: worlds that fall behind, and do not catch up, become fewer."""
        if self._client.hello.lockstep:
            return
        if self.behind > TOO_LATE:
            self._leave()
        elif time.monotonic() > self._looked + AGAIN:
            if LATE < self.behind >= self._before and len(self.cloud) > LEAST:
                self.cloud.leave_out()
            self._looked, self._before = time.monotonic(), self.behind

    def _message(self, tick, seconds, needles):
        return {"epoch": self._epoch, "tick": tick, "time": seconds, "behind": self.behind, "needles": needles}

    def _needle(self, name, tip):
        """`tip`: (3,) m, the server's."""
        tips = self.cloud.tips(name)
        return {"name": name, "tips": tips.astype("<f8").tobytes(), "spread": spread_of(tips), "error": float(np.linalg.norm(tips[0] - tip))}
