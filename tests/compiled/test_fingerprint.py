"""What the compiler may read without its content being known: no machine code of an older content is ever run.

Each case is a module ``jit_law`` that is edited between two processes with one cache; the second must give the new answer.
Where the content is known the kernel is kept, and loaded by a third process; else one line says why it is not.
"""

import cProfile
import functools
import re
import textwrap

import pytest
from forks import forked
from soft_law import process, soft_law

from lmgcpy.compiled import fingerprint as content
from lmgcpy.compiled.cache import cache_directory, extension_in_use
from lmgcpy.compiled.fingerprint import Content
from lmgcpy.compiled.kernel import fingerprint, kernel

ENUM = "from enum import Enum\nclass Mode(Enum):\n    A = 1.5\n    B = 9.0\n"
ARRAY = "import numpy as np\na = np.zeros(2000)\na[500] = 1.5\n"
MODULE = "import types\nm = types.ModuleType('m')\nm.G = 1.5\n"
OVERLOAD = "from numba.extending import overload, overload_attribute, overload_method\nfrom numba import types\n"
INTRINSIC = """
from numba.extending import intrinsic
from llvmlite import ir
FACTOR = 1.5
@intrinsic
def f(typing_context, x):
    def generate(context, builder, signature, arguments):
        return builder.fmul(arguments[0], ir.Constant(ir.DoubleType(), FACTOR))
    return x(x), generate
"""

NJIT = "import numba\n@numba.njit(OPTIONS)\ndef f(x):\n    CODE\n"
# beginning of the module, expression of x = 3
KEPT = {
    "member of an Enum": (ENUM, "x * Mode.A.value"),
    "tuple of members": (ENUM + "T = (Mode.A, Mode.B)\n", "x * T[0].value"),
    "long array in a tuple": (ARRAY + "T = (a, 1)\n", "x * T[0][500]"),
    "long array as a default": (ARRAY + "def f(x, a=a):\n    return a[500] * x\n", "f(x)"),
    "attribute that a module computes": (
        "import sys, types\nclass M(types.ModuleType):\n    G = property(lambda self: 1.5)\nm = M('m')\n", "x * m.G"),
    "constant put into numpy": ("import numpy as np\nnp.jit_law_constant = 1.5\n", "x * np.jit_law_constant"),
    "njit helper put into math": (
        "import math, numba\n@numba.njit\ndef f(x):\n    return 1.5 * x\nmath.jit_law_f = f\n", "math.jit_law_f(x)"),
    "options of a njit helper": (
        NJIT.replace("OPTIONS", "fastmath=1.5 > 2.0").replace("CODE", "return 1.0 if x * 1e308 == np.inf else 0.0")
        + "import numpy as np\n", "f(x * 10.0)"),
    "types of a njit helper's variables": (
        "import numba\nW = numba.float64 if 1.5 > 2.0 else numba.float32\n"
        + NJIT.replace("OPTIONS", "locals={'y': W}").replace("CODE", "y = x; return y"), "f(x / 7.0)"),
}  # fmt: skip
NOT_KEPT = {
    "vectorize": ("import numba\n@numba.vectorize\ndef f(x):\n    return 1.5 * x\n", "f(x)", "'f', an object of .*DUFunc"),
    "guvectorize": (
        "import numba, numpy as np\n@numba.guvectorize('(n)->(n)')\ndef g(x, y):\n    y[0] = 1.5 * x[0]\n"
        "def f(x):\n    y = np.zeros(1)\n    g(np.ones(1), y)\n    return y[0]\n", "f(x)", "'g', an object of .*GUFunc"),
    "intrinsic that reads a constant": (INTRINSIC, "f(x)", "'f', an object of .*_Intrinsic"),
    "njit helper with a signature": (
        "import numba\n@numba.njit('float64(float64)' if 1.5 > 2.0 else 'float32(float32)')\ndef f(x):\n    return x\n",
        "f(x / 7.0)", "'f', a numba.jit function with signatures"),
    "C function": (
        "import numba\n@numba.cfunc('float64(float64)')\ndef f(x):\n    return 1.5 * x\n", "f(x)", "'f', an object"),
    "jitclass": (
        "import numba\nfrom numba.experimental import jitclass\n@jitclass([('a', numba.float64)])\nclass P:\n"
        "    def __init__(self, a):\n        self.a = 1.5 * a\n", "P(x).a", "'P', the class jit_law.P"),
    "number that hides its value": (
        "class F(float):\n    def __repr__(self):\n        return 'F'\nG = F(1.5)\n", "x * G",
        "'G', an object of jit_law.F"),
    "getattr": (MODULE, "x * getattr(m, 'G')", "'getattr', which"),
    "module handed on": (MODULE + "def f(m, x):\n    return x * m.G\n", "f(m, x)", "'m', a module"),
    "module as a default": (MODULE + "def f(x, m=m):\n    return x * m.G\n", "f(x)", "a default argument"),
    "overload of a function of numpy": (
        OVERLOAD + "import numpy as np\n@overload(np.i0)\ndef i0(x):\n    return lambda x: 1.5 * x\n", "np.i0(x)",
        "jit_law.i0 has taught numba a 'i0' of its own"),
    "overload of a builtin": (
        OVERLOAD + "@overload(abs)\ndef size(x):\n    if isinstance(x, types.BaseTuple):\n"
        "        return lambda x: 1.5 * x[0]\n",
        "abs((x, x))", "jit_law.size has taught numba a 'abs' of its own"),
    "overload of an operator": (
        OVERLOAD + "import operator\n@overload(operator.mul)\ndef times(a, b):\n    if isinstance(a, types.BaseTuple):\n"
        "        return lambda a, b: 1.5 * a[0] * b\n", "(x, x) * 2.0", "jit_law.times has taught numba an operator"),
    "attribute of numbers": (
        OVERLOAD + "@overload_attribute(types.Float, 'half')\ndef half(x):\n    return lambda x: 1.5 * x\n", "x.half",
        "jit_law.half has taught numba a 'half' of its own"),
    "method of numbers": (
        OVERLOAD + "@overload_method(types.Float, 'half')\ndef half(x):\n    return lambda x: 1.5 * x\n", "x.half()",
        "jit_law.half has taught numba a 'half' of its own"),
    "Python in between": (
        "from numba import objmode\ndef g(x):\n    return 1.5 * x\n"
        "def f(x):\n    with objmode(y='float64'):\n        y = g(x)\n    return y\n", "f(x)", "'objmode', an object"),
    "stencil": (
        "import numba, numpy as np\n@numba.stencil\ndef g(a):\n    return 1.5 * a[0]\n"
        "def f(x):\n    return g(np.ones(5) * x)[2]\n", "f(x)", "'g', an object of .*StencilFunc"),
}  # fmt: skip
RUN = """
import jit_law
from lmgcpy.compiled.kernel import statistics
print(jit_law.main(3.0), len(statistics().loaded))
"""


