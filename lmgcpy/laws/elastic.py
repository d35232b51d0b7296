"""Elastic links, implicit in the elongation: stable at any stiffness; also with viscosity in parallel (Kelvin and Voigt).

The force follows from the elongation at the end of the step, ``r_n = -h k (g + h u_n - g_ref)``. So stiffness enters as
a compliance ``C = 1/(h^2 k)`` beside W: the stiffer the link, the closer it is to the rigid law, at every time step. The
law damps as the implicit Euler method does: with one degree of freedom of frequency omega, the amplitude falls by
``1/sqrt(1 + (h omega)^2)`` a step.

With viscosity ``r_n = -h k (g + h u_n - g_ref) - h c u_n = -(u_n + b)/C`` with ``C = 1/(h^2 k + h c)`` and
``b = h k/(h k + c) (g - g_ref)/h``.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from lmgcpy.laws.law import Law, Parameter
from lmgcpy.laws.rigid import pull_back


class AxialLink(Law):
    """A link whose stiffness is given as ``stiffness`` k [N/m] or as ``axial_rigidity`` EA [N], ``k = EA / l0``.

    ``l0 = g_ref + R_a + R_b`` is the reference length between centres. So the answer of a wire given by its EA does not
    depend on the number of its beads.
    """

    APPLIES_TO = "link"
    PREPARED: ClassVar[tuple[str, ...]] = ("bias", "compliance")

    stiffness = Parameter("N/m", "force per elongation of one link, k", above=0.0, default=None)
    axial_rigidity = Parameter("N", "force per strain, EA", above=0.0, default=None)

    def validate(self) -> None:
        if (self.stiffness is None) == (self.axial_rigidity is None):
            raise ValueError(f"Law '{self.NAME}' takes either stiffness [N/m] or axial_rigidity [N], one of the two.")

    def table(self, reference_length: np.ndarray) -> np.ndarray:
        """Stiffness of each link [N/m], shape (count, 1)."""
        return self.per_link(self.stiffness, self.axial_rigidity, reference_length)

    @staticmethod
    def per_link(of_link: float | None, axial: float | None, reference_length: np.ndarray) -> np.ndarray:
        """A property of each link, shape (count, 1), from its value for one link or from its axial value for the wire."""
        length = np.asarray(reference_length, dtype=float)[:, None]
        return np.full_like(length, of_link) if axial is None else axial / length

    @staticmethod
    def conic(prepared):
        return (prepared[0], 0.0, prepared[1])

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        (stiffness,) = parameters
        return (pull_back(gap, reference_gap, time_step), 1.0 / (time_step * time_step * stiffness))


class ElasticRod(AxialLink):
    """``r_n = -h k (g+ - g_ref)`` with ``g+ = g + h u_n``.

    A load on a rod sinks by 2 m g/k in half a period:

    >>> import lmgcpy as lm
    >>> scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    >>> hook = scene.add(lm.disk(radius=0.01, position=(0.0, 0.0), mass=1.0)).fix()
    >>> load = scene.add(lm.disk(radius=0.01, position=(0.0, -0.5), mass=1.0))
    >>> chain = scene.chain([hook, load], lm.ElasticRod(stiffness=1000.0))
    >>> sim = lm.Simulation(scene, time_step=1e-4).run(duration=3.141593 * (1.0 / 1000.0) ** 0.5)
    >>> load.position.round(4)
    array([ 0.  , -0.52])
    """

    NAME = "elastic-rod"
    TRAITS = frozenset({"potential"})

    @staticmethod
    def react(W, u, prepared):
        bias, compliance = prepared
        return (-(u[0] + bias) / (W[0][0] + compliance),)

    @staticmethod
    def slope(W, u, prepared):
        return ((-1.0 / (W[0][0] + prepared[1]),),)

    @staticmethod
    def energy(gap, reference_gap, parameters, state):
        return 0.5 * parameters[0] * (gap - reference_gap) ** 2


class ElasticWire(AxialLink):
    """``r_n = -h k max(g+ - g_ref, 0)`` with ``g+ = g + h u_n``: tension only.

    Its stiffness is EA over the reference length, here between centres that are 0.5 m apart:

    >>> import lmgcpy as lm
    >>> scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    >>> hook = scene.add(lm.disk(radius=0.01, position=(0.0, 0.0), mass=1.0)).fix()
    >>> load = scene.add(lm.disk(radius=0.01, position=(0.0, -0.5), mass=1.0))
    >>> chain = scene.chain([hook, load], lm.ElasticWire(axial_rigidity=500.0))
    >>> sim = lm.Simulation(scene, time_step=1e-4).run(duration=3.141593 * (1.0 / 1000.0) ** 0.5)
    >>> load.position.round(4)
    array([ 0.  , -0.52])
    """

    NAME = "elastic-wire"
    TRAITS = frozenset({"potential", "pull"})

    @staticmethod
    def react(W, u, prepared):
        bias, compliance = prepared
        return (min(0.0, -(u[0] + bias) / (W[0][0] + compliance)),)

    @staticmethod
    def slope(W, u, prepared):
        return ((-1.0 / (W[0][0] + prepared[1]) if u[0] + prepared[0] > 0.0 else 0.0,),)

    @staticmethod
    def energy(gap, reference_gap, parameters, state):
        return 0.5 * parameters[0] * max(gap - reference_gap, 0.0) ** 2


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
