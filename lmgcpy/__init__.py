"""lmgcpy: Non Smooth Contact Dynamics of rigid bodies, with interaction laws that users can add."""

import importlib
from typing import TYPE_CHECKING, Any

# first: numba makes its table of conversions in calls that are no deeper here than from ``import numba``. At some
# depths of imports within imports CPython takes and gives back memory for frames at every call: 0.1 s more
import lmgcpy.compiled  # noqa: F401
from lmgcpy import contact, io, laws
from lmgcpy.laws.coulomb import Coulomb
from lmgcpy.laws.elastic import ElasticRod, ElasticWire, VoigtRod, VoigtWire
from lmgcpy.laws.law import Law, Parameter, State
from lmgcpy.laws.restitution import Restitution
from lmgcpy.laws.rigid import BallJoint, RigidRod, RigidWire
from lmgcpy.laws.rolling import RollingCoulomb
from lmgcpy.laws.signorini import Signorini
from lmgcpy.scene.body import Body, Disk, RigidBody, Wall, disk, wall
from lmgcpy.scene.body_3d import Capsule, CylinderWall, Sphere, capsule, cylinder_wall, sphere
from lmgcpy.scene.cell import Cell
from lmgcpy.scene.chain import Chain
from lmgcpy.scene.clump import Clump, clump
from lmgcpy.scene.contactor import Contactor, DiskContactor, RodContactor, SphereContactor
from lmgcpy.scene.features import Surface, mesh, plate, read_mesh, wall_segment
from lmgcpy.scene.joint import Joint
from lmgcpy.scene.mesh_clump import MeshClump, clump_from_mesh
from lmgcpy.scene.scene import Scene
from lmgcpy.scene.skin import Net, PointMass, Skin, Thread, point_mass
from lmgcpy.scene.solid import Material
from lmgcpy.simulation import Simulation
from lmgcpy.simulation.resume import resume
from lmgcpy.solve.newton.alternating import Auto, Newton
from lmgcpy.solve.one_contact import LocalSolution, solve_local
from lmgcpy.solve.problems.problem import Problem
from lmgcpy.solve.problems.report import Outcome
from lmgcpy.solve.problems.residual import residual
from lmgcpy.solve.standalone import Solution, solve
from lmgcpy.solve.sweeps.accelerated import AcceleratedGaussSeidel
from lmgcpy.solve.sweeps.gauss_seidel import GaussSeidel
from lmgcpy.solve.sweeps.solver import Solver
from lmgcpy.solve.sweeps.step import Step
from lmgcpy.version import VERSION

if TYPE_CHECKING:
    from lmgcpy import measure, sample, view

__version__ = VERSION

__all__ = [
    "AcceleratedGaussSeidel",
    "Auto",
    "BallJoint",
    "Body",
    "Capsule",
    "Cell",
    "Chain",
    "Clump",
    "Contactor",
    "Coulomb",
    "CylinderWall",
    "Disk",
    "DiskContactor",
    "ElasticRod",
    "ElasticWire",
    "GaussSeidel",
    "Joint",
    "Law",
    "LocalSolution",
    "Material",
    "MeshClump",
    "Net",
    "Newton",
    "Outcome",
    "Parameter",
    "PointMass",
    "Problem",
    "Restitution",
    "RigidBody",
    "RigidRod",
    "RigidWire",
    "RodContactor",
    "RollingCoulomb",
    "Scene",
    "Signorini",
    "Simulation",
    "Skin",
    "Solution",
    "Solver",
    "Sphere",
    "SphereContactor",
    "State",
    "Step",
    "Surface",
    "Thread",
    "VoigtRod",
    "VoigtWire",
    "Wall",
    "__version__",
    "capsule",
    "clump",
    "clump_from_mesh",
    "contact",
    "cylinder_wall",
    "disk",
    "io",
    "laws",
    "measure",
    "mesh",
    "plate",
    "point_mass",
    "read_mesh",
    "residual",
    "resume",
    "sample",
    "solve",
    "solve_local",
    "sphere",
    "view",
    "wall",
    "wall_segment",
]


_LATER = ("experiment", "measure", "sample", "testing", "view")
"""Packages that are imported at their first use: a run draws, measures and tests nothing, and what it does costs time."""


def __getattr__(name: str) -> Any:
    if name in _LATER:
        return importlib.import_module(f"lmgcpy.{name}")
    from lmgcpy.errors import closest

    raise AttributeError(f"lmgcpy has no '{name}'{closest(name, __dir__())}")


def __dir__() -> list[str]:
    return sorted({*__all__, *_LATER})
