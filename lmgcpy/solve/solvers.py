"""The solvers that come with lmgcpy, by name."""

from __future__ import annotations

from lmgcpy.solve.newton.alternating import Auto, Newton
from lmgcpy.solve.sweeps.accelerated import AcceleratedGaussSeidel
from lmgcpy.solve.sweeps.gauss_seidel import GaussSeidel

AnySolver = GaussSeidel | AcceleratedGaussSeidel | Newton | Auto

SOLVERS: dict[str, type[AnySolver]] = {
    "gauss-seidel": GaussSeidel,
    "accelerated": AcceleratedGaussSeidel,
    "newton": Newton,
    "auto": Auto,
}
"""Solvers by their names on the command line."""
BY_CLASS: dict[str, type[AnySolver]] = {solver.__name__: solver for solver in SOLVERS.values()}
"""Solvers by the names of their classes, as in files."""
