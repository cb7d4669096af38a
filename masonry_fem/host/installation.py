"""Installation: what this machine must offer, looked for without loading anything heavy.

Each ``require_...`` returns silently or raises an InstallationError of one sentence with its cure;
``report`` lists everything for ``masonry-fem info``. Libraries that many scenes never load come with *extras*
of the package (``EXTRAS``); before one is loaded ``require_extra`` or ``lacking`` is asked.
"""

from __future__ import annotations

import ctypes
import os
import platform
import re
import shutil
import sys
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path

import masonry_fem
from masonry_fem.errors import InstallationError

OLDEST_PYTHON = (3, 12)
OLDEST_DOLFINX = (0, 9)
LIBRARIES = ("numpy", "scipy", "numba", "msgspec")
EXTRAS = {  # as in pyproject.toml: what is imported
    "gmsh": ("gmsh",),
    "pictures": ("pyvista", "matplotlib"),
    "movies": ("imageio_ffmpeg",),
    "browser": ("trame", "trame_vtk", "trame_vuetify"),
    "dxf": ("ezdxf",),
}
RENDERERS = {
    "EGL": ("libEGL.so.1", "libEGL.so"),
    "OSMesa": ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"),
}
RENDERING_CURE = "install libEGL or libOSMesa (Debian: apt install libegl1 libgl1-mesa-dri)"
GMSH_CURE = "install what it draws with (Debian: apt install libglu1-mesa libxcursor1 libxft2 libxinerama1)"
DOLFINX_CURE = (
    "install it (pip install 'masonry-fem[fenicsx]', Debian 13: apt install python3-dolfinx, "
    'conda: fenics-dolfinx) or make every block fidelity = "rigid"'
)


@dataclass(frozen=True, slots=True)
class Finding:
    """One line of the report: what, its version or state, and the cure where it is missing."""

    name: str
    state: str
    cure: str = ""


def require_python() -> None:
    """Refuse a Python that is too old.

    Raises
    ------
    InstallationError : It is.
    """
    if sys.version_info < OLDEST_PYTHON:
        raise InstallationError(
            f"Python {platform.python_version()} is too old, expected 3.12 or later; "
            "make the virtual environment with a newer python3"
        )


def require_fenicsx() -> None:
    """Refuse to go on where elastic blocks are wanted and DOLFINx is missing or too old.

    Raises
    ------
    InstallationError : It is.
    """
    found = dolfinx_version()
    if found is None:
        raise InstallationError(f"elastic blocks need DOLFINx, which is not installed; {DOLFINX_CURE}")
    if numbers_of(found) < OLDEST_DOLFINX:
        raise InstallationError(f"DOLFINx {found} is too old, expected 0.9 or later; {DOLFINX_CURE}")


def lacking(extra: str) -> str | None:
    """None where all libraries of an extra are installed, else which are not and how to install them."""
    missing = [name for name in EXTRAS[extra] if find_spec(name) is None]
    if not missing:
        return None
    verb = "is" if len(missing) == 1 else "are"
    return f"{' and '.join(missing)} {verb} not installed; pip install 'masonry-fem[{extra}]'"


def require_extra(extra: str, consequence: str) -> None:
    """Refuse to go on if libraries of an extra are missing.

    Parameters
    ----------
    extra : Name of the extra in ``EXTRAS``.
    consequence : What cannot be done without it; the error message begins with it.

    Raises
    ------
    InstallationError : A library is missing; the message says how to install it.
    """
    if lack := lacking(extra):
        raise InstallationError(f"{consequence}: {lack}")


def require_compiler() -> None:
    """Refuse to go on where FFCx would find no C compiler for the element kernels.

    Raises
    ------
    InstallationError : There is none.
    """
    if compiler() is None:
        wanted = os.environ.get("CC")
        named = f" (CC is '{wanted}', which cannot be run)" if wanted else ""
        raise InstallationError(
            f"elastic blocks need a C compiler and none was found{named}; "
            "install one (Debian: apt install gcc) or name it in the environment variable CC"
        )


