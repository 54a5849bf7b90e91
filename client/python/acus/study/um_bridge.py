# SPDX-License-Identifier: MIT
"""A study's motion and outputs as a model of UM-Bridge, HTTP and JSON that tools of uncertainty quantification speak:
https://um-bridge-benchmarks.readthedocs.io, protocol 1.0.

One model, `forward`: one input vector, the study's parameters in their order; one output vector, the columns of its outputs.
There are no derivatives. A request that cannot be answered gets {"error": {"type", "message"}}: ModelNotFound, InvalidInput
and UnsupportedFeature with status 400, InvalidOutput (of a case that failed, or an output that is no finite number) with
500.

A web page of any site can make a browser ask, of this machine too. What it can send without being let is refused: another
site in Origin, a name in Host that is not this machine's, a body that is not said to be JSON (status 403, 415). Connections
that send no request keep none out that do: of more than MOST_WAITING the one that has waited longest is ended.
"""

import copy
import ipaddress
import json
import math
import queue
import socket
import threading
from contextlib import suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

from urllib.parse import urlsplit

from ..errors import AcusError, StudyError
from .case import Models, evaluate, output_columns
from .designs import Design
from .portable import dumps
from .workers import TRIES, Worker, limit_of

MODEL, PROTOCOL, PORT = "forward", 1.0, 4242
MOST_BYTES, MOST_DISCARDED = 1 << 20, 1 << 26  # of a request
SILENCE = 60.0  # s after which a connection without a request ends
MOST_WAITING = 64  # connections without a whole request
FEATURES = ("Evaluate", "Gradient", "ApplyJacobian", "ApplyHessian")


class Trouble(Exception):
    """What a request cannot have, as it is answered."""

    def __init__(self, kind, message, status=400):
        super().__init__(message)
        self.kind, self.status = kind, status


class ValuesWork:
    """The row of a case that is given by its values."""

    def __init__(self, definition, timeout):
        self._definition, self._timeout, self._models = definition, timeout, Models()

    def __call__(self, values):
        return evaluate(case_of(self._definition, values), 0, self._models, None, self._timeout)


def case_of(definition, values):
    """A Definition of one case, with the values of a request. Whole numbers stay such where the study has them."""
    examples = definition.design.rows[0]
    values = [round(value) if isinstance(example, int) and value == round(value) else value
              for value, example in zip(values, examples)]
    one = copy.copy(definition)
    one.__dict__.pop("repetitions", None)
    one.design = Design("request", definition.design.names, [values])
    return one


class Model:
    """`inputs` and `outputs` are names. evaluate() may be called by several threads; as many cases run at once as there
    are workers. Raises StudyError where the study's first case fails or has an output that is no number."""

    def __init__(self, definition, workers, timeout=None):
        for name, value in zip(definition.design.names, definition.design.rows[0]):
            if isinstance(value, bool) or not isinstance(value, (int, float)):
                raise StudyError(f"UM-Bridge: parameters have to be numbers, and {name} is {value!r}")
        self.inputs = definition.design.names
        self._work, self._idle = dumps(ValuesWork(definition, timeout)), queue.SimpleQueue()
        self._limit = limit_of(timeout)
        self._workers, self._lock, self._closed = set(), threading.Lock(), False
        try:
            for _ in range(workers):
                self._add()
            self.outputs = self._columns(definition)
        except BaseException:
            self.close()
            raise

    def close(self):
        """Cases under way end without an answer. May be called again."""
        with self._lock:
            workers = [] if self._closed else list(self._workers)
            self._closed = True
        for worker in workers:
            worker.kill()
        for _ in workers:  # each comes back to the idle ones, dead
            self._idle.get().end()

    def evaluate(self, values):
        """The list of outputs. Raises Trouble."""
        row = self._run(values)
        if row is None or row["error"]:
            raise Trouble("InvalidOutput", row["error"] if row else "the process died of this case", 500)
        outputs = [row.get(name) for name in self.outputs]
        for name, value in zip(self.outputs, outputs):
            if not is_number(value):
                raise Trouble("InvalidOutput", f"{name} is {value!r} and no finite number", 500)
        return [float(value) for value in outputs]

    def _run(self, values):
        for _ in range(TRIES):
            worker = self._idle.get()
            try:
                worker.give(values)
                if (row := worker.take(self._limit)) is not None:
                    return row
                worker = self._replaced(worker)
            finally:
                self._idle.put(worker)
            if self._closed:
                raise Trouble("InvalidOutput", "the server ends", 500)
        return None

    def _replaced(self, worker):
        """Another one, unless the server ends."""
        with self._lock:
            if self._closed:
                return worker
            self._workers.remove(worker)
            worker = Worker(self._work)
            self._workers.add(worker)
            return worker

    def _add(self):
        worker = Worker(self._work)
        self._workers.add(worker)
        self._idle.put(worker)

    def _columns(self, definition):
        row = self._run([float(value) for value in definition.design.rows[0]])
        if row is None or row["error"]:
            raise StudyError(f"UM-Bridge: the study's first case failed: {row['error'] if row else 'its process died'}")
        known = output_columns(row, self.inputs)
        texts = [name for name in known if not isinstance(row[name], (int, float))]
        if texts:
            raise StudyError(f"UM-Bridge: outputs have to be numbers, and {texts[0]} is {row[texts[0]]!r}")
        return known


