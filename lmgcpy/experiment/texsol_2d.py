"""The paper's 2D study: one sample, a biaxial test per law, and what the wire does to the sand (section 3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from lmgcpy.errors import named_arguments
from lmgcpy.experiment.biaxial import Biaxial, BiaxialRecord, Frame
from lmgcpy.experiment.stages import Stages
from lmgcpy.experiment.texsol_sample import lay_sample
from lmgcpy.experiment.texsol_tests import LAWS, Planned, Result, TexSolStudy, carry_out_study

if TYPE_CHECKING:
    from lmgcpy.experiment.texsol_folder import StudyFolder


@named_arguments
@dataclass(frozen=True)
class Study(TexSolStudy):
    """What to compute in 2D. Defaults are the paper's sample: 2000 particles of which 300 are wire beads.

    Checks are made at a ten times tighter tolerance; other fields as in :class:`TexSolStudy`.
    """

    DIMENSION: ClassVar[int] = 2

    laws: tuple[str, ...] = ("none", "rigid-wire", "rigid-rod")
    grain_count: int = 1700
    bead_count: int = 300
    seed: int = 0
    strain: float = 0.10
    pressure: float = 1e5
    tolerance: float = 3e-3
    max_iterations: int = 6000
    friction: float = 0.4
    platen_friction: float = 0.0
    inertial_number: float = 1e-3
    axial_rigidity: float = 1e7
    check_strain: float = 0.05
    threads: int = 2

    def quick(self) -> Study:
        """The same on a small sample, for a look: 340 particles, 5 % crushing."""
        return replace(self, grain_count=280, bead_count=60, strain=0.05, check_strain=0.02)


def run_study(
    study: Study, stages: Stages | None = None, folder: StudyFolder | None = None, *, resume: bool = False
) -> Result:
    """Prepare the sample and crush it once per law; see :func:`lmgcpy.experiment.texsol_tests.carry_out_study`."""

    def planned(law: str, tighter: float = 1.0) -> Planned:
        def make(sample):
            return Biaxial(sample, LAWS[law](study.axial_rigidity), **study.options(tighter))

        if tighter > 1.0:
            strain = min(study.check_strain, study.strain)
            return Planned(f"{law}-tight", f"biaxial test, {law}, tolerance / {tighter:g}", make, strain, 0)
        return Planned(law, f"biaxial test, {law}", make, study.strain, 100)

    # the longest first, so that no thread waits for the last
    order = sorted(study.laws, key=lambda law: ("rod" not in law, "wire" not in law))
    checks = [planned(law, 10.0) for law in order] if study.check_strain > 0.0 else []
    compaction, done = carry_out_study(
        study,
        lambda: lay_sample(study.grain_count, study.bead_count, seed=study.seed),
        [*checks, *map(planned, order)],
        relaxation=lambda laid: {},
        stages=stages,
        folder=folder,
        resume=resume,
    )
    return Result(
        study,
        compaction,
        {law: done[law] for law in study.laws},
        {law: done[f"{law}-tight"] for law in study.laws if checks},
    )


# ------------------------------------------------------------------------------------------------------- conclusions


def stiffening(wire: BiaxialRecord, sand: BiaxialRecord, strains: Sequence[float]) -> list[tuple[float, float]]:
    """(crushing, reaction with the wire / reaction of the sand) at the given crushing, as far as the tests went."""
    found = []
    for strain in strains:
        if strain <= min(wire.strain[-1], sand.strain[-1]) + 1e-3:
            there = [np.interp(strain, record.strain, record.smooth(record.reaction, 0.005)) for record in (wire, sand)]
            found.append((strain, float(there[0] / there[1])))
    return found


def column(rod: BiaxialRecord, wire: BiaxialRecord, factor: float = 2.0) -> tuple[float | None, float]:
    """(crushing, ratio): where the rods' mean reaction first exceeds ``factor`` times the wire's, and the greatest ratio
    of the two. The crushing is None where it never does so for 0.5 % on end.
    """
    strain = rod.strain[rod.strain <= wire.strain[-1]]
    of_wire = np.interp(strain, wire.strain, wire.smooth(wire.reaction))
    ratio = rod.smooth(rod.reaction)[: len(strain)] / of_wire
    above = ratio > factor
    for k in np.flatnonzero(above):
        if above[(strain >= strain[k]) & (strain <= strain[k] + 0.005)].all():
            return float(strain[k]), float(ratio.max())
    return None, float(ratio.max())


def compression_in_links(record: BiaxialRecord) -> tuple[float, float]:
    """(share, crushing): the greatest share of the vertical load that links carry in compression, and where.

    The share is the part of the vertical Weber stress that comes from links with a compressive force, over the total,
    frame by frame.
    """
    best = (0.0, 0.0)
    for frame in record.frames:
        x0, x1, y0, y1 = frame.walls
        chosen = frame.in_wire & (frame.forces > 0.0)
        branch = frame.lines[chosen, 1] - frame.lines[chosen, 0]
        length = np.linalg.norm(branch, axis=1)
        carried = float(np.sum(frame.forces[chosen] * branch[:, 1] ** 2 / length)) / ((x1 - x0) * (y1 - y0))
        total = frame.top_force / (x1 - x0)
        if total > 0.0 and carried / total > best[0]:
            best = (carried / total, frame.strain)
    return best


def frames_at_equal_force(wire: BiaxialRecord, sand: BiaxialRecord) -> tuple[Frame, Frame]:
    """A frame of each at the same force on top, to 1 %: of all such pairs the most crushed one. Where there is none, the
    pair whose forces differ least."""
    force = [np.array([frame.top_force for frame in record.frames]) for record in (wire, sand)]
    strain = [np.array([frame.strain for frame in record.frames]) for record in (wire, sand)]
    apart = np.abs(force[0][:, None] - force[1][None]) / np.maximum(force[0][:, None], force[1][None])
    crushed = strain[0][:, None] + strain[1][None]
    rank = np.where(apart <= 0.01, crushed, -apart)
    i, j = np.unravel_index(int(np.argmax(rank)), rank.shape)
    return wire.frames[i], sand.frames[j]
