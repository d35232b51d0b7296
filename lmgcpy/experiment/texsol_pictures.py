"""The pictures of a study by pyvista: in 2D after figures 3 and 4 of the paper, in 3D after figures 6 and 7."""

from __future__ import annotations

from contextlib import ExitStack

from lmgcpy.experiment.report_files import ReportFolder
from lmgcpy.experiment.texsol_2d import frames_at_equal_force
from lmgcpy.experiment.texsol_folder import StudyFolder
from lmgcpy.experiment.texsol_tests import Result
from lmgcpy.io.run import open_run


def reason_without_pictures() -> str:
    """A sentence that says why there can be no pictures of the sample, or nothing."""
    try:
        import pyvista  # noqa: F401
    except ImportError:
        return 'There are no pictures of the sample, as pyvista is not installed: pip install "lmgcpy[view]" brings it.'
    from lmgcpy.view.painter import NoOpenGL, Painter

    try:
        Painter(off_screen=True).close()
    except NoOpenGL as error:
        return f"There are no pictures of the sample. {error}"
    return ""


def draw_flat_pictures(result: Result, report: ReportFolder) -> str:
    """Draw the sample, and force chains of each test with a wire beside those of the sand.

    Returns the sentence that says why there are no pictures, or nothing.
    """
    reason = reason_without_pictures()
    if reason:
        return reason
    from lmgcpy.view.figures import name_of
    from lmgcpy.view.force_chains import draw_chains, draw_sample

    sample, sand = result.sample, result.records.get("none")
    draw_sample(report.file("sample.png"), sample)
    for law, record in result.records.items():
        if law != "none" and sand is not None:
            with_wire, without = frames_at_equal_force(record, sand)
            path = report.file(f"chains-{law}.png")
            draw_chains(path, (name_of(law), with_wire), ("sand", without), sample.radii, sample.bead_count)
    return ""


def draw_pictures(result: Result, folder: StudyFolder, report: ReportFolder) -> str:
    """Draw wire layout, sample and force chains; returns the sentence why there are none, or nothing."""
    reason = reason_without_pictures()
    if reason:
        return reason
    import lmgcpy.view as view

    with ExitStack() as stack:
        relaxation = stack.enter_context(open_run(folder.run_file("compaction")))
        if result.sample.wires:
            view.render(
                relaxation,
                report.file("wire.png"),
                what="layout",
                frame=0,
                grains="hidden",
                wires="length",
                camera=["isometric", "x"],
                title=["wire as laid", "seen along x"],
            )
            view.render(
                relaxation,
                report.file("sample.png"),
                what="layout",
                frame=-1,
                grains=["hidden", "plain"],
                wires="layer",
                clip=[None, "y"],
                opacity=1.0,
                title=["wire in the compacted sample", "the same with its grains, cut open"],
            )
        for axis in result.study.axes:
            names = [f"{law}-{axis}" for law in result.study.laws]
            runs = [stack.enter_context(open_run(folder.run_file(name))) for name in names]
            titles = ["sand" if law == "none" else law.replace("-", " ") for law in result.study.laws]
            percent = f"{100.0 * result.study.strain:g} % along {axis}"
            view.render(
                runs,
                report.file(f"chains-{axis}.png"),
                what="forces",
                grains="hidden",
                camera="y",
                title=[f"{name} at {percent}" for name in titles],
            )
    return ""
