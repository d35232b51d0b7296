"""Modules that have moved, under the names that the documentation gave them before: they are the same modules."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType

MOVED = {
    "lmgcpy.jit": "lmgcpy.compiled.kernel",
    "lmgcpy.experiment.column_sample": "lmgcpy.experiment.column.sample",
    "lmgcpy.experiment.texsol_sample": "lmgcpy.experiment.texsol.sample",
    "lmgcpy.experiment.texsol_sample_3d": "lmgcpy.experiment.texsol.sample",
}
"""New names by former ones."""


class FormerNames(MetaPathFinder, Loader):
    """Finds a module that has moved by its former name."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        return ModuleSpec(fullname, self) if fullname in MOVED else None

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        module = importlib.import_module(MOVED[spec.name])
        spec.loader_state = module.__spec__
        return module

    def exec_module(self, module: ModuleType) -> None:
        former = module.__spec__  # the import has put it in the place of the module's own
        assert former is not None
        module.__spec__ = former.loader_state


def know() -> None:
    """Have imports find former names."""
    if not any(isinstance(finder, FormerNames) for finder in sys.meta_path):
        sys.meta_path.append(FormerNames())
