"""The solvers that come with lmgcpy, by name."""

from __future__ import annotations

from lmgcpy.solve.accelerated import AcceleratedGaussSeidel
from lmgcpy.solve.gauss_seidel import GaussSeidel
from lmgcpy.solve.newton.alternating import Auto, Newton

AnySolver = GaussSeidel | AcceleratedGaussSeidel | Newton | Auto

SOLVERS: dict[str, type[AnySolver]] = {
    "gauss-seidel": GaussSeidel,
    "accelerated": AcceleratedGaussSeidel,
    "newton": Newton,
    "auto": Auto,
}
"""By the names of the command line."""
BY_CLASS: dict[str, type[AnySolver]] = {solver.__name__: solver for solver in SOLVERS.values()}
"""By the names of their classes, as files name them."""
