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
from acus.apps.arguments import Arguments, add_server, check_server, read_keys
from acus.apps.top_watch import SILENT, Watch
from acus.errors import ClientError, KeyFileError

REFRESH = 1.0  # s between two pages when nothing changes: the time since the last word counts on
KEY_WAIT = 0.1  # s until a key is looked at
REFUSED, NO_SERVER = 2, 3


def parse_arguments():
    parser = Arguments(prog="acus-top", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_server(parser)
    parser.add_argument("--once", action="store_true", help="print one page and end")
    parser.add_argument("--timeout", type=float, default=5, help="with --once, to wait for a page (s; default: 5)")
    arguments = parser.parse_args()
    if not 0 < arguments.timeout < 1e6:
        parser.error("--timeout: expected a number above 0")
    check_server(parser, arguments)
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

