"""Whatever is written: what was there stays until the new file is whole, and what fails names the file and leaves nothing.

A limit on the size of files stands for a full disk; the kernels that are needed are there before it is set. Every test of
it is a process of its own, as libraries may bring theirs down.
"""

import ast
import errno
import inspect
import os
import stat
import textwrap
from pathlib import Path

import pytest
from forks import forked

import lmgcpy as lm
from lmgcpy import writing

resource = pytest.importorskip("resource")


def text_of(path):
    return Path(path).read_text(encoding="utf-8")


READ = ("open_run", "read", "take_up", "compare")


def test_a_file_that_exists_is_replaced_by_force_or_its_call_says_so(tmp_path):
    """Data are written over with ``force=True`` only; pictures are drawn again, as the docstrings say."""
    public = [
        getattr(room, name)
        for room in (lm.io, lm.io.fclib, lm.view)
        for name in dir(room)
        if getattr(getattr(room, name), "__module__", "").startswith(room.__name__) and callable(getattr(room, name))
    ]
    writers = {each.__name__: each for each in [*public, lm.Simulation.run] if each.__name__ not in READ}
    writers = {name: each for name, each in writers.items() if {"path", "folder", "record"} & set(given(each))}
    del writers["Run"]
    assert set(writers) >= {"export_csv", "export_vtk", "write", "run", "render", "plot"}
    asking = {name for name, each in writers.items() if "force" in given(each) and given(each)["force"].default is False}
    saying = {name for name, each in writers.items() if "A file of that name is replaced" in " ".join(each.__doc__.split())}
    assert asking ^ saying == set(writers)
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=1.0, position=(0, 0), mass=1.0))
    sim, path = lm.Simulation(scene, time_step=1.0), tmp_path / "a.png"
    with pytest.raises(FileExistsError):
        sim.run(steps=1, record=existing(tmp_path / "run.h5"))
    sim.run(steps=1, record=tmp_path / "new.h5")
    with lm.io.open_run(tmp_path / "new.h5") as run:
        lm.view.plot(run, existing(path), what="energy")
        with pytest.raises(FileExistsError):
            lm.io.export_csv(run, tmp_path)
    assert path.read_bytes()[:4] == b"\x89PNG"
    with pytest.raises(FileExistsError):
        lm.io.fclib.write(sim.problem(), existing(tmp_path / "problem.h5"))


def given(function):
    return inspect.signature(function).parameters


def existing(path):
    path.write_text("mine")
    return path


# ---------------------------------------------------------------------------------------------------------- the one way


def test_a_file_has_its_name_only_when_it_is_whole(tmp_path):
    path = tmp_path / "a.txt"
    writing.write_text(path, "old")
    with writing.new_file(path) as new:
        assert new.suffix == ".txt"
        new.write_text("half of the new")
        assert text_of(path) == "old"
    assert text_of(path) == "half of the new"
    assert [each.name for each in tmp_path.iterdir()] == ["a.txt"]


@pytest.mark.parametrize(
    "raised", [KeyboardInterrupt(), ValueError("no"), OSError(errno.ENOSPC, "No space left on device")]
)
def test_what_fails_leaves_what_was_there_and_nothing_else(tmp_path, raised):
    path = tmp_path / "a.txt"
    writing.write_text(path, "old")

    def write():
        with writing.new_file(path) as new:
            new.write_text("half")
            raise raised

    with pytest.raises(type(raised)) as caught:
        write()
    assert text_of(path) == "old"
    assert len(list(tmp_path.iterdir())) == 1
    if isinstance(raised, OSError):
        assert str(caught.value) == f"'{path}' could not be written: No space left on device. {writing.REMEDY}"
        assert caught.value.errno == errno.ENOSPC


@pytest.mark.parametrize("call", ["fsync", "replace"])
def test_a_system_that_fails_late_is_heard(tmp_path, monkeypatch, call):
    path = tmp_path / "a.txt"
    writing.write_text(path, "old")

    def fail(*given):
        raise OSError(errno.EIO, "Input/output error")

    monkeypatch.setattr(os, call, fail)
    with pytest.raises(OSError, match=r"a\.txt' could not be written: Input/output error"):
        writing.write_text(path, "new")
    monkeypatch.undo()
    assert text_of(path) == "old"
    assert len(list(tmp_path.iterdir())) == 1


def test_the_content_is_on_the_disk_before_it_has_the_name(tmp_path, monkeypatch):
    """Else a power cut would leave the name with nothing in it; the folder, which holds the name, is flushed last."""
    done = []
    flush, replace = writing.flush, os.replace
    monkeypatch.setattr(writing, "flush", lambda path: (done.append(os.path.isdir(path)), flush(path)))
    monkeypatch.setattr(os, "replace", lambda *paths: (done.append("named"), replace(*paths)))
    writing.write_text(tmp_path / "a.txt", "new")
    assert done == [False, "named", True]


