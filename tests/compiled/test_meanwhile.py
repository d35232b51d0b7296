"""Steps as plain Python while a copy of the process compiles their kernels. Each test is a process with an empty cache."""

import json
import math
import os
import subprocess
import sys
import types

import numba
import numpy as np
import pytest

from lmgcpy.compiled.ahead import ahead
from lmgcpy.compiled.plain import of_the_system, with_products

pytestmark = pytest.mark.skipif(
    sys.platform != "linux" or not ahead.has_processors(), reason="needs a fork, and a second processor for the copy"
)

WORK = """
import json, os, sys, threading, time
from lmgcpy.compiled.kernel import kernel, statistics
from lmgcpy.compiled.meanwhile import meanwhile
from lmgcpy.compiled.mode import mode
import lmgcpy.compiled.meanwhile as module

@kernel
def square(x):
    return x ** 2

seen = []
def work():
    result = square(1.1)
    seen.append(mode.plain)
    return result
"""


def told(code, tmp_path, **environment):
    """The last line of JSON that a process with an empty cache prints."""
    usual = {name: value for name, value in os.environ.items() if name != "LMGCPY_COMPILE_FIRST"}
    given = {**usual, "LMGCPY_CACHE_DIR": str(tmp_path), **environment}
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], env=given, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def test_work_is_plain_until_the_copy_has_compiled_its_kernels(tmp_path):
    code = """
first = meanwhile.do(work, True)
meanwhile.wait()
second = meanwhile.do(work, True)
print(json.dumps([seen, first, second, len(statistics().loaded), len(statistics().compiled)]))
"""
    product = 1.1 * 1.1
    assert told(WORK + code, tmp_path) == [[True, False], product, product, 1, 0]


@pytest.mark.parametrize("why", ["a thread", "the environment", "stop"])
def test_kernels_are_compiled_first_where_a_copy_is_not_wanted(tmp_path, why):
    begin = {"a thread": "threading.Thread(target=time.sleep, args=(60,), daemon=True).start()", "stop": "meanwhile.stop()"}
    code = begin.get(why, "") + "\nmeanwhile.do(work, True)\nprint(json.dumps([seen, len(statistics().compiled)]))"
    given = {"LMGCPY_COMPILE_FIRST": "1"} if why == "the environment" else {}
    assert told(WORK + code, tmp_path, **given) == [[False], 1]


def test_another_thread_compiles_what_it_lacks(tmp_path):
    """The mode is of the process: a kernel of another thread must not be refused because this one only loads."""
    code = """
begin, found = threading.Event(), []
def other():
    begin.wait()
    found.append(square(2.0))
thread = threading.Thread(target=other)
thread.start()
def meeting():
    begin.set()
    thread.join()
    return work()
meanwhile.do(meeting, True)
print(json.dumps([found, seen]))
"""
    assert told(WORK + code, tmp_path) == [[4.0], [False]]


def test_kernels_are_compiled_here_if_the_copy_fails(tmp_path):
    code = """
here = os.getpid()
def failing():
    if os.getpid() != here:
        raise ValueError
    return work()
meanwhile.do(failing, True)
meanwhile.wait()
meanwhile.do(failing, True)
print(json.dumps([seen, len(statistics().compiled)]))
"""
    assert told(WORK + code, tmp_path) == [[True, False], 1]


def test_a_long_step_of_plain_python_is_the_last(tmp_path):
    code = """
module.LONG = 0.0
meanwhile.do(work, True)
meanwhile.do(work, True)
print(json.dumps(seen))
"""
    assert told(WORK + code, tmp_path) == [True, False]


def test_a_copy_leaves_the_files_of_its_process(tmp_path):
    """The lock of a run file goes with the process that wrote it, and who reads its output need not wait for the copy."""
    code = """
import fcntl
file = open(os.environ["LMGCPY_CACHE_DIR"] + "/locked", "w")
fcntl.flock(file, fcntl.LOCK_EX)
here = os.getpid()
def slow():
    if os.getpid() != here:
        time.sleep(20.0)
    return work()
meanwhile.do(slow, True)
file.close()
file = open(os.environ["LMGCPY_CACHE_DIR"] + "/locked", "w")
fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
file.close()
print(json.dumps(True))
os.kill(meanwhile._copy, 9)
"""
    assert told(WORK + code, tmp_path)


