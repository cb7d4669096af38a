"""Public things whose docstrings do not say what their parameters are, or what they raise, by room.

    python tools/docstrings.py [FOLDER] [--name]    # FOLDER: masonry_fem by default; --name: which they are

Public is what has no leading underscore and is used by another file of the package. Counted is what has more
than one parameter (of a class: fields, or what ``__init__`` takes) and a docstring without a section
``Parameters`` or ``Attributes``, and a function that makes and raises an error and has no section ``Raises``.
Not counted are methods, protocols (nobody calls them), and what every file of a folder defines with the
same parameters, since the folder's ``__init__`` explains these (``ALIKE``).
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


def raises(function: ast.AST) -> bool:
    """Whether a function makes and raises an error, by itself or in a block of its own."""
    inner = (ast.FunctionDef, ast.ClassDef, ast.Lambda)
    return any(
        (
            isinstance(one, ast.Raise)
            and isinstance(one.exc, ast.Call)
            and "AssertionError" not in ast.unparse(one)
        )
        or (not isinstance(one, inner) and raises(one))
        for one in ast.iter_child_nodes(function)
    )


def lacks(thing: Definition) -> list[str]:
    """Sections that the docstring of a definition should have and has not."""
    told = (ast.get_docstring(thing) or "").split("\n")
    described = parameters(thing) < 2 or "Parameters" in told or "Attributes" in told
    warned = isinstance(thing, ast.ClassDef) or "Raises" in told or not raises(thing)
    return ["Parameters"] * (not described) + ["Raises"] * (not warned)


def bare(package: Path) -> list[tuple[str, str]]:
    """Room and ``file:line: name: section`` of each section that a public definition lacks."""
    trees = {file: ast.parse(file.read_text(encoding="utf-8")) for file in sorted(package.rglob("*.py"))}
    uses = Counter(name for tree in trees.values() for name in names_used(tree))
    found = []
    for file, tree in trees.items():
        inside, own = file.relative_to(package).parts, names_used(tree)
        room = inside[0] if len(inside) > 1 else "(top)"
        for thing in tree.body:
            if (
                not isinstance(thing, Definition)
                or thing.name.startswith("_")
                or thing.name == ALIKE.get(room)
            ):
                continue
            if uses[thing.name] > (thing.name in own):
                found += [
                    (room, f"{file}:{thing.lineno}: {thing.name}: {section}") for section in lacks(thing)
                ]
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="public definitions without Parameters or Raises, by room")
    parser.add_argument("package", nargs="?", type=Path, default=Path("masonry_fem"))
    parser.add_argument("--name", action="store_true", help="name them")
    missing = bare((asked := parser.parse_args()).package)
    for room, number in Counter(room for room, _ in missing).most_common():
        print(f"{room}: {number}")
    print(f"all: {len(missing)}", *([line for _, line in missing] if asked.name else []), sep="\n")
