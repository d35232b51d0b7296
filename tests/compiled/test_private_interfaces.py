"""Private interfaces of numba: one room of the package uses them, and the versions of numba are those that were run."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import numba
import numpy as np
import pytest
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompileResult, compile_result
from numba.core.environment import Environment
from numba.core.errors import NumbaError
from numba.core.registry import cpu_target
from numba.core.typing.templates import builtin_registry

import lmgcpy

PACKAGE = Path(lmgcpy.__file__).parent
ROOM = PACKAGE / "compiled"
PUBLIC = {"numba", "numba.extending", "numba.typed", "numba.types"}
"""Modules of numba that its documentation promises to keep."""
PRIVATE = ("core", "np", "misc", "cpython", "parfors", "cuda", "typing", "stencils")
"""Parts of numba that it may change with every 0.x."""


def private_names(file: Path) -> Iterator[str]:
    """The modules and names of numba and llvmlite that a file uses and that numba does not promise to keep."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            found = [node.module if node.module in PUBLIC - {"numba"} else f"{node.module}.{a.name}" for a in node.names]
        elif isinstance(node, ast.Attribute):
            found = [ast.unparse(node)]
        else:
            continue
        for name in found:
            first, *rest = name.split(".")
            if first == "llvmlite" or (first == "numba" and rest and rest[0] in PRIVATE):
                yield name


def used_in_the_room() -> list[str]:
    return sorted({name for file in ROOM.glob("*.py") for name in private_names(file)})


def in_range(version: str, bounds: str) -> bool:
    """Whether a version is one that bounds as ``>=0.60,<0.70`` allow."""
    low, high = ([int(part) for part in bound.split(".")] for bound in re.findall(r"[\d.]+", bounds))
    return low <= [int(part) for part in version.split(".")[:2]] < high


def bounds() -> str:
    found = re.search(r'"numba(>=[\d.]+,<[\d.]+)"', (PACKAGE.parent / "pyproject.toml").read_text(encoding="utf-8"))
    assert found, "pyproject.toml gives numba no lower and upper bound."
    return found[1]


@pytest.mark.long
def test_only_one_room_uses_private_interfaces_of_numba():
    strange = [
        f"{file.relative_to(PACKAGE)} uses {name}"
        for file in PACKAGE.rglob("*.py")
        if ROOM not in file.parents
        for name in private_names(file)
    ]
    assert not strange, f"Private interfaces of numba belong into lmgcpy/compiled: {'; '.join(strange)}."


def test_numba_is_of_a_version_that_was_run():
    assert in_range(numba.__version__, bounds()), (
        f"This is numba {numba.__version__}; lmgcpy was run with numba{bounds()} and uses private interfaces: "
        f"{', '.join(used_in_the_room())}. Run tests/compiled and tests/test_jit*.py, then move the bound."
    )


@pytest.mark.parametrize(("version", "fits"), [("0.59.1", False), ("0.60.0", True), ("0.68.1", True), ("0.70.0rc1", False)])
def test_the_bounds_are_compared_as_numbers(version, fits):
    assert in_range(version, ">=0.60,<0.70") is fits


def test_numba_has_the_private_attributes_that_the_room_reads():
    function, context = numba.njit(lambda: 0.0), cpu_target.target_context
    function()  # which fills numba's registry
    read = [
        (function, ("_cache", "_can_compile", "_compiler", "stats", "targetoptions", "locals", "typeof_pyval")),
        (function._compiler, ("compile",)),
        (CompileResult, ("_find_referenced_environments",)),
        (compile_result(), ("reload_init", "referenced_envs", "entry_point", "fndesc", "environment")),
        (Environment, ("_memo", "consts", "globals")),
        (context, ("data_model_manager", "get_abi_sizeof", "get_data_type", "get_value_type", "get_dummy_value")),
        (type(context), ("nrt",)),  # of the context itself it would be made
        (context.codegen(), ("magic_tuple", "create_library", "set_env", "_llvm_module")),
        (context.codegen()._engine, ("is_symbol_defined", "_defined_symbols", "_ee")),
        (JITCodeLibrary, ("codegen", "add_ir_module", "enable_object_caching", "get_pointer_to_function")),
        (JITCodeLibrary, ("_optimize_final_module", "_finalize_final_module", "_finalize_dynamic_globals")),
        (JITCodeLibrary, ("_verify_declare_only_symbols", "_ensure_finalized")),
        (JITCodeLibrary, ("_get_compiled_object", "_set_compiled_object")),
        *((template, ("key",)) for template in (*builtin_registry.functions, *builtin_registry.attributes)),
    ]
    missing = [f"{name} of {of}" for of, names in read for name in names if not hasattr(of, name)]
    assert not missing, f"numba {numba.__version__} lacks what lmgcpy/compiled reads: {', '.join(missing)}."


def test_numba_counts_no_references_where_it_is_told_so():
    """The flag changes the code, and nothing is made in code without it."""

    def last(numbers):
        return numbers[-1]

    def doubled(numbers):
        return (2.0 * numbers)[-1]

    def calls_in(flag):
        compiled = numba.njit(_nrt=flag)(last)
        assert compiled(np.arange(3.0)) == 2.0
        return "NRT_incref" in "".join(compiled.inspect_llvm().values())

    assert not calls_in(False)
    assert numba.njit(_nrt=True)(doubled)(np.arange(3.0)) == 4.0
    with pytest.raises(NumbaError):
        numba.njit(_nrt=False)(doubled)(np.arange(3.0))


def test_the_room_is_where_private_interfaces_are_found():
    """The search finds what is known to be there."""
    assert {"llvmlite.ir", "numba.core.caching.NullCache", "numba.core.errors.NumbaError"} <= set(used_in_the_room())
