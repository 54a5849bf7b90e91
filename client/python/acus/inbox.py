# SPDX-License-Identifier: MIT
"""What has come from a server's states socket: forces by whole ticks, the newest shapes, events that wait to be
told."""

from collections import deque

from .errors import ProtocolMismatch
from .messages import Event, Force, Haptics, NeedleShape, States, Stats, TissueShape


class Inbox:
    def __init__(self):
        self.lost_ticks = 0  # whose forces never came
        self.stats = None  # the newest Stats
        self.stats_awaited = 0  # that have to come until every subscription is known to be in effect
        self.arrived = 0  # whole ticks, those that nobody wanted to keep included
        self._needles = 0
        self.forget()

    def forget(self, least_epoch=0):
        """All but counts. States of earlier epochs, which are still on their way, are no news."""
        self._least_epoch = least_epoch
        self._partial = {}  # forces of the tick that is coming in, as maps by needle
        self._ticks = deque(maxlen=1)  # the same of the newest whole ticks
        self._events = []
        self.last = None  # (epoch, tick) of the newest whole tick
        self.shapes = {}  # the newest NeedleShape, by needle
        self.tissue = None  # the newest TissueShape
        self.haptics = {}  # the newest Haptics, by needle

    def expect(self, needles):
        """How many needles have a force in every tick. Until this is known, nothing is taken in."""
        self._needles = needles
        self._partial = {}

    def keep(self, ticks):
        """So many whole ticks from now on, the newest."""
        self._ticks = deque(maxlen=ticks)

    def has_tick(self):
        return bool(self._ticks)

    def take(self, message):
        """A message as a map; of a topic that is not known it is left alone."""
        take = self._TAKE.get(message["type"])
        if take is None or message.get("epoch", 0) < self._least_epoch:
            return
        try:
            take(self, message)
        except KeyError as error:
            raise ProtocolMismatch(f"{message['type']}: field {error} is missing") from error

    def give(self, otherwise):
        """The States of each tick that is kept, with the events of each; those of a message that tells epoch, tick and
        time where no forces come."""
        ticks, events = list(self._ticks), self._events
        self._ticks, self._events = deque(maxlen=1), []
        if not ticks:
            return [States({}, events, self.shapes, self.tissue, otherwise, self.haptics)] if otherwise else []
        states = [States({name: Force(message) for name, message in forces.items()}, (), self.shapes, self.tissue,
                         haptics=self.haptics) for forces in ticks]
        for event in events:  # those of ticks that were not kept go with the first one that was
            after = [each for each in states if (each.epoch, each.tick) >= (event.epoch, event.tick)]
            (after[0] if after else states[-1]).events.append(event)
        return states

    def _take_force(self, message):
        name, tick = message["needle"], (message["epoch"], message["tick"])
        if self._partial and (name in self._partial or tick != self._partial_tick):
            self._partial = {}
        self._partial_tick = tick
        self._partial[name] = message
        if len(self._partial) == self._needles:
            self._end_tick(tick)

    def _end_tick(self, tick):
        if self.last and self.last[0] == tick[0]:
            self.lost_ticks += max(0, tick[1] - self.last[1] - 1)
        self.last = tick
        self.arrived += 1
        self._ticks.append(self._partial)
        self._partial = {}

    def _take_shape(self, message):
        self.shapes[message["needle"]] = NeedleShape(message)

    def _take_tissue(self, message):
        self.tissue = TissueShape(message)

    def _take_haptics(self, message):
        self.haptics[message["needle"]] = Haptics(message)

    def _take_event(self, message):
        self._events.append(Event(message))

    def _take_stats(self, message):
        self.stats = Stats(message)
        self.stats_awaited = max(0, self.stats_awaited - 1)

    _TAKE = {"force": _take_force, "needle": _take_shape, "tissue": _take_tissue, "event": _take_event,
             "stats": _take_stats, "haptics": _take_haptics}
