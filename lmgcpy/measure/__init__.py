"""Measures of a sample: stress by law, particle and window, contact network and forces, strain, density, wires, turning."""

from lmgcpy.measure.contacts import ContactForces, ContactKinds, Network, contact_forces, contact_kinds, network
from lmgcpy.measure.density import density
from lmgcpy.measure.facets import Facets, facets
from lmgcpy.measure.fields import CoarseFields, coarse_fields
from lmgcpy.measure.forces_along import ForcesAlong, forces_along
from lmgcpy.measure.reaction import Reaction, reaction
from lmgcpy.measure.strain import LocalStrain, MeanStrain, mean_strain, strain
from lmgcpy.measure.stress import ParticleStress, particle_stress, principal, stress, window_stress
from lmgcpy.measure.turning import LongAxes, angular_momentum, long_axes
from lmgcpy.measure.wire_fabric import (
    StretchByDirection,
    TensionByDirection,
    WireFabric,
    stretch_by_direction,
    tension_by_direction,
    wire_fabric,
)
from lmgcpy.measure.wire_friction import BeadSlip, WireContacts, bead_slip, wire_contacts
from lmgcpy.measure.wire_links import TautRuns, TensionCorrelation, WireLinks, taut_runs, tension_correlation, wire_links
from lmgcpy.measure.wire_shape import WireShape, wire_shape

__all__ = [
    "BeadSlip",
    "CoarseFields",
    "ContactForces",
    "ContactKinds",
    "Facets",
    "ForcesAlong",
    "LocalStrain",
    "LongAxes",
    "MeanStrain",
    "Network",
    "ParticleStress",
    "Reaction",
    "StretchByDirection",
    "TautRuns",
    "TensionByDirection",
    "TensionCorrelation",
    "WireContacts",
    "WireFabric",
    "WireLinks",
    "WireShape",
    "angular_momentum",
    "bead_slip",
    "coarse_fields",
    "contact_forces",
    "contact_kinds",
    "density",
    "facets",
    "forces_along",
    "long_axes",
    "mean_strain",
    "network",
    "particle_stress",
    "principal",
    "reaction",
    "strain",
    "stress",
    "stretch_by_direction",
    "taut_runs",
    "tension_by_direction",
    "tension_correlation",
    "window_stress",
    "wire_contacts",
    "wire_fabric",
    "wire_links",
    "wire_shape",
]


def __dir__() -> list[str]:
    return __all__
