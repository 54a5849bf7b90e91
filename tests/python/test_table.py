#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""acus.table and what reads by it: measured curves, motions, runs and timings, as spreadsheets and testing machines write them."""

import math
import unittest

import numpy as np
from small_scene import InTemporaryFolder

import acus
from acus.fit import read_measurement
from acus.study.trajectory import read_trajectory
from acus.timing import Timing

ROWS = [(0.0, 0.0), (0.5, 0.02), (1.0, 0.04), (1.5, 0.06), (2.0, 0.08)]
POINTS = [f"{x},{y}" for x, y in ROWS]
MOTION = "t,needle,x,y,z,qw,qx,qy,qz\n0,a,0.5,0,0.25,1,0,0,0\n1.5,a,0.5,0,0.125,1,0,0,0\n"


def swapped(text, separator, decimal):
    return text.translate({ord(","): separator, ord("."): decimal})


def as_spreadsheets_write(text):
    """The same table, in each of the ways."""
    yield text
    yield "\ufeff" + text
    yield text.replace("\n", "\r\n")
    yield swapped(text, ";", ",")
    yield swapped(text, "\t", ",")
    yield "sep=;\n" + swapped(text, ";", ".")
    yield "\n# a\n% b\n// c\n" + text.replace("\n", "\n\n") + ",,\n#d\n"
    yield "\n".join(",".join(f'"{cell}"'.replace(".", ",") for cell in line.split(",")) for line in text.splitlines())


def of_points(header, points):
    return "\n".join([header, *points]) + "\n"


class Curves(InTemporaryFolder):
    def read(self, text, **settings):
        path = self.path("data.csv")
        with open(path, "wb") as file:
            file.write(text if isinstance(text, bytes) else text.encode())
        return read_measurement(path, None, **settings)

    def test_each_way_of_writing_gives_the_same_curve(self):
        for text in [*as_spreadsheets_write(of_points("travel_mm,force_N", POINTS)), of_points("travel_mm force_N", [p.replace(",", "  ") for p in POINTS]),
                     of_points("Travel,Force\n(mm),(N)", POINTS), of_points("Travel in mm;Force [N]", [p.replace(",", ";") for p in POINTS]),
                     of_points("needle travel (cm),Axial Force (mN)", [f"{0.1 * x:.3f},{1e3 * y:g}" for x, y in ROWS])]:
            with self.subTest(text):
                data = self.read(text)
                np.testing.assert_allclose(data.x, [1e-3 * x for x, _ in ROWS])
                np.testing.assert_allclose(data.y, [y for _, y in ROWS])

    def test_a_line_tells_how_it_was_read(self):
        data = self.read(swapped(of_points("depth_mm,force_N", [f"{x},{-y}" for x, y in ROWS] + ["3.0,", "4.0,nan"]), ";", ","))
        self.assertEqual(data.told.removeprefix(self.path("data.csv")),
                         ": 5 of 7 rows (2 without a value), separated by ';', decimal comma; force_N turned: negative while the needle goes in; "
                         "in order of depth_mm; depth_mm counts from where the motion begins; if it is measured from the skin, free data.shift "
                         "below 0, to find how far above that is")

    def test_what_is_negative_on_the_way_in_is_turned(self):
        out = [f"{x},{-2 * y}" for x, y in ROWS[::-1]]  # larger, where it comes out
        for points, turned in ((POINTS, "signs as they are"), ([f"{x},{-y}" for x, y in ROWS], "force_N turned"), (POINTS + out, "signs as they are"),
                               ([f"{-x},{y}" for x, y in ROWS], "travel_mm turned"), ([f"{x},\u2212{y}" for x, y in ROWS], "force_N turned"),
                               ([f"{-x},{-y}" for x, y in ROWS], "travel_mm and force_N turned")):
            with self.subTest(points):
                data = self.read(of_points("travel_mm,force_N", points))
                self.assertIn(turned, data.told)
                np.testing.assert_allclose(data.x[:5], [1e-3 * x for x, _ in ROWS])
                np.testing.assert_allclose(data.y[:5], [y for _, y in ROWS])
        data = self.read(of_points("time_s,force_N", ["-1,0", "0,1", "1,2", "2,0", "3,-9"]))
        self.assertIn("signs as they are", data.told)

    def test_rows_that_go_back_are_sorted_or_refused(self):
        data = self.read(of_points("time_s,force_N", ["0,0", "1,1", "2,2", "1.99,2", "3,3", "4,1"]))
        self.assertIn("sorted by time_s, which goes back 1 times", data.told)
        self.assertTrue(np.all(np.diff(data.x) > 0))
        for text, what in ((of_points("time_s,force_N", POINTS * 2), "csv:7: column time_s: it goes back to 0 s, after 2 s; leave one experiment"),
                           (of_points("travel_mm,force_N", POINTS[::-1]), "csv:3: column travel_mm: it goes back to 0.0015 m")):
            with self.subTest(what), self.assertRaisesRegex(acus.FitError, what):
                self.read(text)
        data = self.read(of_points("travel_mm,force_N", POINTS + POINTS[::-1]))
        self.assertIn("6 of 10 rows", data.told)
        self.assertIn("up to line 7, where the first way in ends", data.told)

    def test_what_may_be_two_things_is_refused_with_the_remedy(self):
        header = "travel_mm,force_N\n"
        for text, what in ((of_points("travel_mm,force_N", POINTS).encode("utf-16"), "UTF-16; save it as CSV in UTF-8"),
                           (of_points("travel_mm,force_N", POINTS).encode("utf-16-be"), "UTF-16; save it"),
                           (of_points("travel_\xb5m,force_N", POINTS).encode("latin-1"), "no text in UTF-8; save it"), (b"PK\x03\x04", "a workbook; save it"),
                           (of_points("travel_mm,force_N", [p.replace(".", ",") for p in POINTS]), "csv:2: it has 4 cells, the header 2; where numbers"),
                           (header + "0,0\n1,0,5\n2,1,5\n", "csv:3: it has 3 cells, the header 2"),
                           (header + '500,0.1\n"1,000",0.2\n', "csv:3: '1,000' here and '0.1' in line 2: which is the decimal sign"),
                           (header.replace(",", ";") + "500;0,1\n1.000;0,2\n", "'1.000' here and '0,1' in line 2"),
                           (header + '500,1\n"1,000,000",2\n', "found '1,000,000'; write it without grouping"), (header + "5_0,1\n", "found '5_0'"),
                           (header + "1 000,1\n", "found '1 000'; write it without grouping"), (header + ",\n,\n", "no rows"), (header + "0,\nNA,2\n", "no rows with"),
                           ("travel_mm,force_N,force_N\n0,1,1\n", "expected one column")):
            with self.subTest(what), self.assertRaisesRegex(acus.FitError, what):
                self.read(text)


