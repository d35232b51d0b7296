"""Kill a recording run again and again and look at what it leaves; a script, as it forks: ``kill_loop.py FOLDER TURNS``.

A child records with a commit at every step until it is killed, after a time that grows from turn to turn so that all of
the making of the file, the steps and the mending of a killed file are hit. Then the file is opened and must hold what a
run without interruption holds, as far as it goes; every third turn goes on with the killed file, the others begin anew.
"""

import math
import os
import signal
import sys
import time
import warnings

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

import numpy as np
from mixed_scene import mixed_scene

import lmgcpy as lm

warnings.simplefilter("ignore")
STEPS = 30
FUNCTIONS = {
    (20, "spin"): lambda t: 10.0 * math.sin(5.0 * t),
    (21, "x"): lambda t: 30.0 * math.cos(7.0 * t),
    (44, "y"): lambda t: 0.3 * math.cos(20.0 * t),
}
OBSERVE = {"energy": lambda sim: sim.energy.mechanical, "places": lambda sim: sim.positions[:5]}
SOLVER = lm.GaussSeidel(tolerance=1e-2)


def begin(path):
    sim = lm.Simulation(mixed_scene(), time_step=1e-3, solver=SOLVER)
    return sim.run(steps=STEPS, record=path, every=3, flush=0.0, force=True, observe=OBSERVE)


def go_on(path):
    sim = lm.resume(path, functions=FUNCTIONS, observe=OBSERVE)
    return sim.run(steps=STEPS - sim.steps)


def compare(path, whole, history):
    """Steps in the file, which must be those of the whole run."""
    with lm.io.open_run(path) as run:
        count, frames = len(run.history), run.frame_count
        assert np.array_equal(run.positions[:], whole.positions[:frames])
        assert np.array_equal(run.velocities[:], whole.velocities[:frames])
        for frame in range(frames):
            assert np.array_equal(run.interactions(frame).impulse, whole.interactions(frame).impulse)
        assert np.array_equal(run.history[:]["residual"], history["residual"][:count])
        for name, column in run.observed.items():
            assert np.array_equal(column[:], whole.observed[name][:count])
        assert frames == 1 + count // 3, (frames, count)  # written and committed together
        assert abs(run.checkpoint().steps - count) <= 1
        return count


def main(folder, turns):
    whole_path, path = os.path.join(folder, "whole.h5"), os.path.join(folder, "run.h5")
    end = begin(whole_path).checkpoint()
    start = time.perf_counter()
    begin(whole_path)
    seconds = time.perf_counter() - start
    whole = lm.io.open_run(whole_path)
    history = whole.history[:]
    killed, reached, mended = 0, [], 0
    for turn in range(turns):
        again = turn % 3 == 2 and os.path.exists(path)
        child = os.fork()
        if child == 0:
            (go_on if again else begin)(path)
            os._exit(0)
        time.sleep(1.3 * seconds * (turn + 0.5) / turns)
        os.kill(child, signal.SIGKILL)
        killed += os.waitpid(child, 0)[1] == signal.SIGKILL
        if os.path.exists(path):
            reached.append(compare(path, whole, history))
            mended += again
        if turn % 10 == 9 and os.path.exists(path):
            sim = go_on(path)
            assert compare(path, whole, history) == STEPS
            assert np.array_equal(sim.state.positions, end.positions)
            assert np.array_equal(sim.state.velocities, end.velocities)
            assert np.array_equal(sim._detector.give_memory().impulse, end.memory.impulse)
            assert np.array_equal(sim._detector.give_memory().identity, end.memory.identity)
            assert sim.energy == end.energy
    print(killed, len(reached), min(reached), max(reached), mended)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
