"""Newton steps on active sets, and the solvers that alternate them with sweeps."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.sparse as sparse
from scipy.sparse.linalg import splu

import lmgcpy as lm
from lmgcpy.solve.newton.active_set import ActiveSet, Elimination
from lmgcpy.solve.newton.alternating import DISTURBANCE, GRACE, LONGER, TRIAL, WORK, Progress, newton_steps
from lmgcpy.solve.newton.proximal import PATIENCE, Attempt, proximal_newton
from lmgcpy.solve.newton.rows import LINK, OPEN, SLIDE, STICK
from lmgcpy.solve.problems.report import CONVERGED, SPENT

TIGHT = 1e-10
"""Residual to which problems of some hundred unknowns can be solved in double precision, with a margin."""


def pressed(law=None, friction=0.4, seed=0):
    """A step of a 2D sample: a wire of twelve beads among disks squeezed between four walls."""
    rng = np.random.default_rng(seed)
    scene = lm.Scene(dimension=2, gravity=(0.3, -9.81))
    disks = [
        scene.add(
            lm.disk(
                radius=0.01,
                position=(0.02 * (i + 0.5 * (j % 2)) + 0.01, 0.01 * 3**0.5 * j + 0.01),
                mass=1.0,
                velocity=rng.normal(0.0, 1.0, 2),
            )
        )
        for j in range(10)
        for i in range(12)
    ]
    for point, normal in (((0, 0), (0, 1)), ((0, 0), (1, 0)), ((0.25, 0), (-1, 0))):
        scene.add(lm.wall(point=point, normal=normal))
    lid = scene.add(lm.wall(point=(0, 0.09 * 3**0.5 + 0.02), normal=(0, -1), mass=200.0))
    lid.impose_force(y=-4e4)
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=friction))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.5 * friction))
    if law is not None:
        scene.chain(disks[48:60], law)
    sim = lm.Simulation(scene, time_step=1e-4, on_unconverged="ignore")
    return sim.run(steps=1).problem()


def heap_of_spheres(friction=0.4, seed=0):
    """A step of spheres in a box of walls under gravity that leans."""
    rng = np.random.default_rng(seed)
    scene = lm.Scene(dimension=3, gravity=(2.0, 1.0, -9.81))
    for k in range(4):
        for j in range(4):
            for i in range(4):
                shift = 0.5 * (k % 2)
                position = (0.02 * (i + shift) + 0.01, 0.02 * (j + shift) + 0.01, 0.01 * 2**0.5 * k + 0.01)
                velocity = rng.normal(0.0, 0.3, 3)
                scene.add(lm.sphere(radius=0.01, position=position, mass=1.0, velocity=velocity))
    for point, normal in (
        ((0, 0, 0), (0, 0, 1)),
        ((0, 0, 0), (1, 0, 0)),
        ((0.09, 0, 0), (-1, 0, 0)),
        ((0, 0, 0), (0, 1, 0)),
        ((0, 0.09, 0), (0, -1, 0)),
    ):
        scene.add(lm.wall(point=point, normal=normal))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=friction))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=friction))
    return lm.Simulation(scene, time_step=1e-3, on_unconverged="ignore").run(steps=1).problem()


LAWS = [None, lm.RigidWire(), lm.RigidRod(), lm.ElasticWire(stiffness=1e7), lm.VoigtRod(stiffness=1e6, viscosity=10.0)]


@pytest.fixture(scope="module", params=LAWS, ids=lambda law: law.NAME if law else "sand")
def sample(request):
    return pressed(request.param)


@pytest.fixture(scope="module")
def spheres():
    return heap_of_spheres()


def swept(problem, sweeps):
    return lm.solve(problem, solver=lm.AcceleratedGaussSeidel(tolerance=1e-15, max_iterations=sweeps)).impulses


@pytest.mark.long
def test_error_is_the_natural_one(sample, spheres):
    """Two codes of one formula: ActiveSet.error and lm.residual."""
    for problem in (sample, spheres):
        active = ActiveSet(problem)
        for sweeps in (1, 20):
            r = swept(problem, sweeps)
            assert active.residual(r) == pytest.approx(lm.residual(problem, r), rel=1e-12)


def test_step_satisfies_what_its_statuses_say(sample, spheres):
    """Velocities and impulses after one Newton step, interaction by interaction, against the lines of the module's text."""
    for problem in (sample, spheres):
        active = ActiveSet(problem)
        centre = swept(problem, 15)
        epsilon = 1e-2
        _, status = active.error(centre, epsilon, centre)
        assert {OPEN, STICK, SLIDE} <= set(status.kind)
        r = active.newton(status, epsilon, centre)
        u = active.velocities(r, epsilon, centre)
        scale = 1e-9 * np.abs(u).max()  # what the factorisation leaves, far above round-off
        w, kind, tau = active.weight, status.kind, status.direction
        assert not r[kind == OPEN].any()
        pushed = np.isin(kind, (STICK, SLIDE))
        assert np.abs(u[pushed, 0]).max() < scale
        stuck = (kind == STICK) & (problem.mu > 0.0)
        assert np.abs(u[stuck, 1:]).max() < scale
        link = kind == LINK
        assert np.abs(u[link, 0] + problem.compliance[link] * r[link, 0]).max(initial=0.0) < scale
        slides = kind == SLIDE
        along = np.einsum("it,it->i", r[:, 1:], tau)
        np.testing.assert_allclose(along[slides], (problem.mu * r[:, 0])[slides], rtol=1e-9, atol=1e-12)
        if problem.dimension == 3:
            sigma = np.column_stack([-tau[:, 1], tau[:, 0]])
            across = np.einsum("it,it->i", r[:, 1:], sigma)
            turned = np.einsum("it,it->i", u[:, 1:], sigma) + w * status.turning[:, 0] * across
            assert np.abs(turned[slides]).max() < scale