class Motions(InTemporaryFolder):
    def test_each_way_of_writing_gives_the_same_motion(self):
        for text in as_spreadsheets_write(MOTION):
            with self.subTest(text):
                motion = read_trajectory(self.write("motion.csv", text))["a"]
                np.testing.assert_allclose(motion.at(2)[0], [0.5, 0, 0.125])
        named = read_trajectory(self.write("motion.csv", MOTION.replace(",a,", ',"left, ""long""",')))
        self.assertEqual(list(named), ['left, "long"'])

    def test_lines_are_named(self):
        for text, what in ((MOTION.replace("0.125", "zero"), "csv:3: z: could not convert 'zero' to a number"), (MOTION.replace("1.5", "0"), "csv:3: .*times do not"),
                           (MOTION.replace("\n1.5", "\n\n1.5").replace("1,0,0,0\n", "2,0,0,0\n"), "csv:2: .*unit quaternion"), (MOTION.replace("y,", "x,", 1), "no column 'y'"),
                           (MOTION.replace("z,", "z,z,", 1), "second column 'z'"), (MOTION.encode("utf-16").decode("latin-1"), "UTF-16|UTF-8")):
            with self.subTest(what), self.assertRaisesRegex(acus.StudyError, what):
                read_trajectory(self.write("motion.csv", text))


class Written(InTemporaryFolder):
    """By acus-replay, then saved by a spreadsheet."""

    def test_a_run(self):
        text = "tick,time_s,needle,depth_m\n0,0.5,a,0.25\n1,0.625,a,0.125\n"
        for each in as_spreadsheets_write(text):
            with self.subTest(each), acus.Run(self.write("run.csv", each)) as run:
                np.testing.assert_array_equal(run["a"].depth, [0.25, 0.125])
                np.testing.assert_array_equal(run["a"].tick, [0, 1])
        self.assertRaisesRegex(acus.RunError, "second column 'time_s'", lambda: acus.Run(self.write("run.csv", text.replace("depth_m", "time_s"))).needles)
        events = "tick,time_s,needle,kind,region\n1,0.5,a,puncture,\"liver, left\"\n"
        self.write("run.csv", text)
        for each in (events, events.replace("0.5", '"0,5"'), "\ufeff" + events):
            self.write("run.events.csv", each)
            event = acus.Run(self.path("run.csv")).events[0]
            self.assertEqual((event.time, event.region), (0.5, "liver, left"))

    def test_a_timing(self):
        trips, stats = "seq,round_trip_s\n1,0.5\n2,0.25\n", "received_s,late\n1.5,0\n2.5,1\n"
        for one, other in zip(as_spreadsheets_write(trips), as_spreadsheets_write(stats)):
            with self.subTest(one):
                self.write("timing.stats.csv", other)
                timing = Timing(self.write("timing.csv", one))
                self.assertEqual((timing.trips["round_trip_s"][1], timing.stats["received_s"][1]), (0.25, 2.5))
                self.assertFalse(math.isnan(timing.stats["late"][0]))


if __name__ == "__main__":
    unittest.main()
