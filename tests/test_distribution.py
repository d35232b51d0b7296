"""What is published: the content of source and wheel.

Building them needs a package registry and is a long test; here is what .ci/distribution judges them by.
"""

import re
import subprocess
import sys

import pytest
from ci_scripts import CI, script

from lmgcpy.version import VERSION


@pytest.fixture
def distribution(monkeypatch):
    return script("distribution", monkeypatch)


def test_the_package_in_the_checkout_has_what_a_wheel_must_hold(distribution):
    package = distribution.files_of(CI.parent / "lmgcpy")
    assert {"lmgcpy/py.typed", "lmgcpy/laws/coulomb.py", "lmgcpy/plugin_template/law_contact.txt"} <= package
    assert not any("/tests/" in name or name.endswith(".pyc") for name in package)


INFO = f"lmgcpy-{VERSION}.dist-info"
ABOUT = {f"{INFO}/{name}" for name in ("METADATA", "RECORD", "entry_points.txt", "licenses/LICENSE")}


@pytest.mark.parametrize(
    ("missing", "foreign"),
    [
        (set(), set()),
        ({"lmgcpy/py.typed"}, set()),
        ({"lmgcpy/plugin_template/test_link.txt"}, set()),
        ({f"{INFO}/licenses/LICENSE"}, set()),
        ({f"{INFO}/entry_points.txt"}, set()),
        (set(), {"tests/test_package.py"}),
        (set(), {"benchmarks/start_up.py"}),
        (set(), {"lmgcpy/__pycache__/jit.cpython-311.pyc"}),
    ],
)
def test_a_wheel_that_lacks_or_holds_something_is_told(distribution, missing, foreign):
    package = distribution.files_of(CI.parent / "lmgcpy")
    faults = distribution.faults_of_wheel((package | ABOUT) - missing | foreign, package)
    assert len(faults) == len(missing | foreign), faults


def test_a_source_that_lacks_or_holds_something_is_told(distribution):
    checkout = {"README.md", "lmgcpy/py.typed", "tests/conftest.py"}
    made = {"PKG-INFO", "setup.cfg", "lmgcpy.egg-info/SOURCES.txt"}
    assert distribution.faults_of_source(checkout | made, checkout) == []
    (fault,) = distribution.faults_of_source(checkout - {"tests/conftest.py"}, checkout)
    assert fault == "the source lacks tests/conftest.py"
    (fault,) = distribution.faults_of_source(checkout | {"texsol/summary.md"}, checkout)
    assert "texsol/summary.md" in fault


def metadata(said):
    """As setuptools writes them of a table ``[project]``."""
    lines = [
        "Metadata-Version: 2.4",
        f"Name: {said['name']}",
        f"Version: {said['version']}",
        f"Summary: {said['description']}",
        f"License-Expression: {said['license']}",
        *(f"Classifier: {one}" for one in said["classifiers"]),
        f"Requires-Python: {said['requires-python']}",
        "License-File: LICENSE",
        *("Requires-Dist: " + re.sub(r"(>=.*),(<.*)", r"\2,\1", one) for one in said["dependencies"]),
        'Requires-Dist: pytest>=8; extra == "test"',
        *(f"Provides-Extra: {one}" for one in said["optional-dependencies"]),
    ]
    return "\n".join(lines) + "\n\n## From nothing to the result\n"


def test_metadata_that_differ_from_pyproject_are_told(distribution):
    sound, commands = metadata(distribution.project()), "[console_scripts]\nlmgcpy = lmgcpy.cli:main\n"
    assert distribution.faults_of_metadata(sound, commands) == []
    for wrong in ("Requires-Dist: numba", "Requires-Python: >=", "License-File: ", "Classifier: Typing"):
        assert len(distribution.faults_of_metadata(sound.replace(wrong, wrong + "0"), commands)) == 1, wrong
    assert len(distribution.faults_of_metadata(sound.split("##")[0], commands)) == 1
    assert len(distribution.faults_of_metadata(sound, "[console_scripts]\n")) == 1


@pytest.fixture
def release(monkeypatch):
    return script("release", monkeypatch)


def test_every_place_gives_the_same_version_and_the_changes_tell_of_it(release):
    version = release.project()["version"]
    assert release.faults(version) == []
    assert len(release.faults("99.0.0")) == 4
    assert len(release.notes(version).splitlines()) > 10
    with pytest.raises(SystemExit, match=r"docs/changes.md has no section on version 99\.0\.0"):
        release.notes("99.0.0")


def test_the_recipe_asks_for_what_the_project_asks_for(distribution):
    """conda-forge has matplotlib without windows under another name; optional packages only have bounds."""
    said = distribution.project()
    lines = re.findall(r"^    - (.*)$", (CI.parent / "recipe" / "meta.yaml").read_text(), re.M)
    asked = [distribution.bounds(line) for line in lines]
    wanted = [*said["dependencies"], *said["optional-dependencies"]["view"], f"python{said['requires-python']}"]
    wanted += ["setuptools>=77"]
    for one in wanted:
        assert distribution.bounds(re.sub(r"^matplotlib\b", "matplotlib-base", one)) in asked, one


@pytest.mark.long
def test_distributions_are_built_and_run(tmp_path):
    done = subprocess.run([sys.executable, CI / "distribution", tmp_path / "built"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
