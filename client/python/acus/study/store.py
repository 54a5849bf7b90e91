# SPDX-License-Identifier: MIT
"""The folder of a study. rows.jsonl has a line per case that has run, written in one piece as it comes; of two lines of a
case the later one counts. What was interrupted in the middle of a line is left out and comes again."""

import fcntl
import json
import os
import time

from .. import own_files
from ..errors import StudyError
from .case import MEASURED, RESULT

SYNCHRONISE = 1.0  # s: rows of this long may be lost if the whole machine fails; if a program does, none


def is_table(data):
    """As Study.write() writes it: CSV, or Parquet."""
    if data.startswith(b"PAR1"):
        from pyarrow import BufferReader, parquet  # pylint: disable=import-outside-toplevel  # it was there to write it
        data = ",".join(parquet.read_schema(BufferReader(data)).names).encode()
    return own_files.has_columns(("case",), (*RESULT, *MEASURED))(data)


def are_rows(data):
    """Any of them: a line may be cut."""
    return data.startswith(FIRST) or any(map(row_of, data.split(b"\n")))


FIRST = b'{"key": '  # of every line
FILES = {"rows.jsonl": are_rows, "study.json": own_files.is_signed, "scene.yaml": own_files.is_sealed, "table.csv": is_table}


class Store:
    def __init__(self, folder):
        self.folder = os.path.abspath(folder)
        self.path = os.path.join(self.folder, "rows.jsonl")
        self.cases = os.path.join(self.folder, "cases")
        self._file, self._synchronised = None, 0.0

    def read(self):
        """{key: row}, of all that has run here."""
        rows = {}
        try:
            with open(self.path, "rb") as file:
                for line in file:
                    if row := row_of(line):
                        rows[row["key"]] = row["row"]
        except FileNotFoundError:
            pass
        except OSError as error:
            raise StudyError(f"{self.path}: {error.strerror}") from None
        return rows

    def __enter__(self):
        """To write; only one process may. Raises StudyError."""
        for name, is_own in FILES.items():
            own_files.check(os.path.join(self.folder, name), is_own, StudyError, "give the study another folder")
        try:
            os.makedirs(self.folder, exist_ok=True)
            self._file = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC, 0o644)
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            size = os.fstat(self._file).st_size
            if size and os.pread(self._file, 1, size - 1) != b"\n":
                os.write(self._file, b"\n")
        except BlockingIOError:
            self.__exit__()
            raise StudyError(f"{self.folder}: another program runs a study in this folder") from None
        except OSError as error:
            self.__exit__()
            raise StudyError(f"{self.folder}: {error.strerror}") from None
        return self

    def __exit__(self, *_):
        if self._file is not None:
            os.close(self._file)
        self._file = None

    def write(self, key, row):
        line = json.dumps({"key": key, "row": row}).encode() + b"\n"
        try:
            if os.write(self._file, line) != len(line):
                raise OSError(0, "the disk is full")
            if time.monotonic() > self._synchronised + SYNCHRONISE:
                os.fsync(self._file)
                self._synchronised = time.monotonic()
        except OSError as error:
            raise StudyError(f"{self.path}: {error.strerror}; the rows before are whole, run it again to go on") from None

    def recording(self, key):
        """Where a case leaves its recording, and the text of its error beside it."""
        return os.path.join(self.cases, key + ".acus")

    def note_failure(self, key, text):
        self._write_file(self._text(key), text.encode())

    def keep_recording(self, key, recording):
        self._write_file(self.recording(key), recording)

    def part(self, key):
        """Where a recording is made, until the case has ended."""
        return self.recording(key) + ".part"

    def keep_part(self, key):
        if os.path.exists(self.part(key)):
            os.replace(self.part(key), self.recording(key))

    def forget(self, key, recording):
        """The text of an error, and the recording, too."""
        remove(self._text(key))
        if recording:
            remove(self.recording(key))

    def note_definition(self, told, scene):
        for name, data in (("study.json", own_files.signed(told)), ("scene.yaml", own_files.sealed(scene))):
            own_files.write(os.path.join(self.folder, name), data, FILES[name], StudyError, "give the study another folder")

    def _text(self, key):
        return self.recording(key).removesuffix(".acus") + ".txt"

    @staticmethod
    def _write_file(path, data):
        try:
            os.makedirs(os.path.dirname(path), exist_ok=True)
            with open(path, "wb") as file:
                file.write(data)
        except OSError as error:
            raise StudyError(f"{path}: {error.strerror}; the rows before are whole, run it again to go on") from None


def row_of(line):
    """None of what is no whole line."""
    try:
        row = json.loads(line)
        return row if isinstance(row, dict) and isinstance(row.get("row"), dict) and "key" in row else None
    except ValueError:
        return None


def remove(path):
    try:
        os.remove(path)
    except FileNotFoundError:
        pass
    except OSError as error:
        raise StudyError(f"{path}: {error.strerror}") from None
