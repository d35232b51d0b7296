"""Run files that are damaged or hostile: what is read is what was recorded, or a sentence names what is not.

The tries of ``run_fuzz`` are made in processes of their own. Each is known by its seed and its number:
``python tests/io/run_fuzz.py FOLDER SEED FIRST STOP`` makes it again.
"""

import shutil
import zlib
from pathlib import Path

import h5py
import numpy as np
import pytest
from run_fuzz import height, simulation
from test_damaged_problems import ends

import lmgcpy as lm
from lmgcpy.io.run_file.commits import read_commit
from lmgcpy.io.run_file.trees import digest

FUZZ = Path(__file__).parent / "run_fuzz.py"


def assert_sound(told, tries):
    wrong = [each for each in told if each[2] not in ("refused", "read")]
    assert not wrong, wrong
    assert len(told) == tries
    assert {end for _, _, end in told} == {"refused", "read"}


@pytest.mark.long
def test_damaged_files_are_refused_or_read_as_they_were(tmp_path):
    """Of 270 damaged files, before there were checksums, 33 read as something else."""
    assert_sound(ends(tmp_path, 3, 0, 60, FUZZ), 60)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(20, 28))
def test_two_thousand_damaged_files_are_refused_or_read_as_they_were(tmp_path, seed):
    assert_sound(ends(tmp_path, seed, 0, 250, FUZZ), 250)


# ---------------------------------------------------------------------------------------------------------- by hand


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    """A run of 400 steps with a frame each: several chunks of positions."""
    path = tmp_path_factory.mktemp("sound") / "run.h5"
    simulation(2).run(steps=400, record=path, every=1, observe={"height": height})
    return path


@pytest.fixture
def path(sound, tmp_path):
    """Its file, to be damaged."""
    return Path(shutil.copy(sound, tmp_path / "run.h5"))


def flip(path, place):
    data = bytearray(path.read_bytes())
    data[place] ^= 1
    path.write_bytes(data)


def chunk_of(path, name, row):
    """Where a row of a table lies in the file, and the first and last row of its chunk."""
    with h5py.File(path, "r", locking=False) as file:
        table = file[name]
        first = row // table.chunks[0] * table.chunks[0]
        info = table.id.get_chunk_info_by_coord((first, *(0,) * (table.ndim - 1)))
        inside = (row - first) * table.dtype.itemsize * int(np.prod(table.shape[1:], dtype=int))
        return info.byte_offset + inside, first, min(first + table.chunks[0], len(table)) - 1


@pytest.mark.default_parameters("interactions")
@pytest.mark.parametrize("name", ["frames/positions", "frames/velocities", "interactions", "history", "observed/height"])
def test_damage_is_named_and_the_rest_can_be_read(path, name):
    whole = {}
    with lm.io.open_run(path) as run:
        whole["positions"], whole["steps"] = run.positions[:], run.history[:]["step"]
        first_of_frame = [len(run.interactions(frame)) for frame in range(run.frame_count)]
    place, first, last = chunk_of(path, name, 3)
    flip(path, place)
    with lm.io.open_run(path) as run:
        read = {
            "frames/positions": lambda frame: run.positions[frame],
            "frames/velocities": lambda frame: run.velocities[frame],
            "interactions": lambda frame: run.interactions(frame),
            "history": lambda step: run.history[step],
            "observed/height": lambda step: run.observed["height"][step],
        }[name]
        with pytest.raises(ValueError, match=rf"is damaged: (frames|steps) .*of '{name}' cannot be read") as caught:
            read(3)
        if name == "interactions":
            last = int(np.searchsorted(np.cumsum(first_of_frame), last, "right"))
            first = int(np.flatnonzero(first_of_frame)[0])
        assert f" {first} to {last} of" in str(caught.value)
        if not name.startswith(("history", "observed")):  # whose 400 rows are one chunk
            read(400)
        if name != "frames/positions":
            np.testing.assert_array_equal(run.positions[:], whole["positions"])
        if name != "history":
            np.testing.assert_array_equal(run.history[:]["step"], whole["steps"])


def test_another_scene_is_not_resumed(path):
    """A number of the scene, by damage; with the right digest it is another scene, and may be."""
    with h5py.File(path, "r+", locking=False) as file:
        file["scene/bodies/mass"][1] *= 2.0
    with lm.io.open_run(path) as run:
        assert len(run.positions[:]) == 401
        with pytest.raises(ValueError, match="'scene' is not what was written, by its digest"):
            _ = run.scene
    with pytest.raises(ValueError, match="'scene' is not what was written, by its digest"):
        lm.resume(path, observe={"height": height})
    with h5py.File(path, "r+", locking=False) as file:
        file["scene"].attrs["digest"] = digest(file["scene"])
    assert lm.resume(path, observe={"height": height}).steps == 400


@pytest.mark.long
def test_the_last_chunk_of_a_file_that_was_not_closed_has_a_sum_of_its_own(tmp_path):
    """Its checksum may be that of another moment: what counts in it is read, and is not where a bit of it is another."""
    path = tmp_path / "dead.h5"

    def die(sim):
        if sim.steps == 30:
            path.write_bytes((tmp_path / "run.h5").read_bytes())
        return False

    simulation(2).run(steps=40, record=tmp_path / "run.h5", every=1, flush=0.0, until=die)
    with lm.io.open_run(path) as run:
        assert not run.closed
        positions = run.positions[:]
    with lm.io.open_run(tmp_path / "run.h5") as run:
        np.testing.assert_array_equal(run.positions[: len(positions)], positions)
    from lmgcpy.io.run_file.opening import UnclosedFile

    with h5py.File(UnclosedFile(path), "r") as file:
        table = file["frames/positions"]
        info = table.id.get_chunk_info_by_coord((0, 0, 0))
        rows = read_commit(file).frames
        row = 8 * int(np.prod(table.shape[1:]))
    assert rows < table_rows(path)
    flip(path, info.byte_offset + info.size - 1)  # of the checksum
    with lm.io.open_run(path) as run:
        np.testing.assert_array_equal(run.positions[:], positions)
    flip(path, info.byte_offset + 2 * row)
    with (
        lm.io.open_run(path) as run,
        pytest.raises(ValueError, match=r"frames 0 to \d+ of 'frames/positions' cannot be read"),
    ):
        _ = run.positions[:]


