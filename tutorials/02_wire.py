"""Tutorial 2, a wire: slack, taut, snapped tight by a ball, elastic without explosion.

    python tutorials/02_wire.py [FOLDER]

A ball of 1 kg on a wire of 1 m is let go 0.3 m beside the hook. It falls, the wire
snaps taut, and it swings. Every number has a formula beside it. The picture is written
into FOLDER, by default tutorial_02.
"""

import sys
from pathlib import Path

import numpy as np

import lmgcpy as lm

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "tutorial_02")
folder.mkdir(parents=True, exist_ok=True)
g, mass, length, beside = 9.81, 1.0, 1.0, 0.3


def hang(law, places, bead_mass=1.0, time_step=2e-4, **solver):
    """Hook, beads and ball at these places (x, y), linked by ``length`` of wire."""
    scene, links = lm.Scene(dimension=2, gravity=(0.0, -g)), len(places) - 1
    radii, masses = np.array([0.012] * links + [0.05]), [bead_mass] * links + [mass]
    makes = zip(places, radii, masses, strict=True)
    bodies = [
        scene.add(lm.disk(radius=radius, position=place, mass=m))
        for place, radius, m in makes
    ]
    bodies[0].fix()
    # links act between centres; the reference gap, beyond which a wire pulls, is one
    # between surfaces
    scene.chain(bodies, law, reference_gap=length / links - (radii[:-1] + radii[1:]))
    solver = lm.GaussSeidel(tolerance=1e-10, **solver)
    return lm.Simulation(
        scene, time_step=time_step, solver=solver, on_unconverged="ignore"
    )


# 1. The rigid wire, 0 <= -(u_n + (gap - g_ref)/h) _|_ -r_n >= 0: no force while it is
# slack, no lengthening once it is taut. It snaps taut in two steps: the first ends with
# the wire at its length, the next takes what is left of the speed along it. A shock has
# an impulse; its force, impulse / h, is a number of the time step's.
sim = hang(lm.RigidWire(), [(0.0, 0.0), (beside, 0.0)])
observe = {
    "pull": lambda sim: -sim.interactions.impulse[:, 0].sum(),
    "velocity": lambda sim: sim.velocities[1],
}
kept = {"record": folder / "snap.h5", "every": 20, "observe": observe, "force": True}
sim.run(steps=10_000, until=lambda sim: sim.positions[1, 0] <= 0.0, **kept)
with lm.io.open_run(folder / "snap.h5") as run:
    time, pull, velocity = (
        run.history[:]["time"],
        run.observed["pull"][:],
        run.observed["velocity"][:],
    )
snap = int(np.argmax(pull > 0.0))
depth = np.sqrt(length**2 - beside**2)
fast, across = np.sqrt(2.0 * g * depth), np.sqrt(2.0 * g * depth) * beside / length
bottom = mass * (g + across**2 / length + 2.0 * g * (1.0 - depth / length))
print(
    f"snaps taut at {time[snap]:.4f} s    free fall: {np.sqrt(2.0 * depth / g):.4f} s"
)
print(
    f"impulse       {pull[snap : snap + 2].sum():.4f} N s  m v along the wire: "
    f"{mass * fast * depth / length:.4f} N s"
)
print(
    f"speed after   {np.linalg.norm(velocity[snap + 1]):.4f} m/s  speed across the "
    f"wire: {across:.4f} m/s"
)
print(f"lowest point  {pull[-1] / sim.time_step:.4f} N   m g + m v^2/l: {bottom:.4f} N")

# 2. A wire of 40 beads, 20 g each, with the ball at its end: link by link the tension
# is the weight below. One block for the whole wire finds it at once; sweeps that visit
# links one by one, as other codes do, are far off after hundreds. (Let it swing, and
# mind that a bead on a taut wire answers sideways like an explicit spring: keep h below
# sqrt(m l/T).)
line = np.column_stack([np.zeros(41), np.linspace(0.0, -length, 41)])
weights = g * (mass + 0.02 * np.arange(39, -1, -1))
for blocks, how in ((False, "link by link"), (True, "as one block")):
    wire = hang(
        lm.RigidWire(), line, bead_mass=0.02, wire_blocks=blocks, max_iterations=300
    )
    report, error = (
        wire.step(),
        np.abs(-wire.interactions.force[:, 0] / weights - 1.0).max(),
    )
    print(
        f"tensions {how}: {100 * error:.2g} % off after {report.iterations} sweeps, "
        f"residual {report.residual:.0e}"
    )
with lm.io.open_run(folder / "snap.h5") as run:
    look = {
        "what": "grains",
        "grains": "plain",
        "wires": "tension",
        "limits": (0.0, 20.0),
        "size": (230, 460),
    }
    titles = ["slack, 0 s", "slack, 0.4 s", f"taut, {time[-1]:.2f} s", "40 beads hang"]
    lm.view.render(
        [run, run, run, wire],
        folder / "wire.png",
        frame=[0, 100, -1, None],
        title=titles,
        **look,
    )

# 3. Elastic wires, the ball dropped by 0.1 m. Explicitly (one line below) a spring
# explodes where h^2 k/m > 4, which is why the paper gave them up. lmgcpy takes the
# force of the end of the step, so that stiffness is a compliance 1/(h^2 k) beside W:
# stable at any h, and the rigid wire in the limit. What h cannot resolve is damped: no
# ball rebounds by more than 0.1 m.
print(
    "              stretch [m]       rebound [m]           at rest:\n"
    "k [N/m] h^2 k/m exact lmgcpy    explicit lmgcpy   k x stretch / (m g)"
)
for k in (1e5, 1e7, 1e9, 1e12):
    sag, x, v, stretch, naive = mass * g / k, 0.0, np.sqrt(2.0 * g * 0.1), [], []
    sim = hang(
        lm.ElasticWire(stiffness=k), [(0.0, 0.0), (0.0, 0.1 - length)], time_step=1e-3
    )
    for _ in range(1500):
        stretch.append(-sim.run(steps=1).positions[1, 1] - length)
        naive.append(x := x + 1e-3 * (v := v + 1e-3 * (g - k * max(x, 0.0) / mass)))
    exact = sag + np.sqrt(sag**2 + 0.2 * sag)  # m g (0.1 + x) = k x^2/2
    end = k * stretch[-1] / (mass * g)
    back = max(0.0, -min(stretch[200:]))  # after the first fall
    print(
        f"{k:.0e} {k * 1e-6:6.0e} {exact:8.1e} {max(stretch):7.1e} "
        f"{-min(naive):9.3g} {back:6.3f} {end:14.6f}"
    )
