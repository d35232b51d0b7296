"""Tutorial 6, how accurate is it? Time step and tolerance, against exact answers.

    python tutorials/06_how_accurate.py [FOLDER]

And what both do to a measured curve. The figure is written into FOLDER, by default
tutorial_06.
"""

import sys
import warnings
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.special import ellipj, ellipk

import lmgcpy as lm
from lmgcpy.experiment import Biaxial, compact, lay_sample

# Steps and tolerances much too coarse are here on purpose: lmgcpy would tell it.
warnings.filterwarnings("ignore", message="In the step from .* overlap by")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else "tutorial_06")
folder.mkdir(parents=True, exist_ok=True)
figure, g = Figure(figsize=(10.0, 3.6), layout="constrained"), 9.81
left, middle, right = figure.subplots(1, 3)
left.set(xlabel="time step [ms]", ylabel="error of the height [m]", title="time step")
middle.set(
    xlabel="residual",
    ylabel="greatest relative error of a force",
    title="tower of 20 disks, 1 : 100",
)
right.set(
    xlabel="crushing [%]",
    ylabel="vertical stress [kPa]",
    title="biaxial test",
    ylim=(0, 360),
)

# 1. The time step: heights of a ball on a rigid rod, let go level with its hook, and of
# ten that fall and keep half their speed. Smooth motion is of second order in the time
# step; a shock falls somewhere into a step, which is of first order.
falls, steps = np.linspace(0.5, 0.6, 10), 1.0 / np.array([100, 200, 400, 800, 1600])
shock, found = np.sqrt(2.0 * falls / g), []
pendulum = ellipj(ellipk(0.5) - 0.45 * np.sqrt(g), 0.5)[0] ** 2 - 1.0  # Jacobi's sn
balls = 0.5 * g * (0.45 - shock) * (2.0 * shock - 0.45) - 1.1
exact = [pendulum, *balls]  # [m], after 0.45 s
for h in steps:
    scene = lm.Scene(dimension=2, gravity=(0.0, -g))
    hook, ball = (
        scene.add(lm.disk(radius=0.1, position=(x, 0.0), mass=1.0)) for x in (0.0, 1.0)
    )
    hook.fix()
    scene.chain([hook, ball], lm.RigidRod())
    for k, fall in enumerate(falls):
        scene.add(lm.disk(radius=0.1, position=(3.0 + k, fall - 1.1), mass=1.0))
    scene.add(lm.wall(point=(0.0, -1.2), normal=(0, 1)))
    scene.see("GRAIN", "WALL", lm.Restitution(restitution=0.5))
    found.append(
        lm.Simulation(scene, time_step=h).run(duration=0.45).positions[1:-1, 1]
    )
errors = np.abs(np.array(found) - exact)
print(
    "error of the height at h ="
    + "".join(f"{1e3 * h:7.2f} ms" for h in steps)
    + "   order"
)
for case, series in (
    ("pendulum", errors[:, 0]),
    ("ten shocks", errors[:, 1:].mean(axis=1)),
):
    order = np.polyfit(np.log(steps), np.log(series), 1)[0]
    print(
        f"{case:26}" + "".join(f"{error:8.1e} m" for error in series) + f"{order:8.2f}"
    )
    left.loglog(1e3 * steps, series, "o-", label=f"{case}: order {order:.1f}")

# 2. The tolerance. A tower of 20 disks, every second one a hundred times as heavy: a
# contact bears the weight above it. The residual is the error relative to that of doing
# nothing; it is not the error of the forces, as slow modes hide in it.
masses = np.tile([1.0, 100.0], 10)
# above the second disk ..., last below the tower
weights = g * np.append(masses[::-1].cumsum()[-2::-1], masses.sum())
scene = lm.Scene(dimension=2, gravity=(0.0, -g))
for i, mass in enumerate(masses):
    scene.add(lm.disk(radius=0.01, position=(0.0, 0.01 + 0.02 * i), mass=mass))
scene.add(lm.wall(point=(0.0, 0.0), normal=(0, 1), color="GRAIN"))
scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
# the step, to be solved as often as one likes
problem = lm.Simulation(scene, time_step=1e-3).run(steps=1).problem()
print(
    "\nsolver       tolerance   sweeps   Newton steps   residual   greatest error of "
    "a force"
)
for solver, tolerance in [
    (solver, 10.0**-k) for solver in (lm.GaussSeidel, lm.Auto) for k in (1, 2, 3, 4, 6)
]:
    name, options = solver.__name__, {"max_iterations": 200_000}
    one = lm.solve(problem, solver=solver(tolerance=tolerance, **options))
    error = np.abs(one.impulses[:, 0] / 1e-3 / weights - 1.0).max()
    print(
        f"{name:11} {tolerance:9.0e} {one.iterations:8d} {one.factorisations:10d} "
        f"{one.residual:15.1e} {error:15.1e}"
    )
    middle.loglog(
        one.residual,
        error,
        "o",
        color=f"C{3 * (solver is lm.Auto)}",
        label=name if tolerance == 0.1 else None,
    )

# 3. A biaxial test of 200 grains. With a tolerance so loose that each step lets grains
# sink into each other, the overlaps tell it; the mean stress moves by some percent,
# without a trend: paths of sand part. An error of force, ``force=1e-3``, asks samples
# of any size the same.
sample = compact(lay_sample(200, 0, seed=0), pressure=1e5, density=2600.0).sample
usual = Biaxial(sample).time_step
print(
    "\ntolerance  time step  sweeps a step  stress: 0.1 to 0.6 %  beyond 1 %  "
    "overlap / size"
)
cases = ((1e-1, 1.0), (1e-2, 1.0), (1e-3, 1.0), (1e-3, 0.5), (1e-4, 1.0))
for tolerance, share in cases:
    test = Biaxial(
        sample,
        time_step=share * usual,
        solver=lm.AcceleratedGaussSeidel(tolerance=tolerance),
    )
    record = test.run(0.02, frames=0)
    stress = record.reaction / record.size[:, 0] / 1e3
    overlap = -test.simulation.interactions.gap.min() / sample.diameter
    first = stress[(record.strain > 0.001) & (record.strain < 0.006)].mean()
    then = stress[record.strain > 0.01].mean()
    print(
        f"{tolerance:9.0e} {share:8.1f} h {record.iterations.mean():13.0f} "
        f"{first:18.1f} kPa {then:7.1f} kPa {overlap:14.3f}"
    )
    right.plot(
        100.0 * record.strain,
        stress,
        linewidth=0.8,
        label=f"{tolerance:.0e}, {share:g} h",
    )
for axes in (left, middle, right):
    axes.legend(frameon=False, fontsize="small")
right.legend(title="tolerance, time step", frameon=False, fontsize="small", ncols=2)
figure.savefig(folder / "accuracy.png", dpi=110)
