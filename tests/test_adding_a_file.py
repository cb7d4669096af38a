"""A new file in its folder is known to scenes, commands, the reference and the tests; nothing lists it.

The files are those of the guide, followed literally.
"""

import json
import os
import re
import subprocess
import sys
from dataclasses import dataclass

import pytest


@dataclass(frozen=True)
class Room:
    """A folder, a file of the guide for it, and files that are refused.

    Attributes
    ----------
    package : The folder. page, name : Of the guide, and of its file. keys : What a scene says for it.
    told : What the reference says of it. table : Tests over all in the folder. asked : What finds the files.
    faulty : Files that lack something, and the sentences that say so; ``FILE`` stands for the file,
        and ``NAME`` for its name.
    """

    package: str
    page: str
    name: str
    keys: str
    told: str
    table: str
    asked: str
    faulty: tuple[tuple[str, str], ...]


STONES = """
dimension = 3
fidelity = "rigid"
materials.stone.density = 2400.0
loads.gravity = [0.0, 0.0, -9.81]
output = { pictures = false, fields = false }
"""
STACK = """
structures = [{ kind = "stack", name = "it", material = "stone", size = [1.0, 1.0, 0.5], count = 2 }]
"""
SPRINGS = """
normal_stiffness = 2e10, tangential_stiffness = 1e10, normal_strength = 2.5e5, tangential_strength = 3.5e5,
normal_energy = 18.0, tangential_energy = 60.0
""".replace("\n", " ")
PIER = """
from masonry_fem.records.structure import Structure
class A(Structure, frozen=True, kw_only=True, tag="NAME"): ...
"""
GLUE = """
from dataclasses import dataclass
from masonry_fem.joints import Elastic, Law
@dataclass(frozen=True)
class Glue(Elastic):
    name = "NAME"
    age: complex = 0j
"""
TAPE = """
from dataclasses import dataclass
from masonry_fem.joints import RigidBrittle
@dataclass(frozen=True)
class Tape(RigidBrittle):
    name = "NAME"
    critical_slip: float = 0.0
    apex = tension = frictions = None
"""
SAND = """
from dataclasses import dataclass
from masonry_fem.fem.material_law import MaterialLaw
@dataclass(frozen=True)
class Sand(MaterialLaw):
    'Grains.'
    name = "NAME"
"""
REST = """
from masonry_fem.march.equilibrium import Strategy
class Rest(Strategy, frozen=True, kw_only=True, tag="NAME"): ...
"""
WET = """
from masonry_fem.fidelities import Fidelity
class Wet(Fidelity):
    'Stones in water.'
    name = "NAME"
"""
LAZY = """
class Lazy:
    name, iterations = "other", 10
method = Lazy
"""
ROOMS = {
    "structure": Room(
        "masonry_fem.structures", "add_a_structure", "cairn",
        'structures = [{ kind="cairn", name = "c", material = "stone", size = [1.0, 0.8, 0.3], count = 4 }]',
        '## `[[structures]]`, `kind = "cairn"`',
        "structures/test_every_kind.py", "masonry_fem.structures:kinds",
        (
            ("", r"FILE has 0 classes of a structure \(none\), expected one.*folder 'parts'"),
            (PIER + "class B(A, tag='b'): ...", r"FILE has 2 classes of a structure \(A, B\).*of its own"),
            (PIER.replace(', tag="NAME"', ""), r'FILE: A has no name.*class A\(Structure, .*tag="NAME"\)'),
            (PIER, r"FILE has no function build.*write def build\(spec: A, "),
            (PIER.replace('"NAME"', "3"), r"FILE: A has the name 3, expected 'NAME', that of its file"),
            (PIER.replace("...", "size: list"), r"FILE: A gives no table .*'size' is a list.*give it one"),
            (PIER.replace("...", "size: 'Lenght'"), r"FILE: A gives no table .*'Lenght' is not defined"),
            (PIER.replace("NAME", "wall"), r"FILE: A has the name 'wall', expected 'NAME'.*; write class A"),
        ),
    ),
    "law": Room(
        "masonry_fem.joints.laws", "add_a_law", "convex",
        STACK + f'joints = [{{ friction = 0.6, law = {{ kind = "convex", {SPRINGS} }} }}]',
        '## `[joints.law]`, `kind = "convex"`',
        "joints/test_all_laws.py::test_its_keys_are_explained", "masonry_fem.joints:kinds",
        (
            ("", r"FILE has 0 classes of a law \(none\), expected one, derived from Law"),
            (GLUE.replace('name = "NAME"', ""), r"FILE: Glue has no name.*write name: ClassVar\[str\] = "),
            (GLUE.replace("Glue(Elastic)", "Glue(Law)"), "Glue lacks adhesive_reaction, reduce, stored"),
            (GLUE.replace("NAME", "elastic"), r"FILE: Glue has the name 'elastic', expected 'NAME'"),
            (TAPE, r"FILE: Tape has no parameter friction, critical_opening, expected those .*write them"),
            (GLUE, r"FILE: Glue gives no table .*'age' is a complex.*expected keys of types such as Length"),
        ),
    ),
    "material": Room(
        "masonry_fem.fem.materials", "add_a_material", "compaction",
        STACK.replace('"it",', '"it", fidelity = "inelastic",') + "materials.stone.young = 5e9\n"
        'materials.stone.inelastic = { law = "compaction", crushing_pressure = 4e6 }',
        '## `[materials.NAME.inelastic]`, `law = "compaction"`',
        "fem/materials/test_material_laws.py", "masonry_fem.fem.material_kinds:material_kinds",
        (
            ("", r"FILE has 0 classes of a material law \(none\), expected one, derived from MaterialLaw"),
            (SAND.replace('name = "NAME"', ""), r"FILE: Sand has no name.*write name: ClassVar\[str\] = "),
            (SAND, r"FILE: Sand lacks measures, update, variables, expected all that MaterialLaw asks for"),
            (SAND.replace("NAME", "mohr_coulomb"), r"FILE: Sand has the name 'mohr_coulomb', expected"),
        ),
    ),
    "strategy": Room(
        "masonry_fem.march.equilibrium", "add_a_part", "creep",
        STACK + 'analysis = { kind = "creep", step = 0.01, duration = 0.05 }',
        '## `[analysis]`, `kind = "creep"`',
        "march/test_every_strategy.py", "masonry_fem.march.equilibrium:kinds",
        (
            ("", r"FILE has 0 classes of a strategy"),
            (REST.replace(', tag="NAME"', ""), r"FILE: Rest has no name"),
            (REST, r"FILE: Rest lacks end, schedule, steps, expected all that Strategy asks for; write it"),
            (REST.replace("NAME", "statics"), r"FILE: Rest has the name 'statics', expected 'NAME'"),
        ),
    ),
    "body": Room(
        "masonry_fem.fidelities", "add_a_part", "rocking",
        STACK.replace('"it",', '"it", fidelity = "rocking",'),
        "one of 'auto', 'elastic', 'inelastic', 'reduced', 'rigid', 'rocking'".replace("'", '"'),
        "bodies/test_conformance.py", "masonry_fem.fidelities:fidelities",
        (
            ("", r"FILE has 0 classes of a fidelity"),
            (WET.replace('name = "NAME"', ""), r'FILE: Wet has no name.*write name = "NAME" into Wet'),
            (WET, r"FILE: Wet lacks groups, rank, deforms, expected all that Fidelity asks for; write it"),
            (WET.replace("NAME", "rigid"), r"FILE: Wet has the name 'rigid', expected 'NAME'"),
        ),
    ),
    "placement": Room(
        "masonry_fem.contact.placement", "add_a_part", "halfway",
        STACK + 'joints = [{ friction = 0.6, placement = "halfway" }]',
        '"gauss", "halfway", "navier", "nodes"',
        "contact/test_placement.py::test_areas_and_first_moments", "masonry_fem.contact.placement:points_of",
        (("", r"FILE has no function points, expected one that places.*; write def points\(patch: Patch, "),),
    ),
    "solver": Room(
        "masonry_fem.nscd.methods", "add_a_part", "uzawa",
        STACK + 'analysis = { kind = "dynamics", step = 0.01, duration = 0.02 }\n'
        'solver = { method = "uzawa" }',
        '"nsgs", "uzawa"',
        "nscd/test_iterate.py", "masonry_fem.nscd.methods:make_method",
        (
            ("", r"FILE has no function method, expected one that makes the.*write def method\(\) -> Method"),
            (LAZY, r"FILE: what method\(\) makes, a Lazy, lacks name = 'faulty1' and init\(.*; write it"),
        ),
    ),
}  # fmt: skip
# a folder is looked into at the first scene: a further place stands for a file that was put there
WITH = """
import runpy, sys
from importlib import import_module
import_module({package!r}).__path__.append({folder!r})
from masonry_fem.cli import main
"""
TOLD = """
assert main(["info"]) == 0
assert main(["run", "scene.toml", "--out", "out"]) == 0
assert main(["check", "wrong.toml"]) == 1
print(runpy.run_path({script!r})["page"]())
"""
TABLE = """
import pytest
options = ["-v", "-p", "no:cacheprovider", "-o", "addopts=--import-mode=importlib", "-k", {name!r}]
sys.exit(pytest.main([*options, {table!r}]))
"""
FAULTS = """
import sys
from importlib import import_module
module, name = {asked!r}.split(":")
asked, path = getattr(import_module(module), name), import_module({package!r}).__path__
for number in range({count}):
    path.append(f"{folder}/{{number}}")
    getattr(asked, "cache_clear", lambda: None)()
    try:
        asked(*[f"faulty{{number}}"] * {arguments})
        print("nothing is said")
    except Exception as error:
        print(type(error).__name__, error)
    path.pop()
"""


