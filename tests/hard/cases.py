"""All hard cases, in the order of the table."""

from __future__ import annotations

import compaction
import light
import limits
import nets
import stacks
import taut
import whips
import wires
from case import Case

TWO = ("Newton", "Auto")

CASES = [
    Case(
        "rigid wire thrown taut by a heavy tip",
        wires.thrown,
        tolerance=1e-10,
        others="tensions 87 to 89 % wrong",
        long=True,
    ),
    Case(
        "elastic wire, h²k/m from 1e-4 to 1e10",
        wires.elastic,
        tolerance=1e-12,
        others="explode (the paper's)",
        long=True,
    ),
    Case("capstan", wires.capstan, tolerance=1e-10, fails={"GaussSeidel": "at mu = 1 it stagnates at 1e-3"}),
    Case("whip of tapered rods", wires.whip, tolerance=1e-12, long=True),
    Case("pendulum of ten rods", wires.pendulum, tolerance=1e-12, long=True),
    Case(
        "mass dropped on a taut wire",
        taut.dropped,
        tolerance=1e-8,
        long=True,
        without="the wire grows to four times its length",
    ),
    Case("straight line between posts", taut.straight, tolerance=1e-8, long=True),
    Case(
        "capstan in motion",
        taut.dragged,
        tolerance=1e-8,
        long=True,
        solvers=TWO,
        without="the weight falls almost freely",
    ),
    Case(
        "Atwood's machine on a smooth drum",
        taut.atwood,
        tolerance=1e-8,
        long=True,
        solvers=TWO,
        without="the weight falls almost freely",
    ),
    Case(
        "wire over three pegs",
        taut.pegs,
        tolerance=1e-8,
        long=True,
        solvers=TWO,
        without="the blocks fall",
    ),
    Case(
        "bungee",
        whips.bungee,
        tolerance=1e-8,
        long=True,
        without="the wire stretches without end",
    ),
    Case(
        "bungee on a stiff wire",
        whips.stiff_bungee,
        tolerance=1e-8,
        long=True,
        says=("In the step",),
        without="the mass falls on and on",
    ),
    Case("folded chain", whips.folded, tolerance=1e-8, long=True, says=("In the step",)),
    Case("crack of a whip", whips.crack, tolerance=1e-8, long=True, says=("In the step",)),
    Case(
        "spinning string with heavy ends",
        whips.spinning,
        tolerance=1e-8,
        long=True,
        without="it makes as much energy as it has",
    ),
    Case(
        "ball on a net",
        nets.ball_on_net,
        tolerance=1e-8,
        long=True,
        solvers=TWO,
        without="the ball falls through",
    ),
    Case(
        "spheres on a net",
        nets.spheres_on_net,
        tolerance=1e-4,
        long=True,
        solvers=TWO,
        without="the wires make energy",
    ),
    Case("light wire that friction holds", light.squeezed, tolerance=1e-2, long=True),
    Case(
        "wire of a millionth torn off",
        light.torn_off,
        tolerance=1e-2,
        long=True,
        solvers=("Auto",),
    ),
    Case("light wire drawn through a pack", light.through_pack, tolerance=1e-4, long=True),
    Case(
        "light wire drawn through a pack, to 1e-2",
        light.through_pack_roughly,
        tolerance=1e-2,
        fails=dict.fromkeys(("GaussSeidel", "Newton", "Auto"), "rows go along with the wire, which takes 0.3 of the force"),
    ),
    Case("light bead between grains pulled apart", light.pulled_apart, tolerance=1e-8, long=True),
    Case(
        "light tetherball",
        light.tetherball,
        tolerance=1e-6,
        fails={"GaussSeidel": "a third of its steps are unsolved, and make a quarter of the energy"},
        long=True,
        says=("In the step", "Until t"),
    ),
    Case(
        "column of spheres under 1e4 times its mass",
        stacks.column,
        tolerance=1e-8,
        fails={"GaussSeidel": "it stagnates at 0.1"},
    ),
    Case("disk in a wedge", stacks.wedge, tolerance=1e-8),
    Case("arch of stones", stacks.arch, tolerance=1e-9),
    Case(
        "boulder on grains of a thousandth",
        stacks.boulder,
        tolerance=1e-8,
        fails={"GaussSeidel": "it stagnates: a billionth of the way a sweep"},
    ),
    Case("column crushed between plates", limits.crushed, tolerance=1e-6),
    Case("friction 0, 0.3 and 10", limits.friction_of_any_size, tolerance=1e-10),
    Case("over-determined wheel of rods", limits.wheel, tolerance=1e-10, long=True),
    Case("column of rods in a sample", limits.rod_column, tolerance=1e-9, others="reaction jumps (the paper's)"),
    Case("degenerate geometry", limits.degenerate, tolerance=1e-10),
    Case("microns to kilometres", limits.units, tolerance=1e-12, long=True),
    Case(
        "compaction of 10 000 spheres, smooth",
        compaction.smooth,
        tolerance=1e-8,
        fails={"GaussSeidel": "its 10 000 sweeps leave 2e-7"},
        others="LMGC90: 2 321 sweeps to 1e-4, 1e-6 not in 3 000",
    ),
    Case(
        "compaction of 150 spheres, friction 0.3",
        compaction.rough,
        tolerance=1e-8,
        fails={"GaussSeidel": "its 10 000 sweeps leave 2e-4", "Newton": "ends at 3e-6; Auto goes on"},
    ),
]
