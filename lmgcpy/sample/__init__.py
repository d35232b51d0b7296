"""Samples: gradings, wires laid by random walks, and deposits of grains around them."""

from lmgcpy.sample.deposit import deposit
from lmgcpy.sample.grading import grading
from lmgcpy.sample.grid import grid_positions
from lmgcpy.sample.wire import Wire
from lmgcpy.sample.wire_2d import wire_2d

__all__ = ["Wire", "deposit", "grading", "grid_positions", "wire_2d"]
