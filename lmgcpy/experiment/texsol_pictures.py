"""The pictures of a 3D study, after figures 6 and 7 of the paper, from its run files by pyvista."""

from __future__ import annotations

from contextlib import ExitStack

from lmgcpy.experiment.report_files import ReportFolder
from lmgcpy.experiment.texsol_folder import StudyFolder
from lmgcpy.experiment.texsol_tests import Result
from lmgcpy.io.run import open_run


def draw_pictures(result: Result, folder: StudyFolder, report: ReportFolder) -> str:
    """Draw wire layout, sample and force chains; returns the sentence why there are none, or nothing."""
    try:
        import pyvista  # noqa: F401
    except ImportError:
        return 'There are no pictures of the sample, as pyvista is not installed: pip install "lmgcpy[view]" brings it.'
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
