"""A wire that straightens and stiffens, for lmgcpy."""

import lmgcpy as lm
from lmgcpy_law_hardening_wire.hardening_wire import HardeningWire, elongation, tension

__all__ = ["HardeningWire", "elongation", "tension"]


@lm.laws.hook
def lmgcpy_laws(register):
    register(HardeningWire)