@pytest.fixture
def said(tmp_path, repository):
    """What a program says and complains of."""

    def run(code):
        done = subprocess.run(
            [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False,
            env={**os.environ, "PYTHONPATH": str(repository)},
        )  # fmt: skip
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout + done.stderr

    return run


@pytest.fixture(params=ROOMS)
def room(request):
    """Each folder in turn."""
    return ROOMS[request.param]


def put(room, folder, repository):
    """Put the guide's file into a place of its own; the lines with which a program finds it there."""
    page = (repository / f"docs/{room.page}.md").read_text(encoding="utf-8")
    (block,) = re.findall(rf"`[\w/]*\b{room.name}\.py`:\n\n```python\n(.*?)```", page, re.S)
    place = folder / f"room_{room.name}"
    place.mkdir()
    (place / f"{room.name}.py").write_text(block, encoding="utf-8")
    return WITH.format(package=room.package, folder=str(place))


@pytest.fixture
def start(room, tmp_path, repository):
    """The lines with which a program finds the guide's file in its folder."""
    return put(room, tmp_path, repository)


@pytest.mark.parametrize(
    "room",
    [pytest.param(name, marks=() if name == "structure" else pytest.mark.slow) for name in ROOMS],
    indirect=True,
)
def test_scenes_commands_and_the_reference_have_it(room, start, said, tmp_path, repository):
    (tmp_path / "scene.toml").write_text(room.keys + STONES, encoding="utf-8")
    wrong = room.keys.replace(f'"{room.name}"', f'"{room.name}s"')
    (tmp_path / "wrong.toml").write_text(wrong + STONES, encoding="utf-8")
    text = said(start + TOLD.format(script=str(repository / "docs/scene_reference.py")))
    assert re.search(rf"^\w+ +.*\b{room.name}\b", text, re.M)
    assert json.loads((tmp_path / "out/summary.json").read_text(encoding="utf-8"))["steps"] > 0
    assert re.search(
        rf"'{room.name}s', expected one of [^;]*{room.name}.*did you mean '{room.name}'", text, re.S
    )
    assert room.told in text.replace("'", '"')


@pytest.mark.slow
def test_the_tests_have_it(room, start, said, repository):
    text = said(start + TABLE.format(name=room.name, table=str(repository / "tests" / room.table)))
    assert re.search(rf"\[.*{room.name}.*\] PASSED", text)


def test_what_a_file_lacks_is_said(room, said, tmp_path):
    for number, (text, _) in enumerate(room.faulty):
        (tmp_path / str(number)).mkdir()
        name = f"faulty{number}"
        (tmp_path / str(number) / f"{name}.py").write_text(text.replace("NAME", name), encoding="utf-8")
    by_name = not room.asked.endswith(("kinds", ":fidelities"))
    code = FAULTS.format(
        asked=room.asked,
        package=room.package,
        count=len(room.faulty),
        folder=tmp_path,
        arguments=int(by_name),
    )
    lines = said(code).splitlines()
    assert len(lines) == len(room.faulty)
    for number, (line, (_, sentence)) in enumerate(zip(lines, room.faulty, strict=True)):
        told = sentence.replace("FILE", r"NAME\.py").replace("NAME", f"faulty{number}")
        assert re.search(f"^ExtensionError .*{told}", line), line


def write_scene(name, folder, repository):
    """Put a scene of the guide into a folder."""
    page = (repository / "docs/add_a_part.md").read_text(encoding="utf-8")
    (scene,) = re.findall(rf"`{re.escape(name)}`:\n\n```toml\n(.*?)```", page, re.S)
    (folder / name).write_text(scene, encoding="utf-8")


@pytest.mark.slow
def test_the_scene_of_the_guide_gives_what_it_says(said, tmp_path, repository):
    write_scene("parts.toml", tmp_path, repository)
    starts = [put(ROOMS[name], tmp_path, repository) for name in ("strategy", "placement", "solver")]
    said("\n".join(starts) + 'sys.exit(main(["run", "parts.toml", "--out", "out"]))')
    summary = json.loads((tmp_path / "out/summary.json").read_text(encoding="utf-8"))
    assert summary["steps"] == 5
    assert summary["supports"]["pile.ground"]["force"][1] == pytest.approx(23544.0, rel=1e-7)


@pytest.mark.slow
def test_the_body_of_the_guide_flies_as_it_says(said, tmp_path, repository):
    """At the top of its flight the rotation is left, slowed as the trapezoidal rule has it."""
    write_scene("rocking.toml", tmp_path, repository)
    start = put(ROOMS["body"], tmp_path, repository)
    energies = []
    for fidelity in ("rocking", "rigid"):
        asked = [
            "run",
            "rocking.toml",
            "--set",
            f"fidelity={fidelity}",
            "--set",
            "output.fields=true",
            "--out",
        ]
        said(start + f"assert main({[*asked, fidelity]!r}) == 0")
        history = (tmp_path / fidelity / "history.csv").read_text(encoding="utf-8").splitlines()
        energies.append(float(history[-1].split(",")[history[0].split(",").index("kinetic_energy")]))
        table = (tmp_path / fidelity / "fields/acting_000100.csv").read_text(encoding="utf-8")
        assert [line.split(",")[2] for line in table.splitlines()[1:]] == ["support", fidelity]
    spinning = 2400 * 1.0 * (0.5**2 + 2.0**2) / 12 / 2
    assert energies[0] == pytest.approx(spinning * (0.99 / 1.01) ** 200, rel=1e-9)
    assert energies[1] == pytest.approx(10.2e3, rel=1e-2)
