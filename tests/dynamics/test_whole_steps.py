"""A step is whole or it is not there, wherever an error or a signal ends it."""

from __future__ import annotations

import gc
import os
import random
import signal
import sys
from dataclasses import replace

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.dynamics.stepper import CHANGED
from lmgcpy.scene import body
from lmgcpy.simulation.simulation import between_steps

PACKAGE = os.path.dirname(lm.__file__)
TAIL = 40
"""The last lines or instructions of a step, all of which are interrupted: more than follow the one that makes it whole."""


@pytest.fixture
def no_garbage():
    """Garbage is collected before the test, and not in it. A generator of the package that another test has left suspended,
    in a cycle, ends as garbage is collected: its lines would count, and an interruption in one of them is lost."""
    gc.collect()
    gc.disable()
    yield
    gc.enable()


class Interruption(BaseException):
    """What no line of the package catches by name."""


def interrupted(call, at, opcodes=False):
    """Whether ``call()`` came to its line number ``at`` in the package, counted from 0, where it was interrupted; with
    ``opcodes``, to that instruction."""
    left = at

    def trace(frame, event, _):
        nonlocal left
        if not frame.f_code.co_filename.startswith(PACKAGE):
            return None
        frame.f_trace_opcodes = opcodes
        if event == ("opcode" if opcodes else "line"):
            left -= 1
            if left < 0:
                raise Interruption
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        call()
    except Interruption:
        return True
    finally:
        sys.settrace(before)
    return False


def count_lines(call, opcodes=False):
    """Number of lines in the package that ``call()`` comes to."""
    count = 0

    def trace(frame, event, _):
        nonlocal count
        if not frame.f_code.co_filename.startswith(PACKAGE):
            return None
        frame.f_trace_opcodes = opcodes
        count += event == ("opcode" if opcodes else "line")
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        call()
    finally:
        sys.settrace(before)
    return count


def everything(sim):
    """All that a step changes, as numbers and words that can be compared."""
    driven = sim._driven_overlaps
    memory = vars(sim._detector.give_memory())
    arrays = sim.positions, sim.state.positions, sim.velocities, sim.state.velocities, sim._turning_stretch.predicted
    return (
        *(array.tobytes() for array in (*arrays, *(v for v in memory.values() if isinstance(v, np.ndarray)))),
        *(repr(value) for value in memory.values() if not isinstance(value, np.ndarray)),
        (sim.time, sim.steps, sim.state.steps, sim.state.stale, len(sim.model.mass), len(sim.state.changes)),
        (sim.unconverged_steps, sim.worst_residual, sim.worst_slip, sim._said._names),
        repr(vars(sim.energy)),
        repr(replace(sim.report, seconds=0.0, step_seconds=0.0)),
        (sim._watch._stretched, sim._watch.stretch, driven._pairs.tobytes(), driven._least.tobytes()),
    )


def new_scene(gravity=(0.0, 0.0)):
    """A plane scene whose bodies begin a block of rows: a block that other tests have filled would end among them,
    and a step that copies two blocks comes to more lines."""
    rows = body._start_rows
    rows.taken = len(rows.block)
    return lm.Scene(dimension=2, gravity=gravity)


def thrown_together(changed):
    """Grains and a wire with a heavy end that fall on a floor, in fast steps: new neighbours, turning links, unsolved
    steps, and sentences about them. ``changed``: with statements that the next step takes up."""
    rng = np.random.default_rng(3)
    scene = new_scene(gravity=(0.0, -9.81))
    for i in range(6):
        position = (0.21 * (i % 3), 0.11 + 0.2 * (i // 3))
        scene.add(lm.disk(radius=0.1, mass=1.0, position=position, velocity=rng.normal(0.0, 2.0, 2)))
    beads = [lm.disk(radius=0.02, mass=0.01, position=(0.05 * i, 0.7), color="BEAD") for i in range(4)]
    beads[0].fix()
    beads.append(lm.disk(radius=0.05, mass=5.0, position=(0.22, 0.72), velocity=(3.0, 2.0), color="BEAD"))
    scene.chain([scene.add(bead) for bead in beads], lm.RigidWire())
    floor = scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.4))
    scene.see("GRAIN", "WALL", lm.Restitution(restitution=0.5, friction=0.4))
    solver = lm.GaussSeidel(tolerance=1e-9, max_iterations=3)
    sim = lm.Simulation(scene, time_step=2e-2, solver=solver, overlap="ignore", on_unconverged="ignore")
    sim.run(steps=3)
    if changed:
        scene.bodies[1].hide()
        floor.impose_velocity(y=0.3)
        scene.add(lm.disk(radius=0.1, mass=1.0, position=(0.0, 3.0)))
    return sim