SCENE = """
import hashlib, json
import lmgcpy as lm
from lmgcpy.compiled.kernel import statistics
from lmgcpy.compiled.meanwhile import meanwhile
from lmgcpy.compiled.mode import mode

scene = lm.Scene(dimension=DIMENSION, gravity=(0.3, -9.81, 0.1)[:DIMENSION])
make = lm.disk if DIMENSION == 2 else lm.sphere
grains = []
for k in range(12):
    place = (0.09 * (k % 4), 0.05 + 0.1 * (k // 4), 0.01 * (k % 3))[:DIMENSION]
    grains.append(scene.add(make(radius=0.03 + 0.001 * k, position=place, mass=1.0)))
scene.add(lm.wall(point=(0.0,) * DIMENSION, normal=(0.0, 1.0, 0.0)[:DIMENSION]))
scene.see("GRAIN", "GRAIN", lm.RollingCoulomb(friction=0.4, rolling_friction=0.01))
scene.see("GRAIN", "WALL", lm.Restitution(friction=0.3, restitution=0.5))
scene.chain(grains[4:8], lm.RigidWire())
sim = lm.Simulation(scene, time_step=2e-3)
"""
RUN = """
hashes = []
for _ in range(6):
    sim.run(steps=10)
    parts = sim.positions.tobytes(), sim.velocities.tobytes(), sim.interactions.impulse.tobytes()
    hashes.append(hashlib.sha256(b"".join(parts)).hexdigest())
    if WAITS:
        meanwhile.wait()
print(json.dumps([hashes, len(statistics().loaded), len(statistics().compiled)]))
"""


@pytest.mark.long
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_run_has_the_same_bits_whoever_makes_its_steps(tmp_path, dimension):
    """All steps as plain Python; some so and the rest compiled by copies; all with kernels from the cache."""
    code = (SCENE + RUN).replace("DIMENSION", str(dimension))
    plain, *kernels = told(code.replace("WAITS", "False"), tmp_path, NUMBA_DISABLE_JIT="1")
    assert kernels == [0, 0]
    mixed, loaded, compiled = told(code.replace("WAITS", "True"), tmp_path)
    assert loaded > 10
    assert compiled == 0
    later, loaded, _ = told(code.replace("WAITS", "False"), tmp_path, LMGCPY_COMPILE_FIRST="1")
    assert loaded > 10
    assert plain == mixed == later


@pytest.mark.parametrize(("bodies", "own"), [(3, True), (60, True), (3, False)])
def test_large_scenes_and_laws_of_users_are_compiled_first(tmp_path, bodies, own):
    """A law of a user that cannot be compiled is to be refused at the first step."""
    code = f"""
import json
import lmgcpy as lm

class Mine(lm.Coulomb):
    NAME = "mine"

scene = lm.Scene(dimension=2)
for k in range({bodies}):
    scene.add(lm.disk(radius=0.1, position=(k, 0.0), mass=1.0))
scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3) if {own} else Mine(friction=0.3))
print(json.dumps(lm.Simulation(scene, time_step=1e-3)._is_small))
"""
    assert told(code, tmp_path) == (bodies == 3 and own)


def test_plain_squares_are_products():
    """``pow(x, 2)`` rounds otherwise than ``x * x`` in one of a thousand cases, of which these hold 20 or so."""

    def squares(x, y):
        return (x - y[0]) ** 2 + 2**x - x**3

    plain = types.FunctionType(with_products(squares.__code__), {})
    numbers = np.random.default_rng(0).uniform(0.1, 10.0, 20000).tolist()
    expected = [(x - 1.0) * (x - 1.0) + 2**x - x**3 for x in numbers]
    assert [plain(x, (1.0,)) for x in numbers] == expected
    assert [squares(x, (1.0,)) for x in numbers] != expected


@pytest.mark.parametrize("name", ["math.hypot", "np.hypot", "np.cos", "np.sin", "np.tan", "np.exp", "np.log", "np.sqrt"])
def test_plain_functions_have_the_bits_of_compiled_ones(name):
    module, function = name.split(".")
    names = {"math": math, "np": np}
    arguments = "x, y" if function == "hypot" else "x"
    compiled = numba.njit(eval(f"lambda {arguments}: {name}({arguments})", names))
    plain = getattr(of_the_system(names[module]), function)
    numbers = np.random.default_rng(0).uniform(0.1, 10.0, (2, 5000))
    for x, y in numbers.T.tolist():
        given = (x, y) if function == "hypot" else (x,)
        assert compiled(*given) == plain(*given)
