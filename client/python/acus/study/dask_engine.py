# SPDX-License-Identifier: MIT
"""Cases on the workers of a Dask cluster, `dask://HOST:PORT` of its scheduler, which gives what a lost worker had to others.

Cases go out in batches of a few seconds, so that messages cost little. On each thread of a Dask worker a Python of its own
runs them (workers.Worker): one that crashes takes no Dask worker with it, and keeps the scenes that it has loaded.
"""

import collections
import logging
import os
import statistics
import tempfile
import threading
import time
import uuid

from .. import engine
from ..errors import StudyError
from .case import Models, evaluate
from .portable import dumps
from .values import digest
from .workers import TRIES, Worker

SCHEME = "dask://"
CERTIFICATE, KEY = "certificate.pem", "key.pem"
ANSWERING = 10.0  # s that a scheduler may take to answer
BATCH = 2.0  # s of work in a batch
MOST = 200  # cases in a batch
AHEAD = 3  # batches under way for each thread
COUNTING = 2.0  # s between two looks at how many threads there are
LOOK, WAITING = 0.2, 60.0  # s between two looks for workers, and two lines about it
ROUNDS = 4  # of a case that comes back without a result, as machines are lost


class RemoteWork:
    """(row, recording) of a case: the bytes of its recording where it failed, or where all are kept."""

    def __init__(self, definition, timeout, recordings):
        self._definition, self._timeout, self._recordings = definition, timeout, recordings
        self._models = Models()  # of each worker

    def __call__(self, case):
        with tempfile.TemporaryDirectory(prefix="acus-case-") as folder:
            path = folder + "/case.acus"
            row = evaluate(self._definition, case, self._models, path, self._timeout)
            return row, contents(path) if row["error"] or self._recordings else None


def contents(path):
    try:
        with open(path, "rb") as file:
            return file.read()
    except FileNotFoundError:
        return None


# ---- On a Dask worker ----

here = threading.local()  # `worker` and `digest`, of what it was made with


def run_batch(work, of, limit, cases):
    """[(case, (row, recording) or None)]; None where two processes died of the case, or were killed after `limit` (s). `of`:
    digest of the work."""
    return [(case, run_case(work, of, limit, case)) for case in cases]


def run_case(work, of, limit, case):
    for _ in range(TRIES):
        if getattr(here, "digest", None) != of:
            if getattr(here, "worker", None):
                here.worker.end()
            here.worker, here.digest = Worker(work), of
        here.worker.give(case)
        if (answer := here.worker.take(limit)) is not None:
            return answer
        here.digest = None
    return None


# ---- At the user's ----


def dask_rows(work, cases, on, limit=None, tell=lambda text: None):
    """(case, (row, recording) or None) as they come; None where processes died of the case. `on`: dask://HOST:PORT. What
    it waits for is told."""
    client = connected(on)
    try:
        wait_for_workers(client, on, tell)
        yield from Batches(client, work, cases, on, limit)
    finally:
        client.close()


def connected(on):
    try:
        from distributed import Client, Security  # pylint: disable=import-outside-toplevel  # takes a second, for some users only
    except ImportError:
        raise StudyError("a Dask cluster needs Dask (apt install python3-distributed)") from None
    logging.getLogger("distributed").setLevel(logging.ERROR)  # what is lost comes again, and is told here
    try:
        folder = os.environ.get("ACUS_STUDY_TLS")  # of acus-study cluster
        certificate, key = (os.path.join(folder or "", name) for name in (CERTIFICATE, KEY))
        security = Security(tls_ca_file=certificate, tls_client_cert=certificate, tls_client_key=key, require_encryption=True) \
            if folder else None
        return Client(("tls://" if folder else "tcp://") + on.removeprefix(SCHEME), timeout=ANSWERING, set_as_default=False,
                      security=security)
    except (OSError, ValueError, TimeoutError) as error:
        raise StudyError(f"{on}: no Dask scheduler answers ({error}); start one with dask-scheduler, and workers with "
                         "dask-worker, which can import acus") from None


def wait_for_workers(client, on, tell):
    told = time.monotonic() + COUNTING
    while not client.nthreads():
        if time.monotonic() > told:
            tell(f"{on} has no workers yet; waiting for some")
            told = time.monotonic() + WAITING
        time.sleep(LOOK)


class Batches:
    """An iterator of what dask_rows() gives."""

    def __init__(self, client, work, cases, on, limit):
        self._client, self._on, self._waiting = client, on, collections.deque(cases)
        self._under_way, self._returned, self._seconds = {}, collections.Counter(), collections.deque(maxlen=50)
        self._threads, self._counted, self._limit = 1, -COUNTING, limit
        data = dumps(work)
        self._digest = digest(data)
        self._work = client.submit(bytes, data, key=f"acus-work-{self._digest[:16]}")  # once on each worker

    def __iter__(self):
        from distributed import as_completed  # pylint: disable=import-outside-toplevel
        ended = as_completed(loop=self._client.loop)
        self._fill(ended)
        for future in ended:
            yield from self._results(future)
            self._fill(ended)
        if self._waiting:
            raise StudyError(f"{self._on}: the connection is lost; the rows that came are kept, run it again to go on")

    def _fill(self, ended):
        if time.monotonic() > self._counted + COUNTING and self._client.status == "running":
            self._threads, self._counted = max(1, sum(self._client.nthreads().values())), time.monotonic()
        while self._waiting and len(self._under_way) < AHEAD * self._threads and self._client.status == "running":
            batch = [self._waiting.popleft() for _ in range(self._size())]
            future = self._client.submit(run_batch, self._work, self._digest, self._limit, batch, key=f"acus-batch-{uuid.uuid4()}")
            self._under_way[future.key] = batch
            ended.add(future)

    def _size(self):
        """Of the next batch; towards the end they become small, so that all workers end at about the same time."""
        seconds = statistics.median(self._seconds) if self._seconds else BATCH
        even = len(self._waiting) // (AHEAD * self._threads)
        return max(1, min(round(BATCH / max(seconds, 1e-3)), even, MOST, len(self._waiting)))

    def _results(self, future):
        batch = self._under_way.pop(future.key)
        error = future.exception() if future.status == "error" else None
        if future.status == "finished":
            for case, answer in future.result():
                yield case, self._checked(answer)
        elif error is not None and type(error).__name__ != "KilledWorker":
            raise StudyError(f"{self._on}: a worker cannot run cases: {type(error).__name__}: {error}; can it import acus "
                             "(PYTHONPATH) and the engine (package python3-acus-engine, or ACUS_SERVER of a build)?")
        else:
            yield from self._again(batch)

    def _again(self, batch):
        """Of a batch whose workers were lost time and again; a case that comes back too often is given up."""
        for case in reversed(batch):
            self._returned[case] += 1
            if self._returned[case] < ROUNDS:
                self._waiting.appendleft(case)
            else:
                yield case, None

    def _checked(self, answer):
        if answer is not None:
            row = answer[0]
            self._seconds.append(row["wall_time"])
            if row.get("build") not in (None, engine.build()):
                raise StudyError(f"{self._on}: a worker has another build of the engine ({row['build']}) than this program "
                                 f"({engine.build()}); install the same on all machines")
        return answer
