"""Tutorial 3, your own law: how deep does a boulder sink into a cushion?

    python tutorials/03_your_own_law.py [FOLDER]

Rock sheds are covered by cushions, which boulders crush. From the formula to machine
code in two small functions, checked by an answer in closed form and by lmgcpy's tests
of laws. The figure is written into FOLDER, by default tutorial_03.
"""

import sys
from pathlib import Path

from matplotlib.figure import Figure

import lmgcpy as lm

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "tutorial_03")
folder.mkdir(parents=True, exist_ok=True)


# The formula. A cushion bears any force up to its crushing force Y, does not spring
# back, and does not hold what leaves:
#   apart    r = 0        and  u + b >= 0    r: impulse [N s]
#   rests    0 < r < h Y  and  u + b  = 0    u: velocity of separation [m/s]
#   crushes  r = h Y      and  u + b <= 0    b = max(gap, 0)/h
# A gap may be closed within the step; what is crushed stays crushed: an old penetration
# is left alone. One contact sees the rest of the world as u = u_free + W r. Resting
# takes r = -(u_free + b)/W; the two bounds cut it off.
@lm.laws.register
class Cushion(lm.Law):
    """A frictionless contact that is crushed where it would have to bear more force."""

    NAME = "cushion"
    APPLIES_TO = "contact"
    # what prepare returns, once a step, and react receives, at every sweep
    PREPARED = ("bias", "most")
    # promises, which the tests below hold it to
    TRAITS = frozenset({"push", "dissipative"})
    crushing_force = lm.Parameter(
        "N", "greatest force Y that the cushion bears", above=0.0
    )

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        (crushing_force,) = parameters
        return (max(gap, 0.0) / time_step, crushing_force * time_step)

    @staticmethod
    def react(W, u, prepared):
        bias, most = prepared
        return (min(most, max(0.0, -(u[0] + bias) / W[0][0])),)


# The answer known beforehand: falling through H it sinks until Y d = m g (H + d), so d
# = m g H / (Y - m g). The run begins 0.2 m above the shed, and a contact begins within
# a step: d is known to the 2 mm that the boulder moves in 1.5 of them.
g, mass, fall = 9.81, 1000.0, 5.0
velocity = (0.0, 0.0, -((2.0 * g * (fall - 0.2)) ** 0.5))
figure = Figure(figsize=(8.0, 3.6), layout="constrained")
left, right = figure.subplots(1, 2)
print(
    "crushing force   sinks by   m g H/(Y - m g)   greatest force   at rest (m g = "
    "9.81 kN)"
)
for force in (80e3, 160e3, 320e3):
    scene, rows = lm.Scene(dimension=3, gravity=(0.0, 0.0, -g)), []
    scene.add(
        lm.sphere(
            radius=0.45,
            position=(0.0, 0.0, 0.65),
            mass=mass,
            velocity=velocity,
            color="BOULDER",
        )
    )
    scene.add(lm.wall(point=(0.0, 0.0, 0.0), normal=(0, 0, 1), color="SHED"))
    scene.see("BOULDER", "SHED", Cushion(crushing_force=force))
    sim = lm.Simulation(scene, time_step=1e-4)
    for _ in range(3000):
        sim.step()
        rows.append(
            (
                sim.time,
                0.45 - sim.positions[0, 2],
                1e-3 * sim.interactions.force[:, 0].sum(),
            )
        )
    time, depth, felt = zip(*rows, strict=True)
    exact = mass * g * fall / (force - mass * g)
    print(
        f"{force / 1e3:11.0f} kN {depth[-1]:9.4f} m {exact:13.4f} m "
        f"{max(felt):14.2f} kN {felt[-1]:13.5f} kN"
    )
    left.plot(time, depth, label=f"{force / 1e3:.0f} kN")
    left.axhline(exact, color="black", linestyle=":")
    right.plot(time, felt)
left.set(
    xlabel="time [s]",
    ylabel="depth [m]",
    ylim=(0.8, -0.2),
    title="dotted: m g H/(Y - m g)",
)
left.legend(title="crushing force", frameon=False)
right.set(
    xlabel="time [s]",
    ylabel="force on the shed [kN]",
    title="never above the crushing force",
)
figure.savefig(folder / "cushion.png", dpi=110)

# What every law owes: finite answers to extreme input, an exact local solution, units
# that fit, machine code that says what the Python says, the traits it declares. Leave
# out "* time_step" above, and look.
try:
    from lmgcpy.testing import report
except ImportError as missing:
    print(missing)
else:
    print(report(Cushion(crushing_force=80e3)))
