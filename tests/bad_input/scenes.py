"""Materials, bodies, conditions, the scene and its chains."""

import math

import numpy as np
from bad_input.world import disk, wall

import lmgcpy as lm

nan, inf = math.nan, math.inf


def cluster(contactors, **more):
    return lm.RigidBody(contactors, **{"mass": 1.0, "inertia": 1.0, "position": (0, 0), "color": "GRAIN", **more})


class Shear(lm.RigidRod):
    """A link that would resist sideways motion too."""

    NAME = "test-shear"

    def rows(self, dimension):
        return dimension


class Ghost(lm.Body):
    """A body of a class from elsewhere whose numbers are those that it is given."""

    mass = inertia = 1.0
    contactors = ()
    extent = 1.0


class Egg(lm.Contactor):
    KIND = "test-egg"
    shape, bounding_radius, area, second_moment = (0.1,), 0.1, 1.0, 1.0


def massless():
    """A scene of a cell that yields, without bodies."""
    scene = lm.Scene(dimension=2)
    scene.periodic(x=1.0, y=1.0).impose_stress(xx=-1.0)
    return scene


def ghost(w, **numbers):
    """A simulation of a body from elsewhere."""
    w.scene.add(type("Ghost", (Ghost,), numbers)(position=(9, 9), color="GHOST"))
    return lm.Simulation(w.scene, time_step=1e-3)


