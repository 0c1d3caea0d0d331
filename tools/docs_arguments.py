"""Show functions of the Python interface on the site with the arguments that editors show: an extension of Griffe."""

from __future__ import annotations

import inspect
from importlib import import_module
from typing import Any

from griffe import Extension, Function, Parameter, ParameterKind


class ShownArguments(Extension):
    """Replaces `**read_as` by the arguments that it stands for."""

    def on_function(self, *, func: Function, **_: Any) -> None:
        """State the arguments of a function that reads boxes."""
        if not any("reads_boxes" in str(one.value) for one in func.decorators):
            return
        shown = inspect.signature(getattr(import_module(func.module.path), func.name)).parameters
        del func.parameters["read_as"]
        for name in [name for name in shown if name not in func.parameters]:
            func.parameters.add(
                Parameter(
                    name,
                    annotation=str(shown[name].annotation),
                    kind=ParameterKind.keyword_only,
                    default=repr(shown[name].default),
                )
            )
