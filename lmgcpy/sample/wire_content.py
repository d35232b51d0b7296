"""The wire in an engineer's words: linear density in dtex, content by weight or in km/m³, axial rigidity EA."""

from __future__ import annotations

from lmgcpy.errors import named_arguments, number, whole

DTEX = 1e-7
"""One dtex [kg/m]: 0.1 g per km."""


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
