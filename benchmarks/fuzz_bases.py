"""Fuzz bases: sound scenes and files, small, that the fuzzer mutates."""

from __future__ import annotations

import io
import json
import tempfile
import tomllib
from pathlib import Path
from typing import Any

import meshio
import numpy as np

from benchmarks.mutation import Tree
from masonry_fem.analyses.run import run
from masonry_fem.meshing.session import session
from masonry_fem.scene import loads

ROOT = Path(__file__).resolve().parents[1]
LARGE = {"rubble_wall", "window_bay", "dome_section", "tower", "dome_on_piers", "flying_buttresses"}

# what is run, in a fraction of a second each: every kind of analysis, joint, fidelity and material law
SMALL = {
    "rigid_arch": """
dimension = 2
fidelity = "rigid"
materials = { stone = { density = 2400 } }
structures = [
    { kind = "arch", name = "arch", material = "stone", radius = 2, thickness = "40 cm", voussoirs = 7 },
]
joints = [{ friction = 0.7 }]
loads = { gravity = [0, -9.81], points = [{ block = "arch.v03", vector = [0, "-1 kN"], point = [0, 2] }] }
probes = [{ name = "key", block = "arch.v03", point = [0, 2] }]
output = { interfaces = true, pictures = false, fields = false }
""",
    "elastic_stack": """
dimension = 2
mesh = { element = "Q1", divisions = [2, 2] }
materials = { stone = { density = 2400, young = "10 GPa", poisson = 0.2 } }
structures = [{ kind = "stack", name = "pier", material = "stone", size = [1, 0.5], count = 2 }]
loads = { gravity = [0, -9.81], tractions = [{ on = "pier.b2/top", vector = [0, "-1 MPa"] }] }
analysis = { kind = "statics", load_steps = 2 }
output = { pictures = false, fields = false, determinacy = true }
""",
    "sliding": """
dimension = 2
fidelity = "rigid"
materials = { stone = { density = 2400 } }
structures = [{ kind = "stack", name = "s", material = "stone", size = [1, 1], count = 2, gap = "1 mm" }]
joints = [{ friction = 0.3, restitution = 0.5, form = "velocity", dynamic_friction = 0.2 }]
initial = [{ blocks = "s.b2", velocity = [1, 0], spin = 0.1 }]
analysis = { kind = "dynamics", step = "5 ms", duration = "0.05 s", theta = 0.5 }
contact = { update = "redetect", every = 2, reach = "2 mm" }
output = { pictures = false, every = 5 }
[loads]
gravity = [0, -9.81]
accelerations = [{ vector = [1, 0], time = { kind = "record", path = "quake.csv" } }]
""",
    "wall": """
fidelity = "rigid"
materials = { brick = { density = 1800, young = 5e9 } }
structures = [
    { kind = "wall", name = "wall", material = "brick", brick = [0.5, 0.25, 0.25], columns = 3, courses = 3 },
]
joints = [
    { friction = "no slip" },
    { friction = 0.6, law = { kind = "mohr_coulomb", cohesion = "10 kPa" }, interface = "bed" },
]
loads = { gravity = [0, 0, -9.81], gravity_time = { kind = "sine", frequency = 2, amplitude = 0.1 } }
analysis = { kind = "equilibrium", strategy = "brutal_damping", step = "10 ms", max_steps = 5 }
solver = { method = "nsgs", tolerance = 1e-8, max_iterations = 500 }
overrides = [{ blocks = "wall.c1.*", fidelity = "rigid" }]
output = { pictures = false, fields = false, limit_analysis = true }
[[supports]]
on = "wall.ground"
motion = { displacement = [0, 0, "-1 mm"], time = { kind = "table", points = [[0, 0], [1, 1]] } }
""",
    "box": """
dimension = 3
fidelity = "elastic"
mesh = { element = "P1", size = 0.6 }
materials = { stone = { density = 2400, young = 1e9, damping = { mass = 0.1, stiffness = "1 ms" } } }
structures = [
    { kind = "block", name = "a", material = "stone", size = [1, 1, 1] },
    { kind = "block", name = "b", material = "stone", size = [1, 1, 1], position = [0, 0, 1] },
]
supports = [{ on = "a/bottom", components = ["x", "y", "z"] }]
overrides = [{ blocks = "b", fidelity = "rigid" }]
output = { cuts = [{ name = "middle", point = [0.5, 0.5, 0.5], normal = [1, 0, 0] }], pictures = false }
[loads]
gravity = [0, 0, -9.81]
lines = [{ block = "b", vector = [0, 0, -10], start = [0, 0, 2], end = [1, 0, 2] }]
""",
    "yielding": """
dimension = 2
fidelity = "auto"
plane = "strain"
mesh = { element = "Q1", divisions = [2, 2] }
structures = [
    { kind = "block", name = "a", material = "rock", size = [1, 1] },
    { kind = "block", name = "b", material = "tuff", size = [1, 1], position = [0, 1] },
    { kind = "block", name = "c", material = "brick", size = [1, 1], position = [0, 2] },
    { kind = "block", name = "d", material = "own", size = [1, 1], position = [0, 3] },
]
overrides = [{ blocks = "[bd]", fidelity = "inelastic" }]
joints = [{ friction = 0.6 }]
loads = { gravity = [0, -9.81] }
analysis = { kind = "statics", load_steps = 2 }
output = { pictures = false, fields = false }
[materials.rock]
density = 2400
young = "10 GPa"
promote_at = 0.8
[materials.rock.inelastic]
law = "mohr_coulomb"
cohesion = "0.2 MPa"
friction_angle = 30
dilatancy_angle = "10 deg"
tensile_strength = 1e5
fracture_energy = 100
shear_fracture_energy = 300
residual = 0.1
[materials.tuff]
density = 1600
young = 5e9
[materials.tuff.inelastic]
law = "drucker_prager"
cohesion = 3e5
friction_angle = 35
hardening = 1e8
tension_cutoff = 1e5
crushing_pressure = "5 MPa"
crushing_hardening = 1e8
fit = "plane_strain"
[materials.brick]
density = 1800
young = 5e9
[materials.brick.inelastic]
law = "brittle_damage"
tensile_strength = "0.5 MPa"
fracture_energy = 100
[materials.own]
density = 1800
young = 5e9
[materials.own.inelastic]
law = "python"
file = "law.py"
name = "Compaction"
trusted = true
parameters = { crushing_pressure = 4e6 }
[[supports]]
on = "a/bottom"
[[supports]]
on = "d/top"
motion = { displacement = [0, "-1.2 mm"], time = { kind = "table", points = [[0, 0], [1, 1]] } }
""",
    "staged": """
dimension = 2
fidelity = "rigid"
materials = { stone = { density = 2400, compressive_strength = "20 MPa", tensile_strength = "1 MPa" } }
design = { material_factor = 2, loads = { gravity = 1.35 }, share = 0.1 }
structures = [
    { kind = "stack", name = "pier", material = "stone", size = [1, 0.5], count = 3 },
    { kind = "block", name = "prop", material = "stone", size = [0.2, 1.5], position = [1, 0] },
]
supports = [{ on = "prop" }]
joints = [{ friction = 0.6 }, { friction = 0, between = ["prop", "pier.*"] }]
loads = { gravity = [0, -9.81] }
output = { pictures = false, fields = false, report = true, checkpoint_steps = 1 }
[[stages]]
name = "first"
without = ["pier.b3"]
[[stages]]
name = "propped"
[[stages]]
name = "free"
after = "propped"
without = ["prop"]
analysis = { kind = "statics", load_steps = 2 }
[[stages]]
name = "shaken"
without = ["prop"]
analysis = { kind = "dynamics", step = "5 ms", duration = "0.02 s" }
""",
}
FOREIGN = """
dimension = 3
fidelity = "{fidelity}"
materials = {{ stone = {{ density = 2400, young = 1e9 }} }}
mesh = {{ element = "P1", size = 0.7 }}
structures = [{{ kind = "{kind}", name = "f", material = "stone", path = "file{ending}"{more} }}]
loads = {{ gravity = [0, 0, -9.81] }}
reading = {{ time = 30, memory = "1 GB" }}
output = {{ pictures = false, fields = false }}
"""
LAW = (
    (ROOT / "docs" / "add_a_material.md").read_text(encoding="utf-8").split("```python\n")[1].split("```")[0]
)
QUAKE = "time,acceleration\n0,0\n0.01,1\n0.02,-1\n0.1,0\n"
GEO = """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 1};
Box(2) = {0, 0, 1, 1, 1, 1};
Physical Volume("lower") = {1};
Physical Volume("upper") = {2};
"""


