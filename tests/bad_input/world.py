"""Where the rows of wrong input act: a scene that is being made, one that is compiled, and files of all kinds."""

import math
import os
import shutil

import h5py
import numpy as np
import scipy.sparse as sparse

import lmgcpy as lm
from lmgcpy.writing import FileLock

SAND = lm.Material("sand", density=2600.0)


def disk(**more):
    return lm.disk(**{"radius": 0.01, "position": (0.0, 0.0), "material": SAND, **more})


def wall(**more):
    return lm.wall(**{"point": (0, 0), "normal": (0, 1), **more})


def problem(**more):
    """Two interactions: a contact and a link."""
    parts = {"W": sparse.csr_array(np.eye(4)), "q": -np.ones(4), "mu": [0.3, 0.0], "laws": ("coulomb", "rigid-rod")}
    rest = {"dimension": 2, "compliance": np.zeros(2), "guess": np.zeros((2, 2))}
    return lm.Problem(**{**parts, **rest, **more})


recorded: list[bytes] = []


class World:
    """A scene with four beads in a row and a wall, a compiled scene beside it, and files as they are asked for."""

    def __init__(self, folder, patch):
        self.folder, self.patch = folder, patch
        self.held: FileLock | None = None
        self.scene = lm.Scene(dimension=2)
        self.beads = [self.scene.add(disk(position=(0.03 * i, 0.0), color="BEAD")) for i in range(4)]
        self.wall = self.scene.add(wall(point=(0, -1)))
        self.done = lm.Scene(dimension=2)
        self.old = self.done.add(disk())
        self.sim = lm.Simulation(self.done, time_step=1e-3)

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        if self.held:
            self.held.release()

    def start(self, **options):
        return lm.Simulation(self.scene, **{"time_step": 1e-3, **options})

    def overlapping(self, **options):
        """Two pairs overlap, the worse by a tenth of the radius."""
        for x, y in ((5.0, 0.0), (5.019, 0.0), (6.0, 0.0), (6.0, 0.0192)):
            self.scene.add(disk(position=(x, y), color="BEAD"))
        self.scene.see("BEAD", "BEAD", lm.Signorini())
        return self.start(**options)

    def many_colours(self):
        for i in range(30):
            self.scene.add(disk(position=(i, 5.0), color=f"C{i}"))
        self.scene.see("C7x", "WALL", lm.Signorini())

    def path(self, name="run.h5"):
        return self.folder / name

    def run_file(self):
        """A run of three steps, of a body with a function of time."""
        if not recorded:
            scene = lm.Scene(dimension=2)
            scene.add(disk()).impose_force(x=math.cos)
            lm.Simulation(scene, time_step=1e-3).run(steps=3, record=self.path())
            recorded.append(self.path().read_bytes())
        self.path().write_bytes(recorded[0])
        return self.path()

    def plain_run_file(self):
        """A run without functions of time."""
        self.sim.run(steps=1, record=self.path())
        return self.path()

    def unsolved_run_file(self):
        """A run whose solver is given one sweep a step, where it needs more."""
        scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
        for i in range(6):
            scene.add(disk(position=(0.0, 0.01 + 0.02 * i)))
        scene.add(wall())
        scene.see("GRAIN", "GRAIN", lm.Signorini())
        scene.see("GRAIN", "WALL", lm.Signorini())
        solver = lm.GaussSeidel(tolerance=1e-12, max_iterations=1)
        lm.Simulation(scene, time_step=1e-3, solver=solver).run(steps=0, record=self.path())
        return self.path()

    def changed(self, **attributes):
        """The run file with other attributes."""
        with h5py.File(self.run_file(), "r+") as file:
            file.attrs.update(attributes)
        return self.path()

    def problem_file(self):
        """A problem of two interactions."""
        lm.io.fclib.write(problem(), self.path("problem.h5"))
        return self.path("problem.h5")

    def text(self, content=b"no such thing"):
        self.path().write_bytes(content)
        return self.path()

    def hdf5(self):
        """An HDF5 file of something else."""
        with h5py.File(self.path(), "w") as file:
            file["x"] = 1.0
        return self.path()

    def cut(self, part):
        os.truncate(self.run_file(), int(part * os.path.getsize(self.path())))
        return self.path()

    def spoilt(self):
        """The run file with one byte of what tells where the data are changed: the checksum beside it is wrong then."""
        data = bytearray(self.run_file().read_bytes())
        data[data.rindex(b"OHDR") + 20] ^= 255
        return self.text(bytes(data))

    def fclib(self, **changes):
        """A problem's file, with data sets replaced or, for None, taken away."""
        lm.io.fclib.write(problem(), self.path())
        with h5py.File(self.path(), "r+") as file:
            for name, value in changes.items():
                del file["fclib_local"][name.replace("__", "/")]
                if value is not None:
                    file["fclib_local"][name.replace("__", "/")] = value
        return self.path()

    def lock(self):
        """The file is under another hand."""
        self.held = FileLock(self.run_file())

    def closed_run(self):
        with lm.io.open_run(self.run_file()) as run:
            return run

    def read_only(self, made=None):
        """The answer of the system is put in, as root may write anything."""
        self.patch.setattr(os, "access", lambda place, mode, **options: mode != os.W_OK)
        return made or self

    def full_disk(self, made=None):
        free = shutil.disk_usage(self.folder)._replace(free=1000)
        self.patch.setattr(shutil, "disk_usage", lambda place: free)
        return made or self
