"""Campaigns: what they compute, where, and what becomes of failures, kills and interruptions; the bits are the same."""

from __future__ import annotations

import io
import json
import os
import signal
import socket
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))  # workers import slope from there as well

import slope  # noqa: E402
import suites  # noqa: E402

from lmgcpy.experiment import Campaign, CampaignFolder, Study2D, Study3D  # noqa: E402
from lmgcpy.experiment.campaign.campaign import read_campaign  # noqa: E402
from lmgcpy.experiment.study.engine import Site  # noqa: E402
from lmgcpy.experiment.study.stages import CaseStages, Stages  # noqa: E402


@pytest.fixture(scope="module")
def here():
    """Threads of this process, which begin at once, as an argument of a campaign."""
    with ThreadPoolExecutor(2) as threads:
        yield {"executor": threads}


@pytest.fixture(params=["dask", "processes"])
def workers(request):
    """Arguments of a campaign for so many workers of either kind."""
    with ExitStack() as stack:

        def of(count):
            if request.param == "processes":
                return {"workers": count}
            return {"client": stack.enter_context(dask_client(count))}

        yield of


@contextmanager
def dask_client(count):
    """A client of a cluster whose scheduler leaves deaths to the campaign."""
    distributed = pytest.importorskip("distributed")
    options = {"n_workers": count, "threads_per_worker": 1, "host": "127.0.0.1", "dashboard_address": "127.0.0.1:0"}
    silent = {"silence_logs": 50, "scheduler_kwargs": {"allowed_failures": 0}}
    with distributed.LocalCluster(**options, **silent) as own, distributed.Client(own, set_as_default=False) as client:
        yield client


def slides(**more):
    return Campaign(slope.slide, over={"friction": [0.1, 0.6], "seed": range(2)}, **more)


def same(one, other):
    """The results of two campaigns, to the last bit."""
    assert [case.name for case in one.cases] == [case.name for case in other.cases]
    for a, b in zip(one.cases, other.cases, strict=True):
        assert a.status == b.status == "finished", (a.error, b.error)
        assert a.numbers == b.numbers
        assert {(test, name) for test, curve in a.curves.items() for name in curve} == {
            (test, name) for test, curve in b.curves.items() for name in curve
        }
        for test, curve in a.curves.items():
            for name, values in curve.items():
                assert np.array_equal(values, b.curves[test][name]), (a.name, name)


# ---------------------------------------------------------------------------------------------------- what it computes


def test_cases_are_combinations_and_single_ones():
    campaign = Campaign(
        Study3D(grain_count=100), over={"bead_count": [20, 200], "axes": ["z", "x"]}, cases=[{"pressure": 1.5e5}],
        fixed={"seed": 3},
    )  # fmt: skip
    cases = campaign.all_cases()
    assert [case.name for case in cases] == [
        "bead_count=20,axes=z", "bead_count=20,axes=x", "bead_count=200,axes=z", "bead_count=200,axes=x", "pressure=150000",
    ]  # fmt: skip
    assert cases[1].work == Study3D(grain_count=100, bead_count=20, axes=("x",), seed=3, threads=1)
    assert cases[4].work.pressure == 1.5e5


