"""The registry of laws: one pluggy hook serves built-in laws, installed plug-ins and a user's script alike.

A plug-in distribution names a module under the entry-point group ``lmgcpy``; that module implements
``lmgcpy_laws(register)`` and calls ``register(MyLaw)`` for each of its laws.
"""

from __future__ import annotations

import importlib.metadata
import inspect
import re
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import pluggy

from lmgcpy.errors import closest, shown, told
from lmgcpy.laws.law import TRAITS, Law
from lmgcpy.laws.pair import TAKE_PAIR, takes_pair

GROUP = "lmgcpy"
hook_specification = pluggy.HookspecMarker(GROUP)
hook = pluggy.HookimplMarker(GROUP)
"""Decorator of a plug-in's hook: ``@lmgcpy.laws.hook``."""

ARGUMENTS = {
    "prepare": ("gap", "reference_gap", "velocity", "time_step", "parameters", "state"),
    "react": ("W", "u", "prepared"),
    "slope": ("W", "u", "prepared"),
    "conic": ("prepared",),
    "resisted": ("prepared", "a", "w"),
    "energy": ("gap", "reference_gap", "parameters", "state"),
    "initial": ("gap", "reference_gap", "time", "parameters"),
    "commit": ("gap", "reference_gap", "velocity", "impulse", "time_step", "parameters", "state"),
    "dissipation": ("gap", "reference_gap", "velocity", "impulse", "time_step", "parameters", "state"),
}
"""Exact argument lists of a law's functions, without ``pair``."""


class Specification:
    """The hooks that a plug-in may implement."""

    @hook_specification
    def lmgcpy_laws(self, register: Callable[[type[Law]], type[Law]]) -> None:
        """Call ``register`` with each law class of the plug-in."""


@dataclass(frozen=True)
class Registration:
    """A registered law, and the ``distribution`` that it comes from."""

    law: type[Law]
    distribution: str


class Registry:
    """The laws by name. It keeps the failures of plug-ins and names them when a law is not found."""

    def __init__(self) -> None:
        self._laws: dict[str, Registration] = {}
        self._failures: dict[str, BaseException] = {}
        self._manager = pluggy.PluginManager(GROUP)
        self._manager.add_hookspecs(Specification)
        self._tried: set[str] = set()
        self._loaded = False

    def register(self, law: type[Law], *, distribution: str = "script") -> type[Law]:
        """Add a law class; returns it, so that it serves as a decorator.

        Raises TypeError for a class that does not fit the interface of :class:`~lmgcpy.Law`, and ValueError for a name that
        another distribution has taken. A script may register a class of the same name again: the new one replaces the old.
        """
        check_interface(law)
        taken = self._laws.get(law.NAME)
        if taken is not None and taken.law is law:
            return law
        if taken is not None and not taken.distribution == distribution == "script":
            raise ValueError(
                f"Law '{law.NAME}' is there twice: from {taken.distribution} ({taken.law.__qualname__}) and from "
                f"{distribution} ({law.__qualname__}). Give one another NAME or uninstall one of the distributions."
            )
        self._laws[law.NAME] = Registration(law, distribution)
        return law

    def add_plugin(self, plugin: Any, distribution: str) -> None:
        """Call the hook of one plug-in (a module or object); its laws are registered for ``distribution``."""
        self._manager.register(plugin, name=f"{distribution} {id(plugin)}")  # a distribution may bring several
        for implementation in self._manager.hook.lmgcpy_laws.get_hookimpls():
            if implementation.plugin is plugin:
                implementation.function(lambda law: self.register(law, distribution=distribution))

    def load_plugins(self) -> None:
        """Load the installed plug-ins, once and one by one; a failure is remembered, not raised, whatever it is: sys.exit
        in one must not end the program. Ctrl-C does, and the rest is loaded when it is needed again."""
        if self._loaded:
            return
        for entry in importlib.metadata.entry_points(group=GROUP):
            distribution = f"{entry.dist.name} {entry.dist.version}" if entry.dist else entry.value
            plugin = f"{distribution} ({entry.name})"
            if plugin in self._tried:
                continue
            with _noted_interrupts() as interrupts:
                try:
                    self.add_plugin(entry.load(), distribution)
                except BaseException as error:
                    if interrupts:
                        raise
                    self._failures[plugin] = error
            self._tried.add(plugin)
        self._loaded = True

    def names(self) -> list[str]:
        """Names of all registered laws, sorted."""
        self.load_plugins()
        return sorted(self._laws)

    def get(self, name: str) -> type[Law]:
        """The law class of that name; LookupError names the closest match and the plug-ins that failed to load."""
        if not isinstance(name, str):
            raise TypeError(f"The name of a law is a word such as 'coulomb', got {shown(name)}.")
        self.load_plugins()
        if name in self._laws:
            return self._laws[name].law
        broken = "".join(f" Plug-in {plugin} failed to load: {told(error)}." for plugin, error in self._failures.items())
        cause = next(iter(self._failures.values()), None)
        raise LookupError(f"There is no law '{name}'{closest(name, self._laws)}{broken}") from cause

    def registrations(self) -> dict[str, Registration]:
        """All registrations by name."""
        return {name: self._laws[name] for name in self.names()}

    def failures(self) -> dict[str, BaseException]:
        """Plug-ins that failed to load, with the reason."""
        self.load_plugins()
        return dict(self._failures)

    def __repr__(self) -> str:
        return f"<Registry of {len(self._laws)} laws, {len(self._failures)} plug-ins that failed to load>"


