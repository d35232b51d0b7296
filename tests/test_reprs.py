"""What an object says of itself at a prompt: one line that tells what it is, never arrays."""

from __future__ import annotations

import inspect
import math
import re
from dataclasses import dataclass, field

import numpy as np
import pytest
from scipy import sparse
from test_reference import documented, reached
from two_frames import TwoFrames

import lmgcpy as lm
import lmgcpy.testing
from lmgcpy.continuum import (
    GrowingAnchorage,
    MeasuredCompression,
    MohrCoulomb,
    TexSol,
    WireNetwork,
    biaxial,
    fit_sand,
    isotropic,
    spans_of,
)
from lmgcpy.experiment import (
    Biaxial,
    Campaign,
    CampaignFolder,
    CampaignResults,
    CaseResult,
    PeriodicShear,
    Sample,
    SandColumn,
    Site,
    Stages,
    Study2D,
    StudyFolder,
    Task,
    Triaxial,
    compact,
    lay_column,
    lay_periodic,
    lay_sample,
    let_go,
)
from lmgcpy.io.compare import compare
from lmgcpy.laws.pair import pair_of
from lmgcpy.solve.problems.problem import Split
from lmgcpy.solve.problems.report import Lock, Worst

pytestmark = pytest.mark.filterwarnings("ignore:In the step to")
"""Three spheres are no sample: the plates of their triaxial test fly."""
LONGEST = 200
"""Characters of a line."""