MISTAKES = {
    "no study": (lambda: Campaign(3, over={"seed": [1]}), TypeError, "A campaign is of a study, or of a function"),
    "nothing varied": (lambda: Campaign(Study2D()), ValueError, "A campaign without over and cases has no case"),
    "empty": (lambda: Campaign(Study2D(), over={"seed": []}), ValueError, "over['seed'] of a campaign has no value"),
    "a word as list": (lambda: Campaign(Study3D(), over={"axes": "z"}), TypeError, "over['axes'] of a campaign is a list"),
    "unknown": (lambda: Campaign(Study2D(), over={"sead": [1]}), ValueError, "Study2D has no parameter 'sead' to be"),
    "threads": (lambda: Campaign(Study2D(), over={"threads": [1]}), ValueError, "has no parameter 'threads'"),
    "no time": (lambda: slides(case_timeout=0.0), ValueError, "case_timeout must be above 0 s, got 0 s"),
    "time in words": (lambda: slides(case_timeout="1 h"), TypeError, "case_timeout must be a number in s, got '1 h'"),
    "twice": (lambda: Campaign(Study2D(), over={"seed": [1, 1]}), ValueError, "has the case 'seed=1' twice"),
    "impossible": (lambda: Campaign(Study2D(), over={"friction": [-1.0]}), ValueError, "Case 'friction=-1': friction must"),
    "no argument": (lambda: Campaign(slope.slide, over={"mu": [0.1]}), TypeError, "'mu=0.1': slide(site, ...) cannot be"),
    "an array": (
        lambda: Campaign(slope.slide, over={"friction": [np.ones(2)]}), TypeError, "'friction' of a campaign is a number"
    ),
    "cases in words": (lambda: Campaign(Study2D(), cases="seed"), TypeError, "cases of a campaign is a list of mappings"),
    "one case alone": (lambda: Campaign(Study2D(), cases={"seed": 1}), TypeError, "cases of a campaign is a list of map"),
    "a case of words": (lambda: Campaign(Study2D(), cases=["seed"]), TypeError, "A case of a campaign is a mapping"),
    "too long": (
        lambda: Campaign(Study2D(), over={"laws": [("none", "rigid-wire", "rigid-rod", "elastic-wire", "elastic-rod")],
            "preparation": ["loose"], "solver": ["accelerated"], "pressure": [1.23456789e5], "friction": [0.123456789],
            "strain": [0.0987654321], "axial_rigidity": [1.23456789e6]}),
        ValueError, "The name of a case would have more than 150 bytes"
    ),
}  # fmt: skip


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_gets_a_sentence(mistake):
    make, kind, words = MISTAKES[mistake]
    with pytest.raises(kind) as caught:
        make()
    assert words in str(caught.value)


def test_a_file_says_the_same(tmp_path):
    text = 'study = "texsol-3d"\n[fixed]\ngrain_count = 100\n[over]\nbead_count = [20, 40]\naxes = ["z"]\n'
    (tmp_path / "c.toml").write_text(f"case_timeout = 3600\n{text}[[cases]]\nseed = 7\n")
    over = {"bead_count": [20, 40], "axes": ["z"]}
    expected = Campaign(Study3D(), fixed={"grain_count": 100}, over=over, cases=[{"seed": 7}], case_timeout=3600.0)
    assert read_campaign(tmp_path / "c.toml") == expected
    (tmp_path / "f.toml").write_text('study = "slope:slide"\n[over]\nfriction = [0.1]\n')
    assert read_campaign(tmp_path / "f.toml").work is slope.slide
    (tmp_path / "own.toml").write_text('study = "slides:Slides"\n[over]\nsteps = [10, 20]\n')
    sys.path.insert(0, str(HERE.parent / "study"))
    assert [case.work.steps for case in read_campaign(tmp_path / "own.toml").all_cases()] == [10, 20]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("study = ", "is no TOML file"),
        ("[over]\nseed = [1]", "must say the study"),
        ('study = "texsol"\ncase_timeout = -1\n[over]\nseed = [1]', "case_timeout must be above 0 s"),
        ('study = "texsol-4d"\n[over]\nseed = [1]', "There is no study 'texsol-4d'; did you mean 'texsol-3d'?"),
        ('study = "slope:SLOPE"\n[over]\nseed = [1]', "'slope:SLOPE' is neither a function nor the class of a study"),
        ('study = "slope:glide"\n[over]\nseed = [1]', "'slope:glide' cannot be imported"),
        ('study = "texsol"\n[ower]\nseed = [1]', "has an unknown key 'ower'; did you mean 'over'?"),
        ('study = "texsol"\n[over]\nsead = [1]', "Study2D has no parameter 'sead'"),
        ('study = "texsol"\ncases = 3', "cases of a campaign is a list of mappings of parameters, got 3"),
    ],
)
def test_a_wrong_file_gets_a_sentence(tmp_path, text, words):
    (tmp_path / "c.toml").write_text(text)
    with pytest.raises((ValueError, TypeError), match=r"c\.toml") as caught:
        read_campaign(tmp_path / "c.toml")
    assert words in str(caught.value)


