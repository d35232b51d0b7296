"""Programs that import modules by the names that the documentation gave them go on working."""

import importlib

import pytest

from lmgcpy import former_names


@pytest.mark.parametrize("name", former_names.MOVED)
def test_a_moved_module_is_found_by_its_former_name(name):
    module = importlib.import_module(former_names.MOVED[name])
    own = module.__spec__
    assert importlib.import_module(name) is module
    assert module.__spec__ is own


@pytest.mark.parametrize(
    ("module", "name"),
    [
        ("lmgcpy.jit", "statistics"),
        ("lmgcpy.experiment.column_sample", "lay_column"),
        ("lmgcpy.experiment.texsol_sample", "lay_sample"),
        ("lmgcpy.experiment.texsol_sample_3d", "lay_sample_3d"),
    ],
)
def test_it_has_the_names_that_pages_took_from_it(module, name):
    assert callable(getattr(importlib.import_module(module), name))


def test_other_names_are_not_found():
    with pytest.raises(ModuleNotFoundError):
        importlib.import_module("lmgcpy.no_such_module")
