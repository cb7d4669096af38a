"""The notebook runs cell by cell, and each cell ends in what a notebook can show."""

import ast
import json

import pytest

from masonry_fem.output.render import can_render


def cells(repository):
    """Sources of the notebook's cells of code."""
    book = json.loads((repository / "demos" / "notebook.ipynb").read_text(encoding="utf-8"))
    code = [cell for cell in book["cells"] if cell["cell_type"] == "code"]
    assert all(cell["outputs"] == [] for cell in code)  # what runs make is not kept
    return ["".join(cell["source"]) for cell in code]


def shown(source, names):
    """What a notebook shows below a cell: the value of its last expression."""
    tree = ast.parse(source)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, "<cell>", "exec"), names)
    return None if last is None else eval(compile(ast.Expression(last.value), "<cell>", "eval"), names)


@pytest.mark.slow
@pytest.mark.skipif(not can_render(), reason="nothing to draw with")
def test_the_notebook_runs(repository, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names, made = {}, []
    for source in cells(repository):
        made.append(shown(source, names))
    scene, result, thrust, used, joints, found, thrusts = made
    assert "kind = &quot;arch&quot;" in scene._repr_html_()
    assert "equilibrium" in result._repr_html_()
    assert thrust._repr_png_().startswith(b"\x89PNG")
    assert used._repr_png_() != thrust._repr_png_()
    assert len(joints) == 12
    assert 10.4 < found.value < 10.6  # [cm]; limit analysis: 10.48 to 10.53
    assert list(thrusts.values()) == sorted(thrusts.values())