HELD = {
    "geo": "lower",
    "msh 4.1": "lower",
    "msh 2.2": "lower",
    "msh 4.1 binary": "lower",
    "obj": "block0",
    "json": "b0",
}


def scene_trees() -> tuple[list[Tree], list[Tree]]:
    """Scenes to check (those of the demos and the small ones), and those to run."""
    small = [tomllib.loads(text) for text in SMALL.values()]
    demos = [
        tomllib.loads(path.read_text(encoding="utf-8"))
        for path in sorted((ROOT / "demos").glob("*.toml"))
        if path.stem not in LARGE
    ]
    return [*demos, *small], small


def files() -> list[tuple[str, str, bytes]]:
    """Name, ending and content of sound files of every kind that is read."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [half for a, b, c, d in quads for half in ((a, b, c), (a, c, d))]
    made = [
        ("geo", ".geo", GEO.encode()), ("geo untrusted", ".geo", GEO.encode()),
        ("stl", ".stl", _stl(corners, triangles)), ("stl binary", ".stl", _binary_stl(corners, triangles)),
        ("obj", ".obj", _obj(corners, quads)), ("ply", ".ply", _ply(corners, quads)),
        ("json", ".json", _compas(corners, quads)), ("survey csv", ".csv", _survey().encode()),
        ("record csv", ".csv", QUAKE.encode()), ("law py", ".py", LAW.encode()),
        ("npz", ".npz", _contact()), ("npz plain", ".npz", _plain()),
        ("vtu", ".vtu", _meshio(corners, "vtu", binary=False)),
        ("vtu binary", ".vtu", _meshio(corners, "vtu", binary=True)),
        ("vtk", ".vtk", _meshio(corners, "vtk", binary=False)),
    ]  # fmt: skip
    return [*made, *_gmsh()]


def _stl(corners: Any, triangles: Any) -> bytes:
    lines = ["solid box"]
    for loop in triangles:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex " + " ".join(map(str, corners[v])) for v in loop]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, "endsolid box", ""]).encode()


def _binary_stl(corners: Any, triangles: Any) -> bytes:
    kind = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    table = np.zeros(len(triangles), kind)
    table["corners"] = corners[np.array(triangles)]
    return bytes(80) + len(triangles).to_bytes(4, "little") + table.tobytes()


def _obj(corners: Any, quads: Any) -> bytes:
    lines = []
    for number, shift in enumerate((0.0, 1.0)):
        lines += [f"o block{number}", *(f"v {x} {y} {z + shift}" for x, y, z in corners), "usemtl face"]
        lines += ["f " + " ".join(str(8 * number + v + 1) for v in loop) for loop in quads]
    return "\n".join([*lines, ""]).encode()


def _ply(corners: Any, quads: Any) -> bytes:
    head = ["ply", "format ascii 1.0", f"element vertex {len(corners)}"]
    head += [f"property double {axis}" for axis in "xyz"]
    head += [f"element face {len(quads)}", "property list uchar int vertex_indices", "end_header"]
    rows = [" ".join(map(str, row)) for row in corners] + ["4 " + " ".join(map(str, loop)) for loop in quads]
    return "\n".join([*head, *rows, ""]).encode()


def _compas(corners: Any, quads: Any) -> bytes:
    def mesh(shift: float) -> Tree:
        return {
            "dtype": "compas.datastructures/Mesh",
            "data": {
                "vertex": {str(k): {"x": x, "y": y, "z": z + shift} for k, (x, y, z) in enumerate(corners)},
                "face": {str(k): list(loop) for k, loop in enumerate(quads)},
            },
        }

    nodes = {str(k): {"block": mesh(float(k)), "is_support": k == 0} for k in range(2)}
    return json.dumps({"dtype": "compas_assembly/Assembly", "data": {"graph": {"node": nodes}}}).encode()


def _survey() -> str:
    rows = ["stone,vertex,x,y,z"]
    for course in range(2):
        for stone in range(2):
            x, z = float(stone), 0.5 * course
            outline = [(x, z), (x + 1, z), (x + 1, z + 0.5), (x, z + 0.5)]
            rows += [f"c{course}s{stone},{k + 1},{u},0.0,{w}" for k, (u, w) in enumerate(outline)]
    return "\n".join([*rows, ""])


def _contact() -> bytes:
    """What ``run --save-contact 1`` leaves."""
    with tempfile.TemporaryDirectory() as folder:
        run(loads(SMALL["rigid_arch"]), Path(folder) / "out", save_contact=1)
        return (Path(folder) / "out" / "contact_1.npz").read_bytes()


def _plain() -> bytes:
    stream = io.BytesIO()
    np.savez(
        stream, W_data=np.array([2.0, 1.0]), W_indices=np.array([0, 1]), W_indptr=np.array([0, 1, 2]),
        shape=np.array([2, 2]), q=np.array([-1.0, 0.3]), mu=np.array([0.5]), dim=np.array(2),
    )  # fmt: skip
    return stream.getvalue()


def _meshio(corners: Any, kind: str, *, binary: bool) -> bytes:
    order = [0, 4, 6, 2, 1, 5, 7, 3]
    points = np.concatenate([corners, corners + np.array([0, 0, 1])])
    cells = np.array([order, [v + 8 for v in order]])
    mesh = meshio.Mesh(points, [("hexahedron", cells)], cell_data={"block": [np.array([1, 2])]})
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"file.{kind}"
        mesh.write(path, binary=binary)
        return path.read_bytes()


def _gmsh() -> list[tuple[str, str, bytes]]:
    made = []
    with tempfile.TemporaryDirectory() as folder, session("bases") as gmsh:
        gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
        gmsh.model.occ.addBox(0, 0, 1, 1, 1, 1)
        gmsh.model.occ.synchronize()
        step = Path(folder) / "file.step"
        gmsh.write(str(step))
        made.append(("step", ".step", step.read_bytes()))
        for tag, name in ((1, "lower"), (2, "upper")):
            gmsh.model.addPhysicalGroup(3, [tag], name=name)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 1.0)
        gmsh.model.mesh.generate(3)
        for name, version, binary in (("msh 4.1", 4.1, 0), ("msh 2.2", 2.2, 0), ("msh 4.1 binary", 4.1, 1)):
            gmsh.option.setNumber("Mesh.MshFileVersion", version)
            gmsh.option.setNumber("Mesh.Binary", binary)
            path = Path(folder) / "file.msh"
            gmsh.write(str(path))
            made.append((name, ".msh", path.read_bytes()))
    return made