def test_permissions_stay_and_new_files_have_the_usual_ones(tmp_path):
    path, usual = tmp_path / "a.txt", tmp_path / "b.txt"
    writing.write_text(path, "old")
    usual.write_text("made by open")
    assert path.stat().st_mode == usual.stat().st_mode
    path.chmod(0o640)
    writing.write_text(path, "new")
    assert stat.S_IMODE(path.stat().st_mode) == 0o640


def test_links_go_on_leading_to_the_file(tmp_path):
    (tmp_path / "there").mkdir()
    real, link = tmp_path / "there" / "a", tmp_path / "link.txt"
    link.symlink_to(real)
    for content in ("first", "second"):  # the link leads nowhere at first
        with writing.new_file(link) as new:
            assert (new.parent, new.suffix) == (real.parent, ".txt")
            new.write_text(content)
        assert link.is_symlink()
        assert text_of(real) == content
    assert len(list(tmp_path.iterdir())) == 2


def test_devices_are_written_in_place():
    writing.write_text(os.devnull, "nothing")
    assert stat.S_ISCHR(os.stat(os.devnull).st_mode)
    with pytest.raises(OSError, match="'/dev/full' could not be written: No space left on device"):
        writing.write_text("/dev/full", "something")


@pytest.mark.parametrize(
    ("name", "kind", "words"),
    [
        ("no/a.txt", FileNotFoundError, "There is no folder '.*no' to write '.*' into: make it first"),
        ("folder", IsADirectoryError, "is a folder: give the name of a file"),
        ("file/a.txt", FileNotFoundError, "There is no folder"),
        ("loop", OSError, "loop' could not be written: Too many levels of symbolic links"),
        ("x" * 300, OSError, "could not be written: File name too long"),
    ],
)
def test_places_that_cannot_be_written(tmp_path, name, kind, words):
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("old")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    with pytest.raises(kind, match=words) as caught:
        writing.write_text(tmp_path / name, "new")
    assert type(caught.value) is kind
    assert sorted(each.name for each in tmp_path.iterdir()) == ["file", "folder", "loop"]


def test_a_long_name_is_written(tmp_path):
    writing.write_text(tmp_path / ("x" * 251 + ".txt"), "new")


def test_read_only_places_are_left_alone(tmp_path, monkeypatch):
    path = tmp_path / "a.txt"
    writing.write_text(path, "old")
    for refused, words in ((path, "The file '.*a.txt' is read-only"), (tmp_path, "The folder '.*' is read-only")):
        monkeypatch.setattr(os, "access", lambda place, mode, no=refused: Path(place) != no)
        with pytest.raises(PermissionError, match=words):
            writing.write_text(path, "new")
    assert text_of(path) == "old"


WITHIN = ("new", "memory")


def other_ways(source):
    """Calls in a module that write a file, and not one that ``writing`` gave as ``new``, or memory."""
    found = []
    for call in ast.walk(ast.parse(source.read_text(encoding="utf-8"))):
        if not isinstance(call, ast.Call):
            continue
        name, first = ast.unparse(call.func), ast.unparse(call.args[0]) if call.args else ""
        owner, _, method = name.rpartition(".")
        words = {each.value for each in call.args if isinstance(each, ast.Constant)}
        if (
            (method in ("write_text", "write_bytes") and owner not in ("", "new"))
            or (method in ("save", "savefig", "tofile", "to_csv") and owner not in ("", "figures") and first not in WITHIN)
            or (
                (method in ("open", "File") and words & {"w", "wb", "a", "ab", "x", "r+", "w+"})
                and not {owner, first} & set(WITHIN)
            )
            or name in ("os.replace", "os.rename", "shutil.move", "shutil.copy")
        ):
            found.append(name)
    return found


@pytest.mark.long
def test_no_other_way_is_used():
    """But for files that grow: run files are made under another name, in ``run_file``, and named by ``writing``, and the
    list of a study's runs gets lines."""
    package = Path(lm.__file__).parent
    ways = {source.relative_to(package).as_posix(): other_ways(source) for source in package.rglob("*.py")}
    found = {name: calls for name, calls in ways.items() if calls}
    assert found.pop("writing.py") == ["os.replace"]
    assert found.pop("io/run_file/creation.py") == ["Path(path).write_bytes", "Path(copied).write_bytes"]
    assert found.pop("experiment/study/folder.py") == ["self.file.open"]
    assert not found


# ------------------------------------------------------------------------------------------------------------- full disk