def is_number(value):
    try:
        return isinstance(value, (bool, int, float)) and math.isfinite(value)
    except OverflowError:  # a whole number that no float holds
        return False


class Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    timeout = SILENCE
    model = None  # of the class that a server makes of this

    def setup(self):
        super().setup()
        self.server.waiting.add(self.connection)

    def finish(self):
        self.server.waiting.remove(self.connection)
        super().finish()

    def do_GET(self):  # pylint: disable=invalid-name
        try:
            self._check_sender()
        except Trouble as trouble:
            self._refuse(trouble)
            return
        self._answer("Info" if self.path.strip("/") in ("", "Info") else None, {})

    do_HEAD = do_GET

    def do_POST(self):  # pylint: disable=invalid-name
        try:
            request = self._request()
        except Trouble as trouble:
            self._refuse(trouble)
            return
        self._answer(self.path.strip("/"), request)

    def _refuse(self, trouble):
        self.close_connection = True
        self._send(trouble.status, told(trouble))

    def _check_sender(self):
        for host in self.headers.get_all("Host", []):
            if not self.server.is_name(host):
                raise Trouble("InvalidInput", f"Host: expected the address of this machine or its name, found {host!r}", 403)
            for origin in self.headers.get_all("Origin", []):
                if origin != f"http://{host}":
                    raise Trouble("InvalidInput", f"Origin: web pages are not answered, found {origin!r}", 403)

    def _request(self):
        try:
            size = int(self.headers.get("Content-Length", ""))
        except ValueError:
            raise Trouble("InvalidInput", "expected a request with a Content-Length") from None
        try:
            self._check_sender()
            if self.headers.get_content_type() != "application/json" and "Content-Type" in self.headers:
                raise Trouble("InvalidInput", f"Content-Type: expected application/json, found {self.headers['Content-Type']!r}", 415)
            if not 0 <= size <= MOST_BYTES:
                raise Trouble("InvalidInput", f"expected a request of at most {MOST_BYTES} bytes", 413)
        except Trouble:
            self._take_in(size)
            raise
        try:
            request = json.loads(self.rfile.read(size) or b"{}")
        except (ValueError, RecursionError) as error:
            raise Trouble("InvalidInput", f"no JSON: {error}") from None
        if not isinstance(request, dict):
            raise Trouble("InvalidInput", "expected a map")
        return request

    def _take_in(self, size):
        """What a client sends that gets an error, so that it reads that; not endlessly."""
        left = min(size, MOST_DISCARDED)
        while left > 0 and (part := self.rfile.read(min(left, MOST_BYTES))):
            left -= len(part)

    def _answer(self, what, request):
        self.server.waiting.remove(self.connection)
        try:
            self._send(200, self._answered(what, request))
        except Trouble as trouble:
            self._send(trouble.status, told(trouble))
        except AcusError as error:
            self._send(500, told(Trouble("InvalidOutput", str(error))))
        self.server.waiting.add(self.connection)

    def _answered(self, what, request):
        if what == "Info":
            return {"protocolVersion": PROTOCOL, "models": [MODEL]}
        if what not in ("ModelInfo", "InputSizes", "OutputSizes", *FEATURES):
            raise Trouble("InvalidInput", f"there is no {self.path}", 404)
        if request.get("name") != MODEL:
            raise Trouble("ModelNotFound", f"there is no model {request.get('name')!r}, only '{MODEL}'")
        if what == "ModelInfo":
            return {"support": {feature: feature == "Evaluate" for feature in FEATURES}}
        if what == "InputSizes":
            return {"inputSizes": [len(self.model.inputs)]}
        if what == "OutputSizes":
            return {"outputSizes": [len(self.model.outputs)]}
        if what != "Evaluate":
            raise Trouble("UnsupportedFeature", f"{what}: the model has no derivatives")
        return {"output": [self.model.evaluate(self._input(request))]}

    def _input(self, request):
        vectors, size = request.get("input"), len(self.model.inputs)
        if not isinstance(vectors, list) or len(vectors) != 1 or not isinstance(vectors[0], list) or len(vectors[0]) != size:
            raise Trouble("InvalidInput", f"expected one vector of {size} numbers: {', '.join(self.model.inputs)}")
        for name, value in zip(self.model.inputs, vectors[0]):
            if isinstance(value, bool) or not is_number(value):
                raise Trouble("InvalidInput", f"{name}: expected a finite number, found {value!r}")
        return [float(value) for value in vectors[0]]

    def _send(self, status, answer):
        body = json.dumps(answer).encode()
        self.send_response(status)
        self.send_header("Content-Type", "application/json")
        self.send_header("Content-Length", str(len(body)))
        try:
            self.end_headers()
            self.wfile.write(body if self.command != "HEAD" else b"")
        except ConnectionError:  # nobody reads it
            self.close_connection = True

    def log_message(self, *_):  # pylint: disable=arguments-differ  # a line a request would be too many
        pass


