# SPDX-License-Identifier: MIT
"""What acus-top knows of a server: its newest answer to `hello`, its newest `stats`, and a `force` of each needle.

It costs the server little: forces come at every tick, so they are subscribed to for one tick a second, and a needle's
force is at most about a second old.
"""

import time

import msgpack
import zmq

from acus.errors import ProtocolMismatch
from acus.link import Link
from acus.messages import VERSION, Force, HelloReply, Stats

ASK_AGAIN = 2.0  # s after which a `hello` without an answer is asked once more
SAMPLE = 0.5  # s at most to wait for a force of every needle; none comes while the server is paused
SILENT = 3.0  # s without `stats`, which come every second


class Watch:
    """Call poll() again and again, then read `hello`, `stats` and `forces`."""

    def __init__(self, commands, states, keys=None):
        self.hello = None  # as the contract says, or None before the first
        self.stats = None
        self.forces = {}  # by the name of the needle
        self.heard = None  # monotonic time of the newest stats
        self._context = zmq.Context()
        # Nothing waits for a server that is not there.
        self._link = Link(self._context, zmq.DEALER, commands, keys, [(zmq.IMMEDIATE, 1)])
        self._commands = self._link.socket
        self._states = Link(self._context, zmq.SUB, states, keys).socket
        self._states.subscribe("stats")
        self._poller = zmq.Poller()
        for socket in (self._commands, self._states):
            self._poller.register(socket, zmq.POLLIN)
        self._seq = 0
        self._asked = None  # monotonic time of the hello that has no answer yet
        self._sampling = None  # monotonic time since which forces are subscribed to
        self._missing = set()  # needles without a force in this sample
        self._sampled = False  # whether there was a sample
        self._whole = False  # whether the next stats cover a whole period: ticks count from the subscription on

    def close(self):
        self._context.destroy(linger=0)

    def refused(self):
        """Why the server that is there does not admit this client, None if none is or it does."""
        return self._link.why_no_peer() if not self._link.connected() and self._link.refused() else None

    def broken_off(self):
        """Why the handshake with somebody who is there ended each time; None if nobody is, or one did not."""
        return self._link.why_no_peer() if not self._link.connected() and self._link.broken_off() else None

    def complete(self):
        """Whether there is a whole page to show: a force of every needle, unless none comes."""
        return self.stats is not None and self._sampled and self._sampling is None

    def silence(self):
        """Seconds since the server was heard of; None if it never was."""
        return None if self.heard is None else time.monotonic() - self.heard

    def poll(self, timeout):
        """Takes in what comes within so many seconds; returns whether anything changed."""
        self._ask_if_due()
        ready = dict(self._poller.poll(1000 * timeout))
        changed = self._commands in ready and self._read(self._commands, self._take_answer)
        changed = (self._states in ready and self._read(self._states, self._take_state)) or changed
        return self._end_sample_if_due() or changed

    def _ask_if_due(self):
        now = time.monotonic()
        if self._asked is not None and now - self._asked < ASK_AGAIN:
            return
        if self._asked is None and self.hello is not None:
            return  # the next stats ask
        self._ask(now)

    def _ask(self, now):
        self._seq += 1
        hello = msgpack.packb({"v": VERSION, "type": "hello", "seq": self._seq})
        try:
            self._commands.send(hello, zmq.NOBLOCK)
            self._asked = now
        except zmq.Again:
            pass  # not connected

    @staticmethod
    def _read(socket, take):
        """Gives all waiting messages to take(); whether one of them mattered."""
        mattered = False
        for _ in range(1000):  # then it is the screen's turn
            try:
                frames = socket.recv_multipart(zmq.NOBLOCK)
            except zmq.Again:
                break
            try:
                message = msgpack.unpackb(frames[-1])
                mattered = take(message) or mattered
            except (ValueError, KeyError, TypeError, AttributeError, msgpack.UnpackException, ProtocolMismatch):
                continue  # not what the contract says
        return mattered

    def _take_answer(self, message):
        if message["type"] != "hello_reply" or message["seq"] != self._seq:
            return False
        HelloReply.checked(message)
        set(message["held"])  # names
        self._asked = None
        if self.hello is not None and self.hello["instance"] != message["instance"]:
            self.stats = None  # of another start of the server
        self.hello = message
        names = {needle["name"] for needle in message["needles"]}
        self.forces = {name: force for name, force in self.forces.items()
                       if name in names and force["epoch"] == message["epoch"]}
        return True

    def _take_state(self, message):
        if message["type"] == "force":
            return self._take_force(message)
        if message["type"] != "stats":
            return False
        Stats.checked(message)
        silence = self.silence()
        if self._whole and silence <= SILENT:
            self.stats = message
            self._begin_sample()
        self._whole = True
        self.heard = time.monotonic()
        if self._asked is None:
            self._ask(self.heard)
        return True

    def _take_force(self, message):
        Force.checked(message)
        self.forces[message["needle"]] = message
        self._missing.discard(message["needle"])
        return True

    def _begin_sample(self):
        if self._sampling is not None or self.hello is None:
            return
        self._missing = {needle["name"] for needle in self.hello["needles"]}
        self._sampling = time.monotonic()
        self._states.subscribe("force")

    def _end_sample_if_due(self):
        if self._sampling is None or (self._missing and time.monotonic() - self._sampling < SAMPLE):
            return False
        self._sampling = None
        self._sampled = True
        self._states.unsubscribe("force")
        return True
