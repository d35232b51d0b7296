"""The laws that come with lmgcpy; they register through the same hook as plug-ins."""

from __future__ import annotations

from lmgcpy.laws.coulomb import Coulomb
from lmgcpy.laws.elastic import ElasticRod, ElasticWire, VoigtRod, VoigtWire
from lmgcpy.laws.registry import hook
from lmgcpy.laws.restitution import Restitution
from lmgcpy.laws.rigid import BallJoint, RigidRod, RigidWire
from lmgcpy.laws.rolling import RollingCoulomb
from lmgcpy.laws.signorini import Signorini


@hook
def lmgcpy_laws(register):
    for law in (
        Signorini,
        Coulomb,
        RollingCoulomb,
        Restitution,
        RigidRod,
        RigidWire,
        BallJoint,
        ElasticRod,
        ElasticWire,
        VoigtRod,
        VoigtWire,
    ):
        register(law)
