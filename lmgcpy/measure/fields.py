"""Coarse-grained fields of a sample: density, velocity and stress at every point of a grid, smoothed by a Gaussian.

With a kernel ``phi(x) = (2 pi w^2)^(-d/2) exp(-|x|^2 / (2 w^2))`` of width w, in d dimensions (Goldhirsch, Granular Matter
12, 2010, 239; walls: Weinhart, Thornton, Luding and Bokhove, Granular Matter 14, 2012, 289):

    rho(x)     = sum_i m_i phi(x - r_i)                        density
    rho V (x)  = sum_i m_i v_i phi(x - r_i)                    momentum
    sigma_k(x) = -sum_i m_i v'_i (x) v'_i phi(x - r_i)         kinetic stress, v'_i = v_i - V(x)
    sigma_c(x) = -sum_c f_c (x) b_c int_0^1 phi(x - r_j - s b_c) ds      contact stress, b_c = r_i - r_j
    t(x)       = sum_c f_c phi(x - c)                          force of walls, per volume

``f_c`` is the force of an interaction on the candidate i. The way ``b_c`` goes between the centres, at a wall from the
contact point c to the centre. As ``phi(x - r_i) - phi(x - r_j)`` is ``-b . grad`` of the integral, the fields obey the
balances of mass and momentum at every point and for any width, and not only in the mean:

    d rho/dt + div(rho V) = 0,     d(rho V)/dt = div(sigma_c + sigma_k - rho V (x) V) + t + loads.

The integral is a sum over points of Gauss and Legendre, so that every field is a sum of point sources.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lmgcpy.errors import named_arguments, number, shown
from lmgcpy.measure.moment import Moment, Source, moment
from lmgcpy.measure.stress import corners, images_near, volumes_of

REACH = 8.0
"""Distance in widths beyond which the kernel is left out: it is 1e-14 of its maximum there."""
MOST_POINTS = 10_000_000
"""Most points of a grid."""


@dataclass(frozen=True, repr=False)
class CoarseFields:
    """Fields on a grid of ``n_x`` by ``n_y`` (by ``n_z``) points; d dimensions."""

    axes: tuple[np.ndarray, ...]
    """Coordinates of the points of the grid along each axis [m]."""
    width: float
    """w [m]."""
    density: np.ndarray
    """rho [kg/m^3, per metre of depth in 2D], (n_x, n_y[, n_z])."""
    solid_fraction: np.ndarray
    """The same with the bodies' volumes for their masses [-]; NaN if a body has no known volume."""
    momentum: np.ndarray
    """rho V [kg/(m^2 s)], (n_x, n_y[, n_z], d)."""
    contact_stress: np.ndarray
    """sigma_c of contacts and links [Pa], traction positive, (n_x, n_y[, n_z], d, d)."""
    kinetic_stress: np.ndarray
    """sigma_k of bodies that fly about [Pa], likewise."""
    wall_force: np.ndarray
    """t: force per volume that walls, and bodies without mass, give to the sample [N/m^3], (n_x, n_y[, n_z], d)."""

    @property
    def points(self) -> np.ndarray:
        """Points of the grid [m], (n_x, n_y[, n_z], d)."""
        return np.stack(np.meshgrid(*self.axes, indexing="ij"), axis=-1)

    @property
    def velocity(self) -> np.ndarray:
        """V [m/s], (n_x, n_y[, n_z], d), NaN where there is no density."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return self.momentum / self.density[..., None]

    @property
    def stress(self) -> np.ndarray:
        """Contact stress and kinetic stress together [Pa], (n_x, n_y[, n_z], d, d)."""
        return self.contact_stress + self.kinetic_stress

    def __repr__(self) -> str:
        size = " by ".join(str(len(axis)) for axis in self.axes)
        return f"<CoarseFields on {size} points, of a width of {self.width:g} m>"


@named_arguments
def coarse_fields(
    sim: Source, *, width: float, spacing: float | None = None, region: tuple | None = None, frame: int | None = None
) -> CoarseFields:
    """Density, velocity and stress on a grid, of the last step of a simulation, or of a ``frame`` of an open run.

    ``width`` [m] is the standard deviation of the Gaussian. One diameter or two of a grain smooth the grains away and keep
    what varies over several of them. ``spacing`` [m] of the grid: ``width`` by default; sums over such a grid are the
    integrals of the fields to some 1e-8. ``region``: its corners ((x0, y0), (x1, y1)), with z in 3D [m]; by default the
    bodies with bounds fit in it. The grid has its ends on the corners, and so its spacing may be a little less.

    Bodies with bounds and mass make up the sample; all others are walls to it. Contact points are those of the detection,
    centres and velocities those at the end of the step. In a periodic cell the images count, and the velocity is relative
    to the mean flow. A force on a thread or membrane counts for its nearest node. Near walls density and stress fall to
    zero over a width beyond the sample; the force of the wall is spread likewise.

    A ball of 10 N on a floor: the floor's force over all space, and the mass

    >>> import lmgcpy as lm
    >>> scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    >>> ball = scene.add(lm.disk(radius=0.1, position=(0.0, 0.1), mass=1.0))
    >>> floor = scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
    >>> scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    >>> sim = lm.Simulation(scene, time_step=1e-3).run(steps=5)
    >>> fields = lm.measure.coarse_fields(sim, width=0.1, region=((-1.0, -1.0), (1.0, 1.0)))
    >>> float((fields.density.sum() * 0.1**2).round(6)), (fields.wall_force.sum(axis=(0, 1)) * 0.1**2).round(6)
    (1.0, array([ 0., 10.]))
    """
    now = moment(sim, frame, "coarse_fields")
    d = now.positions.shape[1]
    w = number(width, "width", above=0.0, unit="m")
    step = w if spacing is None else number(spacing, "spacing", above=0.0, unit="m")
    inner = now.moves
    if not inner.any():
        raise ValueError("coarse_fields needs bodies with bounds and mass, and there are none.")
    low, high = _region(now, inner) if region is None else corners(region, "region", d)
    counts = [max(2, int(np.ceil((b - a) / step - 1e-9)) + 1) for a, b in zip(low, high, strict=True)]
    if np.prod([float(count) for count in counts]) > MOST_POINTS:
        raise ValueError(
            f"A grid with a spacing of {step:g} m between {shown(low.tolist())} and {shown(high.tolist())} would have more "
            f"than {MOST_POINTS} points: give a larger spacing, or a region."
        )
    axes = tuple(np.linspace(a, b, count) for a, b, count in zip(low, high, counts, strict=True))
    mass, volume = now.mass[inner], volumes_of(now)[inner]
    known = np.where(np.isfinite(volume), volume, 0.0)
    centres, velocities = now.positions[inner], now.velocities[inner]
    mean = np.average(velocities, axis=0, weights=mass)
    moving = velocities - mean  # the round-off of the kinetic stress is that of differences
    dyads = (moving[:, :, None] * moving[:, None, :]).reshape(-1, d * d)
    sources = np.column_stack([mass, known, mass[:, None] * moving, mass[:, None] * dyads])
    of_bodies = _spread(now, centres, sources, axes, w)
    density, momentum = of_bodies[..., 0], of_bodies[..., 2 : 2 + d]
    fluxes = of_bodies[..., 2 + d :].reshape(*counts, d, d)
    with np.errstate(divide="ignore", invalid="ignore"):
        flow = np.where(density[..., None] > 0.0, momentum / density[..., None], 0.0)
    kinetic = momentum[..., :, None] * flow[..., None, :] - fluxes
    contact, walls = _of_interactions(now, inner, axes, w)
    return CoarseFields(
        axes=axes,
        width=w,
        density=density,
        solid_fraction=of_bodies[..., 1] if np.isfinite(volume).all() else np.full_like(density, np.nan),
        momentum=momentum + density[..., None] * mean,
        contact_stress=contact,
        kinetic_stress=kinetic,
        wall_force=walls,
    )


def _region(now: Moment, inner: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corners of the box that holds the bodies, (d,) each."""
    radius = now.extent[inner, None]
    return (now.positions[inner] - radius).min(axis=0), (now.positions[inner] + radius).max(axis=0)


