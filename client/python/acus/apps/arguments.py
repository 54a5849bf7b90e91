# SPDX-License-Identifier: MIT
"""What the command lines of the programs have in common."""

import argparse
import sys

from acus.client import COMMANDS, STATES
from acus.keys import Keys

BAD_ARGUMENTS = 1


class Arguments(argparse.ArgumentParser):
    """Ends with status 1 for a bad command line."""

    def error(self, message):
        self.print_usage(sys.stderr)
        self.exit(BAD_ARGUMENTS, f"{self.prog}: {message}\n")


def whole_number(text, most=100_000):
    """Of an argument: above 0."""
    if not text.isdecimal() or not 0 < int(text) <= most:
        raise argparse.ArgumentTypeError(f"expected a whole number above 0, found '{text}'")
    return int(text)


def add_server(parser):
    """Where the server is, and the keys for it."""
    parser.add_argument("--commands", default=COMMANDS, help="the server's endpoint (default: %(default)s)")
    parser.add_argument("--states", default=STATES, help="the server's endpoint (default: %(default)s)")
    parser.add_argument("--curve-server-key", metavar="FILE", help="the server's public key, if it asks for keys")
    parser.add_argument("--curve-client-key", metavar="FILE",
                        help="this client's pair of keys, as acus-keygen writes it into NAME.key_secret")


def check_server(parser, arguments):
    if (arguments.curve_server_key is None) != (arguments.curve_client_key is None):
        parser.error("--curve-server-key and --curve-client-key: give both or none")


def read_keys(arguments):
    """Keys, or None without any. Raises KeyFileError."""
    if arguments.curve_server_key is None:
        return None
    return Keys(arguments.curve_server_key, arguments.curve_client_key)
