"""Small steps within large ones: a controller holds a ball up."""

import lmgcpy as lm

scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
ball = scene.add(lm.disk(radius=0.1, position=(0.0, 0.0), mass=2.0))
lift = 0.0
ball.impose_force(y=lambda t: lift)
sim = lm.Simulation(scene, time_step=1e-3)
wanted, missed = 0.5, 0.0  # height [m], and what it was missed by, over time [m s]
for _ in range(1000):  # a controller of 100 Hz: ten steps of 1 ms for one of its own
    error = wanted - ball.position[1]
    missed += 0.01 * error
    lift = 60.0 * error - 20.0 * ball.velocity[1] + 40.0 * missed
    sim.run(steps=10)
print(f"height {ball.position[1]:.4f} m, lift {lift:.3f} N, weight {2.0 * 9.81:.3f} N")
