"""Direct shear: friction of rows of disks, and the hills that they climb.

The upper half of a shear box is drawn over the lower one. Each disk of the middle row
climbs over a disk below it: where their contact has the slope beta, the force over the
load is tan(phi + beta) (P. W. Rowe, Proc. R. Soc. A 269, 1962), with the angle of
friction phi of the disks. beta falls from 30 degrees: sin(beta) = 1/2 - x for a way of
x diameters.
"""

import numpy as np
import lmgcpy as lm

mu, d, load, columns, rows = 0.3, 0.01, 1e3, 8, 8  # friction, [m], load [N/m]
high = np.sqrt(0.75) * d
scene = lm.Scene(dimension=2)
for row in range(rows):
    for x in d * (np.arange(columns - row % 2) + 0.5 * (row % 2)):
        at = (0.5 * d + x, 0.5 * d + high * row)
        scene.add(lm.disk(radius=0.5 * d, position=at, mass=0.2)).fix("spin")
middle, top = 0.5 * (d + high * (rows - 1)), d + high * (rows - 1)
scene.add(lm.wall(point=(0, 0), normal=(0, 1), color="ROUGH"))
lid = scene.add(lm.wall(point=(0, top), normal=(0, -1), mass=1.0, color="ROUGH"))
lid.impose_force(y=-load)
drawn = [lid]
for x in (0.0, columns * d):
    scene.add(lm.wall_segment((x, 0), (x, middle)))
    drawn.append(scene.add(lm.wall_segment((x, middle), (x, 2 * middle))))
for body in drawn:
    body.impose_velocity(x=0.01)
scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=mu))
scene.see("GRAIN", "ROUGH", lm.Coulomb(friction=mu))
scene.see("GRAIN", "WALL", lm.Signorini())

sim = lm.Simulation(scene, time_step=5e-4, solver=lm.Auto(tolerance=1e-6))
for way in (0.05, 0.1, 0.15, 0.2):
    sim.run(duration=way * d / 0.01 - sim.time)
    force = -lm.measure.reaction(sim, drawn).force[0]
    beta = np.arcsin(0.5 - way)
    rowe = np.tan(np.arctan(mu) + beta)
    print(f"{way:.2f} d: force over load {force / load:.3f}, Rowe {rowe:.3f}")
