#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""acus-study cluster: studies on jobs of Slurm, whose controller and node run here, and on processes of this machine."""

import importlib.util
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
import unittest

from small_scene import PATIENCE, ROOT, SCENE, InTemporaryFolder

from acus import engine  # noqa: E402

CASES = 100
PROGRAM = os.path.join(ROOT, "client", "study")
CONFIGURATION = """\
ClusterName=acus
SlurmctldHost={name}(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
SlurmctldPort={controller_port}
SlurmdPort={node_port}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
SchedulerType=sched/backfill
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
NodeName={name} NodeAddr=127.0.0.1 CPUs={processors} State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""
STUDY = """\
import sys
import acus
done = acus.Study(sys.argv[1], acus.Insertion(depth=0.03, speed=0.02), {{"motion.tilt": [i * 1e-3 for i in range({cases})]}},
                  folder=sys.argv[2]).run()
print(len(done.rows), sum(bool(row["error"]) for row in done.rows), done.digest)
"""


@unittest.skipUnless(engine.available() and importlib.util.find_spec("distributed") and shutil.which("dask-worker"),
                     "SKIPPED: the engine or Dask is missing (python3-distributed)")
class OnClusters(InTemporaryFolder):
    def setUp(self):
        super().setUp()
        self.environment = {**os.environ, "PYTHONPATH": os.path.join(ROOT, "client", "python")}
        self.scene = self.write("small.yaml", SCENE.format(name="small"))
        self.script = self.write("study.py", STUDY.format(cases=CASES))

    def run_cluster(self, *options, folder):
        command = [sys.executable, self.script, self.scene, self.path(folder)]
        done = subprocess.run([PROGRAM, "cluster", *options, "--host", "127.0.0.1", "--workers", "2", *command], env=self.environment,
                              cwd=self.folder, capture_output=True, text=True, timeout=10 * PATIENCE, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual([name for name in os.listdir(self.folder) if name.startswith("acus-cluster")], [])
        return done

    def serial(self):
        done = subprocess.run([sys.executable, self.script, self.scene, self.path("serial")], env=self.environment,
                              capture_output=True, text=True, check=True)
        return done.stdout

    def test_processes_of_this_machine(self):
        self.assertEqual(self.run_cluster("--local", folder="local").stdout, self.serial())

    def test_a_program_that_fails_leaves_its_status_and_no_process(self):
        done = subprocess.run([PROGRAM, "cluster", "--local", "--workers", "1", sys.executable, "-c", "raise SystemExit(7)"],
                              env=self.environment, cwd=self.folder, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 7, done.stderr)
        self.assertEqual(processes_in(self.folder), [])

    def test_it_listens_here_alone_and_ends_with_its_program_whatever_ends_that(self):
        for number in (signal.SIGHUP, signal.SIGKILL):
            cluster = subprocess.Popen([PROGRAM, "cluster", "--local", "--workers", "1", "sleep", str(PATIENCE)], env=self.environment,
                                       cwd=self.folder, stderr=subprocess.PIPE, text=True)
            self.assertIn("scheduler at dask://127.0.0.1:", cluster.stderr.readline())
            self.wait_for(lambda: sum(bool(addresses_of(pid)) for pid in processes_in(self.folder)) == 2)
            for pid in processes_in(self.folder):
                self.assertLessEqual(addresses_of(pid), {"0100007F"}, pid)  # 127.0.0.1
            cluster.send_signal(number)
            cluster.wait()
            cluster.stderr.close()
            self.wait_for(lambda: processes_in(self.folder) == [])

    @unittest.skipUnless(shutil.which("slurmctld") and shutil.which("slurmd") and shutil.which("munged"),
                         "SKIPPED: Slurm is missing (slurm-wlm, munge)")
    def test_jobs_of_slurm(self):
        self.start_slurm()
        done = self.run_cluster("--slurm", folder="slurm")
        self.assertRegex(done.stderr, r"submitted job \d+ of 2 workers")
        self.assertRegex(done.stderr, r"ended job \d+")
        self.assertEqual(done.stdout, self.serial())
        done = subprocess.run([PROGRAM, "cluster", "--slurm", "--host", "127.0.0.1", "--workers", "1", "--option=--partition=none", "true"],
                              env=self.environment, cwd=self.folder, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 2)
        self.assertIn("invalid partition", done.stderr)

    # ---- Slurm on this machine ----

    def start_slurm(self):
        name, folder = socket.gethostname().partition(".")[0], self.folder
        for each in ("state", "spool"):
            os.mkdir(self.path(each))
        with open(self.path("munge.key"), "wb") as key:
            key.write(os.urandom(128))
        os.chmod(self.path("munge.key"), 0o600)
        configuration = self.write("slurm.conf", CONFIGURATION.format(
            name=name, user=user(), folder=folder, controller_port=free_port(), node_port=free_port(), processors=os.cpu_count()))
        self.environment["SLURM_CONF"] = configuration
        self.start("munged", "--foreground", "--force", "--socket", self.path("munge.socket"), "--pid-file", self.path("munge.pid"),
                   "--log-file", self.path("munge.log"), "--seed-file", self.path("munge.seed"), "--key-file", self.path("munge.key"))
        self.wait_for(lambda: os.path.exists(self.path("munge.socket")))
        self.start("slurmctld", "-D")
        self.start("slurmd", "-D", "-N", name)
        self.wait_for(lambda: "idle" in subprocess.run(["sinfo", "-h", "-o", "%T"], env=self.environment, capture_output=True, text=True,
                                                       check=False).stdout)

    def start(self, program, *arguments):
        with open(self.path(program + ".out"), "wb") as log:
            process = subprocess.Popen([shutil.which(program), *arguments], env=self.environment, stdout=log, stderr=log)
        self.addCleanup(process.wait)
        self.addCleanup(process.terminate)

    def wait_for(self, condition):
        end = time.monotonic() + PATIENCE
        while not condition():
            self.assertLess(time.monotonic(), end)
            time.sleep(0.1)


def user():
    import pwd  # pylint: disable=import-outside-toplevel
    return pwd.getpwuid(os.getuid()).pw_name


def free_port():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return free.getsockname()[1]


def addresses_of(pid):
    """Of sockets on which a process listens, as /proc/net/tcp writes them; of IPv6 whole."""
    try:
        inodes = {os.readlink(f"/proc/{pid}/fd/{fd}").removeprefix("socket:[").rstrip("]") for fd in os.listdir(f"/proc/{pid}/fd")}
    except OSError:
        return set()
    found = set()
    for table in ("tcp", "tcp6"):
        with open(f"/proc/net/{table}", encoding="ascii") as file:
            rows = [line.split() for line in file][1:]
        found.update(row[1].partition(":")[0] for row in rows if row[3] == "0A" and row[9] in inodes)
    return found


def processes_in(folder):
    """Of those that name it in their command lines."""
    found = []
    for pid in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{pid}/cmdline", "rb") as file:
                if folder.encode() in file.read():
                    found.append(pid)
        except OSError:
            pass
    return found


if __name__ == "__main__":
    unittest.main()
