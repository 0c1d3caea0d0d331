"""A rig carries the mesh of its car's body once it has been read; files and hashes of the rig know nothing of it."""

import pickle

from riglens.core.rig.model import Rig
from riglens.core.rig.presets import preset
from riglens.core.rig.yaml.file import dumps, rig_sha256
from tests.core.review.scenes import BOX_FILE, box_mesh

UNREAD = preset("W+T").replace(vehicle=BOX_FILE)


def test_a_mesh_tells_rigs_apart_and_changes_no_file() -> None:
    mesh = box_mesh()
    one, other = UNREAD.with_body_mesh(mesh), UNREAD.with_body_mesh(box_mesh())
    assert UNREAD.vehicle.lacks_mesh and not one.vehicle.lacks_mesh and one.vehicle.body_mesh is mesh
    assert one == UNREAD.with_body_mesh(mesh) and one != UNREAD and one != other
    assert hash(one.vehicle) == hash(UNREAD.with_body_mesh(mesh).vehicle)
    assert (dumps(one), rig_sha256(one)) == (dumps(UNREAD), rig_sha256(UNREAD))
    assert one.with_body_mesh(None) == UNREAD


def test_edits_of_the_rig_keep_the_mesh_and_those_of_the_vehicle_drop_it() -> None:
    rig = UNREAD.with_body_mesh(box_mesh())
    assert rig.replace(name="other").vehicle.body_mesh is rig.vehicle.body_mesh
    assert rig.with_lidars_alone().vehicle is rig.vehicle
    assert rig.vehicle.replace(body="other.stl").lacks_mesh


def test_a_rig_takes_its_mesh_to_another_process() -> None:
    rig = UNREAD.with_body_mesh(box_mesh())
    there: Rig = pickle.loads(pickle.dumps(rig))
    assert there.vehicle.body_mesh is not None and rig.vehicle.body_mesh is not None
    assert there.vehicle.body_mesh.sha256 == rig.vehicle.body_mesh.sha256
    assert there.with_body_mesh(None) == UNREAD
