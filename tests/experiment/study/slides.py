"""An example of a study: a disk that cannot roll slides down a slope, once per coefficient of friction."""

import math
from dataclasses import dataclass
from typing import ClassVar

import lmgcpy as lm
from lmgcpy.experiment import Study, Task, carry_out
from lmgcpy.experiment.study.folder import ReportFolder, markdown, sections, texts

STEP, SLOPE = 1e-3, 0.5


@dataclass(frozen=True)
class Slides(Study):
    """What to compute: slides with these ``frictions`` for so many ``steps``."""

    COMMAND: ClassVar[str] = "slides"

    frictions: tuple[float, ...] = (0.1, 0.3)
    steps: int = 40
    threads: int = 2

    def lay(self, site):
        return 0.1  # the height of the centre [m]

    def prepare(self, laid, site):
        return site.run("held", "held by friction", self.steps, moved, self, laid, 2.0)

    def tests(self, prepared, done):
        return [] if done else [Task(f"{friction}", slide, (self, prepared[1], friction)) for friction in self.frictions]

    def result(self, prepared, done):
        return {friction: done[f"{friction}"] for friction in self.frictions}

    def report(self, result, folder):
        report = ReportFolder(folder.path)
        report.table("slides.csv", [{"friction": result, "distance [m]": texts((x for x, _ in result.values()), ".17g")}])
        rows = [{"friction": f"{friction:g}", "distance": f"{x:.3f} m"} for friction, (x, _) in result.items()]
        report.text(folder.summary.name, sections("Slides", [markdown(rows)]))
        return report.written


def slide(site, study, height, friction):
    """A task: one slide."""
    return site.run(f"slide-{friction}", f"slide at {friction}", study.steps, moved, study, height, friction)


def moved(study, height, friction, **run):
    """Where a disk is in the end that starts at this height (x, y) [m]."""
    scene = lm.Scene(dimension=2, gravity=(9.81 * math.sin(SLOPE), -9.81 * math.cos(SLOPE)))
    disk = scene.add(lm.disk(radius=0.1, position=(0.0, height), mass=1.0))
    disk.impose_velocity(spin=0.0)
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=friction))
    observe, notes = {"position": lambda sim: sim.positions[0]}, {"friction": friction}
    sim = lm.Simulation(scene, time_step=STEP)
    with carry_out(sim, steps=study.steps, observe=observe, every=10, notes=notes, **run) as it:
        return it.observed["position"][-1]
