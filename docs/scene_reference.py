"""Write docs/scene.md and the keys on the pages of docs/laws from the records of scene files themselves.

    python docs/scene_reference.py            # writes them
    python docs/scene_reference.py --check    # exit code 1 where one is stale

Key, type, range and unit come from the annotations, defaults from the records, and the text of a
table and the meaning of its keys from the record's docstring. A key without a meaning is an error.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

from msgspec import inspect

from masonry_fem.fem.material_kinds import material_kinds
from masonry_fem.joints import kinds as laws
from masonry_fem.march.equilibrium import kinds as strategies
from masonry_fem.records import docstring
from masonry_fem.records.record import Spec
from masonry_fem.scene import specs
from masonry_fem.scene.expectation import expectation
from masonry_fem.scene.explaining import default_of
from masonry_fem.scene.writing import plain
from masonry_fem.structures import kinds

PAGE = Path(__file__).with_name("scene.md")
MARKS = ("<!-- keys: made by docs/scene_reference.py, do not edit -->\n", "<!-- end of keys -->")
HEAD = """# Scene reference

<!-- made by docs/scene_reference.py from masonry_fem/scene and masonry_fem/structures; do not edit -->

A scene is a TOML file. Numbers are in SI units (angles of geometry in degrees, of motions in radians);
wherever a unit is given below, a string with a unit may be used instead: `young = "10 GPa"`. Vectors
have the dimension of the scene. A plane scene is one metre deep: its forces are per metre.

## Names, selectors and labels

Names of blocks begin with the name of their structure, here `wall`, `arch` and so on:

| structure | blocks | groups of blocks | supports |
|---|---|---|---|
| any | `NAME` if there is only one | `NAME`, and other names without their last part, such as `wall.c2`, `portal.left`, `dome.r1`, `dome.p3` | `NAME.ground` |
| wall | `wall.c2.b3` (course 2, brick 3; row by row from the front), `wall.lintel1` | `wall.stretchers`, `wall.headers`, `wall.closers`, `wall.lintels`, `wall.w2` (wythe 2 from the front) | |
| stack, corbel | `stack.b1`, `corbel.b1` (from below) | | |
| buttress | `buttress.c2.b1` (course, stone) | `buttress.stage2` | |
| column | `column.d3` (drum 3), `column.plinth`, `column.capital` | | |
| staircase | `stair.s3` (step 3) | `stair.steps`, `stair.wall` | `stair.below2`, `stair.above2` (wall stones below and above the built-in end of step 2) |
| rubble | `rubble.s07` (from below) | | |
| arches | `arch.v06` (from the left) | `arch.keystone`, `arch.springers` (the stones at both ends) | `arch.springing_left`, `arch.springing_right` |
| arch bridge | as an arch, and `bridge.fill` | as of an arch | `bridge.abutment_left`, `bridge.abutment_right` |
| barrel vault | `vault.c2.s3` (course 2 from the left, stone 3) | `vault.keystone` (the course at the crown), `vault.springers` | `vault.springing_left`, `vault.springing_right` |
| flying buttress | `flyer.v01` (from the foot) | | `flyer.foot`, `flyer.head` |
| portal | as an arch, and `portal.left.c1` (pier, course) | | `portal.ground_left`, `portal.ground_right` |
| dome | `dome.r1.s4` (ring 1, slice 4), `dome.crown`, `dome.d1.s2` (drum, course 1), `dome.p3.c1` (pier 3, course 1) | `dome.s4`, `dome.drum`, `dome.piers` | `dome.base.s4` (under piers `dome.base.p4`), `dome.side_start`, `dome.side_end` |
| file, survey | `NAME.` and the group, object or key in the file, or the stone in the survey | | |

A selector of blocks is a shell pattern of names of blocks or groups (`wall.c5.*`), a selector of faces is
`blocks/face` (`wall.c5.*/top`). A joint is selected by its label.