def test_order_of_elimination_changes_round_off_alone(sample, spheres):
    """A step with the order found for an earlier one, of other statuses, against the same with an order of its own."""
    for problem in (sample, spheres):
        kept, epsilon = ActiveSet(problem), 1e-2
        for sweeps in (5, 15, 40):
            centre = swept(problem, sweeps)
            _, status = kept.error(centre, epsilon, centre)
            r = kept.newton(status, epsilon, centre)
            alone = ActiveSet(problem).newton(status, epsilon, centre)
            np.testing.assert_allclose(r, alone, atol=1e-9 * np.abs(alone).max())  # see the test above


def test_order_is_found_anew_for_other_interactions():
    """Two orders of a line of neighbours in which every third is at first missing; both leave no fill."""
    elimination = Elimination(30)
    for acting in (np.flatnonzero(np.arange(30) % 3), np.arange(30)):
        order, known = elimination.order(acting)
        assert not known
        line = sparse.diags_array([-1.0, 2.1, -1.0], offsets=[-1, 0, 1], shape=(30, 30)).tocsr()
        matrix = sparse.csc_array(line[order][:, order])
        place = np.zeros(30, dtype=int)
        place[order] = np.arange(len(order))
        elimination.factorise(matrix, order, place, known)
        again, known = elimination.order(acting)
        assert known
        np.testing.assert_array_equal(np.sort(again), acting)
        factors = splu(sparse.csc_array(line[again][:, again]), permc_spec="NATURAL", diag_pivot_thresh=0.0)
        assert factors.nnz == matrix.nnz + len(acting)  # the diagonal is in both factors


def test_step_is_newtons(spheres):
    """``e'(r) d = -e(r)`` for the Newton step d, with the derivative by finite differences, turning of directions included.

    Interactions that change their status within the difference are left out; there is at most one.
    """
    active = ActiveSet(spheres)
    epsilon, t = 0.1, 1e-6
    r = swept(spheres, 6)
    error, status = active.error(r, epsilon, r)
    d = active.newton(status, epsilon, r) - r
    ahead, there = active.error(r + t * d, epsilon, r)
    same = status.kind == there.kind
    assert np.count_nonzero(~same) <= 1
    derivative = (ahead - error)[same] / t
    scale = np.linalg.norm(error)
    assert scale > 1e-3 * active.nothing
    assert np.linalg.norm(derivative + error[same]) < 1e-3 * scale  # curvature of the directions, times t; round-off / t


def test_sample_to_the_last_digits(sample):
    solution = lm.solve(sample, solver=lm.Newton(tolerance=TIGHT))
    assert solution.status == "converged"
    assert lm.residual(sample, solution.impulses) <= TIGHT


