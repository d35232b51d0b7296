"""Work on one step shared by threads, with the bits of one thread.

A sweep is a few phases one after another, a phase some tasks that touch no number in common, and who does a task cannot be
seen in the result: sums are kept by task and added in their order. One thread leads: it runs the solver and offers every
phase of more than one task; the others help. An offer is a single number, the ticket. A thread claims a task by adding one
to it, atomically, if the number is still the one that it has read: so nobody can work on a phase that is over. The leader
takes tasks as well and waits for none that nobody has claimed; helpers that are late, or that the system does not let run,
cost nothing. Threads are started for each solve and end with it (0.1 ms): nothing is left behind that a fork, a second
simulation in another thread or the end of the process would have to care about.
"""

from __future__ import annotations

import threading
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from lmgcpy.compiled.atomic import add, exchange, load, store
from lmgcpy.compiled.by_address import ROOM, call_at, call_work, giving_way, work_signature, write
from lmgcpy.compiled.kernel import Kernel, kernel
from lmgcpy.compiled.mode import mode
from lmgcpy.compiled.reference import by_reference
from lmgcpy.contact.interactions import with_spare_rows
from lmgcpy.solve.kernels.system import Groups, System
from lmgcpy.solve.sweeps.cell_copies import AVERAGE, LEND, cell_work, with_copies
from lmgcpy.solve.sweeps.light_bodies import FLY, TAKE_BACK, LightBodies, light_work

TICKET, DONE, HELPERS = 0, 8, 16
"""Entries of ``Team.words``, far enough from each other to be in different lines of the cache."""
STOP = 255
"""Kind of the last offer."""
PATIENCE = 5000
"""Looks at a number that does not change before other processes are given way."""


@by_reference
class Team(NamedTuple):
    """The data by which the thread that leads a solve agrees with the others, of the same types for every kind of body, so
    that a kernel that leads them is compiled once. It lives as long as the solve of a step, as :class:`Job` does."""

    words: np.ndarray
    """(24,) int64: the ticket (turn, kind of work, end of the tasks, next task), how many tasks are done, how many help."""
    partial: np.ndarray
    """Results of each task: a sum, and for errors the largest share, its row and its error, (tasks, 4)."""
    beta: np.ndarray
    """(1,): the momentum of the next extrapolation."""
    phase: np.ndarray
    """First task of each phase, and the end."""
    bounds: np.ndarray
    """(4,): largest residual, slip, and error of a force of a solved step; the geometric mean of all impulses, as last
    measured [N s]."""
    limits: np.ndarray
    """(8,): the error [m/s] and the share of a body's size that an interaction may have whatever round-off is; the terms of
    the velocities without impulses, squared and summed [m^2/s^2]; the most kinetic energy of a solution [J]; whether the
    rounding of gaps counts; how often round-off was looked for; the sum of ``(W_nn r_n)^2`` as last measured [m^2/s^2];
    the largest imbalance of a light body that bears more than little, as last measured.
    They stay while a solve pauses."""
    measured: np.ndarray
    """(6,): see ``lmgcpy.solve.kernels.system.System``."""
    chunks: int
    """Number of parts into which whole arrays are cut."""
    rows: int
    """Number of interactions."""
    light: int
    """Number of light bodies."""
    copies: int
    """Whether tasks have copies of a periodic cell, 0 or 1."""
    work: int
    """Address of the function that does a task: ``work(kind, task, job)``."""
    rare_work: int
    """Address of the function that does the tasks on light bodies and on copies of a cell; 0 if there are none."""
    job: int
    """Address of the :class:`Job` as this thread has it."""
    give_way: int
    """Address of the system's function."""


@by_reference
class Job(NamedTuple):
    """A step to be solved, as compiled tasks have it. Its types depend on the kind of bodies."""

    groups: Groups
    s: System
    free_velocity: np.ndarray
    guess: np.ndarray
    light: LightBodies
    impulse: np.ndarray
    velocity: np.ndarray
    """Impulses and velocities of the system, each in a row. These and the five below are empty for plain Gauss-Seidel."""
    start: np.ndarray
    """Impulses from which the sweep started, in a row as the four below."""
    last_impulse: np.ndarray
    last_velocity: np.ndarray
    """Results of the sweep before."""
    best_impulse: np.ndarray
    weight: np.ndarray
    """Diagonal of W."""
    partial: np.ndarray
    beta: np.ndarray
    bounds: np.ndarray
    limits: np.ndarray
    """As in :class:`Team`."""
    chunks: int


@kernel
def lay(job, address):
    """Write the job to an address, where the work finds it; returns a number that identifies the types of its arrays."""
    return write(address, job)


@kernel
def rare_work(kind, task, job):
    """Do one task on light bodies or on copies of a cell. It is apart from all other work: most scenes have neither, and
    need not compile it."""
    if kind <= TAKE_BACK:
        light_work(kind, task, job)
    else:
        cell_work(kind, task, job)


def ticket(turn, kind, last, task):
    """An offer as one number."""
    return (turn << 40) | (kind << 32) | (last << 16) | task


def do(kind, task, team):
    """Do one task."""
    call_work(team.work if kind < FLY else team.rare_work, kind, task, team.job)


def share(kind, first, last, team):
    """Have the tasks ``first`` to ``last`` of a kind of work done, by this thread and those that help."""
    words = team.words
    if last - first < 2 or words[HELPERS] == 0:
        for task in range(first, last):
            do(kind, task, team)
        return
    store(words, DONE, 0)
    turn = ((load(words, TICKET) >> 40) + 1) & 0x7FFFFF
    store(words, TICKET, ticket(turn, kind, last, first))
    while claim_one(team):
        pass
    looks = 0
    while load(words, DONE) < last - first:
        looks += 1
        if looks > PATIENCE:
            call_at(team.give_way)


