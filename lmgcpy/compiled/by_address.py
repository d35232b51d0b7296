"""Calls of compiled functions by their addresses, and named tuples read and written by theirs.

A function that is called by address is compiled by itself, once, and its caller does not know the types of the arguments
that it passes on: the driver of a solver is one piece of machine code for 2D, 3D and assembled problems. (Passed by value,
the three hundred numbers of a step's arrays cost the compiler a second at every call.)
"""

from __future__ import annotations

import ctypes
import hashlib
import os
from functools import cache
from typing import Any

import numba
from llvmlite import ir
from numba.core import types

from lmgcpy.compiled.fingerprint import described
from lmgcpy.compiled.kernel import Pointer, intrinsic
from lmgcpy.compiled.reference import ADDRESS, copy_words

ROOM = 1024
"""Memory for a named tuple of arrays [words of 8 bytes]."""


def _write(typing_context, address, value):
    """``*address = value`` for a tuple of arrays and numbers; returns a hash of the type of the value."""
    kind = int(hashlib.sha256(described(value).encode()).hexdigest()[:15], 16)

    def generate(context, builder, signature, arguments):
        size = copy_words(context, builder, value, arguments[1], arguments[0])
        assert size <= 8 * ROOM
        return context.get_constant(types.int64, kind)

    return types.int64(types.int64, value), generate


def _call(typing_context, address, start, stop, offset, s):
    """``double f(int64 start, int64 stop, int64 offset, System s)`` at an address."""

    def generate(context, builder, signature, arguments):
        kinds = [context.get_value_type(kind) for kind in signature.args[1:]]
        function = ir.FunctionType(context.get_value_type(signature.return_type), kinds)
        return builder.call(builder.inttoptr(arguments[0], function.as_pointer()), arguments[1:])

    return types.float64(address, start, stop, offset, s), generate


def _call_work(typing_context, address, kind, task, job):
    """``void work(int64 kind, int64 task, void *job)`` at an address."""

    def generate(context, builder, signature, arguments):
        whole = ir.IntType(64)
        function = ir.FunctionType(ir.VoidType(), [whole, whole, ADDRESS])
        job_pointer = builder.inttoptr(arguments[3], ADDRESS)
        builder.call(builder.inttoptr(arguments[0], function.as_pointer()), [*arguments[1:3], job_pointer])
        return context.get_dummy_value()

    return types.void(types.int64, types.int64, types.int64, types.int64), generate


def _call_at(typing_context, address):
    """``int f()`` at an address."""

    def generate(context, builder, signature, arguments):
        function = ir.FunctionType(ir.IntType(32), [])
        return builder.call(builder.inttoptr(arguments[0], function.as_pointer()), [])

    return types.int32(types.int64), generate


_written: dict[int, Any] = {}
"""Tuples by address, for kernels that run as plain Python. An address that is used again keeps only the last tuple."""


def _call_in_python(address, *arguments):
    return Pointer.functions[int(address)](*arguments)


def _work_in_python(address, kind, task, job):
    return Pointer.functions[int(address)](kind, task, _written[int(job)])


def _write_in_python(address, value):
    _written[int(address)] = value
    return 0  # one function serves all types


write: Any = intrinsic(_write_in_python)(_write)
call: Any = intrinsic(_call_in_python)(_call)
"""``call(address, start, stop, offset, s)`` in compiled code."""
call_work: Any = intrinsic(_work_in_python)(_call_work)
call_at: Any = intrinsic(lambda address: 0)(_call_at)


def group_signature(system_type):
    """numba signature of the kernels that :func:`call` calls."""
    return types.float64(types.int64, types.int64, types.int64, system_type)


def work_signature(job):
    """numba signature of the kernels that :func:`call_work` calls on such a job."""
    return types.void(types.int64, types.int64, numba.typeof(job))


@cache
def giving_way() -> int:
    """Address of the system's function by which a thread lets others run."""
    library: Any = ctypes.WinDLL("kernel32") if os.name == "nt" else ctypes.CDLL(None)  # type: ignore[attr-defined]
    function = library.SwitchToThread if os.name == "nt" else library.sched_yield
    address = ctypes.cast(function, ctypes.c_void_p).value
    assert address is not None
    return address
