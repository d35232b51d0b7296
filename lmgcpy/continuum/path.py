"""Paths of a material point: each component has either its strain or its stress imposed.

Every increment is a few Newton steps on the strains that are not imposed, with the tangent of the material point. They
start from the last increment. If they fail, they start from zero strain; if that fails too, the increment is halved, until
parts are too small or too many failed.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lmgcpy.continuum.tensors import SIZE
from lmgcpy.continuum.texsol import PointState, TexSol
from lmgcpy.errors import AXES, named_arguments, number, numbers, one_of, shown

CLOSE = 1e-10
"""Largest error of a prescribed stress, over the largest of them or, if that is more, 1 % of the mean pressure."""
ROUND_OFF = 1e-15
"""Error of a stress by the rounding of strains, over tangent and strain."""
FREE = 1e-13
"""Stiffness over the largest of a tangent below which it leaves a strain free."""
MOST_STEPS = 30
"""Newton steps of an increment before it is halved."""
MOST_HALVINGS = 20
"""Greatest number of times that an increment is halved before the path ends."""
MOST_PARTS = 100
"""Greatest number of parts of an increment that fail before the path ends: without a bound a material that has a solution
for tiny parts alone, as Mohr and Coulomb's beside much wire, would take a million of them."""
SEARCHES = 6
"""Greatest number of times that a Newton step is halved if it makes the error larger."""


class NoSolution(ArithmeticError):
    """A path asks for stresses that the material cannot have."""

    solved = 0
    """Number of increments of the path before the one without a solution."""


@dataclass(frozen=True, eq=False, repr=False)
class DrivenPath:
    """Response of a material point on a path of s increments, in vectors of Mandel's notation, traction positive."""

    strain: np.ndarray
    """[-], (s, m)."""
    stress: np.ndarray
    """Stress of sand and wire [Pa], (s, m)."""
    sand: np.ndarray
    """Stress of the sand [Pa], (s, m)."""
    wire: np.ndarray
    """Stress of the wire [Pa], (s, m)."""
    kappa: np.ndarray
    """Plastic shear of the sand [-], (s,)."""
    residual: np.ndarray
    """Largest error of a prescribed stress over the pressure, (s,)."""
    steps: np.ndarray
    """Newton steps, (s,)."""
    state: PointState = field(compare=False)
    """State at the end."""
    axis: str = ""
    """Axis of the compression: "x", "y", "z", or nothing for other paths."""

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return 2 if self.strain.shape[1] == SIZE[2] else 3

    @property
    def volume_change(self) -> np.ndarray:
        """Trace of the strain, dilation positive, (s,)."""
        return self.strain[:, : self.dimension].sum(axis=1)

    @property
    def axial_strain(self) -> np.ndarray:
        """Strain along the axis of the compression, (s,)."""
        return self.strain[:, self._place]

    @property
    def deviator(self) -> np.ndarray:
        """q: pressure along the axis of the compression less the mean pressure across it [Pa], (s,)."""
        place, normal = self._place, self.stress[:, : self.dimension]
        return np.delete(normal, place, axis=1).mean(axis=1) - normal[:, place]

    @property
    def _place(self) -> int:
        if not self.axis:
            raise ValueError("This path has no axis: it was made by drive(), and not by biaxial() or triaxial().")
        return AXES.index(self.axis)

    def __repr__(self) -> str:
        along = f" along {self.axis}" if self.axis else ""
        return (
            f"<DrivenPath{along} of {len(self.strain)} increments in {self.dimension}D, residual {self.residual.max():.1e}>"
        )


