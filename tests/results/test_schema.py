"""Schema: what every command leaves in its JSON is as ``masonry-fem info --schema`` says."""

import contextlib
import importlib.util
import json
import os

import pytest

from masonry_fem.analyses.run import run, solve_scene
from masonry_fem.cli import main
from masonry_fem.errors import MasonryError
from masonry_fem.fidelities import fidelities
from masonry_fem.march.equilibrium import kinds
from masonry_fem.output.folder import Folder
from masonry_fem.records.discovery import tag_of
from masonry_fem.scene import loads

SCENE = """
title = "pile"
dimension = 2
fidelity = "rigid"
materials.stone = { density = 2400.0, young = 1e9 }
structures = [{ kind = "stack", name = "it", material = "stone", size = [1.0, 1.0], count = 2 }]
mesh.divisions = [2, 2]
joints = [{ friction = 0.6 }]
loads.gravity = [0.0, -10.0]
output = { pictures = false, fields = false }
"""
TYPES = {
    "string": str, "integer": int, "boolean": bool, "null": type(None), "array": list, "object": dict,
    "number": (int, float),
}  # fmt: skip


def faults(value, schema, defs, at=""):
    """Where a value is not as a schema says; the words of it that msgspec makes."""
    if "$ref" in schema:
        yield from faults(value, defs[schema["$ref"].rpartition("/")[2]], defs, at)
    elif "anyOf" in schema:
        found = [list(faults(value, one, defs, at)) for one in schema["anyOf"]]
        yield from () if [] in found else min(found, key=len)
    elif "enum" in schema:
        yield from () if value in schema["enum"] else [f"{at} is {value}"]
    elif "type" in schema:
        kinds = [schema["type"]] if isinstance(schema["type"], str) else schema["type"]
        if not any(isinstance(value, TYPES[kind]) for kind in kinds):
            yield f"{at} is {value}, not {kinds}"
        elif isinstance(value, list):
            parts = [*schema.get("prefixItems", ()), *[schema.get("items") or {}] * len(value)]
            for number, part in enumerate(value):
                yield from faults(part, parts[number], defs, f"{at}.{number}")
        elif isinstance(value, dict):
            yield from (f"{at}.{key} is missing" for key in schema.get("required", ()) if key not in value)
            others = schema.get("additionalProperties", {})
            for key, part in value.items():
                part_schema = schema.get("properties", {}).get(key, others or None)
                if part_schema is None and "properties" in schema:
                    yield f"{at}.{key} is not in the schema"
                else:
                    yield from faults(part, part_schema or {}, defs, f"{at}.{key}")


@pytest.fixture
def judged(capsys):
    """The faults of a file by the published schema, also as jsonschema finds them where it is installed."""
    assert main(["info", "--schema"]) == 0
    schema = json.loads(capsys.readouterr().out)

    def judge(value):
        found = list(faults(value, schema, schema["$defs"]))
        if importlib.util.find_spec("jsonschema") is not None:
            from jsonschema import Draft202012Validator as Validator

            Validator.check_schema(schema)
            found += [f"{one.json_path}: {one.message}" for one in Validator(schema).iter_errors(value)]
        return found

    return judge


def read(path):
    return json.loads(path.read_text(encoding="utf-8"))


