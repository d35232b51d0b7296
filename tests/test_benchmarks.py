"""Every benchmark can at least be started: what it imports is there."""

import runpy
import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"
SCRIPTS = sorted(path.name for path in BENCHMARKS.glob("*.py"))


def test_there_are_benchmarks():
    assert "table.py" in SCRIPTS
    assert len(SCRIPTS) > 10


@pytest.mark.long
@pytest.mark.parametrize("script", SCRIPTS)
def test_a_benchmark_finds_what_it_imports(script, monkeypatch):
    monkeypatch.setattr(sys, "path", [str(BENCHMARKS), *sys.path])
    names = runpy.run_path(str(BENCHMARKS / script), run_name="looked at")
    assert names["__doc__"]
