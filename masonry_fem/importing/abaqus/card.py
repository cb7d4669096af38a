"""Card: a keyword of an Abaqus file with its options and the lines under it.

cards(Path("arch.inp"), "arch.inp")[0].word             # "NODE"
included(Path("arch.inp"))                              # files that it includes
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from masonry_fem.errors import GeometryError


@dataclass(frozen=True, slots=True)
class Card:
    """A keyword with its options.

    Attributes
    ----------
    word : In capitals. options : By name in capitals.
    rows : Words of each line under it. title : Of the file.
    line : The number of its line, and in which file where that is an included one.
    """

    word: str
    options: dict[str, str]
    rows: list[list[str]]
    title: str
    line: str

    @classmethod
    def of(cls, words: str, title: str, line: str) -> Card:
        """From a line that begins with an asterisk.

        Parameters
        ----------
        words : The line. title : Of the file. line : Its number, and in which file.
        """
        head, *rest = (one.strip() for one in words[1:].split(","))
        pairs = (one.partition("=") for one in rest if one)
        options = {key.strip().upper(): value.strip().strip('"') for key, _, value in pairs}
        return cls(" ".join(head.upper().split()), options, [], title, line)

    def named(self, option: str) -> str:
        """What an option says.

        Raises
        ------
        GeometryError : It is not there.
        """
        if option not in self.options:
            raise self.fault(f"*{self.word} has no {option}=, expected a name; correct the file")
        return self.options[option]

    def numbers(self) -> list[list[float]]:
        """The lines under it.

        Raises
        ------
        GeometryError : A word is no number.
        """
        return [self._numbers(row) for row in self.rows]

    def fault(self, words: str) -> GeometryError:
        """The error to raise."""
        return GeometryError(f"{self.title}, line {self.line}: {words}")

    def _numbers(self, row: list[str]) -> list[float]:
        try:
            return [float(one) for one in row if one]
        except ValueError:
            raise GeometryError(
                f"{self.title}, below line {self.line} (*{self.word}): '{', '.join(row)}' are no numbers; "
                "correct it"
            ) from None


def cards(path: Path, title: str) -> list[Card]:
    """The cards of a file and of those it includes.

    Parameters
    ----------
    path : The file. title : Its name in messages.

    Raises
    ------
    GeometryError : An included file is missing, not below the file's folder, or includes itself.
    """
    found: list[Card] = []
    for one in _lines(path, title, {}):
        if isinstance(one, Card):
            found.append(one)
        elif found:
            found[-1].rows.append([word.strip() for word in one.rstrip(",").split(",")])
    return found


def included(path: Path) -> list[Path]:
    """The files beside an ``.inp`` that it includes, and those that these include.

    Raises
    ------
    GeometryError : One is missing, not below the file's folder, or includes itself.
    """
    files: dict[Path, None] = {}
    for _ in _lines(path, path.name, files):
        pass
    return list(files)


def _lines(
    path: Path, title: str, files: dict[Path, None], within: tuple[Path, ...] = ()
) -> Iterator[Card | str]:
    """Cards without their rows, and lines under them, those of included files in their place.

    Included files are added to ``files``.
    """
    for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), start=1):
        words = line.strip()
        if not words or words.startswith("**"):
            continue
        if not words.startswith("*"):
            yield words
            continue
        card = Card.of(words, title, f"{number} of '{path.name}'" if within else str(number))
        if card.word != "INCLUDE":
            yield card
            continue
        name = card.options.get("INPUT", "")
        folder = (within[0] if within else path).parent
        found = _file(folder / name)
        if found is None or not found.is_relative_to(folder.resolve()):
            raise card.fault(f"it includes '{name}', expected a file in its folder or below; put it there")
        if found in (one.resolve() for one in (*within, path)):
            raise card.fault(f"'{name}' includes itself, expected an end; correct the file")
        files[found] = None
        yield from _lines(found, title, files, (*within, path))


def _file(path: Path) -> Path | None:
    """The file at a path, resolved; None where there is none, or where the path is no name of one."""
    try:
        found = path.resolve()
        return found if found.is_file() else None
    except (OSError, ValueError):  # too long, or with a null character
        return None
