"""Damaged and hostile files of problems: ``python fclib_fuzz.py FOLDER SEED FIRST STOP`` tries those from FIRST to STOP.

Each try is a line on standard output, "begin" before and its end after, so that whoever waits for the process knows the try
in which it died. A try is sound where the file is refused by a sentence, or read, measured and solved with finite numbers.
"""

import os
import signal
import sys
import traceback
import warnings

import h5py
import numpy as np
import scipy.sparse as sparse

import lmgcpy as lm

SECONDS = 20
"""Of a try, after which its process is killed: some hundred times what the slowest takes."""
REFUSALS = (ValueError, TypeError, OSError, FloatingPointError)


def problem(seed, *, dimension=2, contacts=40, links=30, geometric=False):
    """W = H M^-1 H^T of links in a row and contacts between random bodies, all masses near one."""
    rng = np.random.default_rng(seed)
    count, bodies, d = contacts + links, max(links + 1, contacts // 2), dimension
    one = np.concatenate([np.arange(links), rng.integers(0, bodies, contacts)])
    other = np.concatenate([np.arange(links) + 1, (one[links:] + rng.integers(1, bodies, contacts)) % bodies])
    frames = np.linalg.qr(rng.normal(size=(count, d, d)))[0]
    H = np.zeros((count, d, bodies, d))
    at = np.arange(count)
    H[at, :, one], H[at, :, other] = frames, -frames
    H = sparse.csr_array(H.reshape(count * d, bodies * d))
    W = sparse.csr_array(H @ sparse.diags_array(rng.uniform(0.5, 2.0, bodies * d)) @ H.T)
    return lm.Problem(
        W=W,
        q=rng.normal(size=count * d),
        mu=np.where(at < links, 0.0, 0.3),
        dimension=d,
        laws=("rigid-wire",) * (links // 2) + ("elastic-rod",) * (links - links // 2) + ("coulomb",) * contacts,
        compliance=np.where((at >= links // 2) & (at < links), 0.1, 0.0),
        guess=rng.normal(size=(count, d)),
        geometric=np.where(at < links, 0.2, 0.0) * geometric,
    )


def make_bases(folder):
    """Sound files: small and larger, of contacts alone, with wires, with geometric stiffness, and a packed one."""
    made = {
        "plane.h5": problem(1),
        "stiff.h5": problem(2, contacts=5, links=20, geometric=True),
        "space.h5": problem(3, dimension=3, contacts=30, links=0),
        "both.h5": problem(4, dimension=3, contacts=20, links=10, geometric=True),
    }
    paths = []
    for name, each in made.items():
        paths.append(os.path.join(folder, name))
        lm.io.fclib.write(each, paths[-1], force=True)
    packed = os.path.join(folder, "packed.h5")
    with h5py.File(paths[0]) as plain, h5py.File(packed, "w") as file:

        def copy(name, item):
            if isinstance(item, h5py.Dataset) and item.size > 10:
                file.create_dataset(name, data=item[()], chunks=True, compression="gzip", shuffle=True, fletcher32=True)
            elif isinstance(item, h5py.Dataset):
                file[name] = item[()]

        plain.visititems(copy)
    return [*paths, packed]


# ------------------------------------------------------------------------------------------------------------- damage


def flip(rng, path):
    """Some bits, anywhere."""
    data = content(path)
    for at in rng.integers(0, 8 * len(data), rng.integers(1, 4)):
        data[at // 8] ^= 1 << (at % 8)
    replace(path, data)


def flip_numbers(rng, path):
    """Some bits of one data set, or of the headers that lie before all of them."""
    with h5py.File(path) as file:
        spans = [(0, 2048)]
        for name in SETS:
            item = file["fclib_local"].get(name)
            if item is not None and item.id.get_offset() is not None:
                spans.append((item.id.get_offset(), item.id.get_storage_size()))
    start, size = spans[rng.integers(len(spans))]
    data = content(path)
    for at in rng.integers(8 * start, 8 * (start + size), rng.integers(1, 3)):
        data[at // 8] ^= 1 << (at % 8)
    replace(path, data)


def cut(rng, path):
    """The end, or a block in the middle, is missing, zero, or comes from elsewhere in the file."""
    data = content(path)
    a, b = sorted(rng.integers(0, len(data), 2).tolist())
    b = min(b, a + 4096)
    way = rng.integers(4)
    if way == 0:
        del data[a:]
    elif way == 1:
        del data[a:b]
    elif way == 2:
        data[a:b] = bytes(b - a)
    else:
        at = int(rng.integers(0, len(data) - (b - a)))
        data[a:b] = data[at : at + b - a]
    replace(path, data)


def content(path):
    with open(path, "rb") as raw:
        return bytearray(raw.read())


def replace(path, data):
    with open(path, "wb") as raw:
        raw.write(data)


SETS = ("W/x", "W/i", "W/p", "W/m", "W/n", "W/nz", "vectors/q", "vectors/mu", "spacedim", "law", "compliance", "geometric",
        "guesses/r")  # fmt: skip
NUMBERS = (5_000_000, -3, -1, 0, 1, 2**31 - 1, -(2**31), 2**31, 2**62, np.nan, np.inf, -np.inf, 1e300, -1e300, 1e69, -1e69,
           1e-320, 1e-69, 0.5, 1e-3, 1e6)  # fmt: skip


def one_number(rng, group, name):
    """One number of a data set becomes another, of the same type where it can be."""
    values = np.array(group[name])
    number = NUMBERS[rng.integers(len(NUMBERS))]
    if values.dtype.kind == "i":
        if not np.isfinite(number) or number != int(number) or abs(number) > 2**62:
            values = values.astype(float)
        elif abs(number) >= 2**31:
            values = values.astype(np.int64)
    values.ravel()[rng.integers(values.size) if values.size else slice(0)] = number
    put(group, name, values)


def all_numbers(rng, group, name):
    """All are multiplied, made one number, noise, or put in another order."""
    values = np.array(group[name], dtype=float).ravel()
    factor = [0.0, -1.0, 1e-60, 1e60, 1e30, 1e-30, 0.5, 1e4][rng.integers(8)]
    whole = group[name].dtype.kind == "i" and abs(factor) <= 1.0
    made = [factor * values, np.full_like(values, factor), rng.normal(size=values.shape) * factor, rng.permutation(values)]
    result = made[rng.integers(4)]
    put(group, name, result.astype(np.int32) if whole else result)


def other_length(rng, group, name):
    """Shorter, longer, empty, a number, a table, or far too long and with nothing in the file."""
    values = np.array(group[name]).ravel()
    way = rng.integers(7)
    if way == 6:
        del group[name]
        size = int(10 ** rng.uniform(4.5, 18))
        group.create_dataset(name, (size,), values.dtype, chunks=(1 << 14,), compression=[None, "gzip"][rng.integers(2)])
        return
    made = [values[:-1], np.append(values, values[-1:]), values[:0], values[:1].sum(), values[:, None], values[None, None]]
    put(group, name, made[way])


def other_type(rng, group, name):
    """Something that is no number, or a number of another kind."""
    values = np.array(group[name]).ravel()
    way = rng.integers(15)
    kinds = {0: np.float64, 1: np.float32, 2: np.float16, 3: np.longdouble, 4: ">f8", 5: np.uint64, 6: np.int8, 7: complex}
    if way in kinds:
        with np.errstate(all="ignore"):
            put(group, name, values.astype(kinds[way]))
    elif way == 8:
        put(group, name, "plane")
    elif way == 9:
        put(group, name, np.array([b"1.5"] * len(values)))
    elif way == 10:
        put(group, name, values > 0)
    elif way == 11:
        put(group, name, np.array([(1, 2.0)] * len(values), dtype=[("a", int), ("b", float)]))
    elif way == 12:
        del group[name]
        variable = group.create_dataset(name, (len(values),), h5py.vlen_dtype(float))
        variable[:1] = [np.ones(3)]
    elif way == 13:
        put(group, name, np.array([group.ref] * len(values), dtype=h5py.ref_dtype))
    else:
        del group[name]
        group.create_dataset(name, data=h5py.Empty(float))


def other_place(rng, group, name):
    """Gone, a group, a link that leads elsewhere or nowhere, or data that lie in other files."""
    values = np.array(group[name]).ravel()
    path = group.file.filename
    del group[name]
    way = rng.integers(10)
    if way == 1:
        group.create_group(name)
    elif way == 2:
        group[name] = h5py.SoftLink("/no/such")
    elif way == 3:
        group[name] = h5py.SoftLink(group.name + "/" + name)
    elif way == 4:
        group[name] = h5py.ExternalLink(os.path.join(os.path.dirname(path), "plane.h5"), "fclib_local/" + name)
    elif way == 5:
        group[name] = h5py.ExternalLink(os.path.join(os.path.dirname(path), "pipe"), "fclib_local/" + name)
    elif way == 6:
        group.create_dataset(name, (len(values),), values.dtype, external=[("/etc/passwd", 0, h5py.h5f.UNLIMITED)])
    elif way == 7:
        layout = h5py.VirtualLayout((len(values),), values.dtype)
        layout[:] = h5py.VirtualSource(
            os.path.join(os.path.dirname(path), "plane.h5"), "fclib_local/" + name, (len(values),)
        )
        group.create_virtual_dataset(name, layout)
    elif way == 8:
        properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        properties.set_chunk((1,))
        properties.set_filter(32_004, h5py.h5z.FLAG_OPTIONAL)  # of a plug-in
        space = h5py.h5s.create_simple((len(values),))
        h5py.h5d.create(group.id, name.encode(), h5py.h5t.NATIVE_DOUBLE, space, properties)
    elif way == 9:
        group[name] = values.reshape(1, -1, 1)


def other_operator(rng, group, name):
    """W is no symmetric, positive semidefinite operator, or is written in a strange way."""
    count, d = len(group["vectors/mu"]), int(group["spacedim"][0])
    size = count * d
    given = (group["W/x"][()], group["W/i"][()], group["W/p"][()])
    W = sparse.csr_array(given, shape=(size, size)).tolil()
    i, j = (int(k) for k in rng.integers(0, size, 2))
    way = rng.integers(7)
    if way == 0:
        W[i, j] = W[j, i] = 10.0 ** rng.uniform(0, 40)
    elif way == 1:
        W[i, j] = 10.0 ** rng.uniform(-2, 3)
    elif way == 2:
        W[i, i] = 0.0
    elif way == 3:
        W = W - rng.uniform(0.1, 0.9) * sparse.diags_array(W.diagonal())
    elif way == 4:
        W = W * 10.0 ** rng.uniform(-80, 80)
    elif way == 5:
        W = sparse.diags_array(10.0 ** rng.uniform(-60, 60, size))
    W = sparse.csr_array(W)
    x, columns, p = W.data, W.indices, W.indptr
    if way == 6:  # every entry twice, from the last to the first
        x, columns, p = np.repeat(x, 2)[::-1] / 2, np.repeat(columns, 2)[::-1], 2 * (p[-1] - p[::-1])
    for part, values in (("x", x), ("i", columns), ("p", p)):
        put(group, f"W/{part}", values)


def put(group, name, values):
    del group[name]
    group[name] = values


def craft(rng, path):
    """A file that HDF5 finds good."""
    ways = [one_number, one_number, one_number, all_numbers, other_length, other_type, other_place, other_operator]
    with h5py.File(path, "r+") as file:
        group = file["fclib_local"]
        names = [name for name in SETS if name in group]
        ways[rng.integers(len(ways))](rng, group, names[rng.integers(len(names))])


KINDS = (flip, flip_numbers, cut, craft, craft)


# -------------------------------------------------------------------------------------------------------------- trying


def attempt(path, solver):
    """Read, measure and solve; returns how that ended."""
    try:
        problem = lm.io.fclib.read(path)
    except REFUSALS as refusal:
        return refused(refusal, path)
    sizes = [lm.residual(problem, problem.guess, measure=measure) for measure in ("natural", "fclib")]
    if np.isnan(sizes).any():
        return "unsound: a measure is NaN"
    try:
        solution = lm.solve(problem, solver=solver)
    except REFUSALS as refusal:
        return refused(refusal, "")
    finite = np.isfinite(solution.impulses).all() and np.isfinite(solution.velocities).all()
    return "solved" if finite and np.isfinite(solution.residual) else "unsound: not finite"


def refused(refusal, path):
    """Whether a sentence says so: of lmgcpy, with the file in it, and not of scipy or numpy."""
    words = str(refusal)
    ours = traceback.extract_tb(refusal.__traceback__)[-1].filename.startswith(os.path.dirname(lm.__file__))
    sound = path in words and words.endswith(".") and words[0] in "'TW" and ours
    return "refused" if sound else f"unsound: {type(refusal).__name__}: {words}"


def main(folder, seed, first, stop):
    warnings.simplefilter("error")
    warnings.filterwarnings("ignore", "W of a problem is not symmetric")
    bases = make_bases(folder)
    if not os.path.exists(os.path.join(folder, "pipe")):
        os.mkfifo(os.path.join(folder, "pipe"))
    solvers = (
        lm.Auto(tolerance=1e-6, max_iterations=200, max_factorisations=20),
        lm.GaussSeidel(max_iterations=300),
        lm.Newton(max_iterations=150, max_factorisations=20),
        lm.AcceleratedGaussSeidel(max_iterations=300, wire_blocks=False),
    )
    for solver in solvers:  # kernels are made before the clock runs
        for base in bases:
            attempt(base, solver)
    path = os.path.join(folder, "tried.h5")
    for k in range(first, stop):
        rng = np.random.default_rng([seed, k])
        base, kind = bases[rng.integers(len(bases))], KINDS[rng.integers(len(KINDS))]
        print(f"begin {k} {kind.__name__} {os.path.basename(base)}", flush=True)
        replace(path, content(base))
        kind(rng, path)
        signal.alarm(SECONDS)
        try:
            end = attempt(path, solvers[k % len(solvers)])
        except Exception as error:
            end = f"unsound: {type(error).__name__}: {error} at {traceback.extract_tb(error.__traceback__)[-1]}"
        signal.alarm(0)
        print(f"end {k} {' '.join(end.split())}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1], *map(int, sys.argv[2:]))
