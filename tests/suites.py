"""The two suites: the default one, and the long one (``-m long``); see conftest.py."""

LONG = False
"""Whether the long suite runs; set by conftest.py before a module of tests is imported."""


def size(default: int, *, long: int) -> int:
    """How many of something a test takes in the suite that runs; the test bears ``@pytest.mark.scaled``."""
    return long if LONG else default
