"""What a user installs: environments away from the checkout, and the README's script in them."""

from __future__ import annotations

import os
import re
import subprocess
import tempfile
import tomllib
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent


def project() -> dict[str, Any]:
    """The table ``[project]`` of pyproject.toml."""
    return tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def readme_script() -> str:
    """The script that the README prints."""
    found = re.search(r"<!-- script -->\n```python\n(.*?)```", (ROOT / "README.md").read_text(), re.S)
    if found is None:
        raise LookupError("README.md has no script marked <!-- script -->.")
    return found.group(1)


def surroundings(folder: Path) -> dict[str, str]:
    """Environment variables that show a process nothing but what is installed; its kernels are kept in ``folder``."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "NUMBA_", "LMGCPY_"))}
    return {**kept, "LMGCPY_CACHE_DIR": str(folder / "cache")}


def environment(python: str | Path, folder: Path, *requirements: str) -> Path:
    """A virtual environment with these requirements, none of them compiled here: the path of its Python."""
    subprocess.run([python, "-m", "venv", folder / "venv"], check=True, env=surroundings(folder))
    inside = folder / "venv" / "bin" / "python"
    install = [inside, "-m", "pip", "install", "--quiet", "--only-binary=:all:", *requirements]
    subprocess.run(install, check=True, cwd=folder, env=surroundings(folder))
    return inside


def run_readme_script(python: Path, folder: Path) -> None:
    """Run it from an empty folder, as a file that a user has saved; ten lines must come out, no complaint. With compiled
    kernels it must print the same lines."""
    script = folder / "script.py"
    script.write_text(readme_script())
    where = "import lmgcpy; print(lmgcpy.__file__)"
    with tempfile.TemporaryDirectory(dir=folder) as empty:
        ask = {"cwd": empty, "env": surroundings(folder), "capture_output": True, "text": True}
        found = subprocess.run([python, "-c", where], **ask)
        if found.returncode or not Path(found.stdout.strip()).is_relative_to(folder / "venv"):
            raise SystemExit(f"lmgcpy is imported from elsewhere than its environment: {found.stdout}{found.stderr}")
        done = subprocess.run([python, script], **ask)
        ask["env"] = {**ask["env"], "LMGCPY_COMPILE_FIRST": "1"}
        again = subprocess.run([python, script], **ask)
    if again.stdout != done.stdout:
        printed = f"{done.stdout}{again.stdout}{again.stderr}"
        raise SystemExit(f"With compiled kernels the README's script prints something else:\n{printed}")
    complaints = [line for line in done.stderr.splitlines() if not line.startswith("lmgcpy compiles kernels")]
    if done.returncode or len(done.stdout.splitlines()) != 10 or complaints:
        raise SystemExit(f"The README's script does not run where lmgcpy is installed:\n{done.stdout}{done.stderr}")
