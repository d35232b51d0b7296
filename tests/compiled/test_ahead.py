"""The second process that compiles kernels: it is started once, makes kernels that are needed; nothing depends on it."""

import subprocess
import sys
import time

import pytest

from lmgcpy.compiled import ahead as module


@pytest.fixture
def ahead(monkeypatch):
    monkeypatch.setattr(module, "_processors", lambda: 2)
    monkeypatch.setattr(module, "have_locks", lambda: True)
    return module._Ahead()


def after(path, seconds=20.0):
    """Whether a file appears in time."""
    end = time.monotonic() + seconds
    while not path.exists() and time.monotonic() < end:
        time.sleep(0.01)
    return path.exists()


def writes(path):
    return f"import pathlib; pathlib.Path({str(path)!r}).touch()"


def test_it_starts_one_process_which_starts_none(ahead, tmp_path):
    first, second, inner = tmp_path / "first", tmp_path / "second", tmp_path / "inner"
    again = "ahead.would_need('" + writes(inner).replace("'", '"') + "'); ahead.begin()"
    ahead.would_need(f"{again}; {writes(first)}")
    ahead.begin()
    ahead.would_need(writes(second))
    ahead.begin()
    assert after(first)
    assert not after(second, 0.5)
    assert not inner.exists()


@pytest.mark.parametrize("lack", ["statement", "processors", "locks", "interpreter"])
def test_it_starts_none_without(ahead, lack, tmp_path, monkeypatch):
    if lack == "processors":
        monkeypatch.setattr(module, "_processors", lambda: 1)
    elif lack == "locks":
        monkeypatch.setattr(module, "have_locks", lambda: False)
    elif lack == "interpreter":
        monkeypatch.setattr(sys, "executable", "")
    made = module._Ahead()
    if lack != "statement":
        made.would_need(writes(tmp_path / "file"))
    monkeypatch.setattr(subprocess, "Popen", lambda *arguments, **options: pytest.fail("a process was started"))
    made.begin()


def test_a_system_that_starts_no_processes_compiles_by_itself(ahead, monkeypatch):
    def refuse(*arguments, **options):
        raise OSError("no processes")

    monkeypatch.setattr(subprocess, "Popen", refuse)
    ahead.would_need("pass")
    ahead.begin()
    assert ahead.is_over


STEP = """
import lmgcpy as lm
scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
scene.add(lm.disk(radius=0.1, mass=1.0, position=(0.0, 0.1)))
scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
sim = lm.Simulation(scene, time_step=1e-3)
sim.step()
print(*sorted(name.split("-")[0] for name in lm.compiled.statistics().loaded))
print(repr(sim.interactions.force.tolist()))
"""


@pytest.mark.long
def test_with_an_empty_cache_both_processes_make_the_first_step(tmp_path, monkeypatch):
    """The first process takes kernels from the cache, how many depends on the processors; the forces are the same as with
    one process, which takes none."""
    alone = "from lmgcpy.compiled.ahead import ahead; ahead.is_over = True\n"
    answers = []
    for name, text in (("two", STEP), ("one", alone + STEP)):
        monkeypatch.setenv("LMGCPY_CACHE_DIR", str(tmp_path / name))
        done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True)
        answers.append(done.stdout.splitlines())
    (loaded, force), (nothing, same) = answers
    assert loaded
    assert nothing == ""
    assert force == same