def _of_interactions(
    now: Moment, inner: np.ndarray, axes: tuple[np.ndarray, ...], w: float
) -> tuple[np.ndarray, np.ndarray]:
    """Contact stress (*grid, d, d) and force of the walls (*grid, d)."""
    net, d = now.net, now.positions.shape[1]
    force = np.einsum("mk,mkd->md", net.force, net.frame)
    acting = (force != 0.0).any(axis=1) & (inner[net.candidate] | inner[net.antagonist])
    force, candidate, antagonist = force[acting], net.candidate[acting], net.antagonist[acting]
    on_c, on_a = inner[candidate, None], inner[antagonist, None]
    moved, lever = now.positions - now.detected, net.lever[acting]
    # from the antagonist's centre or the point at a wall to the candidate's or the point, beginning at the one of them
    # that is in the sample: in a periodic cell the others are images
    at_c, at_a = now.positions[candidate], now.positions[antagonist]
    to_point = np.where(on_c, lever[:, 0] - moved[candidate], lever[:, 1] - moved[antagonist])
    between = at_c - at_a
    if now.lattice is not None:  # the image that met the candidate has moved on with the edges since
        image = now.detected[candidate] - now.detected[antagonist] - (lever[:, 1] - lever[:, 0])
        between -= now.lattice.nearest(image, now.lattice.edges(now.detected)) @ now.lattice.edges(now.positions)
    branch = np.where(on_c & on_a, between, np.where(on_c, -to_point, to_point))
    start = np.where(on_c, at_c - branch, at_a)
    dyads = (-force[:, :, None] * branch[:, None, :]).reshape(-1, d * d)
    total = np.zeros((*map(len, axes), d * d))
    length = np.linalg.norm(branch, axis=1) / w
    # with this number of points the integral is exact to 1e-13 of its maximum, for any length: tests/measure/test_fields.py
    order = 2 ** np.ceil(np.log2(6.0 + 2.0 * length)).astype(int)
    for count in np.unique(order).tolist():
        rows = order == count
        abscissa, weight = np.polynomial.legendre.leggauss(count)
        share = 0.5 * (1.0 + abscissa)
        places = start[rows, None, :] + share[None, :, None] * branch[rows, None, :]
        sources = 0.5 * weight[None, :, None] * dyads[rows, None, :]
        total += _spread(now, places.reshape(-1, d), sources.reshape(-1, d * d), axes, w)
    at_wall = ~(on_c & on_a)[:, 0]
    point = np.where(on_c, at_c, at_a) + to_point
    given = np.where(on_c, force, -force)
    walls = _spread(now, point[at_wall], given[at_wall], axes, w)
    return total.reshape(*total.shape[:-1], d, d), walls


