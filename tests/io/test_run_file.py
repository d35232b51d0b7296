"""The run file: what it holds, while it is written too; what happens to it and to the run when something goes wrong."""

import errno
import json
import logging
import os
import shutil
import signal
import subprocess
import sys
import textwrap
import time
import warnings

import h5py
import numpy as np
import pytest
from click.testing import CliRunner
from columns import unsolved
from forks import forked

import lmgcpy as lm
from lmgcpy.cli import main


def heap(friction=0.4, speed=0.0, **options):
    """Six grains fall on a floor; two of them are tied together."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    grains = [
        scene.add(lm.disk(radius=0.05, position=(0.101 * i, 0.051 + 0.002 * i), mass=1.0, velocity=(speed, 0.0)))
        for i in range(6)
    ]
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=friction))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=friction))
    scene.chain(grains[:2], lm.ElasticWire(stiffness=1e3))
    return lm.Simulation(scene, time_step=2e-3, **options)


def run_cli(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


@pytest.fixture
def path(tmp_path):
    return tmp_path / "run.h5"


# ---------------------------------------------------------------------------------------------------------- contents


def test_the_file_holds_the_run(path):
    """Frames against the states of an unrecorded run of the same scene; history against its reports and energies."""
    heap().run(steps=50, record=path, every=10)
    sim = heap()
    with lm.io.open_run(path) as run:
        assert run.frame_count == 6
        assert run.times.tolist() == pytest.approx(np.arange(6) * 0.02, abs=1e-12)
        assert run.positions.shape == (6, 7, 2)
        assert len(run.interactions(0)) == 0
        history, energy = run.history[:], run.energy
        for k in range(50):
            report = sim.step()
            row = history[k]
            assert row["step"] == k + 1
            assert row["time"] == sim.time
            assert (row["iterations"], row["residual"]) == (report.iterations, report.residual)
            assert row["interactions"] == report.interactions
            assert energy["kinetic"][k] == sim.energy.kinetic
            assert energy["loads"][k] == sim.energy.loads
            assert energy["work"]["coulomb"][k] == sim.energy.interactions.get("coulomb", 0.0)
            assert energy["stored"]["elastic-wire"][k] == sim.energy.stored["elastic-wire"]
            if (k + 1) % 10 == 0:
                frame, net, here = (k + 1) // 10, run.interactions((k + 1) // 10), sim.interactions
                assert np.array_equal(run.positions[frame], sim.positions)
                assert np.array_equal(run.velocities[frame], sim.velocities)
                assert np.array_equal(run.rotations[frame], sim.rotations)
                assert np.array_equal(run.spins[frame], sim.spins)
                for name in ("law", "candidate", "antagonist", "gap", "normal", "frame", "point", "impulse", "force"):
                    assert np.array_equal(getattr(net, name), getattr(here, name)), name
                bounded = np.isfinite(run.extent)[np.column_stack([net.candidate, net.antagonist])]
                np.testing.assert_allclose(net.lever[bounded], here.lever[bounded], atol=1e-15)
        assert run.status.tolist() == ["converged"] * 50
        assert run.closed
        run.scene["laws"].clear()  # of a copy
        assert run.scene["laws"][0] == {"name": "coulomb", "distribution": "lmgcpy", "parameters": {"friction": 0.4}}
        assert run.options["solver"] == "Auto"
        assert run.options["solver_fields"]["tolerance"] == 1e-3
        assert run.versions["numpy"] == np.__version__
        assert set(run.versions) == {"lmgcpy", "numpy", "numba", "h5py", "hdf5", "python", "platform", "machine"}
        assert "7 bodies, 50 steps, 6 frames" in repr(run)
    assert "closed" in repr(run)
    with pytest.raises(ValueError, match="was closed"):
        run.positions[0]


def test_contact_points_are_in_the_middle_of_the_gap(path):
    """A disk 4 mm over a floor, beside another 2 mm away; nothing moves, so the detection is at these places."""
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=0.1, position=(0.5, 0.104), mass=1.0))
    scene.add(lm.disk(radius=0.1, position=(0.702, 0.104), mass=1.0))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.4), alert=0.01)
    scene.see("WALL", "GRAIN", lm.Coulomb(friction=0.4), alert=0.01)
    lm.Simulation(scene, time_step=1e-3).run(steps=1, record=path, every=1)
    with lm.io.open_run(path) as run:
        net = run.interactions(-1)
        assert net.candidate.tolist() == [0, 2, 2]
        np.testing.assert_allclose(net.point, [[0.601, 0.104], [0.5, 0.002], [0.702, 0.002]], atol=1e-15)
        np.testing.assert_allclose(net.lever[0], [[0.101, 0.0], [-0.101, 0.0]], atol=1e-15)


def test_columns_are_indexed_like_arrays(path):
    heap().run(steps=20, record=path, every=2)
    with lm.io.open_run(path) as run:
        whole = np.asarray(run.positions)
        assert whole.shape == (11, 7, 2)
        for key in (0, -1, slice(2, 9, 3), slice(None, None, -2), [3, 1, 1], np.s_[2, 3], np.s_[:, 1:3, 0], np.s_[1:3, 4]):
            assert np.array_equal(run.positions[key], whole[key]), key
        assert np.array_equal(run.positions[whole[:, 0, 0] > 0], whole[whole[:, 0, 0] > 0])
        assert np.array_equal(list(run.rotations), run.rotations[:])
        with pytest.raises(IndexError):
            run.positions[11]
        with pytest.raises(IndexError):
            run.interactions(11)


def test_it_is_plain_hdf5_without_pickles(path):
    """Any HDF5 program reads it; no data set has a type that can hold objects, all texts are JSON."""
    heap().run(steps=5, record=path)
    with h5py.File(path, "r") as file:
        assert file.attrs["format"] == "lmgcpy run"
        items = []
        file.visititems(lambda name, item: items.append(item))
        for item in items:
            if isinstance(item, h5py.Dataset):
                assert item.dtype.kind in "SifubV"
                assert not item.dtype.hasobject
                if item.dtype.kind == "S":
                    json.loads(item[()])


@pytest.mark.long
def test_importing_and_running_need_no_h5py_until_a_file_is_asked_for():
    code = (
        "import sys, lmgcpy as lm\n"
        "scene = lm.Scene(dimension=2)\n"
        "scene.add(lm.disk(radius=1.0, position=(0, 0), mass=1.0))\n"
        "lm.Simulation(scene, time_step=0.1).run(steps=2)\n"
        "assert 'h5py' not in sys.modules\n"
    )
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_a_file_is_read_while_it_is_written(path):
    """By this package, and by another process with HDF5's own reader mode."""
    seen = []

    class Watch(lm.GaussSeidel):
        def solve(self, step):
            if path.exists():
                with lm.io.open_run(path) as run:
                    seen.append((len(run.history), run.frame_count, float(run.positions[-1].sum())))
            return super().solve(step)

    sim = heap(solver=Watch())
    sim.run(steps=10, record=path, every=1, flush=0.0)
    assert [steps for steps, _, _ in seen] == list(range(10))
    assert [frames for _, frames, _ in seen] == list(range(1, 11))
    with lm.io.open_run(path) as run:
        assert [total for _, _, total in seen] == [float(frame.sum()) for frame in run.positions][:10]


