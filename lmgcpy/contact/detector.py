"""Detection: from the positions at the middle of a step to its interactions, in canonical order.

Chains come first, in the order in which they were made, then contacts by row of the visibility table and kind of
contactor pair, and then by ids. The list of neighbours is made anew only when something has moved as far as the list
allows; the interactions do not depend on when it was made. In large scenes interactions are sorted by place instead of by
ids (:mod:`lmgcpy.contact.slabs`), the place of the bodies when the list was made.
"""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from typing import Any

import numpy as np

from lmgcpy.contact import narrow_phase, narrow_phase_3d, narrow_phase_elements
from lmgcpy.contact.broad_phase import ExcludedPairs, near_pairs
from lmgcpy.contact.contactor_pairs import refuse_levers
from lmgcpy.contact.detection_tables import ChainTable, ContactorTable, VisibilityRow
from lmgcpy.contact.elements import Elements, elements_form
from lmgcpy.contact.foreign_pairs import check_narrow_phase, check_points, listing_fault, narrow_fault
from lmgcpy.contact.groups import Group, check_pairs, contact_group, meets_walls
from lmgcpy.contact.images import Images, Seen
from lmgcpy.contact.interactions import Interactions, empty_interactions
from lmgcpy.contact.lattice import Lattice, crossing
from lmgcpy.contact.links import LINKS, detect_at_points
from lmgcpy.contact.memory import LastStep, Memory, surfaces_met
from lmgcpy.contact.neighbours import Distances, KindPair, Surroundings, kind_pairs, neighbours
from lmgcpy.contact.positions import largest_move, place_in_plane, place_in_space
from lmgcpy.contact.segments import are_long, within_reach
from lmgcpy.contact.slabs import Slabs, cut_bodies, is_large


