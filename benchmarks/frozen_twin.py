"""What the tension of a step is worth: steps of a light wire in sand beside their convex twins.

With the dilation ``mu |u_t|`` of each contact held at what a step left, the step is convex and has one answer, which
the conic solver Clarabel finds to 1e-10 (``pip install clarabel``). The samples are those of light_bodies.py, crushed to
8 % with heavy beads; then a test of each begins with lighter beads, and the fifth step of each from rest is looked at.

    python benchmarks/frozen_twin.py
"""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import scipy.sparse as sparse
from light_bodies import crushed
from table import report

import lmgcpy as lm
from lmgcpy.experiment import Triaxial

SCALE = 1e-6
"""Unit of the impulses in the conic problem [N s]."""
STEPS, SEEDS, BUDGET = 5, 3, 6000


def twin(step) -> tuple[np.ndarray, np.ndarray]:
    """Impulses (m, 3) and velocities of the bodies (n, 6) of a step whose dilations are held.

    ``min 1/2 |y|^2 + 1/2 r.C r + (q + mu s n).r`` with ``y = M^-1/2 H r`` and r in its cones.
    """
    import clarabel

    problem, acting = step.conic()
    H = step.interaction_matrix()
    velocity = (H @ step.system.velocity.ravel()).reshape(-1, 3)
    held = np.linalg.norm(velocity[acting, 1:], axis=1)
    root = (H[np.repeat(acting, 3)] @ sparse.diags_array(np.sqrt(step.inverse_mass.ravel()))).tocsc()
    root = root[:, np.flatnonzero(np.diff(root.indptr))]
    (rows, width), contact = root.shape, problem.cones == 0
    q = problem.q.copy()
    q[::3] += problem.mu * held * contact
    across = np.divide(1.0, problem.geometric, out=np.zeros(len(contact)), where=problem.geometric > 0.0)
    quadratic = sparse.block_diag(
        [sparse.diags_array(np.stack([problem.compliance, across, across], axis=1).ravel()), sparse.eye_array(width)]
    )
    pick, none = sparse.eye_array(rows, format="csr"), sparse.csr_array
    links, without = np.flatnonzero(~contact), np.flatnonzero(contact & (problem.mu == 0.0))
    rough = np.flatnonzero(contact & (problem.mu > 0.0))
    free = links[problem.geometric[links] <= 0.0]
    zero = np.concatenate([3 * free + 1, 3 * free + 2, 3 * without + 1, 3 * without + 2])
    cone = np.stack([problem.mu[rough], np.ones(len(rough)), np.ones(len(rough))], axis=1).ravel()
    of_rough = (3 * rough[:, None] + np.arange(3)).ravel()
    blocks = [
        (sparse.hstack([-root.T, sparse.eye_array(width)]), clarabel.ZeroConeT(width)),
        (sparse.hstack([pick[3 * links], none((len(links), width))]), clarabel.NonnegativeConeT(len(links))),
        (sparse.hstack([-pick[3 * without], none((len(without), width))]), clarabel.NonnegativeConeT(len(without))),
        (sparse.hstack([pick[zero], none((len(zero), width))]), clarabel.ZeroConeT(len(zero))),
        (sparse.hstack([-sparse.diags_array(cone) @ pick[of_rough], none((len(of_rough), width))]), None),
    ]
    cones = [kind for _, kind in blocks if kind is not None] + [clarabel.SecondOrderConeT(3)] * len(rough)
    conditions = sparse.csc_matrix(sparse.vstack([block for block, _ in blocks]))
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-10
    linear = np.concatenate([q / SCALE, np.zeros(width)])
    given = sparse.csc_matrix(quadratic), linear, conditions, np.zeros(conditions.shape[0]), cones, settings
    found = clarabel.DefaultSolver(*given).solve()
    assert str(found.status) == "Solved", found.status
    impulse = np.zeros((len(acting), 3))
    impulse[acting] = SCALE * np.array(found.x)[:rows].reshape(-1, 3)
    moved = (H.T @ impulse.ravel()).reshape(step.free_velocity.shape)
    return impulse, step.free_velocity + step.inverse_mass * moved


def main() -> None:
    """Print the table."""
    rows = []
    for seed in range(SEEDS):
        sample = crushed(seed)
        for part in (1.0, 1e-1, 1e-2, 1 / 400, 1e-5):
            solver = lm.AcceleratedGaussSeidel(tolerance=1e-2, max_iterations=BUDGET)
            lighter = replace(sample, bead_mass=part * sample.bead_mass)
            test = Triaxial(lighter, lm.RigidWire(), inertial_number=2e-3, solver=solver)
            options = {"time_step": test.time_step, "on_unconverged": "ignore", "overlap": "ignore"}
            sim = lm.Simulation(test.box.scene, solver=solver, **options).run(steps=STEPS)
            step, h = sim.last_step[0], sim.time_step
            impulse, velocity = twin(step)
            links, beads = sample.bead_count - 1, sample.bead_count
            here, there = (-r[:links, 0] / h for r in (step.system.impulse, impulse))
            way = h * np.linalg.norm((step.system.velocity - velocity)[: len(sample.radii), :3], axis=1) / sample.radii
            row = [f"{part:g}", seed, sim.report.iterations, f"{here.mean():.5f}", f"{there.mean():.5f}"]
            row += [f"{np.abs(here - there).max():.4f}", f"{there.max():.4f}"]
            rows.append([*row, f"{way[beads:].max():.1e}", f"{way[:beads].max():.1e}"])
    header = ["bead / grain", "seed", "sweeps", "tension [N]", "of the twin", "largest difference", "largest tension"]
    report("frozen_twin", [*header, "way of a grain [R]", "of a bead"], rows)


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    main()