def test_refresh_shows_what_came_since(path):
    heap().run(steps=10, record=path)
    sim = lm.resume(path)
    run = lm.io.open_run(path)
    assert not run.hidden(-1).any()
    sim.scene.bodies[5].hide()
    sim.run(steps=10)
    assert run.refresh().frame_count == 3
    assert np.flatnonzero(run.hidden(-1)).tolist() == [5]
    run.close()


# -------------------------------------------------------------------------------------------------- what goes wrong


@pytest.mark.default_parameters(part=(0.02, 0.3, 0.999))
@pytest.mark.parametrize("part", [0.02, 0.1, 0.3, 0.6, 0.9, 0.999])
def test_a_truncated_file_gets_a_sentence_or_is_read(path, part):
    """No other kind of exception, and no wrong number: what is given is what was in the file."""
    heap().run(steps=20, record=path, every=1)
    with lm.io.open_run(path) as run:
        whole = run.positions[:]
    os.truncate(path, int(part * os.path.getsize(path)))
    try:
        with lm.io.open_run(path) as run:
            positions = run.positions[:]
    except ValueError as error:
        assert "truncated" in str(error)  # noqa: PT017
    else:
        assert np.array_equal(positions, whole)


def test_a_checkpoint_that_was_tampered_with_is_not_used(path):
    """With one slot spoilt the other serves; with both a sentence says so."""
    heap().run(steps=10, record=path, flush=0.0)
    with h5py.File(path, "r+") as file:
        newest = max("01", key=lambda slot: file["checkpoint"][slot]["numbers"][0])
        file["checkpoint"][newest]["positions"][0, 0] += 1e-9
    sim = lm.resume(path)
    assert sim.steps in (9, 10)  # the end is in both where nothing came between
    with h5py.File(path, "r+") as file:
        for slot in "01":
            file["checkpoint"][slot]["velocities"][1, 1] += 1e-9
    with pytest.raises(ValueError, match="no complete checkpoint to go on from"):
        lm.resume(path)


