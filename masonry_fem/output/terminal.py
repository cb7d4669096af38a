"""Terminal: what the console shows of a run: its steps, and a table of its summary afterwards."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_fem.host.phases import At, phase
from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.output.components import greatest, in_words, rounded
from masonry_fem.output.extremes import combination_rows, places_rows
from masonry_fem.output.limit_table import support_rows
from masonry_fem.output.recorder import StepReport
from masonry_fem.output.refinement_table import refinement_rows
from masonry_fem.output.search_table import mechanism_lines
from masonry_fem.output.sheet import quantity
from masonry_fem.output.told_words import count as _count
from masonry_fem.output.told_words import (
    damping_words,
    finer_elements,
    greatest_supports,
    joint_words,
    stone_words,
)
from masonry_fem.records.told import plain

if TYPE_CHECKING:
    from rich.console import Console

SHOWN_LINES = 10  # of a mechanism, of supports
BALANCES = ("natural_map", "cone_violation", "block_balance", "global_balance", "energy_balance")
ROUNDED = 1e-9  # relative errors from which it is told what rounding makes of them
SIZES = ("blocks", "shapes", "meshes", "factorisations", "contacts")
FEM_SIZES = ("meshes", "factorisations")
GOOD = ("equilibrium", "finished")
FALLEN = ("no_equilibrium", "no_convergence")  # whose stresses balance no loads
NO_WAY = 1e-12  # opening or sliding that is rounding [m]
SMALL = 1e-6  # friction that is left: less is none
FINE = 0.1  # estimated error of the stress, from which it is said what lessens it
ROUNDING = 1e-8  # smaller errors are shown as '<' and this
CHANGES = ("supports", "probes", "stress", "block_stress")  # by other contact points
AXES = {2: "xy", 3: "xyz"}


class Progress:
    """Recorder that tells of each step as of a phase: step, residual, kinetic energy.

    Parameters
    ----------
    total : Number of steps, if it is known.
    end : Time at which the march ends, if not [s].
    """

    dense = True

    def __init__(self, total: int | None = None, *, end: float | None = None) -> None:
        self._total, self._end = total, end
        self._phase: AbstractContextManager[At] | None = None
        self._at: At | None = None

    def start(self, model: Model) -> None:
        """The march begins."""
        self._phase = phase("steps", self._total if self._end is None else self._end)
        self._at = self._phase.__enter__()

    def record(self, model: Model, state: SystemState, report: StepReport) -> None:
        """A step is done."""
        if self._at is None:
            return
        self._at(
            report.step if self._end is None else report.time,
            f"step {report.step}" + (f"/{self._total}" if self._total else "")
            + f", t {report.time:.4g}, residual {getattr(report, 'natural_map', float('nan')):.1e}, "
            + f"kinetic {quantity(getattr(report, 'kinetic_energy', 0.0), 'J')}",
        )  # fmt: skip

    def end(self, made: Any, determinacy: Any) -> None:
        """The march has ended."""
        if self._phase is not None:
            self._phase.__exit__(None, None, None)
            self._phase = self._at = None

    def close(self, summary: Any) -> list[Path]:
        """The same, where it has ended otherwise."""
        self.end(None, None)
        return []


def print_summary(told: Any, console: Console | None = None) -> None:
    """Print a table of a summary in the order of ``ORDER``; rows without data are left out.

    The outcome stands first.

    Parameters
    ----------
    told : A record, or the contents of ``summary.json``.
    console : Where to write; by default standard output.
    """
    from rich.console import Console  # noqa: PLC0415
    from rich.panel import Panel  # noqa: PLC0415
    from rich.table import Table  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    console, summary = console or Console(), plain(told)
    outcome = str(summary.get("outcome", "unknown"))
    style = "green" if outcome in GOOD else "red"
    head = Text(outcome.replace("_", " "), style=f"bold {style}")
    if message := summary.get("message"):
        head.append(f"\n{message}", style="default")
    console.print(Panel(head, border_style=style, title=summary.get("title") or None, title_align="left"))
    table = Table(box=None, show_header=False, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column(style="bold", no_wrap=True)
    table.add_column(style="dim", no_wrap=True)
    table.add_column()
    for part in ORDER:
        section = ""
        for heading, name, value in part(summary):
            table.add_row("" if heading == section else heading, name, Text(value))
            section = heading
    console.print(table)


Rows = Iterator[tuple[str, str, str]]


def _size(summary: Mapping[str, Any]) -> Rows:
    # a rigid scene has no meshes and factorises no matrices of its blocks
    names = [name for name in SIZES if name in summary and (summary[name] or name not in FEM_SIZES)]
    if names:
        yield "model", "", ", ".join(_plural(summary[name], name) for name in names)
    if "unknowns" in summary:
        yield "model", "unknowns", _count(summary["unknowns"])
    if "time" in summary:
        steps = summary.get("steps")
        after = f" after {_count(steps)} step{'s' if steps != 1 else ''}" if steps is not None else ""
        yield "model", "end", f"t = {summary['time']:.6g}{after}"


def _contacts(summary: Mapping[str, Any]) -> Rows:
    if status := summary.get("status"):
        yield "contacts", "", ", ".join(f"{_count(number)} {name}" for name, number in status.items())


def _mechanism(summary: Mapping[str, Any]) -> Rows:
    if found := summary.get("mechanism"):
        yield "mechanism", "", str(found["sentence"])
        for line in mechanism_lines(found, SHOWN_LINES):
            yield "mechanism", "", line


def _start(summary: Mapping[str, Any]) -> Rows:
    if told := summary.get("start"):
        ways = {
            True: "reached from a start without stress",
            False: "stands only if pre-stressed",
            None: "not known",
        }
        yield "start", "", ways[told["reached"]]
        if told.get("least_thrust") is not None:
            unit = _force_unit(len(summary.get("applied", ())))
            where = ", ".join(" / ".join(pair) for pair in told["joints"][:SHOWN_LINES])
            yield "start", "least thrust", f"{quantity(told['least_thrust'], unit, 4)} between {where}"


def _joints(summary: Mapping[str, Any]) -> Rows:
    if told := summary.get("joints"):
        yield "joints", "", joint_words(told)
        for name in ("greatest_opening", "greatest_sliding"):
            if told[name]["value"] > NO_WAY:
                where = told[name]["interface"]
                yield "joints", name.replace("_", " "), f"{quantity(told[name]['value'], 'm')} in {where}"
        if edge := told.get("nearest_edge"):
            way = f"{100 * edge['value']:.0f} % of the way from the middle"
            yield "joints", "pressure nearest to edge", f"{way} in {edge['interface']}"
        if left := told.get("least_margin"):
            yield "joints", "least μ − T/N", f"{_clean(left['value'])} in {left['interface']}"


def _certificate(summary: Mapping[str, Any]) -> Rows:
    units = {"max_penetration": "m", "min_normal_reaction": _force_unit(len(summary.get("applied", ())))}
    told = summary.get("certificate") or {}
    rounding = told.get("rounding") or {}
    for name, value in told.items():
        if name == "written":
            yield from _written(value)
            continue
        number = value["natural_map"] if name == "rounding" else value
        shown = f"{_number(number)} {units.get(name, '')}".rstrip()
        if name in BALANCES and number is not None and (rounding.get(name) or 0.0) > number > ROUNDED:
            shown += f" (rounding alone makes {_number(rounding[name])})"
        yield "certificate", name.replace("_", " "), shown


def _written(told: Mapping[str, Any]) -> Rows:
    """What the written results leave open, worst over the steps, with its blocks."""
    for name, words, unit in (
        ("balance", "written balance", "of a block's load"),
        ("turning", "… where elastic blocks are now", "of a block's load"),
        ("overlap", "deepest overlap", "m"),
    ):
        part = told.get(name) or {}
        if part.get("blocks"):
            where = f"{' and '.join(part['blocks'])}, step {part['step']}"
            yield "certificate", words, f"{_number(part['value'])} {unit} ({where})"


def _stress(summary: Mapping[str, Any]) -> Rows:
    stress = summary.get("stress") or {}
    names = {
        "max_von_mises": ("max von Mises", " at Gauss points"),
        "max_von_mises_nodal": ("… as pictured", " at nodes"),
        "p95_von_mises": ("95 % of volume under", ""),
        "min_principal": ("greatest compression", ""),
        "max_principal": ("greatest tension", ""),
    }
    for key, (name, where) in names.items():
        value = stress.get(key)
        if isinstance(value, Mapping):
            yield "stress", name, f"{quantity(value['value'], 'Pa')}{where} in {value['block']}"
        elif value is not None:
            yield "stress", name, quantity(value, "Pa")


def _stress_error(summary: Mapping[str, Any]) -> Rows:
    error = (summary.get("stress") or {}).get("error")
    if not error:
        return
    most = f" (most in {error['worst'][0]['block']})" if error["relative"] > 0 else ""
    yield "errors", "of stress, estimated", f"{_percent(error['relative'])}{most}"
    if error["relative"] > FINE and summary.get("outcome") not in FALLEN:
        yield "errors", "… less with", finer_elements(summary)
    if error["unjudged"]:
        blocks = _plural(error["unjudged"], "blocks")
        yield "errors", "… but more", f"{blocks} one linear element thick, whose errors do not show"


def _errors(summary: Mapping[str, Any]) -> Rows:
    yield from _stress_error(summary)
    told = summary.get("errors") or {}
    if contact := told.get("contact"):
        words = [f"{name.replace('_', ' ')} {_percent(contact[name])}" for name in CHANGES if name in contact]
        yield "errors", "by other contact points", ", ".join(words) or str(contact["note"])
    if time := told.get("time"):
        lost = f"{_percent(time['dissipated'])} of the largest energy lost to the scheme"
        yield "errors", "of time steps", lost if "note" not in time else str(time["note"])


def _utilisation(summary: Mapping[str, Any]) -> Rows:
    told = summary.get("utilisation")
    if not told:
        return
    share = _percent(told["share"])
    yield (
        "utilisation",
        f"worst {share} of a stone",
        "1: all is used; ± error (at a point, of the mean stress)",
    )
    for stone in told["worst"]:
        yield "utilisation", stone["block"], utilisation_words(stone)
    yield "utilisation", "partial factor", f"strengths are divided by {told['material_factor']:g}"
    if told.get("load_factor") is not None:
        yield "utilisation", "stresses may grow", f"× {told['load_factor']:.3g} until a stone uses 1"
    yield from (("utilisation", "stones", words) for _, words in stone_words(told))


def utilisation_words(stone: Mapping[str, Any]) -> str:
    """How much of its strength a stone uses: ``0.58 ± 0.07 compression (0.8, 0.3)``.

    Parameters
    ----------
    stone : Its record in a summary.
    """
    mean = f"{stone['of_mean']:.2g}"
    if stone.get("local") is None:
        return f"{mean} {stone['governs']} (of the mean stress of a rigid stone)"
    error = "" if stone.get("error") is None else f" ± {stone['error']:.1g}"
    return f"{stone['local']:.2g}{error} {stone['governs']} ({stone['greatest']:.2g}, {mean})"


def factor_words(summary: Mapping[str, Any]) -> str:
    """The partial factors of loads in words: ``gravity × 1.35, points × 1.5``; empty where all are 1.

    Parameters
    ----------
    summary : What ``summary.json`` says.
    """
    factors = summary.get("load_factors") or {}
    return ", ".join(f"{kind} × {factor:g}" for kind, factor in factors.items())


def _forces(summary: Mapping[str, Any]) -> Rows:
    if (applied := summary.get("applied")) is not None:
        yield "forces", "applied", _force(applied)
    if factors := factor_words(summary):
        yield "forces", "… by partial factors", factors
    supports = summary.get("supports") or {}
    shown, others = greatest_supports(supports, SHOWN_LINES)
    for name in shown:
        yield "forces", f"support {name}", _force(supports[name])
    if others:
        yield "forces", "…", f"{_count(others)} more with smaller forces, in summary.json"


def _stages(summary: Mapping[str, Any]) -> Rows:
    """How each stage has ended, and what its supports gave: all else is of the last one."""
    for stage in summary.get("stages") or ():
        yield "stages", stage["name"], f"{stage['outcome'].replace('_', ' ')}; forces of its supports:"
        supports = stage.get("supports") or {}
        shown, others = greatest_supports(supports)
        for name in shown:
            yield "stages", f"  {name}", _force(supports[name])
        if others:
            yield (
                "stages",
                "  …",
                f"{_count(others)} more with smaller forces, in {stage['name']}/summary.json",
            )


def _ties(summary: Mapping[str, Any]) -> Rows:
    told = summary.get("ties") or {}
    unit = _force_unit(len(summary.get("applied", ())))
    hardest = sorted(told, key=lambda name: -told[name]["force"])[:SHOWN_LINES]
    for name in (one for one in told if one in hardest):
        yield "ties", name, _tie_words(told[name], unit)
    if len(told) > len(hardest):
        yield "ties", "…", f"{_count(len(told) - len(hardest))} more with smaller forces, in ties.csv"


def _tie_words(tie: Mapping[str, Any], unit: str) -> str:
    """What a tie bears."""
    if tie["snapped"]:
        return f"snapped, its ends {quantity(tie['elongation'], 'm', 4)} further apart than its length"
    if tie["force"] == 0:
        return f"slack by {quantity(-tie['elongation'], 'm', 4)}"
    words = f"{quantity(tie['force'], unit, 5)}, {quantity(tie['stress'], 'Pa', 4)}"
    words += f", longer by {quantity(tie['elongation'], 'm', 4)}"
    if tie["plastic_strain"] > 0:
        return f"{words}, yielded by {_percent(tie['plastic_strain'])}"
    return (
        words if tie.get("utilisation") is None else f"{words}, {_percent(tie['utilisation'])} of its yield"
    )


def _limits(summary: Mapping[str, Any]) -> Rows:
    told = summary.get("limit_analysis")
    if not told:
        return
    yield "limit analysis", "", str(told["message"])
    dimension = len(summary.get("applied", ())) or 3
    for section, name, value in support_rows(told, dimension):
        yield "limit analysis", f"{section}, {name}", value


def _determinacy(summary: Mapping[str, Any]) -> Rows:
    told = summary.get("determinacy")
    if not told:
        return
    yield "determinacy", "reactions", str(told["reactions"])
    if "interfaces_determined" in told:
        known, left = told["interfaces_determined"], told["interfaces_not_determined"]
        yield "determinacy", "resultants", f"{_count(known)} determined, {_count(left)} not"
        for name, components in told["supports_not_determined"].items():
            yield "determinacy", f"support {name}", f"not determined: {', '.join(components)}"


def _probes(summary: Mapping[str, Any]) -> Rows:
    told = summary.get("probes") or {}
    beside = greatest(told.values())
    for name, displacement in told.items():
        yield "displacements", name, _vector(displacement, "m", beside)


def _damping(summary: Mapping[str, Any]) -> Rows:
    if words := damping_words(summary):
        yield "damping", "", words


def _response(summary: Mapping[str, Any]) -> Rows:
    response = summary.get("response") or {}
    beside = max((told["greatest"] for told in response.values()), default=0.0)
    for name, told in response.items():
        sizes = (told["greatest"], float(np.linalg.norm(told["residual"])))
        peak, residual = (quantity(rounded(size, "m", beside), "m", 4) for size in sizes)
        yield "response", name, f"peak {peak} at {told['greatest_time']:.4g} s, residual {residual}"
    if told := summary.get("spectra"):
        for name, peak in told["peaks"].items():
            size, period = peak["pseudo_acceleration"], peak["period"]
            yield f"spectra, {100 * told['damping']:.3g} %", name, f"peak {size:.4g} m/s² at {period:.3g} s"


def _cost(summary: Mapping[str, Any]) -> Rows:
    if solver := summary.get("solver"):
        words = [_plural(value, name.replace("_", " ")) for name, value in solver.items() if name != "method"]
        # names of methods that had turns are long, and would take their width from all lines
        yield "solver", "", ", ".join([str(solver.get("method", "")), *words]).removeprefix(", ")
    if seconds := summary.get("seconds"):
        parts = [f"{name} {value:.2f}" for name, value in seconds.items() if isinstance(value, (int, float))]
        yield "seconds", "", ", ".join(parts)
    if ranks := summary.get("ranks"):
        received = sum(sum(work["received"]) for work in (ranks.get("work") or {}).values())
        yield "ranks", "", f"{ranks['count']}, exchanged {received:.1f} MB"
    if (memory := summary.get("peak_memory_mb")) is not None:
        yield "memory", "peak", f"{memory:.0f} MB"


def _force(value: Any) -> str:
    """Force of a wrench given as {force, moment} or as one array of six, or a plain force."""
    if isinstance(value, Mapping):
        value = value.get("force", ())
    flat = np.ravel(np.asarray(value, float))
    return _vector(flat[:3] if flat.size == 6 else flat, _force_unit(flat.size))


def _force_unit(components: int) -> str:
    """Unit of forces: a plane structure has a metre of depth."""
    return "N/m" if components == 2 else "N"


def _vector(values: Sequence[float] | Any, unit: str, beside: float = 0.0) -> str:
    names = AXES.get(np.size(values), "x" * np.size(values))
    return in_words(values, unit, names, 5, beside)


def _plural(number: Any, things: str) -> str:
    one = "mesh" if things == "meshes" else things.removesuffix("s")
    return f"{_count(number)} {one if number == 1 else things}"


def _percent(share: float) -> str:
    if 0 < abs(share) < ROUNDING:
        return f"< {100 * ROUNDING:g} %"
    return f"{'−' if share < 0 else ''}{100 * abs(share):.2g} %"


def _clean(value: float) -> str:
    """A number of the size of one, without its rounding."""
    return "0" if abs(value) < SMALL else f"{value:.2g}".replace("-", "−")


def _number(value: Any) -> str:
    return "–" if value is None else f"{float(value):.2e}"


# what was found; stresses; forces and motions; joints; how exact it is; what it cost
ORDER = (
    combination_rows,
    places_rows,
    _stages,
    _mechanism,
    _start,
    _stress,
    _errors,
    _utilisation,
    refinement_rows,
    _forces,
    _ties,
    _limits,
    _determinacy,
    _probes,
    _response,
    _damping,
    _joints,
    _contacts,
    _certificate,
    _size,
    _cost,
)
