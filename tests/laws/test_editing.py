"""A user's law that is edited between two runs: what runs is what the files say, and nothing else is compiled."""

import json

import pytest
from forks import forked
from soft_law import soft_law

LAW = soft_law(
    "1.0 * SHARE * my_numbers.MORE * closing",
    before="import my_numbers\nfrom my_helper import closing\nfrom my_numbers import SHARE\n",
)
HELPER = """
def closing(u):
    return max(0.0, -u)
"""
NUMBERS = """
SHARE = 1.0
MORE = 1.0
"""
RUN = """
import json
from lmgcpy.compiled.kernel import statistics
from my_law import falling
velocity = falling().run(steps=1).velocities[0, 1]
compiled = [name.split("-")[0].split(" ")[0] for name in statistics().compiled]
print(json.dumps([float(velocity), sorted(compiled)]))
"""


@pytest.fixture
def run(tmp_path):
    for name, text in (("my_law", LAW), ("my_helper", HELPER), ("my_numbers", NUMBERS)):
        (tmp_path / f"{name}.py").write_text(text)
    return lambda: json.loads(forked(RUN, folder=tmp_path, LMGCPY_CACHE_DIR=tmp_path / "cache").stdout)


def edit(path, old, new):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


@pytest.mark.long
def test_every_edit_is_seen_and_nothing_else_is_compiled_again(run, tmp_path):
    """A ball comes at 1 m/s; one update of the law takes the share of its momentum that the files say."""
    velocity, compiled = run()
    assert velocity == 0.0
    # of the one law that the scene has: its update, its error, its preparation; and what all scenes need once
    assert compiled.count("sweep") == compiled.count("error") == compiled.count("prepare_group") == 1
    assert run() == [0.0, []]
    for name, old, new, expected in (
        ("my_law", "1.0 * SHARE", "0.5 * SHARE", -0.5),
        ("my_helper", "max(0.0, -u)", "max(0.0, -0.5 * u)", -0.75),
        ("my_numbers", "SHARE = 1.0", "SHARE = 0.5", -0.875),
        ("my_numbers", "MORE = 1.0", "MORE = 0.5", -0.9375),
    ):
        edit(tmp_path / f"{name}.py", old, new)
        velocity, compiled = run()
        assert velocity == expected, name
        assert sorted(set(compiled)) == ["error", "sweep"], name
        assert run() == [expected, []]