def told(trouble):
    return {"error": {"type": trouble.kind, "message": str(trouble)}}


class Waiting:
    """Connections without a whole request, in the order in which they began to wait. One too many ends the first."""

    def __init__(self):
        self._connections, self._lock = {}, threading.Lock()

    def add(self, connection):
        with self._lock:
            self._connections[connection] = None
            if len(self._connections) > MOST_WAITING:
                first = next(iter(self._connections))
                del self._connections[first]
                with suppress(OSError):
                    first.shutdown(socket.SHUT_RDWR)  # its thread reads the end

    def remove(self, connection):
        with self._lock:
            self._connections.pop(connection, None)


class ModelServer(ThreadingHTTPServer):
    """Listens when it is made; serve_forever() answers, and the `with` block ends its workers. Raises StudyError."""

    daemon_threads = True
    request_queue_size = 128

    def __init__(self, definition, host="127.0.0.1", port=PORT, workers=1, timeout=None):
        self.waiting = Waiting()
        self.names = {"localhost", host.lower(), socket.gethostname().lower()}
        self.model = Model(definition, workers, timeout)
        try:
            super().__init__((host, port), type("ModelHandler", (Handler,), {"model": self.model}))
        except (OSError, OverflowError) as error:
            self.model.close()
            raise StudyError(f"{host}:{port}: {getattr(error, 'strerror', None) or error}") from None

    def is_name(self, host):
        """Whether a Host is an address, which no other site has, or a name of this machine; whatever the port."""
        with suppress(ValueError):
            name = urlsplit(f"//{host}").hostname or ""
            if name in (*self.names, self.server_name.lower()):
                return True
            ipaddress.ip_address(name)
            return True
        return False

    def server_close(self):
        super().server_close()
        self.model.close()
