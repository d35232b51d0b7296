"""The solve of a built-in law in one of your own: friction that weakens in motion."""

import math
import lmgcpy as lm

solve = lm.Coulomb.react  # (W, u, (bias, friction)) -> impulse


@lm.laws.register
class Weakening(lm.Law):
    """Coulomb's law with a static and a sliding coefficient of friction."""

    NAME = "weakening"
    APPLIES_TO = "contact"
    PREPARED = ("bias", "friction")
    TRAITS = lm.Coulomb.TRAITS

    static = lm.Parameter("-", "friction at rest", minimum=0.0)
    sliding = lm.Parameter("-", "friction in motion", minimum=0.0)
    slow = lm.Parameter("m/s", "speed up to which a contact rests", above=0.0)

    def rows(self, dimension):
        return dimension

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        static, sliding, slow = parameters
        friction = static if abs(velocity[1]) < slow else sliding
        return (max(gap, 0.0) / time_step, friction)

    @staticmethod
    def react(W, u, prepared):
        return solve(W, u, prepared)


def on_a_slope(speed):
    angle = math.atan(0.4)  # between the two coefficients
    gravity = (9.81 * math.sin(angle), -9.81 * math.cos(angle))
    scene = lm.Scene(dimension=2, gravity=gravity)
    start = {"position": (0.0, 0.1), "velocity": (speed, 0.0)}
    block = scene.add(lm.disk(radius=0.1, mass=1.0, **start)).fix("spin")
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    law = Weakening(static=0.5, sliding=0.3, slow=0.01)
    scene.see("GRAIN", "WALL", law)
    lm.Simulation(scene, time_step=1e-3).run(duration=0.5)
    return block.velocity[0]


gain = 9.81 * 0.1 * math.cos(math.atan(0.4)) * 0.5  # (0.4 - 0.3) g cos(angle) t
print(f"laid down: {on_a_slope(0.0):.4f} m/s; pushed: {on_a_slope(0.2):.4f} m/s")
print(f"0.2 m/s and what it gains: {0.2 + gain:.4f} m/s")
