"""A small sample in 3D, compacted once for all tests."""

import pytest

import lmgcpy as lm
from lmgcpy.experiment.box import characteristic_time
from lmgcpy.experiment.compaction import compact
from lmgcpy.experiment.texsol.sample import lay_sample_3d

PRESSURE, DENSITY = 1e5, 2600.0


def relax(laid, **options):
    """Compacted as the 3D study does it."""
    step = 0.08 * characteristic_time(laid.diameter, DENSITY, PRESSURE)
    solver = lm.AcceleratedGaussSeidel(tolerance=1e-3, max_iterations=2000, wire_blocks=False)
    options = {"drag": 2.0, "time_step": step, "solver": solver, "max_steps": 1500, **options}
    return compact(laid, pressure=PRESSURE, density=DENSITY, **options)


@pytest.fixture(scope="session")
def compaction_3d():
    return relax(lay_sample_3d(150, 120, seed=1))


@pytest.fixture(scope="session")
def sample_3d(compaction_3d):
    return compaction_3d.sample
