"""What the suites leave out."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import pytest
from suites import leave_out_all_but_one_in


@dataclass(frozen=True)
class Item:
    """What is asked of a test of pytest."""

    nodeid: str
    is_long: bool

    def get_closest_marker(self, name: str) -> bool:
        return self.is_long


def left(many: int, nodes: list[tuple[str, bool]]) -> list[str]:
    """The ids that ``--one-in`` leaves of nodes, each with whether it is long."""
    told: list = []
    config = SimpleNamespace(
        getoption=lambda name: many, hook=SimpleNamespace(pytest_deselected=lambda items: told.extend(items))
    )
    items = [Item(*node) for node in nodes]
    whole = list(items)
    leave_out_all_but_one_in(config, items)
    assert len(told) + len(items) == len(whole)
    return [item.nodeid for item in items]


NODES = [(f"test_{name}.py::test_it[{k}]", True) for name in "abc" for k in range(60)]
NODES += [("test_short.py::test_it[1]", False), ("test_a.py::test_without_parameters", True)]


@pytest.mark.parametrize("many", [2, 3, 7])
def test_one_in_many_parameters_of_each_long_test(many):
    kept = left(many, NODES)
    assert {node.partition("[")[0] for node in kept} == {node.partition("[")[0] for node, _ in NODES}
    for name in "abc":
        count = sum(node.startswith(f"test_{name}.py::test_it") for node in kept)
        assert count == pytest.approx(60 / many, abs=3.0 * (60 / many) ** 0.5)  # of a binomial distribution
    assert kept == left(many, NODES)  # by the names alone


def test_one_at_least_of_each():
    assert len(left(10**9, NODES)) == 5


def test_all_of_them():
    assert left(1, NODES) == [node for node, _ in NODES]