def test_spheres_to_the_last_digits(spheres):
    solution = lm.solve(spheres, solver=lm.Newton(tolerance=TIGHT))
    assert solution.status == "converged"
    assert lm.residual(spheres, solution.impulses) <= TIGHT


def test_newton_and_sweeps_agree_in_velocity():
    """Without friction a step is a convex problem: impulses may not be unique, velocities are. Two solvers, one answer."""
    problem = pressed(lm.RigidWire(), friction=0.0)
    newton = lm.solve(problem, solver=lm.Newton(tolerance=1e-11))
    sweeps = lm.solve(problem, solver=lm.AcceleratedGaussSeidel(tolerance=1e-9, max_iterations=100_000))
    assert newton.factorisations > 0
    assert sweeps.status == "converged"
    error = np.linalg.norm(newton.velocities - sweeps.velocities) / np.linalg.norm(problem.q)
    assert error < 1e-6  # a residual of 1e-9, times what the sample's slowest mode makes of it


def hyperstatic():
    """W of rank one under four contacts: a block on four feet, q pressing it down."""
    count, d = 4, 2
    H = np.zeros((count * d, 3))
    for i, x in enumerate((-1.0, -0.5, 0.5, 1.0)):
        H[d * i] = (0.0, 1.0, x)
        H[d * i + 1] = (1.0, 0.0, 0.0)
    W = sparse.csr_array(H @ H.T)
    q = H @ np.array([0.3, -1.0, 0.1])
    return lm.Problem(W, q, np.full(count, 0.5), d, ("coulomb",) * count, np.zeros(count), np.zeros((count, d)))


def test_redundant_contacts():
    """Eight unknown impulses on three freedoms: some solution, exact. The sum of normal impulses is one: all momentum."""
    problem = hyperstatic()
    solution = lm.solve(problem, solver=lm.Newton(tolerance=1e-12))
    assert solution.status == "converged"
    assert np.abs(solution.velocities[:, 0]).max() < 1e-11
    assert solution.impulses[:, 0].sum() == pytest.approx(1.0, rel=1e-10)


def test_attempt_spends_no_more_than_it_may(sample):
    active = ActiveSet(sample)
    start = swept(sample, 5)
    for most in (0, 1, 7):
        attempt = proximal_newton(active, start, 1e-14, most)
        assert attempt.factorisations <= most
        assert attempt.residual <= active.residual(start)
        assert active.residual(attempt.impulses) == attempt.residual


def test_the_way_of_newton_steps_may_lead_uphill(monkeypatch):
    """Within the patience the residual has halved from its highest on the way, but not from where it began."""
    residuals = iter([2.5e-5, 1.2e-5, 7e-6, 3e-6, 1e-9])
    proximal = sys.modules[proximal_newton.__module__]
    monkeypatch.setattr(proximal, "proximal_solution", lambda *given: (np.array([[next(residuals)]]), True, 6))
    walk = SimpleNamespace(residual=lambda r: float(r[0, 0]), lost=lambda r: False)
    attempt = proximal_newton(walk, np.array([[1e-5]]), 1e-8, 100, patience=10)
    assert (attempt.residual, attempt.factorisations) == (1e-9, 30)


def test_sweeps_go_on_from_where_newton_steps_came_to(monkeypatch):
    """A little disturbed, and not from the best impulses, where those have gained nothing."""
    problem, starts = pressed(), []

    def idle(active, start, *given):
        return Attempt(impulses=start, residual=np.inf, last=3.0 * start, factorisations=1)

    def watched(self, step, *arguments, **others):
        starts.append(step.guess.copy())
        return sweep(self, step, *arguments, **others)

    sweep = lm.Newton._sweep
    monkeypatch.setattr(sys.modules[lm.Newton.__module__], "proximal_newton", idle)
    monkeypatch.setattr(lm.Newton, "_sweep", watched)
    lm.solve(problem, solver=lm.Newton(tolerance=1e-15, max_iterations=150))
    came_to = 3.0 * swept(problem, 100)
    assert starts[1] == pytest.approx(came_to, rel=6 * DISTURBANCE)  # of some hundred factors none is off by six deviations
    assert np.abs(starts[1] - came_to).max() > 1e-3 * np.abs(came_to).max()


def test_budget_spent_is_told_with_the_best_impulses():
    problem = pressed()
    solver = lm.Newton(tolerance=1e-15, max_iterations=30, max_factorisations=3)
    solution = lm.solve(problem, solver=solver)
    assert solution.status == "budget spent"
    assert solution.factorisations <= 3
    assert solution.residual <= lm.residual(problem, swept(problem, 30))


