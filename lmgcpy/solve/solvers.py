"""Solvers by the names that the command line knows them by."""

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
