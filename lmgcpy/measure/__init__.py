"""Measures of a sample: stress by law, particle and window, contact network and forces, strain, density, wires."""

from lmgcpy.measure.contact_forces import ContactForces, contact_forces
from lmgcpy.measure.density import density
from lmgcpy.measure.network import Network, network
from lmgcpy.measure.particle_stress import ParticleStress, particle_stress, window_stress
from lmgcpy.measure.strain import LocalStrain, strain
from lmgcpy.measure.stress import principal, stress
from lmgcpy.measure.wire_shape import WireShape, wire_shape
from lmgcpy.measure.wire_tension import WireTension, wire_tension

__all__ = [
    "ContactForces",
    "LocalStrain",
    "Network",
    "ParticleStress",
    "WireShape",
    "WireTension",
    "contact_forces",
    "density",
    "network",
    "particle_stress",
    "principal",
    "strain",
    "stress",
    "window_stress",
    "wire_shape",
    "wire_tension",
]


def __dir__() -> list[str]:
    return __all__
