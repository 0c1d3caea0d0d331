"""What every part of a rig has in common: immutable, strictly checked, fields named as in the YAML file."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, Field

Finite = Annotated[float, Field(allow_inf_nan=False)]


class Frozen(BaseModel):
    """Immutable, strict, no unknown keys; fields are addressed by the names of the YAML file."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, populate_by_name=True)

    def replace(self, **changes: object) -> Self:
        """Return a validated copy with some fields changed; raise pydantic's ValidationError where one does not fit."""
        fields = {name: getattr(self, name) for name in type(self).model_fields}
        return type(self)(**(fields | changes))
