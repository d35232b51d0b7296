"""A step as a problem of its own: the assembled operator against the sweeps on bodies, and the two measures."""

import numpy as np
import pytest
import scipy.sparse as sparse

import lmgcpy as lm
from lmgcpy.compiled.kernel import INTERPRETED, statistics
from lmgcpy.solve.problems.locked import within_cones
from lmgcpy.solve.problems.residual import project_on_cone


def wired_pile(law=None, friction=0.4):
    """A small pile of disks on a floor between walls, pressed by gravity, with a wire of six beads through it."""
    rng = np.random.default_rng(3)
    scene = lm.Scene(dimension=2, gravity=(1.0, -9.81))
    bodies = []
    for j in range(5):
        for i in range(6):
            position = (0.021 * (i + 0.5 * (j % 2)) + 0.012, 0.0185 * j + 0.011)
            bodies.append(scene.add(lm.disk(radius=0.01 + 5e-4 * rng.random(), position=position, mass=1.0 + rng.random())))
    for point, normal in (((0, 0), (0, 1)), ((0, 0), (1, 0)), ((0.15, 0), (-1, 0))):
        scene.add(lm.wall(point=point, normal=normal))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=friction))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=friction))
    if law is not None:
        scene.chain(bodies[6:12], law)
    return lm.Simulation(
        scene,
        time_step=1e-3,
        solver=lm.GaussSeidel(tolerance=1e-11, max_iterations=100_000),
        on_unconverged="ignore",  # at 1e-11 round-off of W r may stand in the way
    )


@pytest.fixture(
    scope="module",
    params=[None, lm.RigidWire(), lm.RigidRod(), lm.ElasticWire(stiffness=1e6), lm.VoigtRod(stiffness=1e6, viscosity=10.0)],
    ids=lambda law: law.NAME if law else "none",
)
def solved(request):
    return wired_pile(request.param).run(steps=20)


def test_residual_of_the_assembled_problem_is_that_of_the_sweeps(solved):
    """Two codes: numpy on the assembled W against the kernels on the bodies; at 1e-11 round-off of W r is in the way."""
    problem = solved.problem()
    ours = lm.residual(problem, solved.interactions.impulse)
    assert ours == pytest.approx(solved.report.residual, rel=1e-2, abs=1e-13)
    assert lm.residual(problem, np.zeros_like(problem.guess)) == 1.0


def test_velocities_of_the_problem_are_those_of_the_bodies(solved):
    """u = W r + q holds the biases too: without them it is H^T v of the bodies' velocities after the step."""
    problem = solved.problem()
    net = solved.interactions
    relative = solved.velocities[net.candidate] - solved.velocities[net.antagonist]
    bias = problem.velocities(net.impulse)[:, 0] - np.einsum("md,md->m", relative, net.normal)
    contact = net.law == "coulomb"
    np.testing.assert_allclose(bias[contact], np.maximum(net.gap[contact], 0.0) / solved.time_step, atol=1e-12)


@pytest.mark.parametrize("solver", [lm.GaussSeidel, lm.AcceleratedGaussSeidel])
def test_solving_the_problem_anew_gives_the_same_velocities(solved, solver):
    """From no impulses at all; impulses of a hyperstatic pile are not unique, its velocities are."""
    problem = solved.problem()
    solution = lm.solve(problem, solver=solver(tolerance=1e-10, max_iterations=100_000), guess=np.zeros_like(problem.guess))
    assert solution.status == "converged"
    assert solution.residual == pytest.approx(lm.residual(problem, solution.impulses))
    assert solution.residual <= 1.1e-10
    scale = np.abs(problem.q).max()
    expected = problem.velocities(solved.interactions.impulse)
    np.testing.assert_allclose(solution.velocities, expected, atol=1e-7 * scale)


def test_operator_is_symmetric_and_as_wide_as_the_interactions(solved):
    W = solved.problem().W
    assert W.shape == (2 * len(solved.interactions),) * 2
    assert abs(W - W.T).max() < 1e-14 * W.diagonal().max()


def test_open_restitution_is_left_out():
    scene = lm.Scene(dimension=2)
    for x in (0.0, 0.25, 0.45):
        scene.add(lm.disk(radius=0.1, position=(x, 0.0), mass=1.0))
    scene.see("GRAIN", "GRAIN", lm.Restitution(restitution=0.5), alert=0.1)
    sim = lm.Simulation(scene, time_step=1e-3).run(steps=1)
    assert len(sim.interactions) == 2
    assert sim.problem().laws == ("restitution",)