def test_an_existing_file_is_kept_unless_forced(path):
    heap().run(steps=3, record=path)
    before = path.read_bytes()
    sim = heap()
    with pytest.raises(FileExistsError, match=r"exists: give another name, force=True to replace it, or lmgcpy\.resume"):
        sim.run(steps=3, record=path)
    assert sim.steps == 0
    assert path.read_bytes() == before
    sim.run(steps=4, record=path, force=True)
    with lm.io.open_run(path) as run:
        assert len(run.history) == 4


def test_a_file_under_another_hand_is_busy(path):
    heap().run(steps=1, record=path)
    take = "import sys; from lmgcpy.writing import FileLock; lock = FileLock(sys.argv[1])"
    hold = f"{take}; print('held', flush=True); input()"
    with subprocess.Popen([sys.executable, "-c", hold, path], stdin=-1, stdout=-1, text=True) as other:
        try:
            assert other.stdout.readline() == "held\n"
            for call in (lambda: lm.resume(path), lambda: heap().run(steps=1, record=path, force=True)):
                with pytest.raises(BlockingIOError, match="is being written by another run"):
                    call()
            assert "being written" in run_cli("info", path).output
        finally:
            other.kill()
    assert lm.resume(path).run(steps=1).steps == 2
    assert "closed normally" in run_cli("info", path).output


def test_a_full_disk_leaves_the_simulation_usable(path, monkeypatch):
    """No room: OSError with the errno of a full disk; the file holds what came before, the run goes on elsewhere."""
    sim, whole = heap(), heap().run(steps=20)
    usage = shutil.disk_usage(path.parent)
    room = iter([usage.free] * 6)
    monkeypatch.setattr(shutil, "disk_usage", lambda place: usage._replace(free=next(room, 1000)))
    with pytest.raises(OSError, match="make room, or record into another file") as caught:
        sim.run(steps=20, record=path, flush=0.0)
    assert caught.value.errno == errno.ENOSPC
    monkeypatch.undo()
    assert sim.steps == 6
    with lm.io.open_run(path) as run:
        assert len(run.history) == 5
        assert not run.closed
    assert lm.resume(path).steps == 5
    sim.run(steps=14, record=path.with_name("second.h5"))
    assert np.array_equal(sim.positions, whole.positions)


@pytest.mark.long
def test_a_write_that_fails_leaves_the_simulation_usable(path, tmp_path):
    """A limit on the size of files stands for what cannot be foreseen: HDF5's own write fails, in a process of its own."""
    code = f"""
        import sys, resource
        sys.path[:0] = {[os.path.dirname(__file__), os.path.dirname(os.path.dirname(__file__))]!r}
        from test_run_file import heap, lm
        import numpy as np
        whole, sim = heap().run(steps=400), heap()
        heap().run(steps=1, record={str(tmp_path / "first.h5")!r})
        resource.setrlimit(resource.RLIMIT_FSIZE, (450_000, resource.RLIM_INFINITY))
        try:
            sim.run(steps=400, record={str(path)!r}, every=1, flush=0.0)
        except OSError as error:
            print(error)
        resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
        assert 3 < sim.steps < 400, sim.steps
        done = sim.steps
        sim.run(steps=400 - sim.steps)
        assert np.array_equal(sim.positions, whole.positions)
        with lm.io.open_run({str(path)!r}) as run:
            assert done - 5 <= len(run.history) < done, (done, run)
        again = lm.resume({str(path)!r})
        again.run(steps=400 - again.steps)
        assert np.array_equal(again.positions, whole.positions)
    """
    done = forked(textwrap.dedent(code), strict=False)
    assert "The simulation stands at the end of its last step" in done.stdout


def test_a_number_that_stops_being_finite_leaves_a_good_file(path):
    """The steps before it are in the file, and lead up to it again."""
    scene = lm.Scene(dimension=2)
    disk = scene.add(lm.disk(radius=1.0, position=(0, 0), mass=1.0))
    load = lambda t: 1.0 if t < 0.05 else np.nan  # noqa: E731
    disk.impose_force(x=load)
    sim = lm.Simulation(scene, time_step=1e-2)
    with pytest.raises(FloatingPointError, match="component x of body 0"):
        sim.run(steps=10, record=path, every=1)
    with lm.io.open_run(path) as run:
        assert len(run.history) == 5
        assert run.frame_count == 6
        assert not run.closed
    assert "killed" not in run_cli("info", path).output
    with pytest.raises(FloatingPointError):
        lm.resume(path, functions={(0, "x"): load}).run(steps=10)
    with lm.io.open_run(path) as run:
        assert len(run.history) == 5


