"""Files of problems that are damaged or hostile: a sentence or finite numbers, and never a crash, a hang or a raw error.

The tries of ``fclib_fuzz`` are made in processes of their own, which a crash would end. Each is known by its seed and its
number: ``python tests/io/fclib_fuzz.py FOLDER SEED FIRST STOP`` makes it again.
"""

import os
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
import suites
from fclib_fuzz import problem

import lmgcpy as lm

FUZZ = Path(__file__).parent / "fclib_fuzz.py"


def ends(folder, seed, first, stop, fuzz=FUZZ):
    """(number, kind of damage, how it ended) of every try, in as many processes as crashes make needed."""
    told = []
    while first < stop:
        command = [sys.executable, str(fuzz), str(folder), str(seed), str(first), str(stop)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=900)
        kind = ""
        for line in done.stdout.splitlines():
            word, number, rest = line.split(" ", 2)
            if word == "begin":
                first, kind = int(number), rest
            else:
                told.append((int(number), kind, rest))
        if done.returncode:
            told.append((first, kind, f"died of {done.returncode}: {done.stderr[-500:]}"))
        first += 1
    return told


def assert_sound(told, tries):
    wrong = [each for each in told if each[2] not in ("refused", "solved")]
    assert not wrong, wrong
    assert len(told) == tries
    assert {end for _, _, end in told} == {"refused", "solved"}


@pytest.mark.long
@pytest.mark.scaled
def test_damaged_files_do_no_harm(tmp_path):
    """Of 2000 such files, before they were checked, 124 crashed the process and 22 hung it."""
    tries = suites.size(10, long=60)
    assert_sound(ends(tmp_path, 1, 0, tries), tries)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(10, 18))
def test_two_thousand_damaged_files_do_no_harm(tmp_path, seed):
    assert_sound(ends(tmp_path, seed, 0, 250), 250)


# ---------------------------------------------------------------------------------------------------------- by hand


@pytest.fixture
def path(tmp_path):
    lm.io.fclib.write(problem(1), tmp_path / "problem.h5")
    return tmp_path / "problem.h5"


def change(path, name, values, **more):
    with h5py.File(path, "r+") as file:
        del file["fclib_local"][name]
        file["fclib_local"].create_dataset(name, data=values, **more)


def number(path, name, place, value, dtype=None):
    with h5py.File(path) as file:
        values = file["fclib_local"][name][()]
    values = values.astype(dtype or values.dtype)
    values[place] = value
    change(path, name, values)


BY_HAND = {
    "index far out": (lambda p: number(p, "W/i", 7, 5_000_000), "indices of W of a problem", "0 ... 139, got 5000000"),
    "index negative": (lambda p: number(p, "W/i", 7, -3), "indices of W of a problem must be in 0 ... 139, got -3"),
    "indices of floats": (lambda p: number(p, "W/i", 7, 1.5, float), "fclib_local/W/i must be whole numbers"),
    "pointer far out": (lambda p: number(p, "W/p", -1, 10**9), "pointers of W of a problem", "got 0 and 1000000000"),
    "pointer falls": (lambda p: number(p, "W/p", 4, 0), "pointers of W of a problem must not fall"),
    "other rows": (lambda p: change(p, "W/m", [7]), "fclib_local/W/m is 7, but there are 140 numbers"),
    "coordinates": (lambda p: change(p, "W/nz", [2466]), "fclib_local/W/nz must be -2", "got 2466"),
    "mu short": (lambda p: change(p, "vectors/mu", np.ones(69)), "must be 69 numbers, got 70"),
    "q short": (lambda p: change(p, "vectors/q", np.ones(139)), "W/m is 140, but there are 139 numbers"),
    "dimension broken": (lambda p: change(p, "spacedim", [2.5]), "fclib_local/spacedim must be whole numbers"),
    "dimension four": (lambda p: change(p, "spacedim", [4]), "fclib_local/spacedim must be 2 or 3, got 4"),
    "law broken": (lambda p: change(p, "law", np.full(70, 0.5)), "fclib_local/law must be whole numbers"),
    "guess long": (lambda p: change(p, "guesses/r", np.ones(142)), "fclib_local/guesses/r must be 140 numbers, got 142"),
    "q of words": (lambda p: change(p, "vectors/q", np.full(140, b"1.5")), "fclib_local/vectors/q must be numbers"),
    "geometric NaN": (lambda p: change(p, "compliance", np.full(70, np.nan)), "compliance of a problem must be finite"),
    "no symmetry": (lambda p: number(p, "W/x", 1, 0.9), "W of a problem must be symmetric"),
}  # fmt: skip