def test_best_impulses_are_returned_as_they_are(monkeypatch):
    """Those of the Newton steps here, which no sweep touches any more: the solution, told not to be one."""
    problem = pressed()
    best = lm.solve(problem, solver=lm.Newton(tolerance=1e-10)).impulses

    def found(active, start, *given):
        return Attempt(impulses=best, residual=1e-9, last=start, factorisations=1)

    monkeypatch.setattr(sys.modules[lm.Newton.__module__], "proximal_newton", found)
    monkeypatch.setattr(lm.Newton, "_sweep", lambda self, step, turn, **others: lm.Outcome(turn, 0.5, SPENT))
    solution = lm.solve(problem, solver=lm.Newton(tolerance=1e-15, max_iterations=150, max_factorisations=1))
    assert np.array_equal(solution.impulses, best)


def test_newton_steps_are_bounded_by_what_they_cost(sample, monkeypatch):
    """In large samples in space that is less than their number: seven cost as much as half as many sweeps as there are
    interactions. Here the bound is brought down to two steps."""
    assert newton_steps(WORK, 40_000, 3) == 7 * WORK // 20_000 < lm.Newton().max_factorisations
    assert newton_steps(WORK, 2000, 3) > lm.Newton().max_factorisations
    assert newton_steps(WORK, 5000, 2) > lm.Newton().max_factorisations
    monkeypatch.setattr(sys.modules[lm.Newton.__module__], "WORK", 300)
    bounded = lm.solve(sample, solver=lm.Newton(tolerance=1e-14, max_iterations=1000))
    assert bounded.factorisations == 2


def test_progress_lets_a_gain_wait_as_long_as_all_before_it_and_a_grace():
    """Ten sweeps a Newton step, so that a patience of 30 of them is worth more than the grace of so many interactions."""
    progress = Progress(int(GRACE), step=10.0, patience=30)
    progress.add(1e-2, sweeps=100)
    assert (progress.sweeps_left, progress.newton_left) == (2 * 100 + 300 - 100, 40)
    progress.add(0.91e-2, newton=15)  # less than a tenth
    assert (progress.sweeps_left, progress.newton_left) == (250, 25)
    progress.add(0.5e-2, newton=5)
    assert progress.sweeps_left == 2 * 300 + 300 - 300
    progress.add(np.inf, sweeps=601)
    assert (progress.sweeps_left, progress.newton_left) == (0, 0)


def test_what_gains_nothing_is_given_up(monkeypatch):
    """Here neither sweeps nor Newton steps gain after the first turn: the solve ends after one patience, the grace, and the
    turn under way."""
    problem, module = pressed(), sys.modules[lm.Newton.__module__]

    def idle_steps(active, start, aim, most, patience):
        return Attempt(impulses=start, residual=0.5, last=start, factorisations=min(most, patience))

    def idle_sweeps(self, step, turn, **others):
        return lm.Outcome(turn, 0.5, SPENT)

    monkeypatch.setattr(module, "proximal_newton", idle_steps)
    monkeypatch.setattr(lm.Newton, "_sweep", idle_sweeps)
    monkeypatch.setattr(sys.modules[Progress.__module__], "GRACE", 0.0)
    solution = lm.solve(problem, solver=lm.Newton(tolerance=1e-8))
    assert (solution.status, solution.factorisations, solution.iterations) == ("stagnated", PATIENCE, 100 + 200)


@pytest.mark.parametrize("gain", [0.9, 0.1])
def test_auto_tries_newton_steps_before_it_relies_on_them(gain, monkeypatch):
    """A few that gain nothing, and the sweeps go on from where they were, by their own memory; where they gain there are
    more at once, and sweeps begin anew."""
    problem, module = pressed(), sys.modules[lm.Auto.__module__]
    newton, sweeps, residual = [], [], [0.5]

    def steps(active, start, aim, most, patience):
        newton.append(most)
        residual[0] *= gain if len(newton) < 4 else 0.0
        return Attempt(impulses=start, residual=residual[0], last=start, factorisations=1)

    def idle_sweeps(self, step, turn, *, state=None, **others):
        sweeps.append((turn, state is None))
        return lm.Outcome(turn, residual[0], SPENT if residual[0] > 0.0 else CONVERGED)

    monkeypatch.setattr(module, "proximal_newton", steps)
    monkeypatch.setattr(lm.Auto, "_sweep", idle_sweeps)
    solution = lm.solve(problem, solver=lm.Auto(tolerance=1e-8))
    first = lm.Auto().first_turn(*problem.guess.shape)
    assert solution.status == "converged"
    assert newton[0] == TRIAL
    assert sweeps[:2] == [(first, False), (LONGER * first, gain < 0.5)]
    assert newton[1] > TRIAL
    assert all(anew for _, anew in sweeps[2:])


