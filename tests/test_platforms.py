"""The platforms on which the wheel is run; running .ci/platforms takes minutes for each and is a long test."""

import re
import subprocess
import sys

import pytest
from ci_scripts import CI, script


@pytest.fixture
def platforms(monkeypatch):
    return script("platforms", monkeypatch)


def test_oldest_is_the_lower_bound_of_every_requirement(platforms):
    assert platforms.lower_bounds(["numpy>=1.26", "numba>=0.60,<0.70"]) == ("numpy==1.26", "numba==0.60")
    assert len(platforms.lower_bounds(platforms.project()["dependencies"])) == len(platforms.project()["dependencies"])
    with pytest.raises(SystemExit, match="no lower bound"):
        platforms.lower_bounds(["numpy"])


def test_what_is_claimed_is_what_is_run(platforms):
    """Pythons of the classifiers are platforms, the oldest is the least that is allowed, and the tests are there."""
    claimed = re.findall(r"Programming Language :: Python :: (3\.\d+)", "\n".join(platforms.project()["classifiers"]))
    assert tuple(claimed) == platforms.PYTHONS
    assert platforms.oldest_python() == platforms.PYTHONS[0]
    for test in platforms.TESTS:
        assert (CI.parent / test).is_file(), test


def test_numba_has_an_upper_bound_as_its_private_interfaces_are_used(platforms):
    assert any(re.fullmatch(r"numba>=[\d.]+,<[\d.]+", one) for one in platforms.project()["dependencies"])


@pytest.mark.long
def test_every_platform_of_this_machine():
    done = subprocess.run([sys.executable, CI / "platforms"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
