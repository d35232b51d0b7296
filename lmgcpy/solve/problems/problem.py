"""One step as a problem of its own: ``u = W r + q`` with an assembled Delassus operator, and a cone per interaction.

The laws enter in conic form: biases are part of ``q``, and a law is reduced to its cone, its friction and its compliance.
Three cones cover the laws that come with lmgcpy:

* contact: ``0 <= u_n _|_ r_n >= 0`` and ``r_t`` in the disk of radius ``mu r_n``, opposing ``u_t`` when sliding;
* pull: ``0 <= -(u_n + C r_n) _|_ -r_n >= 0``, ``r_t = 0`` (wires);
* both: ``u_n + C r_n = 0``, ``r_t = 0`` (rods).

A link with geometric stiffness kappa has ``r_t = -kappa u_t`` in place of ``r_t = 0``.

If contacts have rolling friction, every interaction has rolling components as well, after the others: one in 2D, in 3D
two of rolling and one of torsion. Their impulses are in a disk of radius ``mu_r r_n`` and an interval up to ``mu_z r_n``,
each opposing its velocity at its bound: a product of disks under one normal impulse.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lmgcpy.errors import LARGEST, named_arguments, numbers, shown, whole
from lmgcpy.laws import Law
from lmgcpy.laws import get as law_of_name
from lmgcpy.laws.law import ROLLING_ROWS
from lmgcpy.solve.problems.delassus import checked_operator, symmetric_semidefinite

if TYPE_CHECKING:
    import scipy.sparse as sparse

CONTACT, PULL, BOTH = range(3)


def cone_of(law: type[Law]) -> int:
    """The cone of a law's impulse: CONTACT, PULL or BOTH."""
    if law.APPLIES_TO == "contact":
        return CONTACT
    return PULL if "pull" in law.TRAITS else BOTH


class Split(NamedTuple):
    """The operator as ``W = sparse + columns columns^T``: if a periodic cell yields, each of its q components couples all
    interactions, which makes W dense by a part of rank q."""

    sparse: sparse.csr_array
    """Without the cell [1/kg], (m d, m d)."""
    columns: np.ndarray
    """[kg^-1/2], (m d, q)."""

    def __repr__(self) -> str:
        return f"<Split of W: {self.sparse.nnz} entries and {self.columns.shape[1]} columns>"


