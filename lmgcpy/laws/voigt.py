"""Elastic links with viscosity in parallel (Kelvin and Voigt), implicit like the elastic links.

``r_n = -h k (g + h u_n - g_ref) - h c u_n = -(u_n + b)/C`` with ``C = 1/(h^2 k + h c)`` and
``b = h k/(h k + c) (g - g_ref)/h``.
"""

from __future__ import annotations

import numpy as np

from lmgcpy.laws.elastic import AxialLink, ElasticRod, ElasticWire
from lmgcpy.laws.law import Parameter
from lmgcpy.laws.rigid import pull_back


def spring_and_damper(gap, reference_gap, time_step, parameters):
    """Bias [m/s] and compliance [1/kg] of a spring and a damper side by side."""
    stiffness, viscosity = parameters
    force_per_velocity = time_step * stiffness + viscosity
    share = time_step * stiffness / force_per_velocity
    return (share * pull_back(gap, reference_gap, time_step), 1.0 / (time_step * force_per_velocity))


class VoigtLink(AxialLink):
    """A link with ``stiffness`` and ``viscosity`` c [N s/m], or ``axial_rigidity`` and ``axial_viscosity`` [N s]."""

    viscosity = Parameter("N s/m", "force per rate of elongation of one link, c", minimum=0.0, default=None)
    axial_viscosity = Parameter("N s", "force per rate of strain", minimum=0.0, default=None)

    def validate(self) -> None:
        super().validate()
        if (self.viscosity is None) == (self.axial_viscosity is None):
            raise ValueError(f"Law '{self.NAME}' takes either viscosity [N s/m] or axial_viscosity [N s], one of the two.")

    def table(self, reference_length: np.ndarray) -> np.ndarray:
        """Stiffness [N/m] and viscosity [N s/m] of each link, shape (count, 2)."""
        viscosity = self.per_link(self.viscosity, self.axial_viscosity, reference_length)
        return np.hstack([super().table(reference_length), viscosity])


class VoigtRod(VoigtLink):
    """``r_n = -h k (g+ - g_ref) - h c u_n``.

    A load on a damped rod comes to rest at m g/k:

    >>> import lmgcpy as lm
    >>> scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    >>> hook = scene.add(lm.disk(radius=0.01, position=(0.0, 0.0), mass=1.0)).fix()
    >>> load = scene.add(lm.disk(radius=0.01, position=(0.0, -0.5), mass=1.0))
    >>> chain = scene.chain([hook, load], lm.VoigtRod(stiffness=1000.0, viscosity=60.0))
    >>> sim = lm.Simulation(scene, time_step=1e-3).run(duration=2.0)
    >>> load.position.round(9)
    array([ 0.  , -0.51])
    """

    NAME = "voigt-rod"

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        return spring_and_damper(gap, reference_gap, time_step, parameters)

    react = staticmethod(ElasticRod.react)
    slope = staticmethod(ElasticRod.slope)
    energy = staticmethod(ElasticRod.energy)


class VoigtWire(VoigtLink):
    """The force of the Voigt rod if it is a tension and the predicted gap exceeds the reference; otherwise no force.

    In a slack link that is drawn taut within the step, the viscous force sets in at once, and the graph of the law jumps.
    The law completes the graph by its vertical part, on which the link ends the step at its reference gap. So it stays
    monotone and has one answer.

    A load on a damped wire comes to rest at m g/k:

    >>> import lmgcpy as lm
    >>> scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    >>> hook = scene.add(lm.disk(radius=0.01, position=(0.0, 0.0), mass=1.0)).fix()
    >>> load = scene.add(lm.disk(radius=0.01, position=(0.0, -0.5), mass=1.0))
    >>> chain = scene.chain([hook, load], lm.VoigtWire(stiffness=1000.0, viscosity=60.0))
    >>> sim = lm.Simulation(scene, time_step=1e-3).run(duration=2.0)
    >>> load.position.round(9)
    array([ 0.  , -0.51])
    """

    NAME = "voigt-wire"
    PREPARED = ("bias", "compliance", "elongation_rate")
    TRAITS = frozenset({"pull"})
    conic = None  # type: ignore[assignment]

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        bias, compliance = spring_and_damper(gap, reference_gap, time_step, parameters)
        return (bias, compliance, pull_back(gap, reference_gap, time_step))

    @staticmethod
    def react(W, u, prepared):
        bias, compliance, elongation_rate = prepared
        w = W[0][0]
        if u[0] + elongation_rate <= 0.0:
            return (0.0,)
        viscous = -(u[0] + bias) / (w + compliance)
        vertical = -(u[0] + elongation_rate) / w
        return (min(0.0, max(viscous, vertical)),)

    @staticmethod
    def slope(W, u, prepared):
        bias, compliance, elongation_rate = prepared
        w = W[0][0]
        viscous = -(u[0] + bias) / (w + compliance)
        vertical = -(u[0] + elongation_rate) / w
        if u[0] + elongation_rate <= 0.0 or max(viscous, vertical) >= 0.0:
            return ((0.0,),)
        return ((-1.0 / (w + compliance) if viscous > vertical else -1.0 / w,),)

    energy = staticmethod(ElasticWire.energy)