# -------------------------------------------------------------------------------------------------------- where it runs


@pytest.mark.long
def test_the_bits_do_not_depend_on_the_workers(tmp_path, workers):
    """Against the function itself, called here."""
    results = slides().run(tmp_path / "two", **workers(2))
    assert [case.status for case in results.cases] == ["finished"] * 4
    for case in results.cases:
        alone = slope.slide(Site(Stages(quiet=True), None), **case.parameters)
        assert case.numbers == {"distance [m]": alone["distance [m]"]}
        assert np.array_equal(case.curves[""]["x [m]"], alone["x [m]"])
        assert (tmp_path / "two" / "cases" / case.name / "slide.h5").exists()
    assert results.cases[0].numbers["distance [m]"] > 0.0 == results.cases[2].numbers["distance [m]"]
    assert not list((tmp_path / "two" / "cases").glob("*.progress"))
    same(results, CampaignFolder(tmp_path / "two").results())


@pytest.mark.long
def test_a_case_that_fails_ends_nothing(tmp_path, workers):
    results = Campaign(slope.fails, over={"number": range(3)}).run(tmp_path / "out", **workers(1))
    assert [case.status for case in results.cases] == ["finished", "failed", "finished"]
    assert results.cases[1].error == "ValueError: one is too many"


@pytest.mark.long
def test_a_worker_that_is_killed_costs_nothing(tmp_path, workers):
    file = str(tmp_path / "died")
    results = Campaign(slope.dies, over={"number": range(4)}, fixed={"file": file}).run(tmp_path / "out", **workers(2))
    assert os.path.exists(file)
    assert [case.numbers for case in results.cases] == [{"number": k} for k in range(4)]


@pytest.mark.long
def test_a_case_whose_workers_always_die_is_given_up(tmp_path, workers):
    """And not the other, which waits behind it at the worker that dies, as often as it dies."""
    results = Campaign(slope.always_dies, over={"number": [1, 0]}).run(tmp_path / "out", **workers(1))
    assert [case.status for case in results.cases] == ["failed", "finished"]
    assert "its worker died 4 times" in results.cases[0].error


@pytest.mark.long
@pytest.mark.skipif(os.name == "nt", reason="groups of processes, and a sleep that holds on to Python")
def test_a_case_that_hangs_is_killed_with_what_it_began_and_the_others_are_done(tmp_path, workers):
    """With one worker, so that the others wait behind it; it is tried again by resume, as what has failed is, and its
    workers do not count as dead. 6 s is three times what a process takes to begin."""
    out, file = tmp_path / "out", str(tmp_path / "begun")
    campaign = Campaign(slope.hangs, over={"number": range(3)}, fixed={"file": file}, case_timeout=6.0)
    one = workers(1)
    results = campaign.run(out, **one)
    assert [case.status for case in results.cases] == ["finished", "failed", "finished"]
    assert results.cases[1].error == "TimeoutError: the case did not end within 6 s and was killed."
    assert results.cases[1].seconds == 6.0
    assert not list((out / "cases").glob("*.progress"))
    again = replace(campaign, case_timeout=5.0).run(out, **one, resume=True)
    assert again.cases[1].error == "TimeoutError: the case did not end within 5 s and was killed."
    begun = Path(file).read_text().split()
    assert len(begun) == 2  # once a run
    assert not any(slope.runs(int(pid)) for pid in begun)


@pytest.mark.long
def test_the_bits_do_not_depend_on_a_process_of_ones_own(tmp_path, workers):
    two = workers(2)
    same(slides(case_timeout=60.0).run(tmp_path / "limited", **two), slides().run(tmp_path / "out", **two))


@pytest.mark.long
@pytest.mark.skipif(os.name == "nt", reason="SIGKILL")
def test_a_case_whose_own_processes_always_die_is_given_up(tmp_path, workers):
    campaign = Campaign(slope.always_dies, over={"number": [1, 0]}, case_timeout=60.0)
    results = campaign.run(tmp_path / "out", **workers(1))
    assert [case.status for case in results.cases] == ["failed", "finished"]
    assert "its worker died 4 times" in results.cases[0].error


