"""The continuous model of wire-reinforced sand: a sand, a network of wires that only pull, and paths of both."""

from lmgcpy.continuum.directions import (
    Directions,
    choose_count,
    in_plane,
    isotropic,
    layers,
    of_links,
    quadrature_error,
)
from lmgcpy.continuum.fit import MeasuredCompression, SandFit, fit_sand
from lmgcpy.continuum.mohr_coulomb import MohrCoulomb
from lmgcpy.continuum.path import DrivenPath, NoSolution, biaxial, drive, triaxial
from lmgcpy.continuum.sand import DruckerPrager, Sand, SandResponse
from lmgcpy.continuum.spans import Spans, spans_of
from lmgcpy.continuum.tensors import mandel, tensor_of, turn
from lmgcpy.continuum.texsol import PointResponse, PointState, TexSol
from lmgcpy.continuum.wire import GrowingAnchorage, WireNetwork, WireResponse

__all__ = [
    "Directions",
    "DrivenPath",
    "DruckerPrager",
    "GrowingAnchorage",
    "MeasuredCompression",
    "MohrCoulomb",
    "NoSolution",
    "PointResponse",
    "PointState",
    "Sand",
    "SandFit",
    "SandResponse",
    "Spans",
    "TexSol",
    "WireNetwork",
    "WireResponse",
    "biaxial",
    "choose_count",
    "drive",
    "fit_sand",
    "in_plane",
    "isotropic",
    "layers",
    "mandel",
    "of_links",
    "quadrature_error",
    "spans_of",
    "tensor_of",
    "triaxial",
    "turn",
]


def __dir__() -> list[str]:
    return __all__