# fmt: off
ROWS: dict[str, tuple] = {
    # ----------------------------------------------------------------------------------------------- materials, bodies
    "material without name": (lambda w: lm.Material("", density=1.0), TypeError,
        "name of a material must be a word, got ''"),
    "material named 3": (lambda w: lm.Material(3, density=1.0), TypeError, "must be a word, got 3"),
    "density zero": (lambda w: lm.Material("air", density=0.0), ValueError,
        "density of material 'air' must be above 0 kg/m^3, got 0 kg/m^3"),
    "density negative": (lambda w: lm.Material("air", density=-1.2), ValueError,
        "must be above 0 kg/m^3, got -1.2 kg/m^3"),
    "density NaN": (lambda w: lm.Material("air", density=nan), ValueError,
        "density of material 'air' must be finite, got nan"),
    "density in words": (lambda w: lm.Material("air", density="light"), TypeError,
        "must be a number in kg/m^3, got 'light'"),
    "density misspelt": (lambda w: lm.Material("air", densty=1.0), TypeError,
        "Material has no argument 'densty'; did you mean 'density'?"),
    "density missing": (lambda w: lm.Material("air"), TypeError,
        "Material needs density: Material(name=..., density=...)"),
    "density twice": (lambda w: lm.Material("air", 1.2, density=1.2), TypeError,
        "Material got density twice: once without a name and once as density=1.2"),
    "density without end": (lambda w: lm.Material("air", 1.2, 1.3), TypeError,
        "Material takes only name, density without a name, got 1.3 without one"),
    "radius negative": (lambda w: disk(radius=-1.0), ValueError, "radius of a disk must be above 0 m, got -1 m"),
    "radius zero": (lambda w: disk(radius=0), ValueError, "radius of a disk must be above 0 m, got 0 m"),
    "radius infinite": (lambda w: disk(radius=inf), ValueError, "radius of a disk must be finite, got inf"),
    "radius NaN": (lambda w: disk(radius=nan), ValueError, "radius of a disk must be finite, got nan"),
    "radius without end": (lambda w: disk(radius=1e200), ValueError,
        "radius of a disk must be at most 1e+70 m in size, got 1e+200 m"),
    "radius next to nothing": (lambda w: disk(radius=1e-200), ValueError,
        "radius of a disk must be at least 1e-70 m, got 1e-200 m"),
    "radius a whole number too long for a float": (lambda w: disk(radius=10**400), ValueError,
        "radius of a disk must be finite"),
    "radius True": (lambda w: disk(radius=True), TypeError, "radius of a disk must be a number in m, got True"),
    "radius of an object": (lambda w: disk(radius=object()), TypeError,
        "radius of a disk must be a number in m, got <object object>"),
    "radius missing": (lambda w: lm.disk(position=(0, 0), mass=1.0), TypeError,
        "disk needs radius: disk(radius=..., position=...)"),
    "disk by position": (lambda w: lm.disk(0.01, (0, 0)), TypeError, "disk takes its arguments by name only, got 0.01"),
    "argument of a disk misspelt": (lambda w: disk(colour="A"), TypeError,
        "disk has no argument 'colour'; did you mean 'color'?"),
    "argument that a body has not": (lambda w: lm.RigidBody([], mass=1.0, inertia=1.0, material=None), TypeError,
        "RigidBody has no argument 'material'", "Known: color, contactors, inertia, mass, position, rotation, spin"),
    "argument that a wall has not": (lambda w: lm.Wall(point=(0, 0), normal=(0, 1), coulor="WALL"), TypeError,
        "Wall has no argument 'coulor'; did you mean 'color'?"),
    "position of a wall": (lambda w: lm.Wall(normal=(0, 1), position=(0, 0), color="WALL"), TypeError,
        "Wall has no argument 'position'"),
    "neither mass nor material": (lambda w: disk(material=None), TypeError, "A disk needs a material= or a mass= [kg]"),
    "material a word": (lambda w: disk(material="sand"), TypeError, "must be a lmgcpy.Material, got 'sand'"),
    "mass zero": (lambda w: disk(mass=0.0), ValueError, "mass of a disk must be above 0 kg, got 0 kg"),
    "mass NaN": (lambda w: disk(mass=nan), ValueError, "mass of a disk must be finite, got nan"),
    "inertia negative": (lambda w: disk(inertia=-1.0), ValueError, "inertia of a disk must be above 0, got -1"),
    "position of three numbers": (lambda w: disk(position=(0, 0, 0)), ValueError,
        "position of a Disk must be 2 numbers in dimension 2, got 3 numbers: (0, 0, 0)"),
    "position in words": (lambda w: disk(position="here"), TypeError,
        "position of a Disk must be 2 numbers, got 'here'"),
    "position of words": (lambda w: disk(position=("1", "2")), TypeError,
        "position of a Disk must be 2 numbers, got ('1', '2')"),
    "position ragged": (lambda w: disk(position=(1, (2, 3))), TypeError,
        "position of a Disk must be 2 numbers, got (1, (2, 3))"),
    "position half None": (lambda w: disk(position=(None, 1.0)), TypeError,
        "position of a Disk must be 2 numbers, got (None, 1.0)"),
    "position complex": (lambda w: disk(position=(1j, 0)), TypeError,
        "position of a Disk must be 2 numbers, got (1j, 0)"),
    "position NaN": (lambda w: disk(position=(0.0, nan)), ValueError,
        "position of a Disk must be finite, got (0.0, nan)"),
    "velocity a table": (lambda w: disk(velocity=[[0.0, 1.0]]), ValueError,
        "velocity of a Disk must be 2 numbers in dimension 2, got an array of shape (1, 2)"),
    "velocity infinite": (lambda w: disk(velocity=(inf, 0)), ValueError,
        "velocity of a Disk must be finite, got (inf, 0)"),
    "spin in words": (lambda w: disk(spin="fast"), TypeError, "spin must be a number, got 'fast'"),
    "no colour": (lambda w: disk(color=""), TypeError, "color of a Disk must be a word such as 'GRAIN', got ''"),
    "point a number in an array": (lambda w: wall(point=np.array(3.0)), ValueError,
        "point of a Wall must be 2 numbers in dimension 2, got an array of shape (): array(3.)"),
    "normal zero": (lambda w: wall(normal=(0, 0)), ValueError, "normal of a wall must not be zero"),
    "normal NaN": (lambda w: wall(normal=(nan, 1)), ValueError, "normal of a wall must be finite, got (nan, 1)"),
    "normal in space": (lambda w: wall(normal=(0, 0, 1)), ValueError,
        "normal of a wall must be 2 numbers in dimension 2"),
    "point in words": (lambda w: wall(point="origin"), TypeError, "point of a Wall must be 2 numbers, got 'origin'"),
    "mass of a wall": (lambda w: wall(mass=-2.0), ValueError, "mass of a wall must be above 0 kg, got -2 kg"),
    "radius of a contactor": (lambda w: lm.DiskContactor(-0.1), ValueError,
        "radius of a disk must be above 0 m, got -0.1 m"),
    "cluster of nothing": (lambda w: cluster([]), TypeError, "needs a list of at least one contactor, got []"),
    "cluster of bodies": (lambda w: cluster([disk()]), TypeError,
        "must be Contactor objects or pairs (contactor, offset), got <Disk"),
    "offset of three numbers": (lambda w: cluster([(lm.DiskContactor(1.0), (0, 0, 0))]), ValueError,
        "offset of a contactor must be 2 numbers"),
    "inertia of a cluster": (lambda w: cluster([lm.DiskContactor(1.0)], inertia=0), ValueError,
        "inertia of a rigid body must be above 0 kg m^2, got 0 kg m^2"),
    "mass of a foreign body": (lambda w: ghost(w, mass=nan), ValueError,
        "The mass and inertia of <Ghost 'GHOST', body 5", "must be above 0, got [nan"),
    "bound of a foreign contactor": (
        lambda w: ghost(w, contactors=[(type("E", (Egg,), {"bounding_radius": -1.0})(), (0, 0))]), ValueError,
        "bounding_radius of a contactor of <Ghost", "must be above 0, got -1.0"),
    "shape of a foreign contactor": (
        lambda w: ghost(w, contactors=[(type("E", (Egg,), {"shape": (nan,)})(), (0, 0))]), ValueError,
        "shape of a contactor of <Ghost", "must be finite, got [nan"),
    "start spoilt in place": (lambda w: (w.beads[2].position.fill(nan), w.start()), ValueError,
        "The position of <Disk 'BEAD', body 2", "must be finite, got [nan, nan, 0.0]"),
    # ------------------------------------------------------------------------------------------------------ conditions
    "component unknown": (lambda w: w.beads[0].fix("z"), ValueError,
        "fix: a body in 2D has no component 'z'. Known: spin, x, y"),
    "component misspelt": (lambda w: w.beads[0].impose_velocity(spinn=1.0), ValueError,
        "impose_velocity: a body in 2D has no component 'spinn'; did you mean 'spin'?"),
    "component a list": (lambda w: w.beads[0].fix(["x", "y"]), TypeError,
        "fix takes names of components, as in fix('x', 'y'), got ['x', 'y']"),
    "no component": (lambda w: w.beads[0].impose_force(), TypeError,
        "impose_force needs a component, for example impose_force(y=0.0)"),
    "component without name": (lambda w: w.beads[0].impose_force(1.0), TypeError,
        "Disk.impose_force takes its arguments by name only, got 1.0"),
    "velocity in words": (lambda w: w.beads[0].impose_velocity(x="slow"), TypeError,
        "impose_velocity(x=...) must be a number, got 'slow'"),
    "velocity NaN": (lambda w: w.beads[0].impose_velocity(x=nan), ValueError,
        "impose_velocity(x=...) must be finite, got nan"),
    "force infinite": (lambda w: w.beads[0].impose_force(x=inf), ValueError,
        "impose_force(x=...) must be finite, got inf"),
    "driven, then loaded": (lambda w: w.beads[0].fix("x").impose_force(x=1.0), ValueError,
        "Component x of <Disk 'BEAD', body 0,",
        "is driven by impose_velocity or fix already and cannot be loaded as well"),
    "loaded, then driven": (lambda w: w.beads[0].impose_force(spin=1.0).fix(), ValueError,
        "Component spin of <Disk 'BEAD', body 0,", "is loaded by impose_force already and cannot be driven as well"),
    "wall loaded without mass": (lambda w: w.wall.impose_force(y=1.0), ValueError,
        "<Wall 'WALL', body 4,", "has no mass: give it one where it is made, so that a load on y can move it"),
    "spin of a wall": (lambda w: w.wall.impose_velocity(spin=1.0), ValueError, "A wall does not turn"),
    "moment on a wall": (lambda w: w.wall.impose_force(spin=1.0), ValueError, "A wall does not turn"),
    "velocity as text from a function": (lambda w: (w.beads[1].impose_velocity(y=lambda t: "1"), w.start()), TypeError,
        "What is imposed on component y of body 1 at t = 0 s must be a number, got '1'"),
    "velocity from a function that fails": (
        lambda w: (w.beads[1].impose_velocity(y=lambda t: 1 / t), w.start()), RuntimeError,
        "imposed on component y of body 1 at t = 0 s failed with ZeroDivisionError"),
    # ------------------------------------------------------------------------------------------------------- the scene
    "dimension four": (lambda w: lm.Scene(dimension=4), ValueError, "dimension must be at most 3, got 4"),
    "dimension in words": (lambda w: lm.Scene(dimension="2"), TypeError, "dimension must be a whole number, got '2'"),
    "dimension missing": (lambda w: lm.Scene(), TypeError, "Scene needs dimension: Scene(dimension=...)"),
    "gravity a number": (lambda w: lm.Scene(dimension=2, gravity=9.81), ValueError,
        "gravity must be 2 numbers in dimension 2, got an array of shape (): 9.81"),
    "gravity NaN": (lambda w: lm.Scene(dimension=2, gravity=(0, nan)), ValueError,
        "gravity must be finite, got (0, nan)"),
    "gravity misspelt": (lambda w: lm.Scene(dimension=2, gravty=(0, 0)), TypeError,
        "Scene has no argument 'gravty'; did you mean 'gravity'?"),
    "no body added": (lambda w: w.scene.add("disk"), TypeError,
        "Scene.add takes a body such as lmgcpy.disk(...), got 'disk'"),
    "body added twice": (lambda w: w.scene.add(w.beads[1]), ValueError,
        "<Disk 'BEAD', body 1,", "is in this scene already"),
    "body of another scene": (lambda w: w.scene.add(w.old), ValueError, "is in another scene already: make a new body"),
    "colour a number": (lambda w: w.scene.see("BEAD", 3, lm.Signorini()), TypeError,
        "A colour is a word such as 'GRAIN', got 3"),
    "colour that nobody has": (lambda w: (w.scene.see("BEED", "WALL", lm.Signorini()), w.start()), LookupError,
        "No body has the colour 'BEED' that the visibility table names; did you mean 'BEAD'? Known: BEAD, WALL"),
    "colour of very many": (lambda w: (w.many_colours(), w.start()), LookupError, "did you mean 'C7'?", "and 12 more"),
    "seen twice": (lambda w: (w.scene.see("BEAD", "GRAIN", lm.Coulomb(friction=0.3)),
        w.scene.see("GRAIN", "BEAD", lm.Signorini())), ValueError,
        "lets 'BEAD' and 'GRAIN' touch under Coulomb(friction=0.3) already", "'BEAD' under Signorini() would act on"),
    "law a word": (lambda w: w.scene.see("BEAD", "WALL", "coulomb"), TypeError,
        "Scene.see takes a law such as", "got 'coulomb'"),
    "law a class": (lambda w: w.scene.see("BEAD", "WALL", lm.Signorini), TypeError,
        "Scene.see takes a law such as", "Signorini'>"),
    "law of links for a contact": (lambda w: w.scene.see("BEAD", "WALL", lm.RigidRod()), TypeError,
        "Law 'rigid-rod' is for a link: give it to Scene.chain, not Scene.see"),
    "law of contacts for a chain": (lambda w: w.scene.chain(w.beads, lm.Signorini()), TypeError,
        "Law 'signorini' is for a contact: give it to Scene.see, not Scene.chain"),
    "law of two components for a chain": (lambda w: w.scene.chain(w.beads, Shear()), TypeError,
        "Law 'test-shear' has 2 components: a link acts along its line only"),
    "alert negative": (lambda w: w.scene.see("BEAD", "WALL", lm.Signorini(), alert=-1.0), ValueError,
        "alert between 'BEAD' and 'WALL' must be at least 0 m, got -1 m"),
    "alert NaN": (lambda w: w.scene.see("BEAD", "WALL", lm.Signorini(), alert=nan), ValueError,
        "alert between 'BEAD' and 'WALL' must be finite"),
    "strangers meet": (
        lambda w: (w.scene.see("GHOST", "WALL", lm.Signorini()), ghost(w, contactors=[(Egg(), (0, 0))])), LookupError,
        "how contactors 'test-egg' and 'wall' meet"),
    # ---------------------------------------------------------------------------------------------------------- chains
    "chain of one": (lambda w: w.scene.chain(w.beads[:1], lm.RigidRod()), ValueError,
        "A chain needs at least 2 bodies, got 1"),
    "chain of a body": (lambda w: w.scene.chain(w.beads[0], lm.RigidRod()), TypeError,
        "A chain links a list of bodies, got <Disk"),
    "ring of two": (lambda w: w.scene.chain(w.beads[:2], lm.RigidRod(), closed=True), ValueError,
        "A closed chain needs at least 3 bodies, got 2"),
    "chain of numbers": (lambda w: w.scene.chain([0, 1], lm.RigidRod()), TypeError,
        "A chain links bodies of the scene, or points (body, point) of them, got 0"),
    "chain of a stranger": (lambda w: w.scene.chain([w.beads[0], disk()], lm.RigidRod()), ValueError,
        "body not yet in a scene", "is not in this scene: add it before it is linked"),
    "chain of another scene's": (lambda w: w.scene.chain([w.beads[1], w.old], lm.RigidRod()), ValueError,
        "is not in this scene"),
    "bead twice in a chain": (lambda w: w.scene.chain([*w.beads, w.beads[0]], lm.RigidRod()), ValueError,
        "body 0,", "is in the chain twice; closed=True links the last body to the first"),
    "closed in words": (lambda w: w.scene.chain(w.beads, lm.RigidRod(), closed="no"), TypeError,
        "closed must be True or False, got 'no'"),
    "gaps too few": (lambda w: w.scene.chain(w.beads, lm.RigidWire(), reference_gap=[0.01, 0.01]), ValueError,
        "reference_gap must be a number [m], 3 numbers (one a link), a function of time or None, got [0.01, 0.01]"),
    "gap in words": (lambda w: w.scene.chain(w.beads, lm.RigidWire(), reference_gap="wide"), TypeError,
        "reference_gap must be a number [m]", "got 'wide'"),
    "gap NaN": (lambda w: w.scene.chain(w.beads, lm.RigidWire(), reference_gap=nan), ValueError,
        "reference_gap must be finite, got nan"),
    "length negative": (
        lambda w: w.scene.chain(w.beads, lm.ElasticWire(stiffness=1.0), reference_gap=-0.03), ValueError,
        "Link 0 of the chain has no length at its reference between the centres of",
        "-0.01 m: give a larger reference_gap"),
    "centres that coincide": (lambda w: w.scene.chain([w.beads[0], w.scene.add(disk())], lm.RigidRod()), ValueError,
        "Link 0 of the chain starts with no distance between the centres", "move one of them"),
    "wire too short": (lambda w: w.scene.chain(w.beads, lm.RigidWire(), reference_gap=0.009), ValueError,
        "Link 0 of the chain, between", "has a gap of 0.01 m where its reference is 0.009 m", "blow"),
    "rod too long": (lambda w: w.scene.chain(w.beads, lm.RigidRod(), reference_gap=[0.01, 0.011, 0.01]), ValueError,
        "Link 1 of the chain"),
    "relaxation negative": (lambda w: w.scene.chain(w.beads, lm.RigidRod(), relaxation=-1.0), ValueError,
        "relaxation of a chain must be at least 0 s, got -1 s"),
    # ---------------------------------------------------------------------------------------- editing what is compiled
    "add a sphere after": (lambda w: w.done.add(lm.sphere(radius=0.1, position=(0, 0, 0), mass=1.0)), ValueError,
        "is of dimension 3, this scene of dimension 2"),
    # ---------------------------------------------------------------------------------------------------- periodic cells
    "periodic without edge": (lambda w: w.scene.periodic(), TypeError, "periodic needs the edge of a direction"),
    "periodic along z in 2D": (lambda w: w.scene.periodic(z=1.0), ValueError, "A scene in 2D has no direction z"),
    "periodic by a negative length": (lambda w: w.scene.periodic(x=-1.0), ValueError,
        "edge x of a periodic cell must be above 0 m, got -1 m"),
    "periodic in words": (lambda w: w.scene.periodic(x="wide"), TypeError,
        "edge x of a periodic cell must be a number in m, got 'wide'"),
    "periodic edge beside its axis": (lambda w: w.scene.periodic(x=(0.0, 1.0), y=1.0), ValueError,
        "The edge x of a periodic cell must go along x"),
    "periodic edge that leans on nothing": (lambda w: w.scene.periodic(x=(1.0, 0.5)), ValueError,
        "Edge x goes along y as well, which is not periodic"),
    "periodic edges in a line": (lambda w: w.scene.periodic(x=(1.0, 1.0), y=(1.0, 1.0001)), ValueError,
        "The edges of a periodic cell lie in one line or plane"),
    "periodic twice": (lambda w: (w.scene.periodic(x=1.0), w.scene.periodic(y=1.0)), ValueError,
        "This scene is periodic already"),
    "periodic inertia zero": (lambda w: w.scene.periodic(x=1.0, inertia=0.0), ValueError,
        "inertia of a periodic cell must be above 0 kg m^2"),
    "periodic after": (lambda w: w.done.periodic(x=1.0), RuntimeError, "Cannot make it periodic"),
    "rate of no component": (lambda w: w.scene.periodic(x=1.0).impose_rate(xy=1.0), ValueError,
        "impose_rate: this cell has no component 'xy'"),
    "rate of nothing": (lambda w: w.scene.periodic(x=1.0).impose_rate(), TypeError, "impose_rate needs a component"),
    "rate in words": (lambda w: w.scene.periodic(x=1.0).impose_rate(xx="fast"), TypeError,
        "impose_rate(xx=...) must be a number, got 'fast'"),
    "stress on a cell with open sides": (lambda w: w.scene.periodic(x=1.0).impose_stress(xx=-1.0), ValueError,
        "A stress acts on a cell that is periodic in all 2 directions; this one is so in 1"),
    "stress on a cell without mass": (lambda w: lm.Simulation(massless(), time_step=1e-3), ValueError,
        "no body has a mass from which its inertia would follow"),
    "component of a cell by number": (lambda w: w.scene.periodic(x=1.0).fix(3), TypeError,
        "fix takes names of components"),
    "edge hidden": (lambda w: (w.scene.periodic(x=1.0), w.scene.bodies[-1].hide()), TypeError,
        "cannot be hidden: the bodies would have no images"),
    "wrapped in 3D": (lambda w: w.scene.periodic(x=1.0).wrapped([[1.0, 2.0, 3.0]]), ValueError,
        "positions must have shape (m, 2) [m], got (1, 3)"),
    "wall across a face": (lambda w: (w.scene.periodic(y=1.0), lm.Simulation(w.scene, time_step=1e-3)), ValueError,
        "cuts the faces of the periodic cell"),
    "see after": (lambda w: w.done.see("GRAIN", "GRAIN", lm.Signorini()), RuntimeError,
        "Cannot extend the visibility table"),
    "chain after": (lambda w: w.done.chain([w.old], lm.RigidRod()), RuntimeError, "Cannot add a chain"),
    "compile twice": (lambda w: lm.Simulation(w.done, time_step=1e-3), RuntimeError, "Cannot compile the scene again"),
    "colour after": (lambda w: setattr(w.old, "color", "RED"), RuntimeError, "set its color before Simulation"),
}
# fmt: on
