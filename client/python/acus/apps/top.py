# SPDX-License-Identifier: MIT
"""Shows how a running acus-server does, once a second: rate, lateness, work, flags, needles, forces and links.

began, ended: how long after they were due ticks began and ended, in the last second. computed: the time for a tick.
held: whether a client holds the needle. axial N: what the tissue resists the needle going in with. fresh: of 100 ticks,
how many got a new command. age: since the last command. lost, reordered: commands that did not come, or too late.
The server does not publish the times of a tick's stages; acus-bench measures them.

q ends the program. Exit status: 0 ended, or with --once a page was printed; 1 bad arguments or keys, or no terminal
that can show pages; 2 with --once, a server is there and does not admit this client; 3 with --once, no server answered
in time.
"""

import argparse
import curses
import os
import signal
import sys
import time

from acus.apps import top_page
from acus.apps.top_watch import SILENT, Watch
from acus.errors import ClientError, KeyFileError
from acus.keys import Keys

REFRESH = 1.0  # s between two pages when nothing changes: the time since the last word counts on
KEY_WAIT = 0.1  # s until a key is looked at
BAD_ARGUMENTS, REFUSED, NO_SERVER = 1, 2, 3


class Arguments(argparse.ArgumentParser):
    def error(self, message):
        self.print_usage(sys.stderr)
        self.exit(BAD_ARGUMENTS, f"{self.prog}: {message}\n")


def parse_arguments():
    parser = Arguments(prog="acus-top", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--commands", default="tcp://127.0.0.1:5750", help="the server's endpoint (default: %(default)s)")
    parser.add_argument("--states", default="tcp://127.0.0.1:5751", help="the server's endpoint (default: %(default)s)")
    parser.add_argument("--curve-server-key", metavar="FILE", help="the server's public key, if it asks for keys")
    parser.add_argument("--curve-client-key", metavar="FILE",
                        help="this client's pair of keys, as acus-keygen writes it into NAME.key_secret")
    parser.add_argument("--once", action="store_true", help="print one page and end")
    parser.add_argument("--timeout", type=float, default=5, help="with --once, to wait for a page (s; default: 5)")
    arguments = parser.parse_args()
    if not 0 < arguments.timeout < 1e6:
        parser.error("--timeout: expected a number above 0")
    if (arguments.curve_server_key is None) != (arguments.curve_client_key is None):
        parser.error("--curve-server-key and --curve-client-key: give both or none")
    return arguments


def print_page(watch):
    try:
        print("\n".join(top_page.page(watch, SILENT)), flush=True)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # nobody reads on


def print_once(watch, timeout):
    deadline = time.monotonic() + timeout
    while time.monotonic() < deadline:
        watch.poll(KEY_WAIT)
        if watch.complete():
            print_page(watch)
            return 0
        if watch.refused():
            print(f"acus-top: {watch.refused()}", file=sys.stderr)
            return REFUSED
    why = watch.broken_off()
    print(f"acus-top: {why or 'no server answered in time'}", file=sys.stderr)
    return REFUSED if why else NO_SERVER


def draw(screen, watch):
    height, width = screen.getmaxyx()
    screen.erase()
    for row, line in enumerate(top_page.page(watch, SILENT)[:height]):
        try:
            screen.addnstr(row, 0, line, max(0, width - 1), curses.A_BOLD if row == 0 else curses.A_NORMAL)
        except curses.error:
            return  # the terminal has become smaller meanwhile
    screen.refresh()


def show(screen, watch):
    """Until q is pressed."""
    screen.nodelay(True)
    try:
        curses.curs_set(0)
    except curses.error:
        pass  # a terminal that cannot hide it
    drawn = 0.0
    while True:
        key = screen.getch()
        if key in (ord("q"), ord("Q")):
            return 0
        changed = watch.poll(KEY_WAIT)
        if (changed and watch.complete()) or key == curses.KEY_RESIZE or time.monotonic() - drawn > REFRESH:
            draw(screen, watch)
            drawn = time.monotonic()


def read_keys(arguments):
    if arguments.curve_server_key is None:
        return None
    return Keys(arguments.curve_server_key, arguments.curve_client_key)


def main():
    arguments = parse_arguments()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))  # with the terminal as it was
    try:
        watch = Watch(arguments.commands, arguments.states, read_keys(arguments))
    except KeyFileError as error:
        sys.exit(f"acus-top: {error}")
    except ClientError as error:
        sys.exit(f"acus-top: --commands or --states: {error}")
    try:
        return print_once(watch, arguments.timeout) if arguments.once else curses.wrapper(show, watch)
    except curses.error as error:
        sys.exit(f"acus-top: this terminal cannot show pages ({error}); use --once")
    except KeyboardInterrupt:
        return 0
    finally:
        watch.close()

