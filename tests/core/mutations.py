"""Small mistakes outside of the kernels that the tests of core must catch: each is one replacement in one source file.

`tests/core/kernels/mutations.py` holds those of kernels, engine and metric. A mutation whose text is not in the file
exactly once is an error, so this list follows the sources.
"""

from __future__ import annotations

from typing import NamedTuple

SMALL = "test_small_mistakes.py"
TESTS = {
    "core/geometry.py": (
        SMALL,
        "test_geometry.py",
    ),
    "core/files.py": (
        SMALL,
        "test_files.py",
    ),
    "core/shown_text.py": ("test_shown_text.py",),
    "core/engine/inspect.py": ("test_engine_inspect.py",),
    "core/engine/sight.py": ("test_sight.py",),
    "core/engine/audit.py": ("test_audit.py",),
    "core/metric/entropy.py": ("test_entropy.py",),
    "core/metric/scoring.py": ("test_scores.py", "test_engine_edits.py"),
    "core/metric/voxel.py": ("test_voxel.py",),
    "core/scene/grid.py": (
        SMALL,
        "test_grid.py",
    ),
    "core/scene/columns.py": ("test_pog_hostile.py", "test_grid.py", "test_entropy.py"),
    "core/scene/filling.py": ("test_filling.py", "test_pog_oracle.py"),
    "core/scene/boxes.py": (SMALL, "test_readers_table.py", "test_pog_oracle.py", "test_readers_nuscenes.py"),
    "core/scene/pog.py": ("test_pog_oracle.py", "test_pog_parts.py", "test_coarse.py", "test_pog_store.py"),
    "core/scene/pog_checks.py": (
        SMALL,
        "test_pog_hostile.py",
    ),
    "core/scene/pog_store.py": ("test_pog_store.py", "test_pog_hostile.py"),
    "core/scene/pog_parts.py": ("test_pog_parts.py",),
    "core/scene/readers/common.py": (
        SMALL,
        "test_readers_table.py",
        "test_readers_limits.py",
        "test_readers_collection.py",
    ),
    "core/scene/readers/frames.py": (SMALL, "test_readers_table.py", "test_readers_limits.py"),
    "core/scene/readers/classes.py": (
        SMALL,
        "test_readers_classes.py",
    ),
    "core/scene/readers/parquet_pages.py": (
        SMALL,
        "test_readers_expansion.py",
    ),
    "core/scene/readers/feather_sizes.py": ("test_readers_expansion.py",),
    "core/simulate/channels.py": ("simulate/test_tables.py", "simulate/test_dataset.py"),
    "core/simulate/clutter.py": ("simulate/test_sweeps.py",),
    "core/simulate/dataset.py": ("simulate/test_dataset.py",),
    "core/simulate/tables.py": ("simulate/test_tables.py",),
    "core/simulate/units.py": ("simulate/test_tables.py", "simulate/test_dataset.py"),
    "core/simulate/carla_session.py": ("simulate/test_carla.py",),
    "core/simulate/carla_collection.py": ("simulate/test_carla.py",),
    "core/rig/edits.py": ("rig/test_mirror.py", "rig/test_many.py"),
    "core/rig/history.py": (SMALL, "rig/test_history.py", "rig/test_edit_names.py"),
    "core/rig/model.py": (
        SMALL,
        "rig/test_mirror.py",
        "rig/test_limits.py",
        "rig/test_yaml_errors.py",
        "test_rays.py",
    ),
    "core/rig/yaml/nodes.py": ("rig/test_yaml_errors.py",),
    "core/rig/yaml/file.py": ("rig/test_yaml.py", "rig/test_yaml_edits.py"),
    "core/rig/yaml/text.py": (
        SMALL,
        "rig/test_yaml.py",
    ),
    "core/rig/pose_text.py": (
        SMALL,
        "rig/test_pose_text.py",
    ),
    "core/formats/source.py": (
        SMALL,
        "formats/test_hostile.py",
    ),
    "core/formats/frames.py": (
        SMALL,
        "formats/test_poses_read.py",
        "formats/test_poses_written.py",
        "formats/test_hostile.py",
    ),
    "core/formats/lenses.py": ("formats/test_driveworks.py", "formats/test_lenses_written.py"),
    "core/sensing/rays.py": (SMALL, "test_rays.py", "test_lattice.py", "test_listed_rays.py"),
    "core/sensing/lens.py": (
        SMALL,
        "test_lens.py",
    ),
    "core/sensing/camera.py": ("test_lens.py", "test_rays.py"),
    "core/view/projection.py": ("view/test_camera_picture.py",),
    "core/view/range_image.py": ("view/test_range_image.py",),
    "core/view/display.py": ("view/test_display.py",),
}
"""Which tests stand guard over a source file, in tests/core."""