def test_laws_without_conic_form_and_no_step_yet_are_told():
    scene = lm.Scene(dimension=2)
    ends = [scene.add(lm.disk(radius=0.1, position=(x, 0.0), mass=1.0)) for x in (0.0, 1.0)]
    scene.chain(ends, lm.VoigtWire(stiffness=1.0, viscosity=1.0))
    sim = lm.Simulation(scene, time_step=1e-3)
    with pytest.raises(RuntimeError, match="no step yet"):
        sim.problem()
    sim.step()
    with pytest.raises(TypeError, match="'voigt-wire' has no conic form"):
        sim.problem()


def one_contact(W, q, mu):
    return lm.Problem(
        sparse.csr_array(np.array(W, float)),
        np.array(q, float),
        np.array([mu]),
        2,
        ("coulomb",),
        np.zeros(1),
        np.zeros((1, 2)),
    )


def test_one_contact_by_hand():
    """W = diag(2, 1), q = (-4, 3), mu = 0.5: r_n = 2, sliding: r_t = -1, u = (0, 2)."""
    problem = one_contact([[2, 0], [0, 1]], [-4, 3], 0.5)
    solution = lm.solve(problem, solver=lm.GaussSeidel(tolerance=1e-14))
    np.testing.assert_allclose(solution.impulses, [[2, -1]], rtol=1e-14)
    np.testing.assert_allclose(solution.velocities, [[0, 2]], atol=1e-14)
    assert lm.residual(problem, solution.impulses) < 1e-15
    assert lm.residual(problem, solution.impulses, measure="fclib") < 1e-15
    # nothing done: the projection of w0 r - (q + mu |q_t| n) = (2.5, -3) on the cone is (3.2, 1.6) / 2 ...
    x = np.array([[2.5, -3.0]])
    along = np.array([1.0, -0.5]) / np.hypot(1.0, 0.5)
    expected = np.linalg.norm((x @ along) * along) / 5.0
    assert lm.residual(problem, [[0.0, 0.0]], measure="fclib") == pytest.approx(expected)


def test_projection_on_the_cone_is_the_nearest_point():
    """Against the nearest of many points of the cone's boundary and its apex; a projection leaves points inside alone."""
    rng = np.random.default_rng(0)
    x = rng.normal(size=(200, 2))
    mu = rng.uniform(0.0, 2.0, 200)
    projected = project_on_cone(x, mu)
    n = np.linspace(0.0, 5.0, 20001)
    for point, friction, found in zip(x, mu, projected, strict=True):
        inside = abs(point[1]) <= friction * point[0]
        edges = np.concatenate([np.stack([n, friction * n], 1), np.stack([n, -friction * n], 1)])
        distance = 0.0 if inside else np.linalg.norm(edges - point, axis=1).min()
        assert np.linalg.norm(found - point) == pytest.approx(distance, abs=1e-6)


def test_no_interaction_is_solved():
    nothing = lm.Problem(sparse.csr_array((0, 0)), np.zeros(0), np.zeros(0), 2, (), np.zeros(0), np.zeros((0, 2)))
    solution = lm.solve(nothing)
    assert (solution.status, solution.residual) == ("converged", 0.0)


def star_of_wires():
    """Three wires meet at one bead, pulled apart: every one of them meets both others, so that they are no chain."""
    directions = np.array([[0.0, 1.0], [np.sqrt(0.75), -0.5], [-np.sqrt(0.75), -0.5]])
    H = np.zeros((6, 8))
    for i, n in enumerate(directions):  # the bead is the last body
        H[2 * i, 2 * i : 2 * i + 2], H[2 * i, 6:] = n, -n
    speeds = np.array([0.0, 1.0, 0.5, 0.0, -0.2, -0.4, 0.3, 0.1])
    mass = np.repeat([1.0, 3.0, 0.2, 0.5], 2)
    W = sparse.csr_array((H / mass) @ H.T)
    return lm.Problem(W, H @ speeds, np.zeros(3), 2, ("rigid-wire",) * 3, np.zeros(3), np.zeros((3, 2)))


@pytest.mark.parametrize("solver", [lm.GaussSeidel(tolerance=1e-12), lm.Newton(tolerance=1e-12)], ids=["sweeps", "newton"])
def test_wires_that_meet_at_one_bead(solver):
    """As if they were one chain, sweeps would leave their coupling out and diverge. All three are taut: u = 0."""
    problem = star_of_wires()
    solution = lm.solve(problem, solver=solver)
    assert solution.status == "converged"
    expected = -np.linalg.solve(problem.W.toarray()[::2, ::2], problem.q[::2])
    taut = expected < 0.0
    assert taut.sum() >= 2
    if taut.all():
        np.testing.assert_allclose(solution.impulses[:, 0], expected, rtol=1e-10)
    assert (solution.impulses[:, 0] <= 0.0).all()
    assert lm.residual(problem, solution.impulses) <= 1e-12


