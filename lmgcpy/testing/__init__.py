"""A conformance kit for authors of interaction laws, driven by hypothesis.

    import lmgcpy.testing
    from my_package import MyLaw

    @lmgcpy.testing.conformance(MyLaw(strength=10.0))
    def test_my_law(check):
        check()

and, in a script, ``print(lmgcpy.testing.report(MyLaw(strength=10.0)))``. ``PROPERTIES`` lists the properties that the kit
checks, and ``docs/conformance.md`` what it cannot find. ``import lmgcpy`` does not import this package.
"""

try:
    import hypothesis as _hypothesis  # noqa: F401
except ImportError as error:
    raise ImportError('lmgcpy.testing needs hypothesis and pytest: pip install "lmgcpy[test]"') from error

# the imports set the order of the properties: basic ones first, the longest last
from lmgcpy.testing import local_solve, traits, invariance, purity, compiled, runs  # noqa: F401, I001
from lmgcpy.testing.case import Nonconformance
from lmgcpy.testing.conformance import Check, Finding, LawReport, conformance, report
from lmgcpy.testing.conformance import PROPERTIES, Property

__all__ = ["PROPERTIES", "Check", "Finding", "LawReport", "Nonconformance", "Property", "conformance", "report"]


def __dir__() -> list[str]:
    return __all__
