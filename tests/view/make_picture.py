#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the moving picture of the README: the page of acus-view while a hand pushes a needle into layers and back.
Usage: ACUS_PROGRAMS=build/release/bin tests/view/make_picture.py FILE.png
In lockstep, so that it is the same each time on one machine. Needs the packages of the group browser."""

import io
import os
import sys
import unittest

import test_page
from PIL import Image

FILE = sys.argv.pop()
SCENE = "layers"
WAYS = [0.0015] * 40 + [0.0] * 4 + [-0.0015] * 24 + [0.0] * 4  # m along the needle, from picture to picture
TICKS = 40  # between two pictures, at 500 Hz
SHOWN = (960, 537)  # px
COLOURS = 96


class Picture(test_page.Page):
    def test(self):
        self.browser.set_window_size(1280, 860)
        self.view_in_lockstep(SCENE)
        self.take()
        pictures = []
        for way in WAYS:
            self.browser.execute_script(f"acus.hands.goal.addScaledVector(acus.hands.axis, {way})")
            self.wait_for("acus.hands.goal.distanceTo(acus.hands.place) < 1e-6")
            self.step(TICKS)
            picture = Image.open(io.BytesIO(self.browser.get_screenshot_as_png())).convert("RGB")
            pictures.append(picture.resize(SHOWN, Image.LANCZOS))
        palette = pictures[len(pictures) // 2].quantize(COLOURS)
        frames = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures]
        frames[0].save(FILE, save_all=True, append_images=frames[1:], duration=80, loop=0, optimize=True)
        print(f"{FILE}: {len(frames)} pictures, {os.path.getsize(FILE) / 1e6:.2f} MB")


if __name__ == "__main__":
    unittest.main()
