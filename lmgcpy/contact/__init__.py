"""Detection: which contactors are near each other, and the local frames in which they meet."""

from lmgcpy.contact.contactor_pairs import register_pair

__all__ = ["register_pair"]


def __dir__() -> list[str]:
    return __all__
