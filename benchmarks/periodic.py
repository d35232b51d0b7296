"""A periodic cell of 500 grains: Weber's stress against the imposed one, its friction in shear, and what walls change.

Each seed: grains at random in a cell, compacted under 100 kPa without friction, then sheared with friction 0.4 to a strain
of 1 at an inertial number of 0.01, the normal stress held. Means are over the second half of the shear. Beside it the solid
fraction of the same grains in a box of frictionless walls, compacted without friction: walls leave voids.

python benchmarks/periodic.py [GRAINS [SEEDS [STRAIN]]]
python benchmarks/periodic.py picture FILE        the picture of docs/periodic.md
"""

from __future__ import annotations

import sys

import numpy as np
from table import report

import lmgcpy as lm
from lmgcpy.experiment import PeriodicShear, Sample, compact, lay_periodic

PRESSURE, FRICTION = 1e5, 0.4


def walled(radii: np.ndarray, dimension: int, seed: int) -> float:
    """Solid fraction of a whole box of these grains, compacted without friction."""
    volume = float((np.pi * radii**2 if dimension == 2 else 4.0 / 3.0 * np.pi * radii**3).sum())
    length = (volume / (0.8 if dimension == 2 else 0.55)) ** (1.0 / dimension)
    box = (*(length,) * (dimension - 1), None)
    positions = lm.sample.deposit(radii, box=box, seed=seed)
    height = float((positions[:, -1] + radii).max())
    sample = Sample(positions, radii, (), 0.0, np.array([*(length,) * (dimension - 1), height]))
    done = compact(sample, pressure=PRESSURE, density=2600.0, drag=0.1, max_steps=2000).sample
    return volume / float(np.prod(done.box))


def picture(file: str) -> None:
    """Contact reactions in a sheared cell of 500 disks."""
    radii = lm.sample.grading(500, minimum=0.005, maximum=0.010, seed=0)
    pressed = compact(lay_periodic(radii, dimension=2, seed=0), pressure=PRESSURE)
    shear = PeriodicShear(pressed.sample, pressure=PRESSURE, friction=FRICTION)
    shear.run(0.35)
    lm.view.render(shear.simulation, file, what="forces", size=(900, 760))


def main(grains: int, seeds: int, strain: float) -> None:
    rows = []
    for dimension in (2, 3):
        for seed in range(seeds):
            radii = lm.sample.grading(grains, minimum=0.005, maximum=0.010, dimension=dimension, seed=seed)
            pressed = compact(lay_periodic(radii, dimension=dimension, seed=seed), pressure=PRESSURE)
            record = PeriodicShear(pressed.sample, pressure=PRESSURE, friction=FRICTION).run(strain)
            late = record.mean(0.5 * strain)
            spread = record.stress[record.strain >= 0.5 * strain, 1, 1].std() / PRESSURE
            rows.append(
                [
                    dimension,
                    seed,
                    f"{np.abs(pressed.stress / PRESSURE + np.eye(dimension)).max():.1e}",
                    f"{pressed.solid_fraction:.4f}",
                    f"{walled(radii, dimension, seed):.4f}",
                    f"{pressed.coordination:.2f}",
                    f"{late['normal'] - 1.0:+.1e}",
                    f"{spread:.1e}",
                    f"{late['friction']:.3f}",
                    f"{late['solid_fraction']:.3f}",
                    f"{record.penetration.max() / pressed.sample.diameter:.1e}",
                    f"{pressed.unconverged} + {record.unconverged}",
                    f"{pressed.seconds:.0f} + {record.seconds:.0f}",
                ]
            )
            print(dict(zip(HEADER, rows[-1], strict=True)), file=sys.stderr, flush=True)
    report("periodic", HEADER, rows)


HEADER = [
    "dimension",
    "seed",
    "stress at rest, error",
    "solid fraction",
    "in a box",
    "coordination",
    "normal stress in shear, error",
    "its spread",
    "friction in shear",
    "solid fraction in shear",
    "overlap / d",
    "unconverged",
    "seconds",
]

if __name__ == "__main__":
    given = sys.argv[1:]
    if given[:1] == ["picture"]:
        picture(given[1])
        raise SystemExit
    main(
        int(given[0]) if given else 500,
        int(given[1]) if len(given) > 1 else 3,
        float(given[2]) if len(given) > 2 else 1.0,
    )
