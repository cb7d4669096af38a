"""Placement: which points of an interface carry its contact.

    contacts = place(assembly, interfaces, [Rule("corners", inset=0.95)] * len(interfaces))

One file a rule, a function ``points(patch, rule) -> Spots``; a new rule is listed in ``RULES``.
"""

from __future__ import annotations

from masonry_fem.contact.placement.place import RULES, place
from masonry_fem.contact.placement.rule import Rule, Spots

__all__ = ["RULES", "Rule", "Spots", "place"]
