"""DXF: closed polylines of a drawing are the stones of a wall; the drawings are made here."""

import numpy as np
import pytest

from masonry_fem.contact.detection import detect
from masonry_fem.errors import GeometryError, InstallationError
from masonry_fem.host import installation
from masonry_fem.importing.dxf import read_dxf
from masonry_fem.scene.specs import MeshSettings
from masonry_fem.structures import build_structure
from masonry_fem.structures.survey import SurveyStructure

ezdxf = pytest.importorskip("ezdxf")

BRICK = (400.0, 200.0)  # millimetres


def rectangle(x, y):
    w, h = BRICK
    return [(x, y), (x + w, y), (x + w, y + h), (x, y + h)]


def drawing(path, *, units=4, extra=lambda space: None):
    """Two bricks below and one above them, in millimetres, on two layers."""
    doc = ezdxf.new(units=units)
    space = doc.modelspace()
    for x in (0.0, 400.0):
        space.add_lwpolyline(rectangle(x, 0.0), close=True, dxfattribs={"layer": "course 1"})
    space.add_polyline2d(rectangle(200.0, 200.0), close=True, dxfattribs={"layer": "top"})
    extra(space)
    doc.saveas(path)
    return path


def wall(path, dimension=3, **keys):
    spec = SurveyStructure(name="w", material="s", path=path.name, depth=0.3, scale=0.001, **keys)
    return build_structure(spec, dimension, path.parent, MeshSettings())


@pytest.mark.parametrize("dimension", [2, 3])
def test_outlines_become_stones_that_touch(tmp_path, dimension, caplog):
    made = wall(drawing(tmp_path / "wall.dxf"), dimension)
    assert [block.name for block in made.blocks] == ["w.course_1_1", "w.course_1_2", "w.top", "w.ground"]
    joints = detect(made)
    depth = 0.3 if dimension == 3 else 1.0
    areas = sorted(joint.area / depth for joint in joints)
    np.testing.assert_allclose(areas, [0.2, 0.2, 0.2, 0.4, 0.4], atol=1e-9)
    assert "unit" not in caplog.text
    if dimension == 3:
        top = made.shapes[2].solid.vertices @ made.blocks[2].pose.rotation.T + made.blocks[2].pose.translation
        assert np.ptp(top[:, 2]) == pytest.approx(0.2), "the drawing's y is upwards"
        assert top[:, 1].min() == pytest.approx(0.0, abs=1e-9)


def test_names_go_from_left_to_right_and_upwards(tmp_path):
    def more(space):
        for x in (800.0, -400.0):
            space.add_lwpolyline(rectangle(x, 0.0), close=True, dxfattribs={"layer": "course 1"})

    found = read_dxf(drawing(tmp_path / "wall.dxf", extra=more), "wall.dxf", 0.001)
    left = {name: corners[:, 0].min() for name, corners in found}
    assert left == {"course_1_1": -400, "course_1_2": 0, "course_1_3": 400, "course_1_4": 800, "top": 200}


def test_inserted_blocks_and_arcs(tmp_path):
    def more(space):
        block = space.doc.blocks.new("brick")
        block.add_lwpolyline(rectangle(0.0, 0.0), close=True, dxfattribs={"layer": "inserted"})
        space.add_blockref("brick", (1000.0, 500.0), dxfattribs={"rotation": 90})
        half = [(0, 1000, 0, 0, 0), (400, 1000, 0, 0, 1.0)]  # a half circle upon a straight side
        space.add_lwpolyline(half, close=True, dxfattribs={"layer": "round"})

    found = dict(read_dxf(drawing(tmp_path / "wall.dxf", extra=more), "wall.dxf", 0.001))
    turned = found["inserted"]
    np.testing.assert_allclose(
        [turned.min(axis=0), turned.max(axis=0)], [[800, 0, 500], [1000, 0, 900]], atol=1e-9
    )
    arc = found["round"]
    radius = np.linalg.norm(arc[:, [0, 2]] - [200, 1000], axis=1)
    np.testing.assert_allclose(radius, 200.0, rtol=2e-3)
    assert len(arc) > 8


def test_what_is_doubtful_is_told(tmp_path, caplog):
    def more(space):
        space.add_lwpolyline(rectangle(800.0, 0.0), close=False)

    read_dxf(drawing(tmp_path / "wall.dxf", extra=more), "wall.dxf", 1.0)
    assert "1 polylines are open" in caplog.text
    assert "write scale = 0.001" in caplog.text


def test_files_without_outlines_and_a_missing_library_are_told(tmp_path, monkeypatch):
    doc = ezdxf.new()
    doc.modelspace().add_line((0, 0), (1, 0))
    doc.saveas(tmp_path / "lines.dxf")
    with pytest.raises(GeometryError, match="no closed polyline but 1 LINE"):
        read_dxf(tmp_path / "lines.dxf", "lines.dxf", 1.0)
    (tmp_path / "no.dxf").write_text("no drawing")
    with pytest.raises(GeometryError, match="no DXF"):
        read_dxf(tmp_path / "no.dxf", "no.dxf", 1.0)
    monkeypatch.setitem(installation.EXTRAS, "dxf", ("no_such_library",))
    with pytest.raises(InstallationError, match="masonry-fem\\[dxf\\]"):
        read_dxf(tmp_path / "lines.dxf", "lines.dxf", 1.0)
