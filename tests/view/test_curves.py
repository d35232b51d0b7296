"""Curves of runs: what is on them is what was recorded, with units."""

import numpy as np
import pytest
from matplotlib.figure import Figure
from seen import pixels

import lmgcpy as lm
from lmgcpy.view import curves, figures
from lmgcpy.view.recorded import RecordedTest, recorded_test, running_mean, stresses_by_frame, wall_forces_by_frame

STRAIN = np.linspace(0.0, 0.05, 60)


def pressed(tmp_path, name="pressed.h5", *, observed=False, wire=False):
    """Two disks in a square box, pressed by 10 N/m from above; the observations are those of a test, made up."""
    scene = lm.Scene(dimension=2)
    disks = [scene.add(lm.disk(radius=0.5, position=(0.5 + i, 0.5), mass=1.0)) for i in range(2)]
    for point, normal in (((0, 0), (1, 0)), ((2, 0), (-1, 0)), ((0, 0), (0, 1))):
        scene.add(lm.wall(point=point, normal=normal))
    lid = scene.add(lm.wall(point=(0, 1), normal=(0, -1), mass=1.0))
    lid.impose_force(y=-10.0)
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.0))
    if wire:
        scene.chain(disks, lm.RigidWire())
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-10))
    observe = None
    if observed:
        observe = {
            "reactions": lambda sim: np.array([1.0, 1.0, 1e3 * (1 + STRAIN[sim.steps - 1]), 1e3]),
            "size": lambda sim: np.array([2.0, 1.0 - STRAIN[sim.steps - 1]]),
            "stress": lambda sim: np.stack([np.diag([-1e5, -3e5]), np.diag([-2e5, -3e5]), np.diag([1e5, 0.0])]),
        }
    sim.run(steps=60, record=tmp_path / name, every=20, observe=observe)
    return lm.io.open_run(tmp_path / name)


def lines(figure: Figure):
    """Curves by their label, of all axes: (x, y)."""
    return {line.get_label(): line.get_data() for axes in figure.axes for line in axes.get_lines()}


def test_forces_on_walls_of_any_run(tmp_path):
    """10 N/m on the lid, and as much on the floor, in every frame after a step."""
    with pressed(tmp_path) as run:
        time, forces = wall_forces_by_frame(run)
        figure = curves.reaction([run], ["pressed"])
    np.testing.assert_allclose(time, [0.02, 0.04, 0.06])
    np.testing.assert_allclose(forces["WALL, body 5"], 10.0, rtol=1e-8)
    np.testing.assert_allclose(forces["WALL, body 4"], 10.0, rtol=1e-8)
    shown = lines(figure)
    np.testing.assert_allclose(shown["WALL, body 4"][1], 10.0, rtol=1e-8)
    assert figure.axes[0].get_ylabel() == "normal force on the wall [N per m of depth]"
    assert figure.axes[0].get_xlabel() == "time [s]"


def test_stress_of_any_run_in_a_box(tmp_path):
    """10 N/m on a lid of 2 m: 5 Pa."""
    with pressed(tmp_path) as run:
        _, sigma = stresses_by_frame(run)
        figure, apart = curves.stress([run], ["pressed"]), curves.deviator([run], ["pressed"])
    np.testing.assert_allclose(sigma["total"][:, 1, 1], -5.0, rtol=1e-6)
    np.testing.assert_array_equal(sigma["wire"], 0.0)
    np.testing.assert_allclose(lines(figure)["whole sample, smallest"][1], -5e-3, rtol=1e-6)
    np.testing.assert_allclose(lines(apart)["pressed"][1], 5e-3, rtol=1e-6)


