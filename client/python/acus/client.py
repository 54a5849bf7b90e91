# SPDX-License-Identifier: MIT
"""A client of acus-server: requests and commands on one connection, states on another."""

import time
from collections import deque

import numpy as np
import zmq

from . import messages
from .errors import KeysRefused, ProtocolMismatch, Refused, Vanished
from .inbox import Inbox
from .link import Link
from .messages import DescribeReply, Done, HashReply, HelloReply, Holding, SnapshotReply

COMMANDS, STATES = "tcp://127.0.0.1:5750", "tcp://127.0.0.1:5751"
TIMEOUT = 10.0  # s
LONGEST_STEP = 100_000  # ticks of one request
LINGER = 100  # ms that closing waits for commands to leave
MOST_SNAPSHOTS = 1000  # of which it is known which commands they had had
STATES_KEPT = 100_000  # that have come and were not read yet; then the newest are lost
STREAMS = ("pose", "spin")


class Client:
    """Connected to a server from the beginning: raises Vanished if none answers within `timeout` (s).

    If the connection ends, whatever is asked next waits for the server to be there again, at most `timeout`; needles
    that were held are acquired again by the next pose. An object belongs to one thread at a time.
    """

    def __init__(self, commands=COMMANDS, states=STATES, *, keys=None, topics=("force", "event"), timeout=TIMEOUT):
        self.timeout = timeout
        self.hello = None  # HelloReply
        self.reconnections = 0
        self._seq = 0
        self._commanded = {}  # (count of commands, orientation), by name
        self._commanded_by = {}  # the same when a snapshot was taken, by its hash
        self._held = set()
        self._lost = 0  # connections, of which this object knows
        self._rejections = deque(maxlen=1000)  # of poses and spins
        self._inbox = Inbox()
        self._topics = set(topics)
        self._context = zmq.Context()
        try:
            self._requests = Link(self._context, zmq.DEALER, commands, keys, [(zmq.IMMEDIATE, 1)])
            self._states = Link(self._context, zmq.SUB, states, keys, [(zmq.RCVHWM, STATES_KEPT)])
            self._poller = zmq.Poller()
            for socket in (self._requests.socket, self._states.socket, self._requests.monitor, self._states.monitor):
                self._poller.register(socket, zmq.POLLIN)
            for topic in topics:
                self._states.socket.subscribe(topic)
            self._states.socket.subscribe("stats")  # the last: once one comes, the others are in effect
            self._inbox.stats_awaited = 1
            self._greet(self._deadline())
        except BaseException:
            self.close()
            raise

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        """What this client holds is released."""
        if not self._context.closed:
            if hasattr(self, "_requests"):
                self._requests.socket.setsockopt(zmq.LINGER, LINGER)
            self._context.destroy()

    # ---- What is simulated ----

    @property
    def needles(self):
        """Needle of each, in the order of the scene."""
        return self.hello.needles

    @property
    def guides(self):
        return self.hello.guides

    @property
    def time_step(self):
        """s"""
        return self.hello.time_step

    @property
    def shapes(self):
        """The newest NeedleShape that has come, by the needle's name."""
        return self._inbox.shapes

    @property
    def tissue(self):
        """The newest TissueShape that has come, or None."""
        return self._inbox.tissue

    @property
    def stats(self):
        """The newest Stats that have come, or None."""
        return self._inbox.stats

    @property
    def lost_states(self):
        """Ticks whose forces never came, as their numbers tell."""
        return self._inbox.lost_ticks

    def refresh(self):
        """Asks anew what is simulated, who holds what, and whether it is paused; the HelloReply."""
        self._greet(self._deadline())
        return self.hello

    def describe(self):
        """Shapes at rest and how they are connected: DescribeReply."""
        return self._ask("describe", DescribeReply)

    # ---- Needles ----

    def acquire(self, *names):
        """Makes this client the holder of needles and guides, all of them or none; the names of all it holds."""
        return self._hold("acquire", names)

    def release(self, *names):
        return self._hold("release", names)

    def pose(self, needle, position, orientation=None, spin=None):
        """Commands where a base (or a guide's hole) shall go: position (3, m), orientation (w, x, y, z; None: as it was
        commanded before, else as after loading), spin (rad; None: as before). Acquires it if this client does not hold
        it. Does not wait otherwise; a rejection is raised by the next step() or wait(). The number of the command."""
        name = getattr(needle, "name", needle)
        self._hold_before_commanding(name)
        seq, before = self._commanded.get(name, (0, None))
        if orientation is None:
            orientation = self._orientation_after_loading(name) if before is None else before
        self._commanded[name] = (seq + 1, orientation)
        self._stream("pose", needle=name, seq=seq + 1, position=np.asarray(position, dtype=float).tolist(),
                     orientation=np.asarray(orientation, dtype=float).tolist(),
                     spin=None if spin is None else float(spin))
        return seq + 1

    def spin(self, needle, angle):
        """Commands the angle (rad) that a needle shall have turned about its axis; its pose stays. Else as pose()."""
        name = getattr(needle, "name", needle)
        self._hold_before_commanding(name)
        seq, orientation = self._commanded.get(name, (0, None))
        self._commanded[name] = (seq + 1, orientation)
        self._stream("spin", needle=name, seq=seq + 1, spin=float(angle))
        return seq + 1

    # ---- Time ----

    def step(self, ticks=1):
        """Lockstep: runs ticks; the States after the last of them."""
        return self._step(ticks, 1)[-1]

    def trace(self, ticks):
        """Lockstep: runs ticks; the States after each of them, as a list."""
        return self._step(ticks, ticks)

    def wait(self, timeout=None):
        """Real time: the States of the newest tick, a later one than the last call gave. Waits for it if need be, at
        most `timeout` (s; None: that of the client), then raises Vanished."""
        deadline = self._deadline(timeout)
        self._wait_for_peer(deadline)
        self._confirm_subscriptions(deadline)
        self._take_waiting()
        while not self._inbox.has_tick():
            self._wait_for_peer(deadline)
            if not self._take_until(deadline):
                raise Vanished(f"no states from '{self._states.endpoint}' in time: "
                               + ("the server is paused or runs in lockstep" if self._states.connected() else
                                  self._states.why_no_peer()))
        self._take_waiting()
        self._raise_rejection()
        return self._inbox.give(None)[-1]

    def subscribe(self, *topics):
        """To `needle` and `tissue`, whose newest then stand in `shapes` and `tissue`, and in States."""
        self._topics.update(topics)
        for topic in topics:
            self._states.socket.subscribe(topic)
        self._inbox.stats_awaited = 2  # the first may have been on its way

    def unsubscribe(self, *topics):
        self._topics.difference_update(topics)
        for topic in topics:
            self._states.socket.unsubscribe(topic)

    # ---- Other requests; each raises Refused if the server says no ----

    def hash(self):
        """HashReply: the state as one number."""
        return self._ask("hash", HashReply)

    def snapshot(self):
        """SnapshotReply: the whole state, for restore()."""
        reply = self._ask("snapshot", SnapshotReply)
        self._commanded_by[hash(reply.snapshot)] = dict(self._commanded)
        while len(self._commanded_by) > MOST_SNAPSHOTS:
            del self._commanded_by[next(iter(self._commanded_by))]
        return reply

    def restore(self, snapshot):
        """Goes on from a SnapshotReply or its bytes, in a new epoch. Done. Commands are counted on from where this client
        took it, else from 1: the same commands give the same hash again."""
        snapshot = getattr(snapshot, "snapshot", snapshot)
        done = self._begin_epoch(self._ask("restore", Done, snapshot=snapshot))
        self._commanded = dict(self._commanded_by.get(hash(snapshot), {}))
        return done

    def reset(self):
        """Back to the state after loading, in a new epoch. Done. Commands are counted from 1."""
        done = self._begin_epoch(self._ask("reset", Done))
        self._commanded.clear()
        return done

    def pause(self):
        return self._ask("pause", Done)

    def resume(self):
        return self._ask("resume", Done)

    def load(self, scene):
        """Another scene: a path on the server's machine, a name in its folder of scenes, or a Scene, which is sent as text.
        Nothing is held then."""
        text = getattr(scene, "text", None)
        done = self._ask("load", Done, **({"text": text()} if text else {"scene": str(scene)}))
        self._held.clear()
        self._commanded.clear()
        self._begin_epoch(done)
        self.refresh()
        return done

    def record(self, name):
        """Begins a recording in a new file of the server's folder for recordings."""
        return self._ask("record", Done, file=name)

    def end_recording(self):
        return self._ask("record", Done)

    def shutdown(self):
        """The server ends."""
        return self._ask("shutdown", Done)

    # ---- Inside ----

    def _begin_epoch(self, done):
        self._inbox.forget(done.epoch)
        return done

    def _deadline(self, timeout=None):
        return time.monotonic() + (self.timeout if timeout is None else timeout)

    def _orientation_after_loading(self, name):
        for needle in self.needles:
            if needle.name == name:
                return needle.base_orientation
        for guide in self.guides:
            if guide.name == name:
                return guide.orientation
        raise Refused("unknown_needle", f"the scene has no needle or guide '{name}'", "pose")

    def _hold(self, kind, names):
        names = [getattr(each, "name", each) for each in names]
        self._held = set(self._ask(kind, Holding, needles=names).needles)
        return sorted(self._held)

    def _hold_before_commanding(self, name):
        if self._requests.connected() and self._requests.lost == self._lost and name in self._held:
            return
        self._wait_for_peer(self._deadline())
        if name not in self._held:
            self.acquire(name)

    def _stream(self, kind, **fields):
        try:
            self._requests.socket.send(messages.encode(kind, time=time.monotonic(), **fields), zmq.NOBLOCK)
        except zmq.Again:
            raise Vanished(f"'{self._requests.endpoint}' takes no commands: the connection ended, or the server does "
                           "not read") from None

    def _ask(self, kind, answer, timeout=None, **fields):
        deadline = self._deadline(timeout)
        self._wait_for_peer(deadline)
        return self._request(kind, answer, deadline, **fields)

    def _wait_for_peer(self, deadline):
        """After a connection that ended, also says hello to what may be another start of the server."""
        if self.hello is not None and self._requests.connected() and self._requests.lost == self._lost:
            return
        if self.hello is None:
            self._wait_until_connected(deadline)
        else:
            self._greet(deadline)

    def _wait_until_connected(self, deadline):
        while not self._requests.connected():
            if self._requests.refused():
                raise KeysRefused(f"'{self._requests.endpoint}': {self._requests.why_no_peer()}")
            if not self._poll(deadline, self._requests.monitor):
                raise Vanished(f"no answer from '{self._requests.endpoint}' in time: {self._requests.why_no_peer()}")

    def _greet(self, deadline):
        self._wait_until_connected(deadline)
        if self.hello is not None and self._requests.lost != self._lost:
            self.reconnections += 1
            self._held.clear()
            self._inbox.forget()
            self._inbox.stats_awaited = 2  # the first of a server that may not know all subscriptions again
        self._lost = self._requests.lost
        self.hello = self._request("hello", HelloReply, deadline)
        self._inbox.expect(len(self.hello.needles))

    @staticmethod
    def _poll(deadline, *sockets):
        left = max(0, deadline - time.monotonic())
        poller = zmq.Poller()
        for socket in sockets:
            poller.register(socket, zmq.POLLIN)
        return bool(poller.poll(1000 * left))

    def _send_request(self, kind, fields):
        self._seq += 1
        try:
            self._requests.socket.send(messages.encode(kind, seq=self._seq, **fields), zmq.NOBLOCK)
        except zmq.Again:
            raise Vanished(f"'{self._requests.endpoint}' takes no request: the connection ended, or the server does "
                           "not read") from None
        return self._seq

    def _request(self, kind, answer, deadline, **fields):
        seq = self._send_request(kind, fields)
        while True:
            message = self._take_answer(kind, seq)
            if message is not None:
                return answer(message)
            self._wait_for_answer(kind, deadline)

    def _wait_for_answer(self, kind, deadline):
        """Takes in states meanwhile: in lockstep the world waits for those who do not read them."""
        self._check_connection(kind)
        if not self._take_until(deadline):
            raise Vanished(f"no answer to '{kind}' from '{self._requests.endpoint}' in time")

    def _check_connection(self, kind):
        if self._requests.lost != self._lost:
            raise Vanished(f"no answer to '{kind}' from '{self._requests.endpoint}': the connection ended")

    def _take_answer(self, kind, seq):
        """The answer with that number if it has come; raises Refused if it is an error."""
        while True:
            try:
                frames = self._requests.socket.recv_multipart(zmq.NOBLOCK)
            except zmq.Again:
                return None
            message = messages.decode(frames[-1])
            if message["type"] != "error":
                if message.get("seq") == seq:
                    return message
                continue  # the late answer to an earlier request
            self._take_error(message, kind, seq)

    def _take_error(self, message, kind=None, seq=None):
        refused = Refused(message.get("code", ""), message.get("message", ""), message.get("rejected"))
        if refused.rejected in STREAMS:
            self._rejections.append(refused)
        elif kind is not None and message.get("seq", seq) == seq:
            if refused.code == "wrong_version":
                raise ProtocolMismatch(str(refused))
            raise refused

    def _raise_rejection(self):
        """Of a pose or spin: the oldest that nobody was told of; the others are dropped, as they follow from it."""
        if self._rejections:
            refused = self._rejections[0]
            self._rejections.clear()
            if refused.code == "not_holder":
                self._held.clear()
            raise refused

    def _step(self, ticks, kept):
        if ticks < 1:
            raise ValueError(f"ticks: expected 1 or more, found {ticks}")
        deadline = self._deadline()
        self._wait_for_peer(deadline)
        self._confirm_subscriptions(deadline)
        self._take_waiting()
        self._inbox.keep(kept)
        before, ran = self._inbox.arrived, 0
        while ran < ticks:
            done = self._run_ticks(min(ticks - ran, LONGEST_STEP))
            ran += LONGEST_STEP
        self._wait_for_states(done, ticks, before)
        self._take_states()  # events follow the forces
        states = self._inbox.give(done)
        self._raise_rejection()
        return states

    def _run_ticks(self, ticks):
        """However long that takes, as long as the server is there."""
        seq = self._send_request("step", {"ticks": ticks})
        while True:
            message = self._take_answer("step", seq)
            if message is not None:
                return Done(message)
            self._check_connection("step")
            self._take_until(self._deadline())

    def _wait_for_states(self, done, ticks, before):
        """They come on another connection than the answer."""
        deadline = self._deadline()
        while not self._all_states_of(done, ticks, before):
            if not self._take_until(deadline):
                raise Vanished(f"the states of tick {done.tick} did not come from '{self._states.endpoint}'")

    def _all_states_of(self, done, ticks, before):
        """Of ticks that have ended; `before` is how many had arrived by then."""
        if self.needles and "force" in self._topics:
            if self._inbox.arrived < before + ticks or self._inbox.last != (done.epoch, done.tick):
                return False
        if "needle" in self._topics and not all(
                self._newest_is_here("needle", self.shapes.get(needle.name), done, ticks) for needle in self.needles):
            return False
        return "tissue" not in self._topics or self._newest_is_here("tissue", self.tissue, done, ticks)

    def _newest_is_here(self, topic, shape, done, ticks):
        """Shapes come every so many ticks; whether that of the last such tick is here, if it was one of these."""
        rate = next(each.rate for each in self.hello.topics if each.name == topic)
        due = done.tick - done.tick % max(1, round(self.hello.rate / rate))
        return due <= done.tick - ticks or (shape is not None and (shape.epoch, shape.tick) >= (done.epoch, due))

    def _confirm_subscriptions(self, deadline):
        """Before that, states would be lost. Takes up to a second, once."""
        while self._inbox.stats_awaited > 0:
            if not self._take_until(deadline):
                raise Vanished(f"no states from '{self._states.endpoint}' in time: {self._states.why_no_peer()}")

    def _take_until(self, deadline):
        """Waits until something comes, and takes in the states among it; False at the deadline."""
        left = deadline - time.monotonic()
        ready = dict(self._poller.poll(max(0, 1000 * left)))
        if self._requests.monitor in ready:
            self._requests.connected()
        if self._states.monitor in ready:
            self._states.connected()
        if self._states.socket in ready:
            self._take_states()
        return bool(ready) or left > 0

    def _take_waiting(self):
        """All that has come, without waiting."""
        self._take_states()
        self._take_answer(None, None)

    def _take_states(self):
        while True:
            try:
                frames = self._states.socket.recv_multipart(zmq.NOBLOCK)
            except zmq.Again:
                return
            self._inbox.take(messages.decode(frames[-1]))
