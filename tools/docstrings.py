"""Public functions and classes whose docstrings do not say what their parameters are, by room.

    python tools/docstrings.py [FOLDER] [--name]    # FOLDER: masonry_fem by default; --name: which they are

Public is what has no leading underscore and is used by another file of the package. Counted is what has more
than one parameter (of a class: fields, or what ``__init__`` takes) and a docstring without a section
``Parameters`` or ``Attributes``. Not counted are methods, protocols (nobody calls them), and what every file
of a folder defines with the same parameters, since the folder's ``__init__`` explains these (``ALIKE``).
"""

from __future__ import annotations

import argparse
import ast
from collections import Counter
from pathlib import Path

Definition = ast.FunctionDef | ast.ClassDef
ALIKE = {"structures": "build", "cli": "add"}  # room: name


def names_used(tree: ast.Module) -> set[str]:
    """What a module imports by name or reaches as an attribute."""
    nodes = list(ast.walk(tree))
    imported = {alias.name for node in nodes if isinstance(node, ast.ImportFrom) for alias in node.names}
    return imported | {node.attr for node in nodes if isinstance(node, ast.Attribute)}


def parameters(thing: Definition) -> int:
    """How many parameters a function or the making of a class has."""
    if isinstance(thing, ast.FunctionDef):
        taken = thing.args
        return len([*taken.posonlyargs, *taken.args, *taken.kwonlyargs])
    if any("Protocol" in ast.unparse(base) for base in thing.bases):
        return 0
    for one in thing.body:
        if isinstance(one, ast.FunctionDef) and one.name == "__init__":
            return parameters(one) - 1
    return sum(isinstance(one, ast.AnnAssign) and "ClassVar" not in ast.unparse(one) for one in thing.body)


def bare(package: Path) -> list[tuple[str, str]]:
    """Room and ``file:line: name`` of each public definition that does not say what its parameters are."""
    trees = {file: ast.parse(file.read_text(encoding="utf-8")) for file in sorted(package.rglob("*.py"))}
    uses = Counter(name for tree in trees.values() for name in names_used(tree))
    found = []
    for file, tree in trees.items():
        inside, own = file.relative_to(package).parts, names_used(tree)
        for thing in tree.body:
            if not isinstance(thing, Definition) or thing.name.startswith("_") or parameters(thing) < 2:
                continue
            room = inside[0] if len(inside) > 1 else "(top)"
            told = (ast.get_docstring(thing) or "").split("\n")
            if thing.name == ALIKE.get(room) or "Parameters" in told or "Attributes" in told:
                continue
            if uses[thing.name] > (thing.name in own):
                found.append((room, f"{file}:{thing.lineno}: {thing.name}"))
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="public definitions without Parameters, by room")
    parser.add_argument("package", nargs="?", type=Path, default=Path("masonry_fem"))
    parser.add_argument("--name", action="store_true", help="name them")
    missing = bare((asked := parser.parse_args()).package)
    for room, number in Counter(room for room, _ in missing).most_common():
        print(f"{room}: {number}")
    print(f"all: {len(missing)}", *([line for _, line in missing] if asked.name else []), sep="\n")
