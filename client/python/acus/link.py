# SPDX-License-Identifier: MIT
"""A ZeroMQ socket that knows whether somebody is at its other end, and why not. It connects again by itself."""

import zmq
from zmq.utils.monitor import parse_monitor_message

from .errors import ClientError

RECONNECT = 50  # ms between attempts to reach a server that is not there
EVENTS = (zmq.EVENT_HANDSHAKE_SUCCEEDED | zmq.EVENT_HANDSHAKE_FAILED_NO_DETAIL | zmq.EVENT_HANDSHAKE_FAILED_PROTOCOL
          | zmq.EVENT_HANDSHAKE_FAILED_AUTH | zmq.EVENT_DISCONNECTED)

# What an attempt to connect came to. As each may end in another way, the one that says most counts.
NOBODY, BROKEN_OFF, OTHER_MECHANISM, REFUSED = range(4)


class Link:
    """One socket of the type, connected to the endpoint; `options` are those of the socket, by number."""

    def __init__(self, context, kind, endpoint, keys=None, options=()):
        self.endpoint = endpoint
        self.lost = 0  # how often a connection ended
        self._connected = False
        self._failure = NOBODY
        self._keyed = keys is not None
        self.socket = context.socket(kind)
        self.socket.setsockopt(zmq.LINGER, 0)
        self.socket.setsockopt(zmq.RECONNECT_IVL, RECONNECT)
        for option, value in options:
            self.socket.setsockopt(option, value)
        if keys:
            keys.give_to(self.socket)
        self.monitor = self.socket.get_monitor_socket(EVENTS)
        try:
            self.socket.connect(endpoint)
        except zmq.ZMQError as error:
            self.close()
            raise ClientError(f"endpoint '{endpoint}': {error}; expected one that ZeroMQ can connect to, such as "
                              "tcp://127.0.0.1:5750") from None

    def close(self):
        self.socket.disable_monitor()
        self.socket.close(linger=0)

    def connected(self):
        """Whether somebody is there, as far as is known now. Does not wait."""
        while self.monitor.poll(0):
            event = parse_monitor_message(self.monitor.recv_multipart())
            self._take_event(event["event"], event["value"])
        return self._connected

    def refused(self):
        """Whether somebody is there who does not admit this client, as far as `connected` knew. Takes nothing in, so that
        who asks both and then waits for the monitor has missed no event."""
        return not self._connected and self._failure in (OTHER_MECHANISM, REFUSED)

    def broken_off(self):
        """Whether somebody is there who ended the handshake. A server with keys may do so before it has said that it has
        them, however often a client without tries."""
        return not self._connected and self._failure != NOBODY

    def why_no_peer(self):
        if self._failure == REFUSED:
            return ("the server refuses this client's key; its public key has to be among those of the server's "
                    "--curve-clients")
        if self._failure == OTHER_MECHANISM:
            return ("the server does not use keys; connect without them, or start it with --curve-server-key"
                    if self._keyed else
                    "the server admits only clients with keys; give the server's public key and this client's own")
        if self._failure == BROKEN_OFF:
            return "the connection ended in the handshake; perhaps " + (
                "the server's public key given here is not that of this server" if self._keyed else
                "the server admits only clients with keys, or somebody else than an acus-server listens there")
        return "nobody is there"

    def _take_event(self, number, value):
        self.lost += self._connected
        self._connected = number == zmq.EVENT_HANDSHAKE_SUCCEEDED
        self._failure = NOBODY if self._connected else max(self._failure, failure_of(number, value))


def failure_of(number, value):
    if number == zmq.EVENT_HANDSHAKE_FAILED_AUTH:
        return REFUSED
    if number == zmq.EVENT_HANDSHAKE_FAILED_PROTOCOL:
        return OTHER_MECHANISM if value == zmq.PROTOCOL_ERROR_ZMTP_MECHANISM_MISMATCH else BROKEN_OFF
    return BROKEN_OFF if number == zmq.EVENT_HANDSHAKE_FAILED_NO_DETAIL else NOBODY
