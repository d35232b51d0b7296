"""The compiler's one place: fingerprints, specialisation, the cache on disk.

Most tests write little modules to a temporary directory and edit them, as an author of a law would.
"""

from __future__ import annotations

import builtins
import errno
import gc
import hashlib
import importlib
import os
import pickle
import subprocess
import sys
import textwrap
import threading
import warnings

import numpy as np
import pytest
from forks import forked
from numba.core.runtime import _nrt_python, rtsys
from soft_law import process

from lmgcpy.compiled.cache import cache_directory
from lmgcpy.compiled.fingerprint import Slot
from lmgcpy.compiled.kernel import CompilerError, fingerprint, kernel, row_reader, statistics


@pytest.fixture
def module(tmp_path, monkeypatch):
    """Function ``(name, source)`` that writes a module and imports it anew."""
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    written = []

    def write(name, source):
        (tmp_path / f"{name}.py").write_text(textwrap.dedent(source))
        importlib.invalidate_caches()
        sys.modules.pop(name, None)
        written.append(name)
        return importlib.import_module(name)

    yield write
    for name in written:
        sys.modules.pop(name, None)


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """An empty cache directory."""
    directory = tmp_path / "cache"
    monkeypatch.setenv("LMGCPY_CACHE_DIR", str(directory))
    return directory


# ----------------------------------------------------------------------------------------- what makes compiling short


def test_kernels_share_the_functions_that_they_both_call(cache):
    """The helper is one function of numba in two kernels, and another one where a name in it is replaced."""

    def called_by(kernel):
        return kernel.dispatcher.py_func.__globals__["_scaled"]

    thrice = _doubled.specialise(_FACTOR=3.0)
    assert (_doubled(1.5), _quadrupled(1.5), thrice(1.5)) == (3.0, 6.0, 4.5)  # a function is complete once it is compiled
    assert called_by(_doubled) is called_by(_quadrupled)
    assert called_by(thrice) is not called_by(_doubled)


def test_a_slot_that_nothing_fills_is_told_again_and_again(cache):
    """The second attempt says what the first one said."""
    empty = kernel(_calls_the_slot)
    for _ in range(2):
        with pytest.raises(TypeError, match="Nothing stands in for '_slot', which _calls_the_slot calls"):
            empty(1.0)


_slot = Slot("_slot")


def _calls_the_slot(x):
    return _scaled(x) + _slot(x)


_FACTOR = 2.0


def _scaled(x):
    return _FACTOR * x


@kernel
def _doubled(x):
    return _scaled(x)


@kernel
def _quadrupled(x):
    return _scaled(_scaled(x))


@pytest.mark.parametrize("enabled", [True, False])
def test_the_collector_waits_while_a_kernel_is_compiled_and_goes_on_as_it_was(cache, enabled):
    """Whether the kernel can be compiled or not."""

    @kernel
    def sound(x):
        return x + 1.0

    @kernel
    def broken(x):
        return x + nowhere  # noqa: F821

    was = gc.isenabled()
    try:
        (gc.enable if enabled else gc.disable)()
        assert sound(1.0) == 2.0
        assert gc.isenabled() is enabled
        with pytest.raises(CompilerError, match="nowhere"):
            broken(1.0)
        assert gc.isenabled() is enabled
    finally:
        (gc.enable if was else gc.disable)()


@pytest.mark.long
def test_what_others_wrote_may_make_arrays_and_gives_their_memory_back(cache):
    """As many arrays are freed as are made."""

    @kernel
    def sums(count, size):
        total = 0.0
        for _ in range(count):
            total += (np.arange(size) + 1.0).sum()
        return total

    _nrt_python.memsys_enable_stats()
    assert sums(1, 10_000) == 10_000 * 10_001 / 2
    before = rtsys.get_allocation_stats()
    sums(100, 10_000)
    after = rtsys.get_allocation_stats()
    assert after.alloc - before.alloc == after.free - before.free >= 100


# ------------------------------------------------------------------------------------------------------ fingerprints

