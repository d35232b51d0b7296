"""Functions whose code only kernels hold do there what they do under numba: print, raise, call Python."""

from __future__ import annotations

import pytest
from forks import forked

TALKING = """
from lmgcpy.compiled.kernel import kernel, statistics

@kernel
def told(x):
    print("x is", x)
    return 2 * x

@kernel
def refused(x):
    if x > 4:
        raise ValueError("too much", x)
    return told(x)

@kernel
def main(x):
    return refused(x) + 1
"""
RUN = """
import talking
print(talking.main(2.0))
try:
    talking.main(5.0)
except ValueError as error:
    print(error.args)
print(len(talking.statistics().loaded))
"""
PYTHON_IN_BETWEEN = """
import warnings, numba
from lmgcpy.compiled.kernel import kernel

@kernel
def inner(x):
    with numba.objmode(y="float64"):
        y = float(str(x) + "1")
    return y

@kernel
def main(x):
    return 2 * inner(x)

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    print(main(2.5))
"""


@pytest.mark.parametrize("loaded", [False, True], ids=["compiled", "loaded"])
def test_a_function_prints_and_raises_what_it_names(loaded, tmp_path):
    (tmp_path / "talking.py").write_text(TALKING)
    for _ in range(1 + loaded):
        out = forked(RUN, folder=tmp_path, LMGCPY_CACHE_DIR=tmp_path / "cache").stdout
    assert out.splitlines() == ["x is 2.0", "5.0", "('too much', 5.0)", str(int(loaded))]


def test_a_function_calls_python(tmp_path):
    out = forked(PYTHON_IN_BETWEEN, strict=False, LMGCPY_CACHE_DIR=tmp_path / "cache").stdout
    assert out == "5.02\n"
