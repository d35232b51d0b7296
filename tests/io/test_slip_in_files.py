"""Slip and round-off in run files; files made before they were kept."""

from __future__ import annotations

import json

import h5py
import numpy as np
import pytest
from click.testing import CliRunner
from columns import column

import lmgcpy as lm
from lmgcpy.cli import main
from lmgcpy.io.take_up import take_up


def five_disks(solver):
    return lm.Simulation(column(5, radius=0.01), time_step=1e-3, solver=solver)


def without_slip(path):
    """Take out of a file what older ones do not hold."""
    with h5py.File(path, "r+") as file:
        history = file["history"]
        rows, chunks = history[:], history.chunks
        names = [name for name in rows.dtype.names if name != "slip"]
        kind = np.dtype([(name, rows.dtype[name]) for name in names])
        kept = np.zeros(len(rows), kind)
        for name in names:
            kept[name] = rows[name]
        del file["history"]
        file.create_dataset("history", data=kept, maxshape=(None,), chunks=chunks)
        fields = file["about/options/solver_fields"]
        for name in [name for name in fields if name in ("slip", "force")]:
            del fields[name]
        del file["about"].attrs["digest"]
        del file["tails"]


def test_slip_and_round_off_are_in_the_history(tmp_path):
    sim = five_disks(lm.Auto(tolerance=1e-3))
    told = []
    sim.run(steps=6, record=tmp_path / "run.h5", until=lambda sim: told.append(sim.report.slip))
    with lm.io.open_run(tmp_path / "run.h5") as run:
        assert run.history[:]["slip"].tolist() == told
        assert max(told) > 0.0
    info = CliRunner().invoke(main, ["info", str(tmp_path / "run.h5")])
    assert f"worst slip {max(told):.3g}" in info.output
    rounded = five_disks(lm.Auto(tolerance=1e-18))
    rounded.run(steps=3, record=tmp_path / "rounded.h5")
    with lm.io.open_run(tmp_path / "rounded.h5") as run:
        assert set(run.status) == {"round-off"}
        assert run.unconverged_steps == 0
    info = CliRunner().invoke(main, ["info", str(tmp_path / "rounded.h5")])
    assert "0 of 3 steps not converged, 3 solved to round-off" in info.output


@pytest.mark.long
def test_older_files_open_and_go_on(tmp_path):
    path = tmp_path / "run.h5"
    five_disks(lm.Auto(tolerance=1e-3)).run(steps=4, record=path)
    five_disks(lm.Auto(tolerance=1e-3)).run(steps=8, record=tmp_path / "whole.h5")
    without_slip(path)
    with lm.io.open_run(path) as run:
        assert "slip" not in run.history.dtype.names
        assert json.loads(json.dumps(run.options["solver_fields"]))["tolerance"] == 1e-3
    info = CliRunner().invoke(main, ["info", str(path)])
    assert info.exit_code == 0
    assert "slip" not in info.output.split("  solver")[1]
    sim = five_disks(lm.Auto(tolerance=1e-3))
    take_up(sim, path)
    sim.run(steps=2)
    resumed = lm.resume(path)
    assert resumed.solver == lm.Auto(tolerance=1e-3)
    resumed.run(steps=2)
    lm.io.export_csv(lm.io.open_run(path), tmp_path / "tables")
    assert "slip" not in (tmp_path / "tables" / "history.csv").read_text().splitlines()[0]
    with lm.io.open_run(path) as run, lm.io.open_run(tmp_path / "whole.h5") as whole:
        assert lm.io.compare(run, whole) is None
