"""numba's compiler for kernels and for the functions that only kernels call.

The code of such a function is linked into the code of each kernel, and is optimised and turned into machine code there.
numba would do both for the function alone as well, and again for each function on the way to the kernel. For the kernel
that deposits spheres, which calls a hundred functions, up to nine deep, that is half of the time.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import compiler, errors, types
from numba.core import ir as numba_ir
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler_machinery import FunctionPass, register_pass
from numba.core.environment import lookup_environment
from numba.core.typed_passes import NopythonTypeInference
from numba.core.untyped_passes import TranslateByteCode

from lmgcpy.compiled.reference import ADDRESS, ReferenceType

# start of numba's name for the environment of a function
_ENVIRONMENT = "_ZN08NumbaEnv"


class KernelCode(JITCodeLibrary):
    """Code of one kernel, which numba makes with its functions."""

    def __init__(self, codegen: Any, name: str, references: dict[str, int]):
        """``references``: arguments that are references, and the size of the tuple to which each refers [bytes]."""
        super().__init__(codegen, name)
        self.references = references

    def add_ir_module(self, ir_module: ir.Module) -> None:
        """Mark each reference as readable at any time and never written: then values that a loop reads by it are loaded
        before the loop."""
        for function in ir_module.functions:
            for argument in () if function.is_declaration else function.args:
                if argument.name in self.references and argument.type == ADDRESS:
                    argument.attributes.dereferenceable = self.references[argument.name]
                    argument.add_attribute("noalias")
        super().add_ir_module(ir_module)

    def _optimize_functions(self, module: Any) -> None:
        """Nothing but to say how data lie in memory: functions are optimised with the kernel that they are linked into, and
        once is enough."""
        module.data_layout = self._codegen._data_layout

    def _finalize_final_module(self) -> None:
        """Give each function linked into this code its environment: strings that it prints, Python that it calls."""
        super()._finalize_final_module()
        for variable in self._final_module.global_variables:
            found = lookup_environment(variable.name) if variable.name.startswith(_ENVIRONMENT) else None
            if found is not None:
                self.codegen.set_env(variable.name, found)


class LinkedCode(KernelCode):
    """Code that is to be linked into the code of kernels."""

    @property
    def codegen(self) -> Any:
        """An object that accepts the environment of the machine code and ignores it, as there is no machine code."""
        return _Nowhere()

    def _optimize_final_module(self) -> None:
        """Nothing: it is done after linking."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """None."""
        self._ensure_finalized()
        return 0


class _Nowhere:
    def set_env(self, name: str, environment: Any) -> None:
        """Nothing."""


@register_pass(mutates_CFG=False, analysis_only=True)
class _ChooseCode(FunctionPass):
    """Makes the library of code that the function is for."""

    _name = "lmgcpy_choose_code"

    def __init__(self) -> None:
        super().__init__()

    def run_pass(self, state: Any) -> bool:
        context, function, flags = state.targetctx, state.func_id, state.flags
        references = {
            f"arg.{name}": context.get_abi_sizeof(context.get_data_type(kind.kind))
            for name, kind in zip(function.arg_names, state.args, strict=False)
            if isinstance(kind, ReferenceType)
        }
        code = (LinkedCode if _is_linked(flags) else KernelCode)(context.codegen(), function.func_qualname, references)
        code.enable_object_caching()
        state.library = code
        return True


@register_pass(mutates_CFG=False, analysis_only=True)
class _RefuseNone(FunctionPass):
    """Refuses a function called by kernels, such as a law's, that returns a tuple in some cases and None in others. numba
    compiles it, and raises when the tuple is read; a kernel that cannot raise would go on."""

    _name = "lmgcpy_refuse_none"

    def __init__(self) -> None:
        super().__init__()

    def run_pass(self, state: Any) -> bool:
        kind = state.return_type
        if _is_linked(state.flags) and isinstance(kind, types.Optional) and isinstance(kind.type, types.BaseTuple):
            raise errors.TypingError(
                f"{state.func_id.func.__name__} returns None in some cases: each way through it has to end in a return",
                loc=_return_of_none(state),
            )
        return False


def _is_linked(flags: Any) -> bool:
    """Whether a function is compiled for kernels that call it, with no way in from Python."""
    return flags.no_cpython_wrapper and flags.no_cfunc_wrapper


def _return_of_none(state: Any) -> Any:
    """Place in the source where the function returns None."""
    for block in state.func_ir.blocks.values():
        if isinstance(block.terminator, numba_ir.Return):
            cast = state.func_ir.get_definition(block.terminator.value)
            value = getattr(cast, "value", block.terminator.value)
            if isinstance(state.typemap[value.name], types.NoneType | types.Optional):
                return block.terminator.loc
    return state.func_ir.loc


class Compiler(compiler.Compiler):
    """numba's steps, with code of lmgcpy's kinds: ``numba.jit(pipeline_class=Compiler)``."""

    def define_pipelines(self) -> list[Any]:
        """The one pipeline. Python in between (``numba.objmode``) is no code of the kernel's: numba makes it as ever."""
        if self.state.func_ir is not None:
            return super().define_pipelines()
        steps = compiler.DefaultPassBuilder.define_nopython_pipeline(self.state)
        steps.add_pass_after(_ChooseCode, TranslateByteCode)
        steps.add_pass_after(_RefuseNone, NopythonTypeInference)
        steps.finalize()
        return [steps]
