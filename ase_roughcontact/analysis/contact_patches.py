"""Connected patches of contact: area, perimeter and centroid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from ase_roughcontact._util.summary import Summarized
from ase_roughcontact.analysis.contact_map import ContactMap, nearest_image
from ase_roughcontact.theory.counted_area import open_sides


@dataclass(frozen=True, eq=False)
class Patches(Summarized):
    """Connected patches of contact, the largest first.

    Attributes
    ----------
    labels : ndarray of int, shape (n, m)
        Labels of the sites: zero without contact, k + 1 in patch k.
    area : ndarray, shape (k,)
        Number of atoms times the area per atom (Å^2).
    perimeter : ndarray, shape (k,)
        Number of edges shared with sites without contact times the spacing (Å).
    centroid : ndarray, shape (k, 2)
        Position of the centroid relative to the (nearest) indenter's axis (Å); NaN
        along a direction in which the patch is connected with its own periodic image.
    """

    labels: np.ndarray
    area: np.ndarray
    perimeter: np.ndarray
    centroid: np.ndarray

    def __len__(self) -> int:
        return len(self.area)


def patches(contact_map: ContactMap, diagonal: bool = False) -> Patches:
    r"""Find the connected patches of contact.

    Parameters
    ----------
    contact_map : ContactMap
        Map of the contact. Patches of a periodic map continue across its edges.
    diagonal : bool
        Whether atoms have 8 neighbours, including the diagonal ones, instead of 4.

    Returns
    -------
    Patches
        Patches, the largest first.

    Notes
    -----
    The perimeter belongs to the union of square cells: a row of k atoms has the
    perimeter :math:`(2k + 2) a_0`. On fine grids the perimeter does not converge to the
    length of a smooth outline, but to the sum of its projections on x and y, which is
    :math:`4/\pi` times as long for a disc, and for any outline on average over its
    orientation.
    """
    structure = ndimage.generate_binary_structure(2, 2 if diagonal else 1)
    pieces, count = ndimage.label(contact_map.contact, structure)
    periodic = contact_map.periodic
    links = _seams(pieces, diagonal) if periodic else np.zeros((0, 4), dtype=int)
    patch_of, cells, around = _merge(count, links)

    kept, patch_of = np.unique(patch_of, return_inverse=True)
    labels = patch_of[pieces]
    size = np.bincount(labels.ravel())
    order = np.append(0, 1 + np.argsort(-size[1:], kind="stable"))
    rank = np.argsort(order)
    labels, kept, size = rank[labels], kept[order][1:], size[order][1:]

    i, j = np.nonzero(contact_map.contact)
    patch = labels[i, j] - 1
    position = np.column_stack((i, j)) + cells[pieces[i, j]] * labels.shape
    edges = open_sides(contact_map.contact, periodic)[i, j]
    centroid = np.column_stack(
        [np.bincount(patch, along, len(size)) / size for along in position.T]
    )
    centroid = contact_map.origin + contact_map.spacing * centroid
    if periodic:
        centroid = nearest_image(centroid, np.array(labels.shape) * contact_map.spacing)
        centroid[around[kept]] = np.nan
    return Patches(
        labels=labels,
        area=size * contact_map.cell_area,
        perimeter=np.bincount(patch, edges, len(size)) * contact_map.spacing,
        centroid=centroid,
    )


def _seams(pieces: np.ndarray, diagonal: bool) -> np.ndarray:
    """Return pairs of pieces that meet across edges of the cell, and the steps across.

    Each row has the labels of two pieces, and the numbers of cells from the first to
    the second one along x and y.
    """
    n, m = pieces.shape
    i, j = np.indices(pieces.shape)
    links = []
    for di, dj in ((1, 0), (0, 1), (1, 1), (1, -1))[: 4 if diagonal else 2]:
        beyond = np.stack(((i + di) // n, (j + dj) // m))
        other = np.roll(pieces, (-di, -dj), axis=(0, 1))
        meet = beyond.any(axis=0) & (pieces > 0) & (other > 0)
        links.append(np.stack((pieces, other, *beyond))[:, meet].T)
    return np.unique(np.concatenate(links), axis=0)


def _merge(count: int, links: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return patch and periodic cell of each piece, and the directions of wrapping.

    A patch has the number of its first piece, and cells are counted from this piece.
    """
    patch_of, cells = np.arange(count + 1), np.zeros((count + 1, 2), dtype=int)
    around = np.zeros((count + 1, 2), dtype=bool)
    links = np.concatenate([links, links[:, [1, 0, 2, 3]] * [1, 1, -1, -1]])
    one, other, step = links[:, 0], links[:, 1], links[:, 2:]
    # numbers decrease until all pieces of a patch have the same one
    while (later := patch_of[one] < patch_of[other]).any():
        for piece, neighbour, *step_of_link in links[later].tolist():
            if patch_of[piece] < patch_of[neighbour]:
                patch_of[neighbour] = patch_of[piece]
                cells[neighbour] = cells[piece] + step_of_link
    # two paths to one piece that end in different periodic cells
    np.logical_or.at(around, patch_of[one], cells[one] + step != cells[other])
    return patch_of, cells, around