def _spread(now: Moment, points: np.ndarray, values: np.ndarray, axes: tuple[np.ndarray, ...], w: float) -> np.ndarray:
    """``sum_k values_k phi(x - points_k)`` on a grid, (*grid, c), of values (k, c) and of their images in a periodic
    cell."""
    low, high = (np.array([axis[end] for axis in axes]) for end in (0, -1))
    reach = 0.5 * float(np.linalg.norm(high - low)) + REACH * w
    total = np.zeros((*map(len, axes), values.shape[1]))
    for places in images_near(now, points, 0.5 * (low + high), reach):
        near = ((places > low - REACH * w) & (places < high + REACH * w)).all(axis=1)
        if near.any():
            total += _gaussians(places[near], values[near], axes, w)
    return total


def _gaussians(points: np.ndarray, values: np.ndarray, axes: tuple[np.ndarray, ...], w: float) -> np.ndarray:
    """The same of these points alone: the Gaussian is a product over the axes, so that one after the other is summed."""
    axis, *others = axes
    across = points[:, 0]
    norm = 1.0 / (np.sqrt(2.0 * np.pi) * w)
    if not others:
        return norm * np.exp(-0.5 * ((axis[:, None] - across) / w) ** 2) @ values
    order = np.argsort(across)
    points, values, across = points[order], values[order], across[order]
    first, last = np.searchsorted(across, axis - REACH * w), np.searchsorted(across, axis + REACH * w)
    found = np.zeros((*map(len, axes), values.shape[1]))
    for k, (a, b) in enumerate(zip(first.tolist(), last.tolist(), strict=True)):
        part = norm * np.exp(-0.5 * ((axis[k] - across[a:b]) / w) ** 2)
        found[k] = _gaussians(points[a:b, 1:], part[:, None] * values[a:b], tuple(others), w)
    return found