@pytest.mark.parametrize("name", BY_HAND)
def test_a_file_damaged_by_hand(path, name):
    damage, *words = BY_HAND[name]
    damage(path)
    with pytest.raises(ValueError) as caught:
        lm.io.fclib.read(path)
    for word in (f"'{path}' is no FCLIB problem: ", *words):
        assert word in str(caught.value)
    assert str(caught.value).endswith(".")


@pytest.mark.parametrize("size", [10**7, 10**11, 10**17])
def test_a_data_set_larger_than_its_file_is_refused(path, size):
    """It takes no room there, and all the memory there is when it is read."""
    with h5py.File(path, "r+") as file:
        del file["fclib_local/vectors/q"]
        file["fclib_local/vectors"].create_dataset("q", (size,), float, chunks=(1000,), compression="gzip")
    with pytest.raises(ValueError, match=r"vectors/q is said to have shape .* more than a file of this size can hold"):
        lm.io.fclib.read(path)


def test_what_lies_in_other_files_is_not_read(path, tmp_path):
    """Not even opened: the other is a pipe, at which one would wait for ever."""
    os.mkfifo(tmp_path / "pipe")
    with h5py.File(path, "r+") as file:
        del file["fclib_local/vectors/q"], file["fclib_local/vectors/mu"]
        file["fclib_local/vectors/q"] = h5py.ExternalLink("pipe", "q")
    with pytest.raises(ValueError, match="vectors/q is a link to elsewhere"):
        lm.io.fclib.read(path)
    with h5py.File(path, "r+") as file:
        del file["fclib_local/vectors/q"]
        file["fclib_local/vectors"].create_dataset("q", (140,), "i1", external=[("/etc/passwd", 0, 140)])
    with pytest.raises(ValueError, match="vectors/q has its numbers in other files"):
        lm.io.fclib.read(path)


def test_filters_that_would_load_code_are_refused(path):
    with h5py.File(path, "r+") as file:
        group = file["fclib_local/vectors"]
        del group["q"]
        properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        properties.set_chunk((10,))
        properties.set_filter(32_004, h5py.h5z.FLAG_OPTIONAL)
        h5py.h5d.create(group.id, b"q", h5py.h5t.NATIVE_DOUBLE, h5py.h5s.create_simple((140,)), properties)
    with pytest.raises(ValueError, match="vectors/q is packed by filter 32004, which is not read"):
        lm.io.fclib.read(path)


def test_a_pipe_or_a_device_is_refused(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", "/dev/zero"):
        with pytest.raises(ValueError, match=f"'{path}' is a pipe or a device, not a file of a problem: write"):
            lm.io.fclib.read(path)


@pytest.mark.parametrize("packing", [{"compression": "gzip", "shuffle": True, "fletcher32": True}, {"compression": "lzf"}])
def test_packed_files_and_compressed_columns_are_read(path, packing):
    """W is symmetric but for round-off, so that its rows, said to be columns, are W again."""
    whole = lm.io.fclib.read(path)
    with h5py.File(path) as file:
        values = {name: file["fclib_local"][name][()] for name in ("W/x", "W/i", "W/p", "vectors/q")}
    for name, given in values.items():
        change(path, name, given, chunks=True, **packing)
    np.testing.assert_array_equal(lm.io.fclib.read(path).q, whole.q)
    change(path, "W/nz", [-1])
    np.testing.assert_array_equal(lm.io.fclib.read(path).W.toarray(), whole.W.toarray().T)
