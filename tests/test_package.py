"""The front door: what importing costs and brings, and the script in the README."""

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import lmgcpy as lm

ROOT = Path(__file__).parent.parent


def fresh(code):
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_public_names_are_there():
    for name in lm.__all__:
        assert hasattr(lm, name), name
    assert sorted(lm.__all__) == lm.__all__


def test_packages_come_with_the_first_that_asks_for_them():
    assert lm.experiment.Biaxial.__name__ == "Biaxial"
    assert callable(lm.testing.conformance)
    assert not {"Any", "importlib", "TYPE_CHECKING"} & set(dir(lm))
    assert {"experiment", "testing", "view"} <= set(dir(lm))
    for package in (lm.contact, lm.experiment, lm.io, lm.laws, lm.measure, lm.sample, lm.testing, lm.view):
        assert sorted(dir(package)) == sorted(package.__all__)
    with pytest.raises(AttributeError, match="lmgcpy has no 'experimnt'; did you mean 'experiment'"):
        lm.experimnt  # noqa: B018


def test_the_version_is_that_of_the_distribution():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert lm.__version__ == project["version"]


def test_import_is_lean_and_compiles_nothing():
    fresh(
        "import sys, lmgcpy\n"
        "for heavy in ('scipy.sparse', 'matplotlib', 'pyvista', 'vtk', 'h5py', 'tqdm', 'click', 'lmgcpy.view'):\n"
        "    assert heavy not in sys.modules, heavy\n"
        "from lmgcpy.compiled.kernel import Kernel\n"
        "import gc\n"
        "kernels = [o for o in gc.get_objects() if isinstance(o, Kernel)]\n"
        "assert kernels and not any(k._dispatcher for k in kernels)\n"
    )


def test_readme_script_runs():
    text = (ROOT / "README.md").read_text()
    script = re.search(r"<!-- script -->\n```python\n(.*?)```", text, re.S).group(1)
    assert len([line for line in script.splitlines() if line.strip()]) <= 15
    lines = fresh(script).splitlines()
    # the wire of length 0.43 m lets the bead fall until it is taut, and never farther from the hook than rounding to
    # millimetres and the second-order stretch of the scheme, (h omega)^2/2 of the length, allow
    assert len(lines) == 10
    for line in lines:
        x, y = (float(v) for v in re.search(r"\[(.*?)\]", line).group(1).split())
        assert (x**2 + (y - 1.0) ** 2) ** 0.5 < 0.43 + 0.0008