BEGIN = """
    import os, resource, signal, sys
    from pathlib import Path
    import numpy as np
    import scipy.sparse as sparse
    import lmgcpy as lm
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    folder = Path(sys.argv[1])

    def limit(size):
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))

    def names():
        return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())

    def refused(path, make, size):
        before = {name: (folder / name).read_bytes() for name in names()}
        limit(size)
        try:
            make()
        except OSError as error:
            limit(resource.RLIM_INFINITY)
            assert f"'{path}' could not be written: " in str(error), error
            assert str(error).endswith("Make room, or give another path."), error
        else:
            raise AssertionError("it was written")
        assert {name: (folder / name).read_bytes() for name in names()} == before, (names(), sorted(before))

    def problem(count):
        rest = np.zeros(count), np.zeros((count, 2))
        return lm.Problem(sparse.eye_array(2 * count), -np.ones(2 * count), np.ones(count), 2, ("coulomb",) * count, *rest)

    def run():
        scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
        disks = [scene.add(lm.disk(radius=0.1, position=(0.3 * i, 0.1), mass=1.0)) for i in range(20)]
        scene.chain(disks, lm.RigidWire())
        scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
        scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
        lm.Simulation(scene, time_step=1e-3).run(steps=30, record=folder / "run.h5", every=3, force=True)
        return lm.io.open_run(folder / "run.h5")
"""


def child(code, folder):
    forked(textwrap.dedent(BEGIN) + textwrap.dedent(code), folder, strict=False)


def test_a_problem_that_finds_no_room_leaves_the_old_one(tmp_path):
    child(
        """
        path = folder / "p.h5"
        refused(path, lambda: lm.io.fclib.write(problem(50), path), 4000)
        lm.io.fclib.write(problem(3), path)
        for size in (0, 100, 3000, 9000):
            refused(path, lambda: lm.io.fclib.write(problem(200), path, force=True), size)
        assert len(lm.io.fclib.read(path).mu) == 3
        """,
        tmp_path,
    )


def test_tables_and_vtk_name_the_file(tmp_path):
    pytest.importorskip("vtkmodules")
    child(
        """
        recorded = run()
        for export, first in ((lm.io.export_csv, "bodies.csv"), (lm.view.export_vtk, "bodies-00000.vtp")):
            out = folder / first[-3:]
            for size in (0, 300):
                refused(out / first, lambda: export(recorded, out, force=True), size)
                assert not list(out.iterdir())
            written = export(recorded, out, force=True)
            refused(out / first, lambda: export(recorded, out, force=True), 300)
        """,
        tmp_path,
    )


@pytest.mark.long
def test_pictures_leave_the_old_one(tmp_path):
    child(
        """
        recorded = run()
        for suffix in (".png", ".svg", ".pdf"):
            path = folder / f"curves{suffix}"
            lm.view.plot(recorded, path, what="solver")
            refused(path, lambda: lm.view.plot(recorded, path, what="energy"), 1000)
        from lmgcpy.view.pictures import _write_png
        path = folder / "picture.png"
        _write_png(np.zeros((50, 50, 3), np.uint8), path)
        noise = np.random.default_rng(0).integers(0, 255, (50, 50, 3)).astype(np.uint8)
        refused(path, lambda: _write_png(noise, path), 1000)
        """,
        tmp_path,
    )


def test_a_plugin_that_finds_no_room_can_be_begun_again(tmp_path):
    child(
        """
        from lmgcpy.plugin_template import write_plugin
        path = folder / "lmgcpy-law-mine" / "pyproject.toml"
        refused(path, lambda: write_plugin("mine", folder), 100)
        assert not list(folder.iterdir())
        write_plugin("mine", folder)
        """,
        tmp_path,
    )


def test_a_study_that_finds_no_room_leaves_the_former_one(tmp_path):
    """Its runs are taken away only when the new study is on the disk."""
    child(
        """
        from dataclasses import dataclass
        from lmgcpy.experiment.study.folder import StudyFolder

        @dataclass(frozen=True)
        class Study:
            text: str
            COMMAND = "test"
            FORMER = {}
            def kind(self):
                return {}
            @classmethod
            def class_of(cls, about):
                return cls

        kept = StudyFolder(folder, Study)
        kept.begin(Study("first"))
        run().close()
        kept.run_names.enter("one", kept.run_file("one"))
        os.replace(folder / "run.h5", kept.run_file("one"))
        kept.summary.write_text("done")
        refused(kept.study_file, lambda: kept.begin(Study("second" * 1000)), 500)
        assert kept.read() == Study("first") and kept.run_file("one").exists() and kept.summary.exists()
        kept.begin(Study("second"))
        assert names() == ["study.json"]
        """,
        tmp_path,
    )