@named_arguments
def drive(material: TexSol, state: PointState, strains: Any, stresses: Any, axis: str = "") -> DrivenPath:
    """Lead a material point from ``state`` along a path.

    ``strains`` (s, m): strains at the end of each increment, NaN for components that are not imposed; ``stresses`` (s, m)
    [Pa]: stresses of sand and wire together, NaN for components with an imposed strain. Every component of every increment
    has one of the two.

    Prescribed stresses are met to 1e-10 of the largest of them, or to the round-off of the strains if that is more. Raises
    TypeError or ValueError for other arrays, and NoSolution if an increment has no solution: the sentence names it.
    """
    if not isinstance(material, TexSol):
        raise TypeError(f"material must be a TexSol, got {shown(material)}.")
    _check_state(material, state)
    if axis:
        one_of(axis, "axis", AXES[: material.dimension])
    imposed, held = _rows(strains, "strains", material), _rows(stresses, "stresses", material)
    if imposed.shape != held.shape:
        raise ValueError(f"strains and stresses must have the same shape, got {imposed.shape} and {held.shape}.")
    free = np.isnan(imposed)
    if (free == np.isnan(held)).any():
        step, part = np.argwhere(free == np.isnan(held))[0]
        raise ValueError(
            f"Every component takes a strain or a stress, and NaN for the other; component {part} of increment {step} "
            f"{'has neither' if free[step, part] else 'has both'}."
        )
    count, size = imposed.shape
    strain, sand, wire = np.empty((count, size)), np.empty((count, size)), np.empty((count, size))
    kappa, residual, steps = np.empty(count), np.empty(count), np.zeros(count, dtype=int)
    last = np.zeros(size)
    for i in range(count):
        places = np.flatnonzero(free[i])
        target = np.where(free[i], held[i], imposed[i])
        before = state
        try:
            state, residual[i], steps[i] = _advance(material, state, places, target, last)
        except NoSolution as error:
            told = NoSolution(
                f"Increment {i} of {count} has no solution: {error} The last strain that has one is "
                f"{shown(np.round(state.strain, 6).tolist())}."
            )
            told.solved = i
            raise told from error
        last = state.strain - before.strain
        strain[i], sand[i], wire[i], kappa[i] = state.strain, state.sand, state.wire, state.kappa
    return DrivenPath(strain, sand + wire, sand, wire, kappa, residual, steps, state, axis)


def _check_state(material: TexSol, state: Any) -> None:
    """Raise TypeError or ValueError if this is no state of the material."""
    if not isinstance(state, PointState):
        raise TypeError(f"state must be a PointState, such as material.start(pressure) gives, got {shown(state)}.")
    size = SIZE[material.dimension]
    if state.strain.shape != (size,):
        raise ValueError(
            f"state is of another dimension than the material: its strain is of shape {state.strain.shape}, not ({size},)."
        )
    slips = 0 if material.wire is None else len(material.wire.directions)
    if len(state.slip) != slips:
        raise ValueError(f"state is of another material: it has {len(state.slip)} directions of wire, and not {slips}.")
    if not all(np.isfinite(part).all() for part in (state.strain, state.sand, state.wire, state.kappa, state.slip)):
        raise ValueError(f"state must have finite numbers, got {shown(state)}.")


