"""Every argument of every public callable, given what is wrong for its kind: each gets a sentence that names it.

``CALLS`` says of each callable how it is called rightly, and of what kind each argument is. A public callable that is not
in it, or an argument of one, fails the test of completeness; ``EXEMPT`` says which are left out, and why.
"""

from __future__ import annotations

import inspect
import math
import traceback
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sparse
from two_frames import TwoFrames

import lmgcpy as lm
from lmgcpy.experiment.biaxial import Biaxial
from lmgcpy.experiment.box import Sample
from lmgcpy.experiment.column.sample import lay_column
from lmgcpy.experiment.column.study import ColumnStudy
from lmgcpy.experiment.compaction import compact
from lmgcpy.experiment.grains import lay_grains
from lmgcpy.experiment.texsol.sample import lay_sample, lay_sample_3d
from lmgcpy.experiment.texsol.study import Study2D, Study3D
from lmgcpy.experiment.triaxial import Triaxial
from lmgcpy.sample.deposit import settle

ROOT = Path(lm.__file__).parent
nan, inf = math.nan, math.inf

NO_NUMBER = ["text", b"1", None, True, [1.0, 2.0], np.array([1.0]), object(), 1j, {}, print]
NO_QUANTITY = [nan, inf, -inf, np.float64(nan), 10**400, 1e300, -1e300]
NO_WORD = [3, None, True, ["x"], object(), nan]
NO_ARRAY = ["text", b"1", object(), ["a", "b"], [[1.0], [2.0, 3.0]], [1j, 0.0], [None, None], {}, print]
NOT_FINITE = [[nan, 0.0], [0.0, inf], [1e300, 0.0], [10**400, 0.0]]

NUMBER = [*NO_NUMBER, *NO_QUANTITY]
NOT_NEGATIVE = [*NUMBER, -1.0, -1e-9]
POSITIVE = [*NOT_NEGATIVE, 0, 0.0, -0.0, 1e-300]
FRACTION = [*NOT_NEGATIVE, 1.1]
COUNT = [*NO_NUMBER, *NO_QUANTITY, 0.5, 2.0, -1, 10**30]
VECTOR = [*NO_ARRAY, *NOT_FINITE, None, 1.0, [1.0], [1.0, 2.0, 3.0], [[1.0, 2.0]]]
VECTOR_OF_ANY = [value for value in VECTOR if value != [1.0, 2.0, 3.0]]
ARRAY = [*NO_ARRAY, *NOT_FINITE, None]
WORD = [*NO_WORD, ""]
CHOICE = [*NO_WORD, "", "nothing such"]
FLAG = ["yes", 1, 0, None, [], object(), nan]
PATH = [3, None, True, nan, "", b"run.h5", "a\0b", object()]
THING = ["text", 3, None, nan, object(), [1.0, 2.0]]
AXIS = [3, "up", "xy", "z", object(), True, [1.0], [0.0, 0.0], [nan, 1.0], [1.0, 2.0, 3.0]]
SEED = ["text", -1, 0.5, nan, object(), [-1]]
BOX = ["text", 1.0, None, [], [1.0], [1.0] * 4, [nan, 1.0], [inf, 1.0], [-1.0, 1.0], [0.0, 1.0], [None, 1.0], ["a", "b"]]
VECTOR_OR_FUNCTION = [value for value in VECTOR if value is not print and value is not None]
FUNCTION_OR_NUMBER = [value for value in NUMBER if value is not print]


def optional(kind):
    """The same, with None for what may be left out."""
    return [value for value in kind if value is not None]


def scene():
    made = lm.Scene(dimension=2)
    for i in range(3):
        made.add(lm.disk(radius=0.1, position=(0.3 * i, 0.0), mass=1.0))
    return made


def netted(**more):
    made = scene()
    given = {"bodies": made.bodies, "edges": [(0, 1), (1, 2)], "law": lm.RigidRod()}
    return made.net(**{**given, **more})


def covered(**more):
    made = lm.Scene(dimension=3)
    nodes = [made.add(lm.point_mass(position=p, mass=1.0)) for p in ((0, 0, 0), (1, 0, 0), (0, 1, 0))]
    given = {"bodies": nodes, "triangles": [(0, 1, 2)], "law": lm.RigidRod(), "radius": 0.1}
    return made.membrane(**{**given, **more})


def pushed(**more):
    made = scene()
    return made.impose_forces(**{"bodies": made.bodies, "forces": [(1.0, 2.0)] * 3, **more})


def disk():
    return lm.disk(radius=1.0, position=(0, 0), mass=1.0)


def simulate(**more):
    return lm.Simulation(**{"scene": scene(), **more})


def simulation():
    return simulate(time_step=1e-3)


def wire_in_sand():
    """A wire of two links among four grains, after a step, and where the bodies are."""
    made = lm.Scene(dimension=2)
    for k in range(3):
        made.add(lm.disk(radius=0.1, position=(0.3 * k, 0.1 * k * k), mass=1.0))
    made.chain(made.bodies[:3], lm.RigidWire())
    for x, y in ((0.0, 1.0), (1.0, 1.1), (0.0, 2.0), (1.0, 2.3)):
        made.add(lm.disk(radius=0.1, position=(x, y), mass=1.0))
    sim = lm.Simulation(made, time_step=1e-3)
    sim.step()
    return sim


WIRED = wire_in_sand()
MOTION = {"sim": WIRED, "since": WIRED.positions.copy()}


def two_frames():
    """What lm.measure.strain reads of a run."""
    positions = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.1]])
    return TwoFrames(positions, positions)


def parts_of_a_problem():
    return {"W": sparse.csr_array(np.eye(4)), "q": -np.ones(4), "mu": [0.3, 0.0], "laws": ("coulomb", "rigid-rod"),
            "dimension": 2, "compliance": np.zeros(2), "guess": np.zeros((2, 2))}  # fmt: skip


def problem():
    return lm.Problem(**parts_of_a_problem())


def sample():
    places = [[0.1, 0.1], [0.3, 0.1], [0.5, 0.1]]
    return Sample(positions=places, radii=[0.05] * 3, wires=(2,), reference_gap=0.1, box=(0.6, 0.2))


def sample_in_space():
    places = [[0.1, 0.1, 0.1], [0.3, 0.1, 0.1], [0.5, 0.1, 0.1]]
    return Sample(positions=places, radii=[0.05] * 3, wires=(2,), reference_gap=0.1, box=(0.6, 0.2, 0.2))


def links(**more):
    made = scene()
    return made.chain(**{"bodies": made.bodies, "law": lm.RigidWire(), **more})


def tie(**more):
    made = scene()
    a, b = made.bodies[:2]
    half = 0.5 * (b.position - a.position)
    return made.link(**{"a": a, "b": b, "law": lm.BallJoint(), "at": (half, -half), **more})


def biaxial_run(**more):
    return Biaxial(sample()).run(**{"strain": 0.1, **more})


