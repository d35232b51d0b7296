"""An example of a function that a campaign calls: a disk that cannot roll slides down a slope."""

import ctypes
import math
import os
import signal
import subprocess
import sys
import time

import lmgcpy as lm
from lmgcpy.experiment import carry_out

STEP, SLOPE = 1e-3, 0.5


def slide(site, friction, seed=0, steps=60, slow=0.0):
    """How far it gets [m]; each step takes so long at least [s]."""
    scene = lm.Scene(dimension=2, gravity=(9.81 * math.sin(SLOPE), -9.81 * math.cos(SLOPE)))
    disk = scene.add(lm.disk(radius=0.1, position=(0.0, 0.1), mass=1.0 + seed))
    disk.impose_velocity(spin=0.0)
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=friction))

    def position(sim):
        time.sleep(slow)
        return sim.positions[0]

    def moved(**run):
        sim = lm.Simulation(scene, time_step=STEP)
        with carry_out(sim, steps=steps, observe={"position": position}, every=10, notes={}, **run) as it:
            return it.observed["position"][:, 0].copy()

    x = site.run("slide", "slide", steps, moved)
    return {"distance [m]": x[-1], "step": range(1, steps + 1), "x [m]": x}


def nothing(site, number):
    """Nothing at all."""
    return {"number": number}


def fails(site, number):
    """Fails for the number 1."""
    if number == 1:
        raise ValueError("one is too many")
    return {"number": number}


def dies(site, number, file):
    """Ends its process at the first call with the number 1."""
    if number == 1 and not os.path.exists(file):
        open(file, "w").close()
        os.kill(os.getpid(), signal.SIGKILL)
    return {"number": number}


def always_dies(site, number):
    """Ends its process whenever it is called with the number 1, when the cases behind it are there."""
    if number == 1:
        time.sleep(0.3)
        os.kill(os.getpid(), signal.SIGKILL)
    return {"number": number}


def hangs(site, number, file):
    """Never returns for the number 1, nor does the process that it has begun, whose number is in the file."""
    if number == 1:
        child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
        with open(file, "a") as begun:
            print(child.pid, file=begun)
        with site.stage("hang", 10):
            ctypes.PyDLL(None).sleep(600)  # holds on to Python: no other thread of the process gets a turn
    return {"number": number}


def waits(site, file):
    """Waits for a minute, once the number of its process is in the file."""
    with open(f"{file}.new", "w") as new:
        new.write(str(os.getpid()))
    os.replace(f"{file}.new", file)
    time.sleep(60.0)
    return {}


def runs(pid):
    """Whether a process is there and no zombie."""
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
