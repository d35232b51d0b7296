"""Cases of the benchmark: problems with a name and a family, from a folder, of chains on one line, and of frozen steps.

A chain of rigid wires hangs from a fixed point along the first axis. Its masses m_1 ... m_n lie below the point; the last
one is the tip. It has a tridiagonal problem, with a solution in extended precision. With n from the antagonist above to the
candidate below, link i has

    W_ii = 1/m_{i-1} + 1/m_i,    W_{i,i+1} = -1/m_i,    1/m_0 = 0,    q_i = v_i - v_{i-1},

and ``0 <= -(W r + q) _|_ -r >= 0``. W is an M-matrix. So Newton's method on the set of taut links converges monotonically,
in at most as many steps as there are links (Chandrasekaran 1970, Opsearch 7); each step is a tridiagonal elimination. Here
it uses numpy's ``longdouble``, which has a mantissa of 64 bits on x86 and of more bits on some other processors. The
elimination shares no code with the solvers that it judges.

A frozen step is the problem of one step of a small run of sand or TexSol, with the last impulses as its guess. Samples are
made from fixed seeds. The runs that lead to a step are solved to 1e-3, so that the step is typical of a simulation and does
not depend on the solvers that are compared.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import scipy.sparse as sparse

from lmgcpy.experiment.biaxial import Biaxial
from lmgcpy.experiment.box import MOMENTUM, Sample
from lmgcpy.experiment.compaction import compact
from lmgcpy.experiment.texsol.sample import lay_sample, lay_sample_3d
from lmgcpy.experiment.texsol.study import Study3D
from lmgcpy.experiment.triaxial import Triaxial
from lmgcpy.io import fclib
from lmgcpy.laws import Law
from lmgcpy.laws.coulomb import Coulomb
from lmgcpy.laws.elastic import ElasticWire
from lmgcpy.laws.rigid import RigidRod, RigidWire
from lmgcpy.sample import deposit, grading, wire_3d
from lmgcpy.scene.body import wall
from lmgcpy.scene.body_3d import sphere
from lmgcpy.scene.scene import Scene
from lmgcpy.scene.solid import Material
from lmgcpy.simulation import Simulation
from lmgcpy.solve.problems.problem import Problem
from lmgcpy.solve.sweeps.accelerated import AcceleratedGaussSeidel

BEADS = (10, 100, 1000, 10_000)
TIPS = (1.0, 1e3, 1e6)
"""Mass of the tip, in masses of a bead."""
BEAD_MASS, FALL = 1e-3, 9.81e-3
"""Mass of a bead [kg], and velocity that gravity adds to a free bead in a step of one millisecond [m/s]."""

DENSITY, PRESSURE = 2600.0, 1e5
"""Density of the grains [kg/m^3], and pressure on the lateral walls of a biaxial test [Pa]."""
RUN = AcceleratedGaussSeidel(tolerance=1e-3, max_iterations=3000)
"""Solver of the runs that lead to a step."""
STRAINS = (0.002, 0.02)
"""Axial strains at which steps of biaxial and triaxial tests are taken."""
WIRES = (RigidWire(), RigidRod(), ElasticWire(axial_rigidity=1e7))


@dataclass(frozen=True)
class Case:
    """A problem that every solver is to solve."""

    name: str
    family: str
    problem: Problem
    exact: np.ndarray | None = None
    """Impulses (m, d) [N s] in extended precision; None if they are not known."""

    @property
    def interactions(self) -> int:
        return len(self.problem.mu)


def from_folder(folder: Path) -> Iterator[Case]:
    """The FCLIB problems of a folder and its subfolders in alphabetic order; the name of the folder is the family.

    Raises FileNotFoundError if the folder is missing or has no problem, and the errors of ``lmgcpy.io.fclib.read``.
    """
    if not folder.is_dir():
        raise FileNotFoundError(f"There is no folder '{folder}' with problems to solve.")
    files = sorted(path for kind in ("*.h5", "*.hdf5") for path in folder.rglob(kind))
    if not files:
        raise FileNotFoundError(f"There is no problem in the folder '{folder}': no file ends in .h5 or .hdf5.")
    for file in files:
        yield Case(file.stem, file.parent.resolve().name, fclib.read(file))


def chain_problem(mass: np.ndarray, velocity: np.ndarray) -> Problem:
    """A chain of rigid wires below a fixed point, in 2D: ``mass`` [kg] and free ``velocity`` downwards [m/s], (n,) each."""
    count = len(mass)
    inverse = 1.0 / mass
    W_n = sparse.diags_array(
        [inverse + np.r_[0.0, inverse[:-1]], -inverse[:-1], -inverse[:-1]], offsets=[0, 1, -1], shape=(count, count)
    )
    # no bead turns, so that the tangential rows have the same masses
    W = sparse.csr_array(sparse.kron(W_n, sparse.eye_array(2)))
    q = np.zeros((count, 2))
    q[:, 0] = np.diff(velocity, prepend=0.0)
    laws = (RigidWire.NAME,) * count
    return Problem(W, q.ravel(), np.zeros(count), 2, laws, np.zeros(count), np.zeros((count, 2)))


def extended_solution(problem: Problem) -> np.ndarray:
    """Impulses (m, 2) of a chain of rigid wires, rounded from extended precision.

    Raises RuntimeError if the impulses do not satisfy the law; the check is in extended precision too.
    """
    W = problem.W.tocsr()
    count = len(problem.mu)
    row = 2 * np.arange(count)
    diagonal = np.asarray(W[row, row], dtype=np.longdouble)
    beside = np.asarray(W[row[:-1], row[1:]], dtype=np.longdouble)
    q = problem.q[::2].astype(np.longdouble)
    taut = q >= 0.0  # a hanging chain, in which only the first link has a free velocity, needs one step
    for _ in range(count + 2):
        r = _tridiagonal(np.where(taut, diagonal, 1), np.where(taut[:-1] & taut[1:], beside, 0), np.where(taut, -q, 0))
        u = diagonal * r + q
        u[:-1] += beside * r[1:]
        u[1:] += beside * r[:-1]
        small = 1e3 * np.finfo(np.longdouble).eps * np.abs(diagonal * r).max(initial=np.abs(q).max())  # round-off
        wrong = np.where(taut, diagonal * r > small, u > small)
        if not wrong.any():
            if (np.abs(u[taut]) > small).any():
                break
            return np.column_stack([r, np.zeros(count)]).astype(np.float64)
        taut = taut ^ wrong
    raise RuntimeError("The chain's solution in extended precision does not satisfy its law.")


def _tridiagonal(diagonal: np.ndarray, beside: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solution of a symmetric tridiagonal system by elimination without pivoting."""
    d, x = diagonal.copy(), right.copy()
    for i in range(1, len(d)):
        factor = beside[i - 1] / d[i - 1]
        d[i] -= factor * beside[i - 1]
        x[i] -= factor * x[i - 1]
    x[-1] /= d[-1]
    for i in range(len(d) - 2, -1, -1):
        x[i] = (x[i] - beside[i] * x[i + 1]) / d[i]
    return x


