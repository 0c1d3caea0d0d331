"""RigLens: how well the LiDARs and cameras of a car cover traffic.

    import riglens as rl

    rig, scene = rl.open_rig("W+T"), rl.load_scene()
    print(rl.score(rig, scene)["car"].seen)

The names below come from `riglens.api`, which is loaded with numpy and Numba when one of them is first used. See
docs/scripting.md for examples.

The other modules are `riglens.core`, `riglens.widgets` and `riglens.app`. A wheel holds these folders, and
`riglens.assets`, in this one; in a checkout they are links to the folders beside it.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from riglens.api import (
        AuditResult,
        Camera,
        ClassResult,
        EvenAngles,
        InputError,
        Lidar,
        OptimiseResult,
        Pose,
        Rig,
        RigLensWarning,
        RigResult,
        Scene,
        SceneEngine,
        TargetResult,
        Traffic,
        Vehicle,
        audit,
        convert,
        load_scene,
        load_traffic,
        open_rig,
        optimise,
        presets,
        render,
        save_rig,
        score,
        targets,
    )

    __version__: str

__all__ = [
    "AuditResult",
    "Camera",
    "ClassResult",
    "EvenAngles",
    "InputError",
    "Lidar",
    "OptimiseResult",
    "Pose",
    "Rig",
    "RigLensWarning",
    "RigResult",
    "Scene",
    "SceneEngine",
    "TargetResult",
    "Traffic",
    "Vehicle",
    "__version__",
    "audit",
    "convert",
    "load_scene",
    "load_traffic",
    "open_rig",
    "optimise",
    "presets",
    "render",
    "save_rig",
    "score",
    "targets",
]


def __getattr__(name: str) -> object:
    """Return a name of `__all__`, loaded on first use (PEP 562)."""
    if name == "__version__":
        from riglens.version import installed_version

        return installed_version()
    if name not in __all__:
        raise AttributeError(f"module 'riglens' has no attribute '{name}'")
    from riglens import api

    return getattr(api, name)


def __dir__() -> list[str]:
    """Return the names for tab completion."""
    return sorted([*globals(), *__all__])
