"""A run in two parts is the whole run, bit for bit: every law, driven and loaded walls, clusters, after SIGKILL."""

import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from stateful import Brittle, Touched

import lmgcpy as lm
from lmgcpy.scene.description import describe, from_description

LAWS = lm.laws.registrations()


def some_law(name):
    """A law of that name with its required parameters, and one optional if it needs one."""
    kind = LAWS[name].law
    given = {key: 0.5 for key, parameter in kind.parameters().items() if parameter.default is not None}
    optional = [key for key in kind.parameters() if key not in given]
    for more in ([], *[[key] for key in optional], *[[a, b] for a in optional for b in optional]):
        try:
            return kind(**given, **dict.fromkeys(more, 300.0))
        except ValueError:
            continue
    raise AssertionError(name)


def box(law, functions=None):
    """Grains and dumbbells thrown together between a floor that rises and a wall that is pushed in; a chain through."""
    rng = np.random.default_rng(3)
    scene = lm.Scene(dimension=2, gravity=(0.3, -9.81))
    link = law.APPLIES_TO == "link"
    sand = lm.Material("sand", density=100.0)
    grains = []
    for i in range(20):
        start = {"position": (0.21 * (i % 5) + 0.12, 0.21 * (i // 5) + 0.12), "velocity": rng.normal(0.0, 1.0, 2)}
        if i % 7 == 5:
            shapes = [(lm.DiskContactor(0.05), (-0.04, 0.01)), (lm.DiskContactor(0.045), (0.05, 0.0))]
            grains.append(lm.RigidBody(shapes, mass=1.0, inertia=2e-3, rotation=0.4, spin=2.0, color="GRAIN", **start))
        else:
            grains.append(lm.disk(radius=rng.uniform(0.08, 0.1), material=sand, spin=rng.normal(), **start))
        scene.add(grains[-1])
    grains[2].fix("x")
    grains[7].impose_force(x=3.0, spin=0.02)
    floor = scene.add(lm.wall(point=(0, 0), normal=(0.1, 1)))
    floor.impose_velocity(y=functions[20, "y"] if functions else 0.2)
    scene.add(lm.wall(point=(0, 0), normal=(1, 0)))
    scene.add(lm.wall(point=(1.1, 0), normal=(-1, 0.05), mass=20.0)).impose_force(x=-40.0)
    contact = lm.Coulomb(friction=0.3) if link else law
    scene.see("GRAIN", "GRAIN", contact)
    scene.see("WALL", "GRAIN", contact, alert=0.02)
    chained = law if link and not law.TIES else lm.RigidWire()
    scene.chain([grains[i] for i in (10, 11, 13, 14, 18)], chained, block_spin=True)
    if law.TIES:
        half = 0.5 * (grains[4].position - grains[3].position)
        scene.link(grains[3], grains[4], law, at=(half, -half))
    scene.chain([grains[i] for i in (0, 1, 6)], lm.VoigtWire(stiffness=50.0, viscosity=1.0), closed=True, relaxation=0.02)
    return scene


def simulation(law, functions=None):
    return lm.Simulation(box(law, functions), time_step=2e-3, theta=0.6, on_unconverged="ignore")


def same_bits(a, b):
    def bits(array):
        return np.ascontiguousarray(array).view(np.int64)

    for name in ("positions", "velocities"):
        assert np.array_equal(bits(getattr(a.state, name)), bits(getattr(b.state, name))), name
    net_a, net_b = a.interactions, b.interactions
    assert np.array_equal(bits(net_a.impulse), bits(net_b.impulse))
    assert np.array_equal(net_a.candidate, net_b.candidate)
    assert a.time == b.time
    assert a.steps == b.steps
    assert a.energy == b.energy
    assert (a.unconverged_steps, a.worst_residual) == (b.unconverged_steps, b.worst_residual)


@pytest.mark.default_parameters("rigid-wire")
@pytest.mark.filterwarnings("ignore:In the step")  # grains that hit at 3 m/s overlap by a tenth in a step
@pytest.mark.parametrize("name", sorted(LAWS))
def test_two_halves_are_the_whole_for_every_law(name, tmp_path):
    law = some_law(name)
    whole = simulation(law).run(steps=30, record=tmp_path / "whole.h5", every=4)
    simulation(law).run(steps=15, record=tmp_path / "halves.h5", every=4)
    sim = lm.resume(tmp_path / "halves.h5").run(steps=15)
    assert len(sim.interactions) > 12
    same_bits(whole, sim)
    with lm.io.open_run(tmp_path / "whole.h5") as a, lm.io.open_run(tmp_path / "halves.h5") as b:
        assert len(b.history) == 30
        assert b.steps.tolist() == [0, 4, 8, 12, 16, 20, 24, 28, 30]
        assert lm.io.compare(a, b) is None


@pytest.mark.long
def test_many_parts_with_lists_of_neighbours_made_in_between(tmp_path):
    """Ten parts of 30 steps: grains change neighbours, impulses are carried from list to list."""
    law = lm.Coulomb(friction=0.3)
    whole = simulation(law).run(steps=300)
    assert whole._detector.rebuilds > 3
    path = tmp_path / "parts.h5"
    simulation(law).run(steps=30, record=path)
    for _ in range(9):
        sim = lm.resume(path).run(steps=30)
    same_bits(whole, sim)
    assert sim._detector.rebuilds == whole._detector.rebuilds


def test_functions_of_time_are_asked_for_and_taken(tmp_path):
    functions = {(20, "y"): lambda t: 0.3 * math.cos(50.0 * t)}
    law, path = lm.Coulomb(friction=0.3), tmp_path / "run.h5"
    whole = simulation(law, functions).run(steps=20)
    simulation(law, functions).run(steps=8, record=path)
    with pytest.raises(ValueError, match=r"velocity along 'y' of <Wall 'WALL', body 20.*functions=\{\(20, \"y\"\): f\}"):
        lm.resume(path)
    with pytest.raises(ValueError, match=r"velocity along 'y'.*lmgcpy\.Scene\.from_run takes the same functions"):
        lm.Scene.from_run(path)
    with pytest.raises(ValueError, match=r"names \[\(3, 'x'\)\]"):
        lm.resume(path, functions={**functions, (3, "x"): math.sin})
    with pytest.raises(TypeError, match="must be a function of time"):
        lm.resume(path, functions={(20, "y"): 2.0})
    same_bits(whole, lm.resume(path, functions=functions).run(steps=12))


def test_same_simulation_goes_on_in_its_file_when_named_again(tmp_path):
    law, path = lm.Coulomb(friction=0.3), tmp_path / "run.h5"
    whole = simulation(law).run(steps=20)
    simulation(law).run(steps=5, record=path)
    sim = lm.resume(path)
    sim.run(steps=5)
    sim.run(steps=5, record=path)
    sim.run(duration=5 * sim.time_step)
    same_bits(whole, sim)
    sim.step()
    with pytest.raises(RuntimeError, match="ends with step 20, the simulation is at step 21"):
        sim.run(steps=1)


def test_recording_changes_no_bit_and_may_begin_late(tmp_path):
    law = lm.Coulomb(friction=0.3)
    plain = simulation(law).run(steps=20)
    late = simulation(law).run(steps=7)
    late.run(steps=8, record=tmp_path / "late.h5", every=1, flush=0.0)
    with lm.io.open_run(tmp_path / "late.h5") as run:
        assert run.steps.tolist() == list(range(7, 16))
        assert run.history[:]["step"].tolist() == list(range(8, 16))
    same_bits(plain, lm.resume(tmp_path / "late.h5").run(steps=5))


def test_a_scene_comes_back_from_its_description():
    """Twice described is once described, and the models are equal to the last bit."""
    scene = box(lm.Coulomb(friction=0.3))
    told = describe(scene)
    again = from_description(told)
    np.testing.assert_equal(describe(again), told)
    a, b = scene.compile(), again.compile()
    for name in ("mass", "inverse_mass", "radius", "extent", "weight"):
        assert np.array_equal(getattr(a, name), getattr(b, name)), name
    assert [type(body) for body in again.bodies] == [type(body) for body in scene.bodies]
    assert again.bodies[0].material == lm.Material("sand", density=100.0)


def linked_box(neighbours_collide):
    """Touching beads on a floor, the last linked to the first."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    places = [(0.0, 0.1), (0.2, 0.1), (0.1, 0.1 + 0.1 * math.sqrt(3.0)), (0.05, 0.5)]
    beads = [scene.add(lm.disk(radius=0.1, position=place, mass=1.0)) for place in places]
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.chain(beads[:3], lm.RigidWire(), closed=True, neighbours_collide=neighbours_collide)
    return scene


@pytest.mark.default_parameters("True")
@pytest.mark.parametrize("neighbours_collide", [None, True, False])
def test_a_run_goes_on_with_the_neighbours_that_collide(tmp_path, neighbours_collide):
    path = tmp_path / "run.h5"
    whole = lm.Simulation(linked_box(neighbours_collide), time_step=2e-3).run(steps=100)
    lm.Simulation(linked_box(neighbours_collide), time_step=2e-3).run(steps=40, record=path)
    resumed = lm.resume(path)
    assert resumed.scene.chains[0].neighbours_collide is neighbours_collide
    same_bits(whole, resumed.run(steps=60))
    met = (whole.interactions.law == "coulomb") & (whole.interactions.candidate < 2) & (whole.interactions.antagonist < 3)
    assert met.any() == (neighbours_collide is True)


def test_in_a_description_that_does_not_say_all_linked_neighbours_collide():
    """So did those of runs that were recorded before there was a choice."""
    told = describe(linked_box(None))
    del told["chains"]["neighbours_collide"]
    again = from_description(told)
    assert again.chains[0].neighbours_collide is True
    assert not len(again.compile().apart)


def test_contactors_and_bodies_of_other_classes_come_back_by_their_numbers():
    class Egg(lm.Contactor):
        KIND = "egg"
        shape = (0.1, 0.2, 0.3)
        bounding_radius, area, second_moment = 0.3, 0.1, 0.01

    class Nest(lm.Body):
        mass, inertia, link_radius, extent = 2.0, 0.5, 0.25, 0.4
        contactors = ((Egg(), (0.0, 0.1)),)
        gravity_acts = False

    scene = lm.Scene(dimension=2, gravity=(0, -1))
    nest = scene.add(Nest(position=(1.0, 2.0), color="NEST"))
    bead = scene.add(lm.disk(radius=0.1, position=(3.0, 2.0), mass=1.0))
    scene.chain([nest, bead], lm.RigidRod())
    again = from_description(describe(scene))
    np.testing.assert_equal(describe(again), describe(scene))
    assert again.chains[0].radius_sums.tolist() == [0.35]
    assert not again.compile().weight[0].any()


def test_a_law_that_is_not_registered_is_asked_for(tmp_path):
    class Stranger(type(lm.Signorini())):
        NAME = "stranger"

    path = tmp_path / "run.h5"
    sim = simulation(Stranger())
    sim.run(steps=2, record=path)
    with pytest.raises(LookupError, match="There is no law 'stranger'"):
        lm.resume(path)


def test_a_solver_from_elsewhere_is_asked_for(tmp_path):
    class Patient(lm.GaussSeidel):
        pass

    path = tmp_path / "run.h5"
    sim = lm.Simulation(box(lm.Signorini()), time_step=2e-3, solver=Patient(), on_unconverged="ignore")
    whole = sim.run(steps=2, record=path).run(steps=2)
    with pytest.raises(LookupError, match="solver 'Patient'"):
        lm.resume(path)
    same_bits(whole, lm.resume(path, solver=Patient()).run(steps=2))


@pytest.mark.long
def test_killed_again_and_again(tmp_path):
    """Every file opens, holds what the whole run holds as far as it goes, and leads to the same end (see the script)."""
    script = Path(__file__).parent / "kill_loop.py"
    done = subprocess.run([sys.executable, script, tmp_path, "30"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    killed, files, least, most, mended = map(int, done.stdout.split())
    assert killed >= 10
    assert files >= 10
    assert mended >= 3
    assert least < most


# ------------------------------------------------------------------------------------------- otherwise than before


def column_of_disks(solver=None):
    """Five disks of 1 kg, one on the other, at rest after 40 steps: the contacts bear 5 g, 4 g, ... 1 g."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    for i in range(5):
        scene.add(lm.disk(radius=0.1, position=(0.0, 0.1 + 0.2 * i), mass=1.0))
    scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    return lm.Simulation(scene, time_step=2e-3, solver=solver or lm.GaussSeidel(tolerance=1e-9)).run(steps=40)


def test_in_another_file_a_run_has_the_same_bits_and_the_first_file_stays(tmp_path):
    law, first, other = lm.Coulomb(friction=0.3), tmp_path / "first.h5", tmp_path / "other.h5"
    whole = simulation(law).run(steps=30)
    simulation(law).run(steps=15, record=first, every=4, notes={"batch": 3})
    held = first.read_bytes()
    first.chmod(0o444)
    sim = lm.resume(first, record=other, observe={"height": lambda sim: sim.positions[0, 1]})
    same_bits(whole, sim.run(steps=15))
    assert first.read_bytes() == held
    with lm.io.open_run(other) as run:
        assert run.steps.tolist() == [15, 16, 20, 24, 28, 30]
        assert run.notes == {"batch": 3}
        assert len(run.observed["height"]) == 15
    with pytest.raises(ValueError, match="observes height"):
        lm.resume(other)


@pytest.mark.parametrize("factor", [0.25, 0.7, 3.0])
def test_with_another_time_step_the_forces_are_the_guess(tmp_path, factor):
    """A column at rest: no sweep is needed, the forces stay, and no disk moves; a new scene at the same place starts from
    nothing, and needs many."""
    path = tmp_path / "run.h5"
    before = column_of_disks().run(steps=1, record=path)
    force, height = before.interactions.force[:, 0], before.positions[:5, 1].copy()
    assert sorted(force) == pytest.approx([10.0, 20.0, 30.0, 40.0, 50.0], rel=1e-6)
    sim = lm.resume(path, time_step=factor * 2e-3, record=tmp_path / "other.h5")
    np.testing.assert_array_equal(sim.checkpoint().memory.impulse, before.checkpoint().memory.impulse * factor)
    sim.run(steps=1)
    assert sim.report.iterations <= 1
    np.testing.assert_allclose(sim.interactions.force[:, 0], force, rtol=1e-6)
    sim.run(steps=50)
    np.testing.assert_allclose(sim.positions[:5, 1], height, atol=1e-9)
    anew = lm.Simulation(lm.Scene.from_run(path), time_step=factor * 2e-3, solver=lm.GaussSeidel(tolerance=1e-9))
    anew.run(steps=1)
    assert anew.report.iterations > 10
    with lm.io.open_run(tmp_path / "other.h5") as run:
        assert run.options["time_step"] == factor * 2e-3
        assert run.times[0] == before.time
        assert run.times[-1] == pytest.approx(before.time + 51 * factor * 2e-3)


def test_with_another_solver_a_column_stays_as_it_is(tmp_path):
    path = tmp_path / "run.h5"
    force = column_of_disks().run(steps=1, record=path).interactions.force[:, 0]
    for solver in (lm.Newton(tolerance=1e-8), lm.Auto(tolerance=1e-8)):
        other = tmp_path / f"{type(solver).__name__}.h5"
        sim = lm.resume(path, solver=solver, record=other).run(steps=5)
        np.testing.assert_allclose(sim.interactions.force[:, 0], force, rtol=1e-6)
        assert lm.resume(other).solver == solver


@pytest.fixture
def laws_with_states():
    for law in (Brittle, Touched):
        lm.laws.register(law)
    yield
    for law in (Brittle, Touched):
        lm.laws.registry._laws.pop(law.NAME)


def test_states_of_laws_are_kept_with_another_time_step(tmp_path, laws_with_states):
    """A wire that broke stays broken, its greatest tension stays, and a contact counts its steps on from its birth."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    beads = [scene.add(lm.disk(radius=0.1, position=(0.0, 2.0 - 0.3 * i), mass=1.0)) for i in range(4)]
    beads[0].fix()
    for bead, load in zip(beads[1:], (5.0, 40.0, 20.0), strict=True):
        bead.impose_force(y=-load)
    slider = scene.add(lm.disk(radius=0.1, position=(3.0, 0.1), mass=1.0, velocity=(1.0, 0.0)))
    scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
    scene.see("GRAIN", "WALL", Touched(friction=0.1))
    scene.chain(beads, Brittle(strength=85.0))
    path = tmp_path / "run.h5"
    before = lm.Simulation(scene, time_step=1e-3).run(steps=20, record=path)
    there = before.interactions
    assert there.state["broken"][:3].tolist() == [1.0, 0.0, 0.0]
    sim = lm.resume(path, time_step=4e-4, solver=lm.GaussSeidel(tolerance=1e-8), record=tmp_path / "other.h5").run(steps=5)
    here = sim.interactions
    assert here.state["broken"][:3].tolist() == [1.0, 0.0, 0.0]
    np.testing.assert_array_equal(here.state["greatest"][:3], there.state["greatest"][:3])
    on_floor = np.flatnonzero((here.law == "test-touched") & (here.candidate == slider.id))[0]
    assert here.state["steps"][on_floor] == 25.0
    assert here.state["born"][on_floor] == 0.0


@pytest.mark.parametrize("law", [lm.VoigtWire(stiffness=1e3, viscosity=20.0), lm.ElasticWire(stiffness=1e3)])
def test_a_stretched_wire_stays_stretched_with_another_time_step(tmp_path, law):
    """A load of 10 N stretches the wire by 0.01 m, and hangs still, then as before."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    hook = scene.add(lm.disk(radius=0.1, position=(0.0, 0.0), mass=1.0)).fix()
    load = scene.add(lm.disk(radius=0.1, position=(0.0, -1.01), mass=1.0))
    scene.chain([hook, load], law, reference_gap=0.8)
    path = tmp_path / "run.h5"
    lm.Simulation(scene, time_step=1e-3).run(steps=10, record=path)
    for h in (1e-4, 5e-3):
        sim = lm.resume(path, time_step=h, record=tmp_path / f"{h}.h5").run(steps=20)
        assert sim.positions[1, 1] == pytest.approx(-1.01, abs=1e-10)
        assert -sim.interactions.force[0, 0] == pytest.approx(10.0, rel=1e-7)
        assert sum(sim.energy.stored.values()) == pytest.approx(0.05, rel=1e-6)


@pytest.mark.parametrize("h", [5e-3, 2e-4])
def test_another_time_step_makes_no_energy(tmp_path, h):
    """A ball swings on a spring: at the change of the step it moves by the difference of the steps before the next
    detection, which is no energy that the spring made."""
    scene = lm.Scene(dimension=2)
    hook = scene.add(lm.disk(radius=0.1, position=(0.0, 0.0), mass=1.0)).fix()
    ball = scene.add(lm.disk(radius=0.1, position=(0.0, -1.0), mass=1.0, velocity=(0.0, -1.0)))
    scene.chain([hook, ball], lm.ElasticRod(stiffness=1e3))
    path = tmp_path / "run.h5"
    lm.Simulation(scene, time_step=2e-3).run(steps=12, record=path)
    anew = lm.Simulation(lm.Scene.from_run(path), time_step=h).run(steps=1)
    sim = lm.resume(path, time_step=h, record=tmp_path / "other.h5").run(steps=1)
    np.testing.assert_allclose(sim.positions, anew.positions, rtol=1e-14)
    assert sim.energy.made <= 1e-12
    assert sim.energy.stored == pytest.approx(anew.energy.stored)


@pytest.mark.parametrize(
    ("given", "error", "words"),
    [
        ({"time_step": 1e-3}, ValueError, r"'time_step' is 0.002 in the file and 0.001 here. Give it another file"),
        ({"solver": lm.Auto()}, ValueError, r"'solver' is 'GaussSeidel' in the file and 'Auto' here.*record='another.h5'"),
        ({"solver": lm.GaussSeidel(tolerance=1e-2)}, ValueError, r"'solver_fields tolerance' is .* here"),
        ({"time_step": -1.0, "record": "new.h5"}, ValueError, "time_step must be above 0 s"),
        ({"solver": "auto", "record": "new.h5"}, TypeError, "solver must be a solver"),
        ({"record": "run.h5"}, FileExistsError, "exists: give another name."),
        ({"record": 3}, TypeError, "record must be the path of a file, got 3"),
        ({"record": "nowhere/new.h5"}, FileNotFoundError, "There is no folder"),
    ],
)
def test_what_a_file_cannot_hold_is_refused(tmp_path, monkeypatch, given, error, words):
    monkeypatch.chdir(tmp_path)
    column_of_disks().run(steps=1, record="run.h5")
    with pytest.raises(error, match=words):
        lm.resume("run.h5", **given)
    assert [path.name for path in tmp_path.iterdir()] == ["run.h5"]
    assert lm.resume("run.h5", time_step=2e-3, solver=lm.GaussSeidel(tolerance=1e-9)).run(steps=1).steps == 42


def test_a_file_that_begins_after_a_change_of_the_step_holds_impulses_of_its_own_step(tmp_path):
    """If its writer is killed before the first step, it goes on from the same forces."""
    sim = column_of_disks()
    sim.time_step = 5e-4
    sim.run(steps=0, record=tmp_path / "run.h5")
    whole, again = sim.run(steps=3), lm.resume(tmp_path / "run.h5").run(steps=3)
    same_bits(whole, again)


@pytest.mark.parametrize("count", [-1, 3])
def test_surfaces_that_come_after_bodies_that_are_not_there_are_refused(count):
    scene = lm.Scene(dimension=2)
    nodes = [scene.add(lm.point_mass(position=(0.1 * k, 0.0), mass=1.0)) for k in range(2)]
    scene.chain(nodes, lm.RigidWire(), surface=lm.Thread(0.01))
    with pytest.raises(ValueError, match="come after more bodies than there are"):
        from_description({**describe(scene), "elements_after": count})


@pytest.mark.parametrize("late", [1, 3])
def test_a_run_with_a_thread_goes_on_after_bodies_were_added(tmp_path, late):
    """Contactors keep the numbers by which impulses are remembered: those of late bodies come after the segments."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    nodes = [scene.add(lm.point_mass(position=(0.1 * k, 0.0), mass=0.02)) for k in range(9)]
    nodes[0].fix()
    nodes[-1].fix()
    scene.chain(nodes, lm.ElasticWire(stiffness=2e3), surface=lm.Thread(0.01))
    for k in range(4):
        place = (0.22 + 0.13 * k, 0.065)
        scene.add(lm.disk(radius=0.05, position=place, mass=1.0, velocity=(0.1 * k, -0.2)))
    for other in ("GRAIN", "THREAD"):
        scene.see("GRAIN", other, lm.Coulomb(friction=0.3))
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=1e-9)).run(steps=60)
    for k in range(late):
        scene.add(lm.disk(radius=0.05, position=(0.2 + 0.15 * k, 0.9), mass=1.0))
    file = tmp_path / "run.h5"
    sim.run(steps=20).run(steps=40, record=file, every=10)
    again = lm.resume(file).run(steps=30)
    sim.run(steps=30)
    np.testing.assert_array_equal(again.positions, sim.positions)
    assert len(sim.interactions) > 8


def test_velocities_that_were_written_last_are_known_to_a_file_that_begins_then(tmp_path):
    """A ball at rest is thrown at its floor, with another one above. A checkpoint knows it, too."""

    def made():
        scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
        for k in range(2):
            scene.add(lm.disk(radius=0.1, position=(0.05 * k, 0.1 + 0.2 * k), mass=1.0))
        scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
        for other in ("GRAIN", "WALL"):
            scene.see("GRAIN", other, lm.Coulomb(friction=0.3))
        return lm.Simulation(scene, time_step=1e-3)

    sim = made().run(steps=20)
    sim.velocities[:2, 1] = -1.0
    again = made()
    again.restore(sim.checkpoint())
    sim.run(steps=0, record=tmp_path / "run.h5")
    same_bits(sim.run(steps=5), lm.resume(tmp_path / "run.h5").run(steps=5))
    same_bits(sim, again.run(steps=5))
    assert abs(sim.velocities[0, 1]) < 1e-9  # and it stops, as it should
