"""Evaluates rigs against one entropy field; casts only what changed since the rig before.

The state is the set of sensors held, each with the voxels it traverses, and their union by kind. Every change - add,
remove, enable, edit, undo - casts the sensors that are new and settles the difference of the unions in integers, so
the scores after any sequence of edits are the bits of an evaluation from scratch. Call it from one thread only.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from riglens.core.engine.caster import Caster, Window
from riglens.core.engine.held import Held, Others, Shape, State
from riglens.core.engine.processors import Processors
from riglens.core.errors import Cancelled, IsStale, never_stale
from riglens.core.geometry import Pose
from riglens.core.kernels.runtime import jit
from riglens.core.kernels.voxels import update_coverage
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import PAPER_SETTINGS, Method, MetricSettings, Scores
from riglens.core.metric.scoring import score
from riglens.core.rig.model import Rig, Sensor, rays_of
from riglens.core.scene.columns import Words
from riglens.core.sensing.body_ends import Obstacle, obstacle_of
from riglens.core.sensors.registry import kind_names
from riglens.core.vehicle.housings import car_of
from riglens.core.vehicle.solid import Solid

SPARE_SLOTS = 2


@dataclass(frozen=True)
class Evaluation:
    """Answer to one request; `seen` are the informative voxels that the sensors of each kind cover, as words, empty
    arrays where they were not requested."""

    rig: Rig
    settings: MetricSettings
    scores: Scores
    seen: Mapping[str, Words]
    elapsed_ms: float
    threads: int

    def seen_by_any(self) -> Words:
        """Return the voxels that any sensor covers."""
        words: Words = np.bitwise_or.reduce(list(self.seen.values()))
        return words

    def seen_by_two_kinds(self) -> Words:
        """Return the voxels that sensors of at least two kinds cover."""
        once, twice = np.zeros((2, self._words), np.uint64)
        for words in self.seen.values():
            twice |= once & words
            once |= words
        return twice

    @property
    def _words(self) -> int:
        return next(iter(self.seen.values())).size


_Wanted = tuple[int, Method, str | None]
"""Identity of a sensor, method, fingerprint of the body: the key of a shape."""


def _cast_shape(sensor: Sensor, method: Method, solid: Solid | None) -> Shape:
    stop = None if solid is None else obstacle_of(sensor, solid)
    return Shape(method, rays_of(sensor), stop)


class Engine:
    """Incremental evaluation of rigs on one field with a number of threads (all processors by default).

    Short edits get fewer where other programs leave no processor for them. It cannot matter for what they find.
    With `for_edits` False it starts again for each rig, in the same memory: the sensors of a kind then share a slot,
    which saves most of the memory, and most of the time that the system takes to provide it.
    """

    def __init__(self, field: EntropyField, threads: int | None = None, for_edits: bool = True) -> None:
        self._field, self._for_edits = field, for_edits
        self._threads, self._processors, self._last_ms = jit.use_threads(threads), Processors(), 0.0
        self._caster = Caster(field, self._threads)
        words = field.index.words.size
        kinds, self._nothing = len(kind_names()), np.zeros(words, np.uint64)
        self._state = State(
            np.zeros((0, words), np.uint64),
            np.zeros((kinds, words), np.uint64),
            np.zeros((kinds + 1, update_coverage.COLUMNS), np.int64),
        )
        self._shapes: dict[_Wanted, tuple[Sensor, Shape]] = {}
        self._solid: Solid | None = None
        self._hits: dict[Shape, tuple[int, ...]] = {}

    def evaluate(
        self,
        rig: Rig,
        settings: MetricSettings = PAPER_SETTINGS,
        with_seen: bool = True,
        stance: Pose = Pose(),
        cancel: IsStale = never_stale,
    ) -> Evaluation:
        """Score a rig; the evaluation holds the seen voxels if requested.

        `stance`: how the car's body stands on the ground; the sensors are where the rig says. InputError where the body
        blocks and its mesh file has not been read.
        Raise Cancelled as soon as `cancel`, which is called every few milliseconds, returns True: whatever was cast
        until then is undone, so the next evaluation is as good as any. The same holds when `cancel` raises.
        """
        started = time.perf_counter()
        settings = replace(settings, body=settings.body or rig.body)
        if self._for_edits:
            self._caster.workers = self._processors.threads(self._threads, self._last_ms)
        jit.use_threads(self._caster.workers)
        self._solid = car_of(rig, stance) if settings.body == "blocks" else None
        wanted = self._shapes_of(rig, settings.method)
        if not self._hold(wanted, cancel):
            raise Cancelled
        hits = self._hit_sums(wanted, cancel) if settings.reading == "hits" else None
        if settings.reading == "hits" and hits is None:
            raise Cancelled
        scores = score(self._field, self._state.sums_q, settings, hits)
        nothing, there = (
            self._nothing if with_seen else self._nothing[:0],
            {s.kind for s in rig.sensors if s.enabled},
        )
        by_kind = {
            kind: row.copy() if with_seen and kind in there else nothing
            for kind, row in zip(kind_names(), self._state.union, strict=True)
        }
        self._last_ms = elapsed_ms = (time.perf_counter() - started) * 1e3
        return Evaluation(rig, settings, scores, by_kind, elapsed_ms, self._threads)

    def scores_without(self, rig: Rig, settings: MetricSettings = PAPER_SETTINGS) -> Scores | None:
        """Return the scores of the rig evaluated last with some of its sensors switched off: nothing is cast, and what
        is held stays. None for any other rig."""
        settings = replace(settings, body=settings.body or rig.body)
        solid, sensors = self._solid, [sensor for sensor in rig.sensors if sensor.enabled]
        body = car_of(rig) if settings.body == "blocks" else None
        if not self._for_edits or body != solid:
            return None
        left, staying = list(self._state.held), list[Held]()
        for shape in (self._shape_of(sensor, settings.method) for sensor in sensors):
            match = next((held for held in left if held.shape == shape), None)
            if match is None:
                return None
            left.remove(match)
            staying.append(match)
        hits = None
        if settings.reading == "hits":
            if any(held.shape not in self._hits for held in staying):
                return None
            hits = self._total_hits([held.shape for held in staying])
        return score(self._field, self._sums_without(staying, left), settings, hits)

    def _sums_without(self, staying: list[Held], leaving: list[Held]) -> NDArray[np.int64]:
        """Return the sums of what the staying sensors see, of those held; all others leave."""
        state, sums_q, union = self._state, self._state.sums_q.copy(), self._state.union.copy()
        there = {held.kind for held in state.held}
        for kind in sorted({held.kind for held in leaving}):
            gone = [held for held in leaving if held.kind == kind]
            free = self._field.index.words.copy()
            for held in staying:
                if held.kind == kind:
                    free &= ~state.stack[held.slot]
            change = self._settled(
                kind, there, (state.stack[[held.slot for held in gone]], union), free,
                (np.zeros(0, np.int64), np.arange(len(gone))), gone,
            )  # fmt: skip
            sums_q[kind] += change[0]
            sums_q[-1] += change[1]
        return sums_q

    @property
    def field(self) -> EntropyField:
        """Return the entropy field that rigs are evaluated against."""
        return self._field

    @property
    def workers(self) -> int:
        """Return the most threads that the parallel kernels may use."""
        return self._threads

    def marks_of(self, sensor: Sensor, method: Method) -> Words | None:
        """Return the voxels that a sensor of the rig evaluated last traverses, uint64 (words,): all informative ones
        and possibly others; None when the sensor is not held on its own.

        It is a view of the engine's own memory: read it at once, never write to it, never keep it.
        """
        shape = self._shape_of(sensor, method)
        held = next((held for held in self._state.held if held.shape == shape), None)
        return self._state.stack[held.slot] if held is not None and self._for_edits else None

    def stack_of(self, sensors: Sequence[Sensor], method: Method) -> tuple[Words, NDArray[np.int64]]:
        """Return all sets of voxels held, uint64 (rows, words), and the row (n,) of each sensor of the rig evaluated
        last. As for `marks_of`: a view, of all informative voxels and possibly others. KeyError: not held."""
        rows = {held.shape: held.slot for held in self._state.held} if self._for_edits else {}
        slots = [rows[self._shape_of(sensor, method)] for sensor in sensors]
        return self._state.stack, np.array(slots, np.int64)

    def stop_of(self, sensor: Sensor, method: Method) -> Obstacle | None:
        """Return what stops the rays of a sensor of the rig evaluated last, or None if its own car stops none."""
        return self._shape_of(sensor, method).stop

    def _shape_of(self, sensor: Sensor, method: Method) -> Shape:
        """Return the shape of a sensor's rays, except for the current body; cached for the rig evaluated last."""
        stop = None if self._solid is None else self._solid.fingerprint
        known = self._shapes.get((id(sensor), method, stop))
        return known[1] if known is not None else _cast_shape(sensor, method, self._solid)

    def _shapes_of(self, rig: Rig, method: Method) -> list[Shape]:
        """Return the ray shape of each enabled sensor; the same objects as last time for unchanged sensors."""
        known, self._shapes = self._shapes, {}
        stop = None if self._solid is None else self._solid.fingerprint
        for sensor in rig.sensors:
            if sensor.enabled:
                found = known.get((id(sensor), method, stop))
                shape = found or (sensor, _cast_shape(sensor, method, self._solid))
                self._shapes[id(sensor), method, stop] = shape
        return [shape for _, shape in self._shapes.values()]

    def _hold(self, wanted: list[Shape], is_stale: IsStale) -> bool:
        """Cast and release until exactly the wanted sensors are held; return False when cancelled."""
        if not self._for_edits:
            self._forget()
        leaving = list(self._state.held)
        arriving: list[Shape] = []
        by_identity = {id(held.shape): held for held in leaving}
        for shape in wanted:
            match = by_identity.get(id(shape)) or next((h for h in leaving if h.shape == shape), None)
            if match is None or match not in leaving:
                arriving.append(shape)
            else:
                leaving.remove(match)
        arrived = self._cast(arriving, is_stale)
        if arrived is None:
            return False
        self._state.held = [h for h in self._state.held if h not in leaving] + arrived
        there = {held.kind for held in (*self._state.held, *leaving)}
        for kind in sorted(there):
            self._settle(kind, there, arrived, leaving)
        self._give_back(is_quiet=not arrived)
        return True

    def _forget(self) -> None:
        """Start as if nothing had been evaluated, in the same memory."""
        state = self._state
        state.held = []
        for array in (state.stack, state.union, state.sums_q):
            array[:] = 0

    def _cast(self, arriving: list[Shape], is_stale: IsStale) -> list[Held] | None:
        """Cast sensors into free slots; when this is abandoned or interrupted the slots are empty again."""
        self._reserve(len(arriving))
        stack, arrived, done = self._state.stack, [], False
        free = self._free_slots()
        try:
            for shape in arriving:
                kind = kind_names().index(shape.sensor.kind)
                slot = next(free) if self._for_edits else kind
                held = Held(shape, kind, slot, self._caster.window(shape.sensor))
                arrived.append(held)
                marks = stack[held.slot]
                if not self._caster.mark(
                    shape.sensor, shape.method, held.window, marks, is_stale, shape.barrier
                ):
                    return None
            done = True
        finally:
            if not done:
                stack[[held.slot for held in arrived]] = 0
        return arrived

    def _settle(self, kind: int, there: set[int], arrived: list[Held], leaving: list[Held]) -> None:
        """Bring the union and the sums of a kind up to date, where other kinds may see something; the slots of those
        who leave fall free."""
        changed = [held for held in (*arrived, *leaving) if held.kind == kind]
        if not changed:
            return
        state = self._state
        arrived_slots, leaving_slots = (
            sorted({held.slot for held in group if held.kind == kind}) for group in (arrived, leaving)
        )
        staying = {
            held.slot: held.window
            for held in state.held
            if held.kind == kind and held.slot not in arrived_slots
        }
        slots = np.array(arrived_slots, np.int64), np.array(leaving_slots, np.int64)
        free = self._free(kind, staying)
        change = self._settled(kind, there, (state.stack, state.union), free, slots, changed)
        state.sums_q[kind] += change[0]
        state.sums_q[-1] += change[1]

    def _settled(
        self,
        kind: int,
        there: set[int],
        sets: tuple[Words, Words],
        free: Words,
        slots: tuple[NDArray[np.int64], NDArray[np.int64]],
        changed: list[Held],
    ) -> NDArray[np.int64]:
        """Bring a union up to date with the slots of a stack that arrive and leave; return the change of the sums."""
        return update_coverage.settle(
            *sets,
            free,
            update_coverage.Slots(*slots),
            np.array([kind, *sorted(there - {kind})], np.int64),
            self._region(reduce(Window.joined, (held.window for held in changed))),
            self._field.entropies,
            self._caster.workers,
        )

    def _free(self, kind: int, staying: dict[int, Window]) -> Words:
        """Return the informative voxels that no staying sensor of a kind sees, given by slot and window.

        What is known is used again: a slot that is to hold another set is named among those that leave before, and so
        is no longer counted.
        """
        state, keep = self._state, self._field.index.words
        others = state.others.get(kind)
        if others is None and not staying:
            return keep
        if others is None:
            others = state.others[kind] = Others({}, np.zeros((0, keep.size), np.uint64), keep.copy())
        known, workers = others.windows, self._caster.workers
        more, less = sorted(staying.keys() - known.keys()), sorted(known.keys() - staying.keys())
        if more or less:
            counts = others.digits(max(len(known), len(staying)))
            window = reduce(Window.joined, [staying[slot] for slot in more] + [known[slot] for slot in less])
            slots = update_coverage.Slots(np.array(more, np.int64), np.array(less, np.int64))
            update_coverage.count_others(
                state.stack, slots, self._region(window), keep, workers, counts, others.free
            )
            others.windows = staying
        return others.free

    def _region(self, window: Window) -> update_coverage.Region:
        return update_coverage.Region(
            window.first_row,
            window.end_row,
            window.first_word,
            window.end_word - window.first_word,
            self._field.index.words.size // self._field.grid.shape[0],
        )

    def _reserve(self, sensors: int) -> None:
        """Reserve room for `sensors` sensors besides those held; untouched pages cost no memory."""
        slots = sensors + len(self._state.held) if self._for_edits else len(self._state.union)
        if slots > len(self._state.stack):
            more = np.zeros((slots + SPARE_SLOTS * self._for_edits, self._field.index.words.size), np.uint64)
            for held in self._state.held:
                more[held.slot] = self._state.stack[held.slot]
            self._state.stack = more

    def _give_back(self, is_quiet: bool) -> None:
        """Give back what the rig has no use for: others of a kind that has none, and unused rows.

        Moving the rows in use takes a few milliseconds, so that it waits for a moment in which nothing was cast, the
        end of a drag, unless most rows are free.
        """
        state = self._state
        state.others = {kind: others for kind, others in state.others.items() if others.windows}
        rows, room = len(state.stack), len(state.held) + SPARE_SLOTS
        if not self._for_edits or rows <= (room if is_quiet else 2 * room):
            return
        stack = np.zeros((room, self._field.index.words.size), np.uint64)
        places = {held.slot: place for place, held in enumerate(state.held)}
        for slot, place in places.items():
            stack[place] = state.stack[slot]
        state.stack = stack
        state.held = [replace(held, slot=places[held.slot]) for held in state.held]
        for others in state.others.values():
            others.windows = {places[slot]: window for slot, window in others.windows.items()}

    def _free_slots(self) -> Iterator[int]:
        used = {held.slot for held in self._state.held}
        return (slot for slot in range(len(self._state.stack)) if slot not in used)

    def _hit_sums(self, wanted: list[Shape], is_stale: IsStale) -> NDArray[np.object_] | None:
        """Return the sums with multiplicity per kind and class as Python integers, (kinds, 3); None if abandoned."""
        self._hits = {shape: sums for shape, sums in self._hits.items() if shape in wanted}
        for shape in wanted:
            if shape not in self._hits:
                sums = self._caster.hits(shape.sensor, shape.method, is_stale, shape.barrier)
                if sums is None:
                    return None
                self._hits[shape] = sums
        return self._total_hits(wanted)

    def _total_hits(self, shapes: list[Shape]) -> NDArray[np.object_]:
        totals = np.zeros((len(kind_names()), 3), dtype=object)
        for shape in shapes:
            totals[kind_names().index(shape.sensor.kind)] += np.array(self._hits[shape], dtype=object)
        return totals


def evaluate_from_scratch(
    field: EntropyField,
    rigs: Iterable[Rig],
    settings: MetricSettings,
    threads: int | None = None,
    with_seen: bool = False,
) -> Iterator[Evaluation]:
    """Evaluate rigs one after another, each from scratch: only memory is reused.

    The evaluations hold the seen voxels only if they are asked for.
    """
    engine = Engine(field, threads, for_edits=False)
    for rig in rigs:
        yield engine.evaluate(rig, settings, with_seen)
