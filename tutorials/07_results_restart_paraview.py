"""Tutorial 7, results: what a run file holds, going on after an interruption, ParaView.

    python tutorials/07_results_restart_paraview.py [FOLDER]

Sand settles around a wire that is laid in it; the run is interrupted, taken up again
from its file, read, and exported. Everything is written into FOLDER, by default
tutorial_07.
"""

import sys
from pathlib import Path

import numpy as np
import pyvista as pv
from vtkmodules.vtkCommonCore import vtkLogger

import lmgcpy as lm

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "tutorial_07")
folder.mkdir(parents=True, exist_ok=True)
side, g = 0.05, 9.81


def begin():
    """300 beads of wire in layers and 200 grains around them, in an open box."""
    scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -g))
    sand = lm.Material("sand", density=2600.0)
    wire = lm.sample.wire_3d(
        box=(side, side, 0.04),
        bead_radius=0.0008,
        interstice=0.0008,
        bead_count=300,
        seed=0,
    )
    radii = lm.sample.grading(200, minimum=0.003, maximum=0.004, dimension=3, seed=0)
    grains = lm.sample.deposit(
        radii, box=(side, side, None), obstacles=(wire.positions, wire.radii), seed=0
    )
    beads = [
        scene.add(lm.sphere(radius=0.0008, position=x, mass=2e-5, color="BEAD"))
        for x in wire.positions
    ]
    for position, radius in zip(grains, radii, strict=True):
        scene.add(
            lm.sphere(radius=radius, position=position, material=sand, color="GRAIN")
        )
    for point, normal in (
        (0, (0, 0, 1)),
        (0, (1, 0, 0)),
        (side, (-1, 0, 0)),
        (0, (0, 1, 0)),
        (side, (0, -1, 0)),
    ):
        scene.add(lm.wall(point=(point, point, 0.0), normal=normal, color="WALL"))
    for one, other in (
        ("GRAIN", "GRAIN"),
        ("BEAD", "GRAIN"),
        ("GRAIN", "WALL"),
        ("BEAD", "WALL"),
    ):
        scene.see(one, other, lm.Coulomb(friction=0.4))
    scene.chain(beads, lm.RigidWire(), reference_gap=wire.interstice, block_spin=True)
    return lm.Simulation(
        scene,
        time_step=4e-4,
        solver=lm.AcceleratedGaussSeidel(tolerance=1e-2),
        on_unconverged="ignore",
    )


# 1. Recording: the scene, a frame every 40 steps, the history of every step, and what
# you observe, functions of the simulation. Stopped after 250 steps, here by design;
# Ctrl-C, or a kill, leaves a file that is as good.
observe = {"top": lambda sim: float(sim.positions[300:500, 2].max())}
begin().run(
    steps=250, record=folder / "settling.h5", every=40, observe=observe, force=True
)

# 2. Going on: in another process, tomorrow, from the file alone (a function cannot be
# stored: observe is said again). The answer is that of a run without interruption, to
# the last bit. What observes nothing goes on by `lmgcpy resume FILE`.
lm.resume(folder / "settling.h5", observe=observe).run(steps=250)
begin().run(
    steps=500, record=folder / "whole.h5", every=40, observe=observe, force=True
)
with (
    lm.io.open_run(folder / "settling.h5") as run,
    lm.io.open_run(folder / "whole.h5") as whole,
):
    print(
        f"{run!r}\n  first difference from the run without interruption: "
        f"{lm.io.compare(run, whole)}"
    )

    # 3. Reading: frames (positions, velocities, interactions), history (a row a step),
    # energies, observations.
    net, history, energy = run.interactions(-1), run.history[:], run.energy
    force = np.einsum("mk,mkd->md", net.force, net.frame)  # on the candidates [N]
    # walls come after 300 beads and 200 grains; the floor is the first
    below = force[net.antagonist == 500, 2].sum()
    weight = g * run.scene["bodies"]["mass"][:500].sum()
    beside = force[net.antagonist > 500, 2].sum()
    print(
        f"  floor {below:.4f} N + walls' friction {beside:.4f} N = "
        f"{below + beside:.4f} N; weight {weight:.4f} N"
    )
    # of laws, and of the forces by which light beads are left out of balance
    imbalance = energy["unbalanced"].sum()
    taken = sum(w.sum() for w in energy["work"].values()) + imbalance
    given, left = energy["loads"].sum(), energy["kinetic"][-1]
    print(
        f"  work of gravity {given:.6e} J, of laws {taken:.6e} J,\n"
        f"  out of balance {imbalance:.1e} J, kinetic energy {left:.6e} J"
    )
    # a value a step, and one before the first, read where it is asked for
    top = run.observed["top"]
    print(
        f"  highest grain at {top[0]:.5f} m, then at {top[-1]:.5f} m; "
        f"{history['iterations'].mean():.0f} sweeps a step"
    )
    lm.view.export_vtk(run, folder / "paraview", force=True)
    lm.view.plot(run, folder / "energy.png", what="energy")

# 4. ParaView. Open the .pvd files; bodies: Glyph, sphere, scaled by radius, factor 2;
# forces: Cell Data to Point Data, then Tube, varying its radius; wires: Tube. pyvista
# is the same VTK, and this is that recipe, on the last file of each series.
bodies, forces, wires = (
    pv.read(max((folder / "paraview").glob(f"{part}-*")))
    for part in ("bodies", "forces", "wires")
)
grains = bodies.extract_points(bodies["radius"] > 0.001).glyph(
    scale="radius", factor=2.0, orient=False, geom=pv.Sphere()
)
forces["width"] = 2e-3 * np.abs(forces["normal_force"]) / forces["normal_force"].max()
# VTK would tell of the display that need not be there
vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
plotter = pv.Plotter(off_screen=True, window_size=(800, 560))
plotter.add_mesh(grains, color="#d9cba3", opacity=0.15)
plotter.add_mesh(
    forces.cell_data_to_point_data().tube(scalars="width", absolute=True),
    color="#b2182b",
)
plotter.add_mesh(wires.tube(radius=0.0006), color="#1b4f9c")
plotter.view_xz()
plotter.camera.zoom(1.7)
plotter.screenshot(folder / "paraview.png")
