"""Links of fixed and of greatest length: the paper's rigid rod and rigid wire (section 2.2).

Both laws use the predicted elongation ``g + h u_n - g_ref``, not the velocity alone. With ``u_n = 0`` the length of a rod
would drift; with the bias its error stays of second order in the step.
"""

from __future__ import annotations

from lmgcpy.laws.law import Law


def pull_back(gap, reference_gap, time_step):
    """Velocity bias ``(g - g_ref)/h`` [m/s]: with ``u_n = -bias`` the link ends the step at its reference."""
    return (gap - reference_gap) / time_step


class RigidRod(Law):
    """``u_n + (g - g_ref)/h = 0``: tension or compression keeps the distance.

    A pendulum that is let go level with its hook:

    >>> import lmgcpy as lm
    >>> scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    >>> hook = scene.add(lm.disk(radius=0.01, position=(0.0, 0.0), mass=1.0)).fix()
    >>> load = scene.add(lm.disk(radius=0.01, position=(0.5, 0.0), mass=1.0))
    >>> chain = scene.chain([hook, load], lm.RigidRod())
    >>> sim = lm.Simulation(scene, time_step=1e-3).run(duration=0.4)
    >>> float(round(sum(load.position**2) ** 0.5, 4))
    0.5
    """

    NAME = "rigid-rod"
    APPLIES_TO = "link"
    PREPARED = ("bias",)
    TRAITS = frozenset({"dissipative", "rigid"})

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        return (pull_back(gap, reference_gap, time_step),)

    @staticmethod
    def react(W, u, prepared):
        return (-(u[0] + prepared[0]) / W[0][0],)

    @staticmethod
    def slope(W, u, prepared):
        return ((-1.0 / W[0][0],),)

    @staticmethod
    def conic(prepared):
        return (prepared[0], 0.0, 0.0)


class BallJoint(RigidRod):
    """``u_i + g_i/h = 0`` along each axis i of space: two points of two bodies stay together. In 2D it is a hinge.

    The impulse is whatever this takes. Bodies turn freely about the point.

    A rod that hangs from a hinge at its end and is let go level:

    >>> import lmgcpy as lm
    >>> scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    >>> post = scene.add(lm.disk(radius=0.01, position=(0.0, 0.0), mass=1.0)).fix()
    >>> balls = [(lm.DiskContactor(0.01), (x, 0.0)) for x in (-0.2, 0.2)]
    >>> start = {"position": (0.2, 0.0), "color": "ROD"}
    >>> rod = scene.add(lm.RigidBody(balls, mass=1.0, inertia=0.04 / 3.0, **start))
    >>> hinge = scene.link(post, rod, lm.BallJoint(), at=((0.0, 0.0), (-0.2, 0.0)))
    >>> sim = lm.Simulation(scene, time_step=1e-3).run(steps=1)
    >>> sim.interactions.force[:, 0].round(4) + 0.0  # on the rod, along x and y [N]: a quarter of its weight
    array([0. , 2.5])
    """

    NAME = "ball-joint"
    TIES = True


class RigidWire(Law):
    """``0 <= -(u_n + (g - g_ref)/h)  _|_  -r_n >= 0``: slack below the reference gap, inextensible at it.

    A load falls freely until its wire is taut, and then swings on it:

    >>> import lmgcpy as lm
    >>> scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    >>> hook = scene.add(lm.disk(radius=0.01, position=(0.0, 0.0), mass=1.0)).fix()
    >>> load = scene.add(lm.disk(radius=0.01, position=(0.5, 0.0), mass=1.0))
    >>> chain = scene.chain([hook, load], lm.RigidWire(), reference_gap=0.58)
    >>> sim = lm.Simulation(scene, time_step=1e-3).run(duration=0.2)
    >>> load.position.round(9), float(sim.interactions.force[0, 0])
    (array([ 0.5, -0.2]), 0.0)
    >>> sim = sim.run(duration=0.3)
    >>> float(round(sum(load.position**2) ** 0.5, 4))
    0.6
    """

    NAME = "rigid-wire"
    APPLIES_TO = "link"
    PREPARED = ("bias",)
    TRAITS = frozenset({"pull", "dissipative", "rigid"})

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        return (pull_back(gap, reference_gap, time_step),)

    @staticmethod
    def react(W, u, prepared):
        return (min(0.0, -(u[0] + prepared[0]) / W[0][0]),)

    @staticmethod
    def slope(W, u, prepared):
        return ((-1.0 / W[0][0] if u[0] + prepared[0] > 0.0 else 0.0,),)

    @staticmethod
    def conic(prepared):
        return (prepared[0], 0.0, 0.0)
