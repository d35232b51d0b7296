"""Tutorial 1, first contact: a column of disks falls into a pile.

    python tutorials/01_pile.py [FOLDER]

The walls beside 200 disks are gone. What carries them, where does their energy go, and
what does the ground feel? The pictures are written into FOLDER, by default tutorial_01.
"""

import sys
from pathlib import Path

import numpy as np

import lmgcpy as lm

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "tutorial_01")
folder.mkdir(parents=True, exist_ok=True)
gravity, width, reach = 9.81, 0.2, 0.5

# A scene is what exists: bodies, each with a colour by which the visibility table knows
# it. In 2D everything is per metre of depth. The deposit is geometric: each disk lies
# in the lowest stable place it can roll to.
scene = lm.Scene(dimension=2, gravity=(0.0, -gravity))
radii = lm.sample.grading(200, minimum=0.005, maximum=0.010, seed=0)
places = lm.sample.deposit(radii, box=(width, None), seed=0) - (0.5 * width, 0.0)
sand, pairs = lm.Material("sand", density=2600.0), zip(radii, places, strict=True)
grains = [
    scene.add(lm.disk(radius=r, position=x, material=sand, color="GRAIN"))
    for r, x in pairs
]
# The ground is a row of disks that are held: on a flat floor disks would roll away for
# ever. Walls stop the stray ones.
for x in np.arange(-reach, reach + 0.01, 0.02):
    scene.add(
        lm.disk(radius=0.009, position=(x, -0.009), mass=1.0, color="GROUND")
    ).fix()
for point, normal in (
    ((0.0, -0.018), (0, 1)),
    ((-reach, 0.0), (1, 0)),
    ((reach, 0.0), (-1, 0)),
):
    scene.add(lm.wall(point=point, normal=normal, color="GROUND"))
# Who sees whom, by which law. In the second row forces are those on the grains: the
# first colour is the candidate's.
scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.5))
scene.see("GRAIN", "GROUND", lm.Coulomb(friction=0.5))
print(lm.view.check(scene))  # does anything overlap?

# A step is solved when its error is 1e-2 times that of doing nothing. If one is not, we
# would be warned, but rather count. In one time step no grain moves by half its radius;
# no stiffness asks for a shorter one.
solver = lm.AcceleratedGaussSeidel(tolerance=1e-2)
sim = lm.Simulation(scene, time_step=5e-4, solver=solver, on_unconverged="ignore")
start = sim.positions[: len(grains)].copy()  # bodies in the order of scene.add
weight = gravity * sum(grain.mass for grain in grains)

print("  t [s]   ground / weight   kinetic energy [J/m]   sweeps of the last step")


def watch(sim):
    """Called after every step; the run ends where this says True."""
    rest = sim.energy.kinetic < 1e-10 * weight
    if rest or sim.steps % 500 == 0:
        # candidates of the last step, a copy; forces in local frames, normal first
        net = sim.interactions
        force = np.einsum("mk,mkd->md", net.force, net.frame)  # [N/m] in x and y
        ground = force[net.antagonist >= len(grains), 1].sum()
        print(
            f"{sim.time:7.2f} {ground / weight:17.6f} {sim.energy.kinetic:22.2e} "
            f"{sim.report.iterations:25d}"
        )
    return rest


sim.run(duration=2.0, until=watch, record=folder / "pile.h5", every=200, force=True)
print(
    f"{sim.unconverged_steps} of {sim.steps} steps missed the tolerance, the worst "
    f"residual was {sim.worst_residual:.3f}"
)

# At rest the ground bears the weight, whatever way the forces take. The energy that
# gravity gave is gone: shocks without rebound and friction took it, and the balance of
# every step closes to round-off, whatever the tolerance.
energy = sim.energy
given, taken = energy.total_loads, energy.total_interactions["coulomb"]
height = np.average((start - sim.positions[: len(grains)])[:, 1], weights=radii**2)
print(
    f"centre of mass fell by {height:.4f} m: weight x height {weight * height:.6f} "
    f"J/m, gravity's work {given:.6f}"
)
print(
    f"work of the contacts {taken:.6f} J/m; not accounted for: "
    f"{given + taken - energy.kinetic:.1e} J/m"
)

# The angle of the pile: a straight line through the highest grains of strips on both
# flanks.
x, y = np.abs(sim.positions[: len(grains), 0]), sim.positions[: len(grains), 1]
strips = [
    (low + 0.015, y[(x >= low) & (x < low + 0.03)].max())
    for low in np.arange(0.0, 0.21, 0.03)
]
slope = np.degrees(np.arctan(-np.polyfit(*np.transpose(strips), 1)[0]))
print(
    f"slope of the pile: {slope:.1f} degrees; disks roll, blocks would not slide "
    f"below {np.degrees(np.arctan(0.5)):.1f}"
)

# Two looks at the pile: who came from where, and what carries it; and a film of the
# recorded frames.
looks = {
    "what": ["grains", "forces"],
    "grains": ["layer", "plain"],
    "title": ["from which height", "force chains"],
}
lm.view.render(sim, folder / "pile.png", **looks, columns=1, size=(900, 300))
with lm.io.open_run(folder / "pile.h5") as run:
    lm.view.render(run, folder / "pile.gif", size=(450, 200))
