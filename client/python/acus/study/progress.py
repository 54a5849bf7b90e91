# SPDX-License-Identifier: MIT
"""How far a study is: on a terminal one line that changes, else a line now and then."""

import sys
import time

BETWEEN = {True: 0.2, False: 30.0}  # s, on a terminal and elsewhere
WIDTH = 24
MOST_ERRORS, MOST_OF_AN_ERROR = 5, 300  # shown; characters


class Progress:
    def __init__(self, total, done=0, shown=True, stream=None):
        """`done`: cases that were there before."""
        self._stream = stream or sys.stderr
        self._terminal = bool(getattr(self._stream, "isatty", bool)())
        self.total, self.done, self.failed, self._before = total, done, 0, done
        self._shown, self._began, self._told, self._width = shown, time.monotonic(), 0.0, 0
        if shown and done:
            self._write(f"{done} of {total} cases are there already\n")

    def add(self, failed=False):
        self.done, self.failed = self.done + 1, self.failed + failed
        now = time.monotonic()
        if self._shown and now - max(self._told, self._began) > BETWEEN[self._terminal]:
            self._tell(now)

    def note(self, text):
        if self._shown:
            self._write(("\r" + " " * self._width + "\r" if self._terminal else "") + text + "\n")

    def end(self, failures=()):
        """`failures`: {error: how many}, of all cases."""
        if not self._shown:
            return
        if self.total > self._before:
            self._tell(time.monotonic())
            self._write("\n" if self._terminal else "")
        for error, count in list(dict(failures).items())[:MOST_ERRORS]:
            self._write(f"  {count} failed: {error[:MOST_OF_AN_ERROR]}\n")

    def line(self, now):
        seconds = max(now - self._began, 1e-3)
        rate = (self.done - self._before) / seconds
        left = (self.total - self.done) / rate if rate else 0
        filled = round(WIDTH * self.done / self.total)
        ending = f"{duration(left)} left" if self.done < self.total else f"took {duration(seconds)}"
        return (f"[{'#' * filled}{'.' * (WIDTH - filled)}] {self.done}/{self.total} done, {self.failed} failed, "
                f"{rate:.3g} cases/s, {ending}")

    def _tell(self, now):
        self._told, line = now, self.line(now)
        self._write("\r" + line.ljust(self._width) if self._terminal else line + "\n")
        self._width = len(line)

    def _write(self, text):
        self._stream.write(text)
        self._stream.flush()


def duration(seconds):
    if seconds < 60:
        return f"{seconds:.0f} s"
    minutes, seconds = divmod(round(seconds), 60)
    return f"{minutes} min {seconds:02d} s" if minutes < 60 else f"{minutes // 60} h {minutes % 60:02d} min"