@pytest.mark.long
def test_a_study_is_a_case_with_a_folder_of_its_own(tmp_path, here):
    """Two laws of a tiny sample; the second campaign finds them there, done, and the folder is one of `lmgcpy texsol`."""
    study = Study2D(grain_count=30, bead_count=4, laws=("none", "rigid-wire"), strain=0.004, check_strain=0.0)
    campaign = Campaign(study, over={"seed": [0]})
    results = campaign.run(tmp_path / "out", **here)
    (case,) = results.cases
    assert case.status == "finished", case.error
    assert "rigid-wire: gain of the peak deviator [Pa]" in case.numbers
    assert case.numbers["none: steps"] == len(case.curves["none"]["crushing"]) > 10
    assert (tmp_path / "out" / "cases" / "seed=0" / "study.json").exists()
    (tmp_path / "out" / "cases.jsonl").unlink()
    same(campaign.run(tmp_path / "out", **here, resume=True), results)


def test_nobody_answers(tmp_path, monkeypatch):
    """Within the time that it is given; 8 s otherwise."""
    pytest.importorskip("distributed")
    monkeypatch.setattr("lmgcpy.experiment.campaign.workers.ANSWER", 1.0)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    begin = time.perf_counter()
    with pytest.raises(ConnectionError, match="No Dask scheduler answers at"):
        slides().run(tmp_path / "out", scheduler=address)
    assert time.perf_counter() - begin < 3.0  # the second, and the import of Dask
    file = tmp_path / "dask.json"
    file.write_text('{"id": 3}')
    with pytest.raises(ValueError, match=r"dask\.json' is no file that a Dask scheduler has written"):
        slides().run(tmp_path / "out", scheduler_file=str(file), force=True)


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:unclosed:ResourceWarning")
def test_a_cluster_of_ones_own(tmp_path, monkeypatch):
    """By a client, which stays open, by address and by file; workers with another version are refused."""
    with dask_client(1) as client:
        address = client.scheduler.address
        results = slides().run(tmp_path / "out", client=client)
        assert len(results.finished) == 4
        assert client.submit(int, 3).result() == 3
        (tmp_path / "dask.json").write_text(json.dumps({"address": address}))
        for k, where in enumerate(({"scheduler": address}, {"scheduler_file": str(tmp_path / "dask.json")})):
            same(slides().run(tmp_path / f"out{k}", **where), results)
        assert client.submit(int, 4).result() == 4
        (worker,) = client.scheduler_info()["workers"]
        with pytest.raises(ConnectionError, match=rf"No Dask scheduler answers at '{worker}' .*there is a Worker of Dask"):
            slides().run(tmp_path / "worker", scheduler=worker)
        monkeypatch.setattr(client, "run", lambda call: {"tcp://elsewhere": {"lmgcpy": "0.1.0"}})
        with pytest.raises(RuntimeError, match=r"worker tcp://elsewhere has lmgcpy 0\.1\.0, this process"):
            slides().run(tmp_path / "other", client=client)


# ---------------------------------------------------------------------------------------- folders, interruption, resume


def test_folders_are_kept_apart(tmp_path, here):
    campaign = Campaign(slope.nothing, over={"number": range(2)})
    campaign.run(tmp_path / "out", **here)
    with pytest.raises(FileExistsError, match="holds a campaign: go on with resume"):
        campaign.run(tmp_path / "out")
    with pytest.raises(ValueError, match="holds another campaign, with cases that are not among these"):
        Campaign(slope.nothing, over={"number": range(1)}).run(tmp_path / "out", resume=True)
    with pytest.raises(ValueError, match="holds another campaign, of slope:nothing and not of slope:fails"):
        Campaign(slope.fails, over={"number": range(2)}).run(tmp_path / "out", resume=True)
    with pytest.raises(FileNotFoundError, match="There is no campaign in"):
        campaign.run(tmp_path / "elsewhere", resume=True)
    with CampaignFolder(tmp_path / "out").held(), pytest.raises(BlockingIOError, match=r"The campaign in .* is under way"):
        campaign.run(tmp_path / "out", resume=True)
    assert len(Campaign(slope.fails, over={"number": range(1)}).run(tmp_path / "out", **here, force=True).finished) == 1
    (tmp_path / "out" / "campaign.json").write_text("{")
    with pytest.raises(ValueError, match="is damaged or of another version"):
        campaign.run(tmp_path / "out", resume=True)


