"""A wire as one block whose law has two pieces of slope 0: slack links, and links at the most that they can bear."""

import numpy as np
import pytest

import lmgcpy as lm


class Saturating(lm.Law):
    """An elastic wire that pulls by no more than ``strength``."""

    NAME = "test-saturating"
    APPLIES_TO = "link"
    PREPARED = ("bias", "compliance", "hold")

    stiffness = lm.Parameter("N/m", above=0.0)
    strength = lm.Parameter("N", above=0.0)

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        stiffness, strength = parameters
        return ((gap - reference_gap) / time_step, 1.0 / (time_step * time_step * stiffness), time_step * strength)

    @staticmethod
    def react(W, u, prepared):
        bias, compliance, hold = prepared
        return (-min(max((u[0] + bias) / (W[0][0] + compliance), 0.0), hold),)

    @staticmethod
    def slope(W, u, prepared):
        bias, compliance, hold = prepared
        pull = (u[0] + bias) / (W[0][0] + compliance)
        return ((-1.0 / (W[0][0] + compliance) if 0.0 < pull < hold else 0.0,),)


def shaken(strength, *, wire_blocks):
    """A wire of 41 beads in zigzag whose heavy ends and middle are thrown apart, with the others shaken at random."""
    rng = np.random.default_rng(3)
    angles = rng.uniform(-1.0, 1.0, 40)
    places = np.vstack([[0.0, 0.0], np.cumsum(0.05 * np.stack([np.cos(angles), np.sin(angles)], axis=1), axis=0)])
    scene = lm.Scene(dimension=2)
    beads = []
    for i, place in enumerate(places):
        heavy = {0: (-2.0, 0.0), 20: (0.0, 2.0), 40: (2.0, 0.0)}.get(i)
        velocity = rng.normal(0.0, 0.5, 2) if heavy is None else heavy
        mass = 0.02 if heavy is None else 5.0
        beads.append(scene.add(lm.disk(radius=0.005, position=place, mass=mass, velocity=velocity)))
    scene.chain(beads, Saturating(stiffness=1e7, strength=strength))
    solver = lm.GaussSeidel(tolerance=1e-10, max_iterations=10_000, wire_blocks=wire_blocks)
    return lm.Simulation(scene, time_step=1e-3, solver=solver)


@pytest.mark.default_parameters("10.0")
@pytest.mark.parametrize("strength", [3.0, 10.0, 20.0, 30.0])
def test_a_link_that_goes_from_slack_to_full_has_changed_its_piece(strength):
    """Both pieces have slope 0. One visit of the block solves the step, to the forces of the links one by one.

    Both to 1e-10 of the error of doing nothing, forces to that times the condition of the wire, some 1e3.
    """
    block, single = (shaken(strength, wire_blocks=one) for one in (True, False))
    assert block.step().status == single.step().status == "converged"
    assert block.report.iterations == 1
    forces = -block.interactions.force[:, 0]
    assert (forces == 0.0).any()
    assert (forces == strength).any()
    assert ((forces > 0.0) & (forces < strength)).any()
    assert forces == pytest.approx(-single.interactions.force[:, 0], abs=1e-6 * strength)
