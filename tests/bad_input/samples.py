"""Samples, measures and experiments."""

import math

import numpy as np

import lmgcpy as lm
from lmgcpy.experiment.biaxial import Biaxial
from lmgcpy.experiment.box import Sample
from lmgcpy.experiment.compaction import compact
from lmgcpy.experiment.texsol.sample import lay_sample, lay_sample_3d
from lmgcpy.experiment.texsol.study import Study2D, Study3D
from lmgcpy.experiment.triaxial import Triaxial
from lmgcpy.sample.deposit import settle

nan, inf = math.nan, math.inf


def grading(**more):
    return lm.sample.grading(**{"grain_count": 10, "minimum": 0.005, "maximum": 0.010, **more})


def deposit(**more):
    return lm.sample.deposit(**{"radii": [0.01, 0.01], "box": (0.3, None), **more})


def grid(**more):
    return lm.sample.grid_positions(**{"radii": [0.01, 0.01], "box": (0.3, None), **more})


def wire(**more):
    return lm.sample.wire_2d(**{"box": (0.67, 0.67), "bead_radius": 0.0075, "interstice": 0.021, "bead_count": 9, **more})


def settled(**more):
    return settle(**{"positions": [[0.1, 0.1]], "radii": [0.01], "box": (0.3, None), "obstacles": None, **more})


def density(**more):
    return lm.measure.density(**{"positions": [[0.0, 0.0]], "radii": [1.0], "window": ((0, 0), (1, 1)), **more})


def sample(**more):
    parts = {"positions": [[0.1, 0.1], [0.3, 0.1], [0.5, 0.1]], "radii": [0.05] * 3, "wires": (2,)}
    return Sample(**{**parts, "reference_gap": 0.1, "box": (0.6, 0.2), **more})


def in_space():
    places = np.column_stack([sample().positions, np.full(3, 0.1)])
    return sample(positions=places, box=(0.6, 0.2, 0.2))


