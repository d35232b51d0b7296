"""Surfaces between bodies that go on across the faces of a periodic cell."""

import numpy as np
import pytest
import suites

import lmgcpy as lm

ROD = lm.ElasticRod(stiffness=1e3)


def ball(d, radius, position, **start):
    return (lm.disk if d == 2 else lm.sphere)(radius=radius, position=position, mass=0.02, **start)


def closed_thread(d, shift, *, wrapped, cells=1):
    """A thread that closes across a face, and balls that fall on it; all is shifted along x. With several ``cells`` the
    periodic cell is as many times as long, and contains as many of them."""
    scene = lm.Scene(dimension=d)
    scene.periodic(**({"x": float(cells)} if d == 2 else {"x": float(cells), "y": 1.0}))
    x = np.arange(10 * cells) * 0.1 + shift
    if wrapped:
        x = x % cells
    nodes = [scene.add(lm.point_mass(position=(at, *[0.5] * (d - 1)), mass=0.01)) for at in x]
    scene.chain(nodes, ROD, closed=True, surface=lm.Thread(0.01))
    for k in range(3 * cells):
        place = [0.03 + 0.31 * (k % 3) + k // 3 + shift, *[0.505] * (d - 2), 0.559 + 0.002 * (k % 3)]
        scene.add(ball(d, 0.05, place, velocity=[-0.3, *[0.0] * (d - 2), -0.5]))
    scene.see("GRAIN", "THREAD", lm.Coulomb(friction=0.3))
    return scene


def sheet(shift, *, wrapped):
    """A membrane without ends in a cell, 6 by 6 nodes, and balls that fall on it, one of them over a corner of the cell."""
    scene = lm.Scene(dimension=3)
    scene.periodic(x=1.0, y=1.0)
    n = 6
    i, j = (index.ravel() for index in np.mgrid[:n, :n])
    places = np.column_stack([i / n + shift[0], j / n + shift[1], np.full(n * n, 0.3)])
    if wrapped:
        places[:, :2] %= 1.0
    nodes = [scene.add(lm.point_mass(position=place, mass=0.01)) for place in places]

    def at(a, b):
        return (a % n) * n + b % n

    triangles = np.array(
        [
            corners
            for a, b in zip(i.tolist(), j.tolist(), strict=True)
            for corners in ((at(a, b), at(a + 1, b), at(a + 1, b + 1)), (at(a, b), at(a + 1, b + 1), at(a, b + 1)))
        ]
    )
    scene.membrane(nodes, triangles, ROD, radius=0.01)
    for x, y in ((0.01, 0.02), (0.4, 0.55), (0.93, 0.3)):
        scene.add(ball(3, 0.06, (x + shift[0], y + shift[1], 0.371), velocity=(0.2, -0.1, -0.5)))
    scene.see("GRAIN", "MEMBRANE", lm.Coulomb(friction=0.3))
    return scene


def run(scene, steps=120):
    """Velocities after so many steps, and the largest defect of the energy; contacts must have acted."""
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=1e-10), overlap="ignore")
    acted, defects = 0, []
    for _ in range(steps):
        sim.step()
        net = sim.interactions
        acted += int(net.impulse[net.law == "coulomb", 0].any())
        defects.append(abs(sim.energy.defect))
    assert acted > 10
    assert max(defects) < 1e-15
    return sim.velocities.copy()


@pytest.mark.scaled
@pytest.mark.default_parameters("2")
@pytest.mark.parametrize("d", [2, 3])
def test_a_thread_across_a_face_is_a_thread_within_the_cell(d):
    expected = run(closed_thread(d, 0.0, wrapped=False))
    for shift, wrapped in ((5.2, True), (0.37, True), (0.93, False))[: suites.size(1, long=3)]:
        # rounding of places, 1e-15, over some hundred steps of impacts
        np.testing.assert_allclose(run(closed_thread(d, shift, wrapped=wrapped)), expected, atol=1e-9)


@pytest.mark.long
def test_a_membrane_that_closes_across_two_faces():
    expected = run(sheet((0.0, 0.0), wrapped=False))
    for shift, wrapped in (((0.37, 0.81), True), ((0.37, -2.19), False)):
        np.testing.assert_allclose(run(sheet(shift, wrapped=wrapped)), expected, atol=1e-9)


@pytest.mark.long
def test_a_cell_is_half_of_one_twice_as_long():
    one, two = (run(closed_thread(2, 0.2, wrapped=True, cells=cells)) for cells in (1, 2))
    nodes, edge = 10, 1
    np.testing.assert_allclose(two[edge : edge + nodes], one[edge : edge + nodes], atol=1e-9)
    np.testing.assert_allclose(two[edge + nodes : edge + 2 * nodes], one[edge : edge + nodes], atol=1e-9)
    np.testing.assert_allclose(two[-3:], one[-3:], atol=1e-9)


