"""``NUMBA_DISABLE_JIT=1``: kernels run as plain Python, so that debuggers and coverage see a law's lines.

Each test is a process of its own, as numba reads the variable when it is imported. Warnings are errors there.
"""

import json

import pytest
from soft_law import process, soft_law

SCENES = """
import json, sys
import lmgcpy as lm
import lmgcpy.testing
from lmgcpy.compiled.kernel import statistics

def stack(d):
    scene = lm.Scene(dimension=d, gravity=(0.0,) * (d - 1) + (-9.81,))
    for k in range(3):
        kind = lm.disk if d == 2 else lm.sphere
        scene.add(kind(radius=0.1, position=(0.001 * k,) + (0.0,) * (d - 2) + (0.099 + 0.2 * k,), mass=1.0 + k))
    scene.add(lm.wall(point=(0.0,) * d, normal=(0.0,) * (d - 1) + (1.0,)))
    for other in ("GRAIN", "WALL"):
        scene.see("GRAIN", other, lm.Coulomb(friction=0.3))
    return scene

def wire(d):
    scene = lm.Scene(dimension=d, gravity=(0.0, -9.81) + (0.0,) * (d - 2))
    kind = lm.disk if d == 2 else lm.sphere
    beads = [scene.add(kind(radius=0.1, position=(0.3 * k,) + (0.0,) * (d - 1), mass=1.0)) for k in range(4)]
    beads[0].fix()
    scene.chain(beads, lm.RigidWire())
    return scene
"""


def told(code, check=True, **environment):
    """What a process prints as JSON; with ``check`` off, its errors."""
    done = process(code, check=False, **environment)
    assert (done.returncode == 0) == check, done.stderr
    return json.loads(done.stdout) if check else done.stderr


RUN = """
found = []
for d in (2, 3):
    for make in (stack, wire):
        for solver in (lm.Auto(tolerance=1e-10), lm.GaussSeidel(tolerance=1e-10), lm.Newton(tolerance=1e-10)):
            sim = lm.Simulation(make(d), time_step=1e-3, solver=solver, threads=2).run(steps=3)
            problem = lm.solve(sim.problem(), solver=lm.GaussSeidel(tolerance=1e-10))
            found.append([sim.velocities.ravel().tolist(), problem.impulses.ravel().tolist()])
alone = lm.solve_local([[2.0, 0.5], [0.5, 1.0]], [-1.0, 0.2], friction=0.3)
found.append([alone.impulse.tolist(), alone.velocity.tolist()])
print(json.dumps([found, len(statistics().compiled) + len(statistics().loaded)]))
"""


@pytest.mark.long
def test_steps_and_problems_have_the_answers_of_the_compiled_ones():
    """Stacks and wires in 2D and 3D, by sweeps and by Newton's method: equal up to the tolerance, 1e-10 of about 0.03 N s
    and m/s."""
    plain, kernels = told(SCENES + RUN, NUMBA_DISABLE_JIT="1")
    assert kernels == 0
    compiled, kernels = told(SCENES + RUN, NUMBA_DISABLE_JIT="0")
    assert kernels > 0
    for ours, theirs in zip(plain, compiled, strict=True):
        for one, other in zip(ours, theirs, strict=True):
            assert one == pytest.approx(other, rel=1e-6, abs=1e-10)


@pytest.mark.long
def test_laws_are_checked_as_plain_python():
    code = "print(json.dumps([lm.testing.report(law).conforms for law in (lm.Coulomb(friction=0.3), lm.RigidWire())]))"
    assert told(SCENES + code, NUMBA_DISABLE_JIT="1") == [True, True]


LAW = soft_law("closing") + "\ndef closing(u):\n    BODY\n"
TRACED = """
seen = set()
def trace(frame, event, argument):
    seen.add(frame.f_code)
    return None
scene = falling()
scene.step()  # the first calls of a law are plain ones, compiled or not
sys.settrace(trace)
scene.step()
sys.settrace(None)
print(json.dumps([f.__code__ in seen for f in (Soft.prepare, Soft.react, closing)]))
"""


@pytest.mark.long
def test_a_debugger_sees_a_laws_functions_and_helpers():
    code = SCENES + LAW.replace("BODY", "return max(0.0, -u)") + TRACED
    assert told(code, NUMBA_DISABLE_JIT="1") == [True, True, True]
    assert told(code, NUMBA_DISABLE_JIT="0") == [False, False, False]


@pytest.mark.long
def test_a_law_that_raises_is_named_with_its_cause():
    body = "if u < 0.0:\n        raise ValueError('too fast')\n    return 0.0"
    code = SCENES + LAW.replace("BODY", body) + "falling().step()\n"
    errors = [told(code, check=False, NUMBA_DISABLE_JIT=off).splitlines()[-1] for off in "10"]
    assert errors[0] == errors[1]
    assert "law 'soft' between bodies 0 and 1" in errors[0]


@pytest.mark.long
def test_nothing_is_to_be_warmed_up():
    code = "from lmgcpy.cli import main; main(['warmup'])"
    assert "With NUMBA_DISABLE_JIT set nothing is compiled: unset it" in told(code, check=False, NUMBA_DISABLE_JIT="1")
