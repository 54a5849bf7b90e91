# SPDX-License-Identifier: MIT
"""Runs programs with studies (acus.Study) on a cluster, serves a study to other tools, and says how far studies are.

  acus-study cluster --slurm --workers 20 --option=--partition=short python3 spread.py
  acus-study cluster --local --workers 2 python3 spread.py
  acus-study serve model.py --port 4242
  acus-study show studies/steering_arc

`cluster` starts a Dask scheduler on this machine and workers, with Slurm as an array of jobs, runs the program, whose
studies find the scheduler by themselves (ACUS_STUDY_ON), and ends all that it started when the program ends. Needs Dask
(python3-distributed) on all machines, and with Slurm a folder that all of them see.

`serve` runs a Python program that sets `study` to an acus.Study, and answers requests of UM-Bridge: one vector of its
parameters in, one of its outputs out. Whoever reaches the port can ask for cases; it is one of this machine by default.

Exit status: that of the program; 1 bad arguments, or a folder without a study; 2 the cluster could not be started.
"""

import argparse
import collections
import json
import os
import runpy
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time

from acus.apps.arguments import BAD_ARGUMENTS, Arguments, whole_number
from acus.errors import AcusError
from acus.guard import Guard
from acus.study import Study
from acus.study.dask_engine import CERTIFICATE, KEY
from acus.study.store import Store
from acus.study.um_bridge import PORT

NO_CLUSTER = 2
STARTING = 30.0  # s until the scheduler listens
ENDING = 10.0  # s
LOOK = 0.1  # s between two looks
DEATH = 60  # s after which a worker without a scheduler ends
SILENT = ("--no-dashboard", "--dashboard-address", "127.0.0.1:0")
NEEDED = {"dask-scheduler": "python3-distributed", "dask-worker": "python3-distributed", "openssl": "openssl"}  # and its package
SLURM = ("sbatch", "scancel")
PASSED_ON = ("PYTHONPATH", "ACUS_SERVER", "PATH")  # to workers on other machines


class NoCluster(AcusError):
    """What could not be started; str() is a sentence."""


