"""Colours with a meaning, the same in every picture and figure."""

SAND, BEAD, WIRE = "#d9cba3", "#9ab7dd", "#1b4f9c"
"""Grains; beads; wires and links in tension."""
CONTACT, PUSHING, COHESION = "#b2182b", "#e08214", "#35978f"
"""Contact reactions, links in compression, contacts in tension."""
WRONG = "#ff0000"
"""Overlaps and links that are too long."""
EDGE, GROUND = "#404040", "#eeeeee"
"""Edges of walls, and floors."""
GROUPS = ["#d9cba3", "#8da0cb", "#fc8d62", "#66c2a5", "#e78ac3", "#a6d854", "#b3b3b3"]
"""Colours of the visibility table, in the order in which they occur."""
CURVES = {
    "none": "#8c6d31",
    "rigid-wire": "#1b4f9c",
    "rigid-rod": "#b2182b",
    "elastic-wire": "#35978f",
    "elastic-rod": "#762a83",
}
"""Colours of the curves of tests, by the law of the wire."""
