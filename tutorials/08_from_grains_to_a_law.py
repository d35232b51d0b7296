"""Tutorial 8, from grains to a law: the continuous model beside a run.

    python tutorials/08_from_grains_to_a_law.py [FOLDER]

A material point of sand with a wire network is compressed; then a small biaxial study
is computed, its sand fitted, and its test with a wire predicted. Everything is written
into FOLDER, by default tutorial_08.
"""

import shutil
import sys
from pathlib import Path

import numpy as np

from lmgcpy.continuum import (
    DruckerPrager,
    TexSol,
    WireNetwork,
    fit_sand,
    in_plane,
    triaxial,
)
from lmgcpy.experiment import Study2D, StudyFolder, carry_out_study
from lmgcpy.experiment.continuum.comparison import compare, measured_compression
from lmgcpy.experiment.continuum.report import write_comparison

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "tutorial_08")

# 1. A material point: sand of 20 degrees, q/p = M = 6 sin 20 / (3 - sin 20), that
# dilates by nothing, and 150 km of wire per cubic metre in horizontal layers.
pressure, M = 1e5, 6 * np.sin(np.radians(20)) / (3 - np.sin(np.radians(20)))
sand = DruckerPrager(
    3,
    critical=M,
    hardening=1e-4,
    peak=0.0,
    peak_shear=1.0,
    dilation=0.0,
    turning=M,
    bulk_modulus=1e8,
    shear_modulus=1e8,
)
crushing = -np.linspace(0.0, 0.05, 201)[1:]
print("triaxial test at 100 kPa of 5 % across and along the layers")
alone = triaxial(TexSol(sand), crushing, pressure=pressure).deviator[-1]
print(f"  sand alone         {1e-3 * alone:6.1f} kPa")
# The wire pulls where it is lengthened, with EA = 10 N and at most 0.5 mm^2 of the
# sand's pressure: beyond that it slips.
for name, anchorage in (("wire, held", np.inf), ("wire, slipping", 0.5e-6)):
    wire = WireNetwork(1.5e5, 10.0, in_plane("z"), anchorage=anchorage)
    ends = [
        triaxial(TexSol(sand, wire), crushing, pressure=pressure, axis=axis)
        for axis in "zx"
    ]
    q = [1e-3 * end.deviator[-1] for end in ends]
    lateral = 1e-3 * ends[0].wire[-1, 0]
    print(
        f"  {name:17} {q[0]:7.1f} and {q[1]:5.1f} kPa; its part along x {lateral:5.1f}"
    )

# 2. A run: a biaxial study of 280 grains and 60 beads, without and with a wire.
shutil.rmtree(folder / "study", ignore_errors=True)
laws = ("none", "elastic-wire")
study = Study2D(
    laws=laws, check_strain=0.0, grain_count=280, bead_count=60, strain=0.05
)
kept = StudyFolder(folder / "study", Study2D)
result = carry_out_study(study, folder=kept)

# 3. The sand, fitted to the test without a wire.
fitted = fit_sand(measured_compression(result.records["none"], result.sample))
off = fitted.misfit
print(
    f"fitted sand: off by {off['friction']:.3f} in q/p, {off['volume']:.5f} in volume"
)

# 4. The test with the wire, predicted: by the local model, in which every link follows
# the mean strain, and by one in which the sand holds the wire only so far.
found = compare([folder / "study"])
(test,) = found.predictions["elastic-wire"]
late = np.linspace(0.8, 0.99, 20) * test.run.crushing[-1]
for name in ("sand", "run", "local", "anchored"):
    q = 1e-3 * getattr(test, name).at(late).deviator.mean()
    print(f"  {name:9} late deviator {q:7.1f} kPa")
for path in write_comparison(found, folder):
    print(path.name)
