"""Small mistakes that the direct tests must catch: each is one replacement in one source file.

A mutation whose text is not in the file exactly once is an error, so this list follows the sources.
"""

from __future__ import annotations

from typing import NamedTuple

KERNELS, ENGINE, METRIC = "core/kernels", "core/engine", "core/metric"
TESTS = {
    f"{KERNELS}/bits.py": ("test_bits",),
    f"{KERNELS}/palette.py": ("test_palette",),
    f"{KERNELS}/predicates.py": ("test_predicates",),
    f"{KERNELS}/walk.py": ("test_walk",),
    f"{KERNELS}/profile.py": ("test_profile",),
    f"{KERNELS}/ties.py": ("test_ties",),
    f"{KERNELS}/fan.py": ("test_fan",),
    f"{KERNELS}/planes.py": ("test_fan",),
    f"{KERNELS}/frustum.py": ("test_frustum", "test_tolerances"),
    f"{KERNELS}/settle.py": ("test_settle",),
    f"{KERNELS}/cast.py": ("test_engine_by_hand",),
    f"{ENGINE}/fans.py": ("test_fan", "test_profile", "test_tolerances"),
    f"{ENGINE}/frustums.py": ("test_engine_by_hand", "test_tolerances"),
    f"{ENGINE}/caster.py": ("test_engine_by_hand",),
    f"{ENGINE}/engine.py": ("test_engine_by_hand",),
    f"{METRIC}/entropy.py": ("test_scores_by_hand",),
    f"{METRIC}/scoring.py": ("test_scores_by_hand",),
    f"{METRIC}/scores.py": ("test_scores_by_hand",),
    f"{METRIC}/estimate.py": ("test_scores_by_hand",),
}
"""Which direct tests stand guard over a source file."""


class Mutation(NamedTuple):
    """A mistake: the text of a file that is replaced, and by what."""

    file: str
    right: str
    wrong: str


def _of(file: str, *pairs: tuple[str, str]) -> list[Mutation]:
    return [Mutation(file, right, wrong) for right, wrong in pairs]


