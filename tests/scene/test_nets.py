"""Links of nets and membranes: their edges and reference gaps are in one order."""

import numpy as np
import pytest

import lmgcpy as lm

CORNERS = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)]


def four():
    scene = lm.Scene(dimension=3)
    return scene, [scene.add(lm.point_mass(position=place, mass=1.0)) for place in CORNERS]


def gaps_by_pair(net):
    """Reference gap of each link by its bodies."""
    found = {}
    for chain in net.chains:
        ids = [body.id for body in chain.bodies]
        for one, other, gap in zip(ids[:-1], ids[1:], chain.reference_gap.tolist(), strict=True):
            found[frozenset((one, other))] = gap
    return found


@pytest.mark.parametrize("surface", [None, lm.Thread(0.01)])
def test_edges_of_a_net_are_as_given_and_so_are_gaps(surface):
    scene, nodes = four()
    edges = [(3, 2), (0, 1), (3, 0), (2, 1)]
    gaps = [0.9, 1.0, 1.1, 1.2]
    net = scene.net(nodes, edges, lm.ElasticWire(stiffness=1.0), surface=surface, reference_gap=gaps)
    assert net.edges.tolist() == [list(edge) for edge in edges]
    by_pair = gaps_by_pair(net)
    assert [by_pair[frozenset(edge)] for edge in net.edges.tolist()] == gaps


def test_edges_of_a_membrane_are_sorted_and_so_are_gaps():
    scene, nodes = four()
    gaps = np.array([0.9, 1.3, 1.0, 1.1, 1.2])
    elastic = lm.ElasticWire(stiffness=1.0)
    membrane = scene.membrane(nodes, [(2, 1, 0), (3, 2, 0)], elastic, radius=0.01, reference_gap=gaps)
    assert membrane.edges.tolist() == [[0, 1], [0, 2], [0, 3], [1, 2], [2, 3]]
    by_pair = gaps_by_pair(membrane)
    assert [by_pair[frozenset(edge)] for edge in membrane.edges.tolist()] == gaps.tolist()


def test_an_edge_given_twice_is_refused():
    scene, nodes = four()
    with pytest.raises(ValueError, match="Two edges of a net join the same bodies"):
        scene.net(nodes, [(0, 1), (1, 0)], lm.ElasticWire(stiffness=1.0))
