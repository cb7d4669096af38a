"""Write docs/parts: a page each for materials, analyses, solvers, placements and fidelities, from sources.

    python docs/make_parts.py            # writes them
    python docs/make_parts.py --check    # exit code 1 where one is stale

The text is the docstring of the part's file, the keys are those of its record. Joint laws have pages of their
own, written by hand, in docs/laws; structures and the keys of all tables stand in docs/scene.md.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Callable, Iterator, Mapping
from importlib.util import find_spec
from pathlib import Path

from masonry_fem import fidelities
from masonry_fem.contact import placement
from masonry_fem.fem.material_kinds import material_kinds
from masonry_fem.march.equilibrium import kinds as analyses
from masonry_fem.nscd import methods
from masonry_fem.records.record import Spec
from masonry_fem.scene.explaining import keys_of

FOLDER = Path(__file__).with_name("parts")
MARK = "<!-- made by docs/make_parts.py from the sources; do not edit -->\n"
PAGE = re.compile(r"\(docs/([\w/]+\.md[\w#-]*)\)")  # as keys and docstrings name a page
# what it is, its package, its names or records by name, how a scene asks for one
ROOMS: tuple[tuple[str, str, Callable[[], Mapping[str, type[Spec]] | tuple[str, ...]], str], ...] = (
    (
        "Material",
        "masonry_fem.fem.materials",
        lambda: {name: kind.record for name, kind in material_kinds().items()},
        'inelastic = {{ law = "{name}", ... }}` of a material',
    ),
    ("Analysis", "masonry_fem.march.equilibrium", analyses, 'kind = "{name}"` of `[analysis]`'),
    ("Contact solver", "masonry_fem.nscd.methods", methods.names, 'method = "{name}"` of `[solver]`'),
    ("Placement", "masonry_fem.contact.placement", placement.names, 'placement = "{name}"` of `[[joints]]`'),
    (
        "Fidelity",
        "masonry_fem.fidelities",
        lambda: tuple(fidelities.fidelities()),
        'fidelity = "{name}"` of the scene, a structure or `[[overrides]]`',
    ),
)


def pages() -> Iterator[tuple[str, str]]:
    """Names of the pages, and their texts; the list of all of them first."""
    made, listed = [], []
    for noun, package, names, asked in ROOMS:
        known = names()
        for name in known:
            file = f"{noun.lower().replace(' ', '_')}_{name}"
            told = docstring(f"{package}.{name}")
            record = known[name] if isinstance(known, Mapping) else None
            made.append((f"{file}.md", page(noun, name, told, asked, package, record)))
            listed.append(f"| {noun.lower()} | [`{name}`]({file}.md) | {first_line(told)} |")
    yield "index.md", "\n".join([
        "# Parts", "", MARK,
        "Parts of the program that a scene chooses by name. Each has a page with its equations and keys, "
        "made from its source file. [Joint laws](../joints.md) have longer pages.", "",
        "| is | name | does |", "|---|---|---|", *listed, "",
        "```{toctree}", ":hidden:", ":glob:", "", "*", "```", "",
    ])  # fmt: skip
    yield from made


def page(noun: str, name: str, told: str, asked: str, package: str, record: type[Spec] | None) -> str:
    """The page of one part.

    Parameters
    ----------
    noun, name : What it is, and is called. told : Its docstring.
    asked : How a scene asks for it. package : Where it stands.
    record : With its keys; None: it has none.
    """
    source = f"{package.replace('.', '/')}/{name}.py"
    first, _, rest = PAGE.sub(r"([page](../\1))", told).partition("\n\n")
    lines = [f"# {noun} `{name}`", "", MARK, first, ""]
    lines += [f"In a scene: `{asked.format(name=name)}. Source: `{source}`.", *(["", rest] if rest else [])]
    keys = [] if record is None else keys_of(record)
    if keys:
        lines += ["", "| key | expected | default | meaning |", "|---|---|---|---|"]
        for key in keys:
            default = f"`{key.default}`" if key.default and key.default != "required" else key.default
            cells = (f"`{key.name}`", key.expected, default, PAGE.sub(r"([page](../\1))", key.meaning))
            lines.append(f"| {' | '.join(cell.replace('|', '\\|') for cell in cells)} |")
    return "\n".join(lines) + "\n"


def docstring(module: str) -> str:
    """The docstring of a module as Markdown; the module is not loaded."""
    found = find_spec(module)
    assert found is not None
    assert found.origin is not None
    text = ast.get_docstring(ast.parse(Path(found.origin).read_text(encoding="utf-8")))
    return (text or "").replace("``", "`").replace("<", "&lt;")


def first_line(told: str) -> str:
    """What a part does: its docstring's first sentence, without its name."""
    line = told.partition("\n")[0].partition(": ")
    return (line[2] or line[0]).rstrip(".").replace("|", "\\|")


def main(arguments: list[str]) -> int:
    """Write the pages, or tell whether they are what they would be."""
    made = dict(pages())
    FOLDER.mkdir(exist_ok=True)
    there = {path.name: path.read_text(encoding="utf-8") for path in FOLDER.glob("*.md")}
    if "--check" in arguments:
        return int(made != there)
    for name in there.keys() - made.keys():
        (FOLDER / name).unlink()
    for name, text in made.items():
        (FOLDER / name).write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
