"""Settings of the whole suite: hypothesis draws the same examples at every run and keeps no data base; Ctrl-C is heard;
long forms are left out, and counted as deselected, unless -m asks for them."""

import signal

import pytest
from hypothesis import settings

settings.register_profile("deterministic", derandomize=True, deadline=None, database=None, max_examples=60)
settings.load_profile("deterministic")

# A shell starts what it puts in the background deaf to Ctrl-C, and child processes are born as deaf: tests press it.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if "long" in config.option.markexpr:
        return
    long = [item for item in items if item.get_closest_marker("long")]
    if long:
        config.hook.pytest_deselected(items=long)
        items[:] = [item for item in items if item not in long]