BASE = {
    "jit_other": "FACTOR = 2.0\nSHIFT = 1.0\n\ndef twice(x):\n    return FACTOR * x\n",
    "jit_law": """
        from __future__ import annotations
        import math
        from typing import NamedTuple
        import jit_other
        from jit_other import twice

        OFFSET = 1.0
        TABLE = (1.0, 2.0)

        class Shape(NamedTuple):
            radius: float

        def square(x):
            return x * x

        def react(x, s: Shape):
            inner = lambda y: y + 1.0
            return inner(square(twice(x))) + OFFSET + TABLE[0] + math.sqrt(s.radius) + jit_other.SHIFT
    """,
}


def react_of(module, changes=()):
    """The function ``react`` of the two modules above after replacing words in them."""
    for name, source in BASE.items():
        text = textwrap.dedent(source)
        for where, old, new in changes:
            if where == name:
                assert old in text
                text = text.replace(old, new)
        last = module(name, text)
    return last.react


CHANGES = {
    "own code": ("jit_law", "inner(square", "2.0 * inner(square"),
    "own constant": ("jit_law", "y + 1.0", "y + 1.5"),
    "global constant": ("jit_law", "OFFSET = 1.0", "OFFSET = 1.5"),
    "tuple of constants": ("jit_law", "(1.0, 2.0)", "(1.5, 2.0)"),
    "helper": ("jit_law", "x * x", "x * x * x"),
    "helper in another module": ("jit_other", "FACTOR * x", "FACTOR + x"),
    "constant of that helper": ("jit_other", "FACTOR = 2.0", "FACTOR = 3.0"),
    "constant read through a module": ("jit_other", "SHIFT = 1.0", "SHIFT = 2.0"),
    "another function of math": ("jit_law", "math.sqrt", "math.exp"),
    "fields of an argument": ("jit_law", "radius: float", "height: float\n    radius: float"),
}


@pytest.mark.parametrize("what", CHANGES)
def test_the_fingerprint_sees_a_change_of(what, module):
    assert fingerprint(react_of(module)) != fingerprint(react_of(module, [CHANGES[what]]))


def test_the_fingerprint_is_that_of_the_content(module):
    """Neither comments, nor line numbers, nor what the code does not read, nor a new import of the same change it."""
    same = [("jit_law", "OFFSET = 1.0", "# a comment\n\nUNREAD = 5.0\nOFFSET = 1.0")]
    assert fingerprint(react_of(module)) == fingerprint(react_of(module)) == fingerprint(react_of(module, same))


def test_the_fingerprint_sees_a_constant_of_a_module_of_a_module(module):
    """``package.constants.K``: an attribute of an attribute."""

    def react(value):
        module("jit_inner", f"K = {value}\n")
        module("jit_outer", "import jit_inner\n")
        return module("jit_law", "import jit_outer\ndef react(x):\n    return jit_outer.jit_inner.K * x\n").react

    assert fingerprint(react(2.0)) != fingerprint(react(3.0))


def test_the_fingerprint_sees_the_content_of_an_array_and_a_closure():
    def scaled(table):
        return lambda i: table[i]

    first, same, other = (scaled(np.array(t)) for t in ([1.0, 2.0], [1.0, 2.0], [1.0, 3.0]))
    assert fingerprint(first) == fingerprint(same) != fingerprint(other)


def test_the_fingerprint_sees_replaced_names():
    assert fingerprint(own_law, {"CONSTANT": 1.0}) == fingerprint(own_law)
    assert fingerprint(own_law, {"CONSTANT": 2.0}) != fingerprint(own_law)
    assert fingerprint(own_law, {"UNREAD": 2.0}) == fingerprint(own_law)


@pytest.mark.long
def test_the_fingerprint_of_a_set_does_not_depend_on_the_hash_seed(tmp_path):
    """A test ``x in {...}`` holds a frozenset, whose order differs from process to process: it must not miss the cache."""
    (tmp_path / "jit_set.py").write_text("def f(x):\n    return x in {'ab', 'cd', 'ef', 'gh'}\n")
    code = "import jit_set, lmgcpy.compiled.kernel as jit; print(jit.fingerprint(jit_set.f))"
    marks = {process(code, folder=tmp_path, PYTHONHASHSEED=seed).stdout for seed in ("1", "2")}
    assert len(marks) == 1


# ---------------------------------------------------------------------------------------------------- specialisation

CONSTANT = 1.0