| structure | faces | labels of joints |
|---|---|---|
| boxes | `left`, `right`, `front`, `back`, `bottom`, `top` | `bed`, `head`; `collar` between the wythes of a wall |
| voussoirs | `start` (the left joint), `end` (the right one), `intrados`, `extrados`, `front`, `back` | `radial`, also between a portal's pier and its arch; or `vertical` with `cut`; in vaults `radial` and `head`; at both ends of flying buttresses `head` |
| fill of an arch bridge | `road`, `strip` (a part of the road), `left`, `right`, `base`, `front`, `back` | `fill`, with voussoirs and abutments |
| stones of domes and drums | `intrados`, `extrados`, `lower`, `upper`, `left`, `right` | `bed`, `meridian` |
| drums of a column | `bottom`, `top`, `side` | `bed` |
| rubble | those in the sides of the box, as of a box | `rubble` |
| survey | by their direction, as of a box | `bed`, `inclined` (30° to 60°), `head` |

`--set` changes any value from the command line: `--set joints.0.friction=0.4`,
`--set structures.wall.courses=8`, `--set "analysis={kind='dynamics', step=1e-4, duration=0.01}"`. A `*` stands for all items that
have the rest of the key: `--set "materials.*.young=3 GPa"`.

"""  # noqa: E501
# record -> (heading, key in the file)
TABLES: dict[type[Spec], str] = {
    specs.Scene: "Top level",
    specs.MeshSettings: "`mesh`, also in a structure",
    specs.Material: "`[materials.NAME]`",
    specs.Orthotropy: "`[materials.NAME.orthotropic]`",
    specs.Damping: "`[materials.NAME.damping]`",
    **{
        kind.record: f'`[materials.NAME.inelastic]`, `law = "{name}"`'
        for name, kind in material_kinds().items()
    },
    specs.PythonMaterial: '`[materials.NAME.inelastic]`, `law = "python"`',
    **{kind.record: f'`[[structures]]`, `kind = "{name}"`' for name, kind in kinds().items()},
    specs.Opening: "`[[structures.openings]]` of a wall",
    specs.Override: "`[[overrides]]`",
    specs.Joint: "`[[joints]]`",
    **{kind.record: f'`[joints.law]`, `kind = "{name}"`' for name, kind in laws().items()},
    specs.PythonLaw: '`[joints.law]`, `kind = "python"`',
    specs.Mortar: "`[joints.mortar]`",
    specs.Closure: "`[joints.closure]`",
    specs.Dilatancy: "`[joints.dilatancy]`",
    specs.Scatter: "`[joints.scatter]`",
    specs.Tie: "`[[ties]]`",
    specs.TiePoint: "`points` of a tie",
    specs.Support: "`[[supports]]`",
    specs.Motion: "`motion` of a support",
    specs.Loads: "`[loads]`",
    specs.Acceleration: "`[[loads.accelerations]]`",
    specs.Accelerogram: "`[[loads.accelerograms]]`",
    specs.Traction: "`[[loads.tractions]]`",
    specs.PressureLoad: "`[[loads.pressures]]`",
    specs.PointForce: "`[[loads.points]]`",
    specs.LineForce: "`[[loads.lines]]`",
    specs.MovingLoad: "`[[loads.moving]]`",
    specs.Temperature: "`[[loads.temperatures]]`",
    specs.Design: "`[design]`",
    specs.LoadFactors: "`[design.loads]`",
    specs.Table: '`time = { kind = "table" }`',
    specs.Sine: '`time = { kind = "sine" }`',
    specs.Pulse: '`time = { kind = "pulse" }`',
    specs.Record: '`time = { kind = "record" }`',
    specs.Initial: "`[[initial]]`",
    **{record: f'`[analysis]`, `kind = "{name}"`' for name, record in strategies().items()},
    specs.Stage: "`[[stages]]`",
    specs.Combination: "`[[combinations]]`",
    specs.Solver: "`[solver]`",
    specs.Contact: "`[contact]`",
    specs.Probe: "`[[probes]]`",
    specs.Output: "`[output]`",
    specs.Reading: "`[reading]`",
    specs.Cut: "`[[output.cuts]]`",
}


def page() -> str:
    """The whole page."""
    return HEAD + "\n".join(section(kind, heading) for kind, heading in TABLES.items())


def section(kind: type[Spec], heading: str) -> str:
    """Heading, text and table of one record."""
    lines = [
        f"## {heading}",
        "",
        text_of(kind),
        "",
        *example_of(kind, heading),
        table(kind),
    ]
    return "\n".join(lines)


def table(kind: type[Spec], keys: tuple[str, ...] = ()) -> str:
    """Table of a record's keys, or of some of them."""
    chosen = [row for row in rows(kind) if not keys or row[0].strip("`") in keys]
    lines = ["| key | expected | default | meaning |", "|---|---|---|---|"]
    lines += [f"| {' | '.join(cell.replace('|', '&#124;') for cell in row)} |" for row in chosen]
    return "\n".join([*lines, ""])


