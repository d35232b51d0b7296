"""Frozen steps: problems of one step of a small run of sand or TexSol, with the last impulses as their guess.

Samples are made from fixed seeds. The runs that lead to a step are solved to 1e-3, so that the step is typical of a
simulation and does not depend on the solvers that are compared.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from lmgcpy.bench.case import Case
from lmgcpy.experiment.biaxial import Biaxial
from lmgcpy.experiment.box import Sample
from lmgcpy.experiment.compaction import compact
from lmgcpy.experiment.texsol.sample import lay_sample, lay_sample_3d
from lmgcpy.experiment.texsol.study import Study3D
from lmgcpy.experiment.triaxial import Triaxial
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
from lmgcpy.solve.sweeps.accelerated import AcceleratedGaussSeidel

DENSITY, PRESSURE = 2600.0, 1e5
"""Density of the grains [kg/m^3], and pressure on the lateral walls of a biaxial test [Pa]."""
RUN = AcceleratedGaussSeidel(tolerance=1e-3, max_iterations=3000)
"""Solver of the runs that lead to a step."""
STRAINS = (0.002, 0.02)
"""Axial strains at which steps of biaxial and triaxial tests are taken."""
WIRES = (RigidWire(), RigidRod(), ElasticWire(axial_rigidity=1e7))


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
        yield from steps_of_test(Triaxial, sample, law, replace(RUN, momentum=Study3D.MOMENTUM))


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