@pytest.fixture
def run(tmp_path):
    """Function ``(source, **environment)``: what a process prints in words, and its errors."""

    def run(source, **environment):
        (tmp_path / "jit_law.py").write_text(textwrap.dedent(source))
        given = {"LMGCPY_CACHE_DIR": tmp_path / "cache", **environment}
        # numba reads its variables as it is imported
        run = process if any(name.startswith("NUMBA") for name in environment) else forked
        done = run(RUN, folder=tmp_path, strict=False, **given)
        return done.stdout.split(), done.stderr

    return run


def source_of(beginning, expression):
    return f"from lmgcpy.compiled.kernel import kernel\n{beginning}\n@kernel\ndef main(x):\n    return {expression}\n"


@pytest.mark.default_parameters("tuple of members", "long array as a default", "options of a njit helper")
@pytest.mark.parametrize("what", KEPT)
def test_content_that_is_known_is_told_apart_and_kept(what, run):
    first = source_of(*KEPT[what])
    second = first.replace("1.5", "2.5")
    assert second != first
    (old, loaded), _ = run(first)
    assert loaded == "0"
    (new, loaded), _ = run(second)
    assert (new != old, loaded) == (True, "0")
    assert run(second)[0] == [new, "1"]
    assert run(first) == ([old, "1"], "")


@pytest.mark.default_parameters("njit helper with a signature", "number that hides its value")
@pytest.mark.parametrize("what", NOT_KEPT)
def test_content_that_is_not_known_is_compiled_again_and_one_line_says_so(what, run):
    beginning, expression, words = NOT_KEPT[what]
    first = source_of(beginning, expression)
    second = first.replace("1.5", "2.5")
    assert second != first
    (old, _), told = run(first)
    assert told.count("A compiled kernel cannot be kept, as ") == 1
    assert re.search(words, told), told
    (new, loaded), _ = run(second)
    assert (new != old, loaded) == (True, "0")
    assert run(second)[0] == [new, "0"]


@pytest.mark.long
def test_what_numba_is_told_about_code_is_part_of_the_fingerprint(run):
    """Bounds are looked at only where ``NUMBA_BOUNDSCHECK`` asks for it; the array has no entry 8."""
    reading = "import numpy as np\ndef f(x):\n    a = np.ones(3)\n    try:\n        return 0.0 * a[int(x) + 5] + 1.0\n"
    source = source_of(reading + "    except Exception:\n        return -1.0\n", "f(x)")
    assert run(source, NUMBA_BOUNDSCHECK="0")[0][1] == "0"
    assert run(source, NUMBA_BOUNDSCHECK="1")[0] == ["-1.0", "0"]