class Mutation(NamedTuple):
    """A mistake: the text of a file that is replaced, and by what."""

    file: str
    right: str
    wrong: str


def _of(file: str, *pairs: tuple[str, str]) -> list[Mutation]:
    return [Mutation(file, right, wrong) for right, wrong in pairs]


MUTATIONS = [
    *_of(
        "core/simulate/channels.py",
        ("(ego_m - self.place_m) @ self.rotation)", "(ego_m - self.place_m) @ self.rotation.T)"),
        ("np.mean([lidar.position for lidar in lidars], axis=0) - origin_m", "-origin_m"),
        ("xyzw[:, [3, 0, 1, 2]]", "xyzw"),
    ),
    *_of(
        "core/simulate/clutter.py",
        ("result &= gap <= mine[..., axis]", "result |= gap <= mine[..., axis]"),
        ("users.centre_m, np.zeros((1, 2))])", "users.centre_m, np.full((1, 2), 90.0)])"),
    ),
    *_of(
        "core/simulate/dataset.py",
        ("if needed * SPARE > free:", "if needed > free:"),
        ("if tuple(note[\"frame\"] for note in notes) == piece.frames", "if True"),
        ("if held and PLAN not in held:", "if False:"),
        ("        shutil.rmtree(self.path / WORK)\n", ""),
    ),
    *_of(
        "core/simulate/tables.py",
        ("quaternions(rotation @ truth.rotation)", "quaternions(truth.rotation)"),
        ('"size": [width, length, height]', '"size": [length, width, height]'),
        ("ego_origin_m(self._rig)) @ rotation.T", "ego_origin_m(self._rig)) @ rotation"),
    ),
    *_of(
        "core/simulate/units.py",
        ("ring = ring + beams[sweep.sensor]", "ring = ring + 0.0 * beams[sweep.sensor]"),
        ("if files.keys() != unit.file_names() or frames", "if frames"),
        ("np.where(alone > 0, alone, sweep.alone)", "np.where(alone > 0, alone, 1)"),
    ),
    *_of(
        "core/simulate/carla_session.py",
        ("_MIRRORED = np.diag([1.0, -1.0, 1.0])", "_MIRRORED = np.diag([1.0, 1.0, 1.0])"),
        ("carla.Location(x=x, y=-y, z=z)", "carla.Location(x=x, y=y, z=z)"),
        ("pitch=-pitch, yaw=-yaw", "pitch=pitch, yaw=-yaw"),
        ("            if sent.frame == number:\n                return sent", "            return sent"),
        ("            world.apply_settings(before)", "            world.apply_settings(now)"),
    ),
    *_of(
        "core/simulate/carla_collection.py",
        ("mirrored(records[:, :3])", "records[:, :3]"),
        ("from_above = np.argsort(-lidar.elevations()", "from_above = np.argsort(lidar.elevations()"),
        ("(red + 256.0 * green + 65536.0 * blue)", "(blue + 256.0 * green + 65536.0 * red)"),
        ("[:, :, 2::-1]", "[:, :, :3]"),
    ),
    *_of(
        "core/engine/inspect.py",
        ('if words is None or not int(index.words[word]) & bit:', 'if words is None:'),
        ('return bool(int(words[word]) & bit)', 'return bool(int(words[word]))'),
        ('if sensor.enabled else None', 'if True else None'),
        ('range(MOST_COUNTED - 1, 0, -1)', 'range(1, MOST_COUNTED)'),
        ('    levels &= engine.field.index.words\n', ''),
        ('levels[level] |= levels[level - 1] & words', 'levels[level] |= levels[level - 1] | words'),
    ),
    *_of(
        "core/engine/sight.py",
        ('if not sensor.enabled:', 'if False:'),
        ('(np.array(voxel) + 0.5) * edge', '(np.array(voxel) + 1.0) * edge'),
        ('edge * math.sqrt(3.0) / 2)', 'edge / 16)'),
        ('    if _would_cross(sensor, nearest.directions, low, high):\n', '    if False:\n'),
        ('if not side and _is_out_of_range(sensor, low, high):', 'if _is_out_of_range(sensor, low, high):'),
        ('return nearest >= far or farthest <= near', 'return farthest >= far or farthest <= near'),
        ('return nearest >= far or farthest <= near', 'return nearest >= far'),
        ('crosses = leave > enter', 'crosses = leave >= 0.0 * enter'),
        ('third = (end - start) / 3', 'third = (end - start) / 2'),
        ('_SEARCH_STEPS = 60', '_SEARCH_STEPS = 3'),
        ('if elevation > lidar.elevations().max():\n        return "above"',
         'if elevation > lidar.elevations().max():\n        return "below"'),
        ('sensor.pose.rotation().T @ centre', 'sensor.pose.rotation() @ centre'),
        ('_WIDE_GAP = 3.0', '_WIDE_GAP = 0.3'),
        ('return "beside" if 0.0 < past < gaps[widest] else ""', 'return "beside"'),
        ('> 0.5 * (outwards @ outwards)', '> 5.0 * (outwards @ outwards)'),
        ('"above" if row == 0 else "below"', '"below" if row == 0 else "above"'),
        ('return 1 if place == 0 else place - 1', 'return 1 if place == 0 else place'),
        ('if along[place] > best_cosine:', 'if along[place] < best_cosine:'),
        ('near = (beside <= least + radius_m) & (along > -radius_m)', 'near = (beside <= least) & (along > -radius_m)'),
    ),
    *_of(
        "core/engine/audit.py",
        ('twice |= once & own\n        once |= own', 'once |= own\n        twice |= once & own'),
        ('twice | (once & ~own)', 'twice | once'),
        ('_seen_nat(free, name, sensor) - _seen_nat(cut, name, sensor)',
         '_seen_nat(cut, name, sensor) - _seen_nat(free, name, sensor)'),
        ('(found.camera if sensor.kind == "camera" else found.lidar)',
         '(found.lidar if sensor.kind == "camera" else found.camera)'),
        ('lost[name] / totals[name] if totals[name] else 0.0', 'lost[name] if totals[name] else 0.0'),
        ('count / max(1, self.rays)', 'count / max(2, self.rays)'),
    ),
    *_of(
        "core/geometry.py",
        ("[-sp, cp * sr, cp * cr]", "[sp, cp * sr, cp * cr]"),
        ("-rotation @ np.array(self.position_m)", "rotation @ np.array(self.position_m)"),
        ("self.rotation() @ part.rotation()", "part.rotation() @ self.rotation()"),
        ("if level < 1e-12:", "if level < 1e-2:"),
        ("_SAME_DEG = 1e-9", "_SAME_DEG = 1e-3"),
    ),
    *_of(
        "core/files.py",
        ("            stream.flush()\n            os.fsync(stream.fileno())\n        if target", "        if target"),
        ("        os.replace(temporary, target)\n    except", "        os.rename(target, temporary)\n    except"),
        ("            os.chmod(temporary,", "            (temporary,"),
        ("    _sync_folder(target.parent)\n\n\ndef _open(", "\n\ndef _open("),
        ("    if is_stream(path):\n        return", "    if False:\n        return"),
        ("return run != _RUN if process == os.getpid() else", "return False if process == os.getpid() else"),
        ("    if place != _place():\n        return False\n", ""),
        ("if entry.name not in files or not entry.is_file()", "if False"),
        ("        os.rename(old, target)\n        raise", "        raise"),
    ),
    *_of(
        "core/shown_text.py",
        ("\\x7f-\\x9f", "\\x7f"),
        ("\\u2028-\\u202e", "\\u2028"),
        ('"＝", ', ""),
    ),
    *_of(
        "core/metric/entropy.py",
        ("np.rint(entropy_of_counts", "np.floor(entropy_of_counts"),
        ("if not informative.all():", "if False:"),
    ),
    *_of(
        "core/metric/scoring.py",
        ("sums_q[row, VOXELS]", "sums_q[0, VOXELS]"),
    ),
    *_of(
        "core/metric/voxel.py",
        ("(keep & (bit - 1))", "(keep & bit)"),
        ("iz // 64, 1 << (iz % 64)", "iz // 64, 1 << (iz % 63)"),
        ("return 0 < _count(pog, cls, voxel) < pog.data.frames", "return 0 < _count(pog, cls, voxel)"),
    ),
    *_of(
        "core/scene/grid.py",
        ("MIN_VOXEL_M <= self.voxel_m", "0.0 < self.voxel_m"),
        ("-self.roi_m[1] / 2, 0.0", "-self.roi_m[1] / 2, -self.roi_m[2] / 2"),
        ("(cells + 0.5)", "cells"),
        ("nx * ny >= MAX_COLUMNS", "False"),
        ("if needed > available:", "if False:"),
    ),
    *_of(
        "core/scene/columns.py",
        ("if top >> (levels % 64):", "if False:"),
        ("(grid.shape[2] + 63) // 64", "grid.shape[2] // 64 + 1"),
        ("words.shape != (words_in(grid),)", "False"),
    ),
    *_of(
        "core/scene/filling.py",
        ("(high > -1.0)", "(high > 1.0)"),
        ("np.add(target, marks > 0, out=target)", "np.add(target, marks, out=target)"),
        ("np.abs(rotation), half_m", "rotation, half_m"),
        ("batch.size_m[rows] / 2", "batch.size_m[rows]"),
    ),
    *_of(
        "core/scene/boxes.py",
        ("rotation[:, 0, 0], rotation[:, 0, 1] = cos, -sin", "rotation[:, 0, 0], rotation[:, 0, 1] = cos, sin"),
        ("/ np.linalg.norm(wxyz, axis=1, keepdims=True)", ""),
        ("2 * (x * y - w * z)", "2 * (x * y + w * z)"),
        ("len(self.names) + more.sequence", "more.sequence"),
    ),
    *_of(
        "core/scene/pog.py",
        ("report.frames <= np.iinfo(np.uint16).max", "True"),
    ),
    *_of(
        "core/scene/pog_checks.py",
        ("if most > self.header.data.frames:", "if False:"),
        ("is_fortran and len(shape) > 1", "False"),
        ("if needed > free:", "if False:"),
        ("if stream.read(1):", "if False:"),
        ("0 if is_part else 1, MAX_FRAMES", "0, MAX_FRAMES"),
        ("not isinstance(value, bool) and low <= value <= high", "low <= value <= high"),
        ("zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)", "member.compress_type,)"),
        ("0 < dtype.itemsize <= 4 * most_chars", "True"),
        ('any("\\ud800" <= letter', 'any("\\ue800" <= letter'),
    ),
    *_of(
        "core/scene/pog_store.py",
        ("if _digest(content.text, content.voxels.words, content.counts) != content.digest:", "if False:"),
        ("digest.update(np.ascontiguousarray(counts).data)", "pass"),
        ("digest.update(np.ascontiguousarray(words).data)", "pass"),
        ("if pog.grid != grid:", "if False:"),
        ("source.content_hash, grid.voxel_m.hex()", "grid.voxel_m.hex()"),
    ),
    *_of(
        "core/scene/pog_parts.py",
        ("if part.grid != grid or part.data.sha256 != group.content_hash:", "if part.grid != grid:"),
        ("future.exception() is not None, waiting[future]", "waiting[future]"),
    ),
    *_of(
        "core/scene/readers/common.py",
        ("np.abs(centre_m) <= MAX_POSITION_M", "centre_m <= MAX_POSITION_M"),
        ("(size_m > 0.0)", "(size_m >= 0.0)"),
        ("frames is not None and frames < report.frames", "False"),
        ("options.frames, list(options", "list(options"),
        ("batch.centre_m + np.asarray", "batch.centre_m - np.asarray"),
        ('side="right"', 'side="left"'),
        ("sum(report.frames for report in reports)", "max(report.frames for report in reports)"),
    ),
    *_of(
        "core/scene/readers/frames.py",
        ("(same & (frame < before_frame))", "False"),
    ),
    *_of(
        "core/scene/readers/classes.py",
        ("if cls not in (*CLASSES, IGNORE):", "if False:"),
    ),
    *_of(
        "core/scene/readers/parquet_pages.py",
        ("if largest > MAX_PAGE_BYTES:", "if False:"),
        ("if largest > MAX_REPEATED_BYTES:", "if False:"),
        ("if length > MAX_FOOTER_BYTES:", "if False:"),
        ("if rows > MAX_ROWS:", "if False:"),
        ("(value >> 1) ^ -(value & 1)", "value >> 1"),
        ("at += page.header_bytes + page.stored_bytes", "at += page.stored_bytes"),
    ),
    *_of(
        "core/scene/readers/feather_sizes.py",
        ("total += length if full == _NOT_COMPRESSED else full", "total += length"),
        ("if kind not in (_DICTIONARY, _RECORDS):", "if kind != _RECORDS:"),
    ),
    *_of(
        "core/rig/edits.py",
        ("0.0 - roll, pitch, 0.0 - yaw", "0.0 - roll, pitch, yaw"),
        ("(x, 0.0 - y, z), (0.0", "(x, y, z), (0.0"),
        ("if sensor.pose == mirrored_pose(sensor.pose):", "if False:"),
        ("other.kind == sensor.kind and ", ""),
        ("is_new or not _agrees(leader, old.get(leader.name))", "is_new"),
        ("renamed.get(sensor.mirror_of or \"\")", "None"),
        ('"right" if y_m > 0.0 else "left"', '"right" if y_m < 0.0 else "left"'),
    ),
    *_of(
        "core/rig/history.py",
        ("bool(self.numbers) and self.numbers == other.numbers", "bool(self.numbers)"),
        ("and not isinstance(value, bool)", ""),
        ("del self._steps[self._index + 1 :]", "pass"),
        ("is_last and self.committed is not self._saved", "is_last"),
        ("same_rig(rig, self.committed) and marks == self.marks", "same_rig(rig, self.committed)"),
        ("if self._index == len(self._steps) - 1:\n            return False", "if False:\n            return False"),
        ("and not same_rig(self.rig, self._saved)", ""),
    ),
    *_of(
        "core/rig/model.py",
        ("(self.to - self.from_) / (self.count - 1)", "(self.to - self.from_) / self.count"),
        ("if span_deg > 360.0:", "if False:"),
        ("len(offsets) != beams", "False"),
        ("not 0 < self.ray_count <= MAX_RAYS_PER_SENSOR", "False"),
        ("math.radians(self.hfov_deg) / 2", "math.radians(self.hfov_deg)"),
        ("elif other in taken:", "elif False:"),
        ("elif kinds[other] != kind:", "elif False:"),
        ("if sensor.name in seen:", "if False:"),
        ("ge=0.001, le=179.9", "ge=0.0001, le=179.9"),
        ("isinstance(s, Lidar) and s.enabled", "isinstance(s, Lidar)"),
    ),
    *_of(
        "core/rig/yaml/nodes.py",
        ("if depth > MAX_DEPTH:", "if False:"),
        ("if self._count > MAX_VALUES:", "if False:"),
        ("if key.text in lines:", "if False:"),
        ("if not is_first:", "if False:"),
        ("if tag := _LONG_TAG.search(text):", "if False and (tag := _LONG_TAG.search(text)):"),
        ("if len(content) > MAX_BYTES:", "if False:"),
    ),
    *_of(
        "core/rig/yaml/file.py",
        ("if size_bytes > MAX_BYTES:", "if False:"),
        ("if size_bytes > MAX_VALUES:", "if False:"),
        ("key not in LATER_FIELDS or value is not None", "True"),
    ),
    *_of(
        "core/rig/yaml/text.py",
        ("return float(one) == float(other) and math.copysign(1.0, one) == math.copysign(1.0, other)",
         "return float(one) == float(other)"),
        ("value.lower() not in _OLD_YAML_BOOLS", "True"),
        ('text.replace("e", ".0e") if "e" in text and "." not in text else text', "text"),
        ("one.keys() == other.keys() and", ""),
    ),
    *_of(
        "core/rig/pose_text.py",
        ("abs(metres) <= MAX_METRES", "metres <= MAX_METRES"),
        ("abs(degrees) <= MAX_DEGREES", "True"),
        ("_RIGID_TOLERANCE = 1e-3", "_RIGID_TOLERANCE = 1e-1"),
    ),
    *_of(
        "core/formats/source.py",
        ('if line.count(".") > MAX_DOTS:', "if False:"),
        ('if sum(map(text.count, ",[{")) > MAX_JSON_VALUES:', "if False:"),
        ("if self._count > MAX_ELEMENTS:", "if False:"),
        ("if len(self._stack) >= MAX_DEPTH:", "if False:"),
        ("        if key in fields:\n            raise", "        if False:\n            raise"),
        ("    if len(content) > limit:\n", "    if False:\n"),
        ('if b"\\0" in content:', "if False:"),
        ("if isinstance(value, bool) or not isinstance(value, (int, float))", "if not isinstance(value, (int, float))"),
    ),
    *_of(
        "core/formats/frames.py",
        ("if np.linalg.det(rotation) < 0.0 or error", "if error"),
        ("error > _WORST_ROTATION", "False"),
        ("if child in self._parents or child == parent:", "if child == parent:"),
        ("parent_SE3_optical @ se3(BODY_R_OPTICAL.T,", "parent_SE3_optical @ se3(BODY_R_OPTICAL,"),
    ),
    *_of(
        "core/formats/lenses.py",
        ("{key: number / focal_px for", "{key: number for"),
        ("focal_px * lens.stretch", "focal_px"),
    ),
    *_of(
        "core/sensing/rays.py",
        ("(np.arange(camera.cast[1]) + 0.5)", "np.arange(camera.cast[1])"),
        ("(low <= origin) & (origin < high)", "(low <= origin) & (origin <= high)"),
    ),
    *_of(
        "core/sensing/lens.py",
        ("_brown_conrady(lens, x, y), axis=-1)", "_brown_conrady(lens, y, x), axis=-1)"),
        ("2.0 * lens.p1 * x * y + lens.p2 * (s + 2.0 * x * x)", "2.0 * lens.p2 * x * y + lens.p1 * (s + 2.0 * x * x)"),
    ),
    *_of(
        "core/sensing/camera.py",
        ("[ahead, -right, -down]", "[ahead, right, -down]"),
        ("rays // columns + 0.5", "rays // columns"),
        ("np.where(depth > 0.0, optical[:, :2] / depth, np.nan)", "optical[:, :2] / depth"),
    ),
    *_of(
        "core/view/projection.py",
        ("high = np.where((at_a < 0.0) & (at_b < 0.0), -1.0, high)", "pass"),
    ),
    *_of(
        "core/view/range_image.py",
        ("np.argsort(-elevations,", "np.argsort(elevations,"),
        ("180.0 - np.mod(180.0 - angles_deg, 360.0)", "np.mod(180.0 + angles_deg, 360.0) - 180.0"),
    ),
    *_of(
        "core/view/display.py",
        ("        if cls not in self._last:\n", "        if not self._last:\n"),
    ),
]  # fmt: skip

SURVIVORS = (
    (
        Mutation(
            "core/rig/yaml/file.py",
            "        if not _says(text, rig):\n            text = rig_text(rig)\n",
            "",
        ),
        "a net: no edit is known whose text says something else than the rig",
    ),
    (
        Mutation(
            "core/scene/pog_checks.py",
            'if not piece:\n            raise ValueError(f"{name}: cut off")',
            "if not piece:\n            break",
        ),
        "what is missing is refused by the checksum of the whole, with another word",
    ),
    (
        Mutation("core/rig/model.py", "or math.isinf(low) or", "or"),
        "an infinite start is never below the end: `low < high` refuses it as well",
    ),
)
"""Mistakes that change no result, and why; they were tried with the others."""