def table_rows(path):
    from lmgcpy.io.run_file.opening import UnclosedFile

    with h5py.File(UnclosedFile(path), "r") as file:
        return file["frames/positions"].chunks[0]


def change(path, name, make):
    with h5py.File(path, "r+", locking=False) as file:
        if name in file:
            del file[name]
        make(file, name)


def plug_in(file, name):
    """A filter whose code HDF5 would look for in a folder of plug-ins."""
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_chunk((1,))
    properties.set_filter(32_004, h5py.h5z.FLAG_OPTIONAL)
    h5py.h5d.create(file.id, name.encode(), h5py.h5t.NATIVE_DOUBLE, h5py.h5s.create_simple((5,)), properties)


def huge(file, name):
    file.create_dataset(name, (10**11, 8, 3), "f8", chunks=(100, 8, 3), maxshape=(None, 8, 3))


def commit(file, _):
    """Frames without end, with the right sum."""
    row = np.array([10**6, 10**11, 0, 0, 1, 0])
    row[-1] = zlib.crc32(row[:-1].tobytes())
    file.create_dataset("commits", data=np.array([row, row]))


BY_HAND = {
    "external link": ("frames/positions", lambda f, n: f.__setitem__(n, h5py.ExternalLink("/etc/passwd", "/")),
        "is a link to"),
    "soft link": ("history", lambda f, n: f.__setitem__(n, h5py.SoftLink("/frames/index")), "history is a link to"),
    "filter": ("frames/positions", plug_in, "is packed by filter 32004, which is not read"),
    "without end": ("frames/positions", huge, "is said to have shape"),
    "rows without end": ("frames/velocities", lambda f, n: f.create_dataset(n, (10**14, 8, 3), "f8", chunks=(100, 8, 3),
        maxshape=(None, 8, 3)), "is said to have shape"),
    "commit without end": ("commits", commit, "'frames/index' lacks entries"),
    "scene's table without end": ("scene/bodies/mass", lambda f, n: f.create_dataset(n, (10**11,), "f8", chunks=(100,)),
        "is said to have shape"),
    "words for numbers": ("history", lambda f, n: f.create_dataset(n, data=np.full((401, 8), b"x"), chunks=True),
        "'history' is of type"),
    "group for a table": ("frames/index", lambda f, n: f.create_group(n), "frames/index"),
    "two components": ("frames/velocities", lambda f, n: f.create_dataset(n, data=np.ones((401, 8, 2)), chunks=True),
        "has 2 components, not 3 or 6"),
    "seven numbers in the plane": ("frames/positions",
        lambda f, n: f.create_dataset(n, data=np.ones((401, 8, 7)), chunks=True),
        "is of shape .401, 8, 7., where 3 numbers a body were written"),
    "positions of no body": ("frames/positions", lambda f, n: f.create_dataset(n, data=np.ones((401, 8)), chunks=True),
        "is of shape .401, 8., where 3 numbers a body were written"),
    "no laws": ("about/laws", lambda f, n: f.create_dataset(n, data=np.bytes_(b"3")), "'about' is not what was written"),
}  # fmt: skip


@pytest.mark.parametrize("name", BY_HAND)
def test_a_file_made_by_hand(path, name):
    place, make, words = BY_HAND[name]
    change(path, place, make)
    with pytest.raises(ValueError, match=words) as caught:
        lm.io.open_run(path)
    assert str(caught.value).startswith(f"'{path}' is truncated or damaged: ")


def test_conditions_of_another_shape_are_no_scene(path):
    """With the right digest."""
    with h5py.File(path, "r+", locking=False) as file:
        values = file["scene/conditions/value"][:]
        del file["scene/conditions/value"]
        file["scene/conditions"].create_dataset("value", data=values[:, None])
        file["scene"].attrs["digest"] = digest(file["scene"])
    with pytest.raises(ValueError, match="holds no scene that can be built: the fields of the conditions differ in shape"):
        lm.resume(path, observe={"height": height})


def test_a_pipe_is_no_run_file(tmp_path):
    import os

    os.mkfifo(tmp_path / "run.h5")
    with pytest.raises(ValueError, match="is a pipe or a device, not a run file"):
        lm.io.open_run(tmp_path / "run.h5")


def test_a_frame_that_points_out_of_the_table(path):
    with h5py.File(path, "r+", locking=False) as file:
        index = file["frames/index"][:]
        index["first"][7] = -3
        index["count"][8] = 10**12
        file["frames/index"][...] = index
        rows = file["interactions"][:]
        rows["candidate"][rows.shape[0] - 1] = 99
        file["interactions"][...] = rows
    with lm.io.open_run(path) as run:
        for frame, words in (
            (7, "frame 7 is said to have interactions -3 to"),
            (8, "frame 8"),
            (400, "a candidate that is not"),
        ):
            with pytest.raises(ValueError, match=words):
                run.interactions(frame)
        run.interactions(6)
