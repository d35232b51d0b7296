"""A geogrid that is drawn out of sand: friction and cross bars hold it."""

import numpy as np
import lmgcpy as lm

p, d, bar = 1e4, 0.01, 0.0015  # pressure [Pa], size of grains, radius of the bars [m]
long, wide, mesh = 0.08, 0.04, 0.02  # the box and the meshes [m]
scene = lm.Scene(dimension=3)
x, y, z = np.meshgrid(*(d * (np.arange(k) + 0.5) for k in (8, 4, 2)), indexing="ij")
rng, sand = np.random.default_rng(0), lm.Material("sand", density=2600.0)
for side in (-1.0, 1.0):
    places = np.column_stack([x.ravel(), y.ravel(), side * (z.ravel() + 2 * bar)])
    scene.add_spheres(rng.uniform(0.4, 0.5, x.size) * d, places, material=sand)
    at, inward = (0.0, 0.0, side * (2 * d + 2 * bar)), (0.0, 0.0, -side)
    lid = scene.add(lm.wall(point=at, normal=inward, mass=0.1))
    lid.impose_force(z=-side * p * long * wide)
ends = [lm.wall(point=(at, 0, 0), normal=(n, 0, 0)) for at, n in ((0, 1), (long, -1))]
sides = [lm.wall(point=(0, at, 0), normal=(0, n, 0)) for at, n in ((0, 1), (wide, -1))]
for wall in ends + sides:
    scene.add(wall)
grid = lm.sample.net(size=(long + mesh, wide), mesh=mesh)  # one mesh is in front
nodes = [scene.add(lm.point_mass(position=at, mass=1e-3)) for at in grid.positions]
edge = [node for node in nodes if node.position[0] > long + bar]
for node in nodes:
    node.fix(*("xyz" if node in edge else "y"))
rod = lm.ElasticRod(stiffness=1e5)
scene.net(nodes, grid.cells, rod, surface=lm.Thread(bar))
for other in ("GRAIN", "THREAD"):
    scene.see("GRAIN", other, lm.Coulomb(friction=0.4))
scene.see("GRAIN", "WALL", lm.Signorini())

solver = lm.Auto(tolerance=1e-2)
sim = lm.Simulation(scene, time_step=4e-4, solver=solver).run(duration=0.06)
for node in edge:
    node.impose_velocity(x=0.1)
sim.run(duration=0.03)
work, push = sim.energy.total_drives, []
for _ in range(100):  # drawn by 0.3 to 0.7 d
    sim.step()
    net = sim.interactions
    on = [net.force[net.antagonist == wall.id, 0].sum() for wall in ends]
    push.append(on[1] - on[0])
pull = (sim.energy.total_drives - work) / (0.1 * 0.04)
sheet = 2.0 * p * long * wide
print(f"pull {pull / sheet:.3f}, push on the walls {np.mean(push) / sheet:.3f}")
