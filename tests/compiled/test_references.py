"""Named tuples by reference: kernels read of them what they would read of the tuples."""

from __future__ import annotations

import collections
import sys
from typing import NamedTuple

import numba
import numpy as np
import pytest

from lmgcpy.compiled.fingerprint import described
from lmgcpy.compiled.kernel import CompilerError, inlined, kernel
from lmgcpy.compiled.reference import ReferenceType, by_reference


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    """An empty cache directory: what is tested here is in no kernel's fingerprint."""
    monkeypatch.setenv("LMGCPY_CACHE_DIR", str(tmp_path))


class Inner(NamedTuple):
    table: np.ndarray
    flag: bool


@by_reference
class Outer(NamedTuple):
    count: int
    values: np.ndarray
    inner: Inner
    factor: float


def outer(table, flag=True):
    return Outer(3, np.arange(4.0), Inner(table, flag), 0.5)


@kernel
def everything(outer):
    """A number that every field takes part in."""
    total = outer.factor * outer.values.sum() + outer.count * outer.values.shape[0]
    for row in range(outer.inner.table.shape[0]):
        for column in range(outer.inner.table.shape[1]):
            total += 10.0 * outer.inner.table[row, column] * (row + 1) * (column + 2)
    return total + entry(outer.inner) if outer.inner.flag else -total


def entry(inner):
    return 1000.0 * inner.table[0, 1]


TABLES = {
    "in a row": np.arange(6.0).reshape(2, 3),
    "by columns": np.arange(6.0).reshape(3, 2).T,
    "every other": np.arange(24.0).reshape(4, 6)[::2, ::2],
    "whole numbers": np.arange(6, dtype=np.int32).reshape(2, 3),
    "not to be written": np.broadcast_to(2.0, (2, 3)),
}


@pytest.mark.default_parameters(flag=(True,))
@pytest.mark.parametrize("flag", [True, False])
@pytest.mark.parametrize("table", TABLES)
def test_a_kernel_reads_what_python_reads(table, flag):
    given = outer(TABLES[table], flag)
    assert everything(given) == everything.function(given)


def test_nested_tuples_are_references_as_well_and_classes_that_are_not_marked_are_none():
    assert isinstance(numba.typeof(outer(np.zeros((1, 2)))), ReferenceType)
    assert not isinstance(numba.typeof(Inner(np.zeros((1, 2)), True)), ReferenceType)


@kernel
def add_up(outer, steps):
    """What is written in one step is read in the next."""
    for _ in range(steps):
        for i in range(1, outer.values.shape[0]):
            outer.values[i] += outer.values[i - 1]
    return outer.values[-1]


def test_what_a_kernel_writes_to_an_array_is_read_by_it_and_by_python():
    given = outer(np.zeros((1, 2)))
    values = given.values.copy()
    for _ in range(3):
        values = np.cumsum(values)
    assert add_up(given, 3) == values[-1]
    assert given.values.tolist() == values.tolist()


@kernel
def foreign(outer):
    return outer.values.sum() + outer.inner.table.sum()


def test_a_kernel_that_counts_references_gives_the_arrays_back():
    """This module is not lmgcpy's: its kernels count."""
    given = outer(np.zeros((1, 2)))
    foreign(given)
    before = sys.getrefcount(given.values), sys.getrefcount(given.inner.table)
    for _ in range(10):
        foreign(given)
    assert (sys.getrefcount(given.values), sys.getrefcount(given.inner.table)) == before


def test_tuples_of_one_name_with_other_fields_are_told_apart():
    def kind(*fields):
        made = by_reference(collections.namedtuple("Pair", fields))
        return described(numba.typeof(made(1.0, 2.0)))

    assert kind("a", "b") == kind("a", "b")
    assert kind("a", "b") != kind("b", "a")


def test_a_field_that_is_not_there_is_named():
    @kernel
    def wrong(outer):
        return outer.nothing

    with pytest.raises(CompilerError, match="nothing"):
        wrong(outer(np.zeros((1, 2))))


# --------------------------------------------------------------------------------- functions that only kernels call


def twice(x):
    return 2.0 * x


@inlined
def thrice(x):
    return 3.0 * x


@kernel
def calls(x):
    return twice(x) + thrice(x) + max(x, 1.0)


def test_a_function_that_only_kernels_call_is_made_machine_code_with_them_alone():
    """Its own code has been neither optimised nor loaded; that of the kernel holds it."""
    assert calls(2.0) == 12.0
    scope = calls.dispatcher.py_func.__globals__
    for name in ("twice", "thrice"):
        (made,) = scope[name].overloads.values()
        assert made.library.get_pointer_to_function(made.fndesc.llvm_func_name) == 0
    (made,) = calls.dispatcher.overloads.values()
    assert made.library.get_pointer_to_function(made.fndesc.llvm_cpython_wrapper_name) != 0


def test_a_function_that_is_marked_so_is_put_into_every_kernel():
    calls(2.0)
    scope = calls.dispatcher.py_func.__globals__
    marked = {}
    for name in ("twice", "thrice"):
        (made,) = scope[name].overloads.values()
        marked[name] = "alwaysinline" in made.library.get_llvm_str()
    assert marked == {"twice": False, "thrice": True}