def law(x):
    """Replaced by a specialisation."""
    return x


def helper(x):
    return law(x) + CONSTANT


@kernel
def template(x):
    return 10.0 * helper(x) + CONSTANT


def own_law(x):
    """Reads the global of the same name as the template does: its own stays its own."""
    return 100.0 * x + CONSTANT


def law_with_shared_helper(x):
    return shared(x)


def shared(x):
    return x + CONSTANT


@kernel
def template_with_shared_helper(x):
    return 1000.0 * law(x) + shared(x)


def test_a_kernel_without_specialisation_is_itself(cache):
    assert template(2.0) == 10.0 * (2.0 + 1.0) + 1.0


def test_specialise_reaches_called_helpers(cache):
    assert template.specialise(CONSTANT=5.0)(2.0) == 10.0 * (2.0 + 5.0) + 5.0


def test_a_name_that_no_kernel_reads_is_refused():
    """It was dropped, so that a slip of the pen compiled the stub."""
    with pytest.raises(TypeError, match=r"reads no name 'CONSTAND' that could be replaced; did you mean 'CONSTANT'\?"):
        template.specialise(CONSTAND=5.0)


unfilled = Slot("unfilled")


@kernel
def needs_a_slot(x):
    return unfilled(x) + 1.0


def test_a_slot_that_nothing_fills_is_refused(cache):
    with pytest.raises(TypeError, match="Nothing stands in for 'unfilled', which needs_a_slot calls: specialise it"):
        needs_a_slot(1.0)
    assert needs_a_slot.specialise(unfilled=own_law)(2.0) == own_law(2.0) + 1.0


def test_specialise_does_not_reach_into_what_it_puts_in(cache):
    """100 x + 1 with the law's own constant, in a template whose constant is 5."""
    assert template.specialise(law=own_law, CONSTANT=5.0)(2.0) == 10.0 * (201.0 + 5.0) + 5.0


def test_a_helper_shared_by_template_and_law_is_two_functions(cache):
    """The template's ``shared`` sees CONSTANT = 5, the law's the original 1."""
    result = template_with_shared_helper.specialise(law=law_with_shared_helper, CONSTANT=5.0)(2.0)
    assert result == 1000.0 * (2.0 + 1.0) + (2.0 + 5.0)


def test_the_fingerprint_tells_those_two_apart():
    """Where the law's ``shared`` is met first, the template's must still be entered with its own constant."""
    names = {"law": law_with_shared_helper}
    function = template_with_shared_helper.function
    marks = {fingerprint(function, {**names, "CONSTANT": value}) for value in (1.0, 5.0, 6.0)}
    assert len(marks) == 3


def test_equal_specialisations_are_one_kernel():
    assert template.specialise(law=own_law, CONSTANT=5.0) is template.specialise(CONSTANT=5.0, law=own_law)
    assert template.specialise(CONSTANT=5.0) is not template.specialise(CONSTANT=6.0)


def test_a_kernel_may_call_a_kernel(cache):
    @kernel
    def outer(x):
        return template(x) + CONSTANT

    assert outer(2.0) == 31.0 + 1.0
    assert outer.specialise(CONSTANT=3.0)(2.0) == 10.0 * (2.0 + 3.0) + 3.0 + 3.0


def test_row_reader_gives_a_tuple():
    assert row_reader(3)(np.arange(10.0), 4) == (4.0, 5.0, 6.0)
    assert row_reader(0)(np.arange(10.0), 4) == ()
    assert row_reader(3) is row_reader(3)


def test_division_by_zero_is_infinite_as_in_numpy(cache):
    @kernel
    def inverse(x):
        return 1.0 / x

    assert inverse(0.0) == np.inf


# --------------------------------------------------------------------------------------------------- the cache on disk


