"""RigLens: how well the LiDARs and cameras of a car cover traffic.

    import riglens as rl

    rig, scene = rl.open_rig("W+T"), rl.load_scene()
    print(rl.score(rig, scene)["car"].seen)

All names come from `riglens.api`, which is loaded with numpy and Numba when the first of them is used. See
docs/scripting.md for examples.

The other modules are `riglens.core`, `riglens.widgets` and `riglens.app`. A wheel holds these folders, and
`riglens.assets`, in this one; in a checkout they are links to the folders beside it.
"""

import sys
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import TYPE_CHECKING


def _find_folders() -> None:
    """Import the folders beside this one where no links lead to them: a checkout on Windows, an unpacked sdist.

    A longer `__path__` would do as well, but make `riglens.tests` and a second `riglens.riglens` importable.
    """
    here = Path(__file__).parent
    for folder in ("app", "assets", "core", "widgets"):
        source = here.parent / folder / "__init__.py"
        if (here / folder).is_dir() or not source.is_file():
            continue
        spec = spec_from_file_location(f"{__name__}.{folder}", source)
        assert spec is not None and spec.loader is not None
        module = sys.modules[spec.name] = globals()[folder] = module_from_spec(spec)
        spec.loader.exec_module(module)


_find_folders()

if TYPE_CHECKING:
    from riglens.api import *  # noqa: F403
    from riglens.api import __all__ as __all__

    __version__: str
else:

    def __getattr__(name: str) -> object:
        """Return a name of `riglens.api`, loaded when it is first asked for (PEP 562)."""
        if name == "__version__":
            from riglens.version import installed_version

            return installed_version()
        is_listed = name == "__all__" or not name.startswith("__")
        api = import_module("riglens.api") if is_listed else None
        if api is None or name not in (*api.__all__, "__all__"):
            raise AttributeError(f"module 'riglens' has no attribute '{name}'")
        return getattr(api, name)

    def __dir__() -> list[str]:
        """Return the names that tab completion shows."""
        return sorted([*globals(), *import_module("riglens.api").__all__, "__all__", "__version__"])
