"""The car in three dimensions on a report's page: sensors of any kind, also those without rays."""

from riglens.core.rig.presets import preset
from riglens.reporting.drawings import view_data


def test_a_sensor_of_which_all_is_blocked_is_in_the_picture_without_rays() -> None:
    rig = preset("Line")
    everything = {"azimuth_deg": (-180.0, 180.0), "elevation_deg": (-90.0, 90.0)}
    blind = rig.sensors[0].replace(name="blind", blocked=(everything,))
    seeing, unseeing = view_data(rig.replace(sensors=(rig.sensors[0], blind)))["rays"]
    assert seeing["ends"] and not unseeing["ends"]
