"""Solvers from elsewhere: what they hand out is measured by the laws, whatever they say themselves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

import lmgcpy as lm


@dataclass(frozen=True)
class Spoilt(lm.Solver):
    """Hands out the solution times a factor, with ``across`` [N s] added along the tangents."""

    factor: float = 1.0
    across: float = 0.0

    def solve(self, step):
        lm.GaussSeidel(tolerance=1e-12).solve(step)
        impulses = self.factor * step.system.impulse
        impulses[:, 1:] += self.across
        return self.finish(step, impulses, iterations=7, factorisations=2)


def tower(solver, *, friction=0.3):
    """Three disks, not quite one above the other."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    for i in range(3):
        scene.add(lm.disk(radius=0.01, position=(0.001 * (i % 2), 0.01 + 0.02 * i), mass=1.0))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=friction))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=friction))
    return lm.Simulation(scene, time_step=1e-3, solver=solver, on_unconverged="ignore")


def test_a_solution_is_told_as_one():
    report = tower(Spoilt()).step()
    assert (report.status, report.iterations, report.factorisations) == ("converged", 7, 2)
    assert report.residual <= 1e-12


def test_half_of_the_impulses_leave_half_of_the_error():
    """All contacts stay closed, so that e is linear between no impulse and the solution."""
    report = tower(Spoilt(factor=0.5)).step()
    assert report.status == "budget spent"
    assert report.residual == pytest.approx(0.5, rel=1e-9)  # but for the residual of 1e-12 of the solution


def test_what_is_no_number_stops_the_run():
    sim = tower(Spoilt(factor=np.nan))
    with pytest.raises(FloatingPointError, match="a number stopped being finite"):
        sim.step()
    assert sim.steps == 0


def test_components_that_a_law_does_not_have_are_left_out():
    """A frictionless contact measures no tangential error: an impulse there would move the bodies unseen."""
    spoilt, sound = tower(Spoilt(across=1e-3), friction=0.0), tower(Spoilt(), friction=0.0)
    assert spoilt.step().status == sound.step().status == "converged"
    assert np.array_equal(spoilt.velocities, sound.velocities)
    problem = sound.problem()
    assert np.array_equal(lm.solve(problem, solver=Spoilt(across=1e-3)).impulses[:, 1:], np.zeros((3, 1)))


def test_with_friction_they_are_measured():
    assert tower(Spoilt(across=1e-3)).step().status == "budget spent"


def test_what_is_no_solver_is_refused():
    class Old:
        tolerance, wire_blocks = 1e-4, True

        def solve(self, groups, system, free_velocity, guess, **operator):
            raise NotImplementedError

    with pytest.raises(TypeError, match=r"or one of your own, derived from lmgcpy\.Solver, got "):
        tower(Old())