WIRE_FRICTION = [*optional(ARRAY), (0.1,), (0.1, -0.1)]
COMPRESSION = {
    "sample": THING, "law": [*optional(THING), lm.RigidRod, lm.Signorini()], "pressure": POSITIVE, "density": POSITIVE,
    "friction": NOT_NEGATIVE, "platen_friction": NOT_NEGATIVE, "inertial_number": [*POSITIVE, 0.2],
    "axis": [*optional(CHOICE), "w"], "time_step": optional(POSITIVE), "wire_friction": WIRE_FRICTION,
}  # fmt: skip
STUDY = {
    "laws": [3, "none", (), ("none", "none"), ("nothing such",)], "grain_count": [*COUNT, 9], "bead_count": [*COUNT, 1],
    "seed": COUNT, "strain": [*POSITIVE, 0.6], "pressure": POSITIVE, "tolerance": [*POSITIVE, 1.1],
    "force_error": [*optional(POSITIVE), 1.5], "max_iterations": [*COUNT, 0], "friction": NOT_NEGATIVE,
    "greatest_reaction": optional(POSITIVE), "preparation": CHOICE, "theta_max": [*NOT_NEGATIVE, 4.0],
    "solver": CHOICE, "platen_friction": NOT_NEGATIVE, "inertial_number": [*POSITIVE, 0.2], "axial_rigidity": POSITIVE,
    "check_strain": [*NOT_NEGATIVE, 0.6], "threads": [*COUNT, 0],
}  # fmt: skip


IN_SPACE = [*NO_ARRAY, None, 1.0, [1.0], [1.0, 2.0], [1.0, 2.0, 3.0, 4.0], [[1.0, 2.0, 3.0]], (0.0, nan, 0.0)]
START = {"velocity": VECTOR, "rotation": NUMBER, "spin": NUMBER, "color": WORD}
def segment(points, **more):
    """``wall_segment``, whose points have no name."""
    return lm.wall_segment(*points if isinstance(points, list) else (points,), **more)


SETTLED = {"positions": [[0.1, 0.1]], "radii": [0.01], "box": (0.3, None), "obstacles": None}
PEANUT = lm.clump([0.01, 0.01], [(0, 0, 0), (0.01, 0, 0)], density=1.0)
FIBRES = {"radii": [0.01, 0.01], "content": 0.5, "radius": 0.002, "length": 0.02, "box": (0.2, 0.2, 0.2),
          "orientation": "horizontal"}  # fmt: skip
WIRE = {"box": (0.67, 0.67), "bead_radius": 0.0075, "interstice": 0.021, "bead_count": 9}
OBSTACLES = ["text", 3.0, object(), [1.0], (1.0, 2.0), ([[nan, 0.0]], [1.0]), ([[0.0, 0.0]], [0.0]), ([[0.0, 0.0]], ["a"])]
PANEL = {
    "source": THING, "what": optional(CHOICE), "frame": optional(COUNT), "grains": optional(CHOICE),
    "wires": optional(CHOICE), "opacity": optional(FRACTION), "clip": optional(CHOICE), "section": optional(CHOICE),
    "camera": optional(CHOICE), "title": [3, True, object(), nan], "limits": optional(VECTOR), "force": optional(POSITIVE),
    "region": optional([*THING, (0.0, 1.0), ((0.0, 0.0),), ((0.0, 0.0), (0.0, 1.0))]),
}  # fmt: skip

