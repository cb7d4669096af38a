"""``stress_error``: the field of files and pictures is what the estimate says, element by element."""

import numpy as np
import pytest

from masonry_fem.analyses.run import run
from masonry_fem.output import fields, sheet
from masonry_fem.output.render import can_render
from masonry_fem.output.scenery import Scenery
from masonry_fem.output.stone_pictures import draw_error
from masonry_fem.output.stress_error import block_errors
from masonry_fem.output.view import view
from masonry_fem.output.vtu import with_nan
from masonry_fem.scene.specs import MeshSettings, Output, Override
from tests.analyses.test_refine import wall

draws = pytest.mark.skipif(not can_render(), reason="no OpenGL")


@pytest.fixture(scope="module")
def refined(tmp_path_factory):
    """A wall with finer elements in one brick and a rigid one beside it."""
    out = tmp_path_factory.mktemp("wall")
    scene = wall(
        overrides=(
            Override(blocks="wall.c4.b2", mesh=MeshSettings(size=0.0625)),
            Override(blocks="wall.c1.b1", fidelity="rigid"),
        ),
        output=Output(fields=True, pictures=False),
    )
    return run(scene, out), out


def test_field_sums_up_to_the_estimate(refined):
    result, _ = refined
    model, state = result.march.model, result.march.state
    blocks = Scenery.of(model, state).blocks
    density = np.asarray(blocks.cell_data[fields.STRESS_ERROR])
    area = np.asarray(blocks.compute_cell_sizes(length=False, volume=False).cell_data["Area"])
    errors = block_errors(model, state)
    for block, square in zip(errors.block, errors.square, strict=True):
        mine = np.asarray(blocks.cell_data[fields.BLOCK]) == block
        assert (density * area)[mine].sum() == pytest.approx(square, rel=1e-9)
    known = np.isfinite(density)
    assert set(np.unique(np.asarray(blocks.cell_data[fields.BLOCK])[known])) == set(errors.block)


def test_files_have_it(refined):
    import pyvista as pv

    result, out = refined
    cells = pv.read(next((out / "fields").glob("blocks_*.vtu"))).cell_data
    with_nan(cells)
    found = np.asarray(cells["stress_error"])
    expected = Scenery.of(result.march.model, result.march.state).blocks.cell_data[fields.STRESS_ERROR]
    np.testing.assert_array_equal(found, expected)


@pytest.mark.slow
@draws
def test_picture(refined, tmp_path):
    from matplotlib.image import imread

    result, out = refined
    path = draw_error(Scenery.of(result.march.model, result.march.state, title="Wall"), tmp_path / "e.png")
    image = imread(path)[..., :3][sheet.TOP : -sheet.BOTTOM]
    assert (image.max(axis=-1) < 0.15).sum() > 50, "the worst elements are nearly black"
    assert image.std() > 0.03
    again = view(out, tmp_path / "again")
    same = next(one for one in again if one.name == "stress_error.png")
    assert imread(same).shape[1] == imread(path).shape[1]
