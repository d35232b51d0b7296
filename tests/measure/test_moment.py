"""The moment of which measures are: the last step, until the next one."""

import numpy as np
import pytest

import lmgcpy as lm


def in_a_box():
    """Disks in a box in the plane, some of them a wire, on a wall with ends."""
    scene = lm.Scene(dimension=2, gravity=(2.0, -10.0))
    disks = [
        scene.add(lm.disk(radius=0.1, position=(0.1 + 0.2 * i, 0.1 + 0.2 * j), mass=1.0))
        for j in range(4)
        for i in range(4)
    ]
    scene.chain(disks[4:8], lm.RigidWire())
    scene.add(lm.wall_segment((0.0, 0.0), (0.4, 0.0), (0.8, 0.0)))
    for point, normal in (((0, 0), (0, 1)), ((0, 0), (1, 0)), ((0.8, 0), (-1, 0)), ((0, 0.8), (0, -1))):
        scene.add(lm.wall(point=point, normal=normal))
    return (
        scene,
        lm.disk(radius=0.3, position=(0.4, 5.0), mass=1.0),
        lm.wall(point=(0.0, 0.6), normal=(0.0, -1.0), color="GRAIN"),
    )


def in_a_cell():
    """Spheres in a cell that is sheared, among them a thread, and bodies that turn."""
    scene = lm.Scene(dimension=3)
    scene.periodic(x=0.6, y=0.6, z=0.6).impose_rate(xz=1.0)
    for k, at in enumerate(np.ndindex(3, 3, 2)):
        velocity = np.array([0.1, 0.2, -0.3]) * (-1) ** k
        scene.add(lm.sphere(radius=0.1, position=0.1 + 0.2 * np.array(at), mass=1.0, velocity=velocity))
    scene.add(lm.capsule(radius=0.05, length=0.15, position=(0.3, 0.3, 0.5), mass=0.3, velocity=(0.0, 0.0, -1.0)))
    nodes = [
        scene.add(lm.point_mass(position=(0.1 + 0.1 * i, 0.4, 0.41), mass=0.1, velocity=(0, 0, -1.0))) for i in range(5)
    ]
    scene.chain(nodes, lm.ElasticWire(stiffness=1e4), surface=lm.Thread(radius=0.01, color="GRAIN"))
    return (
        scene,
        lm.capsule(radius=0.01, length=0.1, position=(0.3, 0.2, 0.5), mass=1.0),
        lm.sphere(radius=0.02, position=(0.1, 0.1, 0.5), mass=1.0),
    )


def one_step(scene):
    """A simulation of a scene after a step, and the positions of its bodies before."""
    for color in sorted({body.color for body in scene.bodies} & {"GRAIN", "WALL"}):
        scene.see("GRAIN", color, lm.Coulomb(friction=0.3))
    sim = lm.Simulation(scene, time_step=2e-3, overlap="ignore")
    since = sim.positions.copy()
    return sim.run(steps=1), since


def numbers(found, name=""):
    """The arrays of a measure by name."""
    if isinstance(found, tuple):
        found = dict(enumerate(found))
    parts = found if isinstance(found, dict) else getattr(found, "__dict__", None)
    if parts is None:
        return {name: np.array(found)}
    return {key: value for part, of in parts.items() for key, value in numbers(of, f"{name}.{part}").items()}


def all_measures(sim, since):
    """Every measure of a simulation that its scene allows; of single bodies, of those of which ``since`` has positions."""
    d, of = sim.model.dimension, lm.measure
    window = (np.full(d, 0.1), np.full(d, 0.5))
    found = {
        "stress": of.stress(sim),
        "particles": of.particle_stress(sim),
        "window": of.window_stress(sim, window),
        "network": of.network(sim),
        "contacts": of.contact_forces(sim),
        "kinds": of.contact_kinds(sim),
        "reactions": [of.reaction(sim, body, about=np.zeros(d)).moment for body in range(len(since))],
        "color": of.reaction(sim, "GRAIN"),
        "fields": of.coarse_fields(sim, width=0.1),
        "facets": of.facets(sim),
        "links": of.wire_links(sim),
        "wire": of.wire_contacts(sim),
        "along": of.forces_along(sim),
        "fabric": of.wire_fabric(sim),
        "strain": of.strain(sim, since=since),
        "mean": of.mean_strain(sim, since=since),
        "slip": of.bead_slip(sim, since=since),
        "interactions": sim.interactions,
    }
    found["turning"] = of.angular_momentum(sim) if d == 2 else of.long_axes(sim)
    return numbers(found)


