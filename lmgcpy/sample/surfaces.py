"""Nodes and cells of surfaces between bodies: nets and geogrids, membranes around a cylinder or a box."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from lmgcpy.errors import named_arguments, number, numbers, shown, whole

MOST = 1e7
"""Most places of a net."""


class Cells(NamedTuple):
    """Nodes of a surface and the cells between them, for ``Scene.net`` and ``Scene.membrane``."""

    positions: np.ndarray
    """Positions of the nodes [m], (n, 3)."""
    cells: np.ndarray
    """Edges (m, 2) or triangles (m, 3), as rows of ``positions``."""
    rim: np.ndarray
    """Whether a node is on the rim: on a side of a net, at an end of a membrane, (n,) bool."""

    def __repr__(self) -> str:
        kind = "edges" if self.cells.shape[1] == 2 else "triangles"
        return f"<Cells: {len(self.cells)} {kind} between {len(self.positions)} nodes, {int(self.rim.sum())} on the rim>"


@named_arguments
def net(*, size: Any, mesh: Any, nodes: int = 1) -> Cells:
    """A rectangular net in the plane z = 0, from the origin: a fishing net, a wire mesh, a geogrid.

    ``size`` [m]: lengths along x and y, each a whole number of meshes; ``mesh`` [m]: one width, or those along x and y;
    ``nodes``: number of pieces of the side of a mesh, which bends at the nodes between them.

    >>> import lmgcpy as lm
    >>> grid = lm.sample.net(size=(1.0, 0.5), mesh=0.25)
    >>> grid.positions.shape, grid.cells.shape, int(grid.rim.sum())
    ((15, 3), (22, 2), 12)
    """
    lengths = numbers(size, "size of a net", "two lengths [m]")
    if lengths.shape != (2,) or not (lengths > 0.0).all():
        raise ValueError(f"size of a net must be two lengths above 0 [m], got {shown(size)}.")
    given = numbers(mesh, "mesh of a net", "one or two widths [m]")
    if given.shape not in ((), (2,)) or not (given > 0.0).all():
        raise ValueError(f"mesh of a net must be one or two widths above 0 [m], got {shown(mesh)}.")
    widths = np.broadcast_to(given, 2)
    pieces = whole(nodes, "nodes of the side of a mesh", minimum=1)
    meshes = np.rint(lengths / widths).astype(int)
    if (meshes < 1).any() or (np.abs(meshes * widths - lengths) > 1e-6 * lengths).any():
        raise ValueError(f"size of a net must be whole meshes of {widths.tolist()} m, got {lengths.tolist()} m.")
    if np.prod((meshes * pieces).astype(float)) > MOST:
        raise ValueError(f"size of a net {lengths.tolist()} m has more than {MOST:g} places: take wider meshes.")
    # all places of a fine grid, of which those on the lines of the net are nodes
    fine = meshes * pieces
    i, j = (axis.ravel() for axis in np.meshgrid(*(np.arange(n + 1) for n in fine), indexing="ij"))
    on_line = [at % pieces == 0 for at in (i, j)]
    taken = on_line[0] | on_line[1]
    number_of = np.full(len(i), -1)
    number_of[taken] = np.arange(taken.sum())
    places = np.column_stack([i * widths[0] / pieces, j * widths[1] / pieces, np.zeros(len(i))])[taken]
    edges = []
    for step, along, last in ((fine[1] + 1, on_line[1], i < fine[0]), (1, on_line[0], j < fine[1])):
        start = np.flatnonzero(along & last)
        edges.append(np.column_stack([number_of[start], number_of[start + step]]))
    rim = ((i == 0) | (i == fine[0]) | (j == 0) | (j == fine[1]))[taken]
    return Cells(places, np.concatenate(edges), rim)


@named_arguments
def membrane_around(*, height: float, spacing: float, radius: float | None = None, box: Any = None) -> Cells:
    """A membrane of triangles that stands on the plane z = 0, open at both ends: the latex around a triaxial sample.

    It goes around the z axis as a polygon inscribed in a cylinder of ``radius`` [m], or around a ``box`` of two lengths [m]
    from the origin; ``height`` [m]; ``spacing`` [m]: distance of the nodes, or a little less. Normals point outward, so
    that a pressure on the membrane presses the sample.

    >>> import lmgcpy as lm
    >>> latex = lm.sample.membrane_around(radius=0.05, height=0.2, spacing=0.02)
    >>> latex.positions.shape, latex.cells.shape
    ((176, 3), (320, 3))
    """
    height = number(height, "height of a membrane", above=0.0, unit="m")
    spacing = number(spacing, "spacing of the nodes of a membrane", above=0.0, unit="m")
    if (radius is None) == (box is None):
        raise TypeError("A membrane goes around a radius= [m] or around a box= of two lengths [m].")
    if radius is not None:
        radius = number(radius, "radius of a membrane", above=0.0, unit="m")
        around = max(3, int(np.ceil(np.pi / np.arcsin(min(1.0, 0.5 * spacing / radius)))))
        angle = 2.0 * np.pi * np.arange(around) / around
        course = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    else:
        sides = numbers(box, "box of a membrane", "two lengths [m]")
        if sides.shape != (2,) or not (sides > 0.0).all():
            raise ValueError(f"box of a membrane must be two lengths above 0 [m], got {shown(box)}.")
        corners = np.array([(0.0, 0.0), (sides[0], 0.0), tuple(sides), (0.0, sides[1])])
        pieces = np.ceil(sides[[0, 1, 0, 1]] / spacing * (1.0 - 1e-9)).astype(int)
        ends = np.roll(corners, -1, axis=0)
        course = np.concatenate(
            [a + np.arange(n)[:, None] / n * (b - a) for a, b, n in zip(corners, ends, pieces, strict=True)]
        )
    levels = max(1, int(np.ceil(height / spacing * (1.0 - 1e-9))))
    count = len(course)
    low = np.arange(levels * count).reshape(levels, count)
    beside, above = np.roll(low, -1, axis=1), low + count
    first = np.stack([low, beside, above], axis=2).reshape(-1, 3)
    second = np.stack([beside, np.roll(above, -1, axis=1), above], axis=2).reshape(-1, 3)
    heights = np.repeat(height * np.arange(levels + 1) / levels, count)
    places = np.column_stack([np.tile(course, (levels + 1, 1)), heights])
    return Cells(places, np.concatenate([first, second]), (heights == 0.0) | (heights == height))
