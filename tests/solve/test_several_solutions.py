"""A step that has several solutions: from the impulses of the step before, the one that stands is kept."""

import numpy as np
import pytest

import lmgcpy as lm

D, P, FRICTION = 0.01, 1e4, 0.4


def packing(part):
    """A hexagonal periodic packing at this part of Rowe's limit ``sqrt(3) tan(60 deg + phi)``, as a problem, and the
    uniform impulses in balance with the load (m, 2), whose T/N is below the friction."""
    n, rise, time_step = 6, np.sqrt(0.75), 2e-3
    scene = lm.Scene(dimension=2)
    for j in range(n):
        for i in range(n):
            scene.add(lm.disk(radius=D / 2, position=(D * (i + 0.5 * (j % 2)), D * rise * j), mass=1.0))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=FRICTION))
    cell = scene.periodic(x=n * D, y=n * D * rise)
    load = P * np.sqrt(3.0) * np.tan(np.pi / 3.0 + np.arctan(FRICTION)) * part
    cell.impose_stress(xx=-P, yy=-load)
    cell.fix("xy", "yx")
    sim = lm.Simulation(scene, time_step=time_step, solver=lm.Auto(tolerance=1e-9))
    sim.step()
    problem, normal = sim.problem(), np.asarray(sim.interactions.normal)
    volume = rise * D * D
    f_y = load * volume / D / (2.0 * np.sin(np.pi / 3.0))
    f_x = min(P * volume / D, f_y / np.tan(np.pi / 3.0))
    level = np.abs(normal[:, 0]) > 0.9
    tangent = np.column_stack([-normal[:, 1], normal[:, 0]])
    force = np.sign(normal) * (f_x, f_y)
    standing = np.column_stack([(force * normal).sum(axis=1), (force * tangent).sum(axis=1)])
    standing[level] = (P * volume / D - f_x, 0.0)
    return problem, time_step * standing


@pytest.mark.parametrize("part", [0.9, 0.99])
@pytest.mark.parametrize("tolerance", [1e-2, 1e-6, 1e-9])
@pytest.mark.parametrize("solver", [lm.GaussSeidel, lm.AcceleratedGaussSeidel, lm.Newton, lm.Auto])
def test_a_packing_that_stands_is_kept_standing(solver, tolerance, part):
    """From no impulses ``Auto`` finds a collapse at 1.7 a second at 0.99 of the limit, an exact solution as well."""
    problem, standing = packing(part)
    assert lm.residual(problem, standing) < 1e-12
    solution = lm.solve(problem, solver=solver(tolerance=tolerance), guess=standing)
    assert solution.status in ("converged", "round-off")
    moved = np.abs(solution.velocities).max()
    assert moved < 1e-10 * np.abs(problem.q).max() + 1e-14
