# SPDX-License-Identifier: MIT
"""Ends a child process and removes its folder when this program is gone, whatever ended it: a shell reads from a pipe whose
other end only this program has."""

import subprocess

# $1: the child, $2: its folder, which stands on its command line, so that no other process of that number is meant.
SCRIPT = """\
trap '' HUP INT TERM
read -r line
is_there() { tr '\\0' '\\n' <"/proc/$1/cmdline" | grep -qF -- "$2"; }
if is_there "$1" "$2" 2>/dev/null; then
  kill "$1"
  for look in $(seq 100); do
    is_there "$1" "$2" 2>/dev/null || break
    sleep 0.1
  done
  is_there "$1" "$2" 2>/dev/null && kill -KILL "$1"
fi
rm -rf -- "$2"
"""


class Guard:
    def __init__(self, pid, folder):
        self._shell = subprocess.Popen(["/bin/sh", "-c", SCRIPT, "acus-guard", str(pid), folder], stdin=subprocess.PIPE,
                                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)

    def end(self):
        """Without doing anything; may be called again."""
        self._shell.kill()
        self._shell.wait()
        self._shell.stdin.close()