@pytest.mark.default_parameters("closed_thread-2")
@pytest.mark.parametrize(("make", "d"), [(closed_thread, 2), (closed_thread, 3), (sheet, 3)])
def test_the_gap_grows_with_the_nodes_the_ball_and_the_cell(make, d):
    """Every body moves by ``v + G x``, the edges by ``G L``, and the normal velocity is the slope of the gap."""
    scene = sheet((0.3, 0.3), wrapped=True) if make is sheet else closed_thread(d, 0.37, wrapped=True)
    scene.cell.impose_rate(xx=1e-9)  # a cell that moves, so that interactions have branches
    sim = lm.Simulation(scene, time_step=1e-12, overlap="ignore")
    sim.step()
    problem, rows = sim.last_step[0], np.flatnonzero(sim.interactions.law == "coulomb")
    assert len(rows) >= 2
    rng, way = np.random.default_rng(3), 1e-6
    velocities = np.zeros_like(sim.state.velocities)
    velocities[:, :d] = 0.3 * rng.standard_normal((len(velocities), d))
    lattice = scene.cell.lattice
    gradient = np.zeros((d, d))
    for row, axis in zip(lattice.rows, lattice.axes, strict=True):
        gradient[: d if d == 2 else 2, axis] = velocities[row, : d if d == 2 else 2] = rng.standard_normal(2)
        velocities[row, 2:] = 0.0
        if d == 2:
            gradient[1, axis] = velocities[row, 1] = 0.0  # the edges stay among the periodic axes
    gaps = []
    for step in (way, 0.0):
        positions = sim.state.positions.copy()
        own = velocities[:, :d].copy()
        own[lattice.rows] = 0.0
        positions[:, :d] += step * (own + positions[:, :d] @ gradient.T)
        gaps.append(sim._detector.detect(positions, 0.0, 1.0).gap[rows])
    normal = problem.relative_velocities(velocities)[rows, 0]
    # the second derivative, times half the way
    np.testing.assert_allclose(gaps[0] - gaps[1], way * normal, atol=1e-4 * way)
    H = problem.interaction_matrix().toarray()
    np.testing.assert_allclose(H @ velocities.ravel(), problem.relative_velocities(velocities).ravel(), atol=1e-14)


@pytest.mark.long
def test_at_rest_the_stress_is_the_imposed_one():
    scene, rng, n, places = lm.Scene(dimension=2), np.random.default_rng(5), 12, []
    cell = scene.periodic(x=1.0, y=1.0)
    nodes = [scene.add(lm.point_mass(position=((i / n + 0.3) % 1.0, 0.5), mass=0.01)) for i in range(n)]
    scene.chain(nodes, ROD, closed=True, surface=lm.Thread(0.015))
    for place in rng.random((4000, 2)):
        apart = np.array([place - other for other in places]).reshape(-1, 2)
        if abs(place[1] - 0.5) > 0.07 and (np.linalg.norm(apart - np.rint(apart), axis=1) > 0.101).all():
            places.append(place)
            scene.add(ball(2, 0.05, place))
    scene.see("GRAIN", "THREAD", lm.Coulomb(friction=0.3))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.drag(linear=0.3)
    cell.impose_stress(xx=-10.0, yy=-10.0)
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=1e-8))
    sim.run(steps=4000)
    net = sim.interactions
    with_thread = (net.law == "coulomb") & (np.minimum(net.candidate, net.antagonist) < 2 + n)
    assert net.impulse[with_thread, 0].any()
    stress = lm.measure.stress(sim)["total"]
    np.testing.assert_allclose(np.diag(stress), -10.0, rtol=1e-4)  # the shear is held and bears what it must
    # the couples of friction on the surface of the thread are left out
    couples = (net.force[:, 1] * (0.015 + 0.5 * net.gap))[with_thread]
    assert stress[0, 1] - stress[1, 0] == pytest.approx(couples.sum() / cell.volume, rel=1e-9)


