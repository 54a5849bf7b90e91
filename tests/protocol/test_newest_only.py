#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What protocol/README.md says of "newest only" in Python, run as it stands there."""

import os
import re
import unittest

import zmq

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


class NewestOnly(unittest.TestCase):
    def test_the_last_of_those_that_wait(self):
        with open(os.path.join(ROOT, "protocol", "README.md"), encoding="utf-8") as file:
            section = file.read().split("### Newest only")[1]
        recipe = {"zmq": zmq}
        exec(re.search(r"```python\n(.*?)```", section, re.DOTALL)[1], recipe)  # pylint: disable=exec-used
        with zmq.Context() as context, context.socket(zmq.PAIR) as server, context.socket(zmq.PAIR) as states:  # which lose none
            server.bind("inproc://states")
            states.connect("inproc://states")
            self.assertIsNone(recipe["newest"](states))
            for i in range(100):
                server.send_multipart([b"force", str(i).encode()])
            self.assertEqual(recipe["newest"](states), b"99")
            self.assertIsNone(recipe["newest"](states))


if __name__ == "__main__":
    unittest.main()
