"""Cases that end as none should, folders that hold what none should: a sentence, and the others are done."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

import slope

from lmgcpy.experiment import Campaign, Site, Stages
from lmgcpy.experiment.campaign import workers
from lmgcpy.experiment.campaign.case_work import Order, do_case
from lmgcpy.experiment.campaign.cases import FAILED, FINISHED, TO_COME, CampaignFolder, _sum, case_name
from lmgcpy.version import versions


def a_site():
    return Site(Stages(quiet=True), None)


class Unspeakable(Exception):
    def __str__(self):
        raise ValueError("cannot be shown")


def ends(site, how):
    """A case that ends so."""
    if how == "interrupt":
        raise KeyboardInterrupt
    if how == "exit":
        sys.exit(0)
    if how == "generator":
        raise GeneratorExit
    if how == "unspeakable":
        raise Unspeakable
    if how == "surrogate error":
        raise ValueError("\udc80")
    if how == "surrogate name":
        return {"a\udc80 [m]": 1.0}
    return {"x [m]": 1.0}


SENTENCES = {
    "interrupt": "KeyboardInterrupt: the case raised it itself.",
    "exit": "SystemExit: the case called sys.exit(0).",
    "generator": "GeneratorExit: ",
    "unspeakable": "Unspeakable: <Unspeakable that cannot be shown>",
    "surrogate error": "ValueError: \\udc80",
    "surrogate name": "ValueError: ends returned a result under the name 'a\\udc80 [m]', which no file can hold.",
}


@pytest.mark.parametrize("how", SENTENCES)
def test_a_case_that_ends_in_its_own_way_has_failed_and_says_how(how, tmp_path):
    """Not "to come", which ended a campaign with return code 0, nor "want of memory"; its line can be written and read."""
    campaign = Campaign(ends, over={"how": [how]})
    (case,) = campaign.all_cases()
    folder = CampaignFolder(tmp_path / "out")
    folder.begin(campaign.described())
    result = do_case(Order(case, str(folder.path), a_site(), versions()))
    assert (result.status, result.error) == (FAILED, SENTENCES[how])
    folder.enter(result)
    assert folder.results().cases[0].error == SENTENCES[how]
    result.error.encode()


def test_a_case_that_the_campaign_stops_is_to_come(tmp_path):
    campaign = Campaign(ends, over={"how": ["interrupt"]})
    folder = CampaignFolder(tmp_path / "out")
    folder.begin(campaign.described())
    site = a_site()
    site.stop()
    order = Order(campaign.all_cases()[0], str(folder.path), site, versions())
    assert do_case(order).status == TO_COME


WRONG = {
    "no dictionary": [],
    "a number": 3,
    "without numbers": {"numbers": None},
    "numbers of words": {"numbers": {"x [m]": "1"}},
    "numbers of flags": {"numbers": {"x [m]": True}},
    "a status of its own": {"status": "done"},
    "to come": {"status": TO_COME},
    "time of words": {"seconds": "1 s"},
    "an error of none": {"error": None},
    "versions of numbers": {"versions": {"lmgcpy": 1}},
    "parameters in a list": {"parameters": []},
    "more than there is": {"more": 1},
    "a name of none": {"name": None},
    "curves in words": {"curves": "0123456789abcdef"},
}


@pytest.mark.parametrize("what", WRONG)
def test_a_line_of_the_ledger_with_a_right_sum_and_wrong_content_does_not_count(what, tmp_path):
    """The case is to come, and is done again; before, reports and resumed campaigns ended in KeyError."""
    campaign = Campaign(ends, over={"how": ["well"]})
    folder = CampaignFolder(tmp_path / "out")
    folder.begin(campaign.described())
    (case,) = campaign.all_cases()
    folder.enter(do_case(Order(case, str(folder.path), a_site(), versions())))
    assert folder.results().cases[0].status == FINISHED
    line = json.loads(folder.ledger.read_text().rpartition(" ")[0])
    given = WRONG[what]
    text = json.dumps({**line, **given} if isinstance(given, dict) else given)
    folder.ledger.write_text(f"{text} {_sum(text.encode())}\n")
    assert folder.results().cases[0].status == TO_COME


def test_names_are_counted_as_file_systems_count_them():
    """Sixty characters of three bytes each are 180 bytes, and a folder's name has 255 with what is put beside it."""
    assert len(case_name({"a": "x" * 100}).encode()) <= 150
    with pytest.raises(ValueError, match="more than 150 bytes"):
        case_name({"a": "\u6e05" * 60})


def test_a_campaign_of_more_cases_than_anybody_waits_for_is_refused_at_once():
    with pytest.raises(ValueError, match="makes 1000000000000 cases, more than 1000000"):
        Campaign(ends, over={name: range(100) for name in "abcdef"})


def test_a_parameter_that_no_file_can_hold_is_refused():
    with pytest.raises(ValueError, match="which no file can hold"):
        Campaign(ends, over={"how": ["\udc80"]})