# ------------------------------------------------------------------------------------------------------------ Ctrl-C


class Interrupting(lm.GaussSeidel):
    """Ctrl-C is pressed in the middle of a step."""

    def solve(self, step):
        if len(presses) < 3:
            presses.append(1)
            if len(presses) == 3:
                signal.raise_signal(signal.SIGINT)
        return super().solve(step)


presses: list[int] = []


def test_ctrl_c_ends_between_steps_with_a_good_file(path):
    presses.clear()
    whole = heap(solver=lm.GaussSeidel()).run(steps=10)
    sim = heap(solver=Interrupting())
    with pytest.raises(KeyboardInterrupt, match=r"Interrupted after step 3; go on with: lmgcpy resume .*run.h5 --steps N$"):
        sim.run(steps=10, record=path)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    assert sim.steps == 3
    with lm.io.open_run(path) as run:
        assert run.closed
        assert len(run.history) == 3
    again = lm.resume(path, solver=lm.GaussSeidel()).run(steps=7)
    assert np.array_equal(again.positions, whole.positions)
    sim.run(steps=7)
    assert np.array_equal(sim.positions, whole.positions)


def test_ctrl_c_without_a_file_raises_at_once():
    presses.clear()
    sim = heap(solver=Interrupting())
    with pytest.raises(KeyboardInterrupt, match=r"^$"):
        sim.run(steps=10)
    assert sim.steps == 2


def test_ctrl_c_on_the_command_line_says_one_line(path):
    heap().run(steps=1, record=path, flush=0.0)
    command = [sys.executable, "-m", "lmgcpy.cli", "resume", str(path), "--steps", "100000000"]
    with subprocess.Popen(command, stdout=-1, stderr=-1, text=True) as process:
        for _ in range(300):
            time.sleep(0.05)
            with lm.io.open_run(path) as run:
                if not run.closed:
                    break
        time.sleep(0.2)
        process.send_signal(signal.SIGINT)
        try:
            out, err = process.communicate(timeout=20)
        finally:
            process.kill()
    assert process.returncode == 130
    assert out == ""
    assert len(err.splitlines()) == 1
    assert err.startswith("Interrupted after step ")
    with lm.io.open_run(path) as run:
        assert run.closed
        assert len(run.history) == int(err.split()[3].rstrip(";"))


# ------------------------------------------------------------------------------------------------------ command line


def test_info_says_what_when_how_far_how_good(path):
    heap().run(steps=20, record=path)
    told = run_cli("info", path)
    assert told.exit_code == 0
    for word in ("7 bodies (6 disk, 1 wall)", "coulomb(friction=0.4) from lmgcpy", "20 steps to t = 0.04 s", "3 frames"):
        assert word in told.output
    for word in ("0 of 20 steps not converged, worst residual", "kinetic", "numba", "Auto(", "closed normally"):
        assert word in told.output


@pytest.mark.long
def test_compare_names_the_first_difference(path):
    other = path.with_name("other.h5")
    heap().run(steps=40, record=path)
    heap().run(steps=40, record=other)
    same = run_cli("compare", path, other)
    assert (same.exit_code, same.output) == (0, "They agree to the last bit.\n")
    heap(friction=0.4 * (1 + 1e-9), speed=1e-12).run(steps=40, record=other, force=True)
    differs = run_cli("compare", path, other)
    assert differs.exit_code == 1
    assert "They differ in velocities at t = 0 s, step 0, by 1e-12" in differs.output
    assert "body 0" in differs.output
    assert run_cli("compare", path, other, "--tolerance", "1e-3").exit_code == 0
    assert run_cli("compare", path, other, "--tolerance", "-1").exit_code == 1
    lm.resume(other).run(steps=1)
    longer = run_cli("compare", path, other, "--tolerance", "1e-3")
    assert longer.exit_code == 1
    assert "number of steps as wholes: 40 and 41" in longer.output
    missing = run_cli("compare", path, path.with_name("none.h5"))
    assert missing.exit_code != 0
    assert "There is no file" in missing.output


