#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests of the check of include directions, on trees of a few files."""

import os
import tempfile
import unittest

import include_directions


class Directions(unittest.TestCase):
    def violations(self, files, exceptions=()):
        """Of a tree with these files; what they include exists as an empty file where it is not given."""
        with tempfile.TemporaryDirectory() as root:
            named = {line.split()[1].strip('"<>') for text in files.values() for line in text.splitlines()
                     if line.startswith("#include")}
            for path in sorted(named | set(files)):
                if "/" not in path or path.startswith(".."):
                    continue
                full = os.path.join(root, path)
                os.makedirs(os.path.dirname(full), exist_ok=True)
                with open(full, "w", encoding="utf-8") as file:
                    file.write(files.get(path, ""))
            return include_directions.violations(root, dict.fromkeys(exceptions, "for the test"))

    def allows(self, path, included):
        return not self.violations({path: f'#include "{included}"\n'})

    def test_each_direction_is_allowed_or_not(self):
        for path, included, allowed in [
            ("server/models/a.h", "server/math/b.h", True),
            ("server/math/a.h", "server/models/b.h", False),
            ("server/constraints/laws/a.h", "server/models/b.h", True),
            ("server/constraints/rows.h", "server/constraints/compliance/b.h", True),
            ("server/models/a.h", "server/constraints/rows.h", False),
            ("server/constraints/compliance/a.h", "server/scene/b.h", False),
            ("server/scene/a.h", "server/constraints/compliance/b.h", True),
            ("server/scene/a.h", "server/constraints/solver/b.h", False),
            ("server/simulation/a.h", "server/scene/b.h", True),
            ("server/simulation/stages/a.h", "server/simulation/b.h", True),
            ("server/scene/a.h", "server/simulation/b.h", False),
            ("server/simulation/a.h", "server/runtime/b.h", False),
            ("server/runtime/a.h", "server/simulation/b.h", True),
            ("server/runtime/a.h", "server/transport/b.h", False),
            ("server/transport/a.h", "server/runtime/b.h", True),
            ("server/main.cpp", "server/transport/b.h", True),
            ("server/main.cpp", "server/tools/b.h", False),
            ("server/transport/a.h", "client/b.h", False),
            ("server/tools/bench/a.h", "client/b.h", True),
            ("server/math/a.h", "protocol/b.h", True),
            ("protocol/a.h", "server/math/b.h", False),
            ("client/a.h", "server/math/b.h", False),
            ("client/a.h", "protocol/b.h", True),
            ("tests/math/a.cpp", "server/main.cpp", False),
            ("tests/math/a.cpp", "client/b.h", True),
            ("server/math/a.h", "tests/support/b.h", False),
        ]:
            with self.subTest(path=path, included=included):
                self.assertEqual(self.allows(path, included), allowed)

    def test_a_violation_names_file_line_and_reason(self):
        found = self.violations({"protocol/a.h": '#pragma once\n\n#include "server/math/b.h"\n'})
        self.assertEqual(found, ["protocol/a.h:3: includes server/math/b.h: protocol may include nothing of the "
                                 "project, but not server/math"])

    def test_angle_brackets_and_relative_paths_are_seen(self):
        self.assertEqual(len(self.violations({"protocol/a.h": "#include <client/b.h>\n"})), 1)
        self.assertEqual(len(self.violations({"protocol/a.h": '#include "../client/b.h"\n', "client/b.h": ""})), 1)
        files = {"protocol/a.h": '#include <vector>\n#include "b.h"\n', "protocol/b.h": ""}
        self.assertEqual(self.violations(files), [])

    def test_a_folder_without_a_rule_is_told(self):
        found = self.violations({"server/attic/a.h": '#include "server/math/b.h"\n'})
        self.assertEqual(len(found), 1)
        self.assertIn("server/attic/a.h lies in no folder of ROOMS", found[0])

    def test_an_exception_holds_for_one_include_as_long_as_it_is_needed(self):
        exception = ("server/math/a.h", "server/models/b.h")
        text = '#include "server/models/b.h"\n'
        self.assertEqual(self.violations({exception[0]: text}, [exception]), [])
        self.assertEqual(len(self.violations({exception[0]: text, "server/math/c.h": text}, [exception])), 1)
        found = self.violations({exception[0]: ""}, [exception])
        self.assertEqual(len(found), 1)
        self.assertIn("no longer includes server/models/b.h", found[0])


if __name__ == "__main__":
    unittest.main(verbosity=2)
