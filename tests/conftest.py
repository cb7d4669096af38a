"""What all tests share: one thread, no windows, the neighbouring data folder, Hypothesis settings."""

import os
import signal
from pathlib import Path

import pytest
from hypothesis import settings

# before NumPy is first imported: the tests run in two processes on two cores
for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")
if "OPENBLAS_CORETYPE" in os.environ:
    os.environ.setdefault("OPENBLAS_L2_SIZE", "512")  # else some kernels crash, see tests/kernels.py
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # else each test that starts the program compiles all of it
os.environ.setdefault("PYVISTA_OFF_SCREEN", "true")
os.environ.setdefault("MPLBACKEND", "Agg")

# shells have their background jobs ignore Ctrl-C, and what these start inherits that
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# The same examples every time, so that a run tells of the change and not of the dice;
# ``--hypothesis-profile=search`` looks for new ones.
settings.register_profile("steady", deadline=None, derandomize=True, max_examples=50)
settings.register_profile("search", deadline=None, max_examples=1000)
settings.load_profile("steady")

REPOSITORY = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def repository() -> Path:
    """The folder that holds pyproject.toml, demos and meshes."""
    return REPOSITORY


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Public reference data (``fc/*.npz`` ...): ``data`` of MASONRY_FEM_SHARED or of the folder
    ``shared`` beside the repository; tests that need it are skipped where there is none.
    """
    folder = Path(os.environ.get("MASONRY_FEM_SHARED", REPOSITORY.parent / "shared")) / "data"
    if not folder.is_dir():
        pytest.skip("no shared data: set MASONRY_FEM_SHARED to the folder that holds data/fc")
    return folder
