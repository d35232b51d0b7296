"""A thread that slides over half of a fixed drum, for the tests of its contacts and of its measures."""

import numpy as np

import lmgcpy as lm


def over_a_drum(d, count, *, friction, mass, tolerance):
    """``count`` segments around a drum of 0.1 m, the thread 2 mm thick, drawn down at its last node and held at its first
    with 1 N."""
    scene = lm.Scene(dimension=d)
    radius, drum, dphi = 2e-3, 0.1, np.pi / count
    rho = (drum + radius) / np.cos(0.5 * dphi)  # segments touch in their middles
    length = 2.0 * rho * np.sin(0.5 * dphi)
    angles = np.linspace(np.pi, 0.0, count + 1)
    arc = rho * np.column_stack([np.cos(angles), np.sin(angles)])
    down = np.column_stack([np.zeros(4), -length * np.arange(4, 0, -1)])
    flat = np.concatenate([arc[0] + down, arc, arc[-1] + down[::-1]])
    places = flat if d == 2 else np.insert(flat, 1, 0.0, axis=1)
    nodes = [scene.add(lm.point_mass(position=place, mass=mass)) for place in places]
    scene.chain(nodes, lm.RigidWire(), surface=lm.Thread(radius))
    scene.add((lm.disk if d == 2 else lm.sphere)(radius=drum, position=(0.0,) * d, mass=1.0)).fix()
    scene.see("GRAIN", "THREAD", lm.Coulomb(friction=friction))
    vertical = "y" if d == 2 else "z"
    nodes[0].fix("x").impose_force(**{vertical: -1.0})
    nodes[-1].impose_velocity(**{vertical: -0.02, "x": 0.0})
    if d == 3:
        for node in nodes:
            node.fix("y")
    return lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=tolerance))


def ratio_of_tensions(sim, steps=150, from_step=50):
    """Mean over the last steps of the tension of the last link of a wire over that of the first."""
    found = []
    for _ in range(steps):
        sim.step()
        tension = sim.interactions.force[sim.interactions.law == "rigid-wire", 0]
        found.append(tension[-1] / tension[0])
    return np.mean(found[from_step:])