def test_a_changed_helper_in_another_module_is_compiled_anew(tmp_path):
    """What numba's own cache gets wrong: it watches the defining file only."""
    code = "import jit_main; print(jit_main.main(3.0), sum(jit_main.main.dispatcher.stats.cache_hits.values()))"
    (tmp_path / "jit_main.py").write_text(
        "from lmgcpy.compiled.kernel import kernel\nfrom jit_helper import f\n@kernel\ndef main(x):\n    return f(x)\n"
    )

    def run():
        return forked(code, folder=tmp_path, LMGCPY_CACHE_DIR=tmp_path / "cache").stdout.split()

    (tmp_path / "jit_helper.py").write_text("def f(x):\n    return 2.0 * x\n")
    assert run() == ["6.0", "0"]
    assert run() == ["6.0", "1"]
    (tmp_path / "jit_helper.py").write_text("def f(x):\n    return 4.0 * x\n")
    assert run() == ["12.0", "0"]


def test_functions_of_one_name_from_two_processes_stay_apart(tmp_path):
    """Two kernels made by two processes from one template; numba alone numbers its functions in each process anew, gives
    both helpers the same name in the machine code, and the linker of a third process keeps the first of them for both."""
    source = """
        import sys
        import numpy as np
        from lmgcpy.compiled.kernel import kernel, statistics
        FACTOR = 0.0
        def helper(x):
            for i in range(x.shape[0]):
                LONG
            return FACTOR
        @kernel
        def main(x):
            return helper(x) + helper(x[1:])
        print(*[main.specialise(FACTOR=float(f))(np.ones(3)) for f in sys.argv[1:]], len(statistics().compiled))
    """
    too_long_to_be_put_in_where_it_is_called = "; ".join(["x[i] += np.sin(x[i - 1]) * np.sin(x[i])"] * 24)
    source = textwrap.dedent(source).replace("LONG", too_long_to_be_put_in_where_it_is_called)
    (tmp_path / "jit_twins.py").write_text(source)
    cache = {"LMGCPY_CACHE_DIR": tmp_path / "cache"}
    outputs = [
        forked("import jit_twins", *factors, folder=tmp_path, **cache).stdout.split()
        for factors in (["1"], ["2"], ["1", "2"])
    ]
    assert outputs == [["2.0", "1"], ["4.0", "1"], ["2.0", "4.0", "0"]]


def test_the_cache_directory_is_the_one_asked_for(cache):
    assert cache_directory() == cache

    @kernel
    def identity(x):
        return x

    assert identity(1.0) == 1.0
    assert [path.name.split("-")[0] for path in cache.glob("kernels/*.kernel")] == ["identity"]


def test_without_a_directory_asked_for_it_is_the_users(monkeypatch):
    for name in ("LMGCPY_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", "/home/somebody")
    assert cache_directory().is_relative_to("/home/somebody")
    assert cache_directory().name == "lmgcpy"


def test_a_directory_that_cannot_be_written_is_told_once_and_everything_works(tmp_path, monkeypatch):
    """Below a regular file no directory can be made, not even by root."""
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("LMGCPY_CACHE_DIR", str(tmp_path / "file" / "cache"))
    first = kernel(lambda x: x + 1.0)
    with pytest.warns(RuntimeWarning, match="cannot keep compiled kernels in .*file/cache.*Set LMGCPY_CACHE_DIR") as told:
        assert first(1.0) == 2.0
    assert len(told) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert kernel(lambda x: x + 2.0)(1.0) == 3.0


def counted(function, *arguments):
    """The result of a kernel made anew, and how many kernels came from the cache and from the compiler for it."""
    before = statistics()
    result = kernel(function)(*arguments)
    after = statistics()
    return result, len(after.loaded) - len(before.loaded), len(after.compiled) - len(before.compiled)


def shifted(x):
    return x + 5.0


def test_statistics_count_signatures(cache):
    assert counted(shifted, 1.0) == (6.0, 0, 1)
    assert counted(shifted, 1.0) == (6.0, 1, 0)
    assert counted(shifted, 1) == (6.0, 0, 1)
    assert statistics().compiled[-1] == f"shifted-{fingerprint(shifted)} (int64,)"


