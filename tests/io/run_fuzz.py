"""Damaged and hostile run files: ``python run_fuzz.py FOLDER SEED FIRST STOP`` tries those from FIRST to STOP.

As ``fclib_fuzz``. A try is sound where what is read is what was recorded, to the last bit, or where a sentence refuses it;
and where a resumed run makes the same steps, or is refused. What was made on purpose, with the right sums, may hold other
numbers, but raises nothing else.
"""

import os
import signal
import sys
import traceback
import warnings

import fclib_fuzz as basis
import h5py
import numpy as np

import lmgcpy as lm
from lmgcpy.io.run_file.opening import UnclosedFile
from lmgcpy.io.run_file.trees import DIGEST, digest

SECONDS = 40
"""Of a try, after which its process is killed. HDF5 waits some seconds for writers that are not there."""


def simulation(dimension):
    """A wire that falls on a floor, and grains."""
    make, ones = (lm.disk, (0.0, 1.0)) if dimension == 2 else (lm.sphere, (0.0, 0.0, 1.0))
    up = np.array(ones)
    scene = lm.Scene(dimension=dimension, gravity=-9.81 * up)
    across = np.eye(dimension)[0]
    beads = [scene.add(make(radius=0.01, position=0.025 * i * across + 0.012 * up, mass=0.1)) for i in range(4)]
    for i in range(3):
        scene.add(make(radius=0.01, position=0.03 * i * across + 0.04 * up, mass=0.2, color="SAND"))
    scene.add(lm.wall(point=0.0 * up, normal=up))
    for one, other in (("GRAIN", "WALL"), ("SAND", "WALL"), ("SAND", "GRAIN")):
        scene.see(one, other, lm.Coulomb(friction=0.3))
    scene.chain(beads, lm.ElasticWire(stiffness=1e4))
    beads[0].impose_force(**{"x": 0.1})
    return lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=1e-8))


def height(sim):
    """An observation."""
    return sim.positions[:, -1]


class Killed(Exception):
    """Raised in the middle of a run."""


def make_bases(folder):
    """Files of a run in the plane, one in space, and one whose writer died; with what was recorded in each."""
    paths = []
    for name, dimension, dead in (("plane.h5", 2, False), ("space.h5", 3, False), ("dead.h5", 2, True)):
        path = os.path.join(folder, name)
        paths.append(path)
        if not dead:
            simulation(dimension).run(steps=40, record=path, every=4, force=True, observe={"height": height})
            continue
        sim = simulation(dimension)
        beside = path + ".whole"

        def die(sim, path=path, beside=beside):
            if sim.steps == 30:
                with open(beside, "rb") as raw, open(path, "wb") as copy:
                    copy.write(raw.read())
            return False

        sim.run(steps=40, record=beside, every=4, flush=0.0, force=True, observe={"height": height}, until=die)
        os.remove(beside)
    return paths


# ------------------------------------------------------------------------------------------------------------- damage