def law_pages() -> Iterator[tuple[Path, str]]:
    """Each page of docs/laws that has keys, and its text with these keys."""
    joint = ("friction", "dynamic_friction", "restitution", "tangential_restitution", "form")
    tables = {name: table(kind.record) for name, kind in laws().items()}
    tables |= {"mortar": table(specs.Mortar), "closure": table(specs.Closure)}
    tables |= {"dilatancy": table(specs.Dilatancy)}
    tables["dry"] = table(specs.Joint, joint)
    for name, keys in tables.items():
        path = PAGE.with_name("laws") / f"{name}.md"
        if path.exists():  # a law of one's own may have none
            before, rest = path.read_text(encoding="utf-8").split(MARKS[0])
            yield path, f"{before}{MARKS[0]}{keys}{MARKS[1]}{rest.split(MARKS[1])[1]}"


def rows(kind: type[Spec]) -> Iterator[tuple[str, str, str, str]]:
    """Key, expectation, default and meaning of each field."""
    info = inspect.type_info(kind)
    assert isinstance(info, inspect.StructType)
    for field in info.fields:
        yield f"`{field.encode_name}`", expected(field.type), default(field), meaning(kind, field.name)


def expected(kind: inspect.Type) -> str:
    """What an error message would say is expected."""
    words = expectation(kind)
    return words[:1].lower() + words[1:]


def default(field: inspect.Field) -> str:
    """A default as one would write it, ``required``, or nothing where None."""
    if not field.required and plain(field.default) == [{}]:
        return "one, all defaults"
    text = default_of(field)
    return text if text in ("", "required") else f"`{text}`"


def meaning(kind: type[Spec], name: str) -> str:
    """What a key means."""
    told = docstring.meanings(kind).get(name)
    if told is None:
        raise SystemExit(
            f"{sys.modules[kind.__module__].__file__}: the key '{name}' of {kind.__name__} has no meaning, "
            f"expected one under Attributes in its docstring; write '{name} : ...' there"
        )
    return marked(told)


def example_of(kind: type[Spec], heading: str) -> list[str]:
    """Lines of a record's example."""
    lines = docstring.example(kind)
    return ["```toml", heading.split("`")[1], *lines.splitlines(), "```", ""] if lines else []


def text_of(kind: type[Spec]) -> str:
    """Docstring of a record as a paragraph or two."""
    blocks = docstring.text(kind).split("\n\n")
    text = "\n\n".join(" ".join(line.strip() for line in block.splitlines()).strip() for block in blocks)
    return marked(text).strip()


def marked(text: str) -> str:
    """Text of a docstring as Markdown."""
    return text.replace("``", "`")


def main(arguments: list[str]) -> int:
    """Write the pages, or compare them."""
    made = [(PAGE, page()), *law_pages()]
    if "--check" in arguments:
        return int(any(not path.exists() or path.read_text(encoding="utf-8") != text for path, text in made))
    for path, text in made:
        path.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
