"""``stone_plastic_strain.png``: where a stone has yielded, drawn by the run and again from its files."""

import pytest

from masonry_fem.analyses.run import run
from masonry_fem.output import sheet
from masonry_fem.output.render import can_render
from masonry_fem.output.view import view
from masonry_fem.scene.reading import check
from masonry_fem.scene.specs import (
    Joint,
    Loads,
    Material,
    MeshSettings,
    Motion,
    Output,
    Scene,
    Statics,
    Support,
    Table,
    material_record,
)
from masonry_fem.structures.stack import StackStructure

pytest.importorskip("pyvista")


def squeezed(closing: float) -> Scene:
    """A stone on its ground under a platen; it yields from 1.7 mm on."""
    law = material_record("drucker_prager", cohesion=1e6, friction_angle=30.0)
    down = Motion(displacement=(0.0, -closing), time=Table(points=((0.0, 0.0), (1.0, 1.0))))
    return check(
        Scene(
            dimension=2,
            fidelity="inelastic",
            materials={"m": Material(density=2000.0, young=2e9, poisson=0.2, inelastic=law)},
            structures=(
                StackStructure(
                    name="s", material="m", size=(1.0, 1.0), count=2, mesh=MeshSettings(divisions=(4, 4))
                ),
            ),
            supports=(Support(on="s.b2", motion=down),),
            joints=(Joint(friction=0.6),),
            loads=Loads(gravity=(0.0, 0.0)),
            analysis=Statics(load_steps=2),
            output=Output(fields=True, pictures=True),
        )
    )


@pytest.mark.slow
@pytest.mark.skipif(not can_render(), reason="neither EGL nor OSMesa here")
def test_what_has_yielded_is_drawn(tmp_path):
    from matplotlib.image import imread

    run(squeezed(5e-3), tmp_path / "yields")
    path = tmp_path / "yields" / "stone_plastic_strain.png"
    middle = imread(path)[..., :3][sheet.TOP : -sheet.BOTTOM]
    assert middle.std() > 0.05
    assert (middle.max(axis=-1) < 0.2).sum() > 100, "the worst elements are nearly black"
    again = view(tmp_path / "yields", tmp_path / "again")
    assert path.name in [one.name for one in again]


@pytest.mark.slow
@pytest.mark.skipif(not can_render(), reason="neither EGL nor OSMesa here")
def test_nothing_is_drawn_where_nothing_has(tmp_path):
    run(squeezed(1e-4), tmp_path)
    assert (tmp_path / "von_mises.png").is_file()
    assert not (tmp_path / "stone_plastic_strain.png").exists()