def test_compare_measures_impulses_by_identity(path):
    """One impulse changed by 0.1 % of the largest: named with its size, and allowed at a tolerance of 1 %."""
    other = path.with_name("other.h5")
    heap().run(steps=20, record=path)
    heap().run(steps=20, record=other)
    with h5py.File(other, "r+") as file:
        net = file["interactions"][:]
        largest = np.abs(net["impulse"]).max()
        row = len(net) - 1
        net["impulse"][row, 0] += 1e-3 * largest
        file["interactions"][:] = net
    with lm.io.open_run(path) as a, lm.io.open_run(other) as b:
        found = lm.io.compare(a, b)
        assert found.quantity == "impulses"
        assert found.step == 20
        assert found.by == pytest.approx(1e-3 * largest)
        assert lm.io.compare(a, b, tolerance=1e-2) is None


def test_export_writes_tables(path, tmp_path):
    heap().run(steps=20, record=path)
    folder = tmp_path / "tables"
    assert run_cli("export", path, "--csv", folder).exit_code == 0
    bodies = np.genfromtxt(folder / "bodies.csv", delimiter=",", skip_header=1)
    net = (folder / "interactions.csv").read_text().splitlines()
    with lm.io.open_run(path) as run:
        assert np.array_equal(bodies[:, 4:6].reshape(3, 7, 2), run.positions[:])
        assert len(net) == 1 + sum(len(run.interactions(k)) for k in range(3))
    assert len((folder / "history.csv").read_text().splitlines()) == 21
    again = run_cli("export", path, "--csv", folder)
    assert again.exit_code != 0
    assert "is not empty" in again.output
    assert run_cli("export", path, "--csv", folder, "--force").exit_code == 0


def test_resume_on_the_command_line(path):
    whole = heap().run(steps=20)
    heap().run(steps=5, record=path)
    done = run_cli("resume", path, "--steps", 15)
    assert done.exit_code == 0, done.output
    assert "20 steps, to t = 0.04 s" in done.output
    with lm.io.open_run(path) as run:
        assert np.array_equal(run.positions[-1], whole.positions)
    assert run_cli("resume", path, "--steps", -1).exit_code != 0
    for command in (("info",), ("resume", "--steps", "1"), ("export", "--csv", "x")):
        told = run_cli(*command, path.with_name("none.h5"))
        assert told.exit_code != 0
        assert "There is no file" in told.output
        assert "Traceback" not in told.output


# ------------------------------------------------------------------------------------------------------ how it goes


def stack(**options):
    return unsolved(6, radius=0.05, **options)


def test_unconverged_steps_are_counted_and_said_once():
    sim = stack()
    with pytest.warns(
        RuntimeWarning, match=r"of 20 steps did not reach the solver's tolerance; the worst residual"
    ) as told:
        sim.run(steps=20)
    assert len(told) == 1
    assert sim.unconverged_steps > 0
    assert f"{sim.unconverged_steps} of 20" in str(told[0].message)
    assert f"{sim.worst_residual:.2e}" in str(told[0].message)
    quiet = stack(on_unconverged="ignore").run(steps=20)
    assert quiet.unconverged_steps == sim.unconverged_steps


def test_unconverged_steps_can_stop_the_run(path):
    sim = stack(on_unconverged="stop")
    with pytest.raises(RuntimeError, match=r"^Step \d+, to t = .* was not solved: budget spent"):
        sim.run(steps=20, record=path)
    with lm.io.open_run(path) as run:
        assert len(run.history) == sim.steps < 20
        assert run.unconverged_steps == 1
        assert run.closed
    with pytest.raises(ValueError, match="did you mean 'warn'"):
        heap(on_unconverged="wran")


def test_a_grain_too_fast_for_the_time_step_is_said_once():
    """30 m/s and 2 ms make 60 mm, radius 50 mm: a step of 2 ms 25/60 would do."""
    sim = heap(speed=30.0)
    with pytest.warns(
        RuntimeWarning, match=r"body 0 moves by 0.06 m, more than half its radius of 0.05 m.*0.00083 s"
    ) as told:
        sim.run(steps=5)
    assert len(told) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sim.run(steps=5)
        heap(speed=10.0).run(steps=5)


def test_a_summary_line_is_logged(caplog):
    with caplog.at_level(logging.INFO, logger="lmgcpy"):
        heap().run(steps=20)
    (line,) = [record.getMessage() for record in caplog.records]
    assert line.startswith("20 steps to t = 0.04 s in ")
    assert "7 bodies" in line
    assert "0 steps not converged" in line
