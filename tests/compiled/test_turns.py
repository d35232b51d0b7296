"""Processes that need a kernel at once: one compiles it and the others wait, if it is worth waiting and not for ever.

The other process is a script that stops where it compiles, until it is told to go on.
"""

from __future__ import annotations

import subprocess
import sys
import textwrap
import threading

import numba
import numpy as np
import pytest

from lmgcpy.compiled import cache as files
from lmgcpy.compiled import kernel as kernels
from lmgcpy.compiled import waiting
from lmgcpy.compiled.kernel import CompilerError, kernel, statistics

pytest.importorskip("fcntl")

OTHER = """
import sys, warnings
from test_turns import KERNELS
from lmgcpy.compiled.kernel import CompilerError, kernel, statistics

warnings.simplefilter("ignore")
made = kernel(KERNELS[sys.argv[1]])
compile = made.dispatcher._compiler.compile

def stop_and_compile(*arguments):
    print("compiling", flush=True)
    input()
    return compile(*arguments)

made.dispatcher._compiler.compile = stop_and_compile
try:
    result = made(2.0)
except CompilerError:
    result = None
print(result, len(statistics().loaded), len(statistics().compiled), flush=True)
input()
"""


def cube(x):
    return x * x * x


def square(x):
    return x * x


TABLE = np.ones(200_000)  # numba takes the address of a global array of more than a megabyte
signed = numba.njit("float64(float64)")(square)  # nobody knows what it was compiled from

KERNELS = {
    "kept": cube,
    "known to be of no use to others": lambda x: signed(x) * x,
    "found to be of no use to others": lambda x: TABLE[0] * x * x * x,
    "broken": lambda x: x + nowhere,  # noqa: F821
}


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    """An empty cache, and a process that has no turn and is patient."""
    directory = tmp_path / "cache"
    monkeypatch.setenv("LMGCPY_CACHE_DIR", str(directory))
    monkeypatch.setattr(waiting.turn, "_is_patient", True)
    yield directory
    assert waiting.turn._handle is None


class Other:
    """Another process, that has begun to compile one of the kernels."""

    def __init__(self, what):
        path = f"import sys; sys.path[:0] = {sys.path!r}\n"
        self.process = subprocess.Popen([sys.executable, "-c", path + OTHER, what], stdin=-1, stdout=-1, text=True)
        assert self.line() == "compiling"

    def line(self):
        return self.process.stdout.readline().strip()

    def go_on(self):
        self.process.stdin.write("go on\n")
        self.process.stdin.flush()

    def kill(self):
        self.process.kill()
        self.process.communicate()


@pytest.fixture
def other():
    """Function that starts the other process."""
    started = []

    def start(what):
        started.append(Other(what))
        return started[-1]

    yield start
    for one in started:
        one.kill()


@pytest.fixture
def waits(monkeypatch):
    """Function that takes what is to happen when this process begins to wait, and returns a list: empty if it never did."""
    waited = []

    def when_waiting(act):
        def pause():
            if not waited:
                act()
            waited.append(True)
            sleep()

        monkeypatch.setattr(waiting, "_pause", pause)
        return waited

    sleep = waiting._pause
    return when_waiting


def counted(what):
    """What a kernel, made anew, computes, and how many were loaded and compiled for it."""
    before = statistics()
    result = kernel(KERNELS[what])(2.0)
    after = statistics()
    return result, len(after.loaded) - len(before.loaded), len(after.compiled) - len(before.compiled)


@pytest.mark.long
def test_of_two_processes_one_compiles(other, waits, cache):
    first = other("kept")
    waited = waits(first.go_on)
    assert counted("kept") == (8.0, 1, 0)
    assert waited
    assert first.line() == "8.0 0 1"
    assert len(list(cache.glob("kernels/*"))) == 1


def test_who_dies_while_compiling_keeps_nobody_waiting(other, waits, cache):
    first = other("kept")
    waited = waits(first.kill)
    assert counted("kept") == (8.0, 0, 1)
    assert waited
    assert len(list(cache.glob("kernels/*"))) == 1


@pytest.mark.long
def test_nobody_waits_for_a_kernel_that_will_not_be_kept(other, waits):
    other("known to be of no use to others")
    waited = waits(pytest.fail)
    with pytest.warns(RuntimeWarning, match="cannot be kept"):
        assert counted("known to be of no use to others") == (8.0, 0, 1)
    assert not waited


@pytest.mark.long
@pytest.mark.parametrize("what", ["found to be of no use to others", "broken"])
def test_who_cannot_keep_a_kernel_lets_the_others_go_on(what, other, waits):
    """As soon as that is known, while it lives on. Who waited takes no turn, and waits for nothing else."""
    first = other(what)
    waited = waits(first.go_on)
    if what == "broken":
        with pytest.raises(CompilerError, match="nowhere"):
            counted(what)
    else:
        with pytest.warns(RuntimeWarning, match="reads a global array"):
            assert counted(what) == (8.0, 0, 1)
    assert waited
    assert first.line() == ("None 0 1" if what == "broken" else "8.0 0 1")
    waits(pytest.fail)
    with pytest.raises(CompilerError, match="nowhere"):
        counted("broken")