def test_cases_can_be_added(tmp_path, here):
    """The entries of the first two are kept, and the folder belongs to the larger campaign from then on."""
    small, large = (Campaign(slope.nothing, over={"number": range(n)}) for n in (2, 4))
    small.run(tmp_path / "out", **here)
    before = (tmp_path / "out" / "cases.jsonl").read_bytes()
    found = large.run(tmp_path / "out", **here, resume=True)
    assert [one.parameters["number"] for one in found.finished] == [0, 1, 2, 3]
    assert (tmp_path / "out" / "cases.jsonl").read_bytes().startswith(before)
    assert len(CampaignFolder(tmp_path / "out").results().finished) == 4
    with pytest.raises(ValueError, match="cases that are not among these"):
        small.run(tmp_path / "out", resume=True)


def test_a_line_that_was_cut_short_is_done_again(tmp_path, here):
    campaign = Campaign(slope.nothing, over={"number": range(3)})
    first = campaign.run(tmp_path / "out", **here)
    ledger = tmp_path / "out" / "cases.jsonl"
    ledger.write_bytes(ledger.read_bytes()[:-20])
    results = CampaignFolder(tmp_path / "out").results()
    assert (len(results.finished), results.left_out) == (2, 1)
    same(campaign.run(tmp_path / "out", **here, resume=True), first)


def test_force_begins_anew(tmp_path, here):
    """Runs of the former campaign, of as many steps as it had, are none of this one; what is under way is left alone."""
    over = {"friction": [0.1]}
    Campaign(slope.slide, over=over, fixed={"steps": 40}).run(tmp_path / "out", **here)
    fewer = Campaign(slope.slide, over=over, fixed={"steps": 20})
    with CampaignFolder(tmp_path / "out").held(), pytest.raises(BlockingIOError, match="is under way"):
        fewer.run(tmp_path / "out", **here, force=True)
    (case,) = CampaignFolder(tmp_path / "out").results().finished
    assert len(case.curves[""]["step"]) == 40
    (case,) = fewer.run(tmp_path / "out", **here, force=True).cases
    assert case.status == "finished", case.error
    assert len(case.curves[""]["step"]) == 20


@pytest.mark.scaled
def test_damaged_folders_are_refused_or_read_as_they_were(tmp_path, here):
    """What is read of a damaged folder is what was there, or is to come again; before there were sums digits of the ledger
    could change, and a damaged archive of curves ended in an error of zipfile. Seed 0."""
    out = tmp_path / "out"
    whole = {case.name: case for case in Campaign(slope.slide, over={"friction": [0.1, 0.6]}).run(out, **here).cases}
    files = {file: file.read_bytes() for file in (out / "campaign.json", out / "cases.jsonl", *(out / "curves").iterdir())}
    rng, ends = np.random.default_rng(0), set()
    for _ in range(suites.size(100, long=3000)):
        file = list(files)[rng.integers(len(files))]
        content = bytearray(files[file])
        start = int(rng.integers(len(content)))
        if rng.random() < 0.3:
            del content[start:]
        elif rng.random() < 0.3:
            del content[start : start + int(rng.integers(1, 40))]
        else:
            content[start] ^= int(rng.integers(1, 256))
        file.write_bytes(content)
        try:
            found = CampaignFolder(out).results().cases
            ends |= {case.status for case in found}
            for case in found:
                if case.status == "finished" and case.name in whole:  # a damaged description may name others
                    assert case.numbers == whole[case.name].numbers
                    for name, values in whole[case.name].curves[""].items():
                        assert np.array_equal(case.curves[""][name], values)
        except (ValueError, FileNotFoundError):
            ends.add("refused")
        file.write_bytes(files[file])
    assert ends == {"finished", "to come", "refused"}


