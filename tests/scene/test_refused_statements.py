"""A statement that is refused changes nothing, wherever in it the wrong argument stands."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lmgcpy as lm

WRONG = ["text", math.nan, math.inf, -1e300, None, object(), [1.0, 2.0]]


def everything():
    """A scene with all kinds of bodies that take statements, some of them driven and loaded; the bodies by name."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    bodies = {name: scene.add(lm.disk(radius=0.1, position=(0.3 * i, 0.5), mass=1.0)) for i, name in enumerate("abcd")}
    bodies["wall"] = scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    bodies["piston"] = scene.add(lm.wall(point=(0, 9), normal=(0, -1), mass=5.0))
    for name in ("a", "wall", "piston"):
        bodies[name].impose_velocity(x=0.0, y=0.5)
    bodies["b"].impose_force(x=1.0, spin=2.0)
    scene.chain([bodies["c"], bodies["d"]], lm.RigidWire())
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    return scene, bodies


def in_a_cell():
    scene = lm.Scene(dimension=2)
    bodies = {name: scene.add(lm.disk(radius=0.05, mass=1.0, position=(0.3 * i, 0.3 * i))) for i, name in enumerate("abc")}
    scene.see("GRAIN", "GRAIN", lm.Signorini())
    scene.periodic(x=1.0, y=1.0).impose_rate(xy=1.0, yx=0.5).impose_stress(yy=-10.0)
    return scene, bodies


def is_now(scene):
    """All that statements change."""
    state = scene._state
    return (
        [(body._id, dict(body._velocities), dict(body._forces), body._hidden) for body in scene.bodies],
        np.array(scene.gravity).tolist(),
        scene.rows,
        list(scene.chains),
        None if state is None else (list(state.changes), state.stale, len(state.positions)),
    )


def statements(scene, bodies):
    """Statements by name, each refused because of one of its arguments."""
    refused = {}

    def keywords(what, call, sound):
        """The call with a wrong value in each place, and with a name that there is not, first and last."""
        for name in sound:
            for wrong in WRONG:
                refused[f"{what}({name}={wrong!r})"] = lambda name=name, wrong=wrong: call(**{**sound, name: wrong})
        refused[f"{what}: bogus last"] = lambda: call(**sound, bogus=1.0)
        refused[f"{what}: bogus first"] = lambda: call(bogus=1.0, **sound)

    def names(what, call, *sound):
        for wrong in ("bogus", 3, None):
            for at in range(len(sound) + 1):
                given = (*sound[:at], wrong, *sound[at:])
                refused[f"{what}{given}"] = lambda given=given: call(*given)

    if scene.cell is not None:
        cell = scene.cell
        keywords("cell.impose_rate", cell.impose_rate, {"xx": 1.0, "xy": 2.0, "yy": 0.0})
        keywords("cell.impose_stress", cell.impose_stress, {"xx": 1.0, "xy": 2.0, "yy": 0.0})
        names("cell.fix", cell.fix, "xy", "yy")
        refused["edge.hide"] = scene.bodies[-1].hide
        return refused
    for name, body in bodies.items():
        keywords(f"{name}.impose_velocity", body.impose_velocity, {"y": 0.1, "x": 2.0})
        keywords(f"{name}.impose_force", body.impose_force, {"y": 0.1, "x": 2.0})
        names(f"{name}.fix", body.fix, "y", "x")
        names(f"{name}.free", body.free, "y", "x")
    wall, piston = bodies["wall"], bodies["piston"]
    refused["wall.free"] = wall.free
    refused["wall.free(y)"] = lambda: wall.free("y")
    refused["wall.impose_force(y)"] = lambda: wall.impose_force(y=1.0)
    refused["piston.free(y, spin)"] = lambda: piston.free("y", "spin")
    refused["piston.impose_force(y, spin)"] = lambda: piston.impose_force(y=-1.0, spin=1.0)
    refused["piston.impose_velocity(y, spin)"] = lambda: piston.impose_velocity(y=-1.0, spin=1.0)
    if scene._state is None:
        refused["a: driven, and loaded"] = lambda: bodies["a"].impose_force(spin=1.0, y=1.0)
        refused["b: loaded, and driven"] = lambda: bodies["b"].impose_velocity(y=1.0, x=1.0)
        refused["b: loaded, and fixed"] = bodies["b"].fix
        refused["chain: spin of a loaded one"] = lambda: scene.chain(
            [bodies["a"], bodies["b"]], lm.RigidRod(), block_spin=True
        )
        refused["chain: no rods of that"] = lambda: scene.chain(
            [bodies["a"], bodies["d"]], lm.RigidRod(), reference_gap=math.nan, block_spin=True
        )
        rows = [("GRAIN", "GRAIN", lm.Signorini(), None), ("GRAIN", "WALL", lm.Signorini(), None)]
        for at in range(2):
            for column, wrong in ((0, 3), (1, ""), (2, "law"), (3, -1.0)):
                row = (*rows[at][:column], wrong, *rows[at][column + 1 :])
                table = [*rows[:at], row, *rows[at + 1 :]]
                refused[f"rows[{at}][{column}]"] = lambda table=table: setattr(scene, "rows", table)
    else:
        refused["c is in a chain"] = bodies["c"].hide
        for name in ("a", "piston"):
            force, velocity = bodies[name].impose_force, bodies[name].impose_velocity
            refused[f"{name}: a load of time"] = lambda force=force: force(x=1.0, y=lambda t: 0.0)
            refused[f"{name}: a drive of time"] = lambda velocity=velocity: velocity(x=1.0, y=lambda t: 0.0)
    for wrong in (*WRONG, [1.0, math.nan], [0.0, "text"], [1.0, 2.0, 3.0]):
        if wrong != [1.0, 2.0]:
            refused[f"gravity = {wrong!r}"] = lambda wrong=wrong: setattr(scene, "gravity", wrong)
    radii, positions = [0.1, 0.1], [[5.0, 5.0], [6.0, 6.0]]
    for wrong in WRONG:
        refused[f"add({wrong!r})"] = lambda wrong=wrong: scene.add(wrong)
        if wrong != [1.0, 2.0]:
            refused[f"radii: {wrong!r}"] = lambda wrong=wrong: scene.add_disks([0.1, wrong], positions, masses=1.0)
            refused[f"masses: {wrong!r}"] = lambda wrong=wrong: scene.add_disks(radii, positions, masses=[1.0, wrong])
    refused["add what is there"] = lambda: scene.add(bodies["a"])
    refused["add a sphere"] = lambda: scene.add(lm.sphere(radius=0.1, position=(0, 0, 0), mass=1.0))
    return refused


