"""What the frontier writes into its folder: tables, figures, and a page that shows them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import asdict, fields
from datetime import UTC, datetime
from pathlib import Path

from lmgcpy.bench.figures import performance_profiles, work_precision
from lmgcpy.bench.frontier import Judged, Run
from lmgcpy.bench.machine import load, machine
from lmgcpy.bench.profile import OVERHEAD, SMALLEST, Profile, profile
from lmgcpy.bench.reference import APART, ENOUGH, MARGIN, Reference
from lmgcpy.view.figures import save
from lmgcpy.writing import make_folder, write_table, write_text

TARGETS = (1e-2, 1e-4, 1e-6)
"""True errors of the tables and profiles."""
PAGE = "frontier.md"


def write_report(
    judged: Sequence[Judged], left_out: Sequence[str], solvers: Sequence[str], folder: Path, load_before: str
) -> list[Path]:
    """Write ``runs.csv``, ``references.csv``, the figures and the page; returns their paths, the page last."""
    make_folder(folder)
    paths = [runs_table(judged, folder / "runs.csv"), references_table(judged, folder / "references.csv")]
    pictures = []
    for family in dict.fromkeys(problem.family for problem in judged):
        picture = folder / f"work-{re.sub(r'[^A-Za-z0-9]+', '-', family).strip('-')}.png"
        save(work_precision([problem for problem in judged if problem.family == family], solvers), picture)
        pictures.append((family, picture))
    profiles = [each for each in (profile(judged, solvers, target) for target in TARGETS) if each.problems]
    if profiles:
        save(performance_profiles(profiles), folder / "profiles.png")
        paths.append(folder / "profiles.png")
    page = folder / PAGE
    lines = ["# Speed against error", "", *conditions(load_before), "", *how_to_read(left_out), ""]
    if profiles:
        lines += ["## Performance profiles", "", profile_words(), "", "![profiles](profiles.png)", ""]
        lines += [*profile_rows(profiles, solvers), ""]
    for family, picture in pictures:
        lines += [
            f"## {family}",
            "",
            f"![work and precision]({picture.name})",
            "",
            *family_rows(judged, family, solvers),
            "",
        ]
    write_text(page, "\n".join(lines))
    return [*paths, *(picture for _, picture in pictures), page]


def conditions(load_before: str) -> list[str]:
    return [
        f"{machine()}. {datetime.now(UTC):%Y-%m-%d}. Load of the machine when it began {load_before}, when it ended "
        f"{load()}: where it is above 1, times are longer than on an idle machine, and only their ratios say something."
    ]


def how_to_read(left_out: Sequence[str]) -> list[str]:
    """What the numbers mean, in words."""
    lines = [
        "An error is that of the relative velocities, |u - u_ref| / |q - u_ref|: 1 is the error of doing nothing. Each "
        "problem has two references, found in different ways; their distance is in the tables, and errors below "
        f"{MARGIN:g} times this distance are not judged: in a table they are told as reached where the error asked for is "
        'above it, and with "?" otherwise; in a figure they lie in the shaded part. Times are of the solver alone, warm, '
        "from the guess that came with the problem; hollow marks are runs that missed their tolerance. Every run is in "
        "runs.csv, every reference in references.csv. With friction a problem may have several solutions: whatever "
        f"solves it to a residual of {ENOUGH:g} is one; where several were found the table says so, an error is the "
        f"distance to the nearest of them, and errors are judged above {MARGIN * APART:g}."
    ]
    if left_out:
        lines += ["", f"Left out, as no impulse changes anything in them: {', '.join(left_out)}."]
    return lines


def profile_words() -> str:
    return (
        "Part of the problems on which a solver reaches the error within so many times the time of the fastest one. "
        f"Problems with fewer than {SMALLEST} interactions, and those whose references do not tell such an error, are left "
        f"out; times below {1e3 * OVERHEAD:g} ms count as that."
    )


def profile_rows(profiles: Sequence[Profile], solvers: Sequence[str]) -> list[str]:
    rows = []
    for each in profiles:
        told = [
            f"{100 * each.share(name, 1.0):.0f} % / {100 * each.share(name, 2.0):.0f} % / {each.failures(name)}"
            for name in solvers
        ]
        rows.append([f"{each.target:g}", str(each.problems), str(each.unsolved), *told])
    heads = ["error", "problems", "solved by none", *(f"{name}: fastest / within twice / failures" for name in solvers)]
    return table(heads, rows)


def family_rows(judged: Sequence[Judged], family: str, solvers: Sequence[str]) -> list[str]:
    """A line a problem: its references, and the time to each error."""
    rows = []
    for problem in judged:
        if problem.family != family:
            continue
        reference = problem.reference
        cells = [" / ".join(cell(problem, name, target) for target in TARGETS) for name in solvers]
        size = f"{problem.interactions} ({problem.dimension}D)"
        rows.append([problem.name, size, " and ".join(reference.ways), distance_cell(reference), *cells])
    targets = " / ".join(f"{target:g}" for target in TARGETS)
    return table(
        ["problem", "interactions", "references", "distance", *(f"{name}: s to {targets}" for name in solvers)], rows
    )


def distance_cell(reference: Reference) -> str:
    """How far apart the references are, and how many solutions were found."""
    several = f" ({len(reference.solutions)} solutions)" if len(reference.solutions) > 1 else ""
    return f"{reference.distance:.0e}{several}"


def cell(problem: Judged, solver: str, target: float) -> str:
    """Seconds to an error; "-" where it was not reached, "?" where the references do not tell."""
    if problem.reference.floor > target:
        return "?"
    run = problem.best(solver, target)
    return "-" if run is None else f"{run.seconds:.2g}"


def table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Lines of Markdown."""
    return ["| " + " | ".join(heads) + " |", "|---" * len(heads) + "|", *("| " + " | ".join(row) + " |" for row in rows)]


def runs_table(judged: Sequence[Judged], path: Path) -> Path:
    """Every run."""
    own = [field.name for field in fields(Run) if field.name != "problem"]
    rows = []
    for problem in judged:
        for run in problem.runs:
            values = [asdict(run)[name] for name in own]
            told = "yes" if run.error > problem.reference.floor else "no"
            rows.append([problem.name, problem.family, problem.dimension, problem.interactions, *values, told])
    write_table(path, ["problem", "family", "dimension", "interactions", *own, "judged"], rows)
    return path


def references_table(judged: Sequence[Judged], path: Path) -> Path:
    """Every reference."""
    rows = []
    for problem in judged:
        told = problem.reference
        pairs = [part for pair in zip(told.ways, told.residuals, strict=True) for part in pair]
        rows.append([problem.name, *pairs, told.distance, told.scale])
    write_table(path, ["problem", "first", "its residual", "second", "its residual", "distance", "scale [m/s]"], rows)
    return path
