# SPDX-License-Identifier: MIT
"""Files that the package writes: whole ones, which replace nothing but files that show to be the package's own.

What shows it depends on the kind of file. Scenes and trajectories, which people edit, begin with a comment that has a hash of
the rest: an edited one is nobody's own. JSON has its writer in the first field, pictures in their metadata, a table its
columns.
"""

import contextlib
import csv
import hashlib
import io
import json
import os
import re
import secrets
import stat

from .errors import AcusError

WRITER = "Acus"
SEAL = re.compile(rb"# Written by Acus, ([0-9a-f]{16}): replaced by what wrote it as long as nobody edits it\n")
PICTURES = {".png": ("Software", b"\x89PNG", b"tEXtSoftware\0" + WRITER.encode()),  # field of the metadata, what stands in the file
            ".svg": ("Creator", b"<?xml", b"<dc:title>" + WRITER.encode() + b"</dc:title>"),
            ".pdf": ("Creator", b"%PDF", b"/Creator (" + WRITER.encode() + b")")}
ANOTHER_NAME = "give another name, or remove it"


def check(path, is_own, error=AcusError, remedy=ANOTHER_NAME):
    """Raises `error` if writing to the path would lose something: a file with content that is_own(bytes) does not know."""
    try:
        if not os.path.isfile(path) or os.path.getsize(path) == 0:
            return
        with open(path, "rb") as file:
            if is_own(file.read()):
                return
    except OSError as trouble:
        raise error(f"{path}: {trouble.strerror}") from None
    raise error(f"{path}: something else stands there, or it was edited, and would be lost; {remedy}")


def write(path, data, is_own, error=AcusError, remedy=ANOTHER_NAME):
    """The bytes, in the place of what check() lets be replaced: all or nothing. Raises `error`."""
    path = os.fspath(path)
    check(path, is_own, error, remedy)
    try:
        if os.path.exists(path) and not os.path.isfile(path):
            with open(path, "wb") as file:  # a pipe or device
                file.write(data)
        else:
            put_in_place(os.path.realpath(path), data)
    except OSError as trouble:
        raise error(f"{path}: {trouble.strerror}") from None


def put_in_place(path, data):
    part = f"{path}.{secrets.token_hex(4)}.part"
    try:
        with open(part, "xb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        with contextlib.suppress(FileNotFoundError):
            os.chmod(part, stat.S_IMODE(os.stat(path).st_mode))
        os.replace(part, path)
    except BaseException:
        with contextlib.suppress(FileNotFoundError):
            os.remove(part)
        raise


# ---- Kinds ----


def sealed(text):
    """Text whose comments begin with #, as bytes."""
    rest = text.encode()
    return b"# Written by Acus, " + hash_of(rest) + b": replaced by what wrote it as long as nobody edits it\n" + rest


def is_sealed(data):
    seal = SEAL.match(data)
    return bool(seal) and hash_of(data[seal.end():]) == seal[1]


def hash_of(data):
    return hashlib.sha256(data).hexdigest()[:16].encode()


def signed(fields):
    """A map as JSON."""
    return json.dumps({"written_by": WRITER, **fields}, indent=2).encode() + b"\n"


def is_signed(data):
    return data.startswith(b'{\n  "written_by": "' + WRITER.encode() + b'"')


def has_columns(first, last):
    """Of a CSV: whether its header begins and ends with these names."""
    def is_own(data):
        names = data.partition(b"\n")[0].decode(errors="replace").strip().split(",")
        return names[:len(first)] == list(first) and names[len(names) - len(last):] == list(last)
    return is_own


def table_of(columns, rows):
    """CSV, as bytes."""
    text = io.StringIO(newline="")
    csv.writer(text, lineterminator="\n").writerows([columns, *rows])
    return text.getvalue().encode()


def is_picture(data):
    return any(data.startswith(kind) and mark in data for _, kind, mark in PICTURES.values())


def write_image(path, image, error=AcusError):
    """An image of pillow, as .png."""
    from PIL.PngImagePlugin import PngInfo  # pylint: disable=import-outside-toplevel  # with matplotlib
    if not os.fspath(path).lower().endswith(".png"):
        raise error(f"{path}: expected a name that ends with .png")
    data, information = io.BytesIO(), PngInfo()
    information.add_text(PICTURES[".png"][0], WRITER)
    image.save(data, format="png", optimize=True, pnginfo=information)
    write(path, data.getvalue(), is_picture, error)
