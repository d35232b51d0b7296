"""The registry: one hook for all, names, duplicates, failures that are remembered, sentences about the interface."""

from __future__ import annotations

import importlib.metadata
import signal
import types
from types import SimpleNamespace

import pytest
from click.testing import CliRunner

import lmgcpy as lm
from lmgcpy.cli import main
from lmgcpy.laws.registry import Registry, check_interface


def law(name="test-law", **attributes):
    """A complete law class of that name, with attributes replaced; None removes one."""
    scope = {
        "NAME": name,
        "APPLIES_TO": "contact",
        "PREPARED": ("bias",),
        "prepare": staticmethod(lambda gap, reference_gap, velocity, time_step, parameters, state: (0.0,)),
        "react": staticmethod(lambda W, u, prepared: (0.0,)),
        **attributes,
    }
    return type("TestLaw", (lm.Law,), {key: value for key, value in scope.items() if value is not None})


def plugin(*laws):
    """A module whose hook registers these."""
    module = types.ModuleType("test_plugin")

    def lmgcpy_laws(register):
        for item in laws:
            register(item)

    module.lmgcpy_laws = lm.laws.hook(lmgcpy_laws)
    return module


def entry_point(name, loaded, distribution="lmgcpy-law-test", version="1.2"):
    """What ``importlib.metadata`` gives for an installed plug-in; ``loaded``: module or exception."""

    def load():
        if isinstance(loaded, BaseException):
            raise loaded
        return loaded

    dist = SimpleNamespace(name=distribution, version=version)
    return SimpleNamespace(name=name, value="test_plugin", dist=dist, load=load)


@pytest.fixture
def install(monkeypatch):
    """Pretend that these entry points are what is installed; returns a new registry."""

    def with_entry_points(*entries):
        def entry_points(*, group):
            assert group == "lmgcpy"
            return list(entries)

        monkeypatch.setattr(importlib.metadata, "entry_points", entry_points)
        return Registry()

    return with_entry_points


def test_the_built_in_laws_come_through_the_hook():
    registrations = lm.laws.registrations()
    names = ["coulomb", "elastic-rod", "elastic-wire", "restitution", "rigid-rod", "rigid-wire", "signorini"]
    for name in [*names, "voigt-rod", "voigt-wire"]:
        assert registrations[name].distribution == "lmgcpy"
        assert name == registrations[name].law.NAME
        assert lm.laws.get(name) is registrations[name].law
    assert lm.laws.names() == sorted(lm.laws.names())
    assert set(lm.laws.names()) >= set(names)


def test_an_unknown_name_gets_the_closest_match():
    with pytest.raises(LookupError, match=r"There is no law 'coulom'; did you mean 'coulomb'\? Known: ball-joint"):
        lm.laws.get("coulom")


def test_a_plugin_is_found_by_its_entry_point(install):
    mine = law()
    registry = install(entry_point("mine", plugin(mine)))
    assert registry.names() == ["test-law"]
    assert registry.get("test-law") is mine
    assert registry.registrations()["test-law"].distribution == "lmgcpy-law-test 1.2"
    assert registry.failures() == {}


def test_plugins_are_loaded_once(install):
    count = []

    def load():
        count.append(1)
        return plugin(law())

    entry = entry_point("mine", None)
    entry.load = load
    registry = install(entry)
    registry.names()
    registry.names()
    assert len(count) == 1


def test_one_distribution_may_have_several_plugins(install):
    registry = install(entry_point("one", plugin(law("a"))), entry_point("two", plugin(law("b"))))
    assert registry.failures() == {}
    assert registry.names() == ["a", "b"]


def test_a_failing_plugin_is_remembered_and_told_when_its_law_is_asked_for(install):
    cause = ImportError("no module named missing")
    registry = install(entry_point("broken", cause, "lmgcpy-law-broken", "0.3"), entry_point("fine", plugin(law())))
    assert registry.names() == ["test-law"]
    assert registry.failures() == {"lmgcpy-law-broken 0.3 (broken)": cause}
    with pytest.raises(LookupError, match=r"Plug-in lmgcpy-law-broken 0.3 \(broken\) failed to load: ImportError") as error:
        registry.get("glue")
    assert error.value.__cause__ is cause


class Unspeakable(Exception):
    """An exception that cannot be shown."""

    def __str__(self):
        raise SystemExit

    __repr__ = __str__


ENDS = [SystemExit(0), SystemExit("no licence"), KeyboardInterrupt(), GeneratorExit(), Unspeakable(), BaseException("all")]


@pytest.mark.parametrize("end", ENDS, ids=[type(end).__name__ + str(i) for i, end in enumerate(ENDS)])
@pytest.mark.parametrize("where", ["import", "hook"])
def test_a_plugin_that_would_end_the_program_is_named_and_left_out(install, end, where, monkeypatch):
    """``sys.exit(0)`` in one ended a recorded simulation with return code 0 before it began."""

    def lmgcpy_laws(register):
        raise end

    module = types.ModuleType("test_plugin")
    module.lmgcpy_laws = lm.laws.hook(lmgcpy_laws)
    broken = entry_point("broken", end if where == "import" else module, "lmgcpy-law-broken", "0.3")
    registry = install(broken, entry_point("fine", plugin(law())))
    assert registry.names() == ["test-law"]
    assert list(registry.failures().values()) == [end]
    with pytest.raises(LookupError, match=rf"lmgcpy-law-broken 0.3 \(broken\) failed to load: <?{type(end).__name__}"):
        registry.get("glue")
    monkeypatch.setattr("lmgcpy.cli.laws.registered", registry)
    listed = CliRunner().invoke(main, ["laws"])
    assert listed.exit_code == 0, listed.output
    assert f"Plug-in lmgcpy-law-broken 0.3 (broken) failed to load: {type(end).__name__}" in listed.output


