"""Named tuples of arrays that kernels take by reference.

For the compiler a tuple passed by value is hundreds of numbers, at each use of its name. By reference, only the fields that
are read are loaded: an array or a number. A field that is a named tuple is a reference again.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.datamodel import models
from numba.core.imputils import lower_getattr_generic
from numba.core.typing.templates import AttributeTemplate, infer_getattr
from numba.extending import NativeValue, register_model, typeof_impl, unbox

_NAMED = types.NamedTuple, types.NamedUniTuple
ADDRESS = cgutils.voidptr_t


class ReferenceType(types.Type):
    """Type of a reference to a named tuple ``kind`` in memory that does not change as long as kernels read it."""

    def __init__(self, kind: Any):
        self.kind = kind
        super().__init__(name=f"reference({kind})")


def by_reference(tuple_class: Any) -> Any:
    """Decorator of a class of named tuples: kernels take them by reference."""
    typeof_impl.register(tuple_class)(lambda value, purpose: ReferenceType(_kind(value, purpose)))
    return tuple_class


def _kind(value: Any, purpose: Any) -> Any:
    """Type of a named tuple by value, and of the named tuples in it."""
    members = [_kind(member, purpose) if hasattr(member, "_fields") else typeof_impl(member, purpose) for member in value]
    return types.BaseTuple.from_types(members, type(value))


@register_model(ReferenceType)
class _Model(models.OpaqueModel):
    """An address."""


@infer_getattr
class _Field(AttributeTemplate):
    key = ReferenceType

    def generic_resolve(self, reference: ReferenceType, name: str) -> Any:  # type: ignore[override]
        """Type of a field; None if the tuple has no field of this name."""
        if name not in reference.kind.fields:
            return None
        member = reference.kind.types[reference.kind.fields.index(name)]
        return ReferenceType(member) if isinstance(member, _NAMED) else member


@lower_getattr_generic(ReferenceType)
def _load_field(context, builder, reference, address, name):
    index = reference.kind.fields.index(name)
    member = reference.kind.types[index]
    place = cgutils.gep_inbounds(builder, _typed(context, builder, reference.kind, address), 0, index)
    if isinstance(member, _NAMED):
        return builder.bitcast(place, ADDRESS)
    model = context.data_model_manager[member]
    if not isinstance(member, types.Array):
        return model.from_data(builder, _load(builder, place))
    # an array that owns no memory: who laid it keeps it alive, and its reader counts no references
    array = ir.Constant(model.get_value_type(), None)
    for field in ("nitems", "itemsize", "data", "shape", "strides"):
        k = model.get_field_position(field)
        array = builder.insert_value(array, _load(builder, cgutils.gep_inbounds(builder, place, 0, k)), k)
    return array


def _load(builder, place):
    """Load a value that no store of a kernel changes: the compiler may load it before a loop instead of in it."""
    loaded = builder.load(place)
    loaded.set_metadata("invariant.load", builder.module.add_metadata([]))
    return loaded


@unbox(ReferenceType)
def _from_python(reference, value, c):
    place = cgutils.alloca_once(c.builder, c.context.data_model_manager[reference.kind].get_data_type())
    taken: list[Any] = []
    failed = _store_fields(reference.kind, value, place, c, taken)

    def give_back():
        for kind, native in taken:
            c.context.nrt.decref(c.builder, kind, native)

    # loads by a reference may be moved before any store: nobody can know this address before the last one of these
    same = ir.FunctionType(ADDRESS, [ADDRESS])
    address = c.builder.asm(same, "", "=r,0,~{memory}", [c.builder.bitcast(place, ADDRESS)], True)
    return NativeValue(address, is_error=failed, cleanup=give_back if c.context.enable_nrt else None)


def _store_fields(kind, value, place, c, taken):
    """Lay a tuple of Python; returns whether that failed, and appends the fields that were ``taken``."""
    failed = cgutils.false_bit
    for k, member in enumerate(kind.types):
        item = c.pyapi.tuple_getitem(value, k)
        here = cgutils.gep_inbounds(c.builder, place, 0, k)
        if isinstance(member, _NAMED):
            error = _store_fields(member, item, here, c, taken)
        else:
            native = c.unbox(member, item)
            error = native.is_error
            taken.append((member, native.value))
            c.builder.store(c.context.data_model_manager[member].as_data(c.builder, native.value), here)
        failed = c.builder.or_(failed, error)
    return failed


def _typed(context, builder, kind, address):
    return builder.bitcast(address, context.data_model_manager[kind].get_data_type().as_pointer())


def copy_words(context, builder, reference, address, target):
    """Copy the tuple behind a reference; returns the number of bytes."""
    source = _typed(context, builder, reference.kind, address)
    size = context.get_abi_sizeof(source.type.pointee)
    cgutils.raw_memcpy(builder, builder.inttoptr(target, source.type), source, cgutils.intp_t(1), size)
    return size