def in_a_cell(changed):
    """A cell that yields, whose edges are straightened as it is sheared."""
    scene = new_scene()
    for i in range(9):
        scene.add(lm.disk(radius=0.1, mass=1.0, position=(0.3 * (i % 3), 0.3 * (i // 3)), velocity=(0.5 - i % 2, 0.3)))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.periodic(x=0.9, y=0.9).impose_rate(xy=8.0).impose_stress(yy=-100.0)
    sim = lm.Simulation(scene, time_step=1e-2, on_unconverged="ignore").run(steps=6)
    if changed:
        scene.cell.impose_rate(xy=20.0)
    return sim


SCENES = {"thrown together": thrown_together, "in a cell": in_a_cell}


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_generators_that_others_left_do_not_count(no_garbage):
    """They are garbage that would be collected at any line."""
    thrown_together(True).step()
    once = count_lines(thrown_together(True).step)
    for _ in range(3):
        suspended = between_steps.__wrapped__()
        next(suspended)
        cycle = [suspended]
        cycle.append(cycle)
        del suspended, cycle
    assert count_lines(thrown_together(True).step) == once
    assert count_lines(gc.collect) >= 3


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.default_parameters("499-False-thrown together-True")
@pytest.mark.parametrize("changed", [False, True])
@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize(("every", "opcodes"), [(499, False), (1, False), (11, True)])
def test_a_step_that_is_interrupted_at_any_line_is_whole_or_not_there(name, changed, every, opcodes, no_garbage):
    """At each line in turn, or ``every`` so many and the last ones: afterwards everything is as before the step or as after
    it, to the last bit. And in the end the step gives what it gives at once."""
    make = SCENES[name]
    sim, once = make(changed), make(changed)
    before = everything(sim)
    once.step()
    after = everything(once)
    assert before == everything(make(changed)) != after
    lines = count_lines(make(changed).step, opcodes)
    assert lines > 500
    whole = []
    for line in sorted({*range(0, lines, every), *range(lines - TAIL, lines)}):
        assert interrupted(sim.step, line, opcodes)
        now = everything(sim)
        assert now in (before, after), f"torn at line {line}"
        if now == after:
            whole.append(line)
            sim = make(changed)
    assert 0 < len(whole) < TAIL
    sim.step()
    assert everything(sim) == after


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("call", ["step", "restore"])
@pytest.mark.parametrize("name", SCENES)
def test_all_that_a_step_sets_is_put_back_where_it_fails(name, call):
    """An attribute that a step sets and the list does not name would stay."""
    sim = SCENES[name](True)
    checkpoint = SCENES[name](False).checkpoint()
    if call == "restore" and len(checkpoint.positions) < len(sim.scene.bodies):
        checkpoint = sim.checkpoint()
    before = vars(sim).copy()
    sim.step() if call == "step" else sim.restore(checkpoint)
    changed = {attribute for attribute, value in vars(sim).items() if value is not before.get(attribute)}
    assert changed <= {*CHANGED, "_detector", "_assembler"}
    assert "report" in changed


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("every", [499, pytest.param(1, marks=pytest.mark.long)])
def test_a_restore_that_is_interrupted_is_whole_or_not_there(every, no_garbage):
    """The same of ``restore``, over statements that it takes back."""
    sim = thrown_together(False)
    sim.state.velocities[0] += 1.0
    checkpoint = sim.checkpoint()
    aim = thrown_together(False)
    aim.restore(checkpoint)
    after = everything(aim)
    sim.scene.bodies[1].hide()
    sim.step()
    lines = count_lines(lambda: sim.restore(checkpoint))
    sim.scene.bodies[1].hide()
    sim.step()
    before = everything(sim)
    for line in sorted({*range(0, lines, every), *range(lines - TAIL, lines)}):
        if not interrupted(lambda: sim.restore(checkpoint), line):
            break  # there is nothing to go through any more
        now = everything(sim)
        assert now[:-1] in (before[:-1], after[:-1]), f"torn at line {line}"  # what was said stays said
        assert sim.scene.bodies[1].hidden == (now[:-1] == before[:-1])
    assert not sim.scene.bodies[1].hidden


def storms(count, seed):
    """Number of runs that end with other bits than one that nothing interrupts, of ``count`` that signals hit: up to three,
    20 us apart."""
    whole = thrown_together(False).run(steps=40)
    rng, torn, left = random.Random(seed), 0, 0

    def ring(*_):
        nonlocal left
        left -= 1
        if left >= 0:
            raise Interruption

    def hit(sim):
        nonlocal left
        left = rng.randint(1, 3)
        signal.setitimer(signal.ITIMER_REAL, rng.uniform(5e-4, 2e-2), 2e-5)
        try:
            sim.run(steps=whole.steps - sim.steps)
            left = 0
        except Interruption:
            left = 0
            return True
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
        return False

    usual = signal.signal(signal.SIGALRM, ring)
    try:
        hits = 0
        while hits < count:
            sim = thrown_together(False)
            try:
                came = hit(sim)
            except Interruption:  # on the way out
                came = True
            hits += came
            left = 0
            sim.checkpoint()  # a way back that three signals ended is gone to its end
            sim.run(steps=whole.steps - sim.steps)
            torn += everything(sim) != everything(whole)
    finally:
        signal.signal(signal.SIGALRM, usual)
    return torn


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # in hypothesis, as garbage is collected
@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="Windows has no timers that send signals")
@pytest.mark.parametrize("count", [5, 1000])
def test_runs_that_signals_interrupt_go_on_as_if_nothing_had_been(count):
    """Real signals at random times, some of them while the first one is still on its way out of the step."""
    assert storms(count, seed=25) == 0
