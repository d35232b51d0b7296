"""``lmgcpy fields``: coarse-grained fields of a frame of a run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from lmgcpy.cli.view import FILE, Plane, Region
from lmgcpy.writing import check_target


@click.command()
@click.argument("file", type=FILE)
@click.option("--width", type=float, required=True, help="Width of the Gaussian [m]: one or two diameters of a grain.")
@click.option("--spacing", type=float, help="Spacing of the grid [m]; otherwise the width.")
@click.option("--region", type=Region(), help="Corners of the grid [m]: x,y,x,y or x,y,z,x,y,z; otherwise all bodies.")
@click.option("--frame", type=int, default=-1, help="Number of the frame; negative: from the end.")
@click.option("--what", help="Field of a picture: density, solid-fraction, velocity, pressure or shear [default: density].")
@click.option("--cut", type=Plane(), help="Section of a picture in 3D: y, or y=0.1 [default: y, half-way].")
@click.option("--out", type=FILE, required=True, help="A .png, .svg or .pdf picture, .vti for ParaView, or .npz for numpy.")
@click.option("--force", is_flag=True, help="Replace a file.")
def fields(
    file: Path,
    width: float,
    spacing: float | None,
    region: Any,
    frame: int,
    what: str | None,
    cut: Any,
    out: Path,
    force: bool,
) -> None:
    """Smooth a frame of a run into fields: density, velocity, pressure and shear at the points of a grid.

    Each grain is spread by a Gaussian. The measure is lmgcpy.measure.coarse_fields.
    """
    import numpy as np

    from lmgcpy.io.run import open_run
    from lmgcpy.measure.fields import coarse_fields
    from lmgcpy.view.curves import SUFFIXES
    from lmgcpy.view.fields import draw_fields, export_fields
    from lmgcpy.writing import new_file

    suffix = out.suffix.lower()
    drawn = suffix in SUFFIXES
    if not drawn and suffix not in (".vti", ".npz"):
        raise ValueError(f"--out must end in {', '.join(SUFFIXES)}, .vti or .npz, got '{out}'.")
    if not drawn and (what or cut):
        raise ValueError(f"--{'what' if what else 'cut'} is for pictures: a {suffix} file holds all fields.")
    check_target(out, force=force, name="--out", instead="give another name by --out, or --force to replace it")
    with open_run(file) as run:
        found = coarse_fields(run, width=width, spacing=spacing, region=region, frame=frame)
    if drawn:
        draw_fields(found, out, what=what or "density", cut=cut)
    elif suffix == ".vti":
        export_fields(found, out, force=force)
    else:
        names = "density", "solid_fraction", "momentum", "velocity", "contact_stress", "kinetic_stress", "wall_force"
        with new_file(out) as new, new.open("wb") as file_of_arrays:
            arrays = {name: getattr(found, name) for name in names}
            np.savez(file_of_arrays, points=found.points, width=found.width, **arrays)
    click.echo(out)