def chains(beads: tuple[int, ...] = BEADS, tips: tuple[float, ...] = TIPS) -> Iterator[Case]:
    """Hanging chains with taut links, for every number of beads and every mass of the tip, and loose chains.

    The beads of a loose chain fly towards each other with random velocities, so that many links are slack.
    """
    for count in beads:
        for tip in tips:
            mass = np.full(count, BEAD_MASS)
            mass[-1] *= tip
            problem = chain_problem(mass, np.full(count, FALL))
            yield Case(f"hanging-{count}-tip-{tip:g}", "chains", problem, extended_solution(problem))
        rng = np.random.default_rng(count)
        problem = chain_problem(np.full(count, BEAD_MASS), np.cumsum(rng.normal(-0.5, 1.0, count)))
        yield Case(f"loose-{count}", "chains", problem, extended_solution(problem))


def in_the_plane(grains: int = 340, beads: int = 60, seed: int = 0) -> Iterator[Case]:
    """Steps of biaxial tests on one compacted sample, as sand and as TexSol with each law of the wire."""
    sample = compact(lay_sample(grains, beads, seed=seed), pressure=PRESSURE, density=DENSITY).sample
    for law in (None, *WIRES):
        yield from steps_of_test(Biaxial, sample, law, RUN)


def in_space(grains: int = 200, beads: int = 110, seed: int = 0) -> Iterator[Case]:
    """Early and later steps of a box of spheres under gravity, without and with a wire, and steps of triaxial tests.

    The triaxial tests have one compacted sample, as sand and as TexSol with a rigid or an elastic wire.
    """
    for wire in (False, True):
        sim = box_of_spheres(grains, beads if wire else 0, seed=seed)
        for steps in (2, 60):
            sim.run(steps=steps - sim.steps)
            yield Case(f"box-{'texsol' if wire else 'sand'}-step-{steps}", "box 3D", sim.problem())
    laid = lay_sample_3d(grains, beads, density=DENSITY, seed=seed)
    sample = compact(laid, pressure=PRESSURE, density=DENSITY, **Study3D(pressure=PRESSURE).relaxation(laid)).sample
    for law in (None, RigidWire(), ElasticWire(axial_rigidity=Study3D().axial_rigidity)):
        yield from steps_of_test(Triaxial, sample, law, replace(RUN, momentum=MOMENTUM[3]))


