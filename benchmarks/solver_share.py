"""The solver's share in figure 3 of the paper: the reaction of wire and rods against what a step costs.

One sample is crushed again and again, each time with another solver: plain Gauss-Seidel link by link with a fixed number of
sweeps a step, as codes of the field do it, the same with the wire as a block, sweeps with momentum to a residual, and
`Auto` to residuals from 1e-2 to 1e-5. The reaction is the mean between 1 % of crushing and the end, over pressure x width;
its error is against that of `Auto` at 1e-5. Paths part, so that errors below some percent are those of another path: runs
of sand at 1e-3 and 1e-5 tell how much that is. In a dense sample, which rods jam, `Auto` goes to 1e-3 only.

    python benchmarks/solver_share.py [grains, 600] [beads, 100] [crushing in %, 4] [loose or dense]
"""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from table import RESULTS, report

import lmgcpy as lm
from lmgcpy.experiment import Biaxial, BiaxialRecord, Study2D, compact
from lmgcpy.experiment.texsol.study import DENSITY, LAWS
from lmgcpy.view.figures import name_of, new_figure, save

NEVER = 1e-14
"""A tolerance that no step of a test reaches: the sweeps are as many as asked for."""
FROM = 0.01
"""Crushing from which the reaction is averaged."""
SWEEPS, RESIDUALS = (50, 200, 1000, 5000), (1e-2, 1e-3, 1e-4, 1e-5)

SOLVERS: dict[str, list[tuple[str, lm.Solver]]] = {
    "Gauss-Seidel, link by link": [
        (f"{count} sweeps", lm.GaussSeidel(tolerance=NEVER, slip=NEVER, max_iterations=count, wire_blocks=False))
        for count in SWEEPS
    ],
    "Gauss-Seidel, wire as a block": [
        (f"{count} sweeps", lm.GaussSeidel(tolerance=NEVER, slip=NEVER, max_iterations=count)) for count in SWEEPS
    ],
    "accelerated": [
        (f"{tolerance:.0e}", lm.AcceleratedGaussSeidel(tolerance=tolerance, max_iterations=6000))
        for tolerance in RESIDUALS[:-1]
    ],
    "Auto": [(f"{tolerance:.0e}", lm.Auto(tolerance=tolerance)) for tolerance in RESIDUALS],
}


def main(grains: int, beads: int, strain: float, preparation: str) -> None:
    study = Study2D(grain_count=grains, bead_count=beads, strain=strain, preparation=preparation)
    loose = preparation == "loose"
    friction = study.friction if loose else 0.0
    sample = compact(study.lay_sample(), pressure=study.pressure, density=DENSITY, friction=friction).sample
    solvers = {family: members[: None if loose or family != "Auto" else 2] for family, members in SOLVERS.items()}

    def run(law: str, solver: lm.Solver) -> BiaxialRecord:
        options = {"pressure": study.pressure, "density": DENSITY, "friction": study.friction, "solver": solver}
        record = Biaxial(sample, LAWS[law](study.axial_rigidity), **options).run(strain, frames=0)
        print(f"{law}, {solver!r}: {record.seconds:.0f} s", file=sys.stderr, flush=True)
        return record

    def reaction(record: BiaxialRecord) -> float:
        return float(record.reaction[record.strain >= FROM].mean() / (study.pressure * sample.width))

    planned = [
        (law, family, *named) for law in ("rigid-wire", "rigid-rod") for family in solvers for named in solvers[family]
    ]
    planned += [("none", "Auto", *solvers["Auto"][k]) for k in (1, -1)]
    with ThreadPoolExecutor(2) as pool:
        records = list(pool.map(lambda plan: run(plan[0], plan[3]), planned))
    best = {
        law: reaction(record) for (law, *_), record in zip(planned, records, strict=True)
    }  # the last of a law: Auto, 1e-5
    rows, points = [], {}
    for (law, family, how, _), record in zip(planned, records, strict=True):
        error = abs(reaction(record) / best[law] - 1.0)
        seconds = record.seconds / len(record.strain)
        points.setdefault((law, family), []).append((seconds, error, float(record.residual.mean())))
        rows.append(
            [
                law, family, how, f"{1e3 * seconds:.0f}", f"{record.residual.mean():.1e}", f"{reaction(record):.3f}",
                f"{100 * error:.1f}", f"{record.reaction.max() / (study.pressure * sample.width):.2f}",
                f"{record.unconverged} of {len(record.strain)}",
            ]
        )  # fmt: skip
    header = ["law", "solver", "to", "ms a step", "mean residual", "mean reaction", "error [%]", "greatest", "unsolved"]
    name = "solver_share" if loose else "solver_share_dense"
    report(name, header, rows)

    figure = new_figure(11.0)
    panels = figure.subplots(2, 2, sharex=True, sharey="row")
    for column, law in zip(panels.T, ("rigid-wire", "rigid-rod"), strict=True):
        for family in solvers:
            seconds, errors, residuals = np.array(points[law, family]).T
            shown = errors > 0.0
            column[0].loglog(1e3 * seconds[shown], 100.0 * errors[shown], marker="o", label=family)
            column[1].loglog(1e3 * seconds, residuals, marker="o", label=family)
        column[0].set_title(name_of(law), fontsize="medium")
        column[1].set_xlabel("a step [ms]")
    panels[0, 0].set_ylabel("error of the mean reaction [%]")
    panels[1, 0].set_ylabel("mean residual")
    panels[0, 1].legend(frameon=False, fontsize="small")
    save(figure, RESULTS / f"{name}.png")


if __name__ == "__main__":
    words = sys.argv[1:]
    grains, beads, percent, preparation = [*words, *("600", "100", "4", "loose")[len(words) :]]
    main(int(grains), int(beads), int(percent) / 100.0, preparation)