def share_phases(kind, team, gather=AVERAGE):
    """Have a kind of work done for all interactions; ``gather``: how copies of a periodic cell become one."""
    for f in range(team.phase.shape[0] - 1):
        if team.copies:
            call_work(team.rare_work, LEND, f, team.job)
        share(kind, team.phase[f], team.phase[f + 1], team)
        if team.copies:
            call_work(team.rare_work, gather, f, team.job)


def share_chunks(kind, team):
    """Have a kind of work done for whole arrays."""
    share(kind, np.int64(0), team.chunks, team)


def claim_one(team):
    """Do one task of the offer, if one is left; returns whether the offer may hold more."""
    words = team.words
    offer = load(words, TICKET)
    task = offer & 0xFFFF
    if task >= (offer >> 16) & 0xFFFF:
        return False
    if exchange(words, TICKET, offer, offer + 1):
        do((offer >> 32) & 0xFF, task, team)
        add(words, DONE, 1)
    return True


@kernel
def help_out(team: Team):
    """Do the tasks of each offer, until the last offer."""
    words = team.words
    looks = 0
    while (load(words, TICKET) >> 32) & 0xFF != STOP:
        if claim_one(team):
            looks = 0
        else:
            looks += 1
            if looks > PATIENCE:
                call_at(team.give_way)


def work_address(work: Kernel, job: Job, kind: int) -> int:
    """Address of the work that is compiled for jobs of this ``kind``, see :func:`lay`; it is valid until the process
    ends."""
    if (work, kind) not in _pointers:
        _pointers[work, kind] = work.pointer(work_signature(job))
    return _pointers[work, kind].address


_pointers: dict[tuple, Any] = {}


def make_ready(solver: Kernel, limits: tuple) -> None:
    """Compile or load a kernel that leads, once, before the work that it leads: with an empty cache a second process may be
    compiling that meanwhile (:mod:`lmgcpy.compiled.ahead`)."""
    if solver not in _ready:
        _ready.add(solver)
        words, phase, one = np.zeros(24, np.int64), np.zeros(1, np.int64), np.zeros(1)
        of_types: list[Any] = [words, np.zeros((1, 4)), one, phase, one, one, one, *[0] * 8]
        solver.make_ready(Team._make(of_types), *limits)


_ready: set[Kernel] = set()


class Crew:
    """The threads that solve a step (groups, system, velocities without impulses, guess, light bodies), and the data that
    they share; ``iterates``: with the arrays of accelerated sweeps.

    A scene without a partition has one task and one chunk, and no use for more than one thread; neither has plain Python.
    """

    def __init__(
        self, work: Kernel, step: tuple[Groups, Any, np.ndarray, np.ndarray, LightBodies], iterates: bool, threads: int
    ):
        groups, system, free_velocity, guess, light = step
        copies = isinstance(system, System) and system.deforms and len(groups.task) > 2
        if copies:
            system = with_copies(system, groups)
        self.velocity = system.velocity[: len(free_velocity)]
        """Velocities of the bodies in the order of the sweep, (n, k)."""
        tasks = len(groups.task) - 1
        chunks = max((1, *(end - first for first, end in pairwise(groups.phase.tolist()))))
        words = np.zeros(24, dtype=np.int64)
        self._helpers = threads - 1 if chunks > 1 and not mode.plain else 0
        partial, beta, bounds, limits = np.zeros((max(tasks, chunks), 4)), np.zeros(1), np.zeros(4), np.zeros(8)
        flat = [np.zeros(0)] * 7
        if iterates:
            impulse, velocity = system.impulse.reshape(-1), self.velocity.reshape(-1)
            start, last, before, best = map(with_spare_rows, map(len, (impulse, impulse, velocity, impulse)))
            weight = system.delassus[:, : system.impulse.shape[1]].reshape(-1)
            flat = [impulse, velocity, start, last, before, best, weight]
        # kept alive as long as its address is in use
        step = groups, system, free_velocity, guess, light
        self._job = job = Job._make([*step, *flat, partial, beta, bounds, limits, chunks])
        self._place = place = np.empty(ROOM, dtype=np.int64)
        kind = lay(job, place.ctypes.data)
        shared = words, partial, beta, groups.phase, bounds, limits, system.measured
        rare = work_address(rare_work, job, kind) if copies or len(light.body) else 0
        addresses = work_address(work, job, kind), rare, place.ctypes.data, giving_way()
        counts = chunks, len(system.impulse), len(light.body), int(copies)
        self._team = Team(*shared, *counts, *addresses)

    def run(self, solver: Kernel, bounds: tuple[float, float, float], limits: tuple) -> Any:
        """``solver(team, *limits)`` to these bounds of residual, slip, and errors of forces, with helpers as long as it
        runs."""
        team = self._team
        for array in (team.words, team.partial, team.beta):
            array.fill(0)
        team.bounds[:3] = bounds
        team.words[HELPERS] = self._helpers
        if not self._helpers:
            return solver(team, *limits)
        solver.make_ready(team, *limits)  # or helpers would spend the compiler's time looking for work
        help_out.make_ready(team)
        helpers: list[threading.Thread] = []
        try:
            for _ in range(self._helpers):
                helpers.append(threading.Thread(target=help_out, args=(team,)))
                helpers[-1].start()
            return solver(team, *limits)
        finally:
            team.words[TICKET] = STOP << 32
            for thread in helpers:
                if thread.ident is not None:  # Ctrl-C may come before it runs
                    thread.join()