def hanging():
    """Two beads on an elastic wire over a floor, and a disk that lies on it."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    top, low = (scene.add(lm.disk(radius=0.1, position=(0.0, y), mass=1.0)) for y in (0.8, 0.4))
    scene.add(lm.disk(radius=0.1, position=(0.5, 0.1), mass=1.0))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    top.fix()
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    scene.chain([top, low], lm.ElasticWire(stiffness=1e4))
    return lm.Simulation(scene, time_step=1e-3)


def sample_in_space():
    places = [[0.1, 0.1, 0.1], [0.3, 0.1, 0.1], [0.5, 0.1, 0.1]]
    return Sample(positions=places, radii=[0.05] * 3, wires=(2,), reference_gap=0.1, box=(0.6, 0.2, 0.2))


@dataclass(frozen=True)
class Watched(lm.Solver):
    """Keeps what it is given and what it returns."""

    seen: dict[str, object] = field(default_factory=dict)

    def solve(self, step):
        self.seen.update(step=step, outcome=lm.GaussSeidel().solve(step))
        return self.seen["outcome"]


def things(folder) -> dict[str, object]:
    """An object of every public class, by what it is expected to say."""
    fresh, sim = hanging(), hanging()
    path = folder / "run.h5"
    sim.run(steps=30, record=path, every=10, observe={"height": lambda sim: sim.positions[1, 1]})
    run, problem = lm.io.open_run(path), sim.problem()
    other = folder / "other.h5"
    hanging().run(steps=30, record=other, every=5)
    laid, column_laid = lay_sample(60, 12), lay_column(grain_count=60)
    test = Biaxial(laid, lm.RigidWire())
    record = test.run(0.002, frames=2)
    findings = lmgcpy.testing.report(
        lm.Signorini(), skip=[name for name in lmgcpy.testing.PROPERTIES if name != "interface"]
    )
    triaxial = Triaxial(sample_in_space(), lm.RigidWire())
    poured = SandColumn(column_laid, friction=0.5, reach=1e-3, mould=True)
    course = let_go(poured, duration=1e-4, frames=1)
    net = lm.measure.network(sim)
    loose = lay_periodic([0.01] * 20, dimension=2)
    pressed = compact(loose, pressure=1e5, max_steps=3)
    sheared = PeriodicShear(loose, pressure=1e5)
    compacted = compact(laid, pressure=1e5, density=2600.0, max_steps=3)
    seen: dict[str, object] = {}
    lm.solve(problem, solver=Watched(seen=seen))
    wire = {"box": (0.67, 0.67), "bead_radius": 0.0075, "interstice": 0.021, "bead_count": 30}
    beads = {"box": (0.1, 0.1, 0.2), "bead_radius": 0.001, "interstice": 0.001, "bead_count": 200}
    ball = lm.clump([1.0], [(0, 0, 0)], density=1.0)
    of_mesh = {"volume_error": 0.01, "inertia_error": 0.02}
    failed = CaseResult("seed=0", {"seed": 0}, "failed", 2.0, "no room", {}, {}, {})
    return {
        "Scene in 2D: 4 bodies, 1 rows of the visibility table, 1 chains": sim.scene,
        "name='sand', density=2600": lm.Material("sand", density=2600.0),
        "Disk 'GRAIN', body 1, at (0, 0.39": sim.scene.bodies[1],
        "Wall 'WALL', body 3, at (0, 0) m": sim.scene.bodies[3],
        "Sphere 'GRAIN', body not yet in a scene": lm.sphere(radius=0.1, position=(0, 0, 0), mass=1.0),
        "CylinderWall 'WALL'": lm.cylinder_wall(point=(0, 0, 0), axis=(0, 0, 1), radius=1.0),
        "RigidBody 'A'": lm.RigidBody([lm.DiskContactor(1.0)], mass=1.0, inertia=1.0, position=(0, 0), color="A"),
        "Capsule 'GRAIN', body not yet in a scene": lm.capsule(radius=0.1, length=0.2, position=(0, 0, 0), mass=1.0),
        "Surface 'WALL', body not yet in a scene, at (0.5, 0) m": lm.wall_segment((0, 0), (1, 0)),
        "FeatureContactor 'tip' of shape (0, 0.5, 0, -1, 0)": lm.wall_segment((0, 0), (1, 0)).contactors[2][0],
        "Clump of 1 spheres: mass 4.189 kg, extent 1 m": ball,
        "Clump of 1 spheres: mass 4.189 kg, extent 1 m, volume +1.0": lm.MeshClump(**vars(ball), **of_mesh),
        "SphereContactor 'sphere' of shape (0.1)": lm.SphereContactor(0.1),
        "RodContactor 'rod' of shape (0.1, 0, 0, 1)": lm.RodContactor(0.1, (0, 0, 1)),
        "Chain of 2 bodies, ElasticWire(stiffness=10000)": sim.scene.chains[0],
        "Joint of <Disk": tied(),
        "Cells: 4 edges between 4 nodes, 4 on the rim": lm.sample.net(size=(1.0, 1.0), mesh=1.0),
        "Net of 1 links between 2 bodies, <Skin 'THREAD' of 1 segments between 2 bodies, radius 0.1 m>": netted(),
        "Skin 'THREAD' of 1 segments": netted().skin,
        "PointMass 'NODE', body 0": netted().bodies[0],
        "Thread(radius=0.1, color='THREAD')": lm.Thread(0.1),
        "DiskContactor 'disk' of shape (0.1)": lm.DiskContactor(0.1),
        "WallContactor 'wall' of shape (0, 1)": sim.scene.bodies[3].contactors[0][0],
        **{type(law).__name__ + "(": law for law in built_in()},
        "Parameter 'friction' [-]: coefficient of friction mu": lm.Coulomb.friction,
        "State [m]: length that has slipped": lm.State("m", "length that has slipped"),
        "Pair(radius=0.05, mass=2.0, radii=(0.1, 0.1), masses=(2.0, inf), time=0.0)": pair_of(
            (0.1, 0.1), (2.0, math.inf), 0.0
        ),
        "Registration(law=<class 'lmgcpy.laws.coulomb.Coulomb'>, distribution='lmgcpy')": lm.laws.registrations()[
            "coulomb"
        ],
        "Registry of ": lm.laws.registry,
        "step 0, h = 0.001 s; no step yet": fresh,
        "Simulation of 4 bodies at t = 0.03 s, step 30, h = 0.001 s; last step converged": sim,
        "Fibres: 3 fibres of 1 m, ": lm.sample.fibres(
            [1.0] * 2, content=0.15, radius=0.3, length=1.0, box=(9.0, 9.0, 9.0)
        ),
        "0 interactions: none": fresh.interactions,
        "2 interactions: 1 coulomb, 1 elastic-wire": sim.interactions,
        "Report: converged after": sim.report,
        "Worst(law=": Worst("coulomb", 0, 1, 1e-9),
        "Lock: no motion of body 99 is compatible with ": Lock((99,), tuple(range(1000, 1090)), 7.0),
        "Energy: kinetic ": sim.energy,
        "Checkpoint of 4 bodies at t = 0.03 s, step 30": sim.checkpoint(),
        "Model in 2D: 4 bodies": sim.model,
        "BodyState of 4 bodies at t = 0.03 s": sim.state,
        **{
            f"{kind.__name__}(tolerance=": kind()
            for kind in (lm.Auto, lm.AcceleratedGaussSeidel, lm.GaussSeidel, lm.Newton)
        },
        "Problem in 2D: 1 coulomb, 1 elastic-wire, ": problem,
        "LocalSolution: slide, impulse (1, -0.3, -0.4) N s": lm.solve_local(np.eye(3), (-1.0, 3.0, 4.0), friction=0.5),
        "Solution of 2 interactions: converged after": lm.solve(problem),
        "wire of 30 beads, 1.04 m long": lm.sample.wire_2d(**wire),
        "wire of 200 beads, 0.597 m long": lm.sample.wire_3d(**beads),
        "4 bodies, 30 steps, 4 frames": run,
        "float64 array of shape (4, 4, 2), in the file": run.positions,
        "Difference: They differ in step of the frame": compare(run, lm.io.open_run(other)),
        "Network of ": net,
        "ContactForces of": lm.measure.contact_forces(sim),
        "ParticleStress of 3 rows": lm.measure.particle_stress(sim),
        "ContactKinds of 4 rows": lm.measure.contact_kinds(sim),
        "WireLinks of 1 rows": lm.measure.wire_links(sim),
        "WireFabric: 1 links, 0.40": lm.measure.wire_fabric(sim),
        "TensionByDirection of 9 rows": lm.measure.tension_by_direction(sim),
        "StretchByDirection of 9 rows": lm.measure.stretch_by_direction(sim, since=sim.positions.copy()),
        "WireContacts of 2 rows": lm.measure.wire_contacts(sim),
        "ForcesAlong of": lm.measure.forces_along(sim),
        "Facets of 0 rows": lm.measure.facets(sim),
        "CoarseFields on ": lm.measure.coarse_fields(sim, width=0.5),
        "Reaction: force (": lm.measure.reaction(sim, 0),
        "BeadSlip of 2 rows": lm.measure.BeadSlip(*np.zeros((8, 2))),
        "TensionCorrelation of 1 rows": lm.measure.tension_correlation(sim),
        "TautRuns of 1 rows": lm.measure.taut_runs(sim),
        "MeanStrain of 3 bodies: volume ": lm.measure.mean_strain(sim, since=sim.positions.copy()),
        "LongAxes of 0 rows": lm.measure.long_axes(lm.Simulation(lm.Scene(dimension=3), time_step=1e-3)),
        "LocalStrain of 4 rows": lm.measure.strain(TWO_FRAMES),
        "WireShape: persistence length ": lm.measure.wire_shape(laid.positions, laid.chains),
        "Layout: 0 overlaps, 0 links longer than their reference": lm.view.check(sim),
        "Sample in 2D: 72 particles, 12 of them beads of one wire, in a box of ": laid,
        "Compaction in 3 steps, not at rest": compacted,
        "Unrest(imbalance=": compacted.unrest,
        "Cell periodic along x, y, edges (": sheared.held.cell,
        "PeriodicCell of 20 grains in 2D": sheared.held,
        "PeriodicSample in 2D: 20 grains, solid fraction 0.450": loose,
        "Compaction in 3 steps, not at rest, solid fraction 0.4": pressed,
        "PeriodicShear of 20 grains in 2D at 100000 Pa": sheared,
        "PeriodicShearRecord: ": sheared.run(1e-3, frames=0),
        "Split of W: 0 entries and 2 columns": Split(sparse.csr_array((4, 4)), np.zeros((4, 2))),
        "Biaxial along y, RigidWire(), at 100000 Pa: 72 particles": test,
        "BiaxialRecord of law 'rigid-wire': 11 steps to 0.21 % of crushing, 0 not converged": record,
        "Frame at ": record.frames[0],
        "Triaxial along z, RigidWire(), at 100000 Pa: 3 particles": triaxial,
        "TriaxialRecord of law 'rigid-wire'": triaxial.run(1e-4, frames=0),
        "Laid column of content 0: <Sample in 3D: 60 particles": column_laid,
        "Mould(side=": column_laid.mould,
        "SandColumn of content 0: 60 particles": poured,
        "ColumnState of 60 particles": course.end,
        "Course of ": course,
        "Site of a study: no folder": Site(Stages(quiet=True), None),
        "Stages: quiet": Stages(quiet=True),
        "Step of 2 interactions in 2D": seen["step"],
        "Outcome: converged after": seen["outcome"],
        "Task 'none': lay_sample": Task("none", lay_sample),
        "StudyFolder 'texsol' of Study2D": StudyFolder("texsol", Study2D),
        "Campaign of 2 cases of Study2D": Campaign(Study2D(), over={"seed": [0, 1]}),
        "CampaignFolder 'strength'": CampaignFolder("strength"),
        "CampaignResults 'strength': 0 finished, 1 failed, 0 to come": CampaignResults("strength", [failed]),
        "CaseResult 'seed=0': failed in 2 s, no room": failed,
        "LawReport: Signorini() conforms": findings,
        "Finding: interface holds": findings.findings[0],
        "check of finite of Signorini()": lmgcpy.testing.Check(lm.Signorini(), lmgcpy.testing.PROPERTIES["finite"]),
        "property finite: ": lmgcpy.testing.PROPERTIES["finite"],
    }


def netted() -> lm.Net:
    scene = lm.Scene(dimension=2)
    nodes = [scene.add(lm.point_mass(position=(i, 0), mass=1.0)) for i in range(2)]
    return scene.net(nodes, [(0, 1)], lm.RigidWire(), surface=lm.Thread(0.1))


def tied() -> lm.Joint:
    scene = lm.Scene(dimension=2)
    a, b = (scene.add(lm.disk(radius=0.1, position=(x, 0.0), mass=1.0)) for x in (0.0, 0.3))
    return scene.link(a, b, lm.BallJoint(), at=((0.15, 0.0), (-0.15, 0.0)))


def built_in():
    """A law of each class."""
    return (
        *(lm.Signorini(), lm.Coulomb(friction=0.3), lm.Restitution(restitution=0.5), lm.RigidWire(), lm.RigidRod()),
        lm.BallJoint(),
        lm.RollingCoulomb(friction=0.3, rolling_friction=0.1),
        *(lm.ElasticWire(stiffness=1.0), lm.ElasticRod(axial_rigidity=1.0)),
        *(lm.VoigtWire(stiffness=1.0, viscosity=1.0), lm.VoigtRod(stiffness=1.0, viscosity=1.0)),
    )


def continuous() -> dict[str, object]:
    """An object of every class of the continuous model."""
    crushing = np.linspace(0.001, 0.05, 30)
    measured = MeasuredCompression(
        axis="y", strain=np.column_stack([crushing, -crushing]), stress=np.tile([-1e5, -2e5], (30, 1))
    )
    fitted, directions = fit_sand(measured), isotropic(2, count=8)
    wire = WireNetwork(10.0, 1e4, directions, anchorage=0.1)
    point = TexSol(fitted.sand(), wire)
    state = point.start(1e5)
    strain = np.array([0.01, -0.01, 0.0])
    return {
        "<MeasuredCompression along y in 2D: 30 moments": measured,
        "<SandFit in 2D: critical": fitted,
        "<DruckerPrager in 2D: q/p": fitted.sand(),
        "<MohrCoulomb in 3D: q/p 0.9 at large shear": MohrCoulomb(3, 0.9, 0.004, 0.3, 0.03, 0.8, 0.7, 1e8, 1e8),
        "<Directions: 8 in 2D": directions,
        "<Spans: 2 in 2D": spans_of(np.eye(2), np.ones(2), 1.0),
        "<WireNetwork of 10 m/m^2": wire,
        "<GrowingAnchorage from 0.1 to 0.2 at a mean slip of 0.05": GrowingAnchorage([0.0, 0.05], [0.1, 0.2]),
        "<TexSol: <DruckerPrager": point,
        "<PointState of 3 components: plastic shear 0, 8 directions of wire": state,
        "<PointResponse of 3 components": point.material_point(strain, state),
        "<SandResponse of 3 components": fitted.sand().respond(strain, state.sand, 0.0),
        "<WireResponse of 8 directions, some slip": wire.respond(strain, state.slip, 1e2),
        "<DrivenPath along y of 3 increments in 2D": biaxial(TexSol(fitted.sand()), -crushing[:3], pressure=1e5),
    }


CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.1]])
TWO_FRAMES = TwoFrames(CORNERS, CORNERS)


@pytest.fixture(scope="module")
def all_things(tmp_path_factory):
    return {**things(tmp_path_factory.mktemp("things")), **continuous()}


def test_each_says_in_one_line_what_it_is(all_things):
    for words, thing in all_things.items():
        told = repr(thing)
        assert words in told
        assert "\n" not in told
        assert len(told) <= LONGEST, told
        assert "array(" not in told, told
        assert not re.search(r"0x[0-9a-f]{6}", told), told


LEFT_OUT = {
    **dict.fromkeys(("Body", "Contactor", "Law", "Sand", "Step", "Study"), "abstract"),
    **dict.fromkeys(("Compression", "CompressionRecord"), "through biaxial and triaxial tests"),
    "Recorder": "a protocol",
    **dict.fromkeys(("Solver", "Stepper"), "bases, whose words are those of the built-in solvers and of Simulation"),
    **dict.fromkeys(("Nonconformance", "NoSolution"), "exceptions"),
    "Statistics": "names of kernels, to be looked up",
}


def test_no_public_class_is_left_out(all_things):
    classes = {thing.__name__ for name in documented() if inspect.isclass(thing := reached(name))}
    looked_at = {type(thing).__name__ for thing in all_things.values()}
    assert classes - looked_at - set(LEFT_OUT) == set()


def test_notebooks_show_tables():
    """Of scenes, reports and measures: a row for each field, short arrays as numbers, long ones by their shape."""
    sim = hanging().run(steps=2)
    assert "<td>Disk &#x27;GRAIN&#x27;</td><td>3 bodies</td>" in sim.scene._repr_html_()
    assert "<td>chains</td><td>1 of ElasticWire(stiffness=10000" in sim.scene._repr_html_()
    assert "<tr><td>status</td><td>converged</td></tr>" in sim.report._repr_html_()
    assert "lock" not in sim.report._repr_html_()
    network = lm.measure.network(sim)._repr_html_()
    assert "<td>coordination</td><td>" in network
    table = lm.measure.wire_links(sim)._repr_html_()
    assert table.count("<tr>") == 2
    assert "<th>tension</th>" in table


def test_a_table_of_many_rows_shows_the_first():
    scene = lm.Scene(dimension=2)
    beads = [scene.add(lm.disk(radius=0.1, position=(0.3 * k, 0.0), mass=1.0)) for k in range(10)]
    scene.chain(beads, lm.RigidWire())
    table = lm.measure.wire_links(lm.Simulation(scene, time_step=1e-3).run(steps=1))._repr_html_()
    assert table.count("<tr>") == 1 + 5
    assert "and 4 more" in table
