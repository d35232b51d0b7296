"""Order of the time stepping where nothing opens, closes or slides.

Errors at a given time against the time step, of a pendulum (rigid rod), of a mass on an elastic rod, and of a disk that
rolls down an incline.

    python benchmarks/stepping.py
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp
from table import report

import lmgcpy as lm
from lmgcpy.bench import load

LENGTH, GRAVITY, STIFFNESS = 1.0, 9.81, 10.0
STEPS = (400, 800, 1600, 3200)


def pendulum(steps: int, theta: float) -> float:
    """Distance from the solution of the equation of motion after a second, started at rest at an angle of 1 [m]."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -GRAVITY))
    pivot = scene.add(lm.disk(radius=0.1, position=(0.0, 0.0), mass=1.0))
    pivot.fix()
    bob = scene.add(lm.disk(radius=0.1, position=(LENGTH * np.sin(1.0), -LENGTH * np.cos(1.0)), mass=1.0))
    scene.chain([pivot, bob], lm.RigidRod())
    lm.Simulation(scene, time_step=1.0 / steps, theta=theta, solver=lm.Newton(tolerance=1e-13)).run(steps=steps)
    motion = solve_ivp(
        lambda t, y: (y[1], -GRAVITY / LENGTH * np.sin(y[0])), (0.0, 1.0), (1.0, 0.0), rtol=1e-12, atol=1e-12
    )
    angle = motion.y[0, -1]
    return float(np.hypot(bob.position[0] - LENGTH * np.sin(angle), bob.position[1] + LENGTH * np.cos(angle)))


def spring(steps: int, theta: float) -> float:
    """Distance from ``v sin(omega t) / omega`` after a second of a mass on an elastic rod, pushed off at 0.3 m/s [m]."""
    scene = lm.Scene(dimension=2)
    end = scene.add(lm.disk(radius=0.1, position=(0.0, 0.0), mass=1.0))
    end.fix()
    bob = scene.add(lm.disk(radius=0.1, position=(LENGTH, 0.0), mass=1.0, velocity=(0.3, 0.0)))
    scene.chain([end, bob], lm.ElasticRod(stiffness=STIFFNESS))
    lm.Simulation(scene, time_step=1.0 / steps, theta=theta, solver=lm.Newton(tolerance=1e-13)).run(steps=steps)
    omega = np.sqrt(STIFFNESS)
    return float(abs(bob.position[0] - LENGTH - 0.3 / omega * np.sin(omega)))


def rolling(steps: int, theta: float) -> float:
    """Distance from ``g sin(a) t^2 / 3`` after a second of a disk that rolls down an incline of 0.2 [m]."""
    scene = lm.Scene(dimension=2, gravity=(GRAVITY * np.sin(0.2), -GRAVITY * np.cos(0.2)))
    ball = scene.add(lm.disk(radius=0.1, position=(0.0, 0.1), mass=1.0))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.5))
    lm.Simulation(scene, time_step=1.0 / steps, theta=theta, solver=lm.Newton(tolerance=1e-13)).run(steps=steps)
    return float(abs(ball.position[0] - GRAVITY * np.sin(0.2) / 3.0))


def orders() -> None:
    rows = []
    for name, case in (("pendulum, rigid rod", pendulum), ("mass on an elastic rod", spring), ("rolling disk", rolling)):
        for theta in (0.5, 1.0):
            errors = np.array([case(steps, theta) for steps in STEPS])
            exact = errors.max() < 1e-10  # round-off
            order = "exact" if exact else f"{np.log2(errors[-2] / errors[-1]):.2f}"
            rows.append([name, theta, *(f"{error:.1e}" for error in errors), order])
    report(
        "stepping_orders",
        ["case", "theta", *(f"error at h = 1/{steps} s" for steps in STEPS), "order of the last two"],
        rows,
    )


def main() -> None:
    print(f"load of the machine: {load()}")
    orders()


if __name__ == "__main__":
    main()