def check_interface(law: Any) -> None:
    """Raise TypeError with a sentence unless ``law`` is a complete :class:`Law` class."""
    if not (isinstance(law, type) and issubclass(law, Law)):
        raise TypeError(f"A law is a subclass of lmgcpy.Law, got {shown(law)}.")
    where = f"Law class {law.__qualname__}"
    for name, kind in (
        ("NAME", str),
        ("APPLIES_TO", str),
        ("PREPARED", tuple),
        ("TRAITS", frozenset),
        ("DIMENSIONS", tuple),
    ):
        if not isinstance(getattr(law, name, None), kind):
            raise TypeError(f"{where} needs a class attribute {name} of type {kind.__name__}.")
    if not re.fullmatch(r"\w[\w.+-]*", law.NAME):
        raise TypeError(f"{where}: NAME must be a word such as 'elastic-rod', got {shown(law.NAME)}.")
    if law.APPLIES_TO not in ("contact", "link"):
        raise TypeError(f"{where}: APPLIES_TO must be 'contact' or 'link', got {law.APPLIES_TO!r}.")
    for trait in law.TRAITS:
        if trait not in TRAITS:
            raise TypeError(f"{where} declares an unknown trait '{trait}'{closest(trait, TRAITS)}")
    for name in ("initial", "commit"):
        if getattr(law, name) is not None and not law.states():
            raise TypeError(f"{where} has {name} but no state: declare its numbers, as damage = lmgcpy.State('-').")
    if not law.DIMENSIONS or not set(law.DIMENSIONS) <= {2, 3}:
        raise TypeError(f"{where}: DIMENSIONS holds 2, 3 or both, as (2,), got {law.DIMENSIONS!r}.")
    for pair in law.PAIRS or ():
        if not (isinstance(pair, tuple) and len(pair) == 2 and all(isinstance(kind, str) for kind in pair)):
            raise TypeError(f'{where}: PAIRS holds pairs of kinds of contactors, as ("disk", "wall"), got {pair!r}.')
    if law.__abstractmethods__:
        raise TypeError(f"{where} lacks {', '.join(sorted(law.__abstractmethods__))}.")
    for name, expected in ARGUMENTS.items():
        function = getattr(law, name)
        if function is None:
            continue
        if not isinstance(inspect.getattr_static(law, name), staticmethod):
            raise TypeError(f"{where}: {name} must be a static method: it is compiled and has no self.")
        got = tuple(inspect.signature(function).parameters)
        wanted = (*expected, "pair") if name in TAKE_PAIR and takes_pair(function) else expected
        if got != wanted:
            more = ", with or without pair" if name in TAKE_PAIR and wanted == expected else ""
            raise TypeError(f"{where}: {name} must take ({', '.join(wanted)}){more}, but it takes ({', '.join(got)}).")


@contextmanager
def _noted_interrupts() -> Iterator[list[int]]:
    """Yield a list that gets an item when Ctrl-C is pressed; Ctrl-C raises KeyboardInterrupt as always. If the list is
    empty after a KeyboardInterrupt, the plug-in has raised it by itself."""
    pressed: list[int] = []

    def note(number: int, frame: Any) -> None:
        pressed.append(number)
        raise KeyboardInterrupt

    usual = (
        threading.current_thread() is threading.main_thread()
        and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    )
    try:
        if usual:
            signal.signal(signal.SIGINT, note)
        yield pressed
    finally:
        if usual:
            signal.signal(signal.SIGINT, signal.default_int_handler)


registry = Registry()