class Detector:
    """Keeps the neighbours of a scene, and the impulses and states of the last step."""

    def __init__(
        self,
        contactors: ContactorTable,
        rows: list[VisibilityRow],
        chains: list[ChainTable],
        inverse_mass: np.ndarray,
        dimension: int = 2,
        apart: np.ndarray | None = None,
        lattice: Lattice | None = None,
    ):
        """``apart``: pairs of bodies that never meet, (p, 2), the lower first, sorted; None if there are none.
        ``lattice``: the lattice of a periodic cell, None without a cell."""
        self.contactors = contactors
        self.rows = rows
        self.chains = chains
        self.inverse_mass = inverse_mass
        self.dimension = dimension
        check_pairs(contactors, rows)
        self._narrow_phase = (narrow_phase if dimension == 2 else narrow_phase_3d).detect_contacts
        self._bounded: np.ndarray = np.isfinite(contactors.bounding_radius)
        self._unbounded = np.flatnonzero(~self._bounded)
        self._free = self._movable(inverse_mass)
        self._elements: Elements | None = None
        """The elements where they are now."""
        self._excluded = ExcludedPairs(np.zeros((0, 2), np.int64) if apart is None else apart, len(inverse_mass))
        self._in_place = not contactors.offset.any() and np.array_equal(contactors.body, np.arange(len(inverse_mass)))
        self._shapes = np.array(contactors.shape, order="C").ravel()  # those of elements are written anew at each detection
        self._stride = contactors.shape.shape[1]
        self._kinds = [kind_pairs(contactors, row) for row in rows]
        if dimension == 3 and contactors.turns is None:
            for kinds in (kinds for of_row in self._kinds for kinds in of_row):
                refuse_levers(kinds.candidate, kinds.antagonist)
        # in space, spins of bodies that keep a rotation are along their own axes
        off_centre = contactors.offset.any(axis=1) if dimension == 2 else contactors.turns
        rows_off = [] if off_centre is None else np.flatnonzero(off_centre).tolist()
        self._off_centre = {contactors.color[k] for k in rows_off}
        """Colours of contactors whose levers may turn spins into normal velocities."""
        with_walls = [any(meets_walls(kinds, self._bounded) for kinds in of_row) for of_row in self._kinds]
        self._looked_at: set[tuple[str, str]] = set()
        """Kinds whose narrow phase, a foreign one, was asked before it is compiled."""
        self._distances = Distances(contactors, rows, with_walls)
        radii = contactors.size[np.isfinite(contactors.size)]
        self._images = None if lattice is None else Images(lattice, contactors, self._bounded)
        pairs_of_kinds = [kinds for of_row in self._kinds for kinds in of_row]
        self._corners = max((sum(n for n in kinds.corners if n > 1) for kinds in pairs_of_kinds), default=0)
        """Most corners of elements that both sides of an interaction have."""
        self._partitioned = is_large(len(radii), dimension) and contactors.elements is None
        self._radii = contactors.bounding_radius
        """Bounding radii now [m], (k,): elements may become longer."""
        self._usual = float(np.quantile(radii, 0.95)) if len(radii) else 0.0
        self._hidden: np.ndarray | None = None
        """Whether each contactor is hidden, (k,) bool; None if none is."""
        self._reach = 0.0
        self._listed_at: np.ndarray | None = None
        self._listed_radii = self._radii
        """Bounding radii then [m], (k,)."""
        self._listed_centres: Any = None
        """The same positions with the centres of the bounding spheres in place of the contactors' own."""
        self.groups: list[Group] = []
        self._surfaces: np.ndarray | None = None
        """Number of what meets which surface for each slot, see :func:`~lmgcpy.contact.memory.surfaces_met`."""
        self.place: np.ndarray | None = None
        """Place of each body in the order of the sweep, (n,); None without slabs."""
        laws = [row.law for row in rows] + [chain.law for chain in chains]
        self.state_names = list(dict.fromkeys(name for law in laws for name in law.states()))
        self.rolling_rows = max([0, *(row.law.rows(dimension) - dimension for row in rows)])
        """Number of rolling components that contacts of the scene have at the most."""
        self._last = LastStep(dimension + self.rolling_rows, max((len(law.states()) for law in laws), default=0) + 1)
        self._make_room()
        self.rebuilds = 0

    def _make_room(self) -> None:
        """Begin with arrays for no interactions, without couplings where inverse masses make none."""
        kinds_of_mass = [self.inverse_mass[:, : self.dimension], self.inverse_mass[:, self.dimension :]]
        alike = all((part == part[:, :1]).all() for part in kinds_of_mass)
        # the edges of a cell that yields may couple the components of every contact
        central = self.contactors.turns is None
        self._plain = self.dimension == 3 and not self.chains and alike and central and self._images is None
        self._plain = self._plain and not self._corners
        self._capacity = empty_interactions(0, True, self.dimension, plain=self._plain, corners=self._corners)
        self._found = self._capacity.cut(0)

    def __copy__(self) -> Detector:
        """An independent detector. It shares arrays: they are replaced in a step, never changed in place. Only the memory
        of the last step and the images are copied."""
        other = object.__new__(type(self))
        other.__dict__.update(self.__dict__)
        other._last = self._last.__copy__()
        if self._images is not None:
            other._images = copy(self._images)
        return other

    def _movable(self, inverse_mass: np.ndarray) -> np.ndarray:
        """Whether a body of each contactor has a component that is not held, (k,) bool."""
        free: np.ndarray = inverse_mass.max(axis=1, initial=0.0) > 0.0
        return self._of_contactors(free)

    def _of_contactors(self, bodies: np.ndarray) -> np.ndarray:
        """Whether something is true (n,) of a body of each contactor, (k,) bool."""
        result: np.ndarray = bodies[self.contactors.body]
        elements = self.contactors.elements
        if elements is not None:
            result[elements.rows] |= bodies[elements.corner].any(axis=1)
        return result

    def hide(self, bodies: np.ndarray) -> None:
        """Leave out the contactors of some bodies (n,) bool, from the next list of neighbours on."""
        self._hidden = self._of_contactors(bodies) if bodies.any() else None

    def change(self, inverse_mass: np.ndarray, hidden: np.ndarray) -> None:
        """Go on with other inverse masses (n, k), and without the ``hidden`` bodies (n,) bool."""
        self.inverse_mass = inverse_mass
        self._free = self._movable(inverse_mass)
        self.hide(hidden)
        self._make_room()
        if self._listed_at is not None:
            self._list_again(self._listed_at)

    def grown(
        self,
        tables: tuple[ContactorTable, list[VisibilityRow], list[ChainTable]],
        inverse_mass: np.ndarray,
        hidden: np.ndarray,
        apart: np.ndarray,
        bodies: np.ndarray,
    ) -> Detector:
        """A detector for other tables with the memory of this one: with more bodies, added after these, or other parameters
        of laws; ``bodies``: positions of all bodies, (n, w)."""
        lattice = None if self._images is None else self._images.lattice
        # first with the old inverse masses: the memory may hold impulses of bodies that are hidden or fixed since
        then = np.concatenate([self.inverse_mass, inverse_mass[len(self.inverse_mass) :]])
        detector = Detector(*tables, then, self.dimension, apart, lattice)
        memory = self.give_memory()
        for k, (now, row) in enumerate(zip(tables[1], self.rows, strict=True), len(self.chains)):
            components = now.law.rows(self.dimension)
            if components < row.law.rows(self.dimension):  # without friction there are no tangential impulses
                memory.impulse[memory.identity[:, 0] == k, components:] = 0.0
        if memory.listed:
            before, placed = len(self.contactors.body), detector._place(bodies)
            listed_at = np.zeros((len(memory.listed_at), placed.shape[1]))  # the first body that turns widens positions
            listed_at[:, : memory.listed_at.shape[1]] = memory.listed_at
            listed_at[:, 6:] = np.where(listed_at[:, 3:].any(axis=1, keepdims=True), listed_at[:, 6:], 1.0)
            parts = listed_at[:before], placed[before : len(tables[0].body)], listed_at[before:]
            memory = replace(memory, listed_at=np.concatenate(parts))
        detector.take_memory(memory)
        if hidden.any() or not np.array_equal(then, inverse_mass):
            detector.change(inverse_mass, hidden)
        return detector

    def with_chains(self, chains: list[ChainTable]) -> Detector:
        """One that goes on by itself, with other tables of the same chains."""
        other = copy(self)
        new = {id(before): after for before, after in zip(self.chains, chains, strict=True)}
        other.chains = chains
        other.groups = [
            group if group.chain is None else replace(group, chain=new[id(group.chain)]) for group in self.groups
        ]
        return other

    def widest(self, travel: float, closing: float) -> float:
        """The greatest alert distance [m]; arguments as of :meth:`detect`."""
        return self._distances.widest_alert(travel, closing)

    def detect(
        self, bodies: np.ndarray, travel: float, closing: float = 0.0, inverse_mass: np.ndarray | None = None
    ) -> Interactions:
        """Interactions at the positions ``bodies`` (n, w) of the bodies, filled into arrays that the next call reuses.

        ``travel``: longest way of a body in one step [m]. ``closing``: largest distance by which a body and a wall may
        come closer in it [m]. ``inverse_mass``: inverse masses in the local blocks of W, (n, k), by default the inverse
        masses of the bodies.
        """
        placed = self._place(bodies)
        self._update_list(placed, travel, closing)
        inverse_mass = self.inverse_mass if inverse_mass is None else inverse_mass
        seen = Seen(self._as_met(placed), self.contactors.body, self._shapes, bodies, inverse_mass)
        elements = self._elements
        if self._images is not None:
            seen = self._images.seen(seen, self._stride)
            elements = None if elements is None else self._images.elements(elements, bodies)
        first = 0
        for group in self.groups:
            group.start = first
            if group.chain:
                first = self._detect_links(group, bodies, inverse_mass)
            else:
                first = self._detect_contacts(group, seen, elements, travel, closing)
            group.stop = first
            if group.cuts is not None:
                slots = self._capacity.slot[group.start : first]
                group.rows = group.start + np.searchsorted(slots, group.first_slot + group.cuts)
        if first != len(self._found.gap) or self._found.gap.base is not self._capacity.gap:
            self._found = self._capacity.cut(first)
        return self._found

    def remember(self, interactions: Interactions, impulse: np.ndarray, state: np.ndarray) -> None:
        """Keep the impulses (m, d) of the step for the next one's start, and the states (m, k) of the laws."""
        self._last.remember(interactions.slot, impulse, state)

    def begin_again(self, interactions: Interactions, impulse: np.ndarray) -> None:
        """Have the next step start from these impulses (m, d), and from the states of the last step."""
        self._last.replace_impulses(interactions.slot, impulse)

    def scale_impulses(self, factor: float) -> None:
        """Have the next step start from the impulses times ``factor``, see :meth:`LastStep.scale`."""
        self._last.scale(factor)

    @property
    def remembered(self) -> tuple[int, int]:
        """How many components the impulse of an interaction has at the most, and the state of its law."""
        return self._last.width

    def recall(self, interactions: Interactions, impulse: np.ndarray, state: np.ndarray) -> None:
        """Fill in the impulses of the last step by identity, zero for new interactions, (m, d), and the states of the laws,
        (m, k), k the longest; NaN for new interactions and for laws with fewer."""
        self._last.recall(interactions.slot, impulse, state)
        if self._surfaces is not None:
            self._last.hand_on(interactions.slot, self._surfaces, impulse, state)

    def give_memory(self) -> Memory:
        """Impulses of the last step and states by identity, and the data from which the list was made; copies."""
        identity, impulse, state = self._last.by_identity(self.groups, [*self.chains, *self.rows])
        return Memory(
            identity=identity,
            impulse=impulse,
            state=state,
            listed=self._listed_at is not None,
            listed_at=self._nowhere() if self._listed_at is None else self._listed_at.copy(),
            reach=self._reach,
            rebuilds=self.rebuilds,
        )

    def take_memory(self, memory: Memory) -> None:
        """Go on from a memory; ValueError if it holds interactions that this scene cannot have."""
        self._reach = memory.reach
        self._listed_at = None
        self.groups = []
        if memory.listed:
            self._list_again(memory.listed_at)
        self.rebuilds = memory.rebuilds
        self._last.take(memory, self.groups, [*self.chains, *self.rows], len(self.contactors.body))

    # ------------------------------------------------------------------------------------------- narrow phase

    def _detect_links(self, group: Group, bodies: np.ndarray, inverse_mass: np.ndarray) -> int:
        """Write the links of a group; returns the row after the last."""
        chain = group.chain
        assert chain is not None
        rows, stop = chain.bodies, group.start + group.slots
        if chain.points is not None:
            lattice = None if self._images is None else self._images.lattice
            detect_at_points(chain, group.start, group.first_slot, bodies, inverse_mass, lattice, self._capacity)
            return stop
        course = None if self._images is None else self._images.course(rows, bodies)
        if course is not None:
            rows, bodies, inverse_mass = np.arange(len(rows)), course, inverse_mass[rows]
        given = rows, chain.radius_sum, chain.closed, group.start, group.first_slot, bodies, inverse_mass
        LINKS[self.dimension](*given, self._capacity)
        if course is not None:
            self._capacity.antagonist[group.start : stop] = chain.bodies[:-1]
            self._capacity.candidate[group.start : stop] = chain.bodies[1:]
        return stop

    def _detect_contacts(
        self, group: Group, seen: Seen, elements: Elements | None, travel: float, closing: float
    ) -> int:
        """Write the contacts of a group; returns the row after the last."""
        assert group.kernel is not None
        assert group.row is not None
        alert = self._distances.alert(group.row, travel, closing if group.unbounded else 0.0)
        contactors = seen.placed.ravel(), seen.body, seen.shapes, self._stride
        pairs = group.pairs if group.placed_pairs is None else group.placed_pairs
        given = [pairs, group.start, group.first_slot, alert, *contactors, seen.bodies, seen.inverse_mass]
        if group.on_elements:
            given.append(elements)
        try:
            stop, group.diagonal = group.kernel(*given, self._capacity)
        except Exception as error:
            if not group.foreign:
                raise
            raise narrow_fault(group, pairs, seen, self._stride, self.dimension, error) from error
        if stop < 0:
            raise narrow_fault(group, pairs[-1 - stop :], seen, self._stride, self.dimension)
        if group.foreign:
            check_points(group, self._capacity, stop, self.contactors)
        if self._images is not None:
            self._images.name_bodies(self._capacity.antagonist[group.start : stop], len(self.inverse_mass))
        return stop

    # ------------------------------------------------------------------------------------------- list of neighbours

    def _place(self, bodies: np.ndarray) -> np.ndarray:
        """Positions of the contactors, (k, w); with a periodic cell its edges are the rows below them."""
        if self._in_place:
            return bodies
        placed = np.empty((len(self.contactors.body), bodies.shape[1]))
        place = place_in_plane if bodies.shape[1] == 3 else place_in_space
        place(bodies, self.contactors.body, self.contactors.offset, placed)
        if self.contactors.elements is not None:
            self._place_elements(bodies, placed)
        return placed if self._images is None else self._images.with_edges(placed, bodies)

    def _place_elements(self, bodies: np.ndarray, placed: np.ndarray) -> None:
        """Enter the positions and shapes of elements, whose axes are those of space."""
        table, d = self.contactors.elements, self.dimension
        assert table is not None
        placed[table.rows] = 0.0
        placed[table.rows, :d] = self._shape_elements(bodies[:, :d])
        if placed.shape[1] == 7:
            placed[table.rows, 6] = 1.0

    def _shape_elements(self, points: np.ndarray) -> np.ndarray:
        """Enter the shapes of elements between bodies at ``points`` (n, d); returns the middles of the elements (e, d)."""
        table = self.contactors.elements
        assert table is not None
        crossed = crossing(None if self._images is None else self._images.lattice, points)
        middle, radii = table.bounds(points, crossed)
        table.enter(self._shapes.reshape(-1, self._stride), points, crossed)
        self._elements = table.at(points, middle, crossed)
        self._radii = self.contactors.bounding_radius.copy()
        self._radii[table.rows] = radii
        if self._images is not None:
            self._images.measure(self._radii)
        return middle

    def _as_met(self, placed: np.ndarray) -> np.ndarray:
        """The positions (k, w) that narrow phases get: the shapes of elements are seen from the origin."""
        if self.contactors.elements is None:
            return placed
        placed = placed.copy()
        placed[self.contactors.elements.rows, : self.dimension] = 0.0
        return placed

    def _nowhere(self) -> np.ndarray:
        """Zeros of the shape that :meth:`_place` returns."""
        edges = 0 if self._images is None or self._in_place else len(self._images.lattice.rows)
        return np.zeros((len(self.contactors.body) + edges, self.contactors.width))

    def _update_list(self, placed: np.ndarray, travel: float, closing: float) -> None:
        """Make the list of neighbours anew if it may lack a pair."""
        widest = self.widest(travel, 0.0)
        too_near_walls = closing > self._distances.cap and self._reach < self._distances.fullest < np.inf
        if self._out_of_date(placed, widest) or too_near_walls:
            reach = self._distances.reach(widest, travel)
            # in a narrow cell the list is made anew more often
            self._reach = reach if self._images is None else max(widest, min(reach, self._images.most_reach(placed)))
            self._list_neighbours(placed)

    def _out_of_date(self, placed: np.ndarray, widest: float) -> bool:
        """Whether a pair that is not in the list may be within the ``widest`` alert distance."""
        if self._listed_at is None or widest > self._reach:
            return True
        before, spare = self._listed_centres, self._reach - widest
        placed = self.contactors.centres(placed)
        if self._images is not None:
            before, ratio = self._images.carried_along(before, placed)
            spare -= self._images.shortening(ratio, self._reach)
        if self.contactors.elements is not None:
            rows = self.contactors.elements.rows
            spare -= 2.0 * float((self._radii[rows] - self._listed_radii[rows]).max(initial=0.0))  # they may become longer
        return bool(spare < 0.0 or 4.0 * largest_move(placed, before, self._unbounded, self.dimension) > spare**2)

    def _list_again(self, placed: np.ndarray) -> None:
        """Make the list of neighbours of these positions of the contactors (k, w) anew, with the shapes that elements had
        there: the middle of the element of a node is its place."""
        table = self.contactors.elements
        if table is not None:
            points = np.zeros((len(self.inverse_mass), self.dimension))
            nodes = np.flatnonzero(table.count == 0)
            points[table.corner[nodes, 1]] = placed[table.first + nodes, : self.dimension]
            if self._images is not None:
                points[self._images.lattice.rows] = placed[len(self.contactors.body) :, : self.dimension]
            self._shape_elements(points)
        self._list_neighbours(placed)

    def _list_neighbours(self, placed: np.ndarray) -> None:
        """Make the groups and their lists of neighbours anew and carry impulses and states over."""
        self.rebuilds += 1
        self._listed_at, self._listed_radii = placed.copy(), self._radii
        self._listed_centres = self.contactors.centres(self._listed_at)
        around = self._surroundings(placed)
        slabs: Slabs | None = None
        if self._partitioned:
            width = 2.0 * self._usual + self._reach
            free: np.ndarray = self.inverse_mass.max(axis=1, initial=0.0) > 0.0
            at, period = placed[:, : self.dimension], np.full(self.dimension, np.inf)
            if self._images is not None:
                at, period = self._images.across(placed)
            slabs = cut_bodies(at, period, self.contactors, self._bounded, free, width)
        self.place = None if slabs is None else slabs.place
        groups = [Group(chain.law, chain.form, chain=chain) for chain in self.chains]
        for row, kinds in zip(self.rows, self._kinds, strict=True):
            groups += [group for pair in kinds if (group := self._group(row, pair, around, slabs)).slots]
        slots = 0
        for group in groups:
            group.first_slot = slots
            slots += group.slots
        self._surfaces = surfaces_met(groups, self.contactors, slots)
        self._last.carry_over(self.groups, groups, slots)
        self.groups = groups
        if self._images is not None:
            self._images.look_at(groups, self._listed_centres)
        central = all(group.form == "central" for group in groups)
        on_elements = any(group.on_elements for group in groups)
        levers = self._capacity.lateral if self.dimension == 2 else self._capacity.lever
        too_few = (not central and len(levers) < slots) or (on_elements and len(self._capacity.corner) < slots)
        if len(self._capacity.gap) < slots or too_few:
            corners = self._corners if on_elements else 0
            given = slots + slots // 8, central, self.dimension
            self._capacity = empty_interactions(*given, plain=self._plain, corners=corners)

    def _surroundings(self, placed: np.ndarray) -> Surroundings:
        """The near pairs of bounded contactors, and the data for pairs with contactors without bounds."""
        if self._images is not None:
            near = self._images.near_pairs(self._listed_centres, self._reach)
        else:
            bounded = np.flatnonzero(self._bounded)
            centres = self._listed_centres.take(bounded, axis=0)[:, : self.dimension]
            box = self.contactors.boxes(placed)
            if box is not None and self.contactors.elements is not None:
                box[self.contactors.elements.rows] = self._radii[self.contactors.elements.rows, None]
            box = None if box is None else box[bounded]
            held = None if box is None else (self.contactors.features & ~self._free)[bounded]
            near = near_pairs(centres, self._radii[bounded], self._reach, box, held)
            if len(bounded) < len(placed):
                near = bounded.astype(np.int32).take(near)
        near = self._excluded.left_out_of(near, self.contactors.body)
        of_walls = self._reach if self._reach < self._distances.fullest else np.inf
        met = self._as_met(placed), self._shapes
        return Surroundings(near, *met, of_walls, self.contactors, self._bounded, self._free, self._excluded)

    def _group(self, row: VisibilityRow, kinds: KindPair, around: Surroundings, slabs: Slabs | None) -> Group:
        """The group of one row of the visibility table and two kinds of contactor."""
        if kinds.foreign and (kinds.candidate, kinds.antagonist) not in self._looked_at:
            check_narrow_phase(kinds, self.contactors, self.dimension)
            self._looked_at.add((kinds.candidate, kinds.antagonist))
        try:
            pairs = neighbours(row, kinds, around)
        except Exception as error:  # the narrow phase gives the distance of contactors without bounds
            if not kinds.foreign:
                raise
            raise listing_fault(kinds, error) from error
        if self._hidden is not None:
            pairs = pairs[~self._hidden[pairs].any(axis=1)]
        if are_long(kinds.candidate, kinds.antagonist) and self._images is None:
            pairs = within_reach(pairs, self.contactors, around.placed, self._reach)
        corners = kinds.corners
        if max(corners) > 1:
            assert self.contactors.elements is not None
            pairs = self.contactors.elements.strangers(pairs, self.contactors.body, self._excluded)
        if len(pairs) == 0:
            return Group(row.law, row=row)
        form = kinds.pair.form
        if form == "lever" and self.dimension == 3 and self.contactors.turns is None:
            form = "central"  # surfaces that do not turn
        if form == "central" and not self._off_centre.isdisjoint((row.candidate, row.antagonist)):
            form = "lever"
        names: dict[str, Any] = {"FOREIGN": True} if kinds.foreign else {}
        if max(corners) > 1:
            form = elements_form(*corners)
            names |= narrow_phase_elements.names_of(self.dimension, kinds.width, *corners)
            kernel = narrow_phase_elements.detect_contacts.specialise(**kinds.meaning, **names)
        else:
            kernel = self._narrow_phase.specialise(**kinds.meaning, **names, CENTRAL=form == "central")
        return contact_group(row, kinds, pairs, kernel, form, self.contactors.body, self._bounded, slabs)
