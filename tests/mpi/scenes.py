"""Scenes that one process and several ranks run."""

WALL = """
title = "wall"
dimension = 3
fidelity = "{fidelity}"
mesh = {{ element = "Q1", divisions = {divisions} }}
materials = {{ stone = {{ young = 10e9, poisson = 0.2, density = 2400 }} }}
loads = {{ gravity = [{push}, 0.0, -9.81] }}
analysis = {{ {analysis} }}
solver = {{ tolerance = {tolerance}, linear = "{linear}" }}
output = {{ pictures = false }}
[[structures]]
kind = "wall"
name = "wall"
material = "stone"
brick = [0.5, 0.25, 0.25]
columns = {columns}
courses = {courses}
[[joints]]
friction = 0.6
{law}
"""
MORTAR = """
[joints.law]
kind = "elastic"
normal_stiffness = 1e11
tangential_stiffness = 4e10
"""
VAULT = """
title = "vault"
dimension = 3
fidelity = "elastic"
mesh = { size = 0.12 }
materials = { stone = { young = 10e9, poisson = 0.2, density = 2400 } }
analysis = { kind = "statics" }
solver = { tolerance = 1e-10 }
output = { pictures = false }
[[structures]]
kind = "barrel_vault"
name = "vault"
material = "stone"
radius = 2.0
thickness = 0.4
depth = 1.0
embrace = 120.0
voussoirs = 5
stones = 2
irregularity = 0.15
[[joints]]
friction = 0.6
"""
USUAL = {
    "fidelity": "elastic", "push": 0.981, "analysis": 'kind = "statics"', "tolerance": 1e-10,
    "linear": "krylov", "columns": 5, "courses": 5, "law": "", "divisions": "[4, 2, 2]",
}  # fmt: skip
STEPS = 'kind = "dynamics", step = 0.01, duration = 0.03'
SCENES = {
    "elastic statics": {},
    "elastic dynamics": {"analysis": STEPS},
    "elastic, many contacts, by the program's own choice": {"linear": "auto", "columns": 10, "courses": 9},
    "elastic joints": {"law": MORTAR},
    "rigid statics": {"fidelity": "rigid", "linear": "auto"},
    "rigid dynamics": {"fidelity": "rigid", "linear": "auto", "analysis": STEPS, "push": 8.0},
}
FEW = {"columns": 1, "courses": 5, "divisions": "[10, 6, 6]"}
PARTS = {"linear": "auto", "columns": 32, "courses": 32, "push": 0.0, "tolerance": 1e-9}
SPLIT = {name for name in SCENES if name.startswith("elastic")}


def scene(name: str) -> str:
    """A scene as TOML."""
    if name == "unlike stones":
        return VAULT
    return WALL.format(**USUAL | (SCENES | {"few stones": FEW, "parts": PARTS})[name])
