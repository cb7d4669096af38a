"""Contact problems on disk: the project's own .npz, and the plain one of public collections.

Own files hold every array of the split form under its name, the compliance in block-sparse parts;
those of cohesion only where there is some.
Plain files hold W (CSR: ``W_data``, ``W_indices``, ``W_indptr``, ``shape``), ``q``, ``mu``, ``dim``.
"""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.atomic import write_atomic
from masonry_fem.errors import ProblemError
from masonry_fem.nscd.problem import COHESION, ContactProblem

FORMAT = "masonry_fem contact problem 1"
ARRAYS = (
    "friction", "free_velocity", "bodies", "rigid_map", "rigid_mass", "rigid_impulse", "rigid_velocity",
)  # fmt: skip
PLAIN_KEYS = frozenset({"W_data", "W_indices", "W_indptr", "shape", "q", "mu", "dim"})


def save_problem(problem: ContactProblem, path: str | Path) -> None:
    """Write a problem to an .npz file that ``load_problem`` reads back bit for bit."""
    parts = {name: getattr(problem, name) for name in ARRAYS}
    parts |= {name: getattr(problem, name) for name in COHESION if getattr(problem, name) is not None}
    compliance = problem.compliance
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


def load_problem(path: str | Path) -> ContactProblem:
    """Read a problem in the own or in the plain format.

    Raises
    ------
    ProblemError : No such file, not an .npz, or neither format.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
    except FileNotFoundError as error:
        raise ProblemError(f"{path}: no such file") from error
    except (OSError, ValueError, zipfile.BadZipFile, AttributeError, EOFError) as error:
        raise ProblemError(f"{path}: not an .npz file of a contact problem") from error
    if str(arrays.get("format", "")) == FORMAT:
        return _own(arrays)
    if arrays.keys() >= PLAIN_KEYS:
        return _plain(arrays)
    missing = ", ".join(sorted(PLAIN_KEYS - arrays.keys()))
    raise ProblemError(
        f"{path}: holds {', '.join(sorted(arrays))}; expected a problem written by --save-contact, "
        f"or the plain format, which also has {missing}"
    )


def _own(arrays: dict[str, NDArray[Any]]) -> ContactProblem:
    parts = {name: arrays[name] for name in ARRAYS}
    parts |= {name: arrays[name] for name in COHESION if name in arrays}
    c, d = parts["free_velocity"].shape
    blocks = (arrays["compliance_data"], arrays["compliance_indices"], arrays["compliance_indptr"])
    compliance = sparse.bsr_array(blocks, shape=(c * d, c * d)) if c else _empty()
    return ContactProblem(compliance=compliance, **parts)


def _plain(arrays: dict[str, NDArray[Any]]) -> ContactProblem:
    shape = (int(arrays["shape"][0]), int(arrays["shape"][1]))
    W = sparse.csr_array((arrays["W_data"], arrays["W_indices"], arrays["W_indptr"]), shape=shape)
    return ContactProblem.plain(W, arrays["q"].reshape(-1, int(arrays["dim"])), arrays["mu"])


def _empty() -> sparse.bsr_array:
    return sparse.bsr_array((0, 0), blocksize=(1, 1))
