"""Samples: gradings, wires laid by random walks, deposits of grains around them, fibres, deposits of clumps."""

from lmgcpy.sample.deposit import deposit, deposit_bodies
from lmgcpy.sample.fibres import Fibres, fibres, join_segments
from lmgcpy.sample.grading import grading
from lmgcpy.sample.loose import grid_positions, scatter
from lmgcpy.sample.surfaces import Cells, membrane_around, net
from lmgcpy.sample.wire_2d import wire_2d
from lmgcpy.sample.wire_3d import wire_3d
from lmgcpy.sample.wires import Wire, Wires, axial_rigidity, bead_count, bead_mass, wire_content, wire_length

__all__ = [
    "Cells",
    "Fibres",
    "Wire",
    "Wires",
    "axial_rigidity",
    "bead_count",
    "bead_mass",
    "deposit",
    "deposit_bodies",
    "fibres",
    "grading",
    "grid_positions",
    "join_segments",
    "membrane_around",
    "net",
    "scatter",
    "wire_2d",
    "wire_3d",
    "wire_content",
    "wire_length",
]


def __dir__() -> list[str]:
    return __all__