def test_force_leaves_what_is_not_the_campaigns(tmp_path):
    """The files of its former cases go, and nothing else: a thesis in ``cases`` stays."""
    folder = CampaignFolder(tmp_path / "out")
    former = Campaign(ends, over={"how": ["well", "exit"]})
    folder.begin(former.described())
    for case in former.all_cases():
        (folder.cases / case.name).mkdir()
        (folder.cases / case.name / "run.h5").write_text("")
    folder.curves.mkdir()
    mine = [folder.cases / "thesis.txt", folder.curves / "mine.npz", folder.cases / "photos" / "me.png"]
    mine[2].parent.mkdir()
    for file in mine:
        file.write_text("mine")
    folder.begin(Campaign(ends, over={"how": ["interrupt"]}).described())
    assert all(file.read_text() == "mine" for file in mine)
    assert not any((folder.cases / case.name).exists() for case in former.all_cases())


def test_two_campaigns_do_not_share_a_folder_whoever_writes_its_description(tmp_path):
    """The lock is on a file of its own: the description is replaced, and was locked as the one that nobody saw any more."""
    folder = CampaignFolder(tmp_path / "out")
    campaign = Campaign(ends, over={"how": ["well"]})
    with folder.held():
        folder.begin(campaign.described())
        before = folder.description_file.read_text()
        with pytest.raises(BlockingIOError, match="is under way"):
            Campaign(ends, over={"how": ["exit"]}).run(folder.path, force=True, workers=1)
        assert folder.description_file.read_text() == before


@pytest.mark.parametrize("says", [b"", b"HTTP/1.1 400 Bad Request\r\n\r\n"])
def test_a_scheduler_that_accepts_and_never_answers_is_named(says, monkeypatch):
    """Neither Dask's patience nor that of a client of which nobody knows is added: before, twice as long. Whoever says what
    Dask does not is named as well: its first eight bytes are a length, of 3 EiB."""
    pytest.importorskip("distributed")
    monkeypatch.setattr(workers, "ANSWER", 0.5)
    with socket.socket() as deaf:
        deaf.bind(("127.0.0.1", 0))
        deaf.listen()
        talker = threading.Thread(target=_say, args=(deaf, says), daemon=True)
        if says:
            talker.start()
        address = f"tcp://127.0.0.1:{deaf.getsockname()[1]}"
        begin = time.monotonic()
        with pytest.raises(ConnectionError, match=f"No Dask scheduler answers at '{address}' within 0.5 s"):
            workers.client_at(address, None)
        assert time.monotonic() < begin + 2.5  # the import of Dask
    if says:
        talker.join()


def _say(server, says):
    with server.accept()[0] as there:
        there.sendall(says)
        while there.recv(1000):  # until the other hangs up
            pass


@pytest.mark.long
def test_a_script_without_a_guard_gets_one_sentence(tmp_path):
    """Its workers begin it anew. Before, each said so as well, and every case failed for want of memory."""
    script = tmp_path / "script.py"
    script.write_text(
        f"import sys\nsys.path.insert(0, {str(Path(__file__).parent)!r})\nimport slope\n"
        "from lmgcpy.experiment import Campaign\n"
        f"Campaign(slope.nothing, over={{'number': [1, 2]}}).run({str(tmp_path / 'out')!r}, workers=2)\n"
    )
    said = subprocess.run([sys.executable, script], capture_output=True, text=True, check=False, timeout=100).stderr
    assert said.count("__main__") == 1
    assert said.count("Traceback") == 1
    assert said.splitlines()[-1].startswith("RuntimeError: The workers on this machine did not start")
    assert said.endswith("put the call under if __name__ == '__main__': there.\n")


WORKER = """
import sys
sys.path.insert(0, {here!r})
import slope
from lmgcpy.experiment.campaign.case_work import do_case_within
from lmgcpy.experiment import Campaign
from lmgcpy.experiment.campaign.case_work import Order
from lmgcpy.experiment import Site, Stages
from lmgcpy.io.recorder import versions
if __name__ == "__main__":
    (case,) = Campaign(slope.waits, over={{"file": [{file!r}]}}).all_cases()
    do_case_within(Order(case, {folder!r}, Site(Stages(quiet=True), None), versions()), 100.0)
"""


@pytest.mark.long
@pytest.mark.skipif(os.name == "nt", reason="SIGKILL")
def test_a_case_in_a_process_of_its_own_ends_with_its_worker(tmp_path):
    """It would else go on with run files that the next worker opens."""
    file, script = tmp_path / "pid", tmp_path / "worker.py"
    script.write_text(WORKER.format(here=str(Path(__file__).parent), file=str(file), folder=str(tmp_path)))
    worker = subprocess.Popen([sys.executable, str(script)])
    _until(file.exists)
    worker.kill()
    worker.wait()
    _until(lambda: not slope.runs(int(file.read_text())))


def _until(there):
    end = time.monotonic() + 30.0
    while not there():
        assert time.monotonic() < end
        time.sleep(0.05)
