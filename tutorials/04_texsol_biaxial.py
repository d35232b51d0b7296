"""Tutorial 4, TexSol: sand with a wire in it, crushed between two platens.

    python tutorials/04_texsol_biaxial.py [FOLDER]

Section 3 of the paper on a small sample: 340 grains and a wire of 60 beads are laid,
relaxed, and compressed under constant lateral pressure, as sand and with the wire
linked. Run files, figures and a picture are written into FOLDER, by default
tutorial_04. The study of 2000 particles, with checks and a summary, is `lmgcpy texsol`.
"""

import sys
from pathlib import Path

import numpy as np

import lmgcpy as lm
from lmgcpy.experiment import Biaxial, compact, lay_sample

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "tutorial_04")
folder.mkdir(parents=True, exist_ok=True)
pressure, friction, strain = 1e5, 0.4, 0.05

# The sample. The wire is a random walk of beads about as large as the grains, with a
# reference gap that the coarsest grain can pass; the grains are put around it one by
# one, each into the lowest stable pocket. No dynamics so far: 2000 particles take 0.03
# s. Then pressure on all sides with the friction of the test, no gravity, the wire
# inextensible, until all is at rest: a loose sample, as in the paper. Without friction
# it would be as dense as its grains can be.
# A wire in wide bends: in curls it would bear only late in the test.
laid = lay_sample(340, 60, theta_max=0.6, seed=0)
compaction = compact(laid, pressure=pressure, density=2600.0, friction=friction)
sample = compaction.sample
print(
    f"laid in {laid.width:.3f} m x {laid.height:.3f} m, relaxed to "
    f"{sample.width:.3f} m x {sample.height:.3f} m"
)
print(
    f"at rest after {compaction.steps} steps: {compaction.at_rest}; solid fraction "
    f"{compaction.solid_fraction:.3f}"
)

# The test. The upper platen goes down, the lateral walls bear the pressure, the
# reaction is measured below. Rigid grains have no stiffness, so that pressure sets the
# time scale d sqrt(rho/p): the step is a fifth of it, and the platen's speed is given
# by the inertial number, 1e-3, slow enough for statics. Sand is the same sample without
# a law between the beads.
records = {}
for name, law in (("sand", None), ("rigid-wire", lm.RigidWire())):
    file = folder / f"{name}.h5"
    file.unlink(missing_ok=True)  # a test takes up its file where it ends
    test = Biaxial(sample, law, pressure=pressure, density=2600.0, friction=friction)
    records[name] = test.run(strain, frames=10, file=file)
print("\nsupport reaction [kN per m of depth], running means")
print("crushing    sand   rigid wire   ratio")
for at in (0.005, 0.01, 0.02, 0.03, 0.04):
    sand, wire = (
        r.smooth(r.reaction, 0.01)[np.argmin(np.abs(r.strain - at))] / 1e3
        for r in records.values()
    )
    print(f"{100 * at:6.1f} % {sand:8.1f} {wire:9.1f} {wire / sand:11.2f}")

# Stress. Weber's tensor, from the forces and branches of all interactions, has to agree
# with what the walls are loaded by; by law it has a part of the sand's contacts and one
# of the wire's links. In biaxial compression the mobilised friction is sin phi = (s1 -
# s3)/(s1 + s3).
for name, record in records.items():
    late = record.strain > 0.4 * strain
    mean = {
        part: values[late].mean(axis=0) / 1e3 for part, values in record.stress.items()
    }
    wall = (record.reaction / record.size[:, 0])[late].mean() / 1e3
    low, high = np.sort(-np.linalg.eigvalsh(mean["total"]))
    print(
        f"\n{name}: stress [kPa], traction positive, mean beyond {40 * strain:.0f} % "
        "of crushing"
    )
    print(
        f"  horizontal {mean['total'][0, 0]:8.2f}   the walls are loaded by "
        f"{-pressure / 1e3:.2f}"
    )
    print(
        f"  vertical   {mean['total'][1, 1]:8.2f}   the lower platen bears  {-wall:.2f}"
    )
    print(
        "  mobilised friction "
        f"{np.degrees(np.arcsin((high - low) / (high + low))):.1f} degrees"
    )
    if record.law != "none":
        part = {which: lm.measure.principal(mean[which]) for which in ("wire", "sand")}
        print(
            f"  wire's part  {part['wire'][0]:8.2f} {part['wire'][1]:8.2f}   "
            "tension, and mostly one way"
        )
        print(
            f"  sand's part  {part['sand'][0]:8.2f} {part['sand'][1]:8.2f}   "
            "confined by the walls and the wire"
        )
        missed = sum(record.unconverged for record in records.values())
        print(
            f"  steps not solved to {record.tolerance:g}, both tests: {missed} of "
            f"{2 * len(record.strain)}"
        )

# Figures 3 to 5 of the paper come from the run files; so does any other picture.
runs = [lm.io.open_run(folder / f"{name}.h5") for name in records]
lm.view.plot(runs, folder / "reaction.png", what="reaction")
lm.view.plot(runs[1], folder / "stress.png", what="stress")
titles = [f"{name}, {100 * strain:.0f} % crushed" for name in records]
lm.view.render(
    runs, folder / "chains.png", what="forces", title=titles, size=(420, 420)
)
for run in runs:
    run.close()
