"""Update: contacts detected anew while blocks move, and which new contact continues which old one.

    now = moved(assembly, rotation, translation)           # blocks where they are, x = R X + t
    contacts = returned(place(now, detect(now), rules), rotation, translation)
    old = partners(before, points_before, contacts, points_now, within)

Whenever contacts are found, they are stored in the reference configuration: so loads and states of the march
stay as they are.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import sparse

from masonry_fem.contact.contacts import Contacts
from masonry_fem.contact.interfaces import Interfaces
from masonry_fem.solid.assembly import Assembly
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray


def moved(assembly: Assembly, rotation: FloatArray, translation: FloatArray) -> Assembly:
    """The assembly after each block's own motion x = R X + t.

    Parameters
    ----------
    assembly : Blocks in their reference poses.
    rotation : R of each block, shape (b, d, d).
    translation : t of each block, shape (b, d) [m].
    """
    blocks = assembly.blocks
    place = np.einsum("bij,bj->bi", rotation, blocks.translation) + translation
    return replace(assembly, blocks=replace(blocks, rotation=rotation @ blocks.rotation, translation=place))


def returned(contacts: Contacts, rotation: FloatArray, translation: FloatArray) -> Contacts:
    """Contacts that were found on moved blocks, transformed back to the reference configuration.

    Points go back with their blocks, and frames with the antagonists. The gap is not transformed.

    Parameters
    ----------
    contacts : Found on the moved blocks.
    rotation, translation : The motion of each block, as in ``moved``.
    """
    turn, shift = rotation[contacts.blocks], translation[contacts.blocks]
    points = np.einsum("csji,csj->csi", turn, contacts.points - shift)
    frame = contacts.frame @ turn[:, 1]
    return replace(contacts, points=points, frame=frame)


def returned_faces(interfaces: Interfaces, rotation: FloatArray, translation: FloatArray) -> Interfaces:
    """Interfaces that were found on moved blocks, transformed back with their antagonists.

    Parameters
    ----------
    interfaces : Found on the moved blocks.
    rotation, translation : The motion of each block, as in ``moved``.
    """
    carrier = interfaces.blocks[:, 1]
    back = rotation[carrier].swapaxes(1, 2)
    return interfaces.moved(back, -np.einsum("iab,ib->ia", back, translation[carrier]))


def partners(
    old: Contacts, old_points: FloatArray, new: Contacts, new_points: FloatArray, within: float
) -> IntArray:
    """The old contact that each new one continues: the nearest one between the same blocks, shape (c,).

    Parameters
    ----------
    old, new : Contacts before and after detection.
    old_points, new_points : Where these contacts are now, shapes (c_old, d) and (c, d) [m].
    within : Largest distance between partners [m].

    Returns
    -------
    Numbers of old contacts, −1 where there is none within that distance.
    """
    if old.count == 0 or new.count == 0:
        return np.full(new.count, -1)
    from scipy.spatial import KDTree  # noqa: PLC0415 - only marches that detect anew need it

    blocks = max(int(old.blocks.max()), int(new.blocks.max())) + 1
    # a tie is continued by a tie only
    pairs = [np.sort(one.blocks, axis=1) @ [blocks, 1] + blocks**2 * one.tied for one in (old, new)]
    # a further coordinate separates contacts of different pairs of blocks, so that one tree serves all
    _, number = np.unique(np.concatenate(pairs), return_inverse=True)
    lifted = 4.0 * within * number[:, None]
    tree = KDTree(np.concatenate([old_points, lifted[: old.count]], axis=1))
    away, nearest = tree.query(
        np.concatenate([new_points, lifted[old.count :]], axis=1), distance_upper_bound=within
    )
    found: IntArray = np.where(np.isfinite(away), nearest, -1)
    return found


def joined(
    kept: tuple[Interfaces, Contacts], added: tuple[Interfaces, Contacts]
) -> tuple[Interfaces, Contacts]:
    """Two sets of interfaces with their contacts as one.

    Parameters
    ----------
    kept, added : Interfaces and contacts; the kept ones come first.
    """
    (first, before), (second, after) = kept, added
    return Interfaces.joined([first, second]), Contacts(
        blocks=np.concatenate([before.blocks, after.blocks]),
        interface=np.concatenate([before.interface, after.interface + len(first)]),
        points=np.concatenate([before.points, after.points]),
        facets=np.concatenate([before.facets, after.facets]),
        frame=np.concatenate([before.frame, after.frame]),
        gap=np.concatenate([before.gap, after.gap]),
        area=np.concatenate([before.area, after.area]),
        means=_stacked(before, after),
        bulge=_bulges(before, after),
        ties=None if before.ties is after.ties is None else np.concatenate([before.tied, after.tied]),
    )


def _bulges(before: Contacts, after: Contacts) -> FloatArray | None:
    """What round faces have in front of their facets at two sets of contacts."""
    if before.bulge is None and after.bulge is None:
        return None
    return np.concatenate(
        [np.zeros(one.count) if one.bulge is None else one.bulge for one in (before, after)]
    )


def _stacked(before: Contacts, after: Contacts) -> sparse.csr_array | None:
    """Weights of the nodes of two sets of contacts."""
    if before.means is None and after.means is None:
        return None
    width = max(one.means.shape[1] for one in (before, after) if one.means is not None)
    # the largest mesh of each may have another number of nodes
    parts = [sparse.csr_array((2 * one.count, width)) if one.means is None else _widened(one.means, width)
             for one in (before, after)]  # fmt: skip
    return sparse.csr_array(sparse.vstack(parts))


def _widened(weights: sparse.csr_array, width: int) -> sparse.csr_array:
    """The same with so many columns."""
    parts = (weights.data, weights.indices, weights.indptr)
    return sparse.csr_array(parts, shape=(weights.shape[0], width))


def chosen(interfaces: Interfaces, contacts: Contacts, keep: np.ndarray) -> tuple[Interfaces, Contacts]:
    """Some of the interfaces, with their contacts.

    Parameters
    ----------
    interfaces : All of them, i in number.
    contacts : Their contacts.
    keep : True for those to keep, shape (i,).
    """
    number = np.cumsum(keep) - 1
    own = np.flatnonzero(keep[contacts.interface]) if contacts.count else np.zeros(0, dtype=np.int64)
    some = picked(contacts, own)
    return interfaces.only(keep), replace(some, interface=number[some.interface])


def picked(contacts: Contacts, rows: IntArray) -> Contacts:
    """Some of the contacts, in a given order.

    Parameters
    ----------
    contacts : All of them.
    rows : Which, shape (k,).
    """
    both = np.stack([2 * rows, 2 * rows + 1], axis=1).ravel()
    return Contacts(
        blocks=contacts.blocks[rows],
        interface=contacts.interface[rows],
        points=contacts.points[rows],
        facets=contacts.facets[rows],
        frame=contacts.frame[rows],
        gap=contacts.gap[rows],
        area=contacts.area[rows],
        means=None if contacts.means is None else contacts.means[both],
        bulge=None if contacts.bulge is None else contacts.bulge[rows],
        ties=None if contacts.ties is None else contacts.ties[rows],
    )