# fmt: off
CALLS = {
    # what it is called as, how it is called rightly, kinds of its arguments
    "Material": (lm.Material, {"name": "sand", "density": 1.0}, {"name": WORD, "density": POSITIVE}),
    "disk": (lm.disk, {"radius": 1.0, "position": (0, 0), "mass": 1.0},
        {"radius": POSITIVE, "position": VECTOR, "material": optional(THING), "color": WORD, "velocity": VECTOR,
         "spin": NUMBER, "mass": optional(POSITIVE), "inertia": optional(POSITIVE)}),
    "Disk": (lm.Disk, {"radius": 1.0, "position": (0, 0), "mass": 1.0, "color": "GRAIN"},
        {"radius": POSITIVE, "material": optional(THING), "mass": optional(POSITIVE), "inertia": optional(POSITIVE),
         "position": VECTOR, **START}),
    "wall": (lm.wall, {"point": (0, 0), "normal": (0, 1)},
        {"point": VECTOR, "normal": [*VECTOR, (0, 0)], "color": WORD, "mass": optional(POSITIVE)}),
    "Wall": (lm.Wall, {"point": (0, 0), "normal": (0, 1), "color": "WALL"},
        {"point": VECTOR, "normal": VECTOR, "mass": optional(POSITIVE), **START}),
    "sphere": (lm.sphere, {"radius": 1.0, "position": (0, 0, 0), "mass": 1.0},
        {"radius": POSITIVE, "position": IN_SPACE, "material": optional(THING), "color": WORD, "velocity": IN_SPACE,
         "spin": IN_SPACE, "mass": optional(POSITIVE), "inertia": optional(POSITIVE)}),
    "Sphere": (lm.Sphere, {"radius": 1.0, "position": (0, 0, 0), "mass": 1.0, "color": "GRAIN"},
        {"radius": POSITIVE, "material": optional(THING), "mass": optional(POSITIVE), "inertia": optional(POSITIVE),
         "position": IN_SPACE, "velocity": IN_SPACE, "spin": IN_SPACE, "color": WORD}),
    "cylinder_wall": (lm.cylinder_wall, {"point": (0, 0, 0), "axis": (0, 0, 1), "radius": 1.0},
        {"point": IN_SPACE, "axis": [*IN_SPACE, (0, 0, 0)], "radius": POSITIVE, "color": WORD, "mass": optional(POSITIVE)}),
    "CylinderWall": (lm.CylinderWall, {"point": (0, 0, 0), "axis": (0, 0, 1), "radius": 1.0, "color": "WALL"},
        {"point": IN_SPACE, "axis": IN_SPACE, "radius": POSITIVE, "mass": optional(POSITIVE), "velocity": IN_SPACE,
         "spin": IN_SPACE, "color": WORD}),
    "RigidBody": (lm.RigidBody,
        {"contactors": [lm.DiskContactor(1.0)], "mass": 1.0, "inertia": 1.0, "position": (0, 0), "color": "A"},
        {"contactors": [*THING, [], [(lm.DiskContactor(1.0), (nan, 0))]], "mass": POSITIVE, "inertia": POSITIVE,
         "position": VECTOR, **START}),
    "RigidBody in space": (lm.RigidBody,
        {"contactors": [lm.SphereContactor(1.0)], "mass": 1.0, "inertia": (1.0, 2.0, 3.0), "position": (0, 0, 0),
         "color": "A"},
        {"contactors": [*THING, [], [(lm.SphereContactor(1.0), (0, 0))]], "mass": POSITIVE,
         "inertia": [*POSITIVE, (1.0, 2.0), (1.0, 2.0, -3.0), (1.0, 1.0, 3.0)], "position": IN_SPACE, "velocity": IN_SPACE,
         "spin": IN_SPACE, "rotation": [*THING, 0.5, (1.0, 0.0, 0.0), (1.0, 1.0, 0.0, 0.0)], "color": WORD}),
    "DiskContactor": (lm.DiskContactor, {"radius": 1.0}, {"radius": POSITIVE}),
    "SphereContactor": (lm.SphereContactor, {"radius": 1.0}, {"radius": POSITIVE}),
    "RodContactor": (lm.RodContactor, {"radius": 1.0, "half": (0, 0, 1)},
        {"radius": POSITIVE, "half": [*IN_SPACE, (0, 0, 0)]}),
    "capsule": (lm.capsule, {"radius": 1.0, "length": 1.0, "position": (0, 0, 0), "mass": 1.0},
        {"radius": POSITIVE, "length": POSITIVE, "position": IN_SPACE, "axis": [*IN_SPACE, (0, 0, 0)],
         "rotation": optional([*THING, 0.5, (1.0, 1.0, 0.0, 0.0)]), "material": optional(THING), "mass": optional(POSITIVE),
         "color": WORD, "velocity": IN_SPACE, "spin": IN_SPACE}),
    "wall_segment": (segment, {"points": [(0, 0), (1, 0), (1, 1)]},
        {"points": [*THING, [(0, 0)], [(0, 0, 0), (1, 0, 0)], [(0, 0), (nan, 1)], [(0, 0), (1, 0), (1, 0)]],
         "radius": NOT_NEGATIVE, "closed": FLAG, "sides": CHOICE, "centre": optional(VECTOR), "material": optional(THING),
         "mass": optional(POSITIVE), "inertia": optional(POSITIVE), "rotation": NUMBER, "color": WORD}),
    "plate": (lm.plate, {"corners": [(0, 0, 0), (1, 0, 0), (0, 1, 0)]},
        {"corners": [*NO_ARRAY, None, [(0, 0, 0), (1, 0, 0)], [(0, 0), (1, 0), (1, 1)], [(0, 0, 0), (1, 0, 0), (2, 0, 0)],
                     [(0, 0, 0), (1, 0, 0), (1, 1, 0.1), (0, 1, 0)], [(0, 0, 0), (2, 0, 0), (0.5, 0.5, 0), (0, 2, 0)],
                     [(0, 3, 0), (2, -3, 0), (-3, 1, 0), (3, 1, 0), (-2, -3, 0)]],
         "radius": NOT_NEGATIVE, "centre": optional(IN_SPACE), "mass": optional(POSITIVE), "inertia": optional(POSITIVE),
         "rotation": optional([*THING, 0.5, (1.0, 1.0, 0.0, 0.0)]), "color": WORD}),
    "mesh": (lm.mesh, {"points": [(0, 0, 0), (1, 0, 0), (0, 1, 0)], "triangles": [(0, 1, 2)]},
        {"points": [*NO_ARRAY, None, [(0, 0), (1, 0), (1, 1)]],
         "triangles": [*THING, None, [], [(0, 1)], [(0, 1, 3)], [(0, 1, -1)], [(0, 1, 1)], [(0.0, 1.0, 2.0)],
                       [(0, 1, 2), (2, 0, 1)], [(0, 1, 2), (1,)]],
         "radius": NOT_NEGATIVE, "sides": CHOICE, "centre": optional(IN_SPACE), "material": optional(THING),
         "mass": optional(POSITIVE), "inertia": optional(POSITIVE),
         "rotation": optional([*THING, 0.5, (1.0, 1.0, 0.0, 0.0)]), "color": WORD}),
    "Capsule": (lm.Capsule, {"radius": 1.0, "length": 1.0, "position": (0, 0, 0), "mass": 1.0, "color": "A"},
        {"radius": POSITIVE, "length": POSITIVE, "material": optional(THING), "mass": optional(POSITIVE),
         "position": IN_SPACE, "velocity": IN_SPACE, "spin": IN_SPACE, "color": WORD}),
    "clump": (lm.clump, {"radii": [1.0, 1.0], "offsets": [(0, 0, 0), (1, 0, 0)], "density": 1.0},
        {"radii": [*ARRAY, [1.0, -1.0], [1.0], [1e-200, 1e-200]], "offsets": [*ARRAY, [(0, 0, 0)], [(0, 0, 0), (5, 0, 0)]],
         "density": POSITIVE, "separate": FLAG}),
    "Clump.at": (lm.clump([1.0, 1.0], [(0, 0, 0), (1, 0, 0)], density=1.0).at, {"position": (0, 0, 0)},
        {"position": IN_SPACE, "rotation": optional([*THING, 0.5, (1.0, 1.0, 0.0, 0.0)]), "scale": POSITIVE,
         "velocity": optional(IN_SPACE), "spin": optional(IN_SPACE),
         "color": WORD}),
    "Scene.add_clumps": (lambda **more: lm.Scene(dimension=3).add_clumps(**more),
        {"shape": lm.clump([1.0, 1.0], [(0, 0, 0), (1, 0, 0)], density=1.0), "positions": [(0, 0, 0), (5, 0, 0)]},
        {"shape": [*THING, lm.clump([1.0], [(0, 0)], density=1.0)], "positions": [*ARRAY, [(0, 0)]],
         "rotations": [*NO_ARRAY, 0.5, [(1.0, 1.0, 0.0, 0.0)] * 2], "scales": [*ARRAY[:-1], [1.0, -1.0]], "color": WORD,
         "velocities": [*NO_ARRAY, [(1.0, 2.0)]], "spins": [*NO_ARRAY, [(1.0, 2.0)]]}),
    "Body.fix": (lambda **more: scene().bodies[0].fix(*more.values()), {"components": "x"}, {"components": CHOICE}),
    "Body.impose_velocity": (lambda **more: scene().bodies[0].impose_velocity(**more), {"x": 1.0},
        {name: FUNCTION_OR_NUMBER for name in ("x", "y", "spin")}),
    "Body.impose_force": (lambda **more: scene().bodies[0].impose_force(**more), {"x": 1.0},
        {name: FUNCTION_OR_NUMBER for name in ("x", "y", "spin")}),
    "Scene": (lm.Scene, {"dimension": 2}, {"dimension": [*COUNT, 1, 4], "gravity": VECTOR_OR_FUNCTION}),
    "Scene.add": (lambda **more: scene().add(**{"body": disk(), **more}), {}, {"body": THING}),
    "Scene.see": (lambda **more: scene().see(**more),
        {"candidate": "GRAIN", "antagonist": "GRAIN", "law": lm.Signorini()},
        {"candidate": WORD, "antagonist": WORD, "law": [*THING, lm.Signorini, lm.RigidRod()],
         "alert": optional(NOT_NEGATIVE)}),
    "Scene.chain": (links, {},
        {"bodies": [*THING, [], range(3), disk()],
         "law": [*THING, lm.RigidRod, lm.Signorini()], "reference_gap": optional([*ARRAY, [1.0] * 3, -1.0]),
         "block_spin": FLAG, "closed": FLAG, "relaxation": NOT_NEGATIVE,
         "neighbours_collide": optional(FLAG), "parameters": [*optional(THING), {"stiffness": [1.0]}, {3: [1.0]}],
         "surface": optional(THING), "settled": FLAG}),
    "Scene.link": (tie, {},
        {"a": THING, "b": THING, "law": [*THING, lm.BallJoint, lm.Signorini()],
         "at": [*THING, [], [None], [(0.0, 0.05), (0.0, nan)], [(0.0, 0.0, 0.0), None], [None, (inf, 0.0)]],
         "reference_gap": optional([*ARRAY, 0.1]), "relaxation": NOT_NEGATIVE, "neighbours_collide": optional(FLAG)}),
    "point_mass": (lm.point_mass, {"position": (0, 0), "mass": 1.0},
        {"position": VECTOR_OF_ANY, "mass": POSITIVE, "color": WORD, "velocity": optional(VECTOR_OF_ANY)}),
    "PointMass": (lm.PointMass, {"position": (0, 0), "mass": 1.0},
        {"position": VECTOR_OF_ANY, "mass": POSITIVE, "color": WORD, "velocity": VECTOR_OF_ANY}),
    "Thread": (lm.Thread, {"radius": 0.1}, {"radius": POSITIVE, "color": WORD}),
    "Scene.net": (netted, {}, {"bodies": [*THING, [], range(3), disk()], "edges": [*ARRAY, [(0, 3)], [(0, 0)], [(0, 1, 2)]],
        "law": [*THING, lm.RigidRod, lm.Signorini()], "surface": optional(THING), "reference_gap": optional(ARRAY),
        "neighbours_collide": optional(FLAG)}),
    "Scene.membrane": (covered, {}, {"bodies": [*THING, [], range(3), disk()], "triangles": [*ARRAY, [(0, 1, 4)], [(0, 1)]],
        "law": [*THING, lm.RigidRod, lm.Signorini()], "radius": POSITIVE, "color": WORD, "reference_gap": optional(ARRAY)}),
    "Scene.impose_forces": (pushed, {}, {"bodies": [*THING[1:], range(3), disk()],
        "forces": [value for value in [*ARRAY, [(1.0, 2.0, 3.0)]] if value is not print]}),
    "Simulation": (simulate, {"time_step": 1e-3},
        {"scene": [*THING, lm.Scene], "time_step": POSITIVE, "theta": [*FRACTION, 0.4],
         "solver": [*optional(THING), lm.GaussSeidel], "on_unconverged": CHOICE, "overlap": CHOICE,
         "threads": COUNT, "geometric_stiffness": FLAG}),
    "Simulation.run": (lambda **more: simulation().run(**more), {"steps": 1},
        {"steps": optional(COUNT), "progress": FLAG, "record": optional(PATH)}),
    "Simulation.run for a time": (lambda **more: simulation().run(**more), {"duration": 1e-3},
        {"duration": optional(NOT_NEGATIVE)}),
    "Simulation.restore": (lambda **more: simulation().restore(**more), {"checkpoint": simulation().checkpoint()},
        {"checkpoint": THING}),
    "AcceleratedGaussSeidel": (lm.AcceleratedGaussSeidel, {},
        {"tolerance": [*POSITIVE, 1.1], "max_iterations": [*COUNT, 0], "wire_blocks": FLAG,
         "momentum": [*FRACTION, 1.0], "slip": optional(POSITIVE), "force": optional(POSITIVE)}),
    **{solver.__name__: (solver, {}, {"tolerance": [*POSITIVE, 1.1], "max_iterations": [*COUNT, 0],
                                      "max_factorisations": COUNT, "wire_blocks": FLAG,
                                      "slip": optional(POSITIVE), "force": optional(POSITIVE)})
       for solver in (lm.Auto, lm.Newton)},
    "GaussSeidel": (lm.GaussSeidel, {},
        {"tolerance": [*POSITIVE, 1.1], "max_iterations": [*COUNT, 0], "slip": optional(POSITIVE),
         "force": optional(POSITIVE)}),
    "Problem": (lm.Problem, parts_of_a_problem(),
        {"W": [*THING, np.eye(4), sparse.csr_array((4, 4)), sparse.csr_array(np.diag([1.0, 1.0, nan, 1.0]))],
         "q": [*ARRAY, np.zeros(3)], "mu": [*ARRAY, [0.0], [-1.0, 0.0]], "dimension": [*COUNT, 1, 4],
         "laws": [*THING, ("coulomb",), ("coulomb", "rigid-rad")], "compliance": [*ARRAY, [0.0], [0.0, -1.0]],
         "guess": [*ARRAY, np.zeros(4)], "scale": optional([*ARRAY, [0.0], [0.0, -1.0]]),
         "geometric": [*ARRAY, [0.0], [0.0, -1.0], [1.0, 0.0]],
         "split": [*optional(THING), (np.eye(4), np.zeros((4, 1)))],
         "rolling": [*ARRAY, [0.0], [0.0, -1.0], [0.1, 0.1]], "torsion": [*ARRAY, [0.0], [0.0, -1.0], [0.1, 0.1]],
         "cone_by_law": [None, "coulomb", 3, [], {"coulomb": 3}, {"coulomb": -1}, {"coulomb": "contact"}]}),
    "solve": (lm.solve, {"problem": problem()},
        {"problem": THING, "solver": [*optional(THING), lm.GaussSeidel], "guess": optional([*ARRAY, np.zeros(4)])}),
    "solve_local": (lm.solve_local, {"W": np.eye(3), "q": (-1.0, 0.0, 0.0), "friction": 0.3},
        {"W": [*ARRAY, np.eye(4), np.diag([1.0, 1.0, -1.0])], "q": [*ARRAY, np.zeros(2)], "friction": [*NUMBER, -1.0]}),
    "residual": (lm.residual, {"problem": problem(), "impulses": np.zeros((2, 2))},
        {"problem": THING, "impulses": [*ARRAY, np.zeros(4)], "measure": CHOICE}),
    "resume": (lm.resume, {"path": "absent.h5"}, {"path": PATH}),
    "laws.get": (lm.laws.get, {"name": "coulomb"}, {"name": ["", "nothing such", 3, None]}),
    "laws.register": (lambda **more: lm.laws.register(*more.values()), {"law": lm.Coulomb},
        {"law": ["text", 3, None, int, lm.Coulomb(friction=0.1)]}),
    "sample.grading": (lm.sample.grading, {"grain_count": 9, "minimum": 0.005, "maximum": 0.01},
        {"grain_count": [*COUNT, 0], "minimum": POSITIVE, "maximum": POSITIVE, "by": [*CHOICE, [[1.0]], [[nan, 0.0]]],
         "dimension": [*COUNT, 1, 4], "seed": SEED}),
    "sample.deposit": (lm.sample.deposit, {"radii": [0.01, 0.01], "box": (0.3, None)},
        {"radii": [*ARRAY, [], [0.0], [-1.0], 0.01], "box": BOX, "obstacles": OBSTACLES, "method": CHOICE,
         "order": CHOICE, "seed": SEED}),
    "sample.grid_positions": (lm.sample.grid_positions, {"radii": [0.01, 0.01], "box": (0.3, None)},
        {"radii": [*ARRAY, [], [0.0], [-1.0], 0.01], "box": BOX, "obstacles": OBSTACLES, "spacing": [*POSITIVE, 0.9],
         "order": CHOICE, "seed": SEED}),
    "sample.scatter": (lm.sample.scatter, {"radii": [0.01, 0.01], "cell": (0.3, 0.3)},
        {"radii": [*ARRAY, [], [0.0], [-1.0], 0.01], "cell": [*BOX, (1.0, None)], "seed": SEED}),
    "sample.net": (lm.sample.net, {"size": (1.0, 0.5), "mesh": 0.25},
        {"size": [*ARRAY, 1.0, (1.0, 0.0), (1.0, 0.6), (1e9, 1.0)], "mesh": [*ARRAY, 0.0, -1.0, 0.3, (0.1, 0.1, 0.1)],
         "nodes": [*COUNT, 0]}),
    "sample.membrane_around": (lm.sample.membrane_around, {"radius": 0.05, "height": 0.2, "spacing": 0.02},
        {"radius": optional(POSITIVE), "height": POSITIVE, "spacing": POSITIVE}),
    "sample.membrane_around a box": (lm.sample.membrane_around, {"box": (0.1, 0.2), "height": 0.2, "spacing": 0.02},
        {"box": optional([*ARRAY, 1.0, (1.0, 0.0), (1.0, 1.0, 1.0)])}),
    "sample.fibres": (lm.sample.fibres, FIBRES,
        {"radii": [*ARRAY, [0.0], [-1.0], 0.01], "content": [*NOT_NEGATIVE, 1e-9, 1e5], "radius": POSITIVE,
         "length": [*POSITIVE, 0.3], "box": [*BOX, (0.3, 0.3), (0.3, 0.3, None), (0.3, 0.3, 0.015)],
         "orientation": [*optional(IN_SPACE), "upright", (0.0, 0.0, 0.0)], "spread": optional([*NOT_NEGATIVE, 1.6]),
         "grain_volume": optional(POSITIVE), "seed": SEED}),
    "Fibres.capsules": (lm.sample.fibres(**FIBRES).capsules, {"material": lm.Material("steel", density=1.0)},
        {"material": [*THING, None], "segments": [*COUNT, 0], "color": WORD}),
    "sample.join_segments": (lm.sample.join_segments, {"scene": lm.Scene(dimension=3), "capsules": [], "segments": 2},
        {"scene": THING, "capsules": [*THING, [PEANUT]], "segments": [*COUNT, 0]}),
    "sample.deposit_bodies": (lm.sample.deposit_bodies, {"bodies": [PEANUT.at((0, 0, 0))], "box": (0.3, 0.3, None)},
        {"bodies": [*THING, [], [disk()], [PEANUT], [lm.wall(point=(0, 0, 0), normal=(0, 0, 1))]],
         "box": [*BOX, (0.3, 0.3), (0.3, 0.02, 0.3), (0.3, 0.3, 1e-3)], "friction": NOT_NEGATIVE, "seed": SEED,
         "max_steps": [*COUNT, 0]}),
    "sample.wire_2d": (lm.sample.wire_2d, WIRE,
        {"box": [*BOX, (1.0, None)], "bead_radius": POSITIVE, "interstice": NOT_NEGATIVE, "bead_count": [*COUNT, 0],
         "theta_max": [*NOT_NEGATIVE, 4.0], "start": optional(VECTOR), "clearance": NOT_NEGATIVE,
         "choices": [*COUNT, 0], "seed": SEED}),
    "sample.wire_3d": (lm.sample.wire_3d,
        {"box": (0.1, 0.1, 0.2), "bead_radius": 0.001, "interstice": 0.001, "bead_count": 200},
        {"box": [*BOX, (0.1, 0.1), (0.1, 0.1, None)], "interstice": NOT_NEGATIVE, "bead_count": [*COUNT, 0],
         "bead_radius": optional(POSITIVE), "theta_max": [*NOT_NEGATIVE, 4.0], "phi_max": [*NOT_NEGATIVE, 2.0],
         "raise_angle": optional([*NUMBER, 2.0]), "switch": FLAG, "retreats": COUNT, "start": optional([*ARRAY, [0.1]]),
         "wires": [*COUNT, 0], "obstacles": OBSTACLES, "seed": SEED}),
    "sample.wire_3d of grains": (lm.sample.wire_3d,
        {"box": (0.1, 0.1, 0.2), "grain_radii": 0.005, "interstice": 0.001, "bead_count": 200},
        {"grain_radii": [nan, "text", object(), [], [0.0], [-1.0], [nan], ["a"], 1j]}),
    "sample.bead_mass": (lm.sample.bead_mass, {"linear_density_dtex": 50.0, "spacing": 0.01},
        {"linear_density_dtex": POSITIVE, "spacing": POSITIVE}),
    "sample.axial_rigidity": (lm.sample.axial_rigidity,
        {"linear_density_dtex": 50.0, "young_modulus": 1e9, "density": 1000.0},
        {"linear_density_dtex": POSITIVE, "young_modulus": POSITIVE, "density": POSITIVE}),
    "sample.wire_length": (lm.sample.wire_length, {"content_km_per_m3": 100.0, "volume": 1.0},
        {"content_km_per_m3": NOT_NEGATIVE, "volume": POSITIVE}),
    "sample.wire_length by weight": (lm.sample.wire_length,
        {"content_by_weight": 0.002, "sand_mass": 1.0, "linear_density_dtex": 50.0},
        {"content_by_weight": [*FRACTION], "sand_mass": POSITIVE, "linear_density_dtex": POSITIVE}),
    "sample.wire_content": (lm.sample.wire_content, {"length": 1.0, "volume": 1.0},
        {"length": NOT_NEGATIVE, "volume": POSITIVE}),
    "sample.bead_count": (lm.sample.bead_count, {"length": 1.0, "spacing": 0.1},
        {"length": NOT_NEGATIVE, "spacing": POSITIVE}),
    "settle": (settle, SETTLED,
        {"positions": [*ARRAY, [[0.1]]], "radii": [*ARRAY, [0.0], [-1.0]], "box": BOX, "obstacles": OBSTACLES,
         "friction": NOT_NEGATIVE, "max_steps": [*COUNT, 0]}),
    "measure.density": (lm.measure.density, {"positions": [[0.0, 0.0]], "radii": [1.0], "window": ((0, 0), (1, 1))},
        {"positions": [*ARRAY, [[0.0]]], "radii": [*ARRAY, [-1.0]], "window": [*ARRAY, [0.0, 1.0], ((1, 1), (0, 0))]}),
    "measure.stress": (lm.measure.stress, {"sim": simulation(), "volume": 1.0},
        {"sim": THING, "volume": POSITIVE}),
    "measure.network": (lm.measure.network, {"sim": simulation()}, {"sim": THING}),
    "measure.contact_forces": (lm.measure.contact_forces, {"sim": simulation()}, {"sim": THING}),
    "measure.particle_stress": (lm.measure.particle_stress, {"sim": simulation()}, {"sim": THING}),
    "measure.window_stress": (lm.measure.window_stress, {"sim": simulation(), "window": ((0, 0), (1, 1))},
        {"sim": THING, "window": [*THING, ((0, 0),), ((0, 0), (0, 1))]}),
    "measure.coarse_fields": (lm.measure.coarse_fields, {"sim": simulation(), "width": 0.1},
        {"sim": THING, "width": POSITIVE, "spacing": optional([*POSITIVE, 1e-9]),
         "region": [*optional(THING), ((0, 0),), ((0, 0), (0, 1))]}),
    "measure.angular_momentum": (lm.measure.angular_momentum, {"sim": simulation()},
        {"sim": THING, "about": optional(VECTOR)}),
    "measure.long_axes": (lm.measure.long_axes, {"sim": lm.Simulation(lm.Scene(dimension=3), time_step=1e-3)},
        {"sim": THING}),
    "measure.facets": (lm.measure.facets, {"sim": simulation()}, {"sim": THING}),
    "measure.reaction": (lm.measure.reaction, {"sim": simulation(), "bodies": 0},
        {"sim": THING, "bodies": ["nothing", None, nan, 0.5, [], [0, 99], [-1], object()], "about": optional(VECTOR)}),
    "measure.forces_along": (lm.measure.forces_along, {"sim": WIRED}, {"sim": THING}),
    "measure.contact_kinds": (lm.measure.contact_kinds, {"sim": WIRED}, {"sim": THING, "tolerance": FRACTION}),
    "measure.wire_links": (lm.measure.wire_links, {"sim": WIRED}, {"sim": THING}),
    "measure.wire_fabric": (lm.measure.wire_fabric, {"sim": WIRED}, {"sim": THING, "volume": optional(POSITIVE)}),
    "measure.tension_by_direction": (lm.measure.tension_by_direction, {"sim": WIRED},
        {"sim": THING, "axis": AXIS, "bins": [*COUNT, 0], "volume": optional(POSITIVE)}),
    "measure.wire_contacts": (lm.measure.wire_contacts, {"sim": WIRED}, {"sim": THING, "tolerance": FRACTION}),
    "measure.tension_correlation": (lm.measure.tension_correlation, {"sim": WIRED}, {"sim": THING, "lags": [*COUNT, 0]}),
    "measure.taut_runs": (lm.measure.taut_runs, {"sim": WIRED}, {"sim": THING}),
    "measure.mean_strain": (lm.measure.mean_strain, MOTION,
        {"sim": THING, "since": [*ARRAY, [1.0, 2.0]], "window": [3, "text", object(), ((0, 0),), ((0, 0), (0, 1))],
         "margin": NOT_NEGATIVE, "kind": CHOICE}),
    "measure.stretch_by_direction": (lm.measure.stretch_by_direction, MOTION,
        {"sim": THING, "since": [*ARRAY, [1.0, 2.0]], "axis": AXIS, "bins": [*COUNT, 0], "links": [*COUNT, 0],
         "kind": CHOICE}),
    "measure.bead_slip": (lm.measure.bead_slip, MOTION,
        {"sim": THING, "since": [*ARRAY, [1.0, 2.0]], "neighbours": [*optional(COUNT), 2]}),
    "measure.strain": (lm.measure.strain, {"sim": two_frames()},
        {"sim": THING, "frame": optional(NO_NUMBER), "since": NO_NUMBER}),
    "measure.principal": (lm.measure.principal, {"sigma": np.eye(2)}, {"sigma": [*ARRAY, [1.0, 2.0], np.eye(4)]}),
    "measure.wire_shape": (lm.measure.wire_shape, {"positions": [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], "chains": None},
        {"positions": [*ARRAY, [0.0, 1.0], [[0.0, 0.0]], np.zeros((3, 2))],
         "chains": [3, "text", object(), [], ["abc"], [[0, 1]], [[0, 1, 3]], [[0, 1, -1]], [[0, 1, 1.5]], [[0, 1, nan]]]}),
    "io.open_run": (lm.io.open_run, {"path": "absent.h5"}, {"path": PATH}),
    "io.Run": (lm.io.Run, {"path": "absent.h5"}, {"path": PATH}),
    "io.take_up": (lm.io.take_up, {"sim": simulation(), "path": "absent.h5"}, {"sim": THING, "path": PATH}),
    "io.compare": (lm.io.compare, {"a": None, "b": None}, {"a": THING, "b": THING}),
    "io.export_csv": (lm.io.export_csv, {"run": None, "folder": "out"}, {"run": THING}),
    "view.export_vtk": (lm.view.export_vtk, {"run": None, "folder": "out"}, {"run": THING}),
    "view.draw_fields": (lm.view.draw_fields,
        {"fields": lm.measure.coarse_fields(simulation(), width=0.5), "path": "a.png"},
        {"fields": THING, "path": PATH, "what": CHOICE, "cut": optional(THING)}),
    "view.export_fields": (lm.view.export_fields,
        {"fields": lm.measure.coarse_fields(simulation(), width=0.5), "path": "a.vti"}, {"fields": THING, "path": PATH}),
    "io.fclib.read": (lm.io.fclib.read, {"path": "absent.h5"}, {"path": PATH}),
    "io.fclib.write": (lm.io.fclib.write, {"problem": problem(), "path": "/no/such/folder/p.h5"},
        {"problem": THING, "path": PATH}),
    "view.check": (lm.view.check, {"source": scene()},
        {"source": THING, "frame": optional(COUNT), "overlap": NOT_NEGATIVE, "excess": NOT_NEGATIVE}),
    "view.render": (lm.view.render, {"source": scene(), "path": "a.png", "size": (20, 20)},
        {**PANEL, "path": PATH, "size": optional([*VECTOR, (15, 20)]), "columns": [*optional(COUNT), 0],
         "frames_per_second": [*POSITIVE, 101.0]}),
    "view.show": (lm.view.show, {"source": scene()}, PANEL),
    "view.plot": (lm.view.plot, {"runs": None, "path": "a.png"}, {"runs": THING}),
    "Study2D": (Study2D, {}, STUDY),
    "Study3D": (Study3D, {},
        {**STUDY, "laws": [*STUDY["laws"], ("rigid-rod",)], "axes": [3, "z", (), ("z", "z"), ("w",)],
         "wires": [*COUNT, 0], "bead_mass": optional(CHOICE), "wire": CHOICE, "thread_diameter": optional(POSITIVE),
         "slenderness": [*POSITIVE, 0.05, 11.0], "node_distance": POSITIVE, "dtex": POSITIVE,
         "wire_friction": WIRE_FRICTION}),
    "ColumnStudy": (ColumnStudy, {},
        {"contents": [3, "0.1", None, (), (0.1, 0.1), (0.0,), (-0.1,), (11.0,), (nan,), ("much",)],
         "grain_count": [*COUNT, 9], "aspect": [*POSITIVE, 0.05, 21.0], "friction": NOT_NEGATIVE, "diameter": POSITIVE,
         "bead_diameter": [*POSITIVE, 0.04, 0.5], "seed": COUNT, "refinements": [*COUNT, 21],
         "tolerance": [*POSITIVE, 1.5], "max_iterations": [*COUNT, 0], "travel": [*POSITIVE, 5.0], "threads": [*COUNT, 0],
         "wire": CHOICE, "node_distance": POSITIVE}),
    "lay_column": (lay_column, {"grain_count": 12, "content": 1.0, "aspect": 1.0},
        {"grain_count": [*COUNT, 9], "content": [*NOT_NEGATIVE, 11.0], "aspect": [*POSITIVE, 0.05, 21.0],
         "diameter": POSITIVE, "bead_diameter": [*POSITIVE, 0.04, 0.5], "seed": COUNT,
         "thread": FLAG, "node_distance": POSITIVE}),
    "lay_sample": (lay_sample, {"grain_count": 20, "bead_count": 0},
        {"grain_count": [*COUNT, 9], "bead_count": [*COUNT, 1], "minimum": POSITIVE, "maximum": POSITIVE, "seed": SEED,
         "theta_max": [*NOT_NEGATIVE, 4.0], "method": CHOICE}),
    "lay_sample_3d": (lay_sample_3d, {"grain_count": 20, "bead_count": 0},
        {"grain_count": [*COUNT, 9], "bead_count": [*COUNT, 1], "wires": [*COUNT, 0], "minimum": POSITIVE,
         "maximum": POSITIVE, "slenderness": [*POSITIVE, 0.05, 11.0], "theta_max": [*NOT_NEGATIVE, 4.0],
         "density": POSITIVE, "seed": SEED, "thread": [*FLAG], "thread_diameter": optional([*POSITIVE, 1.0]),
         "node_distance": POSITIVE}),
    "Sample": (Sample, vars(sample()),
        {"positions": [*ARRAY, [[0.1]]], "radii": [*ARRAY, [0.0], [-1.0]],
         "wires": [3, "two", None, (1,), (4,), ("two",)], "reference_gap": [*ARRAY, [0.1] * 9],
         "box": [*ARRAY, (1.0,), (0.0, 1.0), (1.0, 1.0, 1.0)], "bead_mass": optional(POSITIVE),
         "bodies": [*THING, [disk()], [lm.clump([1.0], [(0, 0)], density=1.0).at((0, 0))], [PEANUT.at((0, 0, 0))]],
         "segments": [*COUNT, 0], "thread": [*FLAG, True]}),
    "lay_grains": (lay_grains, {"grain_count": 20, "content": 0.05, "fibre_length": 2e-3, "orientation": "horizontal"},
        {"grain_count": [*COUNT, 9], "minimum": POSITIVE, "maximum": POSITIVE,
         "shape": [*optional(THING), lm.clump([1.0], [(0, 0)], density=1.0)], "content": [*NOT_NEGATIVE, 1e-9, 1.1],
         "fibre_radius": POSITIVE, "fibre_length": POSITIVE, "orientation": [*optional(IN_SPACE), "upright"],
         "spread": optional([*NOT_NEGATIVE, 1.6]), "segments": [*COUNT, 0], "density": POSITIVE, "seed": SEED}),
    "compact": (compact, {"sample": lay_sample(30, 0), "pressure": 1e5, "density": 2600.0, "max_steps": 5},
        {"sample": THING, "pressure": POSITIVE, "density": POSITIVE, "friction": NOT_NEGATIVE,
         "drag": optional(NOT_NEGATIVE), "time_step": optional(POSITIVE), "solver": [*optional(THING), lm.GaussSeidel],
         "max_steps": optional([*COUNT, 0]), "wire_friction": WIRE_FRICTION}),
    "Biaxial": (Biaxial, {"sample": sample()}, COMPRESSION),
    "Triaxial": (Triaxial, {"sample": sample_in_space()}, COMPRESSION),
    "Biaxial.run": (biaxial_run, {},
        {"strain": [*POSITIVE, 1.0], "frames": COUNT, "greatest_reaction": optional(POSITIVE)}),
}
# fmt: on
CALLED = {
    "name": ["name of a material", "law"],
    "contactors": ["contactor"],
    "components": ["component", "fix"],
    "triangles": ["triangle", "Triangle"],
    "corners": ["corner", "Corner", "plate"],
    "points": ["points", "point"],
    "body": ["body", "Scene.add"],
    "candidate": ["colour", "candidate"],
    "antagonist": ["colour", "antagonist"],
    "law": ["law", "Law"],
    "bodies": ["bodies", "chain", "Chain", "net"],
    "reference_gap": ["reference"],
    "checkpoint": ["restore", "checkpoint"],
    "laws": ["law"],
    "by": ["by", "curve"],
    "impulses": ["impulses"],
    "sim": ["stress", "sim"],
    "sigma": ["stress"],
    "a": ["compare", "Scene.link", "chain"],
    "b": ["compare", "Scene.link", "chain"],
    "run": ["export_csv", "export_vtk", "run must be"],
    "sample": ["Sample"],
    "grain_count": ["grain"],
    "bead_count": ["bead"],
    "positions": ["positions"],
    "radii": ["radii", "positions"],
    "axes": ["axes", "axis"],
    "box": ["box", "positions"],
    "cell": ["cell", "box"],
}
"""Words one of which names an argument in a sentence, where it is not its own name."""