def parse_arguments():
    parser = Arguments(prog="acus-study", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    cluster = commands.add_parser("cluster", help="run a program whose studies use many machines")
    where = cluster.add_mutually_exclusive_group(required=True)
    where.add_argument("--slurm", action="store_true", help="workers are an array of jobs, submitted with sbatch")
    where.add_argument("--local", action="store_true", help="workers are processes of this machine")
    cluster.add_argument("--workers", type=whole_number, required=True, help="how many")
    cluster.add_argument("--threads", type=whole_number, default=1, help="cases at once on each (default: 1)")
    cluster.add_argument("--host", help="address that the scheduler listens on (default: all of this machine; --local: 127.0.0.1)")
    cluster.add_argument("--option", action="append", default=[], metavar="OPTION",
                         help="of sbatch, such as --option=--time=2:00:00; may be given again")
    cluster.add_argument("--folder", default=".", help="for logs, seen by all machines (default: the current one)")
    cluster.add_argument("program", nargs=argparse.REMAINDER, help="and its arguments")
    serve = commands.add_parser("serve", help="answer requests of UM-Bridge")
    serve.add_argument("file", help="a Python program that sets `study`")
    serve.add_argument("--port", type=int, default=PORT, help="(default: %(default)s)")
    serve.add_argument("--host", default="127.0.0.1", help="address to listen on (default: %(default)s)")
    serve.add_argument("--workers", type=whole_number, help="cases at once (default: one for each processor)")
    serve.add_argument("--timeout", type=float, metavar="SECONDS", help="of a case (default: none)")
    show = commands.add_parser("show", help="how far studies are")
    show.add_argument("folder", nargs="+")
    arguments = parser.parse_args()
    if arguments.command == "cluster" and not arguments.program:
        cluster.error("expected a program to run, such as: python3 spread.py")
    if arguments.command == "cluster" and arguments.local and arguments.option:
        cluster.error("--option: is for --slurm")
    return arguments


# ---- Cluster ----


class Cluster:
    """Scheduler and workers in a `with` block; `address` is dask://HOST:PORT."""

    def __init__(self, arguments):
        self._arguments, self._processes, self._guards, self._job = arguments, [], [], None
        for program in (*NEEDED, *(SLURM if arguments.slurm else ())):
            if not shutil.which(program):
                raise NoCluster(f"{program} is not there (apt install {NEEDED.get(program, 'slurm-client')})")
        self.folder = tempfile.mkdtemp(prefix="acus-cluster-", dir=os.path.abspath(arguments.folder))
        self._file = os.path.join(self.folder, "scheduler.json")

    def __enter__(self):
        try:
            host = self._arguments.host or ("127.0.0.1" if self._arguments.local else None)
            self._make_certificate()
            self._start("scheduler", "dask-scheduler", "--port", "0", "--scheduler-file", self._file, "--protocol", "tls",
                        *SILENT, *self._tls(), *(["--host", host] if host else []))
            self.address = self._wait_for_address()
            print(f"acus-study: scheduler at {self.address}", file=sys.stderr)
            if self._arguments.slurm:
                self._submit()
            else:
                for number in range(1, self._arguments.workers + 1):
                    self._start(f"worker-{number}", *self._worker())
            return self
        except BaseException:
            self.__exit__(*sys.exc_info())
            raise

    def __exit__(self, kind, *_):
        if self._job:
            subprocess.run(["scancel", self._job], check=False)
            print(f"acus-study: ended job {self._job}", file=sys.stderr)
        for guard in self._guards:
            guard.end()
        for process in reversed(self._processes):
            process.terminate()
        for process in self._processes:
            try:
                process.wait(ENDING)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        if kind is None:
            shutil.rmtree(self.folder, ignore_errors=True)
        else:
            print(f"acus-study: logs are in {self.folder}", file=sys.stderr)

    def _worker(self):
        return ["dask-worker", "--scheduler-file", self._file, "--protocol", "tls", "--nthreads", str(self._arguments.threads),
                "--no-nanny", "--death-timeout", str(DEATH), "--local-directory", self.folder, *SILENT, *self._tls(),
                *(["--host", "127.0.0.1"] if self._arguments.local else [])]

    def _make_certificate(self):
        """Who has it, from the folder that only this user reads, can ask scheduler and workers; nobody else."""
        done = subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "365", "-subj", "/CN=acus-study",
                               "-keyout", os.path.join(self.folder, KEY), "-out", os.path.join(self.folder, CERTIFICATE)],
                              capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise NoCluster(f"openssl ended with status {done.returncode}: {done.stderr.strip()}")

    def _tls(self):
        certificate, key = (os.path.join(self.folder, name) for name in (CERTIFICATE, KEY))
        return ["--tls-ca-file", certificate, "--tls-cert", certificate, "--tls-key", key]

    def _start(self, name, *command):
        with open(os.path.join(self.folder, name + ".log"), "wb") as log:
            self._processes.append(subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                                                    start_new_session=True))
        self._guards.append(Guard(self._processes[-1].pid, self.folder))

    def _wait_for_address(self):
        end = time.monotonic() + STARTING
        while time.monotonic() < end and self._processes[0].poll() is None:
            try:
                with open(self._file, encoding="utf-8") as file:
                    return "dask://" + json.load(file)["address"].removeprefix("tls://")
            except (FileNotFoundError, ValueError):
                time.sleep(LOOK)
        raise NoCluster("the Dask scheduler does not start")

    def _submit(self):
        script = os.path.join(self.folder, "workers.sh")
        with open(script, "w", encoding="utf-8") as file:
            file.write(self._job_script())
        done = subprocess.run(["sbatch", "--parsable", *self._arguments.option, script], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise NoCluster(f"sbatch ended with status {done.returncode}: {done.stderr.strip()}")
        self._job = done.stdout.strip().partition(";")[0]
        print(f"acus-study: submitted job {self._job} of {self._arguments.workers} workers", file=sys.stderr)

    def _job_script(self):
        passed_on = "".join(f"export {name}={shlex.quote(os.environ[name])}\n" for name in PASSED_ON if name in os.environ)
        return (f"#!/bin/sh\n#SBATCH --job-name=acus-study\n#SBATCH --array=1-{self._arguments.workers}\n"
                f"#SBATCH --cpus-per-task={self._arguments.threads}\n"
                f"#SBATCH --output={self.folder}/worker-%a.log\n{passed_on}exec {shlex.join(self._worker())}\n")


def run_on_cluster(arguments):
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda received, _: sys.exit(128 + received))
    with Cluster(arguments) as cluster:
        program = subprocess.Popen(arguments.program, env={**os.environ, "ACUS_STUDY_ON": cluster.address, "ACUS_STUDY_TLS": cluster.folder})
        try:
            return program.wait()
        except KeyboardInterrupt:  # the program has it, too, and keeps its rows
            return program.wait()
        finally:
            if program.poll() is None:
                program.terminate()
                program.wait()


# ---- Serve ----


def serve_file(arguments):
    try:
        study = runpy.run_path(arguments.file, run_name="acus_study_file").get("study")
    except OSError as error:
        raise AcusError(f"{arguments.file}: {error.strerror}") from None
    if not isinstance(study, Study):
        raise AcusError(f"{arguments.file}: expected that it sets `study` to an acus.Study")
    with study.model_server(arguments.port, host=arguments.host, workers=arguments.workers, timeout=arguments.timeout) as server:
        print(f"acus-study: http://{arguments.host}:{server.server_port}, model 'forward': {', '.join(server.model.inputs)} -> "
              f"{', '.join(server.model.outputs)}", flush=True)
        signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            return 0


# ---- Show ----


def show(folder):
    """Lines about a study."""
    try:
        with open(os.path.join(folder, "study.json"), encoding="utf-8") as file:
            told = json.load(file)
    except (OSError, ValueError):
        raise AcusError(f"{folder}: no study is there") from None
    rows = list(Store(folder).read().values())
    errors = collections.Counter(row["error"] for row in rows if row["error"])
    lines = [f"{folder}: a {told['design']} of {told['cases']} cases, {len(rows)} have run in this folder, {errors.total()} failed"]
    return lines + [f"  {count} failed: {error[:300]}" for error, count in errors.most_common(5)]


def main():
    arguments = parse_arguments()
    try:
        if arguments.command == "cluster":
            return run_on_cluster(arguments)
        if arguments.command == "serve":
            return serve_file(arguments)
        for folder in arguments.folder:
            print("\n".join(show(folder)))
        return 0
    except FileNotFoundError as error:
        print(f"acus-study: {error.filename}: there is no such program", file=sys.stderr)
        return NO_CLUSTER
    except NoCluster as error:
        print(f"acus-study: {error}", file=sys.stderr)
        return NO_CLUSTER
    except AcusError as error:
        print(f"acus-study: {error}", file=sys.stderr)
        return BAD_ARGUMENTS
