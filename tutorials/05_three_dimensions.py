"""Tutorial 5, three dimensions: a wire in layers, triaxial tests, and a column let go.

    python tutorials/05_three_dimensions.py [FOLDER]

Where section 4 of the paper stops, and a little further, on a small sample: its
anisotropy shows, its strength hardly. The pictures are written into FOLDER, by default
tutorial_05. The studies are `lmgcpy texsol --dimension 3`, `lmgcpy column`.
"""

import sys
from pathlib import Path

import numpy as np

import lmgcpy as lm
from lmgcpy.experiment import (
    SandColumn,
    Triaxial,
    compact,
    lay_column,
    lay_sample_3d,
    let_go,
    time_unit,
)

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "tutorial_05")
folder.mkdir(parents=True, exist_ok=True)
density, pressure, friction = 2600.0, 1e5, 0.4

# Five samples, as one so small tells little of the material: fine beads (20 % of the
# smallest grain, as the paper asks) laid from below upward, grains put around them.
# They are compacted without friction. Fine beads are light and fast: short steps, a
# tight tolerance, and a drag, without which grains that are squeezed out crumple the
# wire. Links one by one, as grains hold the wire at every bead. Then they are
# compressed across their layers at 100 kPa, as sand and with the wire.
fine = lm.AcceleratedGaussSeidel(tolerance=1e-3, max_iterations=2000, wire_blocks=False)
solver = lm.AcceleratedGaussSeidel(
    tolerance=3e-3, max_iterations=2000, momentum=0.9, wire_blocks=False
)
deviators, wires = [], []
print(
    "seed  wire   solid   lateral     deviator [kPa]       stress of the wire [kPa]"
    "\n     km/m^3  fraction  [kPa]    sand, with the wire        xx     yy     zz"
)
for seed in range(5):
    laid = lay_sample_3d(200, 320, density=density, seed=seed)
    # in which the pressure moves a grain by its size [s]
    moment = laid.diameter * np.sqrt(density / pressure)
    options = {
        "drag": 2.0,
        "time_step": 0.08 * moment,
        "solver": fine,
        "max_steps": 1500,
    }
    dense = compact(laid, pressure=pressure, density=density, **options)
    chain = dense.sample.positions[dense.sample.chains[0]]
    length = np.linalg.norm(np.diff(chain, axis=0), axis=1).sum()
    content = lm.sample.wire_content(length=length, volume=np.prod(dense.sample.box))
    for law in (None, lm.RigidWire()):
        test = Triaxial(
            dense.sample,
            law,
            density=density,
            friction=friction,
            inertial_number=2e-3,
            solver=solver,
        )
        record = test.run(0.08, frames=0)
        late = record.strain > 0.04
        deviators.append(record.deviator[late].mean() / 1e3)
    lateral = record.lateral[late].mean() / 1e3
    wires.append(np.diag(record.stress["wire"][late].mean(axis=0)) / 1e3)
    x, y, z = wires[-1]
    row = f"{seed:4}{content:7.0f}{dense.solid_fraction:9.3f}{lateral:10.2f}"
    print(f"{row}{deviators[-2]:9.0f}{deviators[-1]:10.0f}{x:12.1f}{y:7.1f}{z:7.1f}")

# The walls' pressures are what was imposed. The wire's part of the stress is large in
# the plane of its layers, x and y, and small across them, z: it is not isotropic, as
# the paper foresaw. How strong it makes a sample varies; the mean is above 0.
gain = np.diff(np.reshape(deviators, (5, 2)), axis=1)
print(
    f"the wire adds {gain.mean():.0f} kPa to the deviator, give or take "
    f"{gain.std(ddof=1) / 5**0.5:.0f} (five samples)"
)
within, across = (
    np.mean(wires, axis=1, where=[True, True, False]),
    np.array(wires)[:, 2],
)
spread = within.std(ddof=1) / 5**0.5
print(
    f"its part of the stress: {within.mean():.1f} kPa within its layers, give or take "
    f"{spread:.1f},"
)
print(
    f"  {across.mean():.1f} kPa across them; larger within than across in "
    f"{(within > across).sum()} of 5 samples"
)
looks = {
    "what": ["grains", "grains", "forces"],
    "grains": ["hidden", "hidden", "plain"],
}
looks |= {"wires": ["length", "length", "plain"], "camera": ["isometric", "x", "x"]}
titles = ["the wire", "its layers, from the side", "forces at 8 % of crushing"]
lm.view.render(
    test.simulation, folder / "sample.png", **looks, title=titles, size=(320, 320)
)

# A column, without and with wire, settles in a smooth mould, which is taken away. Dry
# round columns run out by (R_f - R)/R = 1.6 sqrt(a), a = H/R > 1.7 (Lube et al. 2004);
# here it is that of the radius which holds 99 % of the sand.
runs, titles = [], []
for content in (0.0, 0.8):
    laid = lay_column(grain_count=80, content=content, bead_diameter=0.4, seed=0)
    unit, mould = time_unit(laid), laid.mould  # sqrt(H/g)
    poured = let_go(
        SandColumn(laid, friction=0.5, reach=2.0 * mould.radius, mould=True),
        duration=3.0 * unit,
    )
    file = folder / f"column-{content:g}.h5"
    file.unlink(missing_ok=True)
    column = SandColumn(
        laid, friction=0.5, reach=4.0 * mould.radius, mould=False, state=poured.end
    )
    course = let_go(column, duration=3.0 * unit, file=file)
    runs.append(lm.io.open_run(file))
    titles.append(f"wire {100 * laid.content_by_weight:.1f} % by weight")
    run_out, kept = (
        course.spread[-1, 1] / mould.radius - 1.0,
        course.height[-1, 0] / poured.height[-1, 0],
    )
    print(
        f"column, {titles[-1]}: height kept {kept:.2f}, run-out {run_out:.2f} (law "
        f"for dry sand: {1.6 * 2**0.5:.2f})"
    )
looks = {
    "grains": "layer",
    "wires": "plain",
    "opacity": [1.0, 0.35] * 2,
    "camera": (0.4, -1.0, 0.35),
    "size": (420, 270),
}
lm.view.render(
    runs * 2,
    folder / "columns.png",
    frame=[0, 0, -1, -1],
    title=[*titles, "", ""],
    columns=2,
    **looks,
)