EXEMPT = {
    "Body": "abstract: through Disk, Wall and RigidBody",
    "Cell": "made by Scene.periodic",
    "Chain": "made by Scene.chain",
    "Joint": "made by Scene.link",
    "Net": "made by Scene.net and Scene.membrane",
    "Skin": "made by Scene.chain, Scene.net and Scene.membrane",
    "Clump": "made by clump",
    "MeshClump": "made by clump_from_mesh",
    "clump_from_mesh": "in tests/scene/test_mesh_clump.py",
    "Surface": "made by wall_segment, plate and mesh",
    "read_mesh": "in tests/scene/test_surfaces.py",
    "Contactor": "abstract",
    "Law": "abstract; what authors of laws may do wrong is in tests/laws",
    "Parameter": "of authors of laws",
    "State": "of authors of laws",
    "laws.Pair": "given to laws",
    "Solution": "a result",
    "Outcome": "a result",
    "Step": "made by simulations and lmgcpy.solve",
    "Solver": "abstract; through the built-in ones",
    "LocalSolution": "a result",
    "measure.Network": "a result",
    "measure.ContactForces": "a result",
    "measure.Facets": "a result",
    "measure.CoarseFields": "a result",
    "measure.Reaction": "a result",
    "measure.ForcesAlong": "a result",
    "measure.ParticleStress": "a result",
    "measure.LocalStrain": "a result",
    "measure.LongAxes": "a result",
    "sample.Cells": "a result",
    "measure.WireShape": "a result",
    "measure.BeadSlip": "a result",
    "measure.ContactKinds": "a result",
    "measure.MeanStrain": "a result",
    "measure.StretchByDirection": "a result",
    "measure.TautRuns": "a result",
    "measure.TensionByDirection": "a result",
    "measure.TensionCorrelation": "a result",
    "measure.WireContacts": "a result",
    "measure.WireFabric": "a result",
    "measure.WireLinks": "a result",
    "view.Layout": "a result",
    "sample.Fibres": "a result",
    "sample.Wire": "a result",
    "sample.Wires": "a result",
    "laws.Law": "see Law",
    "laws.Parameter": "see Parameter",
    "laws.State": "see State",
    "laws.hook": "a decorator of pluggy",
    "laws.names": "takes nothing",
    "laws.failures": "takes nothing",
    "laws.registrations": "takes nothing",
}
OF_FRAMES = (
    *("contact_kinds", "wire_links", "wire_fabric", "tension_by_direction", "wire_contacts", "tension_correlation"),
    *("taut_runs", "mean_strain", "stretch_by_direction", "bead_slip", "angular_momentum", "long_axes"),
    *("facets", "forces_along", "coarse_fields"),
)
EXEMPT_ARGUMENTS = {
    ("Simulation.run", "duration"): "has a row of its own",
    ("Simulation.run", "every"): "of the file: in tests/bad_input",
    ("Simulation.run", "flush"): "of the file: in tests/bad_input",
    ("Simulation.run", "force"): "of the file",
    ("Simulation.run", "observe"): "in tests/io/test_observations.py",
    ("Simulation.run", "until"): "in tests/io/test_observations.py",
    ("Simulation.run", "on_step"): "in tests/dynamics/test_changes.py",
    ("GaussSeidel", "wire_blocks"): "below",
    ("resume", "functions"): "in tests/bad_input",
    ("resume", "observe"): "in tests/io/test_observations.py",
    ("resume", "solver"): "in tests/bad_input",
    ("resume", "time_step"): "in tests/io/test_resume.py",
    ("resume", "record"): "in tests/io/test_resume.py",
    ("laws.register", "distribution"): "of plug-ins",
    ("io.take_up", "observe"): "in tests/io/test_observations.py",
    ("io.take_up", "notes"): "of the studies",
    ("io.compare", "tolerance"): "in tests/bad_input",
    ("measure.stress", "frame"): "of run files: in tests/measure",
    ("measure.network", "frame"): "of run files: in tests/measure",
    ("measure.reaction", "frame"): "of run files: in tests/measure",
    ("measure.contact_forces", "frame"): "of run files: in tests/measure",
    ("measure.particle_stress", "frame"): "of run files: in tests/measure",
    ("measure.window_stress", "frame"): "of run files: in tests/measure",
    **dict.fromkeys(((f"measure.{name}", "frame") for name in OF_FRAMES), "of run files: in tests/measure"),
    ("Simulation.run", "notes"): "in tests/io/test_notes_and_compare.py",
    ("Biaxial", "solver"): "of its simulation",
    ("Triaxial", "solver"): "of its simulation",
    **dict.fromkeys((("compact", name) for name in ("file", "on_step", "interrupted")), "of the studies"),
    **dict.fromkeys((("Biaxial.run", name) for name in ("file", "on_step", "interrupted")), "of the studies"),
    ("io.export_csv", "folder"): "in tests/bad_input",
    ("io.export_csv", "force"): "in tests/io",
    ("view.export_vtk", "folder"): "as of io.export_csv",
    ("view.export_fields", "force"): "in tests/view/test_field_pictures.py",
    ("view.export_vtk", "force"): "in tests/view",
    ("view.plot", "path"): "in tests/view/test_curves.py",
    ("view.plot", "what"): "in tests/view/test_curves.py",
    ("io.fclib.write", "force"): "in tests/bad_input",
}

