"""A membrane under pressure: an arc of a circle, with the tension p R."""

import numpy as np
import lmgcpy as lm

p, chord, length, n = 1e3, 1.0, 1.2, 24  # pressure [Pa], span and length [m]
half = 1.0
for _ in range(50):  # half of the angle of the arc: length / chord = half / sin(half)
    half = length / chord * np.sin(half)
R = 0.5 * chord / np.sin(half)
x = np.linspace(0.0, chord, n + 1)
height = np.sqrt(0.25 * (length**2 - chord**2)) * (1.0 - np.abs(2.0 * x / chord - 1.0))
scene = lm.Scene(dimension=2)
nodes = [scene.add(lm.point_mass(position=at, mass=0.1)) for at in zip(x, height)]
nodes[0].fix()
nodes[-1].fix()
chain = scene.chain(nodes, lm.RigidWire(), surface=lm.Thread(radius=0.005))
chain.impose_pressure(-p)  # normals point to the left, upward: press from below
scene.drag(linear=40.0)

sim = lm.Simulation(scene, time_step=1e-3).run(duration=0.6)
tension = lm.measure.wire_links(sim).tension.mean()
top = sim.positions[:, 1].max()
arc = R * (1.0 - np.cos(half))
print(f"tension {tension:.1f} N, p R {p * R:.1f} N; top {top:.4f} m, arc {arc:.4f} m")
