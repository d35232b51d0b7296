"""study.json of a folder is read without trust: a study, or a sentence that names the file."""

from __future__ import annotations

import json
import os

import numpy as np
import pytest
import suites

from lmgcpy.experiment.column.study import ColumnStudy
from lmgcpy.experiment.study.folder import StudyFolder
from lmgcpy.experiment.texsol.study import Study2D, Study3D, TexSolStudy

STUDIES = {"texsol": (TexSolStudy, Study2D), "texsol 3D": (TexSolStudy, Study3D), "column": (ColumnStudy, ColumnStudy)}
TEXTS = (b"", b"{", b"[]", b"null", b"3", b'"word"', b"\xff\xfe", b"[" * 100_000, b'{"format": 3}', b"\0" * 100,
         b'{"format": "lmgcpy texsol study", "study": {}, "versions": {"lmgcpy": 1}}', b"9" * 5000)  # fmt: skip
VALUES = (None, True, -1, 0, 1, 3, 10**400, -(10**18), 1e308, float("nan"), float("inf"), "word", "", [], {}, [1, "a"],
          [None], {"a": 1}, [[1.0]], "x" * 10_000, "../../etc", "\0")  # fmt: skip


@pytest.fixture(params=STUDIES.values(), ids=STUDIES)
def folder(request, tmp_path):
    kind, study = request.param
    made = StudyFolder(tmp_path / "study", kind)
    made.begin(study())
    return made, study


def try_to_read(folder, study):
    """A study, or a sentence."""
    try:
        found = folder.read()
    except ValueError as error:
        words = str(error)
    else:
        assert isinstance(found, study)
        return "read"
    assert str(folder.study_file) in words
    assert words.endswith(".")
    return "refused"


def test_it_is_read_as_it_was_written(folder):
    assert folder[0].read() == folder[1]()


@pytest.mark.parametrize("text", TEXTS, ids=range(len(TEXTS)))
def test_what_is_no_study_is_refused(folder, text):
    folder[0].study_file.write_bytes(text)
    assert try_to_read(*folder) == "refused"


@pytest.mark.default_parameters("texsol")
def test_other_values_are_refused_or_are_those_of_a_study(folder):
    """Every entry by every value, one at a time; of either kind some."""
    about = json.loads(folder[0].study_file.read_text())
    ends = []
    for name in about["study"]:
        for value in VALUES:
            other = {**about, "study": {**about["study"], name: value}}
            folder[0].study_file.write_text(json.dumps(other))
            ends.append(try_to_read(*folder))
    for name in about:
        for value in VALUES:
            folder[0].study_file.write_text(json.dumps({**about, name: value}))
            ends.append(try_to_read(*folder))
    assert set(ends) == {"read", "refused"}


@pytest.mark.scaled
def test_damaged_files_are_refused_or_read(folder):
    """A hundred flips of bits, or a thousand, seed 5. A number may become another number: a study is what a person may
    edit."""
    rng = np.random.default_rng(5)
    whole = folder[0].study_file.read_bytes()
    for _ in range(suites.size(100, long=1000)):
        data = bytearray(whole)
        for at in rng.integers(0, 8 * len(data), rng.integers(1, 4)):
            data[at // 8] ^= 1 << (at % 8)
        folder[0].study_file.write_bytes(data)
        try_to_read(*folder)


def test_a_pipe_is_no_study(folder):
    os.remove(folder[0].study_file)
    os.mkfifo(folder[0].study_file)
    with pytest.raises(ValueError, match="is a pipe or a device"):
        folder[0].read()
