#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The page of acus-view in a real browser, drawn in software. Servers run in lockstep where a test looks at a tick, so
that what is drawn is known and nothing waits for time."""

import io
import os
import shutil
import signal
import sys
import time
import unittest

from viewed import PATIENCE, ROOT, WithGateway, scene

try:
    import msgpack
    import numpy
    import zmq
    from PIL import Image
    from selenium import webdriver
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.by import By
    from selenium.webdriver.chrome.service import Service
    MISSING = next((f"no {name}" for name in ("chromium", "chromedriver") if not shutil.which(name)), None)
except ImportError as error:
    MISSING = str(error)

SIZE = (1280, 720)
FLAGS = ["--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
         "--disable-dev-shm-usage", "--disable-quic", "--no-first-run", "--disable-background-networking",
         "--disable-component-update", "--disable-sync", f"--window-size={SIZE[0]},{SIZE[1]}"]


class Page(WithGateway):
    def setUp(self):
        super().setUp()
        self.browsers = []
        self.browser = self.open_browser()

    def open_browser(self):
        options = webdriver.ChromeOptions()
        for flag in FLAGS:
            options.add_argument(flag)
        options.add_experimental_option("prefs", {"download.default_directory": self.folder})
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        browser = webdriver.Chrome(options=options, service=Service(
            shutil.which("chromedriver"), env=dict(os.environ, TMPDIR=self.folder)))
        self.addCleanup(browser.quit)
        browser.set_script_timeout(PATIENCE)
        self.browsers.append(browser)
        return browser

    def look(self, url, browser=None):
        (browser or self.browser).get(url)

    def get(self, script, browser=None):
        return (browser or self.browser).execute_script("return " + script)

    def wait_for(self, script, browser=None):
        """Until the expression is true; its value."""
        deadline = time.monotonic() + PATIENCE
        while not (value := self.get(script, browser)):
            self.assertLess(time.monotonic(), deadline, script + "\n" + str(self.errors()))
            time.sleep(0.02)
        return value

    def text(self, name, browser=None):
        return (browser or self.browser).find_element(By.ID, name).text

    def press(self, name, browser=None):
        (browser or self.browser).find_element(By.ID, name).click()

    def errors(self):
        return [entry for browser in self.browsers for entry in browser.get_log("browser") if entry["level"] == "SEVERE"]

    def view_in_lockstep(self, name):
        _, url = self.view(scene(name) if os.sep not in name else name, "--lockstep")
        self.look(url)
        self.wait_for("acus.hello && acus.standing.server && acus.hello.scene")

    def take(self):
        self.press("hold")
        self.wait_for("acus.hands.holding")

    def step(self, ticks):
        """Makes ticks, and waits until the last is drawn."""
        answer = self.browser.execute_async_script(
            "const done = arguments[1]; acus.link.request('step', {ticks: arguments[0]}).then(done)", ticks)
        self.assertEqual(answer["type"], "done", answer)
        self.wait_for(f"acus.tick >= {answer['tick']}")
        self.drawn()
        return answer["tick"]

    def drawn(self):
        """Until a picture has been drawn from now on."""
        frames = self.get("(acus.stage.draw(), acus.frames)")
        self.wait_for(f"acus.frames > {frames}")

    def choose(self, name, value):
        self.browser.execute_script(
            "const list = document.getElementById(arguments[0]); list.value = arguments[1];"
            "list.dispatchEvent(new Event('change'))", name, value)

    def picture(self):
        image = Image.open(io.BytesIO(self.browser.get_screenshot_as_png())).convert("RGB")
        where = os.environ.get("ACUS_PICTURES")
        if where:
            image.save(os.path.join(where, f"{self.id().split('.')[-1]}-{int(1e3 * time.monotonic())}.png"))
        width = self.get("document.getElementById('stage').clientWidth")
        return image.crop((0, 0, width, image.height))

    def share(self, image, holds):
        pixels = list(image.getdata())
        return sum(1 for pixel in pixels if holds(*pixel)) / len(pixels)


class Drawing(Page):
    def test_regions_needle_and_forces_are_where_they_should_be(self):
        self.view_in_lockstep("insertion_pullback_layers")
        self.assertIn("SwiftShader", self.get("acus.renderer()"))
        self.take()
        self.step(20)
        self.wait_for("document.getElementById('legend').childElementCount >= 2")
        first = self.picture()
        # The colours of the first regions: terracotta and ochre, whatever light falls on them.
        self.assertGreater(self.share(first, lambda r, g, b: r > g + 25 and g > b), 0.05)
        self.assertGreater(len(set(first.getdata())), 50)
        # Where the camera has the tip there is something else than paper.
        tip = self.get("acus.tip('needle')")
        paper = first.getpixel((3, 3))
        near = [first.getpixel((round(tip["x"]) + i, round(tip["y"]) + j)) for i in range(-3, 4) for j in range(-3, 4)]
        self.assertTrue(any(sum(abs(a - b) for a, b in zip(pixel, paper)) > 60 for pixel in near), near)

    def test_a_push_moves_needle_and_picture_as_the_states_say(self):
        self.view_in_lockstep("insertion_pullback")
        self.take()
        self.step(5)
        before = self.get("acus.force('needle')")
        picture = self.picture()
        pixel = self.get("acus.tip('needle')")
        self.push_ahead(10)  # 15 mm, 5 mm of them into the surface
        tick = self.step(600)
        after = self.get("acus.force('needle')")
        way = sum((a - b) ** 2 for a, b in zip(after["base_position"], before["base_position"])) ** 0.5
        self.assertAlmostEqual(way, 0.015, delta=0.0005)
        self.assertGreater(after["tick"], before["tick"])
        self.assertGreaterEqual(tick, 600)
        self.assertIn("mm", self.text("figures"))
        moved = self.get("acus.tip('needle')")
        self.assertGreater(abs(moved["y"] - pixel["y"]) + abs(moved["x"] - pixel["x"]), 5)
        self.assertGreater(self.share_of_change(picture, self.picture()), 0.0005)

    def push_ahead(self, notches):
        """Of the wheel, upwards."""
        for _ in range(notches):
            self.browser.execute_script(
                "document.querySelector('canvas').dispatchEvent(new WheelEvent('wheel', {deltaY: -100, cancelable: true}))")
        self.wait_for("acus.hands.goal.distanceTo(acus.hands.place) < 1e-6")

    def share_of_change(self, a, b):
        pairs = list(zip(a.getdata(), b.getdata()))
        return sum(1 for x, y in pairs if sum(abs(i - j) for i, j in zip(x, y)) > 30) / len(pairs)

    def test_a_drag_at_the_needle_moves_it_sideways_and_no_deeper(self):
        self.view_in_lockstep("insertion_pullback")
        self.take()
        self.step(5)
        before = self.get("acus.force('needle')")
        at = self.get("acus.stage.pixel(acus.hands.needle().point(2))")
        canvas = self.browser.find_element(By.TAG_NAME, "canvas")
        x, y = at["x"] - canvas.size["width"] / 2, at["y"] - canvas.size["height"] / 2
        ActionChains(self.browser, duration=20).move_to_element_with_offset(canvas, round(x), round(y)).click_and_hold() \
            .move_by_offset(12, 0).move_by_offset(12, 0).release().perform()
        self.wait_for("acus.hands.goal.distanceTo(acus.hands.place) < 1e-6")
        self.step(300)
        after = self.get("acus.force('needle')")
        moved = [a - b for a, b in zip(after["base_position"], before["base_position"])]
        self.assertGreater(max(abs(moved[0]), abs(moved[1])), 0.002)
        self.assertLess(abs(moved[2]), 0.0005)  # the needle points down

    def test_strain_is_shown_with_its_scale(self):
        self.view_in_lockstep("insertion_pullback")
        self.choose("colour", "strain")
        self.take()
        self.step(5)
        self.assertRegex(self.text("legend"), "yellow 0 % strain")
        self.push_ahead(40)  # 60 mm, 37 of them inside
        self.step(800)
        self.wait_for("acus.tissue.largest > 0.02")
        self.assertRegex(self.text("legend"), "yellow [1-9][0-9]* % strain")

    def test_other_scenes_can_be_seen(self):
        for name in ("brachytherapy", "through", "deep_brain"):
            with self.subTest(name):
                if name == "deep_brain" and not os.path.exists(os.path.join(os.environ["ACUS_PROGRAMS"], "acus-mesh")):
                    continue
                self.view_in_lockstep(name)
                self.take()
                self.step(10)
                self.assertGreater(len(set(self.picture().getdata())), 50)
                self.assertEqual(self.errors(), [])

    def test_a_scene_without_tissue(self):
        alone = self.write("alone.yaml", "acus_scene: 1\nname: alone\ntissue: {rung: none}\nneedles:\n"
                           "  - {name: needle, length: 0.15, base: {position: [0, 0, 0.1]}}\n")
        self.view_in_lockstep(alone)
        self.take()
        self.step(10)
        self.assertGreater(self.share(self.picture(), lambda r, g, b: r > b + 80), 0.0001)  # the hub
        self.assertEqual(self.errors(), [])


class Together(Page):
    def test_one_drives_and_others_watch(self):
        _, url = self.view(scene("insertion_pullback"))
        other = self.open_browser()
        self.look(url)
        self.look(url, other)
        self.take()
        self.wait_for("acus.standing.driven && !acus.standing.driving", other)
        self.assertFalse(other.find_element(By.ID, "hold").is_enabled())
        self.assertIn("another page drives", self.text("status", other))
        # What it sends all the same goes nowhere.
        other.execute_script("acus.link.send('reset', {seq: 1}); acus.link.send('shutdown', {seq: 2})")
        self.wait_for("acus.hello.held.length === 1", other)
        self.assertEqual(self.get("acus.hello.epoch", other), 0)
        # Whoever drives lets go when the page is closed, and the needle is free.
        self.browser.get("about:blank")
        self.wait_for("!acus.standing.driven && acus.hello.held.length === 0", other)
        self.assertTrue(other.find_element(By.ID, "hold").is_enabled())
        self.press("hold", other)
        self.wait_for("acus.hands.holding", other)

    def test_the_tips_of_other_worlds_are_drawn_about_the_needles(self):
        context = zmq.Context()
        self.addCleanup(context.destroy, linger=0)
        worlds = context.socket(zmq.PUB)
        worlds.bind(f"ipc://{self.folder}/cloud")
        self.look(self.view(scene("insertion_pullback"), "--lockstep", "--cloud", f"ipc://{self.folder}/cloud")[1])
        self.wait_for("acus.hello && acus.standing.server && acus.hello.scene")
        self.take()
        self.step(1)
        self.assertFalse(self.browser.find_element(By.ID, "cloud").is_displayed())
        apart = 1e-3 * numpy.array([[0, 0, 0], [20, 0, 0], [-20, 0, 0], [0, 0, 20], [0, 15, 0]])  # m, of which one lies along the needle
        needle = {"name": "needle", "tips": (apart + [1, 2, 3]).tobytes(), "spread": 0.0123, "error": 0.0}
        message = {"v": 2, "type": "cloud", "epoch": 0, "tick": 1, "time": 0.002, "behind": 0.0, "needles": [needle]}
        before = self.share(self.picture(), self.is_purple)
        deadline = time.monotonic() + PATIENCE
        while not self.text("spread") and time.monotonic() < deadline:
            worlds.send_multipart([b"cloud", msgpack.packb(message)])
            self.drawn()
        self.assertEqual(self.text("spread"), "tips of 5 worlds, seen along the needle; ring 20 mm, spread 12.30 mm")
        places = self.get("[...document.querySelectorAll('#tips circle:not(.ring)')].map((c) => Math.hypot(c.getAttribute('cx'), c.getAttribute('cy')))")
        numpy.testing.assert_allclose(places, [0, 36, 36, 0, 27], atol=0.1)
        self.assertGreater(self.share(self.picture(), self.is_purple), before + 4 * 10 / (SIZE[0] * SIZE[1]))
        self.assertEqual(self.errors(), [])
        self.browser.execute_async_script("acus.link.request('reset').then(arguments[0])")
        self.wait_for("document.getElementById('cloud').hidden")

    @staticmethod
    def is_purple(red, green, blue):
        return blue > green + 60 and red > green + 40 and blue > red

    def test_the_page_reads_what_the_server_wrote(self):
        """Every field of a force, and all coordinates, against Python's msgpack."""
        self.serve(scene("through"), "--lockstep")
        _, url = self.view("--commands", self.commands, "--states", self.states)
        self.look(url)
        self.wait_for("window.acus && acus.hello && acus.standing.server")
        self.take()
        states = zmq.Context.instance().socket(zmq.SUB)
        self.addCleanup(states.close, 0)
        states.connect(self.states)
        for topic in ("force", "needle", "tissue"):
            states.subscribe(topic)
        while not states.poll(0):  # subscriptions take a moment to arrive
            self.step(40)
        self.step(40)
        self.drawn()
        shown = {"force": self.get("acus.force('needle')"),
                 "needle": self.get("Array.from(acus.hands.needle().positions)"),
                 "tissue": self.get("Array.from(acus.tissue.positions.array)")}
        numbers = {"needle": "<f8", "tissue": "<f4"}
        while shown:  # each is one of those that come
            self.assertTrue(states.poll(1000 * PATIENCE), f"{list(shown)} as the page shows it was never sent")
            topic, payload = states.recv_multipart()
            topic, state = topic.decode(), msgpack.unpackb(payload)
            if topic in numbers:
                state = numpy.frombuffer(state["positions"], numbers[topic]).tolist()
            if shown.get(topic) == state:
                del shown[topic]

    def test_a_server_that_dies_is_shown_and_found_again(self):
        server = self.serve(scene("insertion_pullback"))
        _, url = self.view("--commands", self.commands, "--states", self.states)
        self.look(url)
        self.wait_for("acus.standing.server && acus.tick > 0")
        first = self.get("acus.hello.instance")
        server.send_signal(signal.SIGKILL)
        server.wait(PATIENCE)
        self.wait_for("!acus.standing.server")
        self.assertIn("the server does not answer", self.text("status"))
        self.serve(scene("insertion_pullback"))
        self.wait_for(f"acus.standing.server && acus.hello.instance !== {first} && acus.tick > 0")

    def test_a_wrong_token_is_told(self):
        _, url = self.view(scene("insertion_pullback"))
        self.look(url[:-1] + ("0" if url[-1] != "0" else "1"))
        self.wait_for("document.getElementById('status').textContent.includes('wrong token')")
        self.assertIsNone(self.get("acus.hello"))

    def test_a_damaged_frame_is_told_and_ends_nothing(self):
        self.view_in_lockstep("insertion_pullback")
        for damage in ("[0xc1]", "[0x81]", "[0x2a]", "[]"):
            self.browser.execute_script(f"acus.link.take(new Uint8Array({damage}).buffer)")
        self.wait_for("!document.getElementById('notice').hidden")
        self.assertIn("a damaged message was left out", self.text("notice"))
        self.take()
        self.step(3)
        self.assertEqual(self.errors(), [])

    def test_the_hand_goes_on_from_where_a_reset_puts_the_needle(self):
        _, url = self.view(scene("insertion_pullback"))
        self.look(url)
        self.wait_for("acus.hello && acus.force('needle')")
        start = self.get("acus.force('needle')?.base_position[2]")
        self.take()
        self.browser.execute_script("acus.hands.goal.addScaledVector(acus.hands.axis, 0.012)")
        self.wait_for(f"Math.abs(acus.force('needle')?.base_position[2] - {start} + 0.012) < 1e-4")
        self.press("reset")
        self.wait_for("acus.force('needle')?.epoch === 1 && !acus.hands.waiting")
        tick = self.get("acus.force('needle')?.tick")
        self.wait_for(f"acus.force('needle')?.tick > {tick} + 100")
        self.assertAlmostEqual(self.get("acus.force('needle')?.base_position[2]"), start, delta=1e-5)
        self.assertEqual(self.get("acus.hands.holding"), "needle")

    def test_a_motion_is_played_until_somebody_takes_the_needle(self):
        self.view_in_lockstep("through")
        self.assertEqual(self.get("document.getElementById('motions').value"), "through")
        self.press("play")
        self.wait_for("acus.force('needle')?.depth > 0.005")
        self.assertEqual(self.get("acus.standing.playing"), "through")
        self.assertIn("plays through", self.text("status"))
        self.take()
        self.assertEqual(self.get("acus.standing.playing"), "")
        self.assertEqual(self.text("play"), "Play")
        self.assertEqual(self.errors(), [])

    def test_a_hand_moves_nothing_while_the_simulation_is_paused(self):
        _, url = self.view(scene("insertion_pullback"))
        self.look(url)
        self.wait_for("acus.hello && acus.force('needle')")
        self.take()
        self.press("pause")
        self.wait_for("acus.hello.paused")
        place = self.get("acus.hands.place.toArray()")
        key = "dispatchEvent(new KeyboardEvent('{}', {{key: 'w', shiftKey: true}}))"
        self.get(key.format("keydown"))
        self.get("acus.stage.renderer.domElement.dispatchEvent(new WheelEvent('wheel', {deltaY: -100, cancelable: true}))")
        sent = self.get("acus.hands.seq")
        self.wait_for(f"acus.hands.seq > {sent + 30}")  # half a second
        self.get(key.format("keyup"))
        self.press("pause")
        self.wait_for("!acus.hello.paused")
        sent = self.get("acus.hands.seq")
        self.wait_for(f"acus.hands.seq > {sent + 30}")
        self.assertEqual(self.get("acus.hands.goal.toArray()"), place)
        for axis in range(3):
            self.assertAlmostEqual(self.get("acus.force('needle').base_position")[axis], place[axis], delta=1e-5)
        self.get(key.format("keydown"))
        self.wait_for(f"acus.force('needle').base_position[2] < {place[2]} - 1e-3")
        self.assertEqual(self.errors(), [])

    def test_the_first_motion_goes_to_and_fro_until_somebody_takes_the_needle(self):
        path = os.path.join(self.folder, "small.yaml")
        os.mkdir(os.path.join(self.folder, "trajectories"))
        shutil.copy(scene("through"), path)
        rows = [f"{t},needle,0.003,0.002,{z},0.70710678,0,0.70710678,0\n" for t, z in ((0, 0.145), (0.1, 0.144))]
        self.write("trajectories/small.csv", "t,needle,x,y,z,qw,qx,qy,qz\n" + "".join(rows))
        _, url = self.view(path, "--lockstep", "--play")
        self.look(url)
        self.wait_for("acus.force && acus.force('needle')?.time > 1")  # five times to and fro
        self.assertEqual(self.get("acus.standing.playing"), "small")
        self.take()
        self.assertEqual(self.get("acus.standing.playing"), "")
        self.assertEqual(self.errors(), [])

    def test_curves_and_picture_follow_a_changed_theme(self):
        self.view_in_lockstep("through")
        self.take()
        self.step(5)
        self.wait_for("acus.curves.length > 1")
        self.browser.execute_script(
            "window.ink = () => { const c = document.querySelector('#plots canvas');"
            "return c.getContext('2d').getImageData(0, 0, c.width, c.height).data.join() }; window.before = ''")
        for theme in ("light", "dark", "light", "dark"):
            self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": theme}]})
            self.wait_for("ink() !== before")
            self.drawn()
            self.browser.execute_script("before = ink()")

    def test_a_motion_that_does_not_fit_is_told(self):
        self.view_in_lockstep("through")
        self.choose("motions", "brachytherapy")
        self.press("play")
        self.wait_for("document.getElementById('notice').textContent.includes('does not fit')")
        self.wait_for("acus.standing.playing === ''")

    def test_a_scene_is_chosen_and_its_motion_with_it(self):
        self.view_in_lockstep("insertion_pullback_layers")
        self.assertEqual(self.get("document.getElementById('motions').value"), "insertion_pullback")
        self.choose("scenes", "steering_arc")
        self.wait_for("acus.hello.file === 'steering_arc.yaml'")
        self.wait_for("document.getElementById('motions').value === 'steering_arc'")
        self.assertEqual(self.text("scene"), "steering arc")

    def test_a_run_is_recorded_and_taken_home(self):
        self.view_in_lockstep("through")
        self.press("record")
        name = self.wait_for("acus.hello.recording")
        self.wait_for("document.getElementById('record').textContent === 'Save'")
        self.take()
        self.step(50)
        self.press("record")
        file = os.path.join(self.folder, name)
        deadline = time.monotonic() + PATIENCE
        while not os.path.exists(file):
            self.assertLess(time.monotonic(), deadline, os.listdir(self.folder))
            time.sleep(0.02)
        again = self.launch("acus-export", file, "--quiet")
        self.assertEqual(again.wait(PATIENCE), 0)

    def record(self, seconds):
        """A recording of the needle that is pushed through a slab, as far as it comes in that time."""
        run = self.path("run.acus")
        server = self.serve(scene("through"), "--lockstep", "--record", run)
        with open(os.path.join(ROOT, "scenes", "trajectories", "through.csv"), encoding="utf-8") as file:
            rows = [row for row in file if row.startswith("t") or float(row.split(",")[0]) <= seconds]
        replay = self.launch("acus-replay", self.write("short.csv", "".join(rows)), "--lockstep", "--shutdown",
                             "--commands", self.commands, "--states", self.states)
        replay.communicate(timeout=PATIENCE)
        server.communicate(timeout=PATIENCE)
        self.assertEqual((replay.returncode, server.returncode), (0, 0))
        return run

    def seek(self, seconds):
        self.browser.execute_script("const at = document.getElementById('at'); at.value = arguments[0];"
                                    "at.dispatchEvent(new Event('input'))", seconds)

    def test_a_recording_is_shown_with_a_time_line_and_gone_on_with(self):
        _, url = self.view(self.record(2))
        self.look(url)
        self.wait_for("window.acus && acus.standing.run && acus.standing.run.whole")
        self.wait_for("!acus.standing.run.playing")  # it has come to the end
        length, end = self.get("acus.standing.run.length"), self.get("acus.force('needle')")
        self.assertAlmostEqual(length, 2, delta=0.1)
        span = self.get("acus.span")  # of the curves: what is recorded
        self.assertAlmostEqual(span["max"] - span["min"], length, delta=0.05)
        self.seek(0.3)
        self.seek(1)  # at once: the last counts
        self.wait_for("acus.standing.run.at === 1 && Math.abs(acus.force('needle').time - 1) < 0.02")
        middle = self.get("acus.force('needle')")
        self.assertLess(middle["base_position"][2], self.get("acus.hello.needles[0].base_position[2]"))
        self.assertGreater(middle["base_position"][2], end["base_position"][2])  # it goes down
        self.drawn()
        self.take()  # from here
        self.assertTrue(self.get("acus.standing.run.live"))
        self.wait_for("acus.force('needle').time > 1.2")
        live = self.get("acus.force('needle')")
        for axis in range(3):
            self.assertAlmostEqual(live["base_position"][axis], middle["commanded_position"][axis], delta=1e-4)
        self.assertLess(self.get("acus.curves[0]"), 0.1)  # what was before it stays
        self.assertLess(self.get("Math.max(...acus.curves.slice(1).map((t, i) => t - acus.curves[i]))"), 0.05)
        self.press("hold")
        self.press("run-back")
        self.wait_for("!acus.standing.run.live && acus.force('needle')?.time < 1.02")
        self.press("run-play")
        self.wait_for("acus.force('needle')?.time > 1.1")
        self.assertEqual(self.errors(), [])

    def test_a_recording_becomes_pictures(self):
        run, pictures = self.record(1), os.path.join(self.folder, "pictures")
        done = self.launch("acus-view", run, "--export", pictures, "--rate", "2")
        done.communicate(timeout=PATIENCE)
        self.assertEqual(done.returncode, 0)
        self.assertEqual(sorted(os.listdir(pictures)), ["000001.png", "000002.png", "000003.png"])
        found = [numpy.asarray(Image.open(os.path.join(pictures, name)).convert("RGB")).astype(int)
                 for name in sorted(os.listdir(pictures))]
        for picture in found:
            self.assertEqual(picture.shape, (SIZE[1], SIZE[0], 3))
            self.assertGreater(len(numpy.unique(picture.reshape(-1, 3), axis=0)), 500)  # tissue, needle, words
        for one, other in ((0, 1), (1, 2)):  # needle and curves have gone on
            self.assertGreater(numpy.count_nonzero(numpy.abs(found[one] - found[other]).max(axis=2) > 30), 200)
        for shown, target in ((run, pictures), (scene("layers"), self.path("others"))):  # there already; no recording
            refused = self.launch("acus-view", shown, "--export", target)
            self.assertIn("--export", refused.communicate(timeout=PATIENCE)[1])
            self.assertEqual(refused.returncode, 1)

    def test_a_paused_simulation_goes_on_for_whoever_asks(self):
        _, url = self.view(scene("insertion_pullback"))
        self.look(url)
        self.wait_for("acus.hello && acus.force('needle')")
        self.press("pause")
        self.wait_for("acus.hello.paused && !acus.standing.driving")
        self.browser.refresh()
        self.wait_for("window.acus && acus.hello && acus.hello.paused")
        self.press("pause")
        self.wait_for("!acus.hello.paused && acus.force('needle')")

    def test_another_scene_lets_the_needle_go(self):
        self.serve(scene("insertion_pullback"))
        _, url = self.view("--commands", self.commands, "--states", self.states)
        self.look(url)
        self.wait_for("acus.hello && acus.force('needle')")
        self.take()
        self.browser.find_element(By.ID, "file").send_keys("layers\n")
        self.wait_for("acus.hello.scene === 'layers' && !acus.hands.holding && !acus.standing.driving")
        self.wait_for("document.getElementById('legend').childElementCount === 3")
        self.take()
        self.assertEqual(self.errors(), [])

    def test_a_moment_is_kept_and_found_again(self):
        self.view_in_lockstep("insertion_pullback")
        self.take()
        self.step(7)
        self.press("keep")
        self.wait_for("!document.getElementById('back').disabled")
        self.step(20)
        self.press("back")
        self.wait_for("acus.force('needle')?.epoch === 1 && !acus.hands.waiting")
        self.assertEqual(self.step(1), 10)  # 1 + 7 ticks were kept, and one tells where the needle is
        self.press("reset")
        self.wait_for("acus.force('needle')?.epoch === 2 && !acus.hands.waiting")
        self.assertEqual(self.get("acus.hands.holding"), "needle")
        self.assertEqual(self.errors(), [])


if __name__ == "__main__":
    if MISSING:
        print(f"SKIPPED: {MISSING}; scripts/install-packages browser has it")
        sys.exit(0)
    unittest.main()