MUTATIONS = [
    *_of(
        f"{KERNELS}/bits.py",
        ("return np.int64(popcount(starts ^ later)) - 1", "return np.int64(popcount(starts ^ later))"),
        ("bits & ((later & (~later + one)) - one)", "bits & (later & (~later + one))"),
        ("FULL_WORD >> np.uint64(63 - high)", "FULL_WORD >> np.uint64(62 - high)"),
        ("min(high - 64 * part, 63))", "min(high - 64 * part, 62))"),
        ("(w % depth) * 64 + lowest_bit(bits)", "(w % depth) * 63 + lowest_bit(bits)"),
        ("popcount(words[w] & (lowest - np.uint64(1)))", "popcount(words[w] & lowest)"),
    ),
    *_of(
        f"{KERNELS}/palette.py",
        ("if begun == 0 or not _same(rows, row - 1, row):", "if not _same(rows, row - 1, row):"),
        ("and rows[a, 2] == rows[b, 2])", ")"),
        ("found < firsts.size", "found <= firsts.size"),
        ("while slots[slot] != EMPTY and not _same(rows, firsts[slots[slot]], row):", "while False:"),
    ),
    *_of(
        f"{KERNELS}/predicates.py",
        ("MOMENT_BOUND = 8.0 * UNIT_ROUNDOFF", "MOMENT_BOUND = 0.5 * UNIT_ROUNDOFF"),
        ("SMALLEST <= abs(value)", "SMALLEST < abs(value)"),
        ("abs(value) <= LARGEST", "abs(value) <= 4.0 * LARGEST"),
        ("return total, (a - (total - part)) + (b - part)", "return total, (a - (total - part)) - (b - part)"),
        ("+ a_low * b_low", "- a_low * b_low"),
        ("if a_low == 0.0 and b_low == 0.0:", "if True:"),
        ("_SPLITTER = 134217729.0", "_SPLITTER = 1.0"),
        ("terms[3], terms[2] = _two_product(-b_low, d1)", "terms[3], terms[2] = _two_product(b_low, d1)"),
        ("    sign = _sign_of_sum(terms)\n    return sign if (d1 > 0.0) == (d2 > 0.0) else -sign",
         "    sign = _sign_of_sum(terms)\n    return sign"),
    ),
    *_of(
        f"{KERNELS}/walk.py",
        ("if low <= np.floor(g) < high else (leave, leave)", "if low <= np.floor(g) <= high else (leave, leave)"),
        ("    return compare(entry, leave) < 0", "    return compare(entry, leave) <= 0"),
        ("if compare(into, entry) > 0:", "if compare(into, entry) < 0:"),
        ("blur = 4.0 * UNIT_ROUNDOFF", "blur = -4.0 * UNIT_ROUNDOFF"),
        ("        if order <= 0:\n", "        if order < 0:\n"),
        ("        if order >= 0:\n", "        if order > 0:\n"),
        ("compare(crossing, leave) >= 0", "compare(crossing, leave) > 0"),
        ("int(cell_before(g[2], d[2], crossing))", "int(cell_after(g[2], d[2], crossing))"),
        ("error[axis] += 2 * abs(delta[axis])", "error[axis] += abs(delta[axis])"),
    ),
    *_of(
        f"{KERNELS}/profile.py",
        ("TOLERANCE = 1e-8", "TOLERANCE = 1e-9"),
        ("if here > 0.0 and abs(there - here) < TOLERANCE:", "if here > 0.0 and abs(there - here) < -TOLERANCE:"),
        ("if here > leaves:", "if here < leaves:"),
        ("leaves = max(leaves, there)", "leaves = there"),
        ("if leaves <= farthest:", "if leaves < farthest:"),
        ("if here > farthest or there < here:", "if there < here:"),
        ("int(np.ceil(z0)) - 1", "int(np.ceil(z0))"),
        ("level + 1.0 - z0, level - z0)", "level + 1.0 - z0, level - 1.0 - z0)"),
        ("return max(enters_z / slope, near), min(leaves_z / slope, far)",
         "return enters_z / slope, min(leaves_z / slope, far)"),
        ("range(ray_count - 1, -1, -1)", "range(ray_count - 1, 0, -1)"),
        ("masks[i + 1, level >> 6] ^=", "masks[i + 1, level >> 6] |="),
    ),
    *_of(
        f"{KERNELS}/ties.py",
        ("AROUND = 1e-6", "AROUND = 1e-12"),
        ("TOGETHER = 1e-10", "TOGETHER = 1e-7"),
        ("place >= 1.0 - TOLERANCE:", "place >= 2.0 - TOLERANCE:"),
        ("return 1 if past > 1.0 - TOLERANCE else 0", "return 0"),
        ("place = before + 1 if change > 0 else before", "place = before if change > 0 else before"),
        ("place = before + 1 if change > 0 else before", "place = before + 1 if change > 0 else before + 1"),
        ("ends = min(abs(fan.near[j] - at), abs(fan.far[j] - at))", "ends = 1.0"),
        ("(side_x != 0 and side_y != 0) or", ""),
        ("there = here + step * _side(place)", "there = here - step * _side(place)"),
        ("before + 1 >= start.columns", "before >= start.columns"),
    ),
    *_of(
        f"{KERNELS}/fan.py",
        ("STRAIGHTEST = 1e-3", "STRAIGHTEST = 1e-5"),
        ("STRAIGHT = 1e-13", "STRAIGHT = 1e-10"),
        ("STEEPEST = 1e3", "STEEPEST = 1e5"),
        ("(past < TOLERANCE) | (past > 1.0 - TOLERANCE)", "(past < 0.0) | (past > 1.0)"),
        ("return s_out - s_in < -TOLERANCE", "return s_out - s_in < TOLERANCE"),
        ("return (np.floor(g) if h > 0.0 else np.ceil(g) - 1.0), True", "return np.floor(g), True"),
        ("passed = np.floor(y)", "passed = np.ceil(y)"),
        ("(column_x > 0.0)) | (past_x > 1.0 - TOLERANCE)", "(column_x > 0.0)) | (past_x > 1.0)"),
        ("|= bit if change > 0 else np.uint64(0)", "|= np.uint64(0)"),
        ("levels ^= work.toggles[part, i]", "levels |= work.toggles[part, i]"),
        ("box[0], box[1] = max(box[0], slabs[worker, 0])", "box[0], box[1] = min(box[0], slabs[worker, 0])"),
        ("for row in fan.steep:", "for row in fan.steep[:0]:"),
    ),
    *_of(
        f"{KERNELS}/planes.py",
        ("if h > 0.0 else (float(high), float(low))", "if h < 0.0 else (float(high), float(low))"),
    ),
    *_of(
        f"{KERNELS}/frustum.py",
        ("BALL = 0.499", "BALL = 0.501"),
        ("SPHERE = 0.8661", "SPHERE = 0.4"),
        ("SLACK = 1e-6", "SLACK = -1e-6"),
        ("if slope > 0.0:\n        return max(low, -value / slope), high", "if slope > 0.0:\n        return low, high"),
        ("_narrow(f.depth_limit - x, -ex, low, high)", "_narrow(f.depth_limit - x, ex, low, high)"),
        ("_narrow(x + room, ex,", "_narrow(x - room, ex,"),
        ("if most < -SLACK:", "if most < 1.0:"),
        ("return low - slant, high + slant", "return low + slant, high - slant"),
        ("f.image[2] - f.image[3] * corners", "f.image[2] + f.image[3] * corners"),
        ("for side in range(4):\n        nx, ny, nz", "for side in range(3):\n        nx, ny, nz"),
    ),
    *_of(
        f"{KERNELS}/settle.py",
        ("count += int(come[w] != gone[w])", "count += int(come[w] > gone[w])"),
        ("seen &= row.keep[w]", "seen &= row.other[w]"),
        ("new[i] &= row.keep[i]", "pass"),
        ("new[w] & ~row.own[w], row.own[w] & ~new[w]", "row.own[w] & ~new[w], new[w] & ~row.own[w]"),
        ("~row.other[w]", "row.other[w]"),
        ("(more_any << np.int64(32))", "(more_any << np.int64(31))"),
        ("own = np.int64(np.int32(tallies[code]))", "own = np.int64(np.uint32(tallies[code] & 0xFFFFFFFF))"),
        ("any_sensor = (tallies[code] - own) >> np.int64(32)", "any_sensor = tallies[code] >> np.int64(32)"),
        ("for slot in slots.leaving:\n", "for slot in slots.staying:\n"),
        ("range(worker, region.rows.size, workers)", "range(worker, region.rows.size - 1, workers)"),
        ("union[1 - kind, start:end]", "union[kind, start:end]"),
    ),
    *_of(
        f"{KERNELS}/cast.py",
        ("- np.uint64(1)]", "- np.uint64(0)]"),
        ("return max(t_in, min(a, b) - blur),", "return max(t_in, max(a, b) - blur),"),
        ("for level in range(runs[r, 1], runs[r, 2] + 1):", "for level in range(runs[r, 1], runs[r, 2]):"),
    ),
    *_of(
        f"{ENGINE}/fans.py",
        ("TAMEST, WILDEST = 2.0**-110", "TAMEST, WILDEST = 2.0**-120"),
        ("np.abs(slopes[order]) <= STEEPEST", "np.abs(slopes[order]) < STEEPEST"),
        ("rotation[2, 2] == 1.0", "abs(rotation[2, 2]) == 1.0"),
        ("rays.rotation[:2, :2].T", "rays.rotation[:2, :2]"),
        ('side="right"', 'side="left"'),
        ("rays.reach[1] * forward", "rays.reach[1]"),
    ),
    *_of(
        f"{ENGINE}/frustums.py",
        ("SHORTEST_DEPTH = 16.0", "SHORTEST_DEPTH = 1.0"),
        ("BALL / (0.5 * float(np.hypot(step_u, step_v)))", "BALL / (0.05 * float(np.hypot(step_u, step_v)))"),
    ),
    *_of(
        f"{ENGINE}/caster.py",
        ("max(cell - 1, 0)", "cell + 1"),
        ("min(cell + 2, (nx, ny)[axis])", "cell"),
        ("min(limit / grid.voxel_m, FARTHEST)", "min(limit, FARTHEST)"),
        ("frustum.depth_limit - 1.0, FARTHEST", "frustum.depth_limit + 1.0, FARTHEST"),
    ),
    *_of(
        f"{ENGINE}/engine.py",
        ("or next((h for h in leaving if h.shape == shape), None)", ""),
        ("if sensor.enabled:", "if True:"),
        ("stack[[held.slot for held in arrived]] = 0", "pass"),
        ("leaving.remove(match)", "pass"),
    ),
    *_of(
        f"{METRIC}/entropy.py",
        ("(counts > 0) & (counts < frames)\n    p", "(counts >= 0) & (counts < frames)\n    p"),
        ("- (1.0 - p) * np.log1p(-p)", "+ (1.0 - p) * np.log1p(-p)"),
        ("(class_counts > 0) & (class_counts < frames)", "(class_counts > 0) & (class_counts <= frames)"),
        ("np.argsort(-uses[:found]", "np.argsort(uses[:found]"),
        ("QUANTA_PER_NAT = 1 << 32", "QUANTA_PER_NAT = 1 << 31"),
    ),
    *_of(
        f"{METRIC}/scoring.py",
        ("nats(total_q - seen_q), nats(hit_q)", "nats(seen_q), nats(hit_q)"),
        ("KindScore(magnitude, _share(seen_q, total_q))", "KindScore(magnitude, _share(total_q, total_q))"),
        ("sums_q[ANY, cls]", "sums_q[0, cls]"),
    ),
    *_of(
        f"{METRIC}/scores.py",
        ("DEFAULT_LAMBDA = 0.1", "DEFAULT_LAMBDA = 0.2"),
        ("return -unseen_nat", "return unseen_nat"),
        ('hits_nat if reading == "hits" else seen_nat', "seen_nat"),
        ("return -magnitude if magnitude else 0.0", "return -magnitude"),
        ("return camera_weight * camera_s_mig + lidar_s_mig", "return camera_s_mig + camera_weight * lidar_s_mig"),
    ),
    *_of(
        f"{METRIC}/estimate.py",
        ("LIDAR_POWER = 0.5", "LIDAR_POWER = 1.0"),
        ("max(seen, camera, lidar)", "seen"),
    ),
]  # fmt: skip
