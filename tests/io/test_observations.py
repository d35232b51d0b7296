"""Observations: what functions say of the simulation after every step is in the run file, bit for bit, and goes on."""

import csv

import h5py
import numpy as np
import pytest
from click.testing import CliRunner

import lmgcpy as lm
from lmgcpy.cli import main
from lmgcpy.io.recorder import RunRecorder


def heap(friction=0.4, lift=None, **options):
    """Four grains fall on a floor, which may be lifted."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    for i in range(4):
        scene.add(lm.disk(radius=0.05, position=(0.101 * i, 0.052 + 0.002 * i), mass=1.0))
    floor = scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    if lift:
        floor.impose_velocity(y=lift)
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=friction))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=friction))
    return lm.Simulation(scene, time_step=2e-3, **options)


def support(sim):
    """Force on the floor [N]."""
    net = sim.interactions
    return net.force[net.antagonist == 4, 0].sum()


OBSERVE = {
    "support": support,
    "places": lambda sim: sim.positions[:2],
    "contacts": lambda sim: len(sim.interactions),
    "touching": lambda sim: bool(support(sim) > 0.0),
    "late": lambda sim: 1.0 / sim.time if sim.steps > 10 else np.nan,
}


def run_cli(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


@pytest.fixture
def path(tmp_path):
    return tmp_path / "run.h5"


def test_they_are_what_the_functions_say_after_every_step(path):
    """Against the functions called on an unrecorded run; types are kept, NaN as well, and live views are copied."""
    heap().run(steps=30, record=path, observe=OBSERVE)
    sim = heap()
    with lm.io.open_run(path) as run:
        assert list(run.observed) == list(OBSERVE)
        assert run.observed["places"].shape == (30, 2, 2)
        for name, kind in (("support", "f8"), ("contacts", "i8"), ("touching", "?")):
            assert run.observed[name].dtype == np.dtype(kind)
        for k in range(30):
            sim.step()
            for name, function in OBSERVE.items():
                np.testing.assert_array_equal(run.observed[name][k], function(sim))
        assert run.observed["touching"][-1]
        assert np.isnan(run.observed["late"][:10]).all()


def test_a_run_that_goes_on_asks_for_them_and_gives_the_same_bits(path):
    whole = path.with_name("whole.h5")
    heap().run(steps=30, record=whole, observe=OBSERVE)
    heap().run(steps=13, record=path, observe=OBSERVE)
    with pytest.raises(ValueError, match=r"observes support, places, contacts, touching, late by functions"):
        lm.resume(path)
    some = {name: OBSERVE[name] for name in ("places", "support", "touching", "late")}
    with pytest.raises(ValueError, match=r"observes contacts by functions.*resume\(path, observe=\{\"support\": f, "):
        lm.resume(path, observe=some)
    with pytest.raises(ValueError, match=r"observe names weight, which .* does not observe"):
        lm.resume(path, observe={**OBSERVE, "weight": support})
    shuffled = dict(reversed(OBSERVE.items()))
    lm.resume(path, observe=shuffled).run(steps=17)
    with lm.io.open_run(path) as a, lm.io.open_run(whole) as b:
        assert lm.io.compare(a, b) is None
        for name in OBSERVE:
            np.testing.assert_array_equal(a.observed[name][:], b.observed[name][:])
    told = run_cli("resume", path, "--steps", 1)
    assert told.exit_code != 0
    assert "from Python: lmgcpy.resume" in told.output


def test_a_run_that_observes_nothing_is_as_before(path):
    heap().run(steps=3, record=path)
    with lm.io.open_run(path) as run:
        assert run.observed == {}
        with pytest.raises(LookupError, match=r"Nothing was observed under the name 'places'. Known: none\."):
            run.observed["places"]
    with pytest.raises(ValueError, match="It observes nothing"):
        lm.resume(path, observe={"support": support})
    assert lm.resume(path).run(steps=1).steps == 4


@pytest.mark.parametrize(
    ("observe", "error", "sentence"),
    [
        ({"late": lambda sim: 1.0 / sim.time}, ValueError, r"observe\['late'\] fails before the first step.*ZeroDivision"),
        ({"name": lambda sim: "high"}, TypeError, r"must return a number, or an array .* it returned 'high'"),
        ({"none": lambda sim: None}, TypeError, "must return a number"),
        ({"forces": lambda sim: sim.interactions.force}, TypeError, "of the same shape at every step"),
        ({"height": 3.0}, TypeError, r"observe\['height'\] must be a function of the simulation, got 3.0"),
        ({"a/b": support}, ValueError, "'a/b' cannot be a name"),
        ({"": support}, ValueError, "'' cannot be a name"),
        ({1: support}, ValueError, "1 cannot be a name"),
        (support, TypeError, "observe must be functions of the simulation by name"),
    ],
)
def test_what_cannot_be_observed_gets_a_sentence_and_no_file(observe, error, sentence, path):
    with pytest.raises(error, match=sentence):
        heap().run(steps=3, record=path, observe=observe)
    assert not list(path.parent.iterdir())


def test_observing_needs_a_file_that_is_begun(path):
    with pytest.raises(TypeError, match="observe is kept in the run file that record= begins: name one"):
        heap().run(steps=3, observe=OBSERVE)
    heap().run(steps=3, record=path, observe=OBSERVE)
    sim = lm.resume(path, observe=OBSERVE)
    with pytest.raises(TypeError, match=r"give it to lmgcpy\.resume"):
        sim.run(steps=3, record=path, observe=OBSERVE)


@pytest.mark.default_parameters("<lambda>-float division by zero")
@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        (lambda sim: 0 if sim.steps < 5 else 0.5, r"float64 of shape \(\) after step 5, but its table is of int64"),
        (lambda sim: np.zeros(2 if sim.steps < 5 else 3), r"returned float64 of shape \(3,\) after step 5"),
        (lambda sim: 1.0 / (5 - sim.steps), "float division by zero"),
    ],
)
def test_a_function_that_fails_on_the_way_leaves_a_good_file(changes, sentence, path):
    """What came before is in the file, which goes on with a function that does not fail; the simulation is as it was."""
    sim = heap()
    with pytest.raises((ValueError, ZeroDivisionError), match=sentence):
        sim.run(steps=10, record=path, every=2, flush=0.0, observe={"value": changes})
    assert sim.steps == 5
    with lm.io.open_run(path) as run:
        assert len(run.history) == len(run.observed["value"]) == 4
        shape = run.observed["value"].shape[1:]
    again = lm.resume(path, observe={"value": lambda sim: np.zeros(shape, int)}).run(steps=6)
    assert again.steps == 10
    assert np.array_equal(again.positions, sim.run(steps=5).positions)


@pytest.mark.long
def test_compare_names_an_observation_that_differs(path):
    other = path.with_name("other.h5")
    heap().run(steps=20, record=path, observe=OBSERVE)
    bent = {**OBSERVE, "support": lambda sim: support(sim) * (1.0 + 1e-9 * (sim.steps == 12))}
    heap().run(steps=20, record=other, observe=bent)
    with lm.io.open_run(path) as a, lm.io.open_run(other) as b:
        found = lm.io.compare(a, b)
        assert (found.quantity, found.step) == ("support", 12)
        # relative to the largest of the run, which the impact may be; of the force then it is 1e-9
        assert found.by == pytest.approx(1e-9 * a.observed["support"][11], rel=1e-6)
        assert lm.io.compare(a, b, tolerance=1e-6) is None
    heap().run(steps=20, record=other, observe={"support": support}, force=True)
    told = run_cli("compare", path, other)
    assert told.exit_code == 1
    assert "the observed names" in told.output
    heap().run(steps=20, record=other, observe={**OBSERVE, "support": lambda sim: np.zeros(2)}, force=True)
    assert "shape of support as wholes: (20,) and (20, 2)" in run_cli("compare", path, other).output


def test_info_and_export_show_them(path, tmp_path):
    heap().run(steps=20, record=path, observe=OBSERVE)
    told = run_cli("info", path).output
    with lm.io.open_run(path) as run:
        assert f"support, last {run.observed['support'][-1]:g}; places (2, 2); contacts, last" in told
        assert run_cli("export", path, "--csv", tmp_path / "tables").exit_code == 0
        with (tmp_path / "tables" / "observed.csv").open() as file:
            rows = list(csv.DictReader(file))
        assert [int(row["step"]) for row in rows] == list(range(1, 21))
        assert [float(row["support"]) for row in rows] == run.observed["support"][:].tolist()
        assert [float(row["places[1,0]"]) for row in rows] == run.observed["places"][:, 1, 0].tolist()


def test_they_are_plain_tables_that_grow_with_the_history(path):
    heap().run(steps=20, record=path, observe=OBSERVE)
    with h5py.File(path, "r") as file:
        for name in OBSERVE:
            assert file["observed"][name].shape[0] == len(file["history"]) == 20
            assert not file["observed"][name].dtype.hasobject


# ------------------------------------------------------------------------------------------------- until, and take up


def test_a_run_ends_where_until_says_so(path):
    heap().run(steps=50, record=path, until=lambda sim: sim.steps == 7)
    with lm.io.open_run(path) as run:
        assert run.closed
        assert len(run.history) == 7
    assert heap().run(steps=50, until=lambda sim: sim.steps == 7).steps == 7
    assert heap().run(steps=5, until=lambda sim: False).steps == 5

    with pytest.raises(TypeError, match="until must be a function of the simulation"):
        heap().run(steps=5, until=0.5)

    def fail(sim):
        raise LookupError("nothing there")

    sim = lm.resume(path)
    with pytest.raises(LookupError, match="nothing there"):
        sim.run(steps=5, until=fail)
    with lm.io.open_run(path) as run:
        assert run.closed
        assert len(run.history) == 8


def test_a_program_started_again_takes_its_run_up(path):
    """The scene is built anew, with its functions of time; the rest is as if there had been no interruption."""

    def lift(time):
        return 0.1 * np.cos(50.0 * time)

    whole = heap(lift=lift).run(steps=20)
    heap(lift=lift).run(steps=8, record=path, observe=OBSERVE)
    sim = heap(lift=lift)
    lm.io.take_up(sim, path, observe=OBSERVE)
    assert sim.steps == 8
    sim.run(steps=12)
    assert np.array_equal(sim.positions, whole.positions)
    with lm.io.open_run(path) as run:
        assert len(run.observed["support"]) == 20


@pytest.mark.default_parameters(friction=(0.3,))
@pytest.mark.parametrize(
    ("friction", "options", "notes", "sentence"),
    [
        (0.3, {}, {"pressure": 1e5}, "'scene laws 0 parameters friction' is 0.4 there and 0.3 here"),
        (0.4, {"theta": 0.7}, {"pressure": 1e5}, "'theta' is 0.5 in the file and 0.7 here"),
        (0.4, {"solver": lm.GaussSeidel()}, {"pressure": 1e5}, "'solver' is 'Auto' in the file and 'GaussSeidel' here"),
        (0.4, {}, {"pressure": 2e5}, "'notes pressure' is 100000.0 there and 200000.0 here"),
        (0.4, {}, {}, "there is a 'notes pressure' in it"),
    ],
)
def test_the_file_of_another_run_is_not_taken_up(friction, options, notes, sentence, path):
    sim = heap()
    sim.recorder = RunRecorder(path, notes={"pressure": 1e5})
    sim.run(steps=3)
    other = heap(friction=friction, **options)
    with pytest.raises(ValueError, match=f"is the file of another run: .*{sentence}"):
        lm.io.take_up(other, path, notes=notes)
    assert other.steps == 0
    assert "pressure: 100000.0" in run_cli("info", path).output


NAMED = {
    "support": (support, "N"),
    "places": (lambda sim: sim.positions[:2], ["x_0 [m]", "y_0 [m]", "x_1 [m]", "y_1 [m]"]),
    "velocities": (lambda sim: sim.velocities[:2], "m/s"),
    "contacts": lambda sim: len(sim.interactions),
}
NAMES = [
    *("support [N]", "x_0 [m]", "y_0 [m]", "x_1 [m]", "y_1 [m]"),
    *(f"velocities[{k}] [m/s]" for k in ("0,0", "0,1", "1,0", "1,1")),
    "contacts",
]


def test_columns_have_names_and_units(path, tmp_path):
    """In the tables of the run, in CSV and in pandas; a run that goes on takes them from its file."""
    heap().run(steps=5, record=path, observe=NAMED)
    lm.resume(path, observe={name: value[0] if isinstance(value, tuple) else value for name, value in NAMED.items()}).run(2)
    with lm.io.open_run(path) as run:
        assert list(run.observed) == list(NAMED)
        assert list(run.observed_columns) == NAMES
        np.testing.assert_array_equal(run.observed_columns["y_1 [m]"], run.observed["places"][:, 1, 1])
        lm.io.export_csv(run, tmp_path / "tables")
        assert {"time [s]", "kinetic [J]", "step_seconds [s]", "work:coulomb [J]"} <= set(run.history_columns)
    with open(tmp_path / "tables" / "observed.csv", newline="") as file:
        assert next(csv.reader(file)) == ["step", "time [s]", *NAMES]
    pytest.importorskip("pandas")
    with lm.io.open_run(path) as run:
        frame = run.to_dataframe()
    assert list(frame.columns) == [*run.history_columns, *NAMES]
    assert len(frame) == 7


@pytest.mark.parametrize(
    ("observe", "error", "sentence"),
    [
        ({"height": (support, 3)}, TypeError, r"observe\['height'\] may be a function and the unit of its values"),
        ({"height": (3.0, "m")}, TypeError, r"observe\['height'\] must be a function of the simulation, got 3.0"),
        ({"height": (support, ["a", "b"])}, ValueError, r"observe\['height'\] returns 1 numbers and has 2 names"),
        ({"a": (support, ["f [N]"]), "b": (support, ["f [N]"])}, ValueError, r"observe names two columns 'f \[N\]'"),
    ],
)
def test_wrong_names_are_refused(path, observe, error, sentence):
    with pytest.raises(error, match=sentence):
        heap().run(steps=1, record=path, observe=observe)
    assert not path.exists()
