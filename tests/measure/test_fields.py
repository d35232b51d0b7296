"""Coarse-grained fields: the balances of mass and momentum at points, and their integrals beside other measures."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lmgcpy as lm


def box_of_grains(dimension, *, steps=60, seed=3):
    """Grains of two sizes that fall into a box, with a wire of three of them; none is at rest."""
    rng = np.random.default_rng(seed)
    down = np.zeros(dimension)
    down[-1] = -10.0
    scene = lm.Scene(dimension=dimension, gravity=down)
    make = lm.disk if dimension == 2 else lm.sphere
    sites = np.stack(np.meshgrid(*[np.arange(4)] * dimension, indexing="ij"), axis=-1).reshape(-1, dimension)
    grains = []
    for site in sites:
        place = 0.11 + 0.21 * site + rng.uniform(-0.004, 0.004, dimension)
        grains.append(scene.add(make(radius=rng.uniform(0.08, 0.1), position=place, mass=rng.uniform(0.5, 1.5))))
    scene.chain(grains[:3], lm.ElasticWire(axial_rigidity=50.0))
    for axis in range(dimension):
        for side in (0.0, 0.86):
            point, normal = np.zeros(dimension), np.zeros(dimension)
            point[axis], normal[axis] = side, 1.0 if side == 0.0 else -1.0
            scene.add(lm.wall(point=point, normal=normal))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    return lm.Simulation(scene, time_step=2e-3, solver=lm.Auto(tolerance=1e-10)).run(steps=steps)


def at(sim, place, width, **options):
    """The fields at a point and around it, for differences: five points along each axis, a hundredth of a width apart."""
    step = 0.01 * width
    region = place - 2.0 * step, place + 2.0 * step
    fields = lm.measure.coarse_fields(sim, width=width, spacing=step, region=region, **options)
    assert {len(axis) for axis in fields.axes} == {5}
    return fields, step


FIRST = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / 12.0
"""The first derivative of five values, of fourth order: its error is (step/width)^4/30, 3e-10."""


def gradient(values, step, dimension):
    """Derivatives along each axis at the middle, (c, d) of values (*grid, c)."""
    middle = [values[(*[2] * k, slice(None), *[2] * (dimension - k - 1))] for k in range(dimension)]
    return np.stack([np.tensordot(FIRST, line, axes=(0, 0)) / step for line in middle], axis=-1)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("width", [0.05, 0.15])
def test_forces_are_the_divergence_of_the_stress_and_the_walls(dimension, width):
    """``div sigma_c + t = sum_i f_i phi(x - r_i)``, with f_i the force of all interactions on each body, which comes from
    the measure of reactions, at places in the sample and at a wall."""
    sim = box_of_grains(dimension)
    centres = sim.positions[: 4**dimension]
    forces = np.array([lm.measure.reaction(sim, int(k)).force for k in range(len(centres))])
    assert np.abs(forces).max() > 1.0
    middle = (2,) * dimension
    for place in (np.full(dimension, 0.4), np.full(dimension, 0.03), np.linspace(0.5, 0.7, dimension)):
        fields, step = at(sim, place, width)
        phi = np.exp(-0.5 * ((place - centres) ** 2).sum(axis=1) / width**2) / (2.0 * np.pi * width**2) ** (0.5 * dimension)
        expected = phi @ forces
        divergence = gradient(fields.contact_stress, step, dimension).trace(axis1=1, axis2=2)
        scale = np.abs(phi[:, None] * forces).sum() + 1e-3 * np.abs(forces).max() / width**dimension
        # 1e-7: fourth-order differences of a field that varies over a width, and their round-off
        assert divergence + fields.wall_force[middle] == pytest.approx(expected, abs=1e-7 * scale)


@pytest.mark.parametrize("length", [0.02, 1.0, 1.1, 4.9, 5.1, 12.9, 28.0, 90.0])
def test_the_integral_along_a_link_is_that_of_the_error_function(length):
    """A link along x, ``length`` widths long: ``int_0^1 phi ds`` is a difference of error functions, times the Gaussian
    across."""
    scene, width = lm.Scene(dimension=2), 0.5
    ends = [scene.add(lm.disk(radius=1e-3, position=(x, 0.0), mass=1.0)) for x in (0.0, length * width)]
    scene.chain(ends, lm.ElasticWire(axial_rigidity=1.0), reference_gap=0.25 * (length * width - 2e-3))
    sim = lm.Simulation(scene, time_step=1e-5).run(steps=1)
    tension = lm.measure.wire_links(sim).tension[0]
    assert tension > 1.0
    fields = lm.measure.coarse_fields(sim, width=width, region=((-2.0, -0.7), (length * width + 2.0, 0.7)))
    x, y = fields.points[..., 0], fields.points[..., 1]
    u = np.vectorize(math.erf)
    start, end = sim.positions[:, 0]
    along = u((x - start) / (math.sqrt(2.0) * width)) - u((x - end) / (math.sqrt(2.0) * width))
    expected = 0.5 * tension * along * np.exp(-0.5 * (y / width) ** 2) / (math.sqrt(2.0 * math.pi) * width)
    # 1e-13 of the quadrature, and the round-off of the difference for the shortest link
    assert fields.contact_stress[..., 0, 0] == pytest.approx(expected, abs=1e-12 * expected.max() * max(1.0, 1.0 / length))


@pytest.mark.parametrize("dimension", [2, 3])
def test_mass_is_balanced(dimension):
    """``d rho/dt = -div(rho V)``: the bodies are moved on by their velocities for a little while, both ways."""
    sim = box_of_grains(dimension, steps=20)
    place, width, short = np.linspace(0.3, 0.4, dimension), 0.1, 1e-5
    fields, step = at(sim, place, width)
    middle = (2,) * dimension
    mass = np.array([body.mass for body in sim.scene.bodies[: 4**dimension]])

    def density(time):
        away = place - sim.positions[: len(mass)] - time * sim.velocities[: len(mass)]
        return mass @ np.exp(-0.5 * (away**2).sum(axis=1) / width**2) / (2.0 * np.pi * width**2) ** (0.5 * dimension)

    assert fields.density[middle] == pytest.approx(density(0.0), rel=1e-12)
    change = (density(short) - density(-short)) / (2.0 * short)
    flow = gradient(fields.momentum, step, dimension).trace()
    scale = np.abs(sim.velocities).max() * density(0.0) / width
    assert change == pytest.approx(-flow, abs=1e-6 * scale)


@pytest.mark.parametrize("dimension", [2, 3])
def test_integrals_over_all_space(dimension):
    """Mass, volume, momentum, force of the walls; Weber's sum of the stress; and the kinetic stress about the flow."""
    sim, width = box_of_grains(dimension, steps=150), 0.1
    region = np.full(dimension, -0.9), np.full(dimension, 1.7)
    fields = lm.measure.coarse_fields(sim, width=width, region=region)
    cell = np.prod([axis[1] - axis[0] for axis in fields.axes])
    over = tuple(range(dimension))
    bodies = sim.scene.bodies[: 4**dimension]
    mass = np.array([body.mass for body in bodies])
    assert fields.density.sum() * cell == pytest.approx(mass.sum(), rel=1e-8)
    volumes = lm.measure.particle_stress(sim).volume[: len(bodies)]
    assert fields.solid_fraction.sum() * cell == pytest.approx(volumes.sum(), rel=1e-8)
    momentum = mass @ sim.velocities[: len(bodies)]
    assert fields.momentum.sum(axis=over) * cell == pytest.approx(momentum, abs=1e-7 * np.abs(momentum).max())
    walls = lm.measure.reaction(sim, "WALL").force
    assert fields.wall_force.sum(axis=over) * cell == pytest.approx(-walls, abs=1e-7 * np.abs(walls).max())
    weber = lm.measure.stress(sim, volume=1.0)
    total = fields.contact_stress.sum(axis=over) * cell
    # bodies have moved on since the detection by some 1e-5 of a radius
    assert total == pytest.approx(weber["total"], abs=1e-3 * np.abs(weber["total"]).max())
    smooth = fields.velocity[..., :, None] * fields.momentum[..., None, :]
    moved = -np.einsum("b,bi,bj->ij", mass, sim.velocities[: len(bodies)], sim.velocities[: len(bodies)])
    flow = np.nansum(smooth, axis=over) * cell
    assert fields.kinetic_stress.sum(axis=over) * cell - flow == pytest.approx(moved, abs=1e-6 * np.abs(moved).max())
    assert (np.linalg.eigvalsh(fields.kinetic_stress)[..., -1] <= 1e-12 * np.abs(fields.kinetic_stress).max()).all()


