# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that the package writes replace its own, and nobody else's."""

import importlib.util
import json
import os
import stat
import unittest
import unittest.mock

from small_scene import InTemporaryFolder

from acus import own_files
from acus.errors import SceneError


class OwnFiles(InTemporaryFolder):
    def read(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()

    def write_own(self, name, text):
        own_files.write(self.path(name), own_files.sealed(text), own_files.is_sealed, SceneError)

    def test_what_it_wrote_is_replaced(self):
        for text in ("a: 1\n", "a: 2\n", "", "a: 3"):
            self.write_own("own", text)
            self.assertEqual(self.read("own").partition(b"\n")[2].decode(), text)
        self.write("empty", "")
        self.write_own("empty", "a: 1\n")
        self.assertEqual(sorted(os.listdir(self.folder)), ["empty", "own"])

    def test_others_files_and_edited_ones_are_not(self):
        self.write_own("edited", "a: 1\n")
        with open(self.path("edited"), "a", encoding="utf-8") as file:
            file.write("b: 2\n")
        self.write("others", "a: 1\n")
        os.symlink("others", self.path("link"))
        os.mkdir(self.path("folder"))
        before = {name: self.read(name) for name in ("edited", "others")}
        for name in ("edited", "others", "link"):
            self.assertRaisesRegex(SceneError, f"{name}: something else stands there, .* give another name, or remove it",
                                   self.write_own, name, "a: 3\n")
        self.assertRaisesRegex(SceneError, "folder: Is a directory", self.write_own, "folder", "a: 3\n")
        self.assertEqual({name: self.read(name) for name in before}, before)

    def test_a_link_stays_and_so_do_permissions(self):
        self.write_own("own", "a: 1\n")
        os.chmod(self.path("own"), 0o600)
        os.symlink("own", self.path("link"))
        os.symlink("new", self.path("dangling"))
        for name in ("link", "dangling"):
            self.write_own(name, "a: 2\n")
            self.assertTrue(os.path.islink(self.path(name)))
        self.assertEqual(self.read("own"), self.read("new"))
        self.assertEqual(stat.S_IMODE(os.stat(self.path("own")).st_mode), 0o600)

    def test_what_cannot_be_written_whole_leaves_what_was_there(self):
        self.write_own("own", "a: 1\n")
        before = self.read("own")
        for fails in ("fsync", "replace"):
            with unittest.mock.patch.object(os, fails, side_effect=OSError(28, "No space left on device")):
                self.assertRaisesRegex(SceneError, "own: No space left on device", self.write_own, "own", "a: 2\n")
            self.assertEqual((self.read("own"), os.listdir(self.folder)), (before, ["own"]))

    def test_devices_are_written_to(self):
        own_files.write("/dev/null", b"x", own_files.is_sealed)

    def test_kinds_know_their_own(self):
        table = own_files.has_columns(("case",), ("hash", "error"))
        self.assertTrue(table(own_files.table_of(("case", "a,b", "hash", "error"), [(1, 2, 3, "x\n")])))
        for header in ("case,a\n", "a,hash,error\n", "", "case,hash,error,notes\n", '{"case": 1}'):
            self.assertFalse(table(header.encode()), header)
        self.assertTrue(own_files.is_signed(own_files.signed({"a": 1})))
        self.assertEqual(json.loads(own_files.signed({"a": 1})), {"written_by": "Acus", "a": 1})
        self.assertFalse(own_files.is_signed(b'{"written_by": "Acus"}'))
        for other in (b"", b"\x89PNG\r\n\x1a\n" + 100 * b"x", b"%PDF-1.4 Acus", b"Acus", b"tEXtSoftware\0Acus"):
            self.assertFalse(own_files.is_picture(other), other)


@unittest.skipUnless(all(map(importlib.util.find_spec, ("matplotlib", "PIL"))), "SKIPPED: Matplotlib or Pillow is not installed")
class OwnPictures(InTemporaryFolder):
    def draw(self, name):
        from acus.drawing import figures
        from matplotlib.figure import Figure
        figures.save(Figure((1, 1)), self.path(name))

    def test_pictures_are_replaced_and_others_are_not(self):
        for ending in (".png", ".svg", ".pdf"):
            for _ in range(2):
                self.draw("own" + ending)
            self.write("others" + ending, "mine")
            self.assertRaisesRegex(Exception, "others.* something else stands there", self.draw, "others" + ending)
        self.assertRaisesRegex(Exception, "expected a name that ends with .png, .svg, .pdf", self.draw, "own.txt")


if __name__ == "__main__":
    unittest.main()