PLAINLY_WRONG = {
    "GaussSeidel": lambda: lm.GaussSeidel(wire_blocks="yes"),
    "option of GaussSeidel": lambda: lm.GaussSeidel(tolerence=1e-3),
    "law without names": lambda: lm.Coulomb(0.3),
    "law of a list": lambda: lm.laws.get(["coulomb"]),
    "law of an object": lambda: lm.laws.register(object()),
    "pair of no function": lambda: lm.contact.register_pair("disk", "disk", 3),
}


def law_calls():
    """A row for each built-in law, with the bounds that its parameters declare."""
    given = {"friction": 0.3, "rolling_friction": 0.1, "restitution": 0.5, "stiffness": 1.0, "viscosity": 1.0}
    for registration in lm.laws.registrations().values():
        if registration.distribution != "lmgcpy":
            continue
        parameters = registration.law.parameters()
        kinds = {}
        for parameter in parameters.values():
            kind = POSITIVE if parameter.bounds["above"] == 0.0 else NOT_NEGATIVE
            kind = [*kind, 1.1] if parameter.bounds["maximum"] == 1.0 else kind
            kinds[parameter.name] = kind if parameter.default is not None else optional(kind)
        right = {key: value for key, value in given.items() if key in parameters}
        yield registration.law.__name__, (registration.law, right, kinds)