def _rows(value: Any, name: str, material: TexSol) -> np.ndarray:
    """Rows of a path, with NaN."""
    size = SIZE[material.dimension]
    try:
        given = np.array(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise TypeError(f"{name} must be an array (s, {size}) of numbers and NaN, got {shown(value)}.") from error
    if given.ndim != 2 or given.shape[1] != size or not len(given):
        raise ValueError(f"{name} must be of shape (s, {size}) in {material.dimension}D, got {given.shape}.")
    numbers(np.where(np.isnan(given), 0.0, given), name)
    return given


def _advance(
    material: TexSol, state: PointState, places: np.ndarray, target: np.ndarray, guess: np.ndarray
) -> tuple[PointState, float, int]:
    """State at the end of an increment, error of its stresses over the pressure, and Newton steps.

    ``target``: strains, and stresses at ``places``; ``guess``: the increment of strain to start from. Parts that fail are
    halved, in the order of the path.
    """
    total, tries, error, parts = 0, 0, 0.0, [(target, 0)]
    while parts:
        target, depth = parts.pop()
        for start in (guess, np.zeros(len(guess))):
            found, error, steps = _newton(material, state, places, target, start)
            total += steps
            if found is not None:
                guess, state = found.strain - state.strain, found
                break
        else:
            tries += 1
            if depth == MOST_HALVINGS or tries == MOST_PARTS:
                raise NoSolution("the material cannot have these stresses at these strains, or has no strength left.")
            present = state.strain.copy()
            present[places] = state.stress[places]
            parts += [(target, depth + 1), (0.5 * (present + target), depth + 1)]
            guess = 0.5 * guess
    return state, error, total


def _newton(
    material: TexSol, state: PointState, places: np.ndarray, target: np.ndarray, guess: np.ndarray
) -> tuple[PointState | None, float, int]:
    """The state that meets the ``target``, or None; the error of its stresses over the pressure, and the steps."""
    increment = target - state.strain
    increment[places] = guess[places]
    answer = material.material_point(increment, state)
    if not len(places):
        return answer.state, 0.0, 0
    wanted = target[places]
    d = material.dimension
    # prescribed stresses are the measure, unless they are as small as zero
    pressure = max(0.01 * abs(float(state.stress[:d].sum())) / d, float(np.abs(wanted).max()))
    square = places[:, None], places
    error = answer.stress[places] - wanted
    size = float(np.abs(error).max())
    for step in range(MOST_STEPS):
        part = answer.tangent[square]
        rounding = ROUND_OFF * float(np.abs(part).max()) * float(np.abs(answer.state.strain).max())
        if size <= CLOSE * pressure or size <= rounding:
            return answer.state, size / pressure if pressure > 0.0 else 0.0, step
        try:  # of strains that the material leaves free, as on an edge of Mohr and Coulomb's, the least change
            change = np.linalg.lstsq(part, error, rcond=FREE)[0]
        except np.linalg.LinAlgError:
            return None, size, step
        if not change.any():  # no pressure is left: no step leads out
            return None, size, step
        factor = 1.0
        for _ in range(SEARCHES):
            new = increment.copy()
            new[places] -= factor * change
            answer = material.material_point(new, state)
            error = answer.stress[places] - wanted
            better = float(np.abs(error).max())
            if better < size:
                break
            factor *= 0.5
        increment, size = new, better
        if not size < np.inf:
            break
    return None, size, MOST_STEPS


def _compression(
    material: TexSol, axial_strain: Any, pressure: float, axis: str, flat: str | None, state: PointState | None
) -> DrivenPath:
    """A compression along ``axis``: the other sides have the ``pressure``, except along ``flat``, which has no strain."""
    if not isinstance(material, TexSol):
        raise TypeError(f"material must be a TexSol, got {shown(material)}.")
    pressure = number(pressure, "pressure", above=0.0, unit="Pa")
    d, size = material.dimension, SIZE[material.dimension]
    along = AXES.index(one_of(axis, "axis", AXES[:d]))
    axial = numbers(axial_strain, "axial_strain", "the strains along the axis, compression negative")
    if axial.ndim != 1 or not len(axial):
        raise ValueError(f"axial_strain must be of shape (s,), got {axial.shape}.")
    start = material.start(pressure) if state is None else state
    _check_state(material, start)
    strains, stresses = np.tile(start.strain, (len(axial), 1)), np.full((len(axial), size), np.nan)
    strains[:, along] = axial
    for side in range(d):
        if side != along and AXES[side] != flat:
            strains[:, side] = np.nan
            stresses[:, side] = -pressure
    return drive(material, start, strains, stresses, axis)


@named_arguments
def triaxial(
    material: TexSol, axial_strain: Any, *, pressure: float, axis: str = "z", state: PointState | None = None
) -> DrivenPath:
    """Triaxial compression (3D) of a box with smooth walls: ``pressure`` [Pa] on the four lateral walls.

    ``axial_strain`` (s,): strains along ``axis`` at the end of the increments, logarithmic, compression negative. The sides
    stay at right angles, so that there is no further shear strain. ``state``: the start; if None, the pressure without
    strain.

    Raises TypeError or ValueError with a sentence, and NoSolution as :func:`drive` does.
    """
    if isinstance(material, TexSol) and material.dimension != 3:
        raise ValueError("A triaxial test takes a material of dimension 3; in 2D there is biaxial().")
    return _compression(material, axial_strain, pressure, axis, None, state)


@named_arguments
def biaxial(
    material: TexSol,
    axial_strain: Any,
    *,
    pressure: float,
    axis: str = "y",
    normal: str = "z",
    state: PointState | None = None,
) -> DrivenPath:
    """Biaxial compression in 2D, or in plane strain of a material in 3D: ``pressure`` [Pa] on the lateral sides.

    ``axial_strain`` (s,): strains along ``axis`` at the end of the increments, logarithmic, compression negative;
    ``normal``: in 3D, the axis along which there is no further strain. ``state``: the start; if None, the pressure without
    strain.

    Raises TypeError or ValueError with a sentence, and NoSolution as :func:`drive` does.
    """
    in_space = isinstance(material, TexSol) and material.dimension == 3
    if in_space and one_of(normal, "normal", AXES) == axis:
        raise ValueError(f"normal must be another axis than that of the compression, got '{normal}' twice.")
    return _compression(material, axial_strain, pressure, axis, normal if in_space else None, state)
