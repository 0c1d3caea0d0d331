"""The sensors in the scene: one actor each, moved by its matrix; rebuilt only when its look changes."""

from __future__ import annotations

import pyvista as pv
from vtkmodules.vtkRenderingCore import vtkRenderer

from riglens.core.geometry import Pose
from riglens.core.rig.model import Camera, Lidar
from riglens.widgets.car.materials import rgba_actor
from riglens.widgets.sensors.sensor_shapes import Mark, sensor_body, sensor_mesh
from riglens.widgets.theme import Palette

_OFF_OPACITY, _GHOST_OPACITY = 0.45, 0.65


class SensorLayer:
    """Pucks, boxes and camera bodies by sensor name, and a ghost of one that is about to be put somewhere."""

    def __init__(self, renderer: vtkRenderer) -> None:
        self._renderer = renderer
        self._actors: dict[str, pv.Actor] = {}
        self._looks: dict[str, tuple[object, ...]] = {}
        self._ghost: pv.Actor | None = None

    def set_sensors(self, sensors: list[Lidar | Camera], marks: dict[str, Mark], palette: Palette) -> None:
        """Show exactly these sensors; those named in `marks` are selected or under the mouse."""
        for gone in self._actors.keys() - {sensor.name for sensor in sensors}:
            self._renderer.RemoveActor(self._actors.pop(gone))
            del self._looks[gone]
        for sensor in sensors:
            self._set_look(sensor, marks.get(sensor.name, ""), palette)
            self.set_pose(sensor.name, sensor.pose)

    def set_pose(self, name: str, pose: Pose) -> None:
        """Move a shown sensor."""
        if name in self._actors:
            self._actors[name].user_matrix = pose.vehicle_SE3_sensor()

    def set_ghost(self, sensor: Lidar | Camera | None, palette: Palette) -> None:
        """Show where a sensor would come to stand, or no longer."""
        if self._ghost is not None:
            self._renderer.RemoveActor(self._ghost)
            self._ghost = None
        if sensor is not None:
            self._ghost = self._new_actor(sensor_mesh(sensor_body(sensor), palette, "selected"))
            self._ghost.prop.opacity = _GHOST_OPACITY
            self._ghost.user_matrix = sensor.pose.vehicle_SE3_sensor()

    def _set_look(self, sensor: Lidar | Camera, mark: Mark, palette: Palette) -> None:
        body = sensor_body(sensor)
        look = (body, mark, sensor.enabled, palette.kinds[sensor.kind], palette.selected)
        if self._looks.get(sensor.name) == look:
            return
        mesh = sensor_mesh(body, palette, mark, sensor.enabled)
        if sensor.name in self._actors:
            self._actors[sensor.name].mapper.SetInputData(mesh)
        else:
            self._actors[sensor.name] = self._new_actor(mesh)
        self._actors[sensor.name].prop.opacity = 1.0 if sensor.enabled else _OFF_OPACITY
        self._looks[sensor.name] = look

    def _new_actor(self, mesh: pv.PolyData) -> pv.Actor:
        actor = rgba_actor(mesh, "rgb")
        prop = actor.prop
        prop.lighting, prop.interpolation = True, "Phong"
        prop.ambient, prop.diffuse, prop.specular, prop.specular_power = 0.4, 0.6, 0.3, 25.0
        self._renderer.AddActor(actor)
        return actor
