"""ContactProblem: its checks, its two forms, and its files."""

from dataclasses import fields, replace

import numpy as np
import pytest
from scipy import sparse

from masonry_fem.errors import ProblemError
from masonry_fem.nscd import ContactProblem, load_problem, save_problem
from masonry_fem.nscd.files import PLAIN_KEYS
from masonry_fem.nscd.scaling import contact_scale
from tests.nscd.plain_form import condensed
from tests.nscd.walls import cubes, rigid_wall


@pytest.fixture(scope="module")
def bricks():
    return rigid_wall(3, 2, step=0.01)


@pytest.fixture(scope="module")
def elastic():
    return cubes(2, inertia=1.0).problem(inertia=1.0)


@pytest.mark.parametrize("name", ["bricks", "elastic"])
def test_condensed_form_gives_the_same_velocities(name, request):
    problem = request.getfixturevalue(name)
    p = np.random.default_rng(0).normal(size=problem.free_velocity.shape)
    U = problem.balanced_velocity(p)
    gained = problem.rigid_mass * (U - problem.rigid_velocity)
    assert problem.body_impulse(p) + problem.rigid_impulse == pytest.approx(gained, rel=1e-12, abs=1e-9)
    plain = condensed(problem)
    expected = problem.velocity(p, U)
    assert plain.velocity(p, plain.rigid_velocity) == pytest.approx(
        expected, abs=1e-12 * np.abs(expected).max()
    )
    assert plain.compliance.blocksize == (3, 3)


@pytest.mark.parametrize("name", ["bricks", "elastic"])
def test_some_contacts_alone_move_as_if_the_others_carried_nothing(name, request):
    """The whole problem gives the velocities of the kept contacts, whose cohesion stays with them."""
    whole, rng = request.getfixturevalue(name), np.random.default_rng(3)
    whole = replace(whole, cohesion_offset=rng.normal(size=whole.free_velocity.shape))
    kept = np.flatnonzero(rng.random(whole.count) < 0.5)
    p, U = np.zeros_like(whole.free_velocity), rng.normal(size=whole.rigid_mass.shape)
    p[kept] = rng.normal(size=(len(kept), 3))
    part = whole.only(kept)
    expected = whole.velocity(p, U)[kept]
    assert part.velocity(p[kept], U) == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())
    assert part.body_impulse(p[kept]) == pytest.approx(whole.body_impulse(p), abs=1e-12)
    assert part.contact_part(p[kept], expected) == pytest.approx(
        whole.contact_part(p, whole.velocity(p, U))[kept]
    )
    assert (part.friction == whole.friction[kept]).all()


def test_rigid_maps_may_lie_in_memory_in_any_order(bricks):
    other = replace(bricks, rigid_map=bricks.rigid_map[:, :, :, [0, 1, 2, 3, 4, 5]])
    assert not other.rigid_map.flags.c_contiguous
    U = np.random.default_rng(0).normal(size=bricks.rigid_mass.shape)
    moved = (other.rigid_matrix() @ U.ravel()).reshape(bricks.free_velocity.shape)
    assert moved == pytest.approx(bricks.contact_velocity(U), rel=1e-12)


def test_rigid_matrix_is_the_map(bricks):
    B = bricks.rigid_matrix()
    U = np.random.default_rng(1).normal(size=bricks.rigid_mass.shape)
    p = np.random.default_rng(2).normal(size=bricks.free_velocity.shape)
    assert B @ U.ravel() == pytest.approx(bricks.contact_velocity(U).ravel(), abs=1e-13)
    assert B.T @ p.ravel() == pytest.approx(bricks.body_impulse(p).ravel(), abs=1e-12)


def test_scale_is_elastic_where_there_is_elasticity(elastic, bricks):
    c = elastic.count
    blocks = elastic.compliance.toarray().reshape(c, 3, c, 3)
    expected = [np.linalg.norm(blocks[i, :, i], 2) for i in range(c)]
    assert contact_scale(elastic) == pytest.approx(expected)
    W = bricks.delassus().toarray()
    assert contact_scale(bricks)[0] == pytest.approx(np.linalg.norm(W[:3, :3], 2))
    static = replace(bricks, rigid_mass=0 * bricks.rigid_mass)
    assert contact_scale(static) == pytest.approx(contact_scale(bricks))
    nothing = ContactProblem.plain(np.zeros((6, 6)), np.zeros((2, 3)), 0.5)
    assert np.array_equal(contact_scale(nothing), [1, 1])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"friction": (17, -0.2)}, r"contact 17: friction is -0.2, expected >= 0"),
        ({"friction": (3, np.nan)}, r"contact 3: friction is nan"),
        ({"free_velocity": ((5, 1), np.inf)}, r"contact 5: free_velocity is inf"),
        ({"rigid_mass": ((2, 4), -1.0)}, r"body 2: rigid_mass is -1.0"),
        ({"rigid_impulse": ((1, 0), np.nan)}, r"body 1: rigid_impulse is nan"),
        ({"bodies": ((4, 0), 99)}, r"contact 4: body 99 does not exist, expected 0 to 6"),
        ({"bodies": ((4, 0), -2)}, r"contact 4: body -2 does not exist"),
    ],
)
def test_a_wrong_value_is_named(bricks, change, message):
    ((name, (where, value)),) = change.items()
    array = getattr(bricks, name).copy()
    array[where] = value
    with pytest.raises(ProblemError, match=message):
        replace(bricks, **{name: array})


