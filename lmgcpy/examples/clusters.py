"""Grains that are not round, as clusters of disks: the floor bears their weight."""

import numpy as np
import lmgcpy as lm

r, apart = 0.01, 0.008  # radius of a disk, from the pair's middle to its centre [m]
disk = 2600 * np.pi * r**2  # [kg/m]
inertia = 2 * (0.5 * disk * r**2 + disk * apart**2)
pair = [(lm.DiskContactor(r), (-apart, 0.0)), (lm.DiskContactor(r), (apart, 0.0))]
scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
for k in range(30):
    start = {"position": (0.02 + 0.04 * (k % 5), 0.02 + 0.04 * (k // 5)), "rotation": k}
    mass = {"mass": 2 * disk, "inertia": inertia}
    scene.add(lm.RigidBody(pair, **mass, **start, color="CLUSTER"))
for point, normal in (((0, 0), (0, 1)), ((0, 0), (1, 0)), ((0.2, 0), (-1, 0))):
    scene.add(lm.wall(point=point, normal=normal))
scene.see("CLUSTER", "CLUSTER", lm.Coulomb(friction=0.5))
scene.see("CLUSTER", "WALL", lm.Signorini())

sim = lm.Simulation(scene, time_step=1e-3).run(duration=1.5)
net, floor = sim.interactions, 30
share = net.force[net.antagonist == floor, 0].sum() / (30 * 2 * disk * 9.81)
print(f"the floor bears {share:.4f} of the weight")