def test_a_test_is_drawn_over_its_crushing(tmp_path):
    with pressed(tmp_path, observed=True) as run:
        test = recorded_test(run)
        reaction, apart = curves.reaction([run], ["a"]), curves.deviator([run], ["a"])
    np.testing.assert_allclose(test.strain, STRAIN, atol=1e-12)
    np.testing.assert_allclose(test.reaction, 1e3 * (1 + STRAIN))
    assert test.law == "none"
    x, y = lines(reaction)["sand (no law)"]
    np.testing.assert_allclose(x, 100 * STRAIN, atol=1e-10)
    np.testing.assert_allclose(y, 1 + STRAIN, rtol=2e-3)  # a running mean over 0.25 % of strain
    assert reaction.axes[0].get_xlabel() == "crushing [%]"
    assert reaction.axes[0].get_ylabel() == "support reaction [kN per m of depth]"
    np.testing.assert_allclose(lines(apart)["sand (no law)"][1], 100.0 * -STRAIN, atol=1e-10)  # below: the volume shrinks
    assert apart.axes[0].get_lines()[0].get_ydata() == pytest.approx(200.0)


def test_tests_are_named_by_their_law_where_that_tells_them_apart(tmp_path):
    with pressed(tmp_path, "a.h5", observed=True) as a, pressed(tmp_path, "b.h5", observed=True, wire=True) as b:
        assert {"sand (no law)", "rigid wire"} <= set(lines(curves.reaction([a, b], ["a", "b"])))
        assert {"a", "b"} <= set(lines(curves.reaction([a, a], ["a", "b"])))
        parts = curves.stress([a, b], ["a", "b"])
        assert [axes.get_title() for axes in parts.axes] == [
            "Weber stress with sand (no law)",
            "Weber stress with rigid wire",
        ]
        np.testing.assert_allclose(lines(parts)["wire part, greatest"][1], 100.0)