SLOW = """
import sys
sys.path.insert(0, {here!r})
import slope
from test_campaign import dask_client
from lmgcpy.experiment import Campaign
if __name__ == "__main__":
    over, fixed = {{"friction": [0.1, 0.2], "seed": range({seeds})}}, {{"slow": 0.01, "steps": 80}}
    campaign = Campaign(slope.slide, over=over, fixed=fixed)
    if {dask}:
        with dask_client(2) as client:
            campaign.run({out!r}, client=client)
    else:
        campaign.run({out!r}, workers=2)
"""


SLOWLY = {"slow": 0.01, "steps": 80}


def slow_campaign(out, dask, seeds=2):
    script = out.parent / "campaign.py"
    script.write_text(SLOW.format(here=str(HERE), dask=dask, out=str(out), seeds=seeds))
    paths = os.pathsep.join([str(HERE.parent.parent), *sys.path])
    with (out.parent / "said.txt").open("w") as said:
        return subprocess.Popen(
            [sys.executable, str(script)], start_new_session=True, stderr=said, env={**os.environ, "PYTHONPATH": paths}
        )


def under_way(out, process):
    """Wait until a case has made steps."""
    for _ in range(600):
        if list(out.glob("cases/*/slide.h5")):
            return
        assert process.poll() is None, (out.parent / "said.txt").read_text()
        time.sleep(0.05)
    pytest.fail("no case began within 30 s")


@pytest.mark.long
@pytest.mark.skipif(os.name == "nt", reason="signals of groups of processes")
def test_ctrl_c_ends_it_between_steps_and_it_goes_on(tmp_path):
    """The signal goes to all processes, as on a terminal."""
    out = tmp_path / "out"
    process = slow_campaign(out, dask=False)
    under_way(out, process)
    os.killpg(process.pid, signal.SIGINT)
    assert process.wait(timeout=30) != 0
    assert "KeyboardInterrupt" in (tmp_path / "said.txt").read_text()
    described = Campaign(slope.slide, over={"friction": [0.1, 0.2], "seed": range(2)}, fixed=SLOWLY)
    before = CampaignFolder(out).results()
    assert len(before.finished) < 4
    assert not any(case.status == "failed" for case in before.cases)
    after = described.run(out, workers=2, resume=True)
    same(after, described.run(tmp_path / "whole", workers=1))


@pytest.mark.long
@pytest.mark.skipif(os.name == "nt", reason="SIGKILL")
def test_the_workers_end_with_a_campaign_that_is_killed(tmp_path):
    """They would else go on, with run files that the campaign needs when it is resumed, and wait for ever afterwards."""
    out = tmp_path / "out"
    process = slow_campaign(out, dask=False)
    under_way(out, process)
    process.kill()
    process.wait()
    end = time.monotonic() + 30.0
    while any(slope.runs(pid) for pid in of_session(process.pid)):
        assert time.monotonic() < end
        time.sleep(0.05)
    described = Campaign(slope.slide, over={"friction": [0.1, 0.2], "seed": range(2)}, fixed=SLOWLY)
    assert len(described.run(out, workers=2, resume=True).finished) == 4


@pytest.mark.long
@pytest.mark.skipif(os.name == "nt", reason="signals of groups of processes")
@pytest.mark.parametrize("dask", [True, False])
def test_twenty_four_cases_with_a_killed_worker_have_the_bits_of_one_process(tmp_path, dask):
    """SIGKILL to a worker in the middle of a case, whose run file it leaves behind."""
    out = tmp_path / "out"
    process = slow_campaign(out, dask, seeds=12)
    under_way(out, process)
    victim = next(pid for pid in reversed(of_session(process.pid)) if _has_open(pid, out))
    os.kill(victim, signal.SIGKILL)
    assert process.wait(timeout=120) == 0, (tmp_path / "said.txt").read_text()
    described = Campaign(slope.slide, over={"friction": [0.1, 0.2], "seed": range(12)}, fixed=SLOWLY)
    same(CampaignFolder(out).results(), described.run(tmp_path / "whole", workers=1))


