"""The laws that come with lmgcpy, with parameters that tests vary around these; both ways of giving a stiffness occur."""

import lmgcpy as lm

INSTANCES = [
    lm.Signorini(),
    lm.Coulomb(friction=0.3),
    lm.RollingCoulomb(friction=0.3, rolling_friction=0.1),
    lm.Restitution(friction=0.3, restitution=0.5),
    lm.RigidRod(),
    lm.RigidWire(),
    lm.BallJoint(),
    lm.ElasticRod(stiffness=1e3),
    lm.ElasticWire(axial_rigidity=1e2),
    lm.VoigtRod(stiffness=1e3, viscosity=10.0),
    lm.VoigtWire(axial_rigidity=1e2, axial_viscosity=1.0),
]


def name(law):
    """Of a test."""
    return repr(law).replace(" ", "")