def why_no_pictures() -> str | None:
    """None where pictures can be drawn, else what is missing and how to install it."""
    if lack := lacking("pictures"):
        return f"no pictures: {lack}"
    if not sys.platform.startswith("linux") or os.environ.get("DISPLAY") or renderers():
        return None
    return (
        f"no pictures: neither libEGL nor libOSMesa can be loaded and there is no X server; {RENDERING_CURE}"
    )


def dolfinx_version() -> str | None:
    """DOLFINx's version, None where it is not installed; DOLFINx itself is not imported."""
    if find_spec("dolfinx") is None and find_spec("dolfinx_solver") is None:
        return None
    for distribution in ("fenics-dolfinx", "dolfinx-solver-real", "dolfinx-solver-complex", "dolfinx"):
        if found := package_version(distribution):
            return found
    return declared_version("dolfinx") or _imported_version()


def compiler() -> str | None:
    """Path of the C compiler that FFCx would use."""
    wanted = os.environ.get("CC", "").split()[:1] or ["cc", "gcc", "clang"]
    return next(filter(None, map(shutil.which, wanted)), None)


def renderers() -> tuple[str, ...]:
    """Names of the off-screen rendering libraries that can be loaded."""
    return tuple(name for name, files in RENDERERS.items() if any(map(_loadable, files)))


def numbers_of(text: str) -> tuple[int, ...]:
    """Leading numbers of a version: ``0.11.0.post0`` gives (0, 11, 0)."""
    numbers: list[int] = []
    for part in text.split("."):
        digits = part[: len(part) - len(part.lstrip("0123456789"))]
        if not digits:
            break
        numbers.append(int(digits))
        if digits != part:
            break
    return tuple(numbers)


def package_version(name: str) -> str | None:
    """Version of an installed package, None where it is not installed."""
    try:
        return version(name)
    except PackageNotFoundError:
        return None


def declared_version(name: str) -> str | None:
    """``__version__`` as a package's ``__init__.py`` writes it, without running that."""
    spec = find_spec(name)
    if spec is None or spec.origin is None or not Path(spec.origin).is_file():
        return None
    source = Path(spec.origin).read_text(encoding="utf-8", errors="replace")
    declared = re.search(r"^__version__\s*=\s*['\"]([^'\"]+)['\"]", source, re.MULTILINE)
    return declared[1] if declared else None


def report() -> list[Finding]:
    """Everything that matters on this machine, and advice on what is missing."""
    old_python = sys.version_info < OLDEST_PYTHON
    drawing = renderers()
    findings = [
        Finding("masonry_fem", masonry_fem.__version__),
        Finding("python", platform.python_version(), "use Python 3.12 or later" if old_python else ""),
        *(_package(name, name) for name in LIBRARIES),
        *(_package(name, f"'masonry-fem[{extra}]'") for extra, names in EXTRAS.items() for name in names),
        _dolfinx(),
        _found("petsc", package_version("petsc4py") or declared_version("petsc4py"), DOLFINX_CURE),
        _found("C compiler", compiler(), "apt install gcc, or set CC"),
        *(_found(name, "available" if name in drawing else None, "") for name in RENDERERS),
    ]
    if not lacking("pictures") and why_no_pictures():
        findings.append(Finding("pictures", "not possible", RENDERING_CURE))
    return findings


def _found(name: str, state: str | None, cure: str) -> Finding:
    """The state of what is there, or else the cure."""
    return Finding(name, state or "missing", "" if state else cure)


def _package(name: str, source: str) -> Finding:
    return _found(name, package_version(name), f"pip install {source}")


def _dolfinx() -> Finding:
    """DOLFINx, with the cure also where it is too old."""
    found = dolfinx_version()
    fresh = found is not None and numbers_of(found) >= OLDEST_DOLFINX
    return Finding("dolfinx", found or "missing", "" if fresh else DOLFINX_CURE)


def _loadable(name: str) -> bool:
    try:
        ctypes.CDLL(name)
    except OSError:
        return False
    return True


def _imported_version() -> str | None:
    """For DOLFINx without package metadata: ask a separate process, this one stays light."""
    import subprocess  # noqa: PLC0415  (rare path)

    command = [sys.executable, "-c", "import dolfinx; print(dolfinx.__version__)"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return done.stdout.strip() or None
