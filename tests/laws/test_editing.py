"""A user's law that is edited between two runs: what runs is what the files say, and nothing else is compiled."""

import json
import os
import subprocess
import sys

import pytest

LAW = """
import lmgcpy as lm
import my_numbers
from my_helper import closing
from my_numbers import SHARE

class Soft(lm.Law):
    NAME = "soft"
    APPLIES_TO = "contact"
    PREPARED = ("bias",)

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        return (max(gap, 0.0) / time_step,)

    @staticmethod
    def react(W, u, prepared):
        return (1.0 * SHARE * my_numbers.MORE * closing(u[0] + prepared[0]) / W[0][0],)
"""
HELPER = """
def closing(u):
    return max(0.0, -u)
"""
NUMBERS = """
SHARE = 1.0
MORE = 1.0
"""
RUN = """
import json
import lmgcpy as lm
from lmgcpy.compiled.kernel import statistics
from my_law import Soft
scene = lm.Scene(dimension=2)
ball = scene.add(lm.disk(radius=0.1, position=(0.0, 0.1), mass=1.0, velocity=(0.0, -1.0)))
scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
scene.see("GRAIN", "WALL", Soft())
lm.Simulation(scene, time_step=1e-3, on_unconverged="ignore", solver=lm.GaussSeidel(max_iterations=1)).run(steps=1)
compiled = [name.split("-")[0].split(" ")[0] for name in statistics().compiled]
print(json.dumps([float(ball.velocity[1]), sorted(compiled)]))
"""


@pytest.fixture
def run(tmp_path):
    for name, text in (("my_law", LAW), ("my_helper", HELPER), ("my_numbers", NUMBERS)):
        (tmp_path / f"{name}.py").write_text(text)
    path = os.pathsep.join([str(tmp_path), *(entry for entry in sys.path if entry)])
    environment = {**os.environ, "PYTHONPATH": path, "LMGCPY_CACHE_DIR": str(tmp_path / "cache")}

    def run():
        done = subprocess.run([sys.executable, "-c", RUN], capture_output=True, text=True, env=environment, timeout=200)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run


def edit(path, old, new):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


@pytest.mark.long
def test_every_edit_is_seen_and_nothing_else_is_compiled_again(run, tmp_path):
    """A ball comes at 1 m/s; one update of the law takes the share of its momentum that the files say."""
    velocity, compiled = run()
    assert velocity == 0.0
    # of the one law that the scene has: its update, its error, its preparation; and what all scenes need once
    assert compiled.count("sweep") == compiled.count("error") == compiled.count("prepare_group") == 1
    assert run() == [0.0, []]
    for name, old, new, expected in (
        ("my_law", "1.0 * SHARE", "0.5 * SHARE", -0.5),
        ("my_helper", "max(0.0, -u)", "max(0.0, -0.5 * u)", -0.75),
        ("my_numbers", "SHARE = 1.0", "SHARE = 0.5", -0.875),
        ("my_numbers", "MORE = 1.0", "MORE = 0.5", -0.9375),
    ):
        edit(tmp_path / f"{name}.py", old, new)
        velocity, compiled = run()
        assert velocity == expected, name
        assert sorted(set(compiled)) == ["error", "sweep"], name
        assert run() == [expected, []]
