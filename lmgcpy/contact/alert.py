"""Distances between surfaces: up to which gap a pair is an interaction, and up to which it is in the list of neighbours."""

from __future__ import annotations

import numpy as np

from lmgcpy.contact.detection_tables import ContactorTable, VisibilityRow

STEPS_A_LIST = 4
"""Number of steps at the greatest speed for which a list of neighbours is meant to last."""
FEW, STEPS_OF_FEW = 100, 20
"""With at most ``FEW`` contactors a list is meant to last ``STEPS_OF_FEW`` steps: to look at all of their pairs costs less
than to make a list."""


class Distances:
    """The alert distances of a visibility table and the reach of its lists of neighbours [m]."""

    def __init__(self, contactors: ContactorTable, rows: list[VisibilityRow], meets_walls: list[bool]):
        """``meets_walls``: whether contactors without bounds take part in a row."""
        self._rows = list(zip(rows, meets_walls, strict=True))
        bounded = np.isfinite(contactors.size)
        radii = contactors.size[bounded]
        self._largest = float(radii.max()) if len(radii) else 0.0
        self._lasting = STEPS_OF_FEW if len(radii) <= FEW else STEPS_A_LIST
        # a contactor off the centre of its body swings about it
        swing = np.sqrt((contactors.swing * contactors.swing).sum(axis=1))[bounded]
        self.cap = float((radii + swing).max()) if len(radii) else 0.0
        """Bound of the adaptive alert distance of two bounded contactors."""
        self._skin = max([0.2 * float(radii.min()) if len(radii) else 0.0, *(row.alert for row in rows)])
        greatest = [self.alert(row, np.inf) for row in rows if row.adaptive]
        fixed = [max(row.alert, row.reach) for row in rows]
        self.fullest = max(greatest + fixed) + max(self._skin, 0.5 * self._largest) if greatest else np.inf
        """Reach of the widest list; a list of this reach holds all pairs with walls."""

    def alert(self, row: VisibilityRow, travel: float, closing: float = 0.0) -> float:
        """Alert distance of a row [m]. If the user gave none, it covers the distance that two bodies at the greatest speed
        close in a step, ``travel`` each, up to the largest radius (with the offset of its contactor): a contact seen too
        late starts with a penetration. For contactors without bounds it covers ``closing``, however large that is. The
        reach of a law that acts at a distance is added. A distance that the user gave is raised to the reach."""
        if not row.adaptive:
            return max(row.alert, row.reach)
        return row.reach + max(row.alert, min(2.0 * travel, self.cap), closing)

    def widest_alert(self, travel: float, closing: float) -> float:
        """The greatest alert distance."""
        return max((self.alert(row, travel, closing if walls else 0.0) for row, walls in self._rows), default=0.0)

    def reach(self, widest: float, travel: float) -> float:
        """Reach of a list made now, ``widest`` being the greatest alert distance of bounded contactors: lists that last
        longer hold more pairs, and every step looks at all of them."""
        return widest + max(self._skin, min(2.0 * self._lasting * travel, 0.5 * self._largest))
