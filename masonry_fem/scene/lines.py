r"""Lines: the line of each key in a TOML text, for messages.

``tomllib`` gives no positions, so the text, already known to be valid, is scanned once more:

    key_lines('a = 1\n[[b]]\nc = [2,\n3]')    # {('a',): 1, ('b', 0): 2, ('b', 0, 'c'): 3, ...}
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

KeyPath = tuple[str | int, ...]

_BLANK = re.compile(r"(?:[ \t\r\n,]|#[^\n]*)*")
_STRING = re.compile(
    r'"""(?:[^\\]|\\.)*?"{3,5}(?!")|\'\'\'.*?\'{3,5}(?!\')|"(?:[^"\\\n]|\\.)*"|\'[^\'\n]*\'', re.DOTALL
)
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_SCALAR = re.compile(r"[^,\]}#\n]+")


def key_lines(text: str) -> dict[KeyPath, int]:
    """Line (from 1) of every key, list item and table header of a valid TOML text."""
    return dict(_Scanner(text).statements())


def line_of(lines: Mapping[KeyPath, int], path: KeyPath) -> int | None:
    """Line of a key, or of the nearest enclosing table that the text contains; None where there is none.

    Parameters
    ----------
    lines : Lines by key path, from ``key_lines``.
    path : Key path.
    """
    for length in range(len(path), 0, -1):
        if (line := lines.get(path[:length])) is not None:
            return line
    return None


class _Scanner:
    """A cursor that walks through the statements of a text."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.at = 0
        self.counts: dict[KeyPath, int] = {}

    def statements(self) -> Iterator[tuple[KeyPath, int]]:
        """Key paths with their lines, in the order of the text."""
        table: KeyPath = ()
        while self._next():
            line = self._line()
            if self.text.startswith("[[", self.at):
                self.at += 2
                table = self._item(self._key())
                if table[-1] == 0:
                    yield table[:-1], line
                yield table, line
                self.at = self.text.index("]]", self.at) + 2
            elif self.text[self.at] == "[":
                self.at += 1
                table = self._resolved(self._key())
                yield table, line
                self.at = self.text.index("]", self.at) + 1
            else:
                yield from self._pair(table)

    def _pair(self, table: KeyPath) -> Iterator[tuple[KeyPath, int]]:
        line = self._line()
        path = table + self._key()
        self.at = self.text.index("=", self.at) + 1
        yield path, line
        yield from self._value(path)

    def _value(self, path: KeyPath) -> Iterator[tuple[KeyPath, int]]:
        self._next()
        if string := _STRING.match(self.text, self.at):
            self.at = string.end()
        elif self.text[self.at] == "[":
            self.at += 1
            index = 0
            while self._next() and self.text[self.at] != "]":
                yield (*path, index), self._line()
                yield from self._value((*path, index))
                index += 1
            self.at += 1
        elif self.text[self.at] == "{":
            self.at += 1
            while self._next() and self.text[self.at] != "}":
                yield from self._pair(path)
            self.at += 1
        elif scalar := _SCALAR.match(self.text, self.at):
            self.at = scalar.end()

    def _key(self) -> KeyPath:
        """A dotted key from the cursor on."""
        parts: list[str] = []
        while True:
            self._next()
            if string := _STRING.match(self.text, self.at):
                parts.append(string.group()[1:-1])
                self.at = string.end()
            elif bare := _BARE_KEY.match(self.text, self.at):
                parts.append(bare.group())
                self.at = bare.end()
            self._next()
            if not self.text.startswith(".", self.at):
                return tuple(parts)
            self.at += 1

    def _item(self, key: KeyPath) -> KeyPath:
        """Path of the next item of an array of tables."""
        array = (*self._resolved(key[:-1]), key[-1])
        self.counts[array] = self.counts.get(array, -1) + 1
        return (*array, self.counts[array])

    def _resolved(self, key: KeyPath) -> KeyPath:
        """A header's key with the current index after each array of tables in it."""
        path: KeyPath = ()
        for part in key:
            path = (*path, part)
            if path in self.counts:
                path = (*path, self.counts[path])
        return path

    def _next(self) -> bool:
        """Skip blanks, commas and comments; False at the end of the text."""
        blank = _BLANK.match(self.text, self.at)
        self.at = blank.end() if blank else self.at
        return self.at < len(self.text)

    def _line(self) -> int:
        return self.text.count("\n", 0, self.at) + 1