def test_friction_in_the_guess_of_a_smooth_contact_is_left_out():
    """The tangential impulse of a frictionless contact is no unknown: kept, it would move what nothing measures."""
    W = sparse.csr_array(np.array([[2.0, 0.3], [0.3, 3.0]]))
    problem = lm.Problem(W, np.array([-1.0, 0.4]), np.zeros(1), 2, ("coulomb",), np.zeros(1), np.zeros((1, 2)))
    solution = lm.solve(problem, guess=np.array([[0.2, 5.0]]))
    np.testing.assert_allclose(solution.impulses, [[0.5, 0.0]], rtol=1e-12)
    assert lm.residual(problem, solution.impulses) <= 1e-12


def test_a_problem_that_rolls_says_how_many_components_it_has():
    """And refuses what does not fit, naming the reason."""
    parts = {"laws": ("rolling-coulomb",), "dimension": 3, "compliance": [0.0], "mu": [0.3], "rolling": [0.1]}
    W = sparse.csr_array(np.eye(6))
    rolls = lm.Problem(W=W, q=-np.ones(6), guess=np.zeros((1, 6)), **parts)
    assert rolls.width == 6
    assert rolls.torsion == [0.0]
    assert rolls.rows.tolist() == [[True] * 5 + [False]]
    with pytest.raises(
        ValueError, match=r"guess .* shape \(1, 6\), as rolling gives each of them 6 components, got \(1, 3\)"
    ):
        lm.Problem(W=W, q=-np.ones(6), guess=np.zeros((1, 3)), **parts)
    with pytest.raises(ValueError, match="torsion of a problem goes with rolling"):
        lm.Problem(W=W, q=-np.ones(6), guess=np.zeros((1, 6)), torsion=[0.1], **{**parts, "rolling": np.zeros(0)})
    with pytest.raises(
        ValueError, match=r"rolling of a problem must be 0 for a link, got 0.1 for interaction 0 \('rigid-rod'\)"
    ):
        lm.Problem(W=W, q=-np.ones(6), guess=np.zeros((1, 6)), **{**parts, "laws": ("rigid-rod",)})


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_cone_of_what_rolls_is_projected_on(dimension):
    """As in ``test_locked``: p is in the cone, x - p in its polar cone, and both are orthogonal."""
    rng = np.random.default_rng(0)
    count, width = 200, 3 if dimension == 2 else 6
    problem = lm.Problem(
        W=sparse.eye_array(count * width).tocsr(),
        q=np.zeros(count * width),
        mu=rng.uniform(0.1, 2.0, count),
        dimension=dimension,
        laws=("rolling-coulomb",) * count,
        compliance=np.zeros(count),
        guess=np.zeros((count, width)),
        rolling=rng.uniform(0.0, 1.0, count),
        torsion=rng.uniform(0.0, 1.0, count),
    )
    x = rng.normal(size=(count, width)) * 10.0 ** rng.uniform(-1, 1, (count, width))
    p = within_cones(problem, x)
    left, polar = x - p, (x - p)[:, 0].copy()
    for part, share in problem.disks:
        assert (np.linalg.norm(p[:, part], axis=1) <= share * p[:, 0] * (1 + 1e-14)).all()
        polar += share * np.linalg.norm(left[:, part], axis=1)
    assert (polar <= 1e-12).all()
    np.testing.assert_allclose((left * p).sum(axis=1), 0.0, atol=1e-11)
    assert (p[:, 0] > 0.0).any()
    assert (p[:, 0] == 0.0).any()


@pytest.mark.default_parameters("True-2")
@pytest.mark.skipif(INTERPRETED, reason="plain Python has no machine code to load")
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("rolls", [False, True])
def test_further_solves_load_no_machine_code(dimension, rolls):
    """It was loaded at every call of ``lm.solve``, which took 18 ms and 2 MB each time."""
    law = lm.RollingCoulomb(friction=0.3, rolling_friction=0.1) if rolls else lm.Coulomb(friction=0.3)
    scene = lm.Scene(dimension=dimension, gravity=(*(0.0,) * (dimension - 1), -9.81))
    body = lm.disk if dimension == 2 else lm.sphere
    scene.add(body(radius=0.1, position=(*(0.0,) * (dimension - 1), 0.1), mass=1.0))
    scene.add(lm.wall(point=(0,) * dimension, normal=(*(0,) * (dimension - 1), 1)))
    scene.see("GRAIN", "WALL", law)
    sim = lm.Simulation(scene, time_step=1e-3)
    sim.step()
    lm.solve(sim.problem())
    before = statistics()
    for _ in range(3):
        lm.solve(sim.problem())
    assert statistics() == before
