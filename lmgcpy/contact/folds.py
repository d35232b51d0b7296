"""Folds of threads: contacts of a thread with itself beside a slack link.

Segments that share a node do not meet. So a thread that is folded at a short link would go through itself there: of the
segments before and after the link the one has its nearest point to the other on the link, which shares a node with each.
Therefore the normal from a node to a segment, or to a node, may lie in the cone of the link between them.

A link that is shorter than the thread is thick keeps its ends in each other. Contacts beside it do not let them come
closer, and have no overlap.
"""

from __future__ import annotations

import math

from lmgcpy.contact.contactor_pairs import APART
from lmgcpy.contact.features import (
    SLACK,
    ball_edge,
    corner_at,
    corner_corner,
    dot,
    edge_axis,
    edge_edge,
    faces_corner,
    gap_below,
    less,
    to_body,
    to_space,
)
from lmgcpy.contact.frames import cross


def node_segment(position_c, shape_c, position_a, shape_a):
    """A node and a segment: a corner and an edge, or the edge folded back onto the corner."""
    answer = ball_edge(corner_at(position_c, shape_c), shape_c[0], position_a, shape_a, SLACK)
    if answer[0] == math.inf or faces_corner(answer[1], position_c, shape_c):
        return answer
    return folded(answer, link_to_edge(answer[1], position_c, shape_c, position_a, shape_a), shape_c[0] + shape_a[0])


def node_node(position_c, shape_c, position_a, shape_a):
    """Two nodes: two corners, or the thread folded at the node between them.

    It is met once it overlaps: which corner lies between two others is known by directions alone, and a contact from afar
    that is none would be a bump.
    """
    answer = corner_corner(position_c, shape_c, position_a, shape_a)
    if answer[0] < math.inf:
        return answer
    c = corner_at(position_c, shape_c)
    d = less(c, corner_at(position_a, shape_a))
    distance = math.sqrt(dot(d, d))
    if not 0.0 < distance < shape_c[0] + shape_a[0]:
        return APART
    n = (d[0] / distance, d[1] / distance, d[2] / distance)
    link = shorter_link(d, distance, position_c, shape_c, position_a, shape_a)
    return folded(gap_below(c, shape_c[0], distance, n, shape_a[0]), link, shape_c[0] + shape_a[0])


def segment_segment(position_c, shape_c, position_a, shape_a):
    """Two segments, or edges of membranes, that cross between their ends."""
    answer = edge_edge(position_c, shape_c, position_a, shape_a)
    if answer[0] >= 0.0 or has_faces(shape_a) or has_faces(shape_c):
        return answer
    c, h = edge_axis(position_c, shape_c)
    a, k = edge_axis(position_a, shape_a)
    return folded(answer, nearest_ends(less(c, a), h, k), shape_c[0] + shape_a[0])


def folded(answer, link, thickness):
    """The answer for two parts of a thread that is folded at a link between them, of this length; :data:`APART` if the
    length is 0."""
    if link == 0.0:
        return APART
    return (max(answer[0], 0.0) if link < thickness else answer[0]), answer[1], answer[2]


def link_to_edge(n, position_c, shape_c, position_a, shape_a):
    """Length of the edge from a corner to an end of another edge that is folded back onto the corner: the normal n to the
    corner is in its cone but for the edge between them. 0 if there is none, and if the other edge has faces."""
    if has_faces(shape_a):
        return 0.0
    y = to_body(position_c, (-n[0], -n[1], -n[2]))
    q = corner_at(position_c, shape_c)
    first = to_body(position_c, less(corner_at(position_a, shape_a), q))
    second = to_body(position_c, less(corner_at(position_a, shape_a[3:7]), q))
    link = 0.0
    for k in range(4, len(shape_c), 3):
        e = (shape_c[k], shape_c[k + 1], shape_c[k + 2])
        if dot(y, e) > SLACK:
            if leads_to(e, first):
                link = dot(e, first)
            elif leads_to(e, second):
                link = dot(e, second)
            else:
                return 0.0
    return link


def leads_to(e, way):
    """Whether a way has the direction e."""
    across = cross(e, way)
    return dot(e, way) > 0.0 and dot(across, across) <= SLACK * SLACK * dot(way, way)


def has_faces(shape):
    """Whether an edge has a face."""
    one, other = (shape[10], shape[11], shape[12]), (shape[13], shape[14], shape[15])
    return dot(one, one) > 0.0 or dot(other, other) > 0.0


def shorter_link(d, distance, position_c, shape_c, position_a, shape_a):
    """Length of the shorter of two edges that end at one corner, from two others, the first at ``d`` from the second: the
    normal is in the cones of both but for these edges. 0 if there are none, and for corners of nets and membranes."""
    if spokes(shape_c) > 2 or spokes(shape_a) > 2:
        return 0.0
    slack = SLACK * distance
    for i in range(4, len(shape_c), 3):
        e = to_space(position_c, (shape_c[i], shape_c[i + 1], shape_c[i + 2]))
        for j in range(4, len(shape_a), 3):
            f = to_space(position_a, (shape_a[j], shape_a[j + 1], shape_a[j + 2]))
            # d = s f - t e, as both lead to one place: s m = d x e and t m = d x f with m = f x e
            m = cross(f, e)
            square = dot(m, m)
            if not (square > SLACK and abs(dot(d, m)) <= slack * math.sqrt(square)):
                continue
            link = min(dot(cross(d, e), m), dot(cross(d, f), m)) / square
            if link > slack:
                back = to_body(position_c, (-d[0], -d[1], -d[2]))
                met = in_cone_but(back, shape_c, i, slack) and in_cone_but(to_body(position_a, d), shape_a, j, slack)
                return link if met else 0.0
    return 0.0


def spokes(shape):
    """How many corners are next to a corner."""
    count = 0
    for k in range(4, len(shape), 3):
        if shape[k] != 0.0 or shape[k + 1] != 0.0 or shape[k + 2] != 0.0:
            count += 1
    return count


def in_cone_but(y, shape, without, slack):
    """Whether a vector from a corner points away from all corners next to it but the one whose direction begins there."""
    for k in range(4, len(shape), 3):
        if k != without and y[0] * shape[k] + y[1] * shape[k + 1] + y[2] * shape[k + 2] > slack:
            return False
    return True


def nearest_ends(d, h, k):
    """The least distance of the ends of two edges from ``d`` to ``d + h`` and from 0 to k: if a link is between them, it is
    no shorter."""
    least = min(dot(d, d), square_between(d, k))
    e = (d[0] + h[0], d[1] + h[1], d[2] + h[2])
    return math.sqrt(min(least, dot(e, e), square_between(e, k)))


def square_between(u, v):
    """Square of the distance of two points."""
    return dot(less(u, v), less(u, v))


FOLDS = {("corner", "edge"): node_segment, ("corner", "corner"): node_node, ("edge", "edge"): segment_segment}
"""Narrow phases of two features of surfaces between bodies that differ from their narrow phases on bodies."""
