# SPDX-License-Identifier: MIT
"""Tables of text with a header, as spreadsheets, testing machines and Acus write them.

Found out: a byte-order mark, what stands between cells (comma, semicolon, tab, spaces), whether the decimal sign is a point
or a comma. Blank lines and lines that begin with #, % or // are left out. Numbers with grouped digits are none: 1,234 may
be two numbers.
"""

import csv
import dataclasses
import io
import math
import os
import re

SEPARATORS = {"\t": "tabs", ";": "';'", ",": "','", " ": "spaces"}
COMMENTS = ("#", "%", "//")
LOOKED_AT = 20  # lines, for what stands between cells
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.IGNORECASE)
WITH_COMMA = re.compile(r"[+-]?\d*,\d+(e[+-]?\d+)?", re.IGNORECASE)
ABSENT = {"", "nan", "na", "n/a", "-", "--", "null", "none"}  # cells without a value
MARKS = {b"\xff\xfe": "UTF-16", b"\xfe\xff": "UTF-16", b"PK\x03\x04": "a workbook", b"\xd0\xcf\x11\xe0": "a workbook"}


@dataclasses.dataclass
class Table:
    """`lines`: where each of the rows stands in the file, from 1; `header_line` likewise. `error`: what it raises."""

    path: str
    error: type
    header: list
    header_line: int
    rows: list
    lines: list
    separator: str

    def column(self, name):
        """Where it stands in a row. Raises `error` where it is missing or there twice."""
        places = [i for i, each in enumerate(self.header) if each == name]
        if len(places) == 1:
            return places[0]
        told = f"a second column '{name}'; each has to have its own name" if places else f"it has no column '{name}'; it has {', '.join(self.header)}"
        raise self.error(f"{self.path}: {told}")

    def has_decimal_comma(self, columns):
        """Of the numbers in columns. Raises `error` where some have a comma and others a point."""
        found = {}
        for line, row in zip(self.lines, self.rows):
            for cell in (row[i] for i in columns if i < len(row)):
                sign = "," if WITH_COMMA.fullmatch(cell) else "." if "." in cell and NUMBER.fullmatch(cell) else None
                if sign and found.setdefault(sign, (line, cell)) and len(found) == 2:
                    (first, one), (second, other) = found.values()
                    raise self.error(f"{self.path}:{second}: '{other}' here and '{one}' in line {first}: which is the decimal sign? "
                                     f"Write all numbers with one, without grouping their digits")
        return "," in found

    def told(self, comma):
        """How it was read, in a few words."""
        return f"separated by {SEPARATORS[self.separator]}, decimal {'comma' if comma else 'point'}"


def read_table(path, error):
    """The Table of a file; of an empty one its header is empty. Raises `error`, with path and line."""
    path = os.fspath(path)
    return table_of(path, read_text(path, error), error)


def read_text(path, error):
    """In UTF-8, without its mark."""
    try:
        with open(path, "rb") as file:
            data = file.read()
    except OSError as problem:
        raise error(f"{path}: {problem.strerror}") from None
    kind = next((kind for mark, kind in MARKS.items() if data.startswith(mark)), None) or ("UTF-16" if b"\0" in data[:200] else None)
    try:
        if kind:
            raise ValueError
        return data.decode("utf-8-sig")
    except ValueError:
        raise error(f"{path}: it is {kind or 'no text in UTF-8'}; save it as CSV in UTF-8"
                    + (" (iconv -f UTF-16 -t UTF-8)" if kind == "UTF-16" else "")) from None


def table_of(path, text, error):
    """Of text."""
    lines = text.splitlines()
    first = next((i for i, line in enumerate(lines) if not is_blank(line)), len(lines))
    separator = None
    if first < len(lines) and (said := re.fullmatch(r'"?sep=(.)"?', lines[first].strip("\r\n"), re.IGNORECASE)):
        separator, lines[first] = said[1], ""  # as Excel tells itself
    looked_at = [line for line in lines[first:first + 2 * LOOKED_AT] if not is_blank(line)][:LOOKED_AT]
    if not looked_at:
        return Table(path, error, [], 0, [], [], ",")
    separator = separator if separator in SEPARATORS else separator_of(looked_at)
    (header_line, header), *kept = cells_of(lines, separator, path, error)
    return Table(path, error, header, header_line, [cells for _, cells in kept], [number for number, _ in kept], separator)


def is_blank(line):
    line = line.strip()
    return not line.strip(",; \t") or line.lstrip('"').startswith(COMMENTS)


def separator_of(lines):
    """Which cuts all lines into as many cells, more than one; else the most frequent of the first."""
    for between in SEPARATORS:
        counts = {len(cells_of_line(line, between)) for line in lines}
        if len(counts) == 1 and counts != {1}:
            return between
    return max(",;\t", key=lines[0].count)


def cells_of_line(line, separator):
    if separator == " ":
        return line.split()
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])]


def cells_of(lines, separator, path, error):
    """[(number of the line, cells)]; a cell in quotes may go on over several lines."""
    if separator == " ":
        return [(number, line.split()) for number, line in enumerate(lines, 1) if not is_blank(line)]
    rows, numbers = [], [number for number, line in enumerate(lines, 1) if not is_blank(line)]
    reader = csv.reader(io.StringIO("".join(lines[number - 1] + "\n" for number in numbers)), delimiter=separator, skipinitialspace=True)
    try:
        begin = 0
        for cells in reader:
            rows.append((numbers[begin], [cell.strip() for cell in cells]))
            begin = reader.line_num
    except csv.Error as problem:
        raise error(f"{path}:{numbers[min(begin, len(numbers) - 1)]}: {problem}") from None
    return rows


def number_of(cell, comma):
    """NaN for what is no number."""
    text = cell.replace("\u2212", "-")
    text = text.replace(".", "x").replace(",", ".") if comma else text
    value = float(text) if NUMBER.fullmatch(text) else math.nan
    return value if math.isfinite(value) else math.nan


def is_absent(cell):
    return cell.lower() in ABSENT
