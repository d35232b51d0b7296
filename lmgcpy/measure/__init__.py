"""Measures of a sample: stress by law, particle and window, contact network and forces, strain, density, wires, turning."""

from lmgcpy.measure.contact_forces import ContactForces, contact_forces
from lmgcpy.measure.contact_kinds import ContactKinds, contact_kinds
from lmgcpy.measure.density import density
from lmgcpy.measure.facets import Facets, facets
from lmgcpy.measure.forces_along import ForcesAlong, forces_along
from lmgcpy.measure.mean_strain import MeanStrain, mean_strain
from lmgcpy.measure.network import Network, network
from lmgcpy.measure.particle_stress import ParticleStress, particle_stress, window_stress
from lmgcpy.measure.strain import LocalStrain, strain
from lmgcpy.measure.stress import principal, stress
from lmgcpy.measure.tension_along import TautRuns, TensionCorrelation, taut_runs, tension_correlation
from lmgcpy.measure.turning import LongAxes, angular_momentum, long_axes
from lmgcpy.measure.wire_fabric import TensionByDirection, WireFabric, tension_by_direction, wire_fabric
from lmgcpy.measure.wire_friction import BeadSlip, WireContacts, bead_slip, wire_contacts
from lmgcpy.measure.wire_links import WireLinks, wire_links
from lmgcpy.measure.wire_shape import WireShape, wire_shape
from lmgcpy.measure.wire_stretch import StretchByDirection, stretch_by_direction

__all__ = [
    "BeadSlip",
    "ContactForces",
    "ContactKinds",
    "Facets",
    "ForcesAlong",
    "LocalStrain",
    "LongAxes",
    "MeanStrain",
    "Network",
    "ParticleStress",
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