@pytest.mark.parametrize("between_steps", [False, True])
@pytest.mark.parametrize("make", [everything, in_a_cell])
def test_a_statement_that_is_refused_changes_nothing(make, between_steps):
    """All statements, before a simulation is made and between its steps, with a wrong argument in each place."""
    scene, bodies = make()
    if between_steps:
        lm.Simulation(scene, time_step=1e-4).run(steps=2)
    before, refused = is_now(scene), statements(scene, bodies)
    assert len(refused) > 40
    for name, statement in refused.items():
        with pytest.raises((TypeError, ValueError, RuntimeError)):  # or ``name`` was taken
            statement()
        assert is_now(scene) == before, name


def test_a_run_goes_on_from_its_file_over_a_refused_statement(tmp_path):
    """A wall of no mass that is driven, and is not to be let go: resumed in the middle, and from its file, it is driven on,
    by 0.5 m/s over 60 steps of 1 ms, 0.03 m."""

    def let_go(sim):
        if sim.steps == 10:
            with pytest.raises(ValueError, match="no mass"):
                sim.scene.bodies[4].free()
        if sim.steps == 20:
            sim.scene.gravity = (0.0, -9.8)

    whole = lm.Simulation(everything()[0], time_step=1e-3, overlap="ignore").run(steps=60, on_step=let_go)
    path = tmp_path / "run.h5"
    lm.Simulation(everything()[0], time_step=1e-3, overlap="ignore").run(steps=40, record=path, on_step=let_go)
    again = lm.resume(path).run(steps=20, on_step=let_go)
    assert np.array_equal(whole.state.positions, again.state.positions)
    assert again.positions[4, 1] == pytest.approx(0.03, rel=1e-12)
    for scene in (lm.Scene.from_run(path), whole.scene):
        assert dict(scene.bodies[4]._velocities) == {0: 0.0, 1: 0.5}
