"""Requests about one rig, answered with serial kernels: detection range, mounts, test objects."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, TypeVar

from riglens.app.background.worker import Context
from riglens.core.metric.scores import Body
from riglens.core.rig.model import Rig
from riglens.core.targets.detection_range import DetectionRange, RangePlan

if TYPE_CHECKING:  # loads the compiler, which a window that opens does not need
    from riglens.core.review.mounts import MountLimits, Violation
    from riglens.core.review.verdicts import ProfileVerdict

Options = TypeVar("Options")


@dataclass(frozen=True)
class RigRequest(Generic[Options]):
    """A rig and options of the question."""

    rig: Rig
    options: Options


def detection_range(request: RigRequest[RangePlan], context: Context[DetectionRange]) -> DetectionRange:
    """Return the detection range of a rig."""
    from riglens.core.targets.detection_range_making import detection_range_of

    return detection_range_of(request.rig, request.options, threads=1, progress=context.report)


def object_verdicts(
    request: RigRequest[Body], context: Context[tuple[ProfileVerdict, ...]]
) -> tuple[ProfileVerdict, ...]:
    """Return which objects of every bundled profile a rig sees, its body in the way or not."""
    from riglens.core.review.profiles import bundled_profiles
    from riglens.core.review.verdicts import ObjectVisibility, ProfileVerdict

    profiles, found = bundled_profiles(), list[ProfileVerdict]()
    context.progress(0.0)
    visibility = ObjectVisibility(request.rig, request.options)
    for number, profile in enumerate(profiles, 1):
        context.stop_if_closing()
        found.append(visibility.verdict(profile))
        context.progress(number / len(profiles))
    return tuple(found)


def mount_violations(
    request: RigRequest[MountLimits | None], context: Context[tuple[Violation, ...]]
) -> tuple[Violation, ...]:
    """Return the violations of the request's limits, or of the usual ones."""
    from riglens.core.review.mounts import USUAL_LIMITS, violations

    return violations(request.rig, request.options or USUAL_LIMITS)
