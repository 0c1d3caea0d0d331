"""Verdicts on requirements as JUnit XML, as pipelines show test results."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from xml.etree import ElementTree as ET

from riglens.core.metric.scores import Body
from riglens.core.review.findings import Verdict
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.file import rig_sha256
from riglens.core.shown_text import visible


@dataclass(frozen=True)
class RigCheck:
    """The verdicts on a rig."""

    rig: Rig
    body: Body
    verdicts: tuple[Verdict, ...]

    def unmet(self, day: date | None) -> list[Verdict]:
        """Return the requirements that are not met on a day."""
        return [verdict for verdict in self.verdicts if not verdict.holds_on(day)]


def junit_xml(
    checks: Sequence[RigCheck], file: str, lines: Mapping[str, int], properties: Mapping[str, str], day: date
) -> bytes:
    """Return one test suite per rig and one test case per requirement; waived or optional ones are skipped.

    file: of the requirements; lines: of each by its id; properties: of every suite. Valid by junit-10.xsd of Jenkins'
    xUnit plugin."""
    root = ET.Element("testsuites", name="riglens check")
    for check in checks:
        suite = ET.SubElement(root, "testsuite", _counts(check, day), file=visible(file))
        own = {"body": check.body, "rig sha256": rig_sha256(check.rig)}
        listed = ET.SubElement(suite, "properties")
        for name, value in (own | dict(properties)).items():
            ET.SubElement(listed, "property", name=name, value=visible(value))
        for verdict in check.verdicts:
            _case(suite, check, verdict, f"{file}:{lines[verdict.item.id]}", day)
    ET.indent(root)
    return bytes(ET.tostring(root, encoding="utf-8", xml_declaration=True)) + b"\n"


def _counts(check: RigCheck, day: date) -> dict[str, str]:
    skipped = sum(_skips(verdict, day) for verdict in check.verdicts)
    return {
        "name": visible(check.rig.name),
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
    attributes = {"name": visible(name), "classname": visible(check.rig.name), "time": "0"}
    case = ET.SubElement(suite, "testcase", attributes)  # which has no file or line in Jenkins' schema
    if verdict.status == "met":
        return
    message = f"{verdict.status}: {verdict.text}: {verdict.found_text}, {verdict.accepted_text}"
    tag = "skipped" if _skips(verdict, day) else "failure"
    note = ET.SubElement(case, tag, message=visible(message))
    if tag == "failure":
        note.set("type", verdict.status)
    note.text = "\n".join(visible(line) for line in (place, *verdict.lines(day)))