@pytest.mark.long
def test_njit_helpers_of_one_name_from_two_processes_stay_apart(tmp_path):
    """numba numbers them in each process anew; of two of one name the linker of a third process keeps the first."""
    long = "; ".join(["x[i] += np.sin(x[i - 1]) * np.sin(x[i])"] * 24)  # too long to be put in where it is called
    (tmp_path / "twins.py").write_text(
        "import sys, numba, numpy as np\n"
        "from lmgcpy.compiled.kernel import kernel, statistics\n"
        "def make(factor):\n"
        "    @numba.njit\n"
        "    def helper(x):\n"
        "        for i in range(x.shape[0]):\n"
        f"            {long}\n"
        "        return factor\n"
        "    @kernel\n"
        "    def main(x):\n"
        "        return helper(x) + helper(x[1:])\n"
        "    return main\n"
        "print(*[make(float(f))(np.ones(3)) for f in sys.argv[1:]], len(statistics().compiled))\n"
    )
    run = functools.partial(forked, "import twins", strict=False, folder=tmp_path, LMGCPY_CACHE_DIR=tmp_path / "cache")
    outputs = [run(*factors).stdout.split() for factors in (["1"], ["2"], ["1", "2"])]
    assert outputs == [["2.0", "1"], ["4.0", "1"], ["2.0", "4.0", "0"]]


def test_what_was_changed_after_its_first_use_is_not_kept_under_the_old_mark(tmp_path, monkeypatch):
    """A table is changed between the first call and the first with another type: the second kernel has the new table."""
    import numpy as np

    monkeypatch.setenv("LMGCPY_CACHE_DIR", str(tmp_path))
    table = np.array([1.0])
    scaled = kernel(lambda x: table[0] * x)
    assert scaled(2.0) == 2.0
    table[0] = 5.0
    with pytest.warns(RuntimeWarning, match="cannot be kept, as what .*lambda.* reads was changed after its first use"):
        scaled(2)
    assert len(list(tmp_path.glob("kernels/*"))) == 1


def test_a_profiler_changes_no_fingerprint(tmp_path, monkeypatch):
    monkeypatch.setenv("LMGCPY_CACHE_DIR", str(tmp_path))
    doubled = kernel(lambda x: 2.0 * x)
    before = fingerprint(doubled.function)
    assert cProfile.Profile().runcall(doubled, 2.0) == 4.0
    assert fingerprint(doubled.function) == before


HELPER = """
import numba

@numba.vectorize
def closing(u):
    return max(0.0, -u)

def push(u):
    return closing(u)
"""
MAIN = "\ndef main(x):\n    return float(falling().run(steps=1).velocities[0, 1])\n"
LAW = soft_law("1.0 * push", before=HELPER) + MAIN


@pytest.mark.long
def test_a_law_of_such_a_helper_follows_its_edits_and_is_told_of_once(run):
    """Its sweep and its error read the helper; the line names the law's function, the helper and what it is."""
    everyones = {"LMGCPY_CACHE_DIR": cache_directory()}  # the kernels that the law has no part in are there
    (velocity, _), told = run(LAW, **everyones)
    assert velocity == "0.0"
    assert told.count("cannot be kept") == 1
    assert "jit_law.push (called by jit_law.Soft.react) reads 'closing', an object of numba.np.ufunc" in told
    assert run(LAW.replace("max(0.0, -u)", "max(0.0, -0.5 * u)"), **everyones)[0][0] == "-0.5"


def test_every_kernel_of_lmgcpy_itself_is_known():
    """Those that threads and drivers call have intrinsics of lmgcpy's own, whose constants are looked at."""
    from lmgcpy.compiled import by_address
    from lmgcpy.solve.sweeps import gauss_seidel, sweep, team

    for one in (team.lay, team.help_out, sweep.work, gauss_seidel.gauss_seidel):
        assert Content(one.function).unknown == []
    room, mark = by_address.ROOM, fingerprint(team.lay.function)
    try:
        by_address.ROOM = 2 * room
        assert fingerprint(team.lay.function) != mark
    finally:
        by_address.ROOM = room


def test_what_lmgcpy_adds_to_the_compiler_is_part_of_the_fingerprint(monkeypatch):
    def twice(x):
        return 2.0 * x

    marks = [fingerprint(twice), fingerprint(twice)]
    monkeypatch.setattr(content, "own_part", lambda: "another")
    assert marks[0] == marks[1] != fingerprint(twice)


def test_numba_alone_has_no_extensions():
    kernel(lambda x: x + 0.5)(1.0)
    assert extension_in_use({"abs", "sum", "dot"}) is None
