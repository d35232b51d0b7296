"""Extensions of numba by other packages: ``numba.extending.overload`` and its kind.

An extension changes what a kernel does although the kernel's own text does not name it: ``np.i0(x)``, ``x.half`` or
``a * b`` of tuples call a function of another package, and that function may read anything while it makes code.
"""

from __future__ import annotations

from typing import Any

from numba.core.typing.templates import builtin_registry

AT_HOME = ("numba", "lmgcpy", "abc")
"""Packages whose templates are known; templates that numba makes without a class statement are of module abc."""


def extension_in_use(read: set[str]) -> str | None:
    """A clause about an extension of numba that code with these names may use; None if there is none."""
    for template in (*builtin_registry.functions, *builtin_registry.attributes):
        maker = made_by(template)
        if maker is None or not answered(template):
            continue
        name = stands_for(template)
        if name is None or name in read:
            return f"{maker} has taught numba {f'a {name!r}' if name else 'an operator'} of its own"
    return None


def answered(template: Any) -> bool:
    """Whether a template has ever applied in this process: numba asks most of them about types that are not theirs."""
    answers = getattr(template, "_impl_cache", None)
    if answers is None or hasattr(template, "_attr"):  # answers for attributes are not kept there
        return True
    return any((answer[0] if isinstance(answer, tuple) else answer) is not None for answer in answers.values())


def made_by(template: Any) -> str | None:
    """Module and name of the function that made a template; None for templates of numba and lmgcpy."""
    makers: list[Any] = [getattr(template, part, None) for part in ("_overload_func", "_definition_func")]
    makers = [maker for maker in makers if maker is not None]
    if not makers:
        generic = getattr(template, "generic", None)
        makers = [template, generic, *(cell.cell_contents for cell in getattr(generic, "__closure__", None) or ())]
    return next((f"{maker.__module__}.{maker.__qualname__}" for maker in makers if foreign(maker)), None)


def foreign(made: Any) -> bool:
    """Whether a function or class belongs neither to numba nor to lmgcpy; one that was made from text has no module."""
    module, name = getattr(made, "__module__", None), getattr(made, "__qualname__", None)
    return isinstance(module, str) and isinstance(name, str) and module.split(".")[0] not in AT_HOME


def stands_for(template: Any) -> str | None:
    """The name in code of the function or attribute that a template defines; None for an operator, which has no name."""
    name = getattr(template, "_attr", None) or getattr(getattr(template, "key", None), "__name__", None)
    return None if getattr(template.key, "__module__", None) == "_operator" else name