@named_arguments
@dataclass(frozen=True)
class Problem:
    """A frozen problem of m interactions in dimension d; see the module's text. D is its ``width``, d unless some roll.

    Its arrays are checked and copied. TypeError: an argument is no array of numbers; ValueError: the numbers make no
    problem, as shapes that do not fit, indices outside W, or a W that is not symmetric.
    """

    W: sparse.csr_array
    """Delassus operator [1/kg], (m D, m D), normal component first; given in any sparse format, kept as sorted rows."""
    q: np.ndarray
    """Free relative velocity, biases included [m/s], (m D,)."""
    mu: np.ndarray
    """Coefficient of friction of the contacts, (m,)."""
    dimension: int
    """2 or 3."""
    laws: tuple[str, ...]
    """Name of the law of each interaction, (m,)."""
    compliance: np.ndarray
    """Compliance of the links [1/kg], (m,)."""
    guess: np.ndarray
    """Impulses to start from [N s], (m, D)."""
    geometric: np.ndarray = field(default_factory=lambda: np.zeros(0))
    """Geometric stiffness kappa of the links [kg], (m,), in ``r_t = -kappa u_t``; zero if none is given."""
    scale: np.ndarray | None = None
    """Time step over the radius of the smaller body [s/m], (m,), or None if it is not known."""
    split: Split | None = None
    """W in two parts, which Newton steps factorise faster, or None if it is not split."""
    cone_by_law: Mapping[str, int] = field(default_factory=dict)
    """Cone (0 contact, 1 pull, 2 both) of the laws that are not registered, by name."""
    rolling: np.ndarray = field(default_factory=lambda: np.zeros(0))
    """Coefficient of rolling friction of the contacts, (m,); (0,) if interactions have no rolling components."""
    torsion: np.ndarray = field(default_factory=lambda: np.zeros(0))
    """Coefficient of torsion friction of the contacts in 3D, (m,); zero if none is given."""

    def __post_init__(self):
        whole(self.dimension, "dimension of a problem", minimum=2, maximum=3)
        if not isinstance(self.cone_by_law, Mapping):
            raise TypeError(f"cone_by_law of a problem must be cones by names of laws, got {shown(self.cone_by_law)}.")
        for law, cone in self.cone_by_law.items():
            whole(cone, f"cone_by_law[{shown(law)}] of a problem", minimum=CONTACT, maximum=BOTH)
        object.__setattr__(self, "W", checked_operator(self.W))
        if self.split is not None:
            parts = tuple(getattr(part, "shape", (0,))[0] for part in self.split) if isinstance(self.split, Split) else ()
            if parts != (self.W.shape[0],) * 2:
                raise TypeError(f"split of a problem must be the Split of its W or None, got {shown(self.split)}.")
        arrays = ("q", "mu", "compliance", "guess", "geometric", "rolling", "torsion")
        for name in arrays + (() if self.scale is None else ("scale",)):
            object.__setattr__(self, name, numbers(getattr(self, name), f"{name} of a problem"))
        if self.geometric.size == 0:
            object.__setattr__(self, "geometric", np.zeros_like(self.mu))
        if self.torsion.size and not self.rolling.size:
            raise ValueError("torsion of a problem goes with rolling: give rolling=np.zeros(m) where nothing rolls.")
        if self.torsion.size == 0 < self.rolling.size:
            object.__setattr__(self, "torsion", np.zeros_like(self.rolling))
        self._check_shapes()
        if self.split is None:
            object.__setattr__(self, "W", symmetric_semidefinite(self.W))
        else:
            symmetric_semidefinite(self.split.sparse)
        contact = self.cones == CONTACT
        diagonal = self.W.diagonal()[:: self.width]
        for name, values, sound, bound in (
            ("mu", self.mu, self.mu >= 0.0, "at least 0"),
            ("compliance", self.compliance, self.compliance >= 0.0, "at least 0"),
            ("geometric", self.geometric, self.geometric >= 0.0, "at least 0"),
            ("geometric", self.geometric, ~contact | (self.geometric == 0.0), "0 for a contact"),
            *(() if self.scale is None else (("scale", self.scale, self.scale >= 0.0, "at least 0"),)),
            *((name, values, values >= 0.0, "at least 0") for name, values in self._turning),
            *((name, values, contact | (values == 0.0), "0 for a link") for name, values in self._turning),
            ("W", diagonal, np.where(contact, diagonal > 0.0, diagonal >= 0.0), "above 0 on its diagonal"),
            ("W", diagonal, ~contact | (diagonal >= 1.0 / LARGEST), f"at least {1.0 / LARGEST:g} on its diagonal"),
        ):
            if not sound.all():
                i = int(np.argmin(sound))
                law = self.laws[i]
                raise ValueError(f"{name} of a problem must be {bound}, got {values[i]:g} for interaction {i} ('{law}').")

    def _check_shapes(self) -> None:
        if self.mu.ndim != 1:
            raise ValueError(f"mu of a problem must have shape (m,), got {self.mu.shape}.")
        count, d = len(self.mu), self.width
        if self.W.shape == 2 * self.q.shape and len(self.q) % d == 0:  # two against mu
            count = len(self.q) // d
        shapes = {
            "mu": (count,),
            "W": (count * d, count * d),
            "q": (count * d,),
            "compliance": (count,),
            "guess": (count, d),
            "geometric": (count,),
        }
        if self.scale is not None:
            shapes["scale"] = (count,)
        shapes |= {name: (count,) for name, _ in self._turning}
        for name, shape in shapes.items():
            got = getattr(self, name).shape
            if got != shape:
                more = f", as rolling gives each of them {d} components" if d > self.dimension else ""
                raise ValueError(f"{name} of a problem of {count} interactions must have shape {shape}{more}, got {got}.")
        if not isinstance(self.laws, (tuple, list)) or len(self.laws) != count:
            raise ValueError(f"A problem of {count} interactions must name {count} laws, got {shown(self.laws)}.")

    @property
    def cones(self) -> np.ndarray:
        """Cone of each interaction (0 contact, 1 pull, 2 both), (m,)."""
        known = self.cone_by_law
        of = {name: known[name] if name in known else cone_of(law_of_name(name)) for name in set(self.laws)}
        return np.array([of[name] for name in self.laws], dtype=np.int64)

    @property
    def _turning(self) -> tuple[tuple[str, np.ndarray], ...]:
        """Names and coefficients of the rolling components; empty if there are none."""
        return (("rolling", self.rolling), ("torsion", self.torsion)) if self.rolling.size else ()

    @property
    def width(self) -> int:
        """Number of components of each interaction: ``dimension``, or with rolling components 3 in 2D and 6 in 3D."""
        return ROLLING_ROWS[self.dimension] if self._turning else self.dimension

    @property
    def disks(self) -> list[tuple[slice, np.ndarray]]:
        """The disks of a contact, each with its components of an impulse and its radius over r_n, (m,): friction, and if
        there are any rolling components, rolling, and torsion in 3D."""
        d = self.dimension
        found = [(slice(1, d), self.mu)]
        if self._turning:
            found.append((slice(d, 2 * d - 1), self.rolling))
        if self._turning and d == 3:
            found.append((slice(5, 6), self.torsion))
        return found

    def velocities(self, impulses: np.ndarray) -> np.ndarray:
        """``W r + q`` [m/s], (m, D)."""
        return (self.times(np.asarray(impulses, dtype=float).ravel()) + self.q).reshape(-1, self.width)

    @property
    def rolls(self) -> np.ndarray:
        """Whether each contact has rolling friction, or torsion friction in 3D, (m,) bool."""
        return (self.rolling > 0.0) | (self.torsion > 0.0) if self._turning else np.zeros(len(self.mu), dtype=bool)

    def times(self, r: np.ndarray) -> np.ndarray:
        """``W r`` [m/s] of impulses r (m D,)."""
        if self.split is None:
            return self.W @ r
        sparse, columns = self.split
        return sparse @ r + columns @ (columns.T @ r)

    @property
    def rows(self) -> np.ndarray:
        """Whether each component of an impulse may differ from zero, (m, D) bool."""
        rows = np.zeros((len(self.mu), self.width), dtype=bool)
        rows[:, 0] = True
        for part, share in self.disks:
            rows[:, part] = ((self.cones == CONTACT) & (share > 0.0))[:, None]
        rows[:, 1 : self.dimension] |= (self.geometric > 0.0)[:, None]
        return rows

    def local_weight(self) -> np.ndarray:
        """Mean diagonal of each local block, over the rows that the law has [1/kg], (m,)."""
        diagonal = self.W.diagonal().reshape(-1, self.width)
        tangential = diagonal[:, : self.dimension].mean(axis=1)
        weight = np.where(self.rows[:, 1], tangential, diagonal[:, 0])
        return np.where(self.rolls, diagonal.mean(axis=1), weight) if self._turning else weight

    def react(self, free: np.ndarray, weight: np.ndarray) -> np.ndarray:
        """Impulses [N s], (m, D), that satisfy the laws if each local block of W is ``weight`` (m,) times the identity and
        the free velocities are ``free`` (m, D)."""
        cones = self.cones
        impulse = np.zeros_like(free)
        with_compliance = np.where(cones == CONTACT, weight, weight + self.compliance)
        changes = with_compliance > 0.0  # else no impulse changes the velocity
        normal = np.divide(-free[:, 0], with_compliance, out=np.zeros(len(free)), where=changes)
        push, pull = np.maximum(normal, 0.0), np.minimum(normal, 0.0)
        impulse[:, 0] = np.select([cones == CONTACT, cones == PULL], [push, pull], normal)
        for part, share in self.disks:
            contact = (cones == CONTACT) & (share > 0.0)
            limit = share[contact] * impulse[contact, 0]
            tangential = -free[contact, part] / weight[contact, None]
            size = np.linalg.norm(tangential, axis=1)
            inside = np.where(size > limit, limit / np.where(size > 0.0, size, 1.0), 1.0)
            impulse[contact, part] = tangential * inside[:, None]
        stiff, d = self.geometric > 0.0, self.dimension
        kappa = self.geometric[stiff]
        impulse[stiff, 1:d] = -(kappa / (1.0 + kappa * weight[stiff]))[:, None] * free[stiff, 1:d]
        return impulse

    def errors(self, impulses: np.ndarray) -> np.ndarray:
        """``e = w (r - react(w I, u - w r))`` of impulses (m, D), w the local weight [m/s], (m, D); zero at a solution."""
        weight = self.local_weight()
        free = self.velocities(impulses) - weight[:, None] * impulses
        return weight[:, None] * (impulses - self.react(free, weight))

    def __repr__(self) -> str:
        names, counts = np.unique(np.array(self.laws, dtype=str), return_counts=True)
        by_law = ", ".join(f"{count} {name}" for name, count in zip(names, counts, strict=True))
        return f"<Problem in {self.dimension}D: {by_law or 'no interaction'}, {self.W.nnz} entries of W>"


def check_problem(problem: Any, call: str) -> None:
    """TypeError if ``problem`` is not a :class:`Problem`."""
    if not isinstance(problem, Problem):
        raise TypeError(
            f"{call} takes a problem, from lmgcpy.io.fclib.read(path) or Simulation.problem(), got {shown(problem)}."
        )
