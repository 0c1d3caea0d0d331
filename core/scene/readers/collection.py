"""Combine several box data sets: logs of a folder, tables of a folder, or any paths that a user names together."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property

from riglens.core.geometry import Vec3
from riglens.core.scene.boxes import BoxBatch, DataReport, Progress
from riglens.core.scene.readers.common import FileBoxSource, added_up, require_frames, with_all_frames


class BoxCollection:
    """A BoxSource over members, read one after the other; frames and boxes add up.

    The content hash does not depend on the order of the members. frames: number of frames T of the whole, for
    data in which empty frames leave no trace. is_part: whether it belongs to a larger set, so that it may hold
    no frame.
    """

    def __init__(
        self,
        name: str,
        members: Sequence[FileBoxSource | BoxCollection],
        frames: int | None = None,
        is_part: bool = False,
    ) -> None:
        require_frames(frames)
        self.name = name
        self._members, self._frames, self._is_part = tuple(members), frames, is_part
        self._report: DataReport | None = None

    @property
    def origin_m(self) -> Vec3 | None:
        """Place of the origin in the vehicle frame, metres, when it is the same for all members."""
        places = {member.origin_m for member in self._members}
        return places.pop() if len(places) == 1 else None

    def parts(self) -> Sequence[FileBoxSource]:
        """Return the parts of all members."""
        return [part for member in self._members for part in member.parts()]

    @cached_property
    def content_hash(self) -> str:
        """SHA-256 (hex) over the hashes of the members and the number of frames."""
        hashes = sorted(member.content_hash for member in self._members)
        return hashlib.sha256(repr(("collection", self._frames, hashes)).encode()).hexdigest()

    def forget_hashes(self) -> None:
        """Recompute content hashes: the collection has come to another machine."""
        for source in (self, *self._members):
            vars(source).pop("content_hash", None)

    def batches(self, progress: Progress | None = None) -> Iterator[BoxBatch]:
        """Stream the boxes of all members; raise InputError on bad input."""
        reports: list[DataReport] = []
        for place, member in enumerate(self._members):
            before = sum(report.frames for report in reports)
            for batch in member.batches(_share(progress, place, len(self._members))):
                yield replace(batch, frame=batch.frame + before)
            reports.append(member.report())
        self._report = self.merged(reports)

    def merged(self, reports: Sequence[DataReport]) -> DataReport:
        """Return the report of the whole from those of the members, or of their parts."""
        report = added_up(self.name, self.content_hash, reports)
        return report if self._is_part else with_all_frames(report, self._frames)

    def report(self) -> DataReport:
        """Return the counts of the last complete pass of `batches`; raise RuntimeError before the first one."""
        if self._report is None:
            raise RuntimeError("no complete pass over the boxes yet")
        return self._report


def _share(progress: Progress | None, place: int, count: int) -> Progress | None:
    """Return a progress function of one member that reports progress of the whole."""
    if progress is None:
        return None
    return lambda fraction: progress((place + fraction) / count)