@pytest.mark.parametrize("laid", [in_a_box, in_a_cell])
def test_measures_are_those_of_the_last_step_until_the_next(laid):
    """Bodies are added, a law gets another friction, time step and theta are set: no measure changes until the next step,
    before and after the simulation takes the statements over for a checkpoint."""
    scene, *later = laid()
    sim, since = one_step(scene)
    before = all_measures(sim, since)
    assert before[".contacts.normal"].sum() > 1.0

    def stay():
        after = all_measures(sim, since)
        assert after.keys() == before.keys()
        for name, value in before.items():
            np.testing.assert_array_equal(after[name], value, err_msg=name)

    for body in later:
        scene.add(body)
    scene.set_law("GRAIN", "GRAIN", lm.Coulomb(friction=0.1))
    sim.time_step, sim.theta = 1e-3, 1.0
    stay()
    assert not later[0].reaction.force.any()
    sim.checkpoint()
    stay()
    sim.step()
    assert len(lm.measure.particle_stress(sim)) >= len(before[".particles.body"]) + 1


@pytest.mark.parametrize("laid", [in_a_box, in_a_cell])
def test_hidden_bodies_are_left_out(laid):
    """Hidden bodies among the others, and a hidden wall across the box, change no measure."""
    (sim, since), (scene, *more) = one_step(laid()[0]), laid()
    for body in more:
        scene.add(body).hide()
    with_hidden, since_of_all = one_step(scene)
    one, other = all_measures(sim, since), all_measures(with_hidden, since_of_all)
    assert not other[".reactions"][len(since) :].any()
    other[".reactions"] = other[".reactions"][: len(since)]
    for name, value in one.items():
        if value.dtype.kind == "f":
            np.testing.assert_allclose(other[name], value, atol=1e-9, err_msg=name)
        else:
            np.testing.assert_array_equal(other[name], value, err_msg=name)


def test_bodies_that_are_hidden_in_a_run_count_up_to_the_last_step_that_they_made(tmp_path):
    """The lid and a disk, which are hidden after the second step: until then there are 16 disks in a box."""
    scene, *_ = in_a_box()
    sim, _ = one_step(scene)
    corner, lid = scene.bodies[15], scene.bodies[-1]

    def there(source, **frame):
        assert lm.measure.particle_stress(source, **frame).body.tolist() == list(range(16))
        assert lm.measure.strain(source, **frame, **since(frame)).body.tolist() == list(range(16))
        assert lm.measure.stress(source, **frame)["total"].shape == (2, 2)

    def gone(source, **frame):
        assert lm.measure.particle_stress(source, **frame).body.tolist() == list(range(15))
        assert lm.measure.strain(source, **frame, **since(frame)).body.tolist() == list(range(15))
        assert corner.id not in lm.measure.network(source, **frame).rattlers
        with pytest.raises(ValueError, match="Give volume="):
            lm.measure.stress(source, **frame)

    def since(frame):
        return {} if frame else {"since": start}

    def hide(sim):
        if sim.steps == 2:
            corner.hide()
            lid.hide()
            there(sim)

    start = sim.positions.copy()
    sim.run(steps=2, record=tmp_path / "run.h5", every=1, on_step=hide)
    gone(sim)
    with lm.io.open_run(tmp_path / "run.h5") as run:
        assert run.hidden(1).sum() == 2
        there(run, frame=1)
        gone(run, frame=2)
