#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests of the checks of include directions and of circles, on trees of a few files."""

import os
import tempfile
import unittest

import include_circles
import include_directions


ROOMS = include_directions.rooms("math: \nmodels: math\nlaws: math models\nscene: math models laws\n"
                                 "state: math models laws scene\ntick: math models laws scene state\n")


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
            return include_directions.violations(root, ROOMS, dict.fromkeys(exceptions, "for the test"))

    def allows(self, path, included):
        return not self.violations({path: f'#include "{included}"\n'})

    def test_each_direction_is_allowed_or_not(self):
        for path, included, allowed in [
            ("server/engine/models/a.h", "server/engine/math/b.h", True),
            ("server/engine/math/a.h", "server/engine/models/b.h", False),
            ("server/engine/laws/solver/a.h", "server/engine/models/b.h", True),
            ("server/engine/models/a.h", "server/engine/laws/b.h", False),
            ("server/engine/scene/a.h", "server/engine/laws/solver/b.h", True),
            ("server/engine/scene/a.h", "server/engine/state/b.h", False),
            ("server/engine/state/a.h", "server/engine/scene/b.h", True),
            ("server/engine/state/a.h", "server/engine/tick/stages/b.h", False),
            ("server/engine/tick/stages/a.h", "server/engine/tick/b.h", True),
            ("server/engine/tick/a.h", "server/runtime/b.h", False),
            ("server/runtime/a.h", "server/engine/tick/b.h", True),
            ("server/runtime/a.h", "server/transport/b.h", False),
            ("server/transport/a.h", "server/runtime/b.h", True),
            ("server/main.cpp", "server/transport/b.h", True),
            ("server/main.cpp", "server/export/b.h", False),
            ("server/engine/tick/a.h", "tests/study/bench/b.h", False),
            ("client/link/a.h", "client/replay/b.h", False),
            ("server/transport/a.h", "client/link/b.h", False),
            ("tests/study/bench/a.h", "client/link/b.h", True),
            ("server/engine/math/a.h", "protocol/b.h", True),
            ("protocol/a.h", "server/engine/math/b.h", False),
            ("client/link/a.h", "server/engine/math/b.h", False),
            ("client/link/a.h", "protocol/b.h", True),
            ("tests/math/a.cpp", "server/main.cpp", False),
            ("tests/math/a.cpp", "client/link/b.h", True),
            ("server/engine/math/a.h", "tests/support/b.h", False),
        ]:
            with self.subTest(path=path, included=included):
                self.assertEqual(self.allows(path, included), allowed)

    def test_a_violation_names_file_line_and_reason(self):
        found = self.violations({"protocol/a.h": '#pragma once\n\n#include "server/engine/math/b.h"\n'})
        self.assertEqual(found, ["protocol/a.h:3: includes server/engine/math/b.h: protocol may include nothing of the "
                                 "project, but not server/engine/math"])

    def test_angle_brackets_and_relative_paths_are_seen(self):
        self.assertEqual(len(self.violations({"protocol/a.h": "#include <client/link/b.h>\n"})), 1)
        self.assertEqual(len(self.violations({"protocol/a.h": '#include "../client/link/b.h"\n', "client/link/b.h": ""})), 1)
        files = {"protocol/a.h": '#include <vector>\n#include "b.h"\n', "protocol/b.h": ""}
        self.assertEqual(self.violations(files), [])

    def test_a_folder_without_a_rule_is_told(self):
        found = self.violations({"server/attic/a.h": '#include "server/engine/math/b.h"\n'})
        self.assertEqual(len(found), 1)
        self.assertIn("server/attic/a.h lies in no folder of rooms()", found[0])

    def test_an_exception_holds_for_one_include_as_long_as_it_is_needed(self):
        exception = ("server/engine/math/a.h", "server/engine/models/b.h")
        text = '#include "server/engine/models/b.h"\n'
        self.assertEqual(self.violations({exception[0]: text}, [exception]), [])
        self.assertEqual(len(self.violations({exception[0]: text, "server/engine/math/c.h": text}, [exception])), 1)
        found = self.violations({exception[0]: ""}, [exception])
        self.assertEqual(len(found), 1)
        self.assertIn("no longer includes server/engine/models/b.h", found[0])


class Circles(unittest.TestCase):
    def test_sources_that_need_each_other_are_found_as_one_circle(self):
        needs = {"a": {"b"}, "b": {"c"}, "c": {"b", "d"}, "d": set(), "e": {"f"}, "f": {"e"}, "g": {"a"}}
        self.assertEqual(include_circles.circles(needs), [["b", "c"], ["e", "f"]])

    def test_a_header_and_its_source_are_one(self):
        with tempfile.TemporaryDirectory() as root:
            os.makedirs(os.path.join(root, "protocol"))
            for name, text in (("a.h", ""), ("a.cpp", '#include "protocol/a.h"\n#include "protocol/b.h"\n'),
                               ("b.h", '#include "protocol/a.h"\n'), ("c.cpp", '#include "b.h"\n')):
                with open(os.path.join(root, "protocol", name), "w", encoding="utf-8") as file:
                    file.write(text)
            self.assertEqual(include_circles.circles(include_circles.graph(root)), [["protocol/a", "protocol/b"]])

    def test_folders_of_the_engine_with_too_many_sources_are_found(self):
        names = [f"server/engine/math/a{number}" for number in range(include_circles.MOST + 1)]
        self.assertEqual(include_circles.crowded(dict.fromkeys(names[1:], ())), [])
        self.assertEqual(include_circles.crowded(dict.fromkeys(names, ())), [("server/engine/math", 13, 12)])
        self.assertEqual(include_circles.crowded({name.replace("engine", "runtime"): () for name in names}), [])


if __name__ == "__main__":
    unittest.main(verbosity=2)
