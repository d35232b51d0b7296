"""Settings of the whole suite.

Two suites. The default one answers in minutes; ``-m long`` runs what it leaves out:

* tests and parameters with the marker ``long``;
* of a test with ``@pytest.mark.default_parameters(...)``, ids or values by name, all other parameters;
* tests with the marker ``scaled``, in their full size (:func:`suites.size`);
* tests of hypothesis, with all their examples.

``-m long --one-in N`` runs one in N of the long parameters of each test, chosen by the hash of their names, and at least
one: what repeats at every change has no time for all of them.

Workers of pytest-xdist compile the kernels that many tests need together, before they import the tests.
Steps wait for their kernels to be compiled, also in processes that tests start.
Hypothesis draws the same examples at every run and keeps no data base. Ctrl-C is heard.
"""

import os
import signal
from pathlib import Path

os.environ["LMGCPY_COMPILE_FIRST"] = "1"  # before lmgcpy is imported

import pytest
import suites
from hypothesis import is_hypothesis_test, settings

always = {"derandomize": True, "deadline": None, "database": None}
settings.register_profile("default suite", max_examples=5, **always)
settings.register_profile("long suite", max_examples=60, **always)

# A shell starts what it puts in the background deaf to Ctrl-C, and child processes are born as deaf: tests press it.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--one-in", type=int, default=1, metavar="N", help="with -m long: one in N parameters of each test")


def pytest_configure(config: pytest.Config) -> None:
    """Choose the sizes before any module of tests is imported."""
    suites.LONG = "not long" not in config.option.markexpr
    settings.load_profile("long suite" if suites.LONG else "default suite")


@pytest.hookimpl(tryfirst=True)  # before pytest chooses by -m
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Mark as long what the default suite leaves out, and in the long suite what it runs in full size."""
    some: dict[tuple[str, str], bool] = {}
    for item in items:
        default = item.get_closest_marker("default_parameters")
        if default is not None:
            test = item.path.name, item.originalname
            chosen = is_default(item.callspec, default)
            some[test] = some.get(test, False) or chosen
            if not chosen:
                item.add_marker(pytest.mark.long)
        in_both = item.get_closest_marker("scaled") or is_hypothesis_test(getattr(item, "obj", None))
        if in_both and suites.LONG:
            item.add_marker(pytest.mark.long)
    suites.leave_out_all_but_one_in(config, items)
    if not any("::" in argument for argument in config.args) and not all(some.values()):
        none = [test for test, chosen in some.items() if not chosen]
        raise pytest.UsageError(f"default_parameters leaves the default suite without any parameters of {none}.")


def is_default(callspec, mark: pytest.Mark) -> bool:
    """Whether parameters are among the ids, or the values by name, that a mark gives."""
    if mark.args:
        return callspec.id in mark.args
    return all(callspec.params[name] in values for name, values in mark.kwargs.items())


@pytest.fixture(autouse=True, scope="session")
def no_line_of_the_compiler():
    """A program writes one line on standard error as it waits for the compiler: not into what a test reads."""
    from lmgcpy.compiled import waiting

    waiting._so_far.is_said = True


@pytest.hookimpl(tryfirst=True)
def pytest_collection(session: pytest.Session) -> None:
    """Compile the common kernels before modules are imported, some of which make their scenes then."""
    run, config = getattr(session.config, "workerinput", {}).get("testrunuid"), session.config
    if run is not None and [Path(argument).resolve() for argument in config.args] == [Path(__file__).parent]:
        from common_kernels import compile_together

        compile_together(Path(config.option.basetemp).parent / f"kernels-{run}")