def of_session(pid):
    """The processes of a session."""
    found = subprocess.run(["pgrep", "-s", str(pid)], capture_output=True, text=True, check=False)
    return [int(word) for word in found.stdout.split()]


def _has_open(pid, folder):
    """Whether a process has a run file open."""
    try:
        return any(str(folder) in os.readlink(file) for file in Path(f"/proc/{pid}/fd").iterdir() if file.exists())
    except OSError:
        return False


# -------------------------------------------------------------------------------------------------- cost and progress


def test_the_cost_is_that_of_finished_cases_or_of_the_table(tmp_path, here):
    campaign = Campaign(slope.nothing, over={"number": range(3)})
    results = campaign.run(tmp_path / "out", **here)
    seconds, source = results.expected_seconds(campaign.all_cases()[1])
    assert seconds == results.cases[1].seconds
    assert source == "1 finished alike"
    assert CampaignFolder(tmp_path / "out").results([]).expected_seconds(campaign.all_cases()[0]) == (None, "unknown")
    one, two = (Campaign(Study3D(grain_count=count), over={"seed": [0]}).all_cases()[0] for count in (1000, 4500))
    nothing = CampaignFolder(tmp_path / "none").results([])
    # cost goes with the number of particles: 1000 + 3500 and 4500 + 3500
    assert nothing.expected_seconds(two)[0] / nothing.expected_seconds(one)[0] == pytest.approx(8000 / 4500)


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_a_terminal_shows_what_runs(tmp_path):
    (tmp_path / "number=1.progress").write_text(json.dumps({"stage": "slide", "done": 3, "total": 10}))
    (tmp_path / "number=2.progress").write_text("{")  # being written
    stream = Terminal()
    with CaseStages(tmp_path, 3, 1, stream) as view:
        view.look()
    assert "number=1" in stream.getvalue()
    assert "3/10" in stream.getvalue()
    assert "0 failed, 2 to come" in stream.getvalue()
    quiet = io.StringIO()
    with CaseStages(tmp_path, 3, 0, quiet, quiet=True) as view:
        view.look()
    assert quiet.getvalue() == ""


# ------------------------------------------------------------------------------------------------------- command line


def command(*words):
    from click.testing import CliRunner

    from lmgcpy.cli import main

    return CliRunner().invoke(main, ["campaign", *map(str, words)])


@pytest.mark.default_parameters(workers="processes")
def test_the_command_runs_reports_and_tells_the_cost(tmp_path, workers):
    file = tmp_path / "few.toml"
    file.write_text('study = "slope:fails"\n[over]\nnumber = [0, 1, 2]\n')
    told = command(file, "--dry-run")
    assert told.exit_code == 0, told.output
    assert "number=1: unknown\n" in told.output
    assert "3 of 3 cases to come" in told.output
    assert not (tmp_path / "few").exists()
    ran = command(file, "--workers", "1")
    assert ran.exit_code == 1
    assert "1 of 3 cases failed, the first: number=1: ValueError: one is too many" in ran.output
    assert (tmp_path / "few" / "report.md").exists()
    assert command(file, "--dry-run").output.startswith("number=0: finished\n")
    again = command("report", tmp_path / "few")
    assert again.exit_code == 0
    assert str(tmp_path / "few" / "report.md") in again.output


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["none.toml"], "none.toml"),
        (["c.toml", "--workers", "0"], "0 is not in the range x>=1"),
        (["c.toml", "--workers", "2", "--scheduler", "tcp://127.0.0.1:1"], "--workers are processes of this machine"),
        (["c.toml", "--out", "elsewhere", "--resume"], "There is no campaign in 'elsewhere'"),
        (["report", "empty"], "There is no campaign in 'empty'"),
    ],
)
def test_a_wrong_command_gets_a_sentence(tmp_path, monkeypatch, words, said):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty").mkdir()
    (tmp_path / "c.toml").write_text('study = "slope:nothing"\n[over]\nnumber = [0]\n')
    result = command(*words)
    assert result.exit_code != 0
    assert said in result.output
    assert "Traceback" not in result.output