@pytest.mark.long
def test_other_kernels_are_not_waited_for(other, waits):
    other("broken")
    waits(pytest.fail)
    assert counted("kept") == (8.0, 0, 1)


@pytest.mark.long
def test_nobody_waits_longer_than_a_bound_and_then_never_again(other, waits, monkeypatch, cache):
    monkeypatch.setattr(waiting, "LONGEST", 0.02)
    first = other("kept")
    waited = waits(lambda: None)
    assert counted("kept") == (8.0, 0, 1)
    assert waited
    (path,) = cache.glob("kernels/*")
    path.unlink()
    waits(pytest.fail)
    assert counted("kept") == (8.0, 0, 1)
    first.go_on()
    assert first.line() == "8.0 0 1"


def test_a_kernel_that_is_there_needs_no_turn(monkeypatch):
    assert counted("kept") == (8.0, 0, 1)
    monkeypatch.setattr(waiting.turn, "take", pytest.fail)
    assert counted("kept") == (8.0, 1, 0)


def test_a_kernel_that_another_process_keeps_between_two_looks_is_loaded(monkeypatch):
    """It was not there at the first look, and nobody has the turn any more."""
    counted("kept")
    looks = []
    read = files._read
    monkeypatch.setattr(files, "_read", lambda *given: looks.append(True) if not looks else read(*given))
    assert counted("kept") == (8.0, 1, 0)


def test_ctrl_c_ends_the_turn(monkeypatch):
    """While compiling, and while waiting."""

    def interrupt(*arguments):
        raise KeyboardInterrupt

    made = kernel(cube)
    with monkeypatch.context() as patch:
        patch.setattr(kernels, "_compilable", lambda *given: (given[0], interrupt))
        with pytest.raises(KeyboardInterrupt):
            made(2.0)
    assert waiting.turn._handle is None
    with monkeypatch.context() as patch:
        patch.setattr(waiting, "_lock", lambda *given: False)
        patch.setattr(waiting, "_pause", interrupt)
        with pytest.raises(KeyboardInterrupt):
            kernel(cube)(2.0)
    assert waiting.turn._handle is None
    assert counted("kept") == (8.0, 0, 1)


def test_a_kernel_that_is_called_while_another_is_compiled_ends_the_turn_for_that(monkeypatch, cache):
    """So no process waits that others wait for."""
    outer, inner = kernel(cube), kernel(square)
    compile = outer.dispatcher._compiler.compile
    held = []

    def call_and_compile(*arguments):
        assert waiting.turn._handle is not None
        assert inner(2.0) == 4.0
        held.append(waiting.turn._handle)
        return compile(*arguments)

    outer.dispatcher._compiler.compile = call_and_compile
    assert outer(2.0) == 8.0
    assert held == [None]
    assert len(list(cache.glob("kernels/*"))) == 2


def test_threads_of_a_process_compile_one_kernel_once_and_others_in_turn(cache):
    made = [kernel(cube), kernel(square)]
    results = []
    threads = [threading.Thread(target=lambda k=k: results.append((k, made[k % 2](2.0)))) for k in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    assert sorted(results) == [(k, 4.0 if k % 2 else 8.0) for k in range(6)]
    assert len(list(cache.glob("kernels/*"))) == 2


@pytest.mark.parametrize("missing", ["the module", "locks on this file system", "the right to write the lock file"])
def test_without_locks_kernels_are_compiled_and_kept(missing, monkeypatch, cache):
    def refuse(*arguments):
        raise OSError(37, "No locks available")

    if missing == "the module":
        monkeypatch.setitem(sys.modules, "fcntl", None)
    elif missing == "locks on this file system":
        monkeypatch.setattr("fcntl.lockf", refuse)
    else:
        (cache / "kernels.lock").mkdir(parents=True)  # which nobody can open to write
    assert counted("kept") == (8.0, 0, 1)
    assert counted("kept") == (8.0, 1, 0)


@pytest.mark.long
def test_two_processes_that_start_at_once_compile_each_kernel_once(cache):
    """Nobody is held up: whoever comes first."""
    code = textwrap.dedent("""
        from lmgcpy.compiled.kernel import kernel, statistics
        made = [kernel(lambda x: x + 1.0), kernel(lambda x: x + 2.0), kernel(lambda x: x + 3.0)]
        print("ready", flush=True)
        input()
        assert [one(1.0) for one in made] == [2.0, 3.0, 4.0]
        print(len(statistics().loaded), len(statistics().compiled))
    """)
    group = [subprocess.Popen([sys.executable, "-c", code], stdin=-1, stdout=-1, text=True) for _ in range(2)]
    for one in group:
        assert one.stdout.readline() == "ready\n"
    for one in group:
        one.stdin.write("go\n")
        one.stdin.flush()
    loaded, compiled = zip(*(map(int, one.communicate(timeout=60)[0].split()) for one in group), strict=True)
    assert (sum(loaded), sum(compiled)) == (3, 3)
    assert len(list(cache.glob("kernels/*"))) == 3
