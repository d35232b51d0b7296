"""Numbers that several threads share in compiled code: each read, write, sum or exchange is one step that no other thread
can cut in two."""

from __future__ import annotations

from typing import Any

from numba.core import cgutils, types

from lmgcpy.compiled.kernel import intrinsic

ALIGNED = 8
"""Size and alignment of the numbers, int64 [bytes]."""


def _pointer(context, builder, kind, array, index):
    """Pointer to an entry of an array."""
    whole = context.make_array(kind)(context, builder, array)
    return cgutils.get_item_pointer(context, builder, kind, whole, [index])


def _load(typing_context, array, index):
    """``array[index]``; everything that its writer wrote before is visible afterwards."""

    def generate(context, builder, signature, arguments):
        pointer = _pointer(context, builder, signature.args[0], *arguments)
        return builder.load_atomic(pointer, "seq_cst", ALIGNED)

    return types.int64(array, types.intp), generate


def _store(typing_context, array, index, value):
    """``array[index] = value``; who reads it sees all that was written before."""

    def generate(context, builder, signature, arguments):
        pointer = _pointer(context, builder, signature.args[0], *arguments[:2])
        builder.store_atomic(arguments[2], pointer, "seq_cst", ALIGNED)
        return context.get_dummy_value()

    return types.void(array, types.intp, types.int64), generate


def _add(typing_context, array, index, value):
    """``array[index] += value`` as one step; returns the old value."""

    def generate(context, builder, signature, arguments):
        pointer = _pointer(context, builder, signature.args[0], *arguments[:2])
        return builder.atomic_rmw("add", pointer, arguments[2], "seq_cst")

    return types.int64(array, types.intp, types.int64), generate


def _exchange(typing_context, array, index, expected, value):
    """``array[index] = value`` if ``expected`` is there, as one step; returns whether it was."""

    def generate(context, builder, signature, arguments):
        pointer = _pointer(context, builder, signature.args[0], *arguments[:2])
        result = builder.cmpxchg(pointer, arguments[2], arguments[3], "seq_cst", "seq_cst")
        return builder.extract_value(result, 1)

    return types.boolean(array, types.intp, types.int64, types.int64), generate


def _load_alone(array, index):
    """Replaces the atomic load if kernels run as plain Python, in one thread; the three functions below do the same."""
    return array[index]


def _store_alone(array, index, value):
    array[index] = value


def _add_alone(array, index, value):
    before = array[index]
    array[index] += value
    return before


def _exchange_alone(array, index, expected, value):
    is_there = array[index] == expected
    if is_there:
        array[index] = value
    return is_there


load: Any = intrinsic(_load_alone)(_load)
store: Any = intrinsic(_store_alone)(_store)
add: Any = intrinsic(_add_alone)(_add)
exchange: Any = intrinsic(_exchange_alone)(_exchange)
