"""The sensors in the scene: one actor each, moved by its matrix; rebuilt only when its look changes."""

from __future__ import annotations

import pyvista as pv

from core.geometry import Pose
from core.rig.model import Camera, Lidar
from widgets.theme import Palette
from widgets.viewport.materials import rgba_actor
from widgets.viewport.sensor_shapes import sensor_mesh


class SensorLayer:
    """Pucks and camera bodies by sensor name."""

    def __init__(self, renderer: pv.Renderer) -> None:
        self._renderer = renderer
        self._actors: dict[str, pv.Actor] = {}
        self._looks: dict[str, tuple[object, ...]] = {}

    def set_sensors(self, sensors: list[Lidar | Camera], lit: frozenset[str], palette: Palette) -> None:
        """Show exactly these sensors; those named in `lit` are highlighted."""
        for gone in self._actors.keys() - {sensor.name for sensor in sensors}:
            self._renderer.RemoveActor(self._actors.pop(gone))
            del self._looks[gone]
        for sensor in sensors:
            self._set_look(sensor, sensor.name in lit, palette)
            self.set_pose(sensor.name, sensor.pose)

    def set_pose(self, name: str, pose: Pose) -> None:
        """Move a shown sensor."""
        if name in self._actors:
            self._actors[name].user_matrix = pose.vehicle_SE3_sensor()

    def _set_look(self, sensor: Lidar | Camera, lit: bool, palette: Palette) -> None:
        look = (sensor.kind, lit, sensor.enabled, palette.kinds[sensor.kind], palette.selected)
        if self._looks.get(sensor.name) == look:
            return
        mesh = sensor_mesh(sensor, palette, lit, sensor.enabled)
        if sensor.name in self._actors:
            self._actors[sensor.name].mapper.dataset = mesh
        else:
            actor = rgba_actor(mesh, "rgb")
            prop = actor.prop
            prop.lighting, prop.interpolation = True, "Phong"
            prop.ambient, prop.diffuse, prop.specular, prop.specular_power = 0.4, 0.6, 0.3, 25.0
            self._renderer.AddActor(actor)
            self._actors[sensor.name] = actor
        self._looks[sensor.name] = look
