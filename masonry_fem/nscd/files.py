"""Contact problems on disk: the project's own .npz, and the plain one of public collections.

Own files hold every array of the split form under its name, the compliance in block-sparse parts; those of
cohesion only where there is some. Those of a run have more, which readers may do without: where there is a
plain form, its arrays, and what the step found (``output.contact_file``).
Plain files hold W (CSR: ``W_data``, ``W_indices``, ``W_indptr``, ``shape``), ``q``, ``mu``, ``dim``.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.errors import ProblemError
from masonry_fem.host.atomic import write_atomic
from masonry_fem.nscd.problem import COHESION, ContactProblem

FORMAT = "masonry_fem contact problem 1"
ARRAYS = (
    "friction", "free_velocity", "bodies", "rigid_map", "rigid_mass", "rigid_impulse", "rigid_velocity",
)  # fmt: skip
PLAIN_KEYS = frozenset({"W_data", "W_indices", "W_indptr", "shape", "q", "mu", "dim"})


def save_problem(
    problem: ContactProblem, path: str | Path, more: Mapping[str, NDArray[Any]] | None = None
) -> None:
    """Write a problem to an .npz file that ``load_problem`` reads back bit for bit.

    Parameters
    ----------
    problem : The contact problem.
    path : The file.
    more : Further arrays to write, by name.

    Raises
    ------
    OutputError : The file cannot be written.
    """
    parts = {name: getattr(problem, name) for name in ARRAYS}
    parts |= {name: getattr(problem, name) for name in COHESION if getattr(problem, name) is not None}
    parts |= plain_arrays(problem) | dict(more or {})
    compliance = problem.operator.matrix()
    content = io.BytesIO()
    np.savez_compressed(
        content,
        format=np.array(FORMAT),
        compliance_data=compliance.data,
        compliance_indices=compliance.indices,
        compliance_indptr=compliance.indptr,
        **parts,
    )
    write_atomic(Path(path), content.getvalue())


def plain_arrays(problem: ContactProblem) -> dict[str, Any]:
    """W, q and μ of the plain form; {} in statics and with cohesion, which have none."""
    if problem.cohesive or not problem.count or (problem.rigid_mass <= 0).any():
        return {}
    W = sparse.csr_array(problem.delassus())
    return {
        "W_data": W.data,
        "W_indices": W.indices,
        "W_indptr": W.indptr,
        "shape": np.array(W.shape),
        "q": problem.plain_velocity().ravel(),
        "mu": problem.friction,
        "dim": np.array(problem.dimension),
    }


def load_problem(path: str | Path) -> ContactProblem:
    """Read a contact problem from an .npz file, as ``save_problem`` writes it or in the plain format.

    Raises
    ------
    ProblemError : There is no such file, it is no .npz file, or it has neither format.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
    except FileNotFoundError as error:
        raise ProblemError(f"{path}: no such file") from error
    except Exception as error:  # zip files that are damaged raise errors of many kinds
        raise ProblemError(f"{path}: not an .npz file of a contact problem") from error
    own = str(arrays.pop("format", "")) == FORMAT
    if not own and not arrays.keys() >= PLAIN_KEYS:
        missing = ", ".join(sorted(PLAIN_KEYS - arrays.keys()))
        raise ProblemError(
            f"{path}: holds {', '.join(sorted(arrays))}; expected a problem written by --save-contact, "
            f"or the plain format, which also has {missing}"
        )
    try:
        return _own(arrays) if own else _plain(arrays)
    except ProblemError as error:
        raise ProblemError(f"{path}: {error}") from error
    except KeyError as error:
        raise ProblemError(f"{path}: lacks the array {error}; save the problem again") from error
    except (ValueError, TypeError, IndexError, OverflowError) as error:
        raise ProblemError(
            f"{path}: its arrays do not fit together ({error}); save the problem again"
        ) from error


def _own(arrays: dict[str, NDArray[Any]]) -> ContactProblem:
    bodies = _whole(arrays, "bodies")
    parts: dict[str, Any] = {name: _real(arrays, name) for name in ARRAYS if name != "bodies"}
    parts |= {name: _real(arrays, name) for name in COHESION if name in arrays}
    c, d = parts["free_velocity"].shape
    compliance = sparse.bsr_array(_blocks(arrays, "compliance"), shape=(c * d, c * d)) if c else _empty()
    compliance.check_format(full_check=True)  # an index beyond the ends would be read there
    return ContactProblem(compliance=compliance, bodies=bodies, **parts)


def _plain(arrays: dict[str, NDArray[Any]]) -> ContactProblem:
    rows, columns = _whole(arrays, "shape").tolist()
    q = _real(arrays, "q").reshape(-1, int(_whole(arrays, "dim")))
    if (rows, columns) != (q.size, q.size):
        raise ProblemError(f"shape is {(rows, columns)}, expected {(q.size, q.size)} for q of that size")
    W = sparse.csr_array(_blocks(arrays, "W"), shape=(rows, columns))
    W.check_format(full_check=True)
    return ContactProblem.plain(W, q, _real(arrays, "mu"))


def _blocks(arrays: dict[str, NDArray[Any]], name: str) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    ends = _whole(arrays, f"{name}_indptr")
    if (np.diff(ends) < 0).any():  # which SciPy overlooks where there are no entries
        raise ProblemError(f"the array '{name}_indptr' falls, expected numbers that do not")
    return _real(arrays, f"{name}_data"), _whole(arrays, f"{name}_indices"), ends


def _real(arrays: dict[str, NDArray[Any]], name: str) -> NDArray[Any]:
    values = arrays[name]
    if values.dtype.kind not in "fiub":
        raise ProblemError(f"the array '{name}' holds {values.dtype}, expected real numbers")
    return values.astype(float, copy=False)


def _whole(arrays: dict[str, NDArray[Any]], name: str) -> NDArray[Any]:
    if arrays[name].dtype.kind not in "iu" and not np.array_equal(
        _real(arrays, name), np.round(arrays[name])
    ):
        raise ProblemError(f"the array '{name}' holds {arrays[name].dtype}, expected whole numbers")
    return arrays[name] if arrays[name].dtype.kind == "i" else arrays[name].astype(np.int64)


def _empty() -> sparse.bsr_array:
    return sparse.bsr_array((0, 0), blocksize=(1, 1))
