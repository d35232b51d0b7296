"""Run files where writing fails, and files that were killed and then cut.

A limit on the size of files stands for a disk that is full, a quota, a broken line: HDF5's own writes fail. Each test is a
process of its own, as HDF5 has brought the process down when it was not spared.
"""

import os
import textwrap

import pytest
from forks import forked

import lmgcpy as lm
from lmgcpy.io.run_file.opening import lookup3

resource = pytest.importorskip("resource")

BEGIN = f"""
    import errno, os, resource, signal, sys
    sys.path[:0] = {[os.path.dirname(__file__), os.path.dirname(os.path.dirname(__file__))]!r}
    import numpy as np
    from test_run_file import heap, lm
    path = sys.argv[1]

    def limit(size):
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))

    def refused(make):
        try:
            make()
        except OSError as error:
            return error
        raise AssertionError("it was written")

    heap().run(steps=1, record=path + ".first", flush=0.0, force=True)  # all kernels there: the cache is files too
    heap(solver=lm.GaussSeidel()).run(steps=1)
    limit(resource.RLIM_INFINITY)
"""


def child(code, path):
    """A process that must end as it should, and what it says on standard error."""
    return forked(textwrap.dedent(BEGIN) + textwrap.dedent(code), path).stderr


@pytest.fixture
def path(tmp_path):
    return tmp_path / "run.h5"


@pytest.mark.long
def test_wherever_a_run_is_cut_short_its_file_is_good(path):
    """Limits at which other tables fail: the run stops with a sentence, the file leads to the end of the whole run."""
    said = child(
        """
        whole, done = heap().run(steps=120), set()
        end = whole.checkpoint()
        for size in range(448_000, 556_000, 9_000):
            sim = heap()
            limit(size)
            error = refused(lambda: sim.run(steps=200, record=path, every=1, flush=0.0, force=True))
            limit(resource.RLIM_INFINITY)
            assert "could not be written on" in str(error)
            assert "The simulation stands at the end of its last step" in str(error)
            done.add(sim.steps)
            assert os.path.getsize(path) <= size
            with lm.io.open_run(path) as run:
                assert not run.closed
                assert len(run.history) == sim.steps - 1
                assert run.frame_count == sim.steps
                assert np.isfinite(run.positions[:]).all()
            again = lm.resume(path)
            assert again.steps == sim.steps - 1
            if again.steps < 120:
                again.run(steps=120 - again.steps)
                assert np.array_equal(again.state.positions, end.positions)
                assert again.energy == end.energy
        assert len(done) > 1, done
        """,
        path,
    )
    assert said == ""


def test_a_file_that_cannot_be_made_leaves_nothing_behind(path):
    said = child(
        """
        sim = heap()
        for size in (0, 1_000, 10_000, 20_000, 40_000, 60_000, 100_000, 200_000):
            limit(size)
            error = refused(lambda: sim.run(steps=5, record=path))
            assert "could not be made" in str(error)
            assert sim.steps == 0
            assert not os.path.exists(path) and not os.path.exists(path + ".new")
        limit(resource.RLIM_INFINITY)
        sim.run(steps=5, record=path)
        """,
        path,
    )
    assert said == ""
    with lm.io.open_run(path) as run:
        assert len(run.history) == 5


def test_a_step_that_fails_where_no_more_can_be_written_leaves_a_good_file(path):
    """The number that is not finite is what is raised; the file has what was committed before."""
    said = child(
        """
        scene = lm.Scene(dimension=2)
        disk = scene.add(lm.disk(radius=1.0, position=(0, 0), mass=1.0))
        disk.impose_force(x=lambda t: 1.0 if t < 0.05 else no_more_room())
        def no_more_room():
            limit(os.path.getsize(path))
            return float("nan")
        sim = lm.Simulation(scene, time_step=1e-2)
        try:
            sim.run(steps=10, record=path, every=1, flush=1e9)
        except FloatingPointError:
            limit(resource.RLIM_INFINITY)
        else:
            raise AssertionError
        with lm.io.open_run(path) as run:
            assert len(run.history) == 0
            assert run.frame_count == 1
        """,
        path,
    )
    assert said == ""


KILLED = """
    class Killing(lm.GaussSeidel):
        def solve(self, step):
            steps.append(1)
            if len(steps) == 100:
                os.kill(os.getpid(), signal.SIGKILL)
            return super().solve(step)
    steps = []
    heap(solver=Killing()).run(steps=200, record=path, every=1, flush=0.0)
"""


@pytest.fixture
def killed(path):
    """A file whose writer was killed in its hundredth step."""
    assert forked(textwrap.dedent(BEGIN) + textwrap.dedent(KILLED), path, check=False).returncode == -9
    return path


def test_a_killed_file_that_cannot_be_mended_for_want_of_room_stays_as_it_is(killed):
    before = killed.read_bytes()
    said = child(
        """
        sizes = 1_000, 60_000, os.path.getsize(path) // 2
        for size in sizes:
            sim = lm.resume(path, solver=lm.GaussSeidel())
            limit(size)
            error = refused(lambda: sim.run(steps=1))
            limit(resource.RLIM_INFINITY)
            assert "could not be mended" in str(error), error
            assert not os.path.exists(path + ".mending")
            assert sim.steps == 99
        """,
        killed,
    )
    assert said == ""
    assert killed.read_bytes() == before
    assert lm.resume(killed, solver=lm.GaussSeidel()).run(steps=1).steps == 100


@pytest.mark.long
def test_a_file_that_was_killed_and_then_cut_is_refused_at_once_or_read(killed):
    """HDF5's shared reading would look for what is missing for ever; 2 s are a hundred times what reading takes."""
    child(
        """
        import time
        with lm.io.open_run(path) as run:
            assert len(run.history) == 99
            assert not run.closed
            whole, size = run.positions[:], os.path.getsize(path)
        refused = 0
        for part in np.linspace(0.999, 0.001, 60):
            os.truncate(path, int(part * size))
            begin = time.perf_counter()
            try:
                with lm.io.open_run(path) as run:
                    assert np.array_equal(run.positions[:], whole)
                    assert len(run.history[:]) == 99
                    run.checkpoint()
            except ValueError as error:
                assert "truncated" in str(error), error
                refused += 1
            assert time.perf_counter() - begin < 2.0
        assert refused > 50, refused
        """,
        killed,
    )


@pytest.mark.long
def test_a_killed_file_under_another_hand_is_still_read(killed):
    """While it is locked it counts as being written, and is read in HDF5's shared mode."""
    from lmgcpy.writing import FileLock

    lock = FileLock(killed)
    try:
        with lm.io.open_run(killed) as run:
            assert len(run.history) == 99
    finally:
        lock.release()


def test_the_checksum_is_that_of_hdf5(path):
    """Of a superblock that HDF5 has written, and of texts told by the author of the hash."""
    child("heap().run(steps=1, record=path)", path)
    head = path.read_bytes()[:48]
    assert lookup3(head[:44]) == int.from_bytes(head[44:], "little")
    assert lookup3(b"Four score and seven years ago") == 0x17770551
