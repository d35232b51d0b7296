"""A rigid wire of light beads, each squeezed between two heavy grains, pulled at one end."""

import lmgcpy as lm

RADIUS = 0.01
"""Of a bead [m]."""
FRICTION, SQUEEZE = 0.4, 100.0


def squeezed_wire(ratio, pull, *, dimension=2, law=None, count=20):
    """(scene, beads). Grains of 1 kg weigh ``ratio`` times as much as a bead and press with 100 N; the last bead is pulled
    with ``pull`` times what friction holds, 2 mu N on every bead."""

    def at(x, height):
        return (x, height) if dimension == 2 else (x, 0.0, height)

    scene = lm.Scene(dimension=dimension)
    make = lm.disk if dimension == 2 else lm.sphere
    beads = []
    for i in range(count):
        beads.append(scene.add(make(radius=RADIUS, position=at(0.05 * i, 0.0), mass=1.0 / ratio, color="BEAD")))
        for side in (1, -1):
            grain = scene.add(make(radius=0.02, position=at(0.05 * i, 0.03 * side), mass=1.0))
            if dimension == 2:
                grain.fix("x", "spin")
                grain.impose_force(y=-SQUEEZE * side)
            else:
                grain.fix("x", "y", "spin_x", "spin_y", "spin_z")
                grain.impose_force(z=-SQUEEZE * side)
    scene.chain(beads, law or lm.RigidWire(), block_spin=True)
    beads[-1].impose_force(x=pull * 2.0 * FRICTION * SQUEEZE * count)
    scene.see("BEAD", "GRAIN", lm.Coulomb(friction=FRICTION))
    return scene, beads


def way(scene, beads, time_step, solver, steps):
    """Way of the pulled bead, and the longest way of any body, in radii of a bead; and the simulation."""
    sim = lm.Simulation(scene, time_step=time_step, solver=solver)
    start = sim.positions.copy()
    sim.run(steps=steps)
    moved = sim.positions - start
    return moved[beads[-1].id, 0] / RADIUS, abs(moved).max() / RADIUS, sim
