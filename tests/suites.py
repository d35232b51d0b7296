"""The two suites: the default one, and the long one (``-m long``); see conftest.py."""

import zlib
from collections import defaultdict

import pytest

LONG = False
"""Whether the long suite runs; set by conftest.py before a module of tests is imported."""


def size(default: int, *, long: int) -> int:
    """How many of something a test takes in the suite that runs; the test bears ``@pytest.mark.scaled``."""
    return long if LONG else default


def leave_out_all_but_one_in(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Deselect long parameters of each test by the hash of their names, but the one of the least hash."""
    many = config.getoption("one_in")
    tests: dict[str, dict[pytest.Item, int]] = defaultdict(dict)
    for item in items:
        if many > 1 and item.get_closest_marker("long"):
            tests[item.nodeid.partition("[")[0]][item] = zlib.crc32(item.nodeid.encode())
    out = {item for by in tests.values() for item, value in by.items() if value % many and value > min(by.values())}
    config.hook.pytest_deselected(items=list(out))
    items[:] = [item for item in items if item not in out]