@pytest.mark.default_parameters("beginning", "one byte in the middle")
@pytest.mark.parametrize(
    "damage",
    [
        lambda whole: b"",
        lambda whole: whole[:20],
        lambda whole: whole[:-1],
        lambda whole: bytes(len(whole)),
        lambda whole: whole[: len(whole) // 2] + b"?" + whole[len(whole) // 2 + 1 :],
    ],
    ids=["empty", "beginning", "last byte missing", "zeros", "one byte in the middle"],
)
def test_a_damaged_file_is_compiled_again_and_replaced(cache, damage):
    """Machine code that was cut or changed would not raise an error but end the process, or compute something else."""
    counted(shifted, 1.0)
    (path,) = cache.glob("kernels/*.kernel")
    whole = path.read_bytes()
    path.write_bytes(damage(whole))
    assert path.read_bytes() != whole
    assert counted(shifted, 1.0) == (6.0, 0, 1)
    assert counted(shifted, 1.0) == (6.0, 1, 0)


def test_a_file_that_is_whole_but_of_no_use_is_compiled_again(cache):
    """What it names is no longer there, for example."""
    counted(shifted, 1.0)
    (path,) = cache.glob("kernels/*.kernel")
    useless = pickle.dumps(("not", "what", "numba", "keeps"))
    path.write_bytes(hashlib.sha256(useless).digest() + useless)
    assert counted(shifted, 1.0) == (6.0, 0, 1)
    assert counted(shifted, 1.0) == (6.0, 1, 0)


def test_a_cache_that_can_only_be_read_is_read_in_silence(cache, monkeypatch):
    """One that came with an image, filled: a warning comes where something is missing."""
    counted(shifted, 1.0)
    monkeypatch.setattr(os, "replace", refuse)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert counted(shifted, 1.0) == (6.0, 1, 0)
    with pytest.warns(RuntimeWarning, match="cannot keep compiled kernels"):
        assert counted(shifted, 1) == (6.0, 0, 1)
    assert len(list(cache.glob("kernels/*"))) == 1


class Planted:
    """What makes a file when it is unpickled."""

    def __init__(self, path):
        self.path = str(path)

    def __reduce__(self):
        return open, (self.path, "w")


def plant(path, came):
    """Put code that leaves a sign into a kernel's file, whole by its digest."""
    code = pickle.dumps(Planted(came))
    path.write_bytes(hashlib.sha256(code).digest() + code)


def give_away(*paths):
    """To the user that owns nothing."""
    for path in paths:
        os.chown(path, 65534, 65534)


of_root = pytest.mark.skipif(getattr(os, "geteuid", lambda: 1)() != 0, reason="only root can give files away")
posix = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="Windows knows neither these modes nor pipes with names")
OPENINGS = {
    "the directory of kernels": lambda file: file.parent.chmod(0o777),
    "the directory above": lambda file: file.parent.parent.chmod(0o777),
    "sticky": lambda file: file.parent.chmod(0o1777),
    "a group's": lambda file: (os.chown(file.parent, -1, 12345), file.parent.chmod(0o775)),
    "the file": lambda file: file.chmod(0o666),
    "a directory of nobody's": lambda file: give_away(file.parent),
    "a file of nobody's": lambda file: give_away(file),
    "all of nobody's": lambda file: give_away(file.parent.parent, file.parent, file),
}


@pytest.mark.default_parameters("the directory above", "the file", "a file of nobody's")
@posix
@pytest.mark.parametrize(
    "opening", [pytest.param(what, marks=of_root if "nobody" in what or "group" in what else ()) for what in OPENINGS]
)
def test_what_others_may_have_written_is_not_run(cache, tmp_path, opening):
    """It is compiled again, with one line, and works."""
    counted(shifted, 1.0)
    (path,) = cache.glob("kernels/*.kernel")
    came = tmp_path / "came"
    plant(path, came)
    OPENINGS[opening](path)
    with pytest.warns(RuntimeWarning, match="does not use .*compiled kernels? .* as (it belongs|others may)") as told:
        assert counted(shifted, 1.0) == (6.0, 0, 1)
    assert not came.exists()
    assert len(told) == 1
    assert counted(lambda x: x + 7.0, 1.0)[0] == 8.0  # and nothing is said twice
    if "file" in opening:  # it is replaced by one that is the user's
        assert counted(shifted, 1.0) == (6.0, 1, 0)


@posix
def test_a_cache_of_the_users_own_is_used_whatever_the_mask_of_its_files(cache):
    """The mask of some systems lets the user's own group write; files are made without."""
    before = os.umask(0)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            assert counted(shifted, 1.0) == (6.0, 0, 1)
            assert counted(shifted, 1.0) == (6.0, 1, 0)
            os.chown(cache, -1, os.geteuid())
            cache.chmod(0o775)
            assert counted(shifted, 1.0) == (6.0, 1, 0)
    finally:
        os.umask(before)


