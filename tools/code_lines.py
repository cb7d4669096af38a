"""Code lines of a package by room, and its functions that branch much.

    python tools/code_lines.py [FOLDER] [--name]    # FOLDER: masonry_fem by default; --name: which functions

A code line holds something else than a comment or a part of a docstring: blank lines do not count, a
statement over three lines counts three. McCabe's complexity of a function is one, and one more for every
decision in it; what a decision is follows radon: ``if`` (a conditional expression too), ``for`` and ``while``
(one more with ``else``), ``except`` and the ``else`` of a ``try``, each loop and each ``if`` of a
comprehension, each ``case`` but ``case _``, each ``and`` and ``or``, ``assert``. A function within a function
counts by itself.
"""

from __future__ import annotations

import argparse
import ast
import io
import sys
import tokenize
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

MANY = 12  # a function of a higher complexity is named
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
SILENT = {
    tokenize.COMMENT,
    tokenize.NL,
    tokenize.NEWLINE,
    tokenize.INDENT,
    tokenize.DEDENT,
    tokenize.ENDMARKER,
}


def code_lines(source: str) -> int:
    """Number of code lines of a Python source."""
    told = set(docstrings(ast.parse(source)))
    lines: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type not in SILENT and token.start not in told:
            lines.update(range(token.start[0], token.end[0] + 1))
    return len(lines)


def docstrings(tree: ast.Module) -> Iterator[tuple[int, int]]:
    """Line and column at which each docstring begins."""
    for node in ast.walk(tree):
        if isinstance(node, (ast.Module, ast.ClassDef, *FUNCTIONS)) and ast.get_docstring(node) is not None:
            yield node.body[0].lineno, node.body[0].col_offset


def complexities(tree: ast.Module) -> Iterator[tuple[str, int, int]]:
    """Name, line and complexity of each function of a source."""
    for node in ast.walk(tree):
        if isinstance(node, FUNCTIONS):
            yield node.name, node.lineno, 1 + sum(map(decisions, own(node)))


def own(function: ast.AST) -> Iterator[ast.AST]:
    """All that stands in a function but not in a function within it."""
    for child in ast.iter_child_nodes(function):
        if not isinstance(child, FUNCTIONS):
            yield child
            yield from own(child)


def decisions(node: ast.AST) -> int:
    """How many ways to go on a piece of syntax adds."""
    match node:
        case ast.For() | ast.AsyncFor() | ast.While():
            return 1 + bool(node.orelse)
        case ast.Try() | ast.TryStar():
            return len(node.handlers) + bool(node.orelse)
        case ast.BoolOp():
            return len(node.values) - 1
        case ast.comprehension():
            return 1 + len(node.ifs)
        case ast.match_case():
            return not (isinstance(node.pattern, ast.MatchAs) and node.pattern.pattern is None)
    return isinstance(node, (ast.If, ast.IfExp, ast.Assert))


def room_of(file: Path, package: Path) -> str:
    """First folder below the package, ``(top)`` for files that lie in none."""
    inside = file.relative_to(package).parts
    return inside[0] if len(inside) > 1 else "(top)"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description="code lines and branchy functions by room")
    parser.add_argument("package", nargs="?", type=Path, default=Path("masonry_fem"))
    parser.add_argument("--name", action="store_true", help="name the branchy functions")
    asked = parser.parse_args()
    lines: Counter[str] = Counter()
    files: Counter[str] = Counter()
    branchy: Counter[str] = Counter()
    named = []
    for file in sorted(asked.package.rglob("*.py")):
        source, room = file.read_text(encoding="utf-8"), room_of(file, asked.package)
        lines[room] += code_lines(source)
        files[room] += 1
        many = [one for one in complexities(ast.parse(source)) if one[2] > MANY]
        branchy[room] += len(many)
        named += [f"{file}:{line}: {name}, {complexity}" for name, line, complexity in many]
    if not files:
        sys.exit(f"code_lines: no Python file in '{asked.package}', expected a package's folder; name one")
    print(f"| room | files | code lines | McCabe > {MANY} |\n|---|---|---|---|")
    for room, number in lines.most_common():
        print(f"| {room} | {files[room]} | {number} | {branchy[room]} |")
    print(f"| **all** | {files.total()} | {lines.total()} | {branchy.total()} |")
    if asked.name:
        print("", *named, sep="\n")


if __name__ == "__main__":
    main()