@pytest.mark.skipif(not hasattr(signal, "raise_signal"), reason="no signals")
def test_ctrl_c_while_a_plugin_is_loaded_ends_the_program_and_not_the_plugin(install):
    """And it is loaded when it is needed again; those before it are not loaded twice."""
    pressed = []

    def load():
        if not pressed:
            pressed.append(True)
            signal.raise_signal(signal.SIGINT)
        return plugin(law("slow"))

    slow = entry_point("slow", None)
    slow.load = load
    registry = install(entry_point("fine", plugin(law())), slow)
    with pytest.raises(KeyboardInterrupt):
        registry.names()
    assert registry.names() == ["slow", "test-law"]
    assert registry.failures() == {}
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_plugin_that_registers_nonsense_fails_alone(install):
    registry = install(entry_point("odd", plugin(int)), entry_point("fine", plugin(law()), "other"))
    assert registry.names() == ["test-law"]
    (failure,) = registry.failures().values()
    assert isinstance(failure, TypeError)


def test_a_hook_with_a_wrong_argument_is_a_failure(install):
    module = types.ModuleType("test_plugin")
    module.lmgcpy_laws = lm.laws.hook(lambda laws: None)
    registry = install(entry_point("odd", module))
    assert registry.names() == []
    assert len(registry.failures()) == 1


def test_the_same_name_twice_is_refused_naming_both(install):
    registry = install(
        entry_point("one", plugin(law()), "lmgcpy-law-first", "1.0"),
        entry_point("two", plugin(law()), "lmgcpy-law-second", "2.0"),
    )
    (failure,) = registry.failures().values()
    assert isinstance(failure, ValueError)
    assert "lmgcpy-law-first 1.0" in str(failure)
    assert "lmgcpy-law-second 2.0" in str(failure)
    assert registry.registrations()["test-law"].distribution == "lmgcpy-law-first 1.0"


def test_a_script_cannot_take_a_built_in_name():
    with pytest.raises(ValueError, match=r"Law 'coulomb' is there twice: from lmgcpy \(Coulomb\) and from script"):
        lm.laws.register(law("coulomb"))


def test_a_script_may_register_a_law_and_define_it_again():
    registry = Registry()
    first, second = law(), law()
    assert registry.register(first) is first
    registry.register(first)
    registry.register(second)
    assert registry.get("test-law") is second


NO_WORDS = ["", " ", "two words", "a/b", "line\nbreak", "\udc80", "-x", "a\0", "'"]
INCOMPLETE = [
    (lambda: int, "A law is a subclass of lmgcpy.Law, got <class 'int'>"),
    (lambda: lm.Coulomb(friction=0.3), "A law is a subclass of lmgcpy.Law, got Coulomb"),
    (lambda: law(NAME=None), "needs a class attribute NAME of type str"),
    (lambda: law(NAME=3), "needs a class attribute NAME of type str"),
    *((lambda name=name: law(name), "NAME must be a word such as") for name in NO_WORDS),
    (lambda: law(APPLIES_TO=None), "needs a class attribute APPLIES_TO of type str"),
    (lambda: law(APPLIES_TO="grain"), "APPLIES_TO must be 'contact' or 'link', got 'grain'"),
    (lambda: law(PREPARED=["bias"]), "needs a class attribute PREPARED of type tuple"),
    (lambda: law(TRAITS={"push"}), "needs a class attribute TRAITS of type frozenset"),
    (lambda: law(TRAITS=frozenset({"pusch"})), "unknown trait 'pusch'; did you mean 'push'"),
    (lambda: law(react=None), "lacks react"),
    (lambda: law(react=None, prepare=None), "lacks prepare, react"),
    (lambda: law(react=lambda W, u, prepared: (0.0,)), "react must be a static method"),
    (lambda: law(slope=lambda W, u, prepared: ((0.0,),)), "slope must be a static method"),
    (
        lambda: law(react=staticmethod(lambda W, q, prepared: (0.0,))),
        r"react must take \(W, u, prepared\), but it takes \(W, q, prepared\)",
    ),
    (lambda: law(energy=staticmethod(lambda gap: 0.0)), r"energy must take \(gap, reference_gap, parameters, state\)"),
]


@pytest.mark.parametrize(("make", "sentence"), INCOMPLETE, ids=[str(i) for i in range(len(INCOMPLETE))])
def test_an_incomplete_law_is_refused_with_a_sentence(make, sentence):
    candidate = make()
    with pytest.raises(TypeError, match=sentence):
        check_interface(candidate)
    with pytest.raises(TypeError, match=sentence):
        Registry().register(candidate)
