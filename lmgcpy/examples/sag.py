"""A ball on a taut thread: the sag of the string equation."""

import lmgcpy as lm

T, weight, at, n = 40.0, 0.05, 0.3, 20  # tension, weight [N], place [m], segments
scene = lm.Scene(dimension=3)
places = [(k / n, 0.0, 0.0) for k in range(n + 1)]
nodes = [scene.add(lm.point_mass(position=place, mass=1e-3)) for place in places]
scene.chain(nodes, lm.RigidWire(), surface=lm.Thread(radius=0.002))
nodes[0].fix()
nodes[-1].fix("y", "z").impose_force(x=T)
ball = scene.add(lm.sphere(radius=0.02, position=(at, 0.0, 0.022), mass=5e-3))
ball.fix("x", "y", "spin_x", "spin_y", "spin_z").impose_force(z=-weight)
scene.see("GRAIN", "THREAD", lm.Coulomb(friction=0.3))
scene.drag(linear=1.0)

solver = lm.Auto(tolerance=1e-8)
sim = lm.Simulation(scene, time_step=1e-3, solver=solver).run(duration=0.5)
sag, string = 0.022 - ball.position[2], weight * at * (1.0 - at) / T
print(f"sag {1e3 * sag:.4f} mm, of the string equation {1e3 * string:.4f} mm")
