#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Packs the build in $ACUS_BUILD with CPack and tries what comes out. The system's own packages are left alone: dpkg
installs into a root of the test's own, where maintainer scripts are told so by $DPKG_ROOT."""

import glob
import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import unittest

BUILD, CPACK, CMAKE = (os.environ["ACUS_" + name] for name in ("BUILD", "CPACK", "CMAKE"))
VERSION = os.environ["ACUS_VERSION"]
CONSUMER = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "install", "consumer")
TOOLS = ["dpkg", "dpkg-deb", "dpkg-shlibdeps", "help2man"]
PACKAGES = ["acus-client", "acus-scenes", "acus-server", "libacus-dev", "libacus-engine-dev", "python3-acus", "python3-acus-engine"]
SOME_FILES = {
    "acus-server": ["usr/bin/acus-server", "usr/bin/acus-mesh", "usr/bin/acus-export",
                    "usr/lib/systemd/system/acus-server@.service", "usr/share/man/man1/acus-server.1.gz"],
    "acus-client": ["usr/bin/acus-view", "usr/share/acus/view/view.js", "usr/bin/acus-replay", "usr/bin/acus-haptic", "usr/bin/acus-keygen", "usr/bin/acus-plot", "usr/bin/acus-top", "usr/bin/acus-study", "usr/bin/acus-fit", "usr/bin/acus-cloud",
                    "usr/share/acus/client/launch", "usr/share/man/man1/acus-keygen.1.gz",
                    "usr/share/man/man1/acus-top.1.gz"],
    "libacus-dev": ["usr/include/acus/client/link/client.h", "usr/include/acus/client/haptics/kit.h",
                    "usr/lib/libacus_client.a", "usr/lib/libacus_haptics.a", "usr/lib/cmake/acus/acusConfig.cmake"],
    "libacus-engine-dev": ["usr/include/acus/server/engine/tick/simulation.h", "usr/lib/libacus_engine.a",
                           "usr/lib/cmake/acus/acusEngineTargets.cmake"],
    "python3-acus": ["usr/lib/python3/dist-packages/acus/__init__.py", "usr/lib/python3/dist-packages/acus/client.py"],
    "python3-acus-engine": [f"usr/lib/python3/dist-packages/acus_engine.{sysconfig.get_config_var('SOABI')}.so"],
    "acus-scenes": ["usr/share/acus/scenes/insertion_pullback.yaml", "usr/share/acus/scenes/meshes/prostate.msh",
                    "usr/share/acus/scenes/trajectories/through.csv", "usr/share/doc/acus/README.md"],
}


def run(*command, **settings):
    return subprocess.run(command, capture_output=True, text=True, timeout=300, check=False, **settings)