CASES = {**CALLS, **dict(law_calls())}


def refusal(call, arguments):
    try:
        call(**arguments)
    except Exception as error:
        return error
    return None


@pytest.mark.filterwarnings("ignore:In the step to")  # three particles are no sample
@pytest.mark.parametrize(
    "name", [name for name in CASES if not name.startswith(("io.", "resume", "view.show", "view.plot", "view.export"))]
)
def test_what_is_called_rightly_is_accepted(name, tmp_path, monkeypatch):
    """So that it is the wrong value that is refused; files are opened in other tests, windows in none."""
    monkeypatch.chdir(tmp_path)
    call, right, _ = CASES[name]
    assert refusal(call, right) is None


@pytest.mark.parametrize("name", CASES)
def test_every_wrong_value_gets_a_sentence_that_names_its_argument(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    call, right, kinds = CASES[name]
    for argument, wrong in kinds.items():
        words = CALLED.get(argument, [argument])
        for value in wrong:
            case = f"{name}({argument}={value!r})"
            error = refusal(call, {**right, argument: value})
            assert error is not None, f"{case} was accepted"
            told = f"{case} gave {type(error).__name__}: {error}"
            assert type(error) in (ValueError, TypeError, LookupError), told
            frame = traceback.extract_tb(error.__traceback__)[-1]
            assert Path(frame.filename).is_relative_to(ROOT), told
            assert str(error)[-1:] in (".", "?"), told
            assert any(word in str(error) for word in words), told
            assert len(str(error)) <= 400, told
            assert "at 0x" not in str(error), told
    assert not list(tmp_path.iterdir())


PLAIN = [name for name in CASES if inspect.isclass(CASES[name][0]) or inspect.isfunction(CASES[name][0])]
PLAIN = [name for name in PLAIN if CASES[name][2] and CASES[name][0].__module__.startswith("lmgcpy")]


@pytest.mark.parametrize("name", PLAIN)
def test_an_argument_that_there_is_not_is_named_with_the_closest(name):
    call, right, kinds = CASES[name]
    argument = list(kinds)[-1]
    with pytest.raises(TypeError, match=f"'{argument}x'; did you mean '") as caught:
        call(**{**right, f"{argument}x": 1.0})
    assert str(caught.value).endswith(".")


def public():
    """Public callables by name, from the front door and the modules behind it."""
    parts = (lm.sample, lm.measure, lm.io, lm.laws, lm.view)
    for module, prefix in ((lm, ""), *((part, part.__name__.removeprefix("lmgcpy.") + ".") for part in parts)):
        for name in module.__all__:
            if callable(getattr(module, name)):
                yield prefix + name, getattr(module, name)


def test_no_public_callable_is_left_out():
    names = {name for name, _ in public()}
    assert {name for name in names if name not in CASES and name not in EXEMPT} == set()
    assert set(EXEMPT) <= names, "exempt is what there is not"


@pytest.mark.parametrize("name", [name for name in CALLS if " " not in name and not name.startswith("Body.")])
def test_no_argument_is_left_out(name):
    names = {"Simulation": lm.Simulation, "Scene": lm.Scene, "Biaxial": Biaxial}
    owner, _, method = name.partition(".")
    call = CALLS[name][0]
    if owner in names:
        call = getattr(names[owner], method) if method else names[owner]
    elif name == "laws.register":
        call = lm.laws.register
    given = {p.name for p in inspect.signature(call).parameters.values() if p.kind is not p.VAR_KEYWORD}
    tried = {argument for other in CALLS if other.split(" ")[0] == name for argument in CALLS[other][2]}
    left = {argument for argument in given - tried - {"self"} if (name, argument) not in EXEMPT_ARGUMENTS}
    assert left == set()


@pytest.mark.parametrize("case", PLAINLY_WRONG)
def test_what_has_no_arguments_to_vary(case):
    with pytest.raises((ValueError, TypeError)) as caught:
        PLAINLY_WRONG[case]()
    assert str(caught.value).endswith(".")
    assert "at 0x" not in str(caught.value)