def flip_numbers(rng, path):
    """Some bits of the numbers of a data set."""
    spans = []
    with h5py.File(path, "r", locking=False) as file:

        def find(name, item):
            if not isinstance(item, h5py.Dataset):
                return
            if item.chunks:
                for k in range(item.id.get_num_chunks()):
                    info = item.id.get_chunk_info(k)
                    spans.append((info.byte_offset, info.size))
            elif item.id.get_offset() is not None:
                spans.append((item.id.get_offset(), item.id.get_storage_size()))

        file.visititems(find)
    start, size = spans[rng.integers(len(spans))]
    data = basis.content(path)
    for at in rng.integers(8 * start, 8 * (start + size), rng.integers(1, 3)):
        data[at // 8] ^= 1 << (at % 8)
    basis.replace(path, data)


def names_of(file):
    """Paths of all data sets."""
    found = []
    file.visititems(lambda name, item: found.append(name) if isinstance(item, h5py.Dataset) else None)
    return found


def one_entry(rng, group, name):
    """One number in a table of several columns becomes another."""
    values = np.array(group[name])
    if values.dtype.names is None or not values.size:
        return basis.one_number(rng, group, name) if values.dtype.kind in "iuf" and values.size else None
    field = values.dtype.names[rng.integers(len(values.dtype.names))]
    column = values[field]
    number = basis.NUMBERS[rng.integers(len(basis.NUMBERS))]
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        column.ravel()[rng.integers(column.size)] = np.array(number).astype(column.dtype)
    values[field] = column
    group[name][...] = values
    return None


def other_text(rng, group, name):
    """A JSON text becomes another, or none."""
    texts = (
        b"",
        b"{",
        b"null",
        b"[]",
        b"{}",
        b"3",
        b"-1",
        b"1e999",
        b'"word"',
        b"NaN",
        b"[1, 2]",
        b'{"a": 1}',
        b"\xff",
        b"0",
    )
    if group[name].dtype.kind == "S":
        basis.put(group, name, np.bytes_(texts[rng.integers(len(texts))]))


def gone(rng, group, name):
    """Or a whole group is."""
    del group[name.rsplit("/", rng.integers(0, 2))[0]]


def too_long(rng, group, name):
    """A growing table claims rows that it has not."""
    if group[name].chunks and group[name].maxshape[0] is None:
        group[name].resize(int(10 ** rng.uniform(2, 15)), axis=0)


def other_attribute(rng, group, name):
    """What the file says of itself."""
    values = (-1, 2, 10**6, "lmgcpy", b"\xff", np.zeros(3), 1.5, np.zeros(10**4), "lmgcpy run", h5py.Empty(float))
    place = group if rng.integers(2) else group["scene"]
    key = ("format", "format_version", DIGEST)[rng.integers(3)]
    place.attrs[key] = values[rng.integers(len(values))]


def recommit(group, rng):
    """Commits that count other numbers of rows, with the right sum."""
    from lmgcpy.io.run_file.commits import Commit, write_commit

    numbers = [int(basis.NUMBERS[rng.integers(7)]) for _ in range(3)]
    write_commit(group, Commit(int(rng.integers(0, 1000)), *numbers, closed=bool(rng.integers(2))))


WAYS = (one_entry, one_entry, basis.other_length, basis.other_type, basis.other_place, other_text, gone, too_long,
        other_attribute)  # fmt: skip


def craft(rng, path):
    """A file that HDF5 finds good; every second with the right digests."""
    with h5py.File(path, "r+", locking=False) as file:
        names = names_of(file)
        name = names[rng.integers(len(names))]
        if rng.integers(8) == 0:
            recommit(file, rng)
        else:
            way = WAYS[rng.integers(len(WAYS))]
            if way in (basis.other_length, basis.other_type) and file[name].dtype.kind not in "iuf":
                way = one_entry
            way(rng, file, name)
        if rng.integers(2):
            for part in ("about", "scene"):
                try:
                    file[part].attrs[DIGEST] = digest(file[part])
                except Exception:  # what cannot be summed has no right sum
                    continue


KINDS = (basis.flip, flip_numbers, flip_numbers, basis.cut, craft, craft, craft)


# -------------------------------------------------------------------------------------------------------------- trying


def words_of(run):
    """All that a file holds, as pairs of a name and bytes; what cannot be read as the sentence that says so."""
    parts = {
        "times": lambda: run.times,
        "steps": lambda: run.steps,
        "positions": lambda: run.positions[:],
        "velocities": lambda: run.velocities[:],
        "rotations": lambda: run.rotations[:],
        "spins": lambda: run.spins[:],
        "history": lambda: run.history[:],
        "status": lambda: run.status,
        "unconverged": lambda: np.array(run.unconverged_steps),
        "height": lambda: run.observed["height"][:],
        "scene": lambda: np.array(repr(run.scene)),
        "extent": lambda: run.extent,
        "walls": lambda: np.array(repr(run.wall_normals)),
        "about": lambda: np.array(repr((run.laws, run.options, run.notes))),
        "checkpoint": lambda: np.array(repr(vars(run.checkpoint()))),
    }
    for frame in range(min(run.frame_count, 20)):
        parts[f"interactions {frame}"] = lambda frame=frame: np.array(repr(vars(run.interactions(frame))))
    found = {}
    for name, read in parts.items():
        try:
            value = read()
            found[name] = (str(value.dtype), value.shape, value.tobytes())
        except ValueError as refusal:
            found[name] = refusal
    return found


def attempt(path, whole, crafted):
    """Read all, then resume and make some steps; returns how that ended."""
    refusals = []
    try:
        with lm.io.open_run(path) as run:
            found = words_of(run)
    except (ValueError, OSError) as refusal:
        return refused(refusal, path)
    for name, value in found.items():
        if isinstance(value, Exception):
            refusals.append(refused(value, path))
        elif not crafted and value not in whole[0].get(name, ()):
            return f"unsound: {name} reads as something else"
    try:
        sim = lm.resume(path, observe={"height": height})
        start = sim.steps
        sim.run(steps=3)
        if not crafted and not any(same(sim, start, known) for known in whole[1]):
            return "unsound: resumed with other numbers"
    except (ValueError, OSError, LookupError, FloatingPointError, RuntimeError, TypeError) as refusal:
        refusals.append(refused(refusal, path, resumed=True))
    wrong = [told for told in refusals if told != "refused"]
    return wrong[0] if wrong else "refused" if refusals else "read"


def same(sim, start, known):
    return known[0] == start and known[1] == sim.positions.tobytes() and known[2] == sim.velocities.tobytes()


def refused(refusal, path, resumed=False):
    """Whether a sentence says so, of lmgcpy and not of h5py or numpy."""
    words = str(refusal)
    ours = traceback.extract_tb(refusal.__traceback__)[-1].filename.startswith(os.path.dirname(lm.__file__))
    sound = words.endswith(".") and ours and (resumed or path in words)
    return "refused" if sound else f"unsound: {type(refusal).__name__}: {words}"


def known_of(path):
    """What a whole file holds, with either checkpoint and commit, and where three more steps lead."""
    copy = path + ".copy"
    found: dict[str, list] = {}
    ends = []
    with h5py.File(UnclosedFile(path), "r") as file:
        last = max("01", key=lambda k: file[f"checkpoint/{k}/numbers"][0])
        checkpoint = file[f"checkpoint/{last}/numbers"].id.get_offset()
        commit = file["commits"].id.get_offset() + 8 * 6 * int(np.argmax(file["commits"][:, 0]))
    for lost in ((), (checkpoint,), (commit,)):  # of what is written in turn, either may be taken
        data = basis.content(path)
        for at in lost:
            data[at] ^= 1
        basis.replace(copy, data)
        with lm.io.open_run(copy) as run:
            for name, value in words_of(run).items():
                found.setdefault(name, []).append(value)
        try:
            sim = lm.resume(copy, observe={"height": height})
        except ValueError:
            continue
        start = sim.steps
        sim.run(steps=3)
        ends.append((start, sim.positions.tobytes(), sim.velocities.tobytes()))
    os.remove(copy)
    return found, ends


def main(folder, seed, first, stop):
    warnings.simplefilter("error")
    warnings.filterwarnings("ignore", message="In the step|Until t|\\d+ of \\d+ steps|\\d+ pairs? of bodies")
    bases = make_bases(folder)
    whole = {base: known_of(base) for base in bases}
    if not os.path.exists(os.path.join(folder, "pipe")):
        os.mkfifo(os.path.join(folder, "pipe"))
    path = os.path.join(folder, "tried.h5")
    for k in range(first, stop):
        rng = np.random.default_rng([seed, k])
        base, kind = bases[rng.integers(len(bases))], KINDS[rng.integers(len(KINDS))]
        if kind in (craft, flip_numbers) and base.endswith("dead.h5"):
            base = bases[0]  # HDF5 does not open what is marked as being written
        print(f"begin {k} {kind.__name__} {os.path.basename(base)}", flush=True)
        if os.path.exists(path):
            os.remove(path)  # a lock of the try before would be one on this file
        basis.replace(path, basis.content(base))
        kind(rng, path)
        signal.alarm(SECONDS)
        try:
            end = attempt(path, whole[base], kind is craft)
        except Exception as error:
            end = f"unsound: {type(error).__name__}: {error} at {traceback.extract_tb(error.__traceback__)[-1]}"
        signal.alarm(0)
        print(f"end {k} {' '.join(end.split())}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1], *map(int, sys.argv[2:]))
