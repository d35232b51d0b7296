"""lmgcpy: Non Smooth Contact Dynamics of rigid bodies, with interaction laws of your own."""

import importlib
from typing import TYPE_CHECKING, Any

from lmgcpy import contact, io, laws, measure, sample
from lmgcpy.dynamics.simulation import Simulation
from lmgcpy.io.restart import resume
from lmgcpy.laws.coulomb import Coulomb
from lmgcpy.laws.elastic import ElasticRod, ElasticWire
from lmgcpy.laws.law import Law, Parameter, State
from lmgcpy.laws.restitution import Restitution
from lmgcpy.laws.rigid import RigidRod, RigidWire
from lmgcpy.laws.signorini import Signorini
from lmgcpy.laws.voigt import VoigtRod, VoigtWire
from lmgcpy.scene.body import Body, Disk, RigidBody, Wall, disk, wall
from lmgcpy.scene.body_3d import CylinderWall, Sphere, cylinder_wall, sphere
from lmgcpy.scene.chain import Chain
from lmgcpy.scene.contactor import Contactor, DiskContactor
from lmgcpy.scene.material import Material
from lmgcpy.scene.scene import Scene
from lmgcpy.solve.accelerated import AcceleratedGaussSeidel
from lmgcpy.solve.gauss_seidel import GaussSeidel
from lmgcpy.solve.newton.alternating import Auto, Newton
from lmgcpy.solve.one_contact import LocalSolution, solve_local
from lmgcpy.solve.problem import Problem, Solution, residual, solve

if TYPE_CHECKING:
    from lmgcpy import view

__version__ = "0.1.0"

__all__ = [
    "AcceleratedGaussSeidel",
    "Auto",
    "Body",
    "Chain",
    "Contactor",
    "Coulomb",
    "CylinderWall",
    "Disk",
    "DiskContactor",
    "ElasticRod",
    "ElasticWire",
    "GaussSeidel",
    "Law",
    "LocalSolution",
    "Material",
    "Newton",
    "Parameter",
    "Problem",
    "Restitution",
    "RigidBody",
    "RigidRod",
    "RigidWire",
    "Scene",
    "Signorini",
    "Simulation",
    "Solution",
    "Sphere",
    "State",
    "VoigtRod",
    "VoigtWire",
    "Wall",
    "__version__",
    "contact",
    "cylinder_wall",
    "disk",
    "io",
    "laws",
    "measure",
    "residual",
    "resume",
    "sample",
    "solve",
    "solve_local",
    "sphere",
    "view",
    "wall",
]


def __getattr__(name: str) -> Any:
    """``lmgcpy.view``, which is imported when it is first asked for: most runs look at nothing."""
    if name == "view":
        return importlib.import_module("lmgcpy.view")
    from lmgcpy.errors import closest

    raise AttributeError(f"lmgcpy has no '{name}'{closest(name, __all__)}")
