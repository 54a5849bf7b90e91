#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the log of a server as an operator's programs do."""

import json
import re
import signal
import subprocess
import unittest

from running_server import PATIENCE, SCENE, WithServer

EVIL = '"a\\n[2026-01-01 00:00:00.000] [acus-server] [error] b\\e[2J"'


class Log(WithServer):
    def lines_of_a_life(self, *options):
        """Of a server that loads a scene with a name that looks like a line of its own."""
        server = self.start(*options, stderr=subprocess.PIPE, text=True)
        client = self.client()
        self.assertEqual(client.ask("load", text=SCENE.format(name=EVIL))["type"], "done")
        client.ask("pose")  # without its fields
        server.send_signal(signal.SIGTERM)
        log = server.communicate(timeout=PATIENCE)[1]
        self.assertEqual(server.returncode, 0)
        return log.split("\n")[:-1]

    def test_lines_of_text_are_records(self):
        lines = self.lines_of_a_life()
        for line in lines:
            self.assertRegex(line, r"^\[\d{4}-\d\d-\d\d [0-9:.]{12}\] \[acus-server\] \[(info|warning)\] [^\x00-\x1f]+$")
        self.assertEqual(sum(line.endswith("[error] b\\x1b[2J' loaded") for line in lines), 1)

    def test_lines_of_json_are_objects(self):
        records = [json.loads(line) for line in self.lines_of_a_life("--log-format", "json")]
        for record in records:
            self.assertEqual(list(record), ["time", "level", "program", "message"])
            self.assertTrue(re.fullmatch(r"\d{4}-\d\d-\d\dT[0-9:]{8}\.\d{6}Z", record["time"]))
        messages = [record["message"] for record in records]
        self.assertIn("scene 'a\n[2026-01-01 00:00:00.000] [acus-server] [error] b\x1b[2J' loaded", messages)
        self.assertIn("commands on " + self.commands, messages)

    def test_levels_leave_out_what_is_below_them(self):
        self.assertEqual(self.lines_of_a_life("--log-level", "off"), [])
        warnings = self.lines_of_a_life("--log-level", "warn", "--log-format", "json")
        self.assertTrue(all(json.loads(line)["level"] == "warning" for line in warnings))
        debug = self.lines_of_a_life("--log-level", "debug")
        self.assertTrue(any("[debug]" in line and "'pose' of client" in line for line in debug), debug)

    def test_what_is_no_level_is_a_bad_command_line(self):
        for option in ("--log-level", "--log-format"):
            server = self.start(option, "loud", stderr=subprocess.PIPE, text=True)
            self.assertIn(option, server.communicate(timeout=PATIENCE)[1])
            self.assertEqual(server.returncode, 1)


if __name__ == "__main__":
    unittest.main()