def test_no_interaction_and_nothing_to_do():
    empty = lm.Problem(sparse.csr_array((0, 0)), np.zeros(0), np.zeros(0), 2, (), np.zeros(0), np.zeros((0, 2)))
    for solver in (lm.Newton(), lm.Auto()):
        assert lm.solve(empty, solver=solver).status == "converged"
    parted = lm.Problem(
        sparse.csr_array(np.eye(2)), np.array([1.0, 0.2]), np.array([0.3]), 2, ("coulomb",), np.zeros(1), np.ones((1, 2))
    )
    solution = lm.solve(parted, solver=lm.Newton())
    assert not solution.impulses.any()


def stacked(solver, law, height=40):
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    for i in range(height):  # overlapping by a hair: restitution acts where there is no gap
        scene.add(lm.disk(radius=0.01, position=(0.0, 0.0099999 + 0.0199999 * i), mass=1.0 + 10.0 * (i % 2)))
    scene.see("GRAIN", "GRAIN", law)
    scene.see("GRAIN", "WALL", law)
    return lm.Simulation(scene, time_step=1e-3, solver=solver, on_unconverged="ignore")


@pytest.mark.parametrize(
    "law", [lm.Coulomb(friction=0.3), lm.Restitution(friction=0.3, restitution=0.5)], ids=lambda x: x.NAME
)
def test_simulation_with_newton_steps(law):
    """The foot of a stack carries its weight to the last digits; restitution leaves open contacts out of the problem."""
    sim = stacked(lm.Newton(tolerance=1e-12), law)
    sim.step()
    assert sim.report.status == "converged"
    assert sim.report.factorisations > 0
    assert f"{sim.report.factorisations} Newton steps" in str(sim.report)
    net = sim.interactions
    at_wall = net.antagonist == 0
    weight = 9.81 * (40 + 10 * 20)
    assert net.force[at_wall, 0].sum() == pytest.approx(weight, rel=1e-9)
    assert abs(sim.energy.defect) < 1e-12 * weight


class Sticky(lm.Law):
    """Holds on up to a small pull; without a conic form."""

    NAME = "sticky-for-newton"
    APPLIES_TO = "contact"
    PREPARED = ("bias", "hold")
    hold = lm.Parameter("N", minimum=0.0)

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        return (max(gap, 0.0) / time_step, parameters[0] * time_step if gap <= 0.0 else 0.0)

    @staticmethod
    def react(W, u, prepared):
        bias, hold = prepared
        return (max(-hold, -(u[0] + bias) / W[0][0]),)


def test_law_without_a_conic_form():
    """Newton refuses it by a sentence, Auto passes on to sweeps alone."""
    with pytest.raises(TypeError, match="'sticky-for-newton' has no conic form"):
        stacked(lm.Newton(tolerance=1e-12), Sticky(hold=1.0)).step()
    sim = stacked(lm.Auto(tolerance=1e-9, max_iterations=60_000), Sticky(hold=1.0), height=100)
    report = sim.step()
    assert report.status == "converged"
    assert report.factorisations == 0
    assert report.iterations > 1000


def test_auto_is_the_sweeps_where_these_suffice():
    problem = pressed()
    auto = lm.solve(problem, solver=lm.Auto(tolerance=1e-2))
    sweeps = lm.solve(problem, solver=lm.AcceleratedGaussSeidel(tolerance=1e-2))
    assert auto.factorisations == 0
    np.testing.assert_array_equal(auto.impulses, sweeps.impulses)


def test_auto_is_the_default():
    scene = lm.Scene(dimension=2)
    assert isinstance(lm.Simulation(scene, time_step=1e-3).solver, lm.Auto)
    assert lm.solve(hyperstatic()).residual <= lm.Auto().tolerance