def test_wrong_shapes_are_named(bricks):
    with pytest.raises(ProblemError, match=r"friction has shape \(2,\), expected \("):
        replace(bricks, friction=np.ones(2))
    with pytest.raises(ProblemError, match="blocks of"):
        replace(bricks, compliance=sparse.bsr_array((3 * bricks.count,) * 2, blocksize=(1, 1)))
    with pytest.raises(ProblemError, match="expected 2 or 3 a contact"):
        ContactProblem.plain(np.eye(8), np.ones(8), [0.5, 0.5])
    with pytest.raises(ProblemError, match="contact 1: compliance to contact 0 is not finite"):
        ContactProblem.plain(
            np.where(np.arange(36).reshape(6, 6) == 18, np.nan, np.eye(6)), np.ones(6), [1, 1]
        )


@pytest.mark.parametrize("name", ["bricks", "elastic"])
def test_saved_and_read_back_bit_for_bit(name, request, tmp_path):
    problem = request.getfixturevalue(name)
    save_problem(problem, tmp_path / "step 3.npz")
    back = load_problem(tmp_path / "step 3.npz")
    for item in fields(problem):
        one, other = getattr(problem, item.name), getattr(back, item.name)
        if item.name == "compliance":
            one, other = one.toarray(), other.toarray()
        assert np.array_equal(one, other), item.name


def test_reads_the_plain_format(tmp_path):
    W = sparse.csr_array(np.diag([1.0, 2, 2, 3, 4, 4]))
    q = np.arange(6.0)
    np.savez(
        tmp_path / "a.npz", W_data=W.data, W_indices=W.indices, W_indptr=W.indptr, shape=W.shape, q=q,
        mu=[0.1, 0.2], dim=3, name="a",
    )  # fmt: skip
    problem = load_problem(tmp_path / "a.npz")
    assert np.array_equal(problem.compliance.toarray(), W.toarray())
    assert np.array_equal(problem.free_velocity, q.reshape(2, 3))
    assert np.array_equal(problem.friction, [0.1, 0.2])


def test_files_that_are_no_problem(tmp_path):
    with pytest.raises(ProblemError, match="no such file"):
        load_problem(tmp_path / "missing.npz")
    (tmp_path / "text.npz").write_text("hello")
    with pytest.raises(ProblemError, match=r"not an \.npz file"):
        load_problem(tmp_path / "text.npz")
    np.savez(tmp_path / "other.npz", a=1)
    with pytest.raises(ProblemError, match="holds a; expected"):
        load_problem(tmp_path / "other.npz")


@pytest.fixture
def saved(bricks, tmp_path):
    """Arrays of a problem on disk, in the own and in the plain form."""
    save_problem(bricks, tmp_path / "own.npz")
    with np.load(tmp_path / "own.npz") as file:
        own = {name: file[name] for name in file.files if name not in PLAIN_KEYS}  # beside it, and not read
    plain = {
        "W_data": np.array([2.0, 1.0]), "W_indices": np.array([0, 1]), "W_indptr": np.array([0, 1, 2]),
        "shape": np.array([2, 2]), "q": np.array([-1.0, 0.3]), "mu": np.array([0.5]), "dim": np.array(2),
    }  # fmt: skip
    return {"own": own, "plain": plain}


OTHERS = {
    "nothing": None, "empty": np.zeros(0), "7": np.array(7), "text": np.array("text"),
    "nan": np.full((2, 2, 2), np.nan), "large": np.array([10**9, -5]), "complex": 1j * np.ones(3),
}  # fmt: skip
# a friction of all contacts alike, numbers of any size, and entries of a compliance that has none
FITS = {("plain", "7"): {"mu"}, ("plain", "large"): {"W_data", "q"}, ("own", "empty"): {"compliance_indices"}}


@pytest.mark.parametrize("form", ["own", "plain"])
@pytest.mark.parametrize("name", OTHERS)
def test_arrays_that_are_missing_or_ill_shaped_are_refused(saved, form, name, tmp_path):
    """Whatever one array is replaced by: an error that names the file; what happens to fit holds together."""
    arrays, other, refused = saved[form], OTHERS[name], {}
    for key in arrays:
        changed = {one: values for one, values in arrays.items() if one != key or other is not None}
        if other is not None:
            changed[key] = other
        np.savez(tmp_path / "changed.npz", **changed)
        try:
            load_problem(tmp_path / "changed.npz").compliance.check_format(full_check=True)
        except ProblemError as error:
            refused[key] = str(error)
    assert arrays.keys() - refused.keys() == FITS.get((form, name), set())
    assert all("changed.npz: " in message for message in refused.values())


def test_row_pointers_that_fall_are_refused(saved, tmp_path):
    """Also where there is no entry, so that nothing stands between them."""
    pointer = saved["own"]["compliance_indptr"].copy()
    pointer[1] = -1
    np.savez(tmp_path / "changed.npz", **saved["own"] | {"compliance_indptr": pointer})
    with pytest.raises(ProblemError, match=r"changed\.npz: the array 'compliance_indptr' falls"):
        load_problem(tmp_path / "changed.npz")


def test_what_impulses_do_where_there_is_mass_is_divided_by_it(bricks):
    mass = np.random.default_rng(3).uniform(0.5, 2.0, bricks.rigid_mass.shape)
    problem = replace(bricks, rigid_mass=mass)
    B = problem.rigid_matrix().toarray()
    assert problem.delassus().toarray() == pytest.approx(B / mass.ravel() @ B.T, rel=1e-12, abs=1e-12)