@pytest.mark.default_parameters("pipe")
@posix
@pytest.mark.parametrize("what", ["pipe", "folder", "link to a pipe"])
def test_what_is_no_file_has_a_kernels_name_and_nobody_waits_for_it(cache, what):
    """Before, a pipe was opened to be read, and waited for somebody to write."""
    counted(shifted, 1.0)
    (path,) = cache.glob("kernels/*.kernel")
    path.unlink()
    if what == "folder":
        path.mkdir()
    else:
        os.mkfifo(path if what == "pipe" else cache / "pipe")
        if what != "pipe":
            path.symlink_to(cache / "pipe")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore" if what == "folder" else "error")  # a folder is not removed
        assert counted(shifted, 1.0) == (6.0, 0, 1)
        assert counted(shifted, 1.0) == (6.0, 0, 1) if what == "folder" else (6.0, 1, 0)


def refuse(*arguments):
    raise PermissionError(errno.EACCES, "Permission denied")


def test_code_with_addresses_of_this_process_is_not_kept(cache):
    table = np.zeros(200_000)  # numba takes the address of a global array of more than a megabyte
    table[3] = 7.0
    with pytest.warns(RuntimeWarning, match=r"cannot be kept, as lambda-\w+ reads a global array.*every process compiles"):
        assert kernel(lambda i: table[i])(3) == 7.0
    assert not list(cache.glob("kernels/*"))


def test_source_that_is_in_no_file_is_cached_too(cache, monkeypatch):
    """A law typed in at a prompt, which has no module; what others have put among the builtins is not kept with it."""
    monkeypatch.setattr(builtins, "cannot_be_pickled", threading.Lock(), raising=False)
    scope = {}
    exec("def typed(x):\n    return 3.0 * x", scope)
    assert counted(scope["typed"], 2.0) == (6.0, 0, 1)
    assert counted(scope["typed"], 2.0) == (6.0, 1, 0)


@pytest.mark.long
def test_importing_lmgcpy_compiles_nothing_and_brings_no_heavy_library():
    code = """
import numba.core.event as event
recorder = event.RecordingListener()
event.register("numba:run_pass", recorder)
import lmgcpy, sys
heavy = [name for name in ("pyvista", "vtk", "matplotlib", "h5py") if name in sys.modules]
print(len(recorder.buffer), *heavy)
"""
    assert process(code).stdout.split() == ["0"]


HOMELESS = """
import os, pwd, warnings
def nobody(user):
    raise KeyError(user)
pwd.getpwuid = nobody
from lmgcpy.compiled.kernel import kernel
from lmgcpy.compiled.cache import cache_directory
with warnings.catch_warnings(record=True) as told:
    warnings.simplefilter("always")
    results = [kernel(lambda x: x + 1.0)(1.0), kernel(lambda x: x + 2.0)(1.0)]
print(results, len(told), told[0].message, os.listdir())
cache_directory()
"""


@pytest.mark.long
def test_without_a_home_directory_kernels_are_not_kept_and_one_line_names_the_way_out(tmp_path):
    """A user whom the system does not know, as in a container; where the directory is asked for there is an error."""
    pytest.importorskip("pwd")
    environment = {name: value for name, value in os.environ.items() if name not in ("HOME", "LMGCPY_CACHE_DIR")}
    environment = {name: value for name, value in environment.items() if not name.startswith("XDG_")}
    done = subprocess.run([sys.executable, "-c", HOMELESS], env=environment, capture_output=True, text=True, cwd=tmp_path)
    assert done.stdout.startswith("[2.0, 3.0] 1 lmgcpy finds no directory for compiled kernels"), done.stderr
    assert "Set LMGCPY_CACHE_DIR to a directory that can be written." in done.stdout
    assert done.stdout.endswith(" []\n")
    last = done.stderr.splitlines()[-1]
    assert last.startswith("FileNotFoundError: lmgcpy finds no directory for compiled kernels, as this user has no home")
    assert "Set LMGCPY_CACHE_DIR" in last
