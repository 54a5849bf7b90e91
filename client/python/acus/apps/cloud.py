# SPDX-License-Identifier: MIT
"""Goes along with a running acus-server in worlds where tissue and needle are a little other than in its scene, on another
core, and publishes their tips: where the tip may be, if nobody knows stiffness, friction and bevel exactly.

  acus-cloud insertion_pullback
  acus-cloud liver.yaml --worlds 16 --uncertain stiffness=0.5:2 --uncertain "needles[0].young_modulus=6e10:8e10"
  acus-view insertion_pullback --play --cloud 8            starts it, and draws the cloud

The worlds branch from the server's state when this program comes, and at every reset, load and restore; from then on they
get the same commands, so the tips part. SCENE is what the server simulates, a file or the name of a project scene; without
it the server's own file name is looked for among the project's scenes. --uncertain takes factors (stiffness, friction,
bevel), which are drawn evenly in their logarithm, and fields of the scene. Worlds that are more than a quarter of a second
behind a server in real time become fewer.

The topic is `cloud`; protocol/README.md lists its fields.

Exit status: 0 ended; 1 bad arguments or keys; 2 the server does not admit this client; 3 --publish cannot be used.
"""

import argparse
import os
import re
import signal
import sys
import time

import zmq

from acus import engine
from acus.apps.arguments import Arguments, add_server, check_server, read_keys
from acus.apps.cloud_follow import Follower
from acus.distributions import LogUniform, Uniform
from acus.errors import AcusError, KeyFileError, KeysRefused
from acus.messages import encode
from acus.plan.uncertain import FACTORS
from acus.study.study import scene_of

PUBLISH = "tcp://127.0.0.1:5752"
OURS = re.compile(r"ipc://.+|tcp://(127\.0\.0\.1|localhost):\d+")
WAIT = 0.1  # s
REFRESH = 1.0  # s between two lines in a terminal
REFUSED, CANNOT_PUBLISH = 2, 3


def range_of(text):
    name, _, bounds = text.rpartition("=")
    try:
        low, high = map(float, bounds.split(":"))
        return name, (LogUniform if name in FACTORS else Uniform)(low, high)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"expected NAME=LOW:HIGH, found '{text}' ({error})") from None


def parse_arguments():
    parser = Arguments(prog="acus-cloud", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", metavar="SCENE", nargs="?", help="what the server simulates")
    parser.add_argument("--worlds", type=int, default=8, help="how many, the scene as it is among them (default: %(default)s)")
    parser.add_argument("--uncertain", type=range_of, action="append", metavar="NAME=LOW:HIGH",
                        help="may be given again (default: stiffness=0.8:1.25, friction=0.8:1.25, bevel=0.9:1.1)")
    parser.add_argument("--rate", type=float, default=50, help="ticks of each world per second (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="of what is drawn (default: %(default)s)")
    parser.add_argument("--publish", default=PUBLISH, metavar="ENDPOINT", help="of this machine: ipc://PATH or tcp://127.0.0.1:PORT (default: %(default)s)")
    add_server(parser)
    arguments = parser.parse_args()
    if not 2 <= arguments.worlds <= 1000:
        parser.error("--worlds: expected 2 to 1000")
    if not 1 <= arguments.rate <= 1e4:
        parser.error("--rate: expected 1 to 10000")
    if arguments.seed < 0:
        parser.error("--seed: expected a whole number, at least 0")
    if not OURS.fullmatch(arguments.publish):
        parser.error(f"--publish: expected ipc://PATH or tcp://127.0.0.1:PORT, found '{arguments.publish}'")
    check_server(parser, arguments)
    return arguments


def publisher(context, endpoint):
    socket = context.socket(zmq.PUB)
    socket.setsockopt(zmq.LINGER, 0)
    try:
        socket.bind(endpoint)
    except zmq.ZMQError as error:
        print(f"acus-cloud: --publish {endpoint}: {error}", file=sys.stderr)
        sys.exit(CANNOT_PUBLISH)
    return socket


class Teller:
    """Says on standard error what changes, and in a terminal once a second how things stand."""

    def __init__(self):
        self._terminal, self._said, self._drawn, self._open = sys.stderr.isatty(), None, 0.0, False

    def changed(self, words):
        if words != self._said:
            self._line(words)
            self._said = words

    def stands(self, words):
        if self._terminal and time.monotonic() - self._drawn > REFRESH:
            print(f"\r\x1b[K{words}", end="", file=sys.stderr, flush=True)
            self._drawn, self._open = time.monotonic(), True

    def _line(self, words):
        print(("\n" if self._open else "") + words, file=sys.stderr, flush=True)
        self._open = False


def standing(follower, message):
    needles = ", ".join(f"{each['name']}: {1e3 * each['spread']:.2f} mm" for each in message["needles"])
    return f"{message['time']:.2f} s, spread of the tips {needles}; {100 * follower.share:.0f} % of real time"


def run(follower, socket):
    teller = Teller()
    while True:
        message = follower.poll(WAIT)
        if follower.cloud is None:
            teller.changed(f"acus-cloud: waits: {follower.why or 'loads the worlds'}")
        else:
            teller.changed(f"acus-cloud: {len(follower.cloud)} worlds go along")
        if message:
            socket.send_multipart([b"cloud", encode("cloud", **message)])
            teller.stands(standing(follower, message))


def main():
    arguments = parse_arguments()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    os.nice(5)  # ticks of the server come first
    context = zmq.Context()
    follower = None
    try:
        keys = read_keys(arguments)
        engine.version()  # whether there is one
        if arguments.scene:
            scene_of(arguments.scene)  # a wrong name is told at once, not when there is a server
        socket = publisher(context, arguments.publish)
        uncertain = dict(arguments.uncertain) if arguments.uncertain else None
        follower = Follower(arguments.commands, arguments.states, keys, arguments.scene, rate=arguments.rate, worlds=arguments.worlds,
                            uncertain=uncertain, seed=arguments.seed)
        run(follower, socket)
    except KeyFileError as error:
        sys.exit(f"acus-cloud: {error}")
    except KeysRefused as error:
        print(f"acus-cloud: {error}", file=sys.stderr)
        return REFUSED
    except AcusError as error:
        sys.exit(f"acus-cloud: {error}")
    except KeyboardInterrupt:
        return 0
    finally:
        if follower:
            follower.close()
        context.destroy(linger=0)
