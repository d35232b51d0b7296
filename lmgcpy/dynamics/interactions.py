"""The interactions of a step as a user sees them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from lmgcpy.contact.frames import local_frames
from lmgcpy.contact.interactions import Interactions, levers
from lmgcpy.dynamics.cell import CellMotion
from lmgcpy.dynamics.model import Model
from lmgcpy.dynamics.rolling import moments
from lmgcpy.dynamics.step_problem import StepProblem


@dataclass(frozen=True)
class InteractionView:
    """Links and all candidates within alert of a step, as copies; m of them, in canonical order. Simulations and run files
    give the same, but that a file has no states of laws."""

    law: np.ndarray
    """Names of the laws, (m,)."""
    candidate: np.ndarray
    """Ids of the candidate bodies, (m,)."""
    antagonist: np.ndarray
    """Ids of the antagonist bodies, (m,)."""
    gap: np.ndarray
    """Gaps at the detection configuration [m], (m,)."""
    normal: np.ndarray
    """Unit normals from the antagonist to the candidate, (m, d)."""
    point: np.ndarray
    """Contact points at the detection configuration [m], (m, d)."""
    lever: np.ndarray
    """Contact point seen from the centre of the candidate, and of the antagonist [m], (m, 2, d). A wall has no centre: in a
    simulation the point is seen from its foot on the wall, in a file from the position of the wall."""
    impulse: np.ndarray
    """Impulses in the local frame, normal first [N s], (m, d)."""
    force: np.ndarray
    """impulse / time step [N], (m, d)."""
    moment: np.ndarray
    """Impulses of the moments of rolling friction on the candidates [N m s], (m, 1) in 2D, (m, 3)
    in the local frame in 3D, normal (torsion) first; (m, 0) in scenes without any."""
    state: dict[str, np.ndarray] = field(default_factory=dict)
    """Numbers that laws with a state keep, by name, (m,) each; NaN if the law of an interaction keeps no such number."""

    @property
    def frame(self) -> np.ndarray:
        """Rows n, t(, s) of the local frames, (m, d, d)."""
        return local_frames(self.normal)

    @classmethod
    def empty(cls, dimension: int, state_names: list[str], rolling_rows: int = 0) -> InteractionView:
        """No interaction."""
        ids, vectors = np.zeros(0, dtype=np.int64), np.zeros((0, dimension))
        levers, state = np.zeros((0, 2, dimension)), {name: np.zeros(0) for name in state_names}
        turning = np.zeros((0, rolling_rows))
        return cls(ids.astype("<U1"), ids, ids, np.zeros(0), vectors, vectors, levers, vectors, vectors, turning, state)

    @classmethod
    def of(
        cls,
        problem: StepProblem,
        interactions: Interactions,
        state_names: list[str],
        detected: np.ndarray,
        extent: np.ndarray,
    ) -> InteractionView:
        """Copy the arrays of a step; ``state_names``: of all laws of the scene; ``detected``: positions of the bodies at
        the detection [m], (n, d); ``extent`` of the bodies [m], infinite for walls, (n,)."""
        groups, d = problem.by_law, problem.dimension
        impulse = problem.system.impulse[:, :d]
        names = [group.law.NAME for group in groups]
        counts = [group.stop - group.start for group in groups]
        normal = interactions.normal
        lever = levers(interactions, slice(None))
        for group in groups:
            if group.chain is None:
                continue
            part = slice(group.start, group.stop)
            if not group.jointed:  # the point of a link is its middle
                half = 0.5 * (interactions.gap[part] + group.chain.radius_sum)[:, None] * normal[part]
                lever[part] += np.stack([-half, half], axis=1)
            points = group.chain.points
            if d == 3 and points is not None:  # levers of walls, which never turn, are left out
                held = np.where(points.turns[:, None], 0.0, points.offset)
                antagonist, candidate = group.chain.ends
                lever[part] += np.stack([held[candidate], held[antagonist]], axis=1)
        state = {name: np.full(len(impulse), np.nan) for name in state_names}
        for group in groups:
            for k, name in enumerate(group.law.states()):
                state[name][group.start : group.stop] = problem.data.state[group.start : group.stop, k]
        candidate, antagonist = (ids.astype(np.int64) for ids in (interactions.candidate, interactions.antagonist))
        # a wall has no centre, so that its contact point is measured from the other body
        from_wall = ~np.isfinite(extent)[candidate]
        seen_from = np.where(from_wall, antagonist, candidate)
        return cls(
            law=np.repeat(np.array(names or [""]), counts or [0]),
            candidate=candidate,
            antagonist=antagonist,
            gap=interactions.gap.copy(),
            normal=normal.copy(),
            point=detected[seen_from] + np.where(from_wall[:, None], lever[:, 1], lever[:, 0]),
            lever=lever,
            impulse=impulse.copy(),
            force=impulse / problem.data.time_step,
            moment=moments(problem.system.rolling, problem.system.impulse, d),
            state=state,
        )

    def __len__(self) -> int:
        return len(self.gap)

    def __repr__(self) -> str:
        names, counts = np.unique(self.law, return_counts=True)
        by_law = ", ".join(f"{count} {name}" for name, count in zip(names, counts, strict=True))
        return f"<{len(self)} interactions: {by_law or 'none'}>"


def detection_positions(
    positions: np.ndarray, velocities: np.ndarray, theta: float, time_step: float, cell: CellMotion | None = None
) -> np.ndarray:
    """Positions at the detection of the step that has ended, ``q_m = q - theta h v`` [m], (n, d); in a periodic ``cell``
    those from which the step went on with the cell's motion."""
    if cell is not None:
        return cell.before(positions, theta * time_step * velocities)
    return positions - theta * time_step * velocities


class MadeStep(NamedTuple):
    """A step as it was made: statements since may have given the simulation another model, time step or theta, and further
    bodies."""

    problem: StepProblem
    interactions: Interactions
    model: Model
    theta: float

    @property
    def time_step(self) -> float:
        """[s]."""
        return self.problem.data.time_step

    def detected(self, positions: np.ndarray) -> np.ndarray:
        """Positions at the detection [m], (n, d), of the n bodies of the step, from the present ones, (n or more, d);
        velocities that were written since do not count."""
        velocity = self.problem.system.velocity[:, : self.model.dimension]
        return detection_positions(positions[: len(velocity)], velocity, self.theta, self.time_step, self.model.cell)
