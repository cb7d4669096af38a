"""Joint: what the joints do that an entry of ``joints`` selects."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from masonry_fem.contact.placement import names as placements
from masonry_fem.records.record import BlockSelector, Count, Fraction, Inclination, NonNegative, Spec, Unit
from masonry_fem.scene.laws import AnyLaw, Closure, Dilatancy, Mortar, Scatter

if TYPE_CHECKING:
    PlacementName = str
else:  # what ``placement`` may be, told from the files there
    PlacementName = Literal[placements()]

# μ of joints that do not slip: only what is about to open has less pressure than a hundredth of its shear
NO_SLIP = 1e2


class Joint(Spec, frozen=True, kw_only=True):
    """What the selected joints do: friction, and a cohesive law, mortar or dilatancy where wanted.

    If several entries match a joint, the last one applies. Entries select joints by ``interface`` (their
    label: bed, head, radial ...), ``between`` (the two blocks) and ``inclination`` (the angle to the
    horizontal, for blocks without labels: bed joints have 0°, head joints 90°).

    The strengths and stiffnesses of a ``law`` are per area, and each contact point has its share of the
    face. A ``mortar`` is an elastic layer in series with the contact: it deforms under pressure and shear
    even where the faces neither open nor slide. With ``dilatancy`` a joint that slides also opens.

    Attributes
    ----------
    friction : Coulomb's μ; with ``no slip`` the joint can open but never slides
    law : cohesive law, chosen by ``kind``; without it the joint is dry
    mortar : elastic layer in series with the contact; none by default
    closure : asperities that close under pressure, in series with the contact; none by default
    dilatancy : opening that sliding causes; none by default
    scatter : properties that vary from joint to joint; none by default
    dynamic_friction : μ of a point that slides; equal to ``friction`` by default
    restitution : Newton's coefficient e of the normal velocity; only with ``form = "velocity"``
    tangential_restitution : the same for the tangential velocity
    contact : ``unilateral``: the blocks press on each other and rub; ``none``: they do not touch there, as at
        head joints that were left open, and nothing else of this entry matters
    form : ``gap`` demands that blocks do not penetrate at the end of a step; ``velocity`` is an impact law
    placement : where the contact points lie: at the ``nodes`` of the finer mesh, at the ``corners`` of the
        common face, or at its ``gauss`` points; ``weighted`` has a mean for each node of the finer mesh, and
        is exact between any two meshes; ``navier`` takes faces as plane, with contacts at corners and
        centroid; ``auto`` is ``nodes`` where that is exact, else ``weighted``, and ``corners`` between
        rigid blocks. Left out, it is ``navier`` between reduced stones of degree 1 and 2, else ``auto``
    inset : for ``corners`` and ``navier``: the corners' points lie at this share of the half-thickness, 1
        being the edge
    density : for ``gauss``: number of subdivisions of the face
    interface : pattern of the joint's label: ``bed``, ``head``, ``radial``, a file's surface group
    between : selectors of the two blocks, in either order
    inclination : smallest and largest angle between the joint's plane and the horizontal
    """

    friction: NonNegative | Literal["no slip"] = 0.6
    law: AnyLaw | None = None
    mortar: Mortar | None = None
    closure: Closure | None = None
    dilatancy: Dilatancy | None = None
    scatter: Scatter | None = None
    dynamic_friction: NonNegative | None = None
    restitution: Unit = 0.0
    tangential_restitution: Unit = 0.0
    contact: Literal["unilateral", "none"] = "unilateral"
    form: Literal["gap", "velocity"] = "gap"
    placement: PlacementName | None = None
    inset: Fraction = 1.0
    density: Count = 1
    interface: str = "*"
    between: tuple[BlockSelector, BlockSelector] = ("*", "*")
    inclination: tuple[Inclination, Inclination] = (0.0, 90.0)

    @property
    def coefficient(self) -> float:
        """Coulomb's μ of a joint at rest."""
        return NO_SLIP if self.friction == "no slip" else float(self.friction)

    @property
    def dry(self) -> bool:
        """True where contact and friction are all there is."""
        layers = self.law, self.mortar, self.closure, self.dilatancy
        return all(layer is None for layer in layers)
