# SPDX-License-Identifier: MIT
"""Cases on the processors of this machine, each worker a fresh Python of its own: nothing is forked, so threads and locks
of the program that asks do not matter. A worker that dies, as of a crash or for want of memory, is replaced, and its case
runs once more; one with which a second worker dies has failed."""

import os
import signal
import socket
import subprocess
import sys
import threading
import time
import traceback
from multiprocessing.connection import Connection, wait

from ..errors import StudyError
from .portable import dumps, loads

TRIES = 2  # of a case whose worker dies
ENDING = 5.0  # s that a worker may take to end
GRACE = 10.0  # s that a case may take to end after its time
LOOK = 0.5  # s between two looks
BEGIN = "import sys; sys.path[:] = {path!r}; from acus.study.workers import main; main({file}, {parent})"
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}  # each: there is a worker for every processor


def processors():
    """That this process may use."""
    return len(os.sched_getaffinity(0))


def limit_of(timeout):
    """s after which the process of a case that should end by itself after `timeout` is killed; None without one."""
    return timeout + GRACE if timeout else None


def local_rows(work, cases, count, limit=None):
    """(case, row) as they come, of work(case) for each, on so many workers; None for a row where workers died of it. A
    worker that takes longer than `limit` (s) is killed, for what does not end by itself."""
    waiting, deaths = list(reversed(cases)), {}
    work = dumps(work)
    workers = []
    try:
        while waiting or any(worker.busy for worker in workers):
            while waiting and len(workers) < count:
                workers.append(Worker(work))
            for worker in workers:
                if not worker.busy and waiting:
                    worker.give(waiting.pop())
            for worker in ended_of([worker for worker in workers if worker.busy], limit):
                case = worker.case
                if (row := worker.take()) is not None:
                    yield case, row
                    continue
                workers.remove(worker)
                deaths[case] = deaths.get(case, 0) + 1
                if deaths[case] < TRIES:
                    waiting.append(case)
                else:
                    yield case, None
    finally:  # also where who asked wants no more
        for worker in workers:
            worker.end()


def ended_of(workers, limit):
    """Those that have an answer, have died, or are killed now."""
    while True:
        ready = wait([worker.connection for worker in workers], LOOK if limit else None)
        for worker in workers:
            if limit and time.monotonic() > worker.began + limit:
                worker.kill()
        if ready:
            return [worker for worker in workers if worker.connection in ready]


class Worker:
    """`case` is the one that it works on since `began`, while it is `busy`."""

    def __init__(self, work):
        here, there = socket.socketpair()
        begin = BEGIN.format(path=sys.path, file=there.fileno(), parent=os.getpid())
        with there:
            # In a session of its own: an interrupt is for the program that asks.
            self._process = subprocess.Popen([sys.executable, "-c", begin], pass_fds=[there.fileno()], start_new_session=True,
                                             stdin=subprocess.DEVNULL, env={**os.environ, **ONE_THREAD})
        self.connection, self.case, self.busy, self.began = Connection(here.detach()), None, False, 0.0
        self._send(work)

    def give(self, case):
        self.case, self.busy, self.began = case, True, time.monotonic()
        self._send(dumps(case))

    def take(self, limit=None):
        """The row of its case; None if it died, or took longer than `limit` (s) in this call. Raises StudyError for work
        that cannot be begun there, or could not go on."""
        self.busy = False
        try:
            if limit and not self.connection.poll(limit):
                self.end()
                return None
            went_well, row = loads(self.connection.recv_bytes())
        except (EOFError, OSError):
            self.end()
            return None
        if not went_well:
            raise StudyError(f"a worker cannot go on: {row}")
        return row

    def kill(self):
        """Which take() finds."""
        self._process.kill()

    def end(self):
        self.connection.close()
        self._process.kill()
        self._process.wait(ENDING)

    def _send(self, message):
        try:
            self.connection.send_bytes(message)
        except OSError:
            pass  # it has died, which take() finds


def main(file, parent):
    """Of a worker: the work first, then a case after the other, until there are no more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=end_with, args=(parent,), daemon=True).start()
    connection = Connection(file)
    try:
        work = None
        while True:
            message = connection.recv_bytes()
            try:
                if work is None:
                    work = loads(message)
                    continue
                answer = dumps((True, work(loads(message))))
            except Exception as error:  # pylint: disable=broad-except  # what is no case's own: modules, disks
                answer = dumps((False, f"{type(error).__name__}: {error}\n{traceback.format_exc()}"))
            connection.send_bytes(answer)
    except (EOFError, OSError):
        pass


def end_with(parent):
    """Ends this process when the one that started it has gone, whatever is under way."""
    while os.getppid() == parent:
        time.sleep(LOOK)
    os._exit(1)
