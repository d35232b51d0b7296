"""The scripts in .ci as modules."""

import importlib.machinery
import importlib.util
import sys
from pathlib import Path

CI = Path(__file__).parent.parent / ".ci"


def script(name, monkeypatch):
    """``.ci/NAME``, not run."""
    monkeypatch.syspath_prepend(CI)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    loader = importlib.machinery.SourceFileLoader(name, str(CI / name))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(name, loader))
    loader.exec_module(module)
    return module
