"""Run files of former versions, stored beside this test, are read, measured and gone on with.

Each holds six steps of 1 ms, three frames: three grains on a floor, an elastic wire of four beads above them.
"""

from __future__ import annotations

import lzma
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import lmgcpy as lm
from lmgcpy.cli import main

STORED = sorted((Path(__file__).parent / "old_files").glob("*.h5.xz"))
X = {"2d": [0.0, 0.02104170267150053, 0.04208340534300106], "3d": [0.0, 0.021044318772094936, 0.04208863754418987]}
"""Where the grains were in the end, as the program printed it then [m]."""


@pytest.fixture(params=STORED, ids=lambda path: path.name.removesuffix(".h5.xz"))
def old(request, tmp_path):
    """The unpacked file, and where its grains were."""
    path = tmp_path / "run.h5"
    path.write_bytes(lzma.decompress(request.param.read_bytes()))
    return path, X[request.param.name[-8:-6]]


def test_both_versions_are_stored():
    assert [path.name for path in STORED] == [f"{v}-{d}.h5.xz" for v in ("0.1.0", "0.2.0") for d in X]


@pytest.mark.default_parameters("0.1.0-3d", "0.2.0-2d")
def test_it_is_read_and_measured(old):
    path, x = old
    with lm.io.open_run(path) as run:
        assert run.frame_count == 3
        np.testing.assert_array_equal(run.positions[-1][:3, 0], x)
        assert set(run.laws) == {"coulomb", "elastic-wire", "signorini"}
        net = run.interactions(-1)
        assert (net.law[:3] == "elastic-wire").all()
        # six steps of fall against the wire's pull: the beads bear next to nothing yet, the floor the grains' weight
        links = lm.measure.wire_links(run)
        np.testing.assert_allclose(links.length, 0.012, rtol=1e-2)
        assert np.isfinite(lm.measure.stress(run, volume=1.0)["total"]).all()
    told = CliRunner().invoke(main, ["info", str(path)])
    assert told.exit_code == 0, told.output
    assert "1 chains" in told.output


@pytest.mark.default_parameters("0.1.0-2d", "0.2.0-3d")
def test_one_goes_on_with_it(old):
    path, x = old
    sim = lm.resume(path)
    assert sim.steps == 6
    np.testing.assert_array_equal(sim.positions[:3, 0], x)
    sim.run(steps=3)
    with lm.io.open_run(path) as run:
        assert run.frame_count == 4
    again = lm.Simulation(lm.Scene.from_run(path, 6), time_step=1e-3).run(steps=3)
    np.testing.assert_allclose(again.positions, sim.positions, atol=1e-6)
