"""The one small interface of all formats: recognise a source, read it to a rig, write a rig to files."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from riglens.core.formats.mounts import ON_ROOF, SEDAN, Mounting, Origin, ReadOptions
from riglens.core.formats.report import Notes, OpenedRig, Report
from riglens.core.formats.source import Source
from riglens.core.formats.unread import note_unread
from riglens.core.rig.model import Rig, Vehicle


@dataclass(frozen=True)
class Exported:
    """The text of every file by its name, with a report on everything in the rig."""

    files: Mapping[str, str]
    report: Report


@dataclass(frozen=True)
class Format:
    """A format by its name on the command line; `reads` or `writes` is None if it is not supported.

    suffixes: those of its files, of which `recognises` is asked, and of folders where has_folders. endings: file name
    endings that belong to this format only; is_folder: whether it is written as a folder. Where files do not say it:
    vehicle, described by `car`, and origin. harmless: a pattern of fields that are not read because they bear on
    neither pose nor view.
    """

    name: str
    title: str
    suffixes: tuple[str, ...]
    recognises: Callable[[Source], bool]
    reads: Callable[[Source, Mounting], Rig] | None = None
    writes: Callable[[Rig, Notes], Mapping[str, str]] | None = None
    endings: tuple[str, ...] = ()
    is_folder: bool = False
    has_folders: bool = False
    vehicle: Vehicle = SEDAN
    car: str = "a sedan"
    origin: Origin = ON_ROOF
    harmless: str = ""

    def fits(self, source: Source) -> bool:
        """Return whether a file or folder is in this format."""
        is_asked = self.has_folders if source.is_folder else source.suffix in self.suffixes
        return is_asked and self.recognises(source)

    def read(self, source: Source, options: ReadOptions) -> OpenedRig:
        """Read a rig; raise InputError with file, field, what was found and what is accepted."""
        assert self.reads is not None
        source.reads.forget()
        mounting = Mounting(source.where, Notes(), options, self.vehicle, self.car, self.origin)
        rig = self.reads(source, mounting)
        note_unread(source.reads, mounting.notes, self.harmless)
        return OpenedRig(rig, mounting.notes.report(self.title), mounting.file)

    def write(self, rig: Rig) -> Exported:
        """Return the files of a rig; raise InputError when it cannot be written."""
        assert self.writes is not None
        notes = Notes()
        return Exported(self.writes(rig, notes), notes.report(self.title))
