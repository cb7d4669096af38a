"""Contacts found anew on moved blocks: back to the reference, and from old to new."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse

from masonry_fem.contact.detection import detect
from masonry_fem.contact.place import place
from masonry_fem.contact.placement import Rule
from masonry_fem.contact.update import chosen, joined, moved, partners, returned
from tests.contact.blocks import turning, turning_2d, wall


def contacts_of(assembly):
    interfaces = detect(assembly)
    return interfaces, place(assembly, interfaces, [Rule()] * len(interfaces))


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_structure_that_moves_as_one_keeps_its_contacts(dimension):
    """Found where the wall has gone and taken back: the same points, frames and gaps as at the start."""
    assembly = wall(3, 3, dimension)
    turn = turning(0.7) if dimension == 3 else turning_2d(0.7)
    count = len(assembly.blocks)
    rotation, translation = np.tile(turn, (count, 1, 1)), np.tile(np.arange(dimension) - 1.5, (count, 1))
    _, before = contacts_of(assembly)
    _, there = contacts_of(moved(assembly, rotation, translation))
    back = returned(there, rotation, translation)
    old = partners(before, before.points[:, 0], back, back.points[:, 0], 0.05)
    assert sorted(old) == list(range(before.count))
    assert back.points == pytest.approx(before.points[old], abs=1e-12)
    assert back.frame[:, 0] == pytest.approx(before.frame[old, 0], abs=1e-12)
    assert back.gap == pytest.approx(before.gap[old], abs=1e-12)
    assert back.area == pytest.approx(before.area[old])
    assert (back.blocks == before.blocks[old]).all()


def test_partners_are_of_the_same_blocks_and_near():
    _, contacts = contacts_of(wall(2, 2))
    points = contacts.points[:, 0]
    assert (partners(contacts, points, contacts, points, 0.05) == np.arange(contacts.count)).all()
    aside = points + np.array([0.02, 0.0, 0.0])
    assert (partners(contacts, points, contacts, aside, 0.03) == np.arange(contacts.count)).all()
    assert (partners(contacts, points, contacts, aside, 0.01) == -1).all()
    # where two interfaces meet, contacts of other blocks stand nearer, and do not count
    _, some = chosen(detect(wall(2, 2)), contacts, np.arange(len(detect(wall(2, 2)))) % 2 == 0)
    found = partners(some, some.points[:, 0], contacts, points, 10.0)
    pairs = [{tuple(sorted(pair)) for pair in one.blocks.tolist()} for one in (some, contacts)]
    for own, other in zip(contacts.blocks, found, strict=True):
        known = tuple(sorted(own.tolist())) in pairs[0]
        assert (other >= 0) == known
        if known:
            assert set(some.blocks[other]) == set(own)


def test_chosen_and_joined_again():
    interfaces, contacts = contacts_of(wall(2, 2))
    keep = np.arange(len(interfaces)) % 3 > 0
    parts = chosen(interfaces, contacts, keep), chosen(interfaces, contacts, ~keep)
    whole, together = joined(*parts)
    assert len(whole) == len(interfaces)
    assert together.count == contacts.count
    for number, interface in enumerate(whole):
        own = together.interface == number
        assert (together.blocks[own] == interface.blocks).all()
        assert together.area[own].sum() == pytest.approx(interface.area)


def test_weights_of_meshes_of_other_sizes_are_joined():
    """Of the nodes of the largest mesh of either: those that the other lacks weigh nothing."""
    interfaces, contacts = contacts_of(wall(2, 2))
    few, many = (
        replace(contacts, means=sparse.csr_array(np.arange(2.0 * n * contacts.count).reshape(-1, n)))
        for n in (3, 5)
    )
    for first, second in ((few, many), (many, few)):
        means = joined((interfaces, first), (interfaces, second))[1].means.toarray()
        assert means.shape == (4 * contacts.count, 5)
        for own, rows in zip((first, second), np.split(means, 2), strict=True):
            width = own.means.shape[1]
            assert (rows[:, :width] == own.means.toarray()).all()
            assert not rows[:, width:].any()
