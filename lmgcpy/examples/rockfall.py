"""A rockfall net of links that break: it holds a slow ball, a fast one goes through."""

import numpy as np
import lmgcpy as lm


@lm.laws.register
class BrittleWire(lm.Law):
    """Elastic up to a tension of ``strength``, and broken from the next step on."""

    NAME, APPLIES_TO = "brittle-wire", "link"
    PREPARED = ("bias", "compliance", "most")
    TRAITS = frozenset({"pull"})

    stiffness = lm.Parameter("N/m", "force per elongation", above=0.0)
    strength = lm.Parameter("N", "greatest tension", above=0.0)
    broken = lm.State("-", "1 if the link is broken")

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        k, strength = parameters
        most = 0.0 if state[0] > 0.0 else time_step * strength
        return ((gap - reference_gap) / time_step, 1.0 / (time_step**2 * k), most)

    @staticmethod
    def react(W, u, prepared):
        bias, compliance, most = prepared
        return (-min(max((u[0] + bias) / (W[0][0] + compliance), 0.0), most),)

    @staticmethod
    def commit(gap, reference_gap, velocity, impulse, time_step, parameters, state):
        whole = -impulse[0] < 0.999999 * time_step * parameters[1]
        return (state[0] if whole else 1.0,)


m, k, strength = 2.0, 2e3, 60.0  # mass [kg], stiffness [N/m] and strength [N] of links
limit = np.sqrt(4.0 * strength**2 / (k * m))
for speed in (1.8, 3.0):
    grid = lm.sample.net(size=(1.0, 1.0), mesh=0.5)
    scene = lm.Scene(dimension=3)
    nodes = [scene.add(lm.point_mass(position=x, mass=1e-3)) for x in grid.positions]
    for i in np.flatnonzero(grid.rim):
        nodes[i].fix()
    law = BrittleWire(stiffness=k, strength=strength)
    scene.net(nodes, grid.cells, law, surface=lm.Thread(radius=0.005))
    start = {"position": (0.5, 0.5, 0.056), "velocity": (0.0, 0.0, -speed)}
    ball = scene.add(lm.sphere(radius=0.05, mass=m, **start))
    scene.see("GRAIN", "THREAD", lm.Signorini())
    solver = lm.Auto(tolerance=1e-5)
    sim = lm.Simulation(scene, time_step=5e-4, solver=solver).run(duration=0.3)
    broken, after = np.nansum(sim.interactions.state["broken"]), ball.velocity[2]
    known = speed if speed < limit else -np.sqrt(speed**2 - limit**2)
    print(f"{speed} m/s: {broken:.0f} links broken, {after:.3f} m/s, known {known:.3f}")
