"""Interaction laws: the abstract class, the built-in laws, and the registry through which users add their own."""

from lmgcpy.laws import builtin
from lmgcpy.laws.law import Law, Parameter, State
from lmgcpy.laws.pair import Pair
from lmgcpy.laws.registry import hook, registry

registry.add_plugin(builtin, "lmgcpy")

names = registry.names
get = registry.get
register = registry.register
failures = registry.failures
registrations = registry.registrations

__all__ = [
    "Law",
    "Pair",
    "Parameter",
    "State",
    "failures",
    "get",
    "hook",
    "names",
    "register",
    "registrations",
    "registry",
]


def __dir__() -> list[str]:
    return __all__