def test_the_stress_under_a_heap_is_the_weight_above():
    """A static column between smooth walls: the integral of the vertical stress over a level is the weight above it."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    for k in range(12):
        scene.add(lm.disk(radius=0.1, position=(0.1 + 0.15 * (k % 2), 0.1 + 0.13 * k), mass=1.0 + 0.1 * k))
    floor = scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
    scene.add(lm.wall(point=(0.0, 0.0), normal=(1.0, 0.0)))
    scene.add(lm.wall(point=(0.35, 0.0), normal=(-1.0, 0.0)))
    scene.see("GRAIN", "GRAIN", lm.Signorini())
    scene.see("GRAIN", "WALL", lm.Signorini())
    scene.drag(rate=10.0)
    sim = lm.Simulation(scene, time_step=5e-3, solver=lm.Auto(tolerance=1e-10))
    sim.run(steps=1500)
    assert np.abs(sim.velocities).max() < 1e-6
    width = 0.08
    fields = lm.measure.coarse_fields(sim, width=width, spacing=0.02, region=((-0.6, -0.7), (1.0, 2.6)))
    across, up = (axis[1] - axis[0] for axis in fields.axes)
    vertical = fields.contact_stress[..., 1, 1].sum(axis=0) * across
    # momentum: sigma grows downward by the weight, and above the floor by its force
    expected = -10.0 * fields.density.sum(axis=0) * across + fields.wall_force[..., 1].sum(axis=0) * across
    assert np.abs(vertical).max() > 0.8 * -floor.reaction.force[1]
    gained = np.concatenate([[0.0], np.cumsum(0.5 * (expected[1:] + expected[:-1]) * up)])
    assert -vertical == pytest.approx(gained, abs=2e-3 * np.abs(vertical).max())  # trapezia: (up/width)^2/12 a step


@pytest.mark.parametrize("width", [0.06, 0.4])
def test_a_periodic_cell(width):
    """Fields have the cell's period, and their means over it are the mass and Weber's stress; also for widths near the
    cell's own."""
    rng = np.random.default_rng(5)
    scene = lm.Scene(dimension=2)
    for x in range(5):
        for y in range(5):
            place = 0.1 + 0.2 * np.array([x, y]) + rng.uniform(-0.01, 0.01, 2)
            scene.add(lm.disk(radius=0.1, position=place, mass=1.0, velocity=rng.uniform(-0.5, 0.5, 2)))
    scene.periodic(x=1.0, y=1.0)
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=1e-10), overlap="ignore").run(steps=60)
    count = 41
    fields = lm.measure.coarse_fields(sim, width=width, spacing=1.0 / (count - 1), region=((-0.2, 0.3), (0.8, 1.3)))
    for values in (fields.density, fields.momentum, fields.contact_stress, fields.kinetic_stress):
        scale = np.abs(values).max()
        assert values[0] == pytest.approx(values[-1], abs=1e-9 * scale)
        assert values[:, 0] == pytest.approx(values[:, -1], abs=1e-9 * scale)
    assert fields.density[:-1, :-1].mean() == pytest.approx(25.0, rel=1e-9)
    weber = lm.measure.stress(sim)["total"]
    assert np.abs(weber).max() > 1.0
    assert fields.contact_stress[:-1, :-1].mean(axis=(0, 1)) == pytest.approx(weber, abs=2e-3 * np.abs(weber).max())


