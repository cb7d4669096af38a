"""Output: what is written of a run, and the points and planes that are looked at."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal, cast

from msgspec import Meta, defstruct

from masonry_fem.output import asked
from masonry_fem.records.record import Axis, BlockSelector, Count, Name, Point, Positive, Seconds, Spec

PictureName = Literal[
    "deformed", "von_mises", "principal_stresses", "utilisation", "stress_error", "stone", "overview",
    "reactions", "resultants", "damage", "thrust", "opening", "sliding", "mechanism", "response", "places",
]  # fmt: skip
CutField = Literal["von_mises", "vertical", "greatest", "least"]


class Probe(Spec, frozen=True, kw_only=True):
    """A material point whose displacement is recorded.

    Attributes
    ----------
    name : name of its columns in results
    block : selector that matches one block
    point : in world coordinates of the undeformed structure
    """

    name: Name
    block: BlockSelector
    point: Point


class Cut(Spec, frozen=True, kw_only=True):
    """A picture ``cut_NAME_FIELD.png`` of the stresses on a plane through a 3D structure.

    Tension is positive. Rigid blocks are grey.

    Attributes
    ----------
    name : part of the pictures' names
    point : any point of the plane, in world coordinates of the undeformed structure
    normal : normal of the plane, pointing towards the viewer
    show : the fields, each of which gives a picture: von Mises stress, vertical stress (zz), greatest and
        least principal stress
    """

    name: Name
    point: Point
    normal: Axis
    show: tuple[CutField, ...] = ("von_mises",)

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """A cut through the plane, or along none."""
        if dimension == 2:
            yield "name", "no cut in a 2D scene, all of which the other pictures show"
        if not any(self.normal):
            yield "normal", "a normal that is not zero"


def _with_outputs(record: type[Output]) -> type[Output]:
    """The record with a key for each further file of ``masonry_fem.output.asked``."""
    keys = [key for key in asked.names() if key not in record.__struct_fields__]
    if not keys:
        return record
    told = "\n".join(f"{key} : {asked.meaning(key)}" for key in keys)
    text = {"__doc__": f"{record.__doc__}\nAttributes\n----------\n{told}"}
    fields = [(key, bool, False) for key in keys]
    wider = defstruct("Output", fields, bases=(record,), namespace=text, frozen=True, kw_only=True)
    return cast("type[Output]", wider)


@_with_outputs
class Output(Spec, frozen=True, kw_only=True):
    """What is written besides ``summary.json`` and ``history.csv``.

    Attributes
    ----------
    fields : write ``.vtu`` and ``.pvd`` files for ParaView
    pictures : write PNG pictures of the last state: all that there is data for, or the named ones only, as in
        ``["overview", "thrust"]``; ``cuts`` come with either
    every : number of steps between field files; the first and the last are always written
    interfaces : write [``interfaces.csv``](results.md#interfacescsv): which forces each joint carries, where,
        and how far it opened and slid. With ``pictures``, thrust lines and maps of opening and sliding are
        drawn, too; with ``fields``, ``interfaces.pvd`` is written for ParaView
    stones : write [``stones.csv``](results.md#stonescsv): the stress of each stone and how much of its
        strength it uses; by default where a material has a strength, or a report is asked for
    cuts : pictures of [stresses on planes](results.md#cuts), in 3D
    determinacy : write ``determinacy.csv``: [which resultants are determined](determinacy.md), that is, equal
        in all solutions of the last step; its reactions are then those of least norm
    limit_analysis : put into the summary what [limit analysis](limit_analysis.md) says about rigid blocks
        with the same contact points
    contact_error : run the analysis a second time with [other contact points](errors.md#contact), and put
        into the summary what changes
    report : write ``report.html``: [all of it in one file](report.md), which can be handed on; it turns on
        ``interfaces`` and ``stones``
    amplification : factor of displacements in pictures; chosen automatically by default
    spectrum_damping : damping ratio of the oscillators of [response spectra](shaking.md#response-spectra),
        which are written where accelerograms act
    checkpoint_steps : number of steps after which ``checkpoint.npz`` is written, from which
        [a run goes on](histories.md); it is also written at the start and at the end
    checkpoint_time : the same by the time of the clock, as ``"5 min"``; both may be given
    """

    fields: bool = True
    pictures: bool | tuple[PictureName, ...] = True
    every: Count = 1
    interfaces: bool = False
    stones: bool | None = None
    cuts: tuple[Cut, ...] = ()
    determinacy: bool = False
    limit_analysis: bool = False
    contact_error: bool = False
    report: bool = False
    amplification: Positive | None = None
    spectrum_damping: Annotated[float, Meta(ge=0, lt=1)] = 0.05
    checkpoint_steps: Count | None = None
    checkpoint_time: Seconds | None = None
