"""What threads need to agree in compiled code: reading, writing and claiming a number at once."""

from __future__ import annotations

from typing import Any

from numba.core import cgutils, types

from lmgcpy.compiled.kernel import intrinsic

ALIGNED = 8
"""Bytes of the numbers, int64."""


def _place(context, builder, kind, array, index):
    """Pointer to an entry of an array."""
    whole = context.make_array(kind)(context, builder, array)
    return cgutils.get_item_pointer(context, builder, kind, whole, [index])


def _load(typing_context, array, index):
    """``array[index]``, with all that was written before it was."""

    def generate(context, builder, signature, arguments):
        place = _place(context, builder, signature.args[0], *arguments)
        return builder.load_atomic(place, "seq_cst", ALIGNED)

    return types.int64(array, types.intp), generate


def _store(typing_context, array, index, value):
    """``array[index] = value``, after all that was written before."""

    def generate(context, builder, signature, arguments):
        place = _place(context, builder, signature.args[0], *arguments[:2])
        builder.store_atomic(arguments[2], place, "seq_cst", ALIGNED)
        return context.get_dummy_value()

    return types.void(array, types.intp, types.int64), generate


def _add(typing_context, array, index, value):
    """``array[index] += value`` at once; returns what was there."""

    def generate(context, builder, signature, arguments):
        place = _place(context, builder, signature.args[0], *arguments[:2])
        return builder.atomic_rmw("add", place, arguments[2], "seq_cst")

    return types.int64(array, types.intp, types.int64), generate


def _exchange(typing_context, array, index, expected, value):
    """``array[index] = value`` if ``expected`` is there, at once; returns whether it was."""

    def generate(context, builder, signature, arguments):
        place = _place(context, builder, signature.args[0], *arguments[:2])
        result = builder.cmpxchg(place, arguments[2], arguments[3], "seq_cst", "seq_cst")
        return builder.extract_value(result, 1)

    return types.boolean(array, types.intp, types.int64, types.int64), generate


def _load_alone(array, index):
    """The same of one thread, in Python; as what follows."""
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
