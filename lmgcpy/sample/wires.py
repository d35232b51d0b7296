"""Wires as the generators lay them: chains of beads in their order; and content, density and rigidity of a real wire."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lmgcpy.errors import named_arguments, number, whole

DTEX = 1e-7
"""One dtex [kg/m]: 0.1 g per km."""


@dataclass(frozen=True, eq=False, repr=False)
class Wire:
    """A chain of beads, and whether it had to be cut (paper, section 4: "sometimes it is impossible to define a bead
    position, so the wire is cut").
    """

    positions: np.ndarray
    """Centres of the beads [m], shape (bead_count, d)."""

    radii: np.ndarray
    """Radii of the beads [m], shape (bead_count,)."""

    interstice: float
    """Gap between the surfaces of consecutive beads [m]: the reference gap of the links."""

    requested_count: int
    """Number of beads asked for."""

    @property
    def bead_count(self) -> int:
        """Number of beads laid."""
        return len(self.positions)

    @property
    def cut(self) -> bool:
        """Whether the wire ends before the requested number of beads, as the next bead fitted nowhere."""
        return self.bead_count < self.requested_count

    @property
    def length(self) -> float:
        """Laid length from the first to the last centre [m]."""
        return float(np.linalg.norm(np.diff(self.positions, axis=0), axis=1).sum())

    def __str__(self) -> str:
        laid = f"wire of {self.bead_count} beads, {self.length:.3g} m long"
        if not self.cut:
            return laid
        return f"{laid}, cut: there was no place for bead {self.bead_count + 1} of {self.requested_count}"

    def __repr__(self) -> str:
        return f"<{self}>"


@dataclass(frozen=True, eq=False, repr=False)
class Wires(Wire):
    """One wire or several, wire after wire; n beads in all. ``requested_count`` and ``length`` are sums over all wires.

    The first bead of a wire has no link behind it: its angles are zero.
    """

    wire_count: int
    """Number of wires."""

    wire: np.ndarray
    """Wire to which each bead belongs, shape (n,), from 0 on."""

    theta: np.ndarray
    """Direction in the (x, y) plane of the link that leads to each bead [rad], shape (n,), turns added up."""

    phi: np.ndarray
    """Angle of that link to the plane [rad], shape (n,). The link is s (cos phi cos theta, cos phi sin theta, sin phi)."""

    phi_up: np.ndarray
    """The raise angle in force at each bead, with its sign [rad], shape (n,)."""

    skirted: np.ndarray
    """Whether phi_random was drawn from the wide range, as the bead met the chain or an obstacle; bool, shape (n,)."""

    rebounded: np.ndarray
    """Whether theta_random was drawn from the wide range, at a lateral face of the box; bool, shape (n,)."""

    switched: np.ndarray
    """Whether phi_up changed its sign, at the top or the bottom of the box; bool, shape (n,)."""

    @property
    def spacing(self) -> float:
        """Distance between the centres of consecutive beads [m]."""
        return self.interstice + 2.0 * float(self.radii[0])

    @property
    def chains(self) -> list[np.ndarray]:
        """Beads of each wire in the order of the chain, as indices of ``positions``: links join these, no others."""
        return [np.flatnonzero(self.wire == number) for number in range(self.wire_count)]

    @property
    def lengths(self) -> np.ndarray:
        """Laid length of each wire [m], shape (wire_count,)."""
        return (np.bincount(self.wire, minlength=self.wire_count) - 1) * self.spacing

    @property
    def length(self) -> float:
        """Laid length of all wires [m]."""
        return float(self.lengths.sum())

    @property
    def ends(self) -> np.ndarray:
        """Centre of the last bead of each wire [m], shape (wire_count, 3): where it was cut, if it was."""
        return np.array([self.positions[beads[-1]] for beads in self.chains])

    @property
    def cut_wires(self) -> np.ndarray:
        """Numbers of the wires that were cut, as their next bead fitted nowhere."""
        return np.flatnonzero(np.bincount(self.wire, minlength=self.wire_count) < self.requested_count // self.wire_count)

    def __str__(self) -> str:
        each = self.requested_count // self.wire_count
        many = f"{self.wire_count} wires" if self.wire_count > 1 else "wire"
        laid = f"{many} of {self.bead_count} beads, {self.length:.3g} m long"
        for cut in self.cut_wires[:3]:
            count = np.count_nonzero(self.wire == cut)
            place = ", ".join(f"{x:.4g}" for x in self.ends[cut])
            which = f"wire {cut}, {self.lengths[cut]:.3g} m, " if self.wire_count > 1 else ""
            laid += f"; {which}cut at ({place}) m: there was no place for bead {count + 1} of {each}"
        more = len(self.cut_wires) - 3
        return f"{laid}; {more} more cut" if more > 0 else laid


@named_arguments
def bead_mass(*, linear_density_dtex: float, spacing: float) -> float:
    """Mass of a bead [kg] such that the chain has the mass of the wire: linear density times spacing.

    ``linear_density_dtex`` [dtex]; ``spacing``: between the centres of consecutive beads, ``interstice`` + 2
    ``bead_radius`` [m].
    """
    density = number(linear_density_dtex, "linear_density_dtex", above=0.0, unit="dtex")
    return density * DTEX * number(spacing, "spacing", above=0.0, unit="m")


@named_arguments
def axial_rigidity(*, linear_density_dtex: float, young_modulus: float, density: float) -> float:
    """Axial rigidity EA [N] of a wire: E times its section, which is linear density / density.

    ``linear_density_dtex`` [dtex], ``young_modulus`` of the polymer [Pa], ``density`` of the polymer [kg/m³]. Elastic
    and Voigt links take this value (``axial_rigidity=``) for any spacing of the beads.
    """
    linear = number(linear_density_dtex, "linear_density_dtex", above=0.0, unit="dtex") * DTEX
    modulus = number(young_modulus, "young_modulus", above=0.0, unit="Pa")
    return modulus * linear / number(density, "density", above=0.0, unit="kg/m^3")


@named_arguments
def wire_length(
    *,
    content_km_per_m3: float | None = None,
    volume: float | None = None,
    content_by_weight: float | None = None,
    sand_mass: float | None = None,
    linear_density_dtex: float | None = None,
) -> float:
    """Length of wire [m] that a sample needs for its content, which is given in one of two ways.

    ``content_km_per_m3`` [km/m³] with the ``volume`` of the sample [m³]: 100 to 200 is usual (paper, section 1).
    ``content_by_weight``: mass of the wire over that of the dry sand, in (0, 1], 0.002 for 0.2 %, with the ``sand_mass``
    [kg] and the ``linear_density_dtex`` [dtex].

    Raises ValueError if neither way or both ways are given, or one of them only in part.
    """
    by_length = {"content_km_per_m3": content_km_per_m3, "volume": volume}
    by_weight = {
        "content_by_weight": content_by_weight,
        "sand_mass": sand_mass,
        "linear_density_dtex": linear_density_dtex,
    }
    given = [name for name, value in (by_length | by_weight).items() if value is not None]
    if given == list(by_length):
        content = number(content_km_per_m3, "content_km_per_m3", minimum=0.0, unit="km/m^3")
        return 1000.0 * content * number(volume, "volume", above=0.0, unit="m^3")
    if given == list(by_weight):
        share = number(content_by_weight, "content_by_weight", minimum=0.0, maximum=1.0)
        mass = number(sand_mass, "sand_mass", above=0.0, unit="kg")
        return share * mass / (DTEX * number(linear_density_dtex, "linear_density_dtex", above=0.0, unit="dtex"))
    raise ValueError(
        f"wire_length takes either {' and '.join(by_length)}, or {', '.join(by_weight)}; got "
        f"{', '.join(given) or 'none of them'}."
    )


@named_arguments
def wire_content(*, length: float, volume: float) -> float:
    """Content [km/m³] of a ``length`` of wire [m], such as ``thread.length``, in a ``volume`` [m³]."""
    return number(length, "length", minimum=0.0, unit="m") / number(volume, "volume", above=0.0, unit="m^3") / 1000.0


@named_arguments
def bead_count(*, length: float, spacing: float) -> int:
    """Number of beads of a wire of this ``length`` [m] with this ``spacing`` of their centres [m], to the nearest.

    A wire has one bead more than links.
    """
    links = number(length, "length", minimum=0.0, unit="m") / number(spacing, "spacing", above=0.0, unit="m")
    return whole(round(links) + 1, "the number of beads, length / spacing + 1,")