def tube(pressure, around=24, along=6):
    """A tube of triangles, endless along z, with a pressure inside; where the ring of nodes has the radius 0.1 m."""
    scene, radius, height = lm.Scene(dimension=3), 0.1, 0.16
    scene.periodic(z=height)
    i, j = (index.ravel() for index in np.mgrid[:along, :around])
    angle = 2.0 * np.pi * (j + 0.5 * i) / around
    places = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height * i / along])
    nodes = [scene.add(lm.point_mass(position=place, mass=1e-3)) for place in places]

    def at(a, b):  # a turn further up nodes are half an angle further on, a whole number of them around the cell
        return (a % along) * around + (b + (along // 2 if a == along else 0)) % around

    triangles = [
        corners
        for a, b in zip(i.tolist(), j.tolist(), strict=True)
        for corners in ((at(a, b), at(a, b + 1), at(a + 1, b)), (at(a, b + 1), at(a + 1, b + 1), at(a + 1, b)))
    ]
    net = scene.membrane(nodes, triangles, lm.ElasticRod(stiffness=100.0), radius=0.002)
    net.impose_pressure(-pressure)  # normals point outward, and the pressure is behind them
    scene.drag(linear=0.3)
    return scene, np.array(triangles), height


@pytest.mark.long
def test_a_latex_tube_bears_a_pressure_by_its_hoops():
    """Virtual work of a wider tube: the tensions T of links that are s across the axis, out of l, do ``sum T s^2 / l =
    2 p V``. In a smooth tube the hoops bear ``p R`` per length."""
    pressure = 5.0
    scene, triangles, height = tube(pressure)
    sim = lm.Simulation(scene, time_step=1e-3)
    sim.run(duration=1.0)
    assert np.abs(sim.velocities).max() < 1e-6
    net, x = sim.interactions, sim.positions
    way = x[net.candidate] - x[net.antagonist]
    way[:, 2] -= height * np.rint(way[:, 2] / height)
    tension, length = -net.force[:, 0], np.linalg.norm(way, axis=1)
    across = (way[:, :2] ** 2).sum(axis=1)
    corners = x[1:][triangles]
    corners[:, :, 2] -= height * np.rint((corners[:, :, 2] - corners[:, :1, 2]) / height)
    areas = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    volume = 0.5 * float((areas * corners.mean(axis=1))[:, :2].sum())  # of what is between the tube and its axis
    assert float((tension * across / length).sum()) == pytest.approx(2.0 * pressure * volume, rel=1e-6)
    radius = np.linalg.norm(x[1:, :2], axis=1)
    assert np.ptp(radius) < 1e-9 + 1e-6 * radius.mean()
    hoop = float((tension * across / length).sum()) / (2.0 * np.pi * radius.mean() * height)
    # sides of 24 angles lie within the circle by (pi/24)^2 / 3, and triangles lean as much
    assert hoop == pytest.approx(pressure * radius.mean(), rel=(np.pi / 24) ** 2)


def test_pressures_in_cells_that_deform_are_refused():
    for order in (("impose_stress", {"xx": -1.0}), ("impose_rate", {"xy": 1.0}), ("impose_rate", {"xy": lambda t: t})):
        name, given = order
        first, last = lm.Scene(dimension=2), lm.Scene(dimension=2)
        for scene in (first, last):
            cell = scene.periodic(x=1.0, y=1.0)
            nodes = [scene.add(lm.point_mass(position=(0.2 + 0.2 * k, 0.5), mass=1.0)) for k in range(3)]
            skin = scene.chain(nodes, ROD, surface=lm.Thread(0.01)).skin
            if scene is first:
                skin.impose_pressure(1.0)
                with pytest.raises(ValueError, match="under pressure, and the cell would deform"):
                    getattr(cell, name)(**given)
                assert not any(edge._forces or any(edge._velocities.values()) for edge in cell._edges)
                cell.fix()
            else:
                getattr(cell, name)(**given)
                with pytest.raises(ValueError, match="under pressure, and the cell would deform"):
                    skin.impose_pressure(1.0)
                assert skin.pressure is None


def test_nodes_that_are_near_across_a_face_are_refused():
    scene = lm.Scene(dimension=2)
    scene.chain(
        [scene.add(lm.point_mass(position=(x, 0.5), mass=1.0)) for x in (0.0, 0.3, 0.6, 0.99)], ROD, closed=True,
        surface=lm.Thread(0.01),
    )  # fmt: skip
    with pytest.raises(ValueError, match=r"has nodes 0\.01 m apart, closer"):
        scene.periodic(x=1.0)


@pytest.mark.long
def test_a_run_goes_on_from_its_file_bit_for_bit(tmp_path):
    path, options = tmp_path / "run.h5", {"time_step": 1e-3, "overlap": "ignore"}
    scene = sheet((0.37, 0.81), wrapped=True)
    scene.cell.impose_rate(xy=0.5)
    lm.Simulation(scene, **options).run(steps=30, record=path)
    lm.resume(path).run(steps=30)
    whole = sheet((0.37, 0.81), wrapped=True)
    whole.cell.impose_rate(xy=0.5)
    expected = lm.Simulation(whole, **options).run(steps=60)
    with lm.io.open_run(path) as recorded:
        np.testing.assert_array_equal(recorded.positions[-1], expected.positions)
    again = lm.Scene.from_run(path)
    assert len(again.skins) == 1
    assert again.cell is not None