ALL = "output={pictures=false, fields=false, interfaces=true, determinacy=true, limit_analysis=true}"
YIELDING = (  # under the pile's weight
    "materials.stone={density=2400.0, young=1e9, poisson=0.2, inelastic={law='mohr_coulomb', cohesion=1e4, "
    "friction_angle=30.0, hardening=1e8}}"
)
RUNS = {
    "rigid": ([], "equilibrium"),
    "all that may be asked": ([ALL], "equilibrium"),
    "falls": (["loads.gravity=[8.0, -10.0]", ALL], "no_equilibrium"),
    "dynamics": (["analysis={kind='dynamics', step=0.1, duration=0.3, theta=1.0}"], "finished"),
    "to rest": (
        ["analysis={kind='equilibrium', strategy='brutal_damping', step=0.1}"], "equilibrium"
    ),
    "along a path": (
        ["analysis={kind='path', probe='top', direction=[0.0, -1.0], distance=1e-8, load_steps=2}",
         "probes=[{name='top', block='it.b2', point=[0.5, 2.0]}]", "fidelity='elastic'"],
        "finished",
    ),
    "crossing": (
        ["analysis={kind='crossing', places=3}",
         "loads.moving=[{on='it.b2/top', path=[[0.0, 2.0], [1.0, 2.0]], vector=[0.0, -1e3], spread=0.1}]"],
        "equilibrium",
    ),
    "elastic": (["fidelity='elastic'", "output.contact_error=true"], "equilibrium"),
    "reduced": (["fidelity='reduced'"], "equilibrium"),
    "inelastic": (["fidelity='inelastic'", YIELDING], "equilibrium"),
    "auto": (["fidelity='auto'", YIELDING], "equilibrium"),
    "mortar that scatters": (
        ["joints=[{friction=0.6, law={kind='mohr_coulomb', cohesion=1e5}, "
         "scatter={seed=1, variation={cohesion=0.1}}}]", ALL],
        "equilibrium",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", RUNS)
def test_runs(case, judged, tmp_path):
    changes, outcome = RUNS[case]
    result = run(loads(SCENE, changes), tmp_path)
    told = read(tmp_path / "summary.json")
    assert (told["outcome"], told["schema"]) == (outcome, "run/2")
    assert result.outcome == outcome
    assert judged(told) == []


def test_runs_are_of_every_kind():
    scenes = [loads(SCENE, changes) for changes, _ in RUNS.values()]
    assert {tag_of(type(scene.analysis)) for scene in scenes} == set(kinds())
    assert {scene.fidelity for scene in scenes} == set(fidelities())


def test_a_run_under_way_and_one_that_failed(judged, tmp_path):
    with contextlib.suppress(MasonryError), Folder(tmp_path, "run", title="pile"):
        told = read(tmp_path / "summary.json")
        assert (told["schema"], told["outcome"], told["pid"]) == ("run/2", "running", os.getpid())
        assert judged(told) == []
        raise MasonryError("the disk is full")
    told = read(tmp_path / "summary.json")
    assert (told["outcome"], told["message"]) == ("failed", "the disk is full.")
    assert judged(told) == []


@pytest.mark.parametrize(("place", "figures"), [("writing.march", False), ("asked.errors_of", True)])
def test_interrupted_runs_keep_what_they_know(judged, tmp_path, monkeypatch, place, figures):
    def interrupted(*arguments, **keys):
        raise KeyboardInterrupt

    monkeypatch.setattr(f"masonry_fem.analyses.run.{place}", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run(loads(SCENE), tmp_path)
    told = read(tmp_path / "summary.json")
    assert told["outcome"] == "interrupted"
    assert ("certificate" in told) == figures
    assert judged(told) == []


def test_collapse_threshold_and_limit_analysis(judged, tmp_path, capsys):
    scene = tmp_path / "scene.toml"
    scene.write_text(SCENE, encoding="utf-8")
    assert main(["collapse", str(scene), "--acceleration", "x", "--out", str(tmp_path), "--quiet"]) == 0
    told = read(tmp_path / "collapse.json")
    assert (told["outcome"], told["schema"]) == ("bracketed", "collapse/1")
    assert judged(told) == []
    asked = ["threshold", str(scene), "joints.0.friction", "--between", "0", "1", "--out", str(tmp_path)]
    assert main(asked) == 2
    told = read(tmp_path / "threshold.json")
    assert (told["outcome"], told["schema"]) == ("stands at both ends", "threshold/1")
    assert judged(told) == []
    capsys.readouterr()
    assert main(["limit", str(scene), "--tilt", "x", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["schema"] == "limit/1"
    assert judged(told) == []


def test_refinement(judged, tmp_path):
    """The run with the finest mesh says how the error came down."""
    scene = tmp_path / "scene.toml"
    scene.write_text(SCENE.replace('"rigid"', '"elastic"'), encoding="utf-8")
    main(["run", str(scene), "--refine-to", "30 %", "--out", str(tmp_path), "--quiet"])
    told = read(tmp_path / "summary.json")
    assert told["refinement"]["rounds"]
    assert judged(told) == []


def test_study(judged, tmp_path, capsys):
    scene = tmp_path / "scene.toml"
    scene.write_text(SCENE, encoding="utf-8")
    varied = ["--vary", "structures.it.count=1,2", "--workers", "1", "--out", str(tmp_path)]
    assert main(["study", str(scene), *varied, "--json", "--quiet"]) == 0
    printed, told = json.loads(capsys.readouterr().out), read(tmp_path / "study.json")
    assert told["schema"] == printed["schema"] == "study/1"
    assert judged(told) == judged(printed) == []


def test_what_is_otherwise_is_a_fault(judged, tmp_path):
    run(loads(SCENE), tmp_path)
    told = read(tmp_path / "summary.json")
    assert judged(told) == []
    for wrong in ({"steps": "one"}, {"outcome": "fine"}, {"more": 1}, {"schema": "run/0"}, {"moving": [1]}):
        assert judged(told | wrong), wrong
    assert judged({key: value for key, value in told.items() if key != "certificate"})


def test_a_result_is_a_short_table():
    lines = repr(solve_scene(loads(SCENE))).splitlines()
    assert lines[0].split() == ["outcome", "equilibrium"]
    assert [line.split("  ")[0] for line in lines] == [
        "outcome", "message", "size", "end", "balance", "overlap", "support it.ground", "CPU",
    ]  # fmt: skip
    assert "3 blocks, 4 contacts" in lines[2]


def test_remarks_are_data(tmp_path):
    """A block that nothing holds is named, in the result and in the file."""
    flying = ["structures=[{kind='block', name='a', material='stone', size=[1.0, 1.0]}]"]
    dynamics = "analysis={kind='dynamics', step=0.1, duration=0.1, theta=1.0}"
    result = run(loads(SCENE, [*flying, dynamics]), tmp_path)
    (made,) = (one for one in result.summary.remarks if one.code == "loose")
    assert made.blocks == ("a",)
    told = read(tmp_path / "summary.json")["remarks"]
    assert {"code": "loose", "sentence": made.sentence, "blocks": ["a"]} in told


def test_the_published_schema_is_that_of_the_program(repository, capsys):
    """Of a key that goes, or changes its meaning, the version in ``schema`` must tell; then print it anew."""
    assert main(["info", "--schema"]) == 0
    published = (repository / "docs" / "results.schema.json").read_text(encoding="utf-8")
    assert json.loads(capsys.readouterr().out) == json.loads(published)


def test_what_rounding_makes_of_measures_has_their_units():
    """Of forces it is as large as the forces, whatever the step; of shares of them it stays."""

    def told(*changes):
        return solve_scene(loads(SCENE, changes)).summary.certificate.rounding

    once, more = told(), told("loads.gravity=[0.0, -10000.0]")
    weight = 2 * 2400.0 * 10.0
    assert -1e-14 * weight < once.min_normal_reaction < 0
    assert more.min_normal_reaction == pytest.approx(1e3 * once.min_normal_reaction, rel=1e-9)
    for name in ("natural_map", "cone_violation", "block_balance", "global_balance"):
        assert 0 < getattr(once, name) < 1e-14
        assert getattr(more, name) == pytest.approx(getattr(once, name), rel=1e-9)
    dynamics = "analysis={{kind='dynamics', step={0}, duration={0}, theta=1.0}}"
    short, long = told(dynamics.format(0.001)), told(dynamics.format(0.1))
    assert short.min_normal_reaction == pytest.approx(long.min_normal_reaction, rel=1e-6)
