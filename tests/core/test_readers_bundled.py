"""The scenario that comes with the program reads like any table."""

import json
from importlib import resources

from riglens.core.scene.readers import bundled_source


def test_the_bundled_scenario_holds_what_its_note_says() -> None:
    note = json.loads(resources.files("riglens.assets").joinpath("scenarios/town/scenario.json").read_text())
    source = bundled_source()
    total = sum(batch.frame.size for batch in source.batches())
    report = source.report()
    assert report.frames == note["frames"] >= 2000
    assert sum(report.boxes.values()) == total
    assert all(count > 0 for count in report.boxes.values())
    assert not report.unmapped