def steps_of_test(
    test: type[Biaxial] | type[Triaxial], sample: Sample, law: Law | None, solver: AcceleratedGaussSeidel
) -> Iterator[Case]:
    """The last steps of tests that reach the :data:`STRAINS`."""
    name = "sand" if law is None else law.NAME
    for strain in STRAINS:
        made = test(sample, law, pressure=PRESSURE, density=DENSITY, solver=solver)
        made.run(strain, frames=0)
        assert made.simulation is not None
        kind = test.__name__.lower()
        yield Case(f"{kind}-{name}-{100 * strain:g}%", f"{kind} {test.DIMENSION}D", made.simulation.problem())


def packings(sizes: tuple[int, ...] = (1000, 3000)) -> Iterator[Case]:
    """Deposits of spheres after ten steps under gravity."""
    for count in sizes:
        yield Case(f"packing-{count}", "packings", box_of_spheres(count, 0, seed=1).run(steps=10).problem())


def box_of_spheres(grains: int, beads: int, *, seed: int) -> Simulation:
    """Grains of 8 to 10 mm deposited in an open box about as high as wide, around a wire of ``beads`` beads of 1.6 mm."""
    side = 0.01 * max(3.0, round(grains ** (1.0 / 3.0)))
    radii = grading(grains, minimum=0.004, maximum=0.005, by="diameter", seed=seed)
    obstacles = None
    if beads:
        thread = wire_3d(
            box=(side, side, 0.8 * side),
            bead_radius=8e-4,
            interstice=4e-4,
            bead_count=beads,
            theta_max=0.4,
            phi_max=0.15,
            seed=0,
        )
        obstacles = (thread.positions, thread.radii)
    positions = deposit(radii, box=(side, side, None), obstacles=obstacles, seed=seed)
    scene = Scene(dimension=3, gravity=(0.5, 0.3, -9.81))
    sand = Material("sand", density=DENSITY)
    for radius, position in zip(radii, positions, strict=True):
        scene.add(sphere(radius=radius, position=position, material=sand))
    if obstacles is not None:
        line = [
            scene.add(sphere(radius=radius, position=position, mass=2e-6, color="BEAD"))
            for position, radius in zip(*obstacles, strict=True)
        ]
        scene.chain(line, RigidWire(), reference_gap=5e-4)
    for axis in range(3):
        for end in (0.0, side) if axis < 2 else (0.0,):
            point, normal = np.zeros(3), np.zeros(3)
            point[axis], normal[axis] = end, 1.0 if end == 0.0 else -1.0
            scene.add(wall(point=point, normal=normal))
    pairs = [("GRAIN", "GRAIN"), ("GRAIN", "WALL")]
    if beads:
        pairs += [("GRAIN", "BEAD"), ("BEAD", "WALL"), ("BEAD", "BEAD")]
    for one, other in pairs:
        scene.see(one, other, Coulomb(friction=0.4))
    return Simulation(scene, time_step=2e-4, solver=RUN, on_unconverged="ignore", overlap="ignore")