class Packages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        absent = [tool for tool in TOOLS if shutil.which(tool) is None]
        absent += [] if os.geteuid() == 0 or shutil.which("fakeroot") else ["fakeroot"]
        if absent:
            print("SKIPPED: not here: " + ", ".join(absent))
            raise unittest.SkipTest("tools")
        folder = tempfile.TemporaryDirectory(prefix="acus-packages-")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = folder.name
        packed = run(CPACK, "-G", "DEB", "-B", cls.folder, cwd=BUILD, umask=0o022)
        assert packed.returncode == 0, packed.stdout + packed.stderr
        cls.files = {os.path.basename(path).split("_")[0]: path for path in glob.glob(cls.folder + "/*.deb")}

    def assert_success(self, done):
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def field(self, package, name):
        return self.assert_success(run("dpkg-deb", "--field", self.files[package], name)).strip()

    def dpkg(self, *arguments):
        """In a root of the test's own, which has none of the packages that these depend on."""
        command = ["dpkg", "--root=" + self.root, "--force-depends", "--force-script-chrootless",
                   "--force-not-root", "--log=/dev/null", *arguments]
        return run(*([] if os.geteuid() == 0 else ["fakeroot"]), *command)

    def make_root(self):
        self.root = os.path.join(self.folder, self.id())
        for name in ("info", "updates", "triggers"):
            os.makedirs(os.path.join(self.root, "var/lib/dpkg", name))
        for name in ("status", "available"):
            open(os.path.join(self.root, "var/lib/dpkg", name), "w", encoding="utf-8").close()
        self.before = self.files_of_root()

    def files_of_root(self):
        """And folders, but for what dpkg itself keeps."""
        return sorted(os.path.join(folder, name) for folder, folders, files in os.walk(self.root)
                      for name in folders + files if "var/lib/dpkg/" not in os.path.join(folder, name))

    def installed(self, *command, **settings):
        program = os.path.join(self.root, "usr/bin", command[0])
        return run(program, *command[1:], **settings)

    def test_each_component_is_a_package_with_its_files(self):
        self.assertEqual(sorted(self.files), PACKAGES)
        for package, path in self.files.items():
            self.assertEqual(self.field(package, "Version"), VERSION + "-1")
            self.assertEqual(self.field(package, "Architecture") == "all", package in ("acus-scenes", "python3-acus"))
            listed = self.assert_success(run("dpkg-deb", "--contents", path))
            documents = [f"usr/share/doc/{package}/{name}" for name in ("copyright", "changelog.gz", "changelog.Debian.gz")]
            for file in SOME_FILES[package] + documents:
                self.assertIn(f" ./{file}", listed)

    def test_libraries_that_programs_need_are_dependencies(self):
        for library in ("libzmq5", "libcholmod", "libpugixml", "libc6"):
            self.assertIn(library, self.field("acus-server", "Depends"))
        self.assertIn("libzmq5", self.field("acus-client", "Depends"))
        self.assertIn(f"python3-acus (= {VERSION}-1)", self.field("acus-client", "Depends"))
        self.assertIn("python3-zmq", self.field("python3-acus", "Depends"))
        self.assertIn("libzmq3-dev", self.field("libacus-dev", "Depends"))

    def test_lintian_has_nothing_to_complain_of(self):
        if shutil.which("lintian") is None:
            self.skipTest("lintian is not here")
        allowed = ["--allow-root"] if os.geteuid() == 0 else []
        self.assert_success(run("lintian", *allowed, "--fail-on", "error,warning", *self.files.values()))

    def test_installed_programs_run_and_purging_leaves_nothing(self):
        self.make_root()
        self.assert_success(self.dpkg("--install", *self.files.values()))
        self.assertEqual(self.assert_success(self.installed("acus-server", "--version")).strip(), VERSION)
        self.assertIn("insertion", self.assert_success(self.installed("acus-server", "insertion_pullback", "--check")))
        self.assert_success(self.installed("acus-server", "brachytherapy", "--check"))  # whose mesh acus-mesh reads
        for program in ("acus-replay", "acus-haptic", "acus-keygen", "acus-top", "acus-export"):
            self.assertIn("--help", self.assert_success(self.installed(program, "--help")))
        modules = os.path.join(self.root, "usr/lib/python3/dist-packages")
        self.assert_success(run("/usr/bin/python3", "-c", "import acus", env={**os.environ, "PYTHONPATH": modules}))
        self.assert_success(self.dpkg("--install", *self.files.values()))  # an upgrade
        self.assert_success(self.dpkg("--remove", *PACKAGES))
        self.assert_success(self.dpkg("--purge", *PACKAGES))
        self.assertEqual(self.files_of_root(), self.before)

    def test_purging_leaves_the_administrators_scenes(self):
        self.make_root()
        self.assert_success(self.dpkg("--install", self.files["acus-server"]))
        for name, is_left in (("own.yaml", True), (None, False)):
            folder = os.path.join(self.root, "etc/acus")
            os.makedirs(folder, exist_ok=True)
            if name:
                open(os.path.join(folder, name), "w", encoding="utf-8").close()
            self.assert_success(self.dpkg("--purge", "acus-server"))
            self.assertEqual(os.path.exists(folder), is_left)
            shutil.rmtree(folder, ignore_errors=True)
            self.assert_success(self.dpkg("--install", self.files["acus-server"]))

    def test_a_program_builds_with_the_installed_library(self):
        self.make_root()
        self.assert_success(self.dpkg("--install", self.files["libacus-dev"]))
        build = os.path.join(self.folder, "consumer")
        prefix = "-DCMAKE_PREFIX_PATH=" + os.path.join(self.root, "usr")
        self.assert_success(run(CMAKE, "-S", CONSUMER, "-B", build, prefix))
        self.assert_success(run(CMAKE, "--build", build))
        self.assert_success(run(os.path.join(build, "consumer")))


if __name__ == "__main__":
    sys.exit(unittest.main())
