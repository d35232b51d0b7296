"""A thread that is drawn out between pressed grains: 2 mu N for each pair."""

import numpy as np
import lmgcpy as lm

mu, press, load = 0.3, 2.0, 0.1  # friction, force on each grain and at the far end [N]
scene = lm.Scene(dimension=3)
places = [(0.01 * k, 0.0, 0.0) for k in range(26)]
nodes = [scene.add(lm.point_mass(position=at, mass=1e-5)).fix("z") for at in places]
scene.chain(nodes, lm.RigidWire(), surface=lm.Thread(radius=0.001))
for x in np.linspace(0.05, 0.2, 10):
    for side in (-1.0, 1.0):
        at = (x, 0.0, 0.006 * side)
        grain = scene.add(lm.sphere(radius=0.005, position=at, mass=1e-4))
        grain.fix("x", "y", "spin_x", "spin_y", "spin_z").impose_force(z=-press * side)
scene.see("GRAIN", "THREAD", lm.Coulomb(friction=mu))
nodes[0].impose_force(x=-load)
nodes[-1].impose_velocity(x=0.02)

solver = lm.Auto(tolerance=1e-8)
sim = lm.Simulation(scene, time_step=1e-3, solver=solver).run(steps=60)
along, tension = lm.measure.forces_along(sim), lm.measure.wire_links(sim).tension
pull, friction = tension[-1] - load, -along.friction_along.sum()
print(f"pull {pull:.4f} N, friction {friction:.4f} N, 20 mu N {20 * mu * press:.4f} N")