@pytest.mark.parametrize("theta", [0.5, 1.0])
def test_forces_are_the_divergence_of_the_stress_across_the_faces_of_a_cell_that_deforms(theta):
    """Two disks meet across a face of a cell that is sheared: ``div sigma_c = sum_i f_i phi(x - r_i)`` over all images, as
    they are when the step ends and the edges have moved on."""
    scene = lm.Scene(dimension=2)
    for y, up in ((0.08, -1.0), (0.91, 1.0)):
        scene.add(lm.disk(radius=0.1, position=(0.5, y), mass=1.0, velocity=(0.0, up)))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    cell = scene.periodic(x=1.0, y=1.0).impose_rate(xy=5.0)
    sim = lm.Simulation(scene, time_step=1e-3, theta=theta, overlap="ignore").run(steps=1)
    forces = np.array([lm.measure.reaction(sim, k).force for k in range(2)])
    assert np.abs(forces).max() > 100.0
    place, width = np.array([0.48, 0.02]), 0.05
    fields, step = at(sim, place, width)
    shifts = np.stack(np.meshgrid([-1, 0, 1], [-1, 0, 1]), axis=-1).reshape(-1, 2)
    images = sim.positions[:2] + (shifts @ cell.edges)[:, None]
    phi = np.exp(-0.5 * ((place - images) ** 2).sum(axis=2) / width**2) / (2.0 * np.pi * width**2)
    divergence = gradient(fields.contact_stress, step, 2).trace(axis1=1, axis2=2)
    assert divergence == pytest.approx((phi @ forces).sum(axis=0), abs=1e-6 * np.abs(phi[..., None] * forces).sum())


