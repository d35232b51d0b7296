"""Cohesive contact after Mohr and Coulomb, for lmgcpy."""

import lmgcpy as lm
from lmgcpy_law_cohesive.cohesive import Cohesive

__all__ = ["Cohesive"]


@lm.laws.hook
def lmgcpy_laws(register):
    register(Cohesive)
