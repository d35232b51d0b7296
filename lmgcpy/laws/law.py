"""The interface of interaction laws.

At one interaction the time step reduces to ``u = u_free + W r``: ``u`` the relative velocity at the end of the step
[m/s], ``r`` the impulse [N s], ``W`` the local block of the Delassus operator [1/kg], all in the local frame, normal
component first. A law closes this with a relation between ``u`` and ``r``, and *is* its exact solution, ``react``.

The functions of a law are plain Python functions of numbers and tuples of numbers. lmgcpy compiles them, and whatever
they call, into the solver's kernels.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import cache
from typing import Any, ClassVar, TypeVar

import numpy as np

from lmgcpy.errors import closest, named_arguments, number, shown

REQUIRED = object()

ROLLING_ROWS = {2: 3, 3: 6}
"""Number of components of an impulse with rolling ones, by dimension."""

TRAITS = {
    "push": "the normal impulse is never negative",
    "pull": "the normal impulse is never positive",
    "cone": "the tangential impulse is at most friction times the normal one, the rolling one at most rolling friction "
    "times it, and sliding does not dilate",
    "dissipative": "with zero bias, the impulse never gives energy: r . u <= 0",
    "potential": "the impulse derives from the stored energy that `energy` returns",
    "rigid": "no compliance: an interaction that starts beyond its reference would be a blow",
}
"""Traits that a law may declare, and what each promises."""


@named_arguments
class Parameter:
    """A number that a law takes, declared in the class body: ``friction = Parameter("-", minimum=0.0)``.

    ``unit`` is an SI unit, or "-" for none. ``minimum``, ``maximum`` and ``above`` (exclusive) bound the number. Without
    ``default`` it is required; a default of None makes it optional.
    """

    def __init__(
        self,
        unit: str,
        text: str = "",
        *,
        minimum: float = -np.inf,
        maximum: float = np.inf,
        above: float = -np.inf,
        default: Any = REQUIRED,
    ):
        self.unit, self.text, self.default = unit, text, default
        self.bounds = {"minimum": minimum, "maximum": maximum, "above": above}
        self.name = ""

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    def __get__(self, law: Law | None, owner: type) -> Any:
        return self if law is None else law.__dict__["_values"][self.name]

    def __set__(self, law: Law, value: Any) -> None:
        raise AttributeError(f"A law is frozen: make a new {type(law).__name__} instead of setting {self.name}.")

    def check(self, value: Any, law_name: str) -> float | None:
        """``value`` as a float within bounds, or TypeError / ValueError."""
        if value is None and self.default is None:
            return None
        return number(value, f"{self.name} of law '{law_name}'", unit=self.unit, **self.bounds)

    def __repr__(self) -> str:
        return f"<Parameter '{self.name}' [{self.unit}]{f': {self.text}' if self.text else ''}>"


@named_arguments
class State:
    """A number that a law keeps for each interaction, declared in the class body: ``damage = State("-", "1: broken")``."""

    def __init__(self, unit: str, text: str = ""):
        self.unit, self.text = unit, text

    def __repr__(self) -> str:
        return f"<State [{self.unit}]{f': {self.text}' if self.text else ''}>"


Declaration = TypeVar("Declaration", Parameter, State)


class Law(ABC):
    """An interaction law. Subclass it, and register the class with ``lm.laws.register``.

    A dashpot between two bodies, ``r_n = -h c u_n``, reads so. With ``u = u_free + W r`` its exact solution is
    ``r = -u_free / (W + 1/(h c))``::

        >>> import lmgcpy as lm
        >>> class Dashpot(lm.Law):
        ...     NAME = "dashpot"
        ...     APPLIES_TO = "link"
        ...     PREPARED = ("compliance",)
        ...     TRAITS = frozenset({"dissipative"})
        ...
        ...     viscosity = lm.Parameter("N s/m", "force per velocity c", above=0.0)
        ...
        ...     @staticmethod
        ...     def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        ...         (viscosity,) = parameters
        ...         return (1.0 / (time_step * viscosity),)
        ...
        ...     @staticmethod
        ...     def react(W, u, prepared):
        ...         return (-u[0] / (W[0][0] + prepared[0]),)
        >>> law = Dashpot(viscosity=8.0)
        >>> law
        Dashpot(viscosity=8)
        >>> compliance = law.prepare(0.0, 0.0, (1.0,), 0.125, (law.viscosity,), ())
        >>> law.react(((1.0,),), (1.0,), compliance)  # half the velocity is left
        (-0.5,)

    Class attributes:

    * ``NAME``: the name of the law in files and tables;
    * ``APPLIES_TO``: "contact" or "link";
    * ``PREPARED``: names of the numbers that ``prepare`` returns;
    * ``TRAITS``: what the law promises, out of :data:`~lmgcpy.laws.law.TRAITS`;
    * ``PAIRS``: pairs of contactor kinds that a contact law serves, as ``{("disk", "wall")}``; None for all;
    * ``DIMENSIONS``: dimensions of the scenes that the law is for, by default 2 and 3;
    * ``TIES``: whether a link law ties two points (``Scene.link``): it acts along each axis of space, and its gap is the
      component of the vector from the antagonist's point to the candidate's, with its sign;
    * ``KEEPS_GAP``: whether the ``reference_gap`` of a contact is the gap that the law predicted in the step before,
      ``gap + time_step * velocity[0]``, if that is below zero, and 0 if not (of a new contact: its own gap, if below zero).
      If the gap is smaller, turning has closed the difference (``laws/signorini.py``). False: 0;
    * ``TAKES_BACK_LATER``: whether the rest of this difference that a step leaves is added to the gap that the law
      predicted, so that the next step may take it back;
    * :class:`Parameter` attributes, in the order in which ``prepare`` receives their values;
    * :class:`State` attributes, in the same order: numbers that the law keeps for each interaction (damage, plastic
      length, wear).

    The state of an interaction starts with ``initial`` (without it, with zeros) in the first step of the interaction. A
    link exists from the start. A contact exists from the step in which its bodies come within the alert distance to the
    step in which they leave it; then its state is lost. ``commit`` makes the new state once a step, after the solver;
    without ``commit`` the state stays.

    Each of ``prepare``, ``initial``, ``commit``, ``energy`` and ``dissipation`` may take one argument more, the last, named
    ``pair``: a :class:`~lmgcpy.laws.Pair` with radii, masses and the time.

    An instance is frozen and comparable: two laws with equal parameters are equal.
    """

    NAME: ClassVar[str]
    APPLIES_TO: ClassVar[str]
    PREPARED: ClassVar[tuple[str, ...]]
    TRAITS: ClassVar[frozenset[str]] = frozenset()
    PAIRS: ClassVar[frozenset[tuple[str, str]] | None] = None
    DIMENSIONS: ClassVar[tuple[int, ...]] = (2, 3)
    TIES: ClassVar[bool] = False
    KEEPS_GAP: ClassVar[bool] = False
    TAKES_BACK_LATER: ClassVar[bool] = False

    initial: ClassVar[Callable | None] = None
    """``initial(gap, reference_gap, time, parameters)``: state of an interaction that is new at ``time`` [s], a tuple with
    one number for each :class:`State`. The simulation starts at time 0. None: zeros."""
    commit: ClassVar[Callable | None] = None
    """``commit(gap, reference_gap, velocity, impulse, time_step, parameters, state)``: the state after the step.

    ``gap`` [m] is the gap at the detection configuration, the same as in ``prepare``. ``velocity`` [m/s] is the relative
    velocity at the end of the step: the predicted gap is ``gap + time_step * velocity[0]``. ``impulse`` [N s] is
    ``time_step`` times the force."""
    slope: ClassVar[Callable | None] = None
    """``slope(W, u, prepared)``: generalized derivative of ``react`` by ``u``, a tuple of rows. A law without slope leaves
    it None."""
    energy: ClassVar[Callable | None] = None
    """``energy(gap, reference_gap, parameters, state)``: energy stored in one interaction [J]. A law that stores none
    leaves it None."""

    dissipation: ClassVar[Callable | None] = None
    """``dissipation(gap, reference_gap, velocity, impulse, time_step, parameters, state)``: energy that one interaction has
    dissipated in the step [J]. A law that does not report it leaves it None. ``velocity`` [m/s] is the mean of the
    velocities at the start and at the end of the step, so that ``impulse . velocity`` is the work of the impulse; ``state``
    is the state before the step."""

    conic: ClassVar[Callable | None] = None
    """``conic(prepared)``: bias [m/s], friction and compliance [1/kg] of the law in conic form (see
    ``lmgcpy.solve.problems.problem``), from columns of prepared numbers; for a law with rolling components also rolling
    friction and torsion friction (in 2D any number for the latter). Solvers that assemble W need it. A law without conic
    form leaves it None."""
    resisted: ClassVar[Callable | None] = None
    """``resisted(prepared, a, w)``: for a law whose friction is Coulomb's on ``u_t + slip``, with a slip and a coefficient
    that depend on the impulses: the coefficients (k,) and slips [m/s] (d - 1, k) at ``a = r - u/w`` (d, k), from columns of
    prepared numbers and weights w (k,). Newton steps take them for a start of ``conic``. Other laws leave it None."""

    @staticmethod
    @abstractmethod
    def prepare(
        gap: float,
        reference_gap: float,
        velocity: tuple[float, ...],
        time_step: float,
        parameters: tuple[float, ...],
        state: tuple[float, ...],
    ) -> tuple[float, ...]:
        """The few numbers that ``react`` needs, a tuple as long as ``PREPARED``; called once a step and interaction.

        ``gap`` [m] is the gap at the detection configuration, ``reference_gap`` [m] the reference gap of a link (for
        contacts see ``KEEPS_GAP``), ``velocity`` [m/s] the relative velocity at the start of the step, a tuple, normal
        component first, ``time_step`` [s] the step. ``parameters`` and ``state`` are tuples; ``state`` is empty for a law
        without state."""

    @staticmethod
    @abstractmethod
    def react(W: tuple[tuple[float, ...], ...], u: tuple[float, ...], prepared: tuple[float, ...]) -> tuple[float, ...]:
        """The impulse (a tuple, [N s]) that satisfies the law exactly with the velocity ``u + W impulse``.

        ``W``: a tuple of rows [1/kg], symmetric positive definite; ``u``: free velocity [m/s], a tuple.
        """

    def __init__(self, *unnamed: Any, **values: Any):
        known = self.parameters()
        if unnamed:
            given = f"{next(iter(known), 'nothing')}=..." if known else ""
            raise TypeError(
                f"Law '{self.NAME}' takes its parameters by name, as in {type(self).__name__}({given}), got "
                f"{shown(unnamed[0])}."
            )
        for name in values:
            if name not in known:
                raise TypeError(f"Law '{self.NAME}' has no parameter '{name}'{closest(name, known)}")
        checked = {}
        for name, parameter in known.items():
            value = values.get(name, parameter.default)
            if value is REQUIRED:
                raise TypeError(f"Law '{self.NAME}' needs {name} [{parameter.unit}]: {type(self).__name__}({name}=...).")
            checked[name] = parameter.check(value, self.NAME)
        self.__dict__["_values"] = checked
        self.validate()

    def validate(self) -> None:
        """Check parameters against each other; raise ValueError with a sentence. A law may override it."""
        return None

    @classmethod
    def parameters(cls) -> dict[str, Parameter]:
        """The declared parameters by name, in order of declaration."""
        return dict(_declared(cls, Parameter))

    @classmethod
    def states(cls) -> dict[str, State]:
        """The declared numbers of the internal state by name, in order of declaration."""
        return dict(_declared(cls, State))

    @property
    def values(self) -> dict[str, float | None]:
        """Parameters by name."""
        return dict(self.__dict__["_values"])

    def with_values(self, **values: Any) -> Law:
        """A copy of the law with other values of some parameters; raises the errors of a law that is made with them."""
        given = {name: value for name, value in {**self.values, **values}.items() if value is not None}
        return type(self)(**given)

    def rows(self, dimension: int) -> int:
        """Number of components of the impulse that the law may make non-zero: 1 (normal), ``dimension``, or with rolling
        ones 3 in 2D and 6 in 3D (see :class:`~lmgcpy.RollingCoulomb`)."""
        return 1

    def acts_within(self, radius: float, other: float) -> float:
        """Greatest gap [m] at which a contact law acts between surfaces of two radii [m], infinite for walls.

        Its contacts are seen at least up to there. By default it is the parameter ``reach``, if the law has one, else 0: it
        acts on contact. A law of capillary bridges overrides it, as with ``return self.volume ** (1 / 3)``. It is asked
        for the smallest and the largest radii of a scene, and should be greatest for one of them.
        """
        return self.values.get("reach") or 0.0

    def table(self, reference_length: np.ndarray) -> np.ndarray:
        """Parameters as ``prepare`` receives them, one row an interaction, shape (count, k).

        ``reference_length``: distance between centres at which a link is at its reference [m], shape (count,).
        """
        return np.tile(np.array(list(self.values.values()), dtype=float), (len(reference_length), 1))

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"A law is frozen: make a new {type(self).__name__} instead of setting {name}.")

    def __repr__(self) -> str:
        given = ", ".join(f"{name}={value:g}" for name, value in self.values.items() if value is not None)
        return f"{type(self).__name__}({given})"

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and other.values == self.values  # type: ignore[attr-defined]

    def __hash__(self) -> int:
        return hash((type(self), tuple(self.values.items())))


@cache
def _declared(law: type[Law], kind: type[Declaration]) -> dict[str, Declaration]:
    """Declarations of one kind by name, in order; kept, as every step asks."""
    found: dict[str, Declaration] = {}
    for base in reversed(law.__mro__):
        found.update({name: value for name, value in vars(base).items() if isinstance(value, kind)})
    return found