def test_a_frame_of_a_run_is_as_the_simulation(tmp_path):
    sim = box_of_grains(2, steps=10)
    sim.run(steps=10, record=tmp_path / "run.h5", every=5)
    now = lm.measure.coarse_fields(sim, width=0.1)
    with lm.io.open_run(tmp_path / "run.h5") as run:
        read = lm.measure.coarse_fields(run, width=0.1)
        before = lm.measure.coarse_fields(run, width=0.1, frame=0)
    for name in ("density", "solid_fraction", "momentum", "contact_stress", "kinetic_stress", "wall_force"):
        assert (getattr(read, name) == getattr(now, name)).all()
    assert not np.array_equal(before.density, now.density)
    assert repr(now).startswith("<CoarseFields on ")
    assert now.points.shape == (*now.density.shape, 2)


def test_wrong_arguments():
    sim = box_of_grains(2, steps=1)
    with pytest.raises(ValueError, match="width must be above 0"):
        lm.measure.coarse_fields(sim, width=0.0)
    with pytest.raises(TypeError, match="region must be two corners"):
        lm.measure.coarse_fields(sim, width=0.1, region=(1.0, 2.0, 3.0))
    with pytest.raises(ValueError, match="low corner and its high corner"):
        lm.measure.coarse_fields(sim, width=0.1, region=((1.0, 1.0), (0.0, 2.0)))
    with pytest.raises(ValueError, match="give a larger spacing"):
        lm.measure.coarse_fields(sim, width=0.1, spacing=1e-5)
    scene = lm.Scene(dimension=2)
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    empty = lm.Simulation(scene, time_step=1e-3).run(steps=1)
    with pytest.raises(ValueError, match="bodies with bounds and mass"):
        lm.measure.coarse_fields(empty, width=0.1)
