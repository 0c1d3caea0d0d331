"""Verdicts on requirements as JUnit XML, as pipelines show test results."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from typing import Any
from xml.etree import ElementTree as ET

from riglens.core.metric.scores import Body
from riglens.core.review.documents import settings_text
from riglens.core.review.findings import Verdict
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.file import rig_sha256
from riglens.core.shown_text import visible


@dataclass(frozen=True)
class RigCheck:
    """The verdicts on a rig, called by its name, with a number where several rigs have that; sources: what they depend
    on besides the rig."""

    rig: Rig
    body: Body
    verdicts: tuple[Verdict, ...]
    title: str
    sources: Mapping[str, Any]

    @property
    def settings_text(self) -> str:
        """Return the settings of the verdicts in one line."""
        return settings_text(self.sources)

    def unmet(self, day: date | None) -> list[Verdict]:
        """Return the requirements that are not met on a day."""
        return [verdict for verdict in self.verdicts if not verdict.holds_on(day)]


def junit_xml(checks: Sequence[RigCheck], file: str, lines: Mapping[str, int], day: date) -> bytes:
    """Return one test suite per rig and one test case per requirement; waived or optional ones are skipped.

    file: of the requirements; lines: of each by its id. Valid by junit-10.xsd of Jenkins' xUnit plugin.
    """
    root = ET.Element("testsuites", name="riglens check")
    for check in checks:
        suite = ET.SubElement(root, "testsuite", _counts(check, day), file=visible(file))
        listed = ET.SubElement(suite, "properties")
        for name, value in _properties(check).items():
            ET.SubElement(listed, "property", name=name, value=visible(value))
        for verdict in check.verdicts:
            _case(suite, check, verdict, f"{file}:{lines[verdict.item.id]}", day)
    ET.indent(root)
    return bytes(ET.tostring(root, encoding="utf-8", xml_declaration=True)) + b"\n"


def _properties(check: RigCheck) -> dict[str, str]:
    """Return what the verdicts on a rig depend on, as words."""
    found = {"body": check.body, "rig sha256": rig_sha256(check.rig), "settings": check.settings_text}
    for name, value in check.sources.items():
        if name == "data":
            found |= {f"data {key}": str(part) for key, part in (value or {}).items()}
        elif name == "requirements":
            found |= {f"requirements {key}": str(part) for key, part in value.items()}
        elif name == "profiles":
            found["profiles sha256"] = " ".join(part["sha256"] for part in value)
        elif value is not None:
            found[name] = " ".join(map(str, value)) if isinstance(value, list) else str(value)
    return found


def _counts(check: RigCheck, day: date) -> dict[str, str]:
    skipped = sum(_skips(verdict, day) for verdict in check.verdicts)
    return {
        "name": visible(check.title),
        "tests": str(len(check.verdicts)),
        "failures": str(len(check.unmet(day))),
        "errors": "0",
        "skipped": str(skipped),
        "time": "0",
    }


def _skips(verdict: Verdict, day: date) -> bool:
    return verdict.holds_on(day) and verdict.status != "met"


def _case(suite: ET.Element, check: RigCheck, verdict: Verdict, place: str, day: date) -> None:
    name = f"{verdict.item.id}: {verdict.item.requirement.label or verdict.text}"
    attributes = {"name": visible(name), "classname": visible(check.title), "time": "0"}
    case = ET.SubElement(suite, "testcase", attributes)  # which has no file or line in Jenkins' schema
    if verdict.status == "met":
        return
    message = f"{verdict.status}: {verdict.text}: {verdict.found_text}, {verdict.accepted_text}"
    tag = "skipped" if _skips(verdict, day) else "failure"
    note = ET.SubElement(case, tag, message=visible(message))
    if tag == "failure":
        note.set("type", verdict.status)
    note.text = "\n".join(visible(line) for line in (place, *verdict.lines(day)))
