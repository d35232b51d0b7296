"""Tutorial 5, three dimensions: a wire in layers, a dense sample, a triaxial test, and a column let go.

    python tutorials/05_three_dimensions.py [FOLDER]

Where section 4 of the paper stops, and a little further, on a small sample: its anisotropy shows, its strength hardly. The
pictures are written into FOLDER, by default tutorial_05. The studies are `lmgcpy texsol --dimension 3`, `lmgcpy column`.
"""

import sys
from pathlib import Path

import numpy as np

import lmgcpy as lm
from lmgcpy.experiment import SandColumn, Triaxial, compact, lay_column, lay_sample_3d, let_go, time_unit

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "tutorial_05")
folder.mkdir(parents=True, exist_ok=True)
density, pressure, friction = 2600.0, 1e5, 0.4

# The sample: fine beads (20 % of the smallest grain, as the paper asks) laid from below upward, grains put around them.
# It is compacted without friction. Fine beads are light and fast: short steps, a tight tolerance, and a drag, without which
# grains that are squeezed out crumple the wire. Links one by one, as grains hold the wire at every bead.
laid = lay_sample_3d(200, 320, density=density, seed=0)
moment = laid.diameter * np.sqrt(density / pressure)  # in which the pressure moves a grain by its size [s]
fine = lm.AcceleratedGaussSeidel(tolerance=1e-3, max_iterations=2000, wire_blocks=False)
dense = compact(laid, pressure=pressure, density=density, drag=2.0, time_step=0.08 * moment, solver=fine, max_steps=1500)
chain = dense.sample.positions[dense.sample.chains[0]]
length = np.linalg.norm(np.diff(chain, axis=0), axis=1).sum()
print(f"wire {1e3 * length:.0f} mm, {lm.sample.wire_content(length=length, volume=np.prod(dense.sample.box)):.0f} km/m^3")
print(f"solid fraction {dense.solid_fraction:.3f} (random close packing 0.64), coordination {dense.coordination:.2f}")

# Compressed across its layers at 100 kPa. The walls' pressures must be what was imposed; the wire's part of the stress is
# large in the plane of its layers, x and y, and small across them, z: it is not isotropic, as the paper foresaw.
solver = lm.AcceleratedGaussSeidel(tolerance=3e-3, max_iterations=2000, momentum=0.9, wire_blocks=False)
sines = []
for name, law in (("sand", None), ("rigid wire", lm.RigidWire())):
    test = Triaxial(dense.sample, law, density=density, friction=friction, inertial_number=2e-3, solver=solver)
    record = test.run(0.08, frames=0)
    late = record.strain > 0.04
    q, p, lateral = (v[late].mean() / 1e3 for v in (record.deviator, record.mean_pressure, record.lateral))
    sines.append(3.0 * q / (6.0 * p + q))  # sin phi = (s1 - s3)/(s1 + s3)
    angle = np.degrees(np.arcsin(sines[-1]))
    wire = np.diag(record.stress["wire"][late].mean(axis=0)) / 1e3
    print(f"{name:10}: lateral {lateral:.2f} kPa, deviator {q:.0f} kPa, {angle:.1f} degrees, wire {wire.round(1)} kPa")
worth = (1.0 + sines[0]) / (1.0 - sines[0]) * wire[:2].mean()  # s1/s3 of the sand, times what the wire adds to s3
print(f"the wire's confinement is worth {worth:.0f} kPa of deviator; a sample so small varies by more: try another seed")
looks = {"what": ["grains", "grains", "forces"], "grains": ["hidden", "hidden", "plain"]}
looks |= {"wires": ["length", "length", "plain"], "camera": ["isometric", "x", "x"]}
titles = ["the wire", "its layers, from the side", "forces at 8 % of crushing"]
lm.view.render(test.simulation, folder / "sample.png", **looks, title=titles, size=(320, 320))

# A column, without and with wire, settles in a smooth mould, which is taken away. Dry round columns run out by
# (R_f - R)/R = 1.6 sqrt(a), a = H/R > 1.7 (Lube et al. 2004); here it is that of the radius which holds 99 % of the sand.
runs, titles = [], []
for content in (0.0, 0.8):
    laid = lay_column(grain_count=80, content=content, bead_diameter=0.4, seed=0)
    unit, mould = time_unit(laid), laid.mould  # sqrt(H/g)
    poured = let_go(SandColumn(laid, friction=0.5, reach=2.0 * mould.radius, mould=True), duration=3.0 * unit)
    file = folder / f"column-{content:g}.h5"
    file.unlink(missing_ok=True)
    column = SandColumn(laid, friction=0.5, reach=4.0 * mould.radius, mould=False, state=poured.end)
    course = let_go(column, duration=3.0 * unit, file=file)
    runs.append(lm.io.open_run(file))
    titles.append(f"wire {100 * laid.content_by_weight:.1f} % by weight")
    run_out, kept = course.spread[-1, 1] / mould.radius - 1.0, course.height[-1, 0] / poured.height[-1, 0]
    print(f"column, {titles[-1]}: height kept {kept:.2f}, run-out {run_out:.2f} (law for dry sand: {1.6 * 2**0.5:.2f})")
looks = {"grains": "layer", "wires": "plain", "opacity": [1.0, 0.35] * 2, "camera": (0.4, -1.0, 0.35), "size": (420, 270)}
lm.view.render(runs * 2, folder / "columns.png", frame=[0, 0, -1, -1], title=[*titles, "", ""], columns=2, **looks)