# fmt: off
ROWS: dict[str, tuple] = {
    # --------------------------------------------------------------------------------------------------------- samples
    "no grains": (lambda w: grading(grain_count=0), ValueError, "grain_count must be at least 1, got 0"),
    "half a grain": (lambda w: grading(grain_count=2.5), TypeError, "grain_count must be a whole number, got 2.5"),
    "grading without minimum": (lambda w: grading(minimum=None), ValueError, "needs minimum and maximum"),
    "minimum zero": (lambda w: grading(minimum=0.0), ValueError, "minimum must be above 0 m, got 0 m"),
    "minimum above maximum": (lambda w: grading(minimum=0.02), ValueError,
        "minimum must not exceed maximum, got 0.02 m and 0.01 m"),
    "maximum in words": (lambda w: grading(maximum="wide"), TypeError, "maximum must be a number in m, got 'wide'"),
    "grading misspelt": (lambda w: grading(by="diametre"), ValueError,
        "by cannot be 'diametre'; did you mean 'diameter'?"),
    "grading by a number": (lambda w: grading(by=3), TypeError, "by must be one of 'diameter', 'mass', got 3"),
    "grading in four dimensions": (lambda w: grading(dimension=4), ValueError, "dimension must be at most 3, got 4"),
    "seed negative": (lambda w: grading(seed=-1), ValueError,
        "seed must be a whole number of at least 0, or None, got -1"),
    "seed in words": (lambda w: wire(seed="lucky"), TypeError,
        "seed must be a whole number of at least 0, or None, got 'lucky'"),
    "curve with minimum": (lambda w: grading(by=[[0.1, 0.0], [0.2, 1.0]]), ValueError, "leave minimum and maximum out"),
    "curve that turns back": (lambda w: grading(by=[[0.2, 0], [0.1, 1]], minimum=None, maximum=None), ValueError,
        "increase from row to row"),
    "curve in percent": (lambda w: grading(by=[[0.1, 0], [0.2, 100]], minimum=None, maximum=None), ValueError,
        "divided by 100"),
    "curve that falls": (
        lambda w: grading(by=[[0.1, 0], [0.2, 0.5], [0.3, 0.4], [0.4, 1]], minimum=None, maximum=None), ValueError,
        "must not decrease"),
    "curve of one row": (lambda w: grading(by=[0.1, 0.2], minimum=None, maximum=None), ValueError, "two or more rows"),
    "deposit of nothing": (lambda w: deposit(radii=[]), ValueError, "radii must hold at least 1 value, got 0"),
    "radius below zero in a deposit": (lambda w: deposit(radii=[0.01, -0.01]), ValueError,
        "radii must be above zero, but number 1 is -0.01 m"),
    "radius NaN in a deposit": (lambda w: deposit(radii=[0.01, nan]), ValueError,
        "radii must be finite, got [0.01, nan]"),
    "radii in a table": (lambda w: deposit(radii=[[0.01]]), ValueError, "radii must have shape (n,), got (1, 1)"),
    "radii of words": (lambda w: deposit(radii=["a"]), TypeError, "radii must be an array of numbers, got ['a']"),
    "box too narrow": (lambda w: deposit(box=(0.015, None)), ValueError,
        "too narrow for the coarsest grain", "0.015 m"),
    "box too low": (lambda w: deposit(box=(0.3, 0.015)), ValueError, "too narrow for the coarsest grain"),
    "box too wide": (lambda w: deposit(box=(1e12, None)), ValueError,
        "the box is too wide for the coarsest grain", "metres"),
    "box open aside": (lambda w: deposit(box=(None, 0.3)), ValueError, "only the last length, the height, may be None"),
    "box in space and time": (lambda w: deposit(box=(0.3, 0.3, 0.3, None)), ValueError,
        "box must have 2 or 3 lengths [m], got 4"),
    "box in words": (lambda w: deposit(box="wide"), TypeError, "box must be a tuple of 2 or 3 lengths [m], got 'wide'"),
    "box full": (lambda w: deposit(radii=[0.005] * 12, box=(0.1, 0.01)), ValueError,
        "10 of 12 grains fitted under its height of 0.01 m"),
    "method misspelt": (lambda w: deposit(method="geometrical"), ValueError,
        "method cannot be 'geometrical'; did you mean 'geometric'?"),
    "order misspelt": (lambda w: deposit(order="gven"), ValueError, "order cannot be 'gven'; did you mean 'given'?"),
    "obstacles no pair": (lambda w: deposit(obstacles=np.zeros((3, 2))), TypeError,
        "obstacles must be a pair (positions, radii)"),
    "obstacles short of radii": (lambda w: deposit(obstacles=(np.zeros((3, 2)), [1.0])), ValueError,
        "3 positions and 1 radii"),
    "obstacles in space": (lambda w: deposit(obstacles=(np.zeros((3, 3)), [1.0])), ValueError,
        "shape (n, 2), got (3, 3)"),
    "obstacle without size": (lambda w: deposit(obstacles=(np.zeros((1, 2)), [0.0])), ValueError,
        "the radii of the obstacles must be above zero"),
    "grid too tight": (lambda w: grid(spacing=0.9), ValueError, "spacing must be at least 1, got 0.9"),
    "grid full": (lambda w: grid(radii=[0.01] * 21, box=(0.1, 0.08), spacing=1.0), ValueError,
        "20 of 21 grains fitted"),
    "settled for ever": (lambda w: settled(max_steps=0), ValueError, "max_steps must be at least 1, got 0"),
    "settled too soon": (lambda w: settled(max_steps=1), RuntimeError,
        "The grains have not come to rest after 20 steps", "max_steps"),
    "settled above the top": (lambda w: settled(radii=[0.1], box=(0.3, 0.15)), ValueError,
        "rest up to 0.2", "above the top of the box at 0.15 m"),
    "settled with friction below zero": (lambda w: settled(friction=-1.0), ValueError,
        "friction of law 'coulomb' must be at least 0, got -1"),
    "wire in an open box": (lambda w: wire(box=(0.67, None)), ValueError,
        "the length of box along y is None: this box must be closed"),
    "wire in space": (lambda w: wire(box=(0.67, 0.67, 0.67)), ValueError, "box must have 2 lengths [m], got 3"),
    "wire in a number": (lambda w: wire(box=0.67), TypeError, "box must be a tuple of 2 lengths [m], got 0.67"),
    "wire in a box below zero": (lambda w: wire(box=(0.67, -1.0)), ValueError,
        "the length of box along y must be above 0 m, got -1 m"),
    "wire in a narrow box": (lambda w: wire(box=(0.01, 0.67)), ValueError, "too narrow for a bead"),
    "bead without size": (lambda w: wire(bead_radius=0.0), ValueError, "bead_radius must be above 0 m, got 0 m"),
    "interstice negative": (lambda w: wire(interstice=-0.1), ValueError, "interstice must be at least 0 m, got -0.1 m"),
    "no beads": (lambda w: wire(bead_count=0), ValueError, "bead_count must be at least 1, got 0"),
    "turns too sharp": (lambda w: wire(theta_max=4.0), ValueError, "theta_max must be at most 3.14159 rad, got 4 rad"),
    "clearance in words": (lambda w: wire(clearance="no"), TypeError, "clearance must be a number in m, got 'no'"),
    "box a number in an array": (lambda w: deposit(box=np.array(3.0)), TypeError,
        "box must be a tuple of 2 or 3 lengths [m], got array(3.)"),
    "start in the wall": (lambda w: wire(start=(0.0, 0.1)), ValueError,
        "start must leave the first bead, of radius 0.0075 m, inside the box, got (0.0, 0.1)"),
    "start a number": (lambda w: wire(start=0.1), ValueError, "start must be 2 numbers"),
    "argument of a wire misspelt": (lambda w: wire(bead_cout=3), TypeError,
        "wire_2d has no argument 'bead_cout'; did you mean 'bead_count'?"),
    # -------------------------------------------------------------------------------------------------------- measures
    "density in space": (lambda w: density(positions=[[0.0, 0.0, 0.0]]), ValueError,
        "density takes disks", "got (1, 3) and (1,)"),
    "density short of positions": (lambda w: density(radii=[1.0, 2.0]), ValueError, "radii (n,), got (1, 2) and (2,)"),
    "density of a radius below zero": (lambda w: density(radii=[-1.0]), ValueError,
        "radii must not be negative, but number 0 is -1 m"),
    "density of NaN": (lambda w: density(positions=[[0.0, nan]]), ValueError,
        "positions must be finite, got [[0.0, nan]]"),
    "density of words": (lambda w: density(positions=["a"]), TypeError,
        "positions must be an array of numbers, got ['a']"),
    "window without width": (lambda w: density(window=((0, 0), (0, 1))), ValueError,
        "lower left to its upper right corner, got ((0, 0), (0, 1))"),
    "window of two numbers": (lambda w: density(window=(0, 1)), ValueError,
        "window must be two corners ((x0, y0), (x1, y1)) [m], got (0, 1)"),
    "stress of a scene": (lambda w: lm.measure.stress(w.scene), TypeError,
        "stress takes a simulation", "got <Scene in 2D: 5 bodies"),
    "stress without a box": (lambda w: lm.measure.stress(w.sim), ValueError,
        "0 pairs of walls face each other", "Give volume= [m^2]"),
    "volume negative": (lambda w: lm.measure.stress(w.sim, volume=-1.0), ValueError,
        "volume must be above 0 m^2, got -1 m^2"),
    "stress of NaN": (lambda w: lm.measure.principal([[nan, 0], [0, 1]]), ValueError, "a stress tensor must be finite"),
    "stress not square": (lambda w: lm.measure.principal([1.0, 2.0]), ValueError,
        "A stress tensor must have shape (2, 2) or (3, 3), got (2,)"),
    # ----------------------------------------------------------------------------------------------------- experiments
    "study of a law unknown": (lambda w: Study2D(laws=("rigid-wir",)), ValueError,
        "no law 'rigid-wir'; did you mean 'rigid-wire'"),
    "study of no law": (lambda w: Study2D(laws=()), ValueError, "laws must name each law once, got none"),
    "study of a law twice": (lambda w: Study2D(laws=("none", "none")), ValueError,
        "laws must name each law once, got none, none"),
    "study of three grains": (lambda w: Study2D(grain_count=3), ValueError, "grains must be at least 10, got 3"),
    "study of beads below zero": (lambda w: Study2D(bead_count=-1), ValueError, "beads must be at least 0, got -1"),
    "study of one bead": (lambda w: Study2D(bead_count=1), ValueError, "beads must be at least 2 for a wire, got 1"),
    "study of no strain": (lambda w: Study2D(strain=0.0), ValueError, "strain must be above 0, got 0"),
    "study crushed to nothing": (lambda w: Study2D(strain=0.7), ValueError, "strain must be at most 0.5, got 0.7"),
    "study under suction": (lambda w: Study2D(pressure=-1.0), ValueError, "pressure must be above 0 Pa, got -1 Pa"),
    "study under NaN": (lambda w: Study2D(pressure=nan), ValueError, "pressure must be finite, got nan"),
    "study without tolerance": (lambda w: Study2D(tolerance=0.0), ValueError, "tolerance must be above 0, got 0"),
    "study of a wire that pushes": (lambda w: Study2D(axial_rigidity=-1.0), ValueError,
        "axial_rigidity must be above 0 N, got -1 N"),
    "study without threads": (lambda w: Study2D(threads=0), ValueError, "threads must be at least 1, got 0"),
    "study without iterations": (lambda w: Study2D(max_iterations=0), ValueError,
        "max_iterations must be at least 1, got 0"),
    "study of friction below zero": (lambda w: Study2D(friction=-0.4), ValueError,
        "friction must be at least 0, got -0.4"),
    "study too fast": (lambda w: Study2D(inertial_number=1.0), ValueError, "inertial_number must be at most 0.1, got 1"),
    "study prepared otherwise": (lambda w: Study2D(preparation="moist"), ValueError,
        "preparation cannot be 'moist'. Known: dense, loose."),
    "study solved otherwise": (lambda w: Study2D(solver="newton"), ValueError,
        "solver cannot be 'newton'. Known: accelerated, auto."),
    "study of a wire that turns beyond back": (lambda w: Study2D(theta_max=4.0), ValueError,
        "theta_max must be at most 3.14159 rad, got 4 rad"),
    "study under a press of no force": (lambda w: Study2D(greatest_reaction=0.0), ValueError,
        "greatest_reaction must be above 0, got 0"),
    "study misspelt": (lambda w: Study2D(grains=100), TypeError,
        "Study2D has no argument 'grains'; did you mean 'strain'?"),
    "sample of one bead": (lambda w: lay_sample(100, 1), ValueError,
        "beads must be 0 (sand alone) or at least 2: one bead is no wire"),
    "sample of a long wire": (lambda w: lay_sample(50, 5000), ValueError,
        "No place was found for a wire of 5000 beads among 50 grains"),
    "sample short of radii": (lambda w: sample(radii=[0.05]), ValueError, "3 positions and 1 radii"),
    "sample of more beads than particles": (lambda w: sample(wires=(9,)), ValueError,
        "beads of all wires of the sample must be at most 3, got 9"),
    "sample with a wire of one bead": (lambda w: sample(wires=(1,)), ValueError,
        "beads of one of the wires of the sample must be at least 2, got 1"),
    "sample without width": (lambda w: sample(box=(0.0, 0.2)), ValueError,
        "size of the box of the sample along x must be above 0 m, got 0 m"),
    "sample in a box of four sizes": (lambda w: sample(box=(1.0, 1.0, 1.0, 1.0)), ValueError,
        "box of the sample must be its 2 or 3 sizes [m]"),
    "sample on a plane in space": (lambda w: sample(box=(0.6, 0.2, 0.2)), ValueError, "shape (n, 3), got (3, 2)"),
    "compaction by suction": (lambda w: compact(sample(), pressure=-1e5, density=2600.0), ValueError,
        "pressure must be above 0 Pa, got -100000 Pa"),
    "compaction of nothing": (lambda w: compact("sand", pressure=1e5, density=2600.0), TypeError,
        "takes a Sample", "got 'sand'"),
    "compaction in honey of no drag": (lambda w: compact(sample(), pressure=1e5, density=2600.0, drag=-1.0), ValueError,
        "drag must be at least 0, got -1"),
    "biaxial test of nothing": (lambda w: Biaxial("sand"), TypeError, "A biaxial test is for a Sample", "got 'sand'"),
    "biaxial test in space": (lambda w: Biaxial(in_space()), ValueError,
        "A biaxial test takes a sample of dimension 2, this one is of dimension 3."),
    "triaxial test on a plane": (lambda w: Triaxial(sample()), ValueError,
        "A triaxial test takes a sample of dimension 3, this one is of dimension 2."),
    "triaxial test along no axis": (lambda w: Triaxial(in_space(), axis="w"), ValueError,
        "axis cannot be 'w'. Known: x, y, z."),
    "sample in 3D of a wire without room": (lambda w: lay_sample_3d(40, 5000), ValueError,
        "No place was found for 5000 beads of wire among 40 grains"),
    "sample in 3D of three wires of four beads": (lambda w: lay_sample_3d(40, 4, wires=3), ValueError,
        "beads must be 0 (sand alone) or at least 2 for each wire, got 4 for 3."),
    "study in 3D with rods": (lambda w: Study3D(laws=("rigid-rod",)), ValueError,
        "laws of the study in 3D cannot be 'rigid-rod'", "Take rigid-wire or elastic-wire."),
    "study in 3D along no axis": (lambda w: Study3D(axes=()), ValueError, "axes must name each axis once, got none"),
    "study in 3D along an axis that there is not": (lambda w: Study3D(axes=("w",)), ValueError,
        "The study has no axis 'w'. Known: x, y, z."),
    "study in 3D without wires": (lambda w: Study3D(wires=0), ValueError, "wires must be at least 1, got 0"),
    "biaxial test under a law's name": (lambda w: Biaxial(sample(), "rigid-wire"), TypeError,
        "law of the wire must be", "got 'rigid-wire'"),
    "biaxial test under a law of contacts": (lambda w: Biaxial(sample(), lm.Signorini()), TypeError,
        "Law 'signorini' is for a contact"),
    "biaxial test under suction": (lambda w: Biaxial(sample(), pressure=-1.0), ValueError,
        "pressure must be above 0 Pa, got -1 Pa"),
    "biaxial test with time turned back": (lambda w: Biaxial(sample(), time_step=-1.0), ValueError,
        "time_step must be above 0 s, got -1 s"),
    "biaxial test to no strain": (lambda w: Biaxial(sample()).run(0.0), ValueError, "strain must be above 0, got 0"),
    "biaxial test with half a frame": (lambda w: Biaxial(sample()).run(0.1, frames=0.5), TypeError,
        "frames must be a whole number, got 0.5"),
}
# fmt: on
