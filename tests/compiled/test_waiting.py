"""Who waits is told that kernels are compiled: at a terminal by a line that goes away, elsewhere by one line."""

import io
import time

import pytest

from lmgcpy.compiled import waiting
from lmgcpy.compiled.kernel import kernel


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def started(tmp_path, monkeypatch):
    """A process that has compiled nothing, with an empty cache."""
    monkeypatch.setenv("LMGCPY_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(waiting, "_so_far", waiting._Waiting())


def wait_at(stream, seconds, monkeypatch):
    """What a stream gets while somebody compiles twice, so many seconds each."""
    monkeypatch.setattr("sys.stderr", stream)
    for _ in range(2):
        with waiting.told_to_wait():
            time.sleep(seconds)
    return stream.getvalue()


def test_a_terminal_is_told_after_a_second_and_cleared(started, monkeypatch):
    monkeypatch.setattr(waiting, "PATIENCE", 0.05)
    told = wait_at(Terminal(), 0.2, monkeypatch)
    first, cleared, second, gone, end = told.split("\r")
    assert first == "compiling kernels (once): 1, 0 s so far"
    assert second == "compiling kernels (once): 2, 0 s so far"
    assert cleared == gone == " " * len(first)
    assert end == ""


def test_short_compilations_are_not_told(started, monkeypatch):
    assert wait_at(Terminal(), 0.001, monkeypatch) == ""


def test_a_file_gets_one_line(started, monkeypatch):
    """While two kernels are compiled; a worker of a pool says nothing, as its program has said it."""
    monkeypatch.setattr(waiting, "PATIENCE", 0.0)
    assert wait_at(io.StringIO(), 0.05, monkeypatch) == waiting.ONCE + "\n"
    monkeypatch.setattr(waiting, "_so_far", waiting._Waiting())
    monkeypatch.setattr("multiprocessing.parent_process", lambda: "a program")
    assert wait_at(io.StringIO(), 0.05, monkeypatch) == ""


def test_a_file_gets_no_line_of_short_compilations(started, monkeypatch):
    assert wait_at(io.StringIO(), 0.001, monkeypatch) == ""


def test_a_kernel_is_told_of_once_and_not_when_it_is_loaded(started, monkeypatch):
    monkeypatch.setattr(waiting, "PATIENCE", 0.0)

    def cube(x):
        return x * x * x

    for told in (True, False):
        terminal = Terminal()
        monkeypatch.setattr("sys.stderr", terminal)
        assert kernel(cube)(2.0) == 8.0
        assert ("compiling kernels (once): 1" in terminal.getvalue()) == told
