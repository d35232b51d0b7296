"""lmgcpy: Non Smooth Contact Dynamics of rigid bodies, with interaction laws of your own."""

from lmgcpy import contact, laws
from lmgcpy.dynamics.simulation import Simulation
from lmgcpy.laws.coulomb import Coulomb
from lmgcpy.laws.elastic import ElasticRod, ElasticWire
from lmgcpy.laws.law import Law, Parameter
from lmgcpy.laws.restitution import Restitution
from lmgcpy.laws.rigid import RigidRod, RigidWire
from lmgcpy.laws.signorini import Signorini
from lmgcpy.laws.voigt import VoigtRod, VoigtWire
from lmgcpy.scene.body import Body, Disk, RigidBody, Wall, disk, wall
from lmgcpy.scene.chain import Chain
from lmgcpy.scene.contactor import Contactor, DiskContactor
from lmgcpy.scene.material import Material
from lmgcpy.scene.scene import Scene
from lmgcpy.solve.gauss_seidel import GaussSeidel

__version__ = "0.1.0"

__all__ = [
    "Body",
    "Chain",
    "Contactor",
    "Coulomb",
    "Disk",
    "DiskContactor",
    "ElasticRod",
    "ElasticWire",
    "GaussSeidel",
    "Law",
    "Material",
    "Parameter",
    "Restitution",
    "RigidBody",
    "RigidRod",
    "RigidWire",
    "Scene",
    "Signorini",
    "Simulation",
    "VoigtRod",
    "VoigtWire",
    "Wall",
    "__version__",
    "contact",
    "disk",
    "laws",
    "wall",
]
