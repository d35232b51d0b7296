"""Elastic wires in the biaxial test, from soft to stiff: no explosion, and the rigid wire as the limit.

The paper gave elastic laws up because samples exploded. Here the same test runs at any stiffness; ``h^2 k/m`` is the
number that an explicit scheme would have to keep below 4. The table tells how far the support reaction is from the rigid
wire's over the first 0.5 % and 2 % of crushing (two runs of the rigid wire that differ in nothing but the solver's
tolerance stand for the noise), and the kinetic energy late in the test over that early in it: vibrations that grow would
show.

    python benchmarks/elastic_wire.py [folder for the figure]
"""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from table import RESULTS, report

import lmgcpy as lm
from lmgcpy.experiment.biaxial import Biaxial, BiaxialRecord
from lmgcpy.experiment.compaction import compact
from lmgcpy.experiment.texsol.sample import lay_sample
from lmgcpy.experiment.texsol.study import DENSITY
from lmgcpy.view.figures import new_figure, save

PRESSURE, STRAIN, TOLERANCE = 1e5, 0.02, 1e-4
RIGIDITIES = (1e4, 1e5, 1e6, 1e7, 1e8, 1e10)
"""EA [N] per metre of depth; pressure times height is about 4e4 N."""


def difference(record: BiaxialRecord, reference: BiaxialRecord, strain: float) -> float:
    """Mean difference of the reactions up to ``strain``, relative to the mean."""
    part = reference.strain <= strain
    return float(np.abs(record.reaction - reference.reaction)[part].mean() / reference.reaction[part].mean())


def trend(record: BiaxialRecord) -> float:
    """Mean kinetic energy in the last third of the test over that in the first, the start left out."""
    third = len(record.kinetic) // 3
    return float(record.kinetic[-third:].mean() / record.kinetic[third // 3 : third].mean())


def main(folder: Path) -> None:
    laid = lay_sample(280, 60, seed=0)
    sample = compact(laid, pressure=PRESSURE, density=DENSITY, solver=lm.AcceleratedGaussSeidel(tolerance=1e-4)).sample

    def run(law: lm.Law, tolerance: float = TOLERANCE) -> BiaxialRecord:
        solver = lm.AcceleratedGaussSeidel(tolerance=tolerance, max_iterations=20_000)
        biaxial = Biaxial(sample, law, pressure=PRESSURE, density=DENSITY, solver=solver)
        record = biaxial.run(STRAIN, frames=0)
        print(f"{law!r} at {tolerance:g}: {record.seconds:.0f} s, {record.unconverged} steps unconverged", file=sys.stderr)
        return record

    with ThreadPoolExecutor(2) as pool:
        rigid = pool.submit(run, lm.RigidWire())
        noise = pool.submit(run, lm.RigidWire(), 10 * TOLERANCE)
        elastic = {ea: pool.submit(run, lm.ElasticWire(axial_rigidity=ea)) for ea in RIGIDITIES}
        rigid, noise = rigid.result(), noise.result()
        elastic = {ea: future.result() for ea, future in elastic.items()}

    step = Biaxial(sample, pressure=PRESSURE, density=DENSITY).time_step
    bead = sample.radii[0]
    mass = DENSITY * np.pi * bead**2
    length = sample.reference_gap + 2 * bead
    rows = []
    for ea, record in [*elastic.items(), ("rigid", noise)]:
        stiff = f"{step**2 * ea / length / mass:.2g}" if ea != "rigid" else f"rigid, tolerance {10 * TOLERANCE:g}"
        rows.append(
            [
                ea if ea == "rigid" else f"{ea:.0e}",
                stiff,
                f"{100 * difference(record, rigid, 0.005):.2f} %",
                f"{100 * difference(record, rigid, 0.02):.2f} %",
                f"{trend(record):.2f}",
                f"{record.residual.mean():.1e}",
                record.unconverged,
                f"{record.seconds:.0f}",
            ]
        )
    header = ["EA [N]", "h^2 k/m", "from rigid, to 0.5 %", "to 2 %", "kinetic energy, late / early"]
    header += ["residual", "unconverged", "seconds"]
    report("elastic_wire", header, rows)

    figure = new_figure()
    axes = figure.subplots()
    shades = [0.85 - 0.6 * i / len(RIGIDITIES) for i in range(len(RIGIDITIES))]
    for (ea, record), shade in zip(elastic.items(), shades, strict=True):
        reaction = 1e-3 * record.smooth(record.reaction)
        axes.plot(100 * record.strain, reaction, color=(shade, shade, 1.0), label=f"EA = {ea:.0e} N")
    axes.plot(100 * rigid.strain, 1e-3 * rigid.smooth(rigid.reaction), color="black", linestyle="--", label="rigid wire")
    axes.set_xlabel("crushing [%]")
    axes.set_ylabel("support reaction [kN per m of depth]")
    axes.legend(frameon=False, fontsize="small")
    save(figure, folder / "elastic_wire.png")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else RESULTS)
