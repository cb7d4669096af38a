"""Card: a keyword of an Abaqus file with its options and the lines under it.

cards(text, "arch.inp")[0].word             # "NODE"
"""

from __future__ import annotations

from dataclasses import dataclass

from masonry_fem.errors import GeometryError


@dataclass(frozen=True, slots=True)
class Card:
    """A keyword with its options.

    Attributes
    ----------
    word : In capitals. options : By name in capitals.
    rows : Words of each line under it. title, line : Of the file, and the number of its line.
    """

    word: str
    options: dict[str, str]
    rows: list[list[str]]
    title: str
    line: int

    @classmethod
    def of(cls, words: str, title: str, line: int) -> Card:
        """From a line that begins with an asterisk.

        Parameters
        ----------
        words : The line. title, line : Of the file, and its number.
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


def cards(text: str, title: str) -> list[Card]:
    """The cards of a file.

    Parameters
    ----------
    text : Of the file. title : Its name in messages.
    """
    found: list[Card] = []
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.strip()
        if not words or words.startswith("**"):
            continue
        if words.startswith("*"):
            found.append(Card.of(words, title, number))
        elif found:
            found[-1].rows.append([one.strip() for one in words.rstrip(",").split(",")])
    return found
