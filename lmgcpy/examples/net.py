"""A net that catches a ball: the links store the energy that it brought."""

import numpy as np
import lmgcpy as lm

m, speed = 2.0, 3.0  # mass of the ball [kg], its speed [m/s]
grid = lm.sample.net(size=(1.0, 1.0), mesh=0.2)
scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -9.81))
nodes = [scene.add(lm.point_mass(position=at, mass=1e-3)) for at in grid.positions]
for k in np.flatnonzero(grid.rim):
    nodes[k].fix()
elastic = lm.ElasticWire(stiffness=2e3)
scene.net(nodes, grid.cells, elastic, surface=lm.Thread(radius=0.005))
start = {"position": (0.52, 0.53, 0.156), "velocity": (0.0, 0.0, -speed)}
ball = scene.add(lm.sphere(radius=0.15, mass=m, **start))
scene.see("GRAIN", "THREAD", lm.Signorini())

sim = lm.Simulation(scene, time_step=2.5e-4)
while ball.velocity[2] < 0.0:
    sim.step()
depth = 0.156 - ball.position[2]
given = m * (0.5 * speed**2 + 9.81 * depth)
stored = sim.energy.stored["elastic-wire"]
print(f"depth {depth:.3f} m: given {given:.2f} J, links store {stored:.2f} J")