def test_energy_and_solver(tmp_path):
    """A body in free fall: what gravity works is its kinetic energy, m g^2 t^2/2."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    scene.add(lm.disk(radius=0.1, position=(0.0, 5.0), mass=2.0))
    lm.Simulation(scene, time_step=1e-2).run(steps=50, record=tmp_path / "fall.h5")
    with lm.io.open_run(tmp_path / "fall.h5") as run:
        energy, solver = curves.energy([run], ["fall"]), curves.solver([run], ["fall"])
    time, kinetic = lines(energy)["kinetic energy"]
    np.testing.assert_allclose(kinetic, 0.5 * 2.0 * (10.0 * time) ** 2, rtol=1e-12)
    np.testing.assert_allclose(lines(energy)["work of loads and weight"][1], kinetic, rtol=1e-12)
    assert energy.axes[0].get_ylabel() == "energy [J per m of depth]"
    assert "fall, 0 of 50 steps not converged" in lines(solver)
    assert [axes.get_ylabel() for axes in solver.axes] == ["residual", "iterations a step"]


@pytest.mark.default_parameters(".png-energy")
@pytest.mark.parametrize("what", list(curves.CURVES))
@pytest.mark.parametrize("suffix", [".png", ".svg"])
def test_a_file_comes_out(what, suffix, tmp_path):
    with pressed(tmp_path) as run:
        out = lm.view.plot(run, tmp_path / f"a{suffix}", what=what)
    assert out.stat().st_size > 1000
    if suffix == ".png":
        assert (pixels(out) < 250).any()


def test_running_means():
    values = np.arange(100.0)
    np.testing.assert_allclose(running_mean(values, values, 10.0)[10:-10], values[10:-10])  # of a line the line
    np.testing.assert_array_equal(running_mean(np.zeros(5), values[:5], 1.0), values[:5])
    assert running_mean(values, (-1.0) ** values, 10.0)[20:-20] == pytest.approx(0.0, abs=0.1)


def test_deviators():
    """Difference of the principal values; in 3D, with two of them equal, as well. Turned axes change nothing."""
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    for stress in (np.diag([-1.0, -4.0]), np.diag([-1.0, -1.0, -4.0])):
        assert figures.deviator(stress[None]) == pytest.approx(3.0)
    assert figures.deviator((turn @ np.diag([-1.0, -1.0, -4.0]) @ turn.T)[None]) == pytest.approx(3.0)


def test_runs_of_one_name_are_told_apart():
    class Named:
        def __init__(self, path):
            self.path = path

    assert curves.names_of([Named("/x/a/run.h5"), Named("/x/b/run.h5")]) == ["a/run", "b/run"]
    assert curves.names_of([Named("/x/a/run.h5")]) == ["run"]


def test_what_cannot_be_plotted_gets_a_sentence(tmp_path):
    lm.Simulation(one_disk(), time_step=1e-3).run(steps=0, record=tmp_path / "empty.h5")
    with lm.io.open_run(tmp_path / "empty.h5") as run:
        for what in ("deviator", "stress", "energy", "solver"):
            with pytest.raises(ValueError, match=r"holds no (frame after a )?step yet: there is nothing to draw\."):
                lm.view.plot(run, tmp_path / "a.png", what=what)
    lm.Simulation(one_disk(), time_step=1e-3).run(steps=10, record=tmp_path / "one.h5")
    with lm.io.open_run(tmp_path / "one.h5") as run:
        for what, words in {
            "reaction": "has no wall",
            "stress": "not in a box",
            "deviator": "not in a box",
            "strain": "what cannot be 'strain'",
        }.items():
            with pytest.raises(ValueError, match=words):
                lm.view.plot(run, tmp_path / "a.png", what=what)
        with pytest.raises(ValueError, match=r"path must end in \.png, \.svg, \.pdf"):
            lm.view.plot(run, tmp_path / "a.txt")
    with pytest.raises(TypeError, match="runs must be what"):
        lm.view.plot([], tmp_path / "a.png")
    assert not (tmp_path / "a.png").exists()


def one_disk():
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=0.1, position=(0.0, 0.0), mass=1.0))
    return scene


def a_test(size, strain, reaction, wire=0.0):
    """A test of three steps with a wire that bears a part of the stress."""
    d = size.shape[1]
    total = np.tile(-np.eye(d) * 1e5, (len(strain), 1, 1))
    stress = {"total": total, "sand": total, "wire": np.tile(np.diag([wire] + [0.0] * (d - 1)), (len(strain), 1, 1))}
    return RecordedTest("rigid-wire", strain, reaction, size, stress)


@pytest.mark.parametrize(("dimension", "axis"), [(2, 1), (3, 2), (3, 0)])
def test_the_isotropic_load_and_q_over_p(dimension, axis):
    """A sample of 0.2 m (x 0.2 m) and 0.4 m along the axis under 1e5 Pa: 20 kN/m, or 4 kN. Twice the load is q = p_l, hence
    q/p = 1/1.5 in the plane, and 3/4 in space."""
    strain = np.array([0.0, 0.01, 0.02])
    size = np.full((3, dimension), 0.2)
    size[:, axis] = 0.4 * (1.0 - strain)
    size[2, (axis + 1) % dimension] *= 1.001  # it widens
    load = 20e3 if dimension == 2 else 4e3
    record = a_test(size, strain, load * np.array([1.5, 1.9, 2.0]))
    assert figures.height_of(record) == 0.4
    figure = figures.reaction_figure([record], pressure=1e5)
    (axes,) = figure.axes
    isotropic = [line for line in axes.get_lines() if line.get_label() == "isotropic load"]
    assert isotropic[0].get_ydata()[0] == pytest.approx(1e-3 * load)
    (scale,) = axes.child_axes
    to_ratio, to_reaction = scale._functions
    assert to_ratio(2e-3 * load) == pytest.approx(1.0 / 1.5 if dimension == 2 else 0.75)
    assert to_reaction(to_ratio(1.7e-3 * load)) == pytest.approx(1.7e-3 * load)
    assert min(scale.get_yticks()) == 0.0
    assert not figures.reaction_figure([record]).axes[0].child_axes


def test_the_wire_has_an_axis_of_its_own_in_space():
    """In the plane it bears as much as the sand, and is drawn with it."""
    strain = np.array([0.0, 0.01, 0.02])
    for dimension in (2, 3):
        records = [a_test(np.full((3, dimension), 0.2), strain, np.ones(3), wire) for wire in (2e3, 4e3)]
        figure = figures.stress_figure(*records)
        assert len(figure.axes) == (2 if dimension == 2 else 4)
        if dimension == 3:
            own = [
                axes for axes in figure.axes if any("axis at the right" in line.get_label() for line in axes.get_lines())
            ]
            assert len(own) == 2
            assert own[0].get_ylim() == own[1].get_ylim()
            assert own[1].get_ylim()[1] >= 4.0
            assert len(figure.legends[0].get_texts()) == 6
