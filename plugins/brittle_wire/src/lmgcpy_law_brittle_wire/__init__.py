"""An elastic wire that breaks, for lmgcpy."""

import lmgcpy as lm
from lmgcpy_law_brittle_wire.brittle_wire import BrittleWire

__all__ = ["BrittleWire"]


@lm.laws.hook
def lmgcpy_laws(register):
    register(BrittleWire)
