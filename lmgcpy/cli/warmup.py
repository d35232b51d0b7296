"""The command ``lmgcpy warmup``."""

from __future__ import annotations

import os
import time as clock

import click

from lmgcpy import laws as registry
from lmgcpy.cli.options import CommaList
from lmgcpy.compiled.cache import CacheWarning, cache_directory
from lmgcpy.compiled.mode import INTERPRETED
from lmgcpy.experiment.study.stages import Stages
from lmgcpy.warmup import warm_up


@click.command()
@click.option(
    "--laws",
    type=CommaList(str, "coulomb,rigid-wire"),
    default="",
    help="Laws to compile, separated by commas; otherwise all registered laws.",
)
@click.option("--dimension", type=click.Choice(["2", "3"]), help="Dimension to compile; otherwise both.")
@click.option(
    "--workers",
    type=click.IntRange(min=1),
    default=lambda: os.cpu_count() or 1,
    show_default="the number of processors",
    help="Processes that share the work.",
)
def warmup(laws: tuple[str, ...], dimension: str | None, workers: int) -> None:
    """Compile the kernels that scenes need, so that the first run need not wait.

    The command compiles every law with every pair of contactors and every solver, with and without threads, the samples,
    and problems of one step. It keeps the kernels in the cache. LMGCPY_CACHE_DIR names the folder of the cache; otherwise
    it lies in the user's cache directory.
    """
    if INTERPRETED:
        raise RuntimeError("With NUMBA_DISABLE_JIT set nothing is compiled: unset it to fill the cache.")
    dimensions = [int(dimension)] if dimension else [2, 3]
    chosen = [registry.get(name) for name in laws or registry.names()]
    begin = clock.perf_counter()
    try:
        with Stages().stage("warmup", (len(chosen) + 1) * len(dimensions)) as tick:
            failures, found = warm_up(chosen, dimensions, tick, workers)
    except CacheWarning as warning:
        raise OSError(str(warning)) from warning
    compiled = {kernel for one in found for kernel in one.compiled}
    there = {kernel for one in found for kernel in one.loaded} - compiled  # some laws share kernels
    click.echo(
        f"{len(compiled) + len(there)} kernels in {cache_directory()}: {len(compiled)} compiled, {len(there)} were there; "
        f"{clock.perf_counter() - begin:.1f} s."
    )
    if failures:
        name, cause = next(iter(failures.items()))
        raise RuntimeError(
            f"Kernels of {', '.join(failures)} could not be compiled. Why: lmgcpy --traceback warmup --laws {name} "
            "--workers 1"
        ) from cause
