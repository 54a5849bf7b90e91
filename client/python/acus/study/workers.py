# SPDX-License-Identifier: MIT
"""Cases on the processors of this machine, each worker a fresh Python of its own: nothing is forked, so threads and locks
of the program that asks do not matter. A worker that dies, as of a crash or for want of memory, is replaced, and its case
runs once more; one with which a second worker dies has failed."""

import ctypes
import os
import signal
import socket
import subprocess
import sys
import traceback
from multiprocessing.connection import Connection, wait

from ..errors import StudyError
from .portable import dumps, loads

TRIES = 2  # of a case whose worker dies
ENDING = 5.0  # s that a worker may take to end
PR_SET_PDEATHSIG = 1  # of prctl(2)
BEGIN = "import sys; sys.path[:] = {path!r}; from acus.study.workers import main; main({file}, {parent})"
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}  # each: there is a worker for every processor


def processors():
    """That this process may use."""
    return len(os.sched_getaffinity(0))


def local_rows(work, cases, count):
    """(case, row) as they come, of work(case) for each, on so many workers; None for a row where workers died of it."""
    waiting, deaths = list(reversed(cases)), {}
    work = dumps(work)
    workers = []
    try:
        while waiting or any(worker.case is not None for worker in workers):
            while waiting and len(workers) < count:
                workers.append(Worker(work))
            for worker in workers:
                if worker.case is None and waiting:
                    worker.give(waiting.pop())
            busy = {worker.connection: worker for worker in workers if worker.case is not None}
            for connection in wait(list(busy)):
                worker = busy[connection]
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


class Worker:
    """`case` is the one that it works on, or None."""

    def __init__(self, work):
        here, there = socket.socketpair()
        begin = BEGIN.format(path=sys.path, file=there.fileno(), parent=os.getpid())
        with there:
            # In a session of its own: an interrupt is for the program that asks.
            self._process = subprocess.Popen([sys.executable, "-c", begin], pass_fds=[there.fileno()], start_new_session=True,
                                             stdin=subprocess.DEVNULL, env={**os.environ, **ONE_THREAD})
        self.connection, self.case = Connection(here.detach()), None
        self._send(work)

    def give(self, case):
        self.case = case
        self._send(dumps(case))

    def take(self):
        """The row of its case; None if it died. Raises StudyError for work that cannot be begun there."""
        self.case = None
        try:
            began, row = loads(self.connection.recv_bytes())
        except (EOFError, OSError):
            self.end()
            return None
        if not began:
            raise StudyError(f"a worker cannot begin: {row}")
        return row

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
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)  # with who asked it ends
    if os.getppid() != parent:
        return
    connection = Connection(file)
    try:
        work = begun(connection)
        while True:
            case = loads(connection.recv_bytes())
            connection.send_bytes(dumps((True, work(case))))
    except (EOFError, OSError):
        pass


def begun(connection):
    try:
        return loads(connection.recv_bytes())
    except (EOFError, OSError):
        raise
    except Exception as error:  # pylint: disable=broad-except  # whatever the user's modules raise
        connection.send_bytes(dumps((False, f"{error}\n{traceback.format_exc()}")))
        raise EOFError from None
