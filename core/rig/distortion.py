"""Coefficients of lens distortion, named as OpenCV names them; the mathematics is in `riglens.core.sensing.lens`."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from riglens.core.rig.frozen import Frozen

Coefficient = Annotated[float, Field(allow_inf_nan=False, ge=-1e9, le=1e9)]


class BrownConrady(Frozen):
    """Radial and tangential distortion; with k4, k5 or k6 the rational model (OpenCV, calib3d).

    r' / r = (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6), r on the plane at distance 1.
    """

    model: Literal["brown_conrady"] = "brown_conrady"
    k1: Coefficient = 0.0
    k2: Coefficient = 0.0
    p1: Coefficient = 0.0
    p2: Coefficient = 0.0
    k3: Coefficient = 0.0
    k4: Coefficient = 0.0
    k5: Coefficient = 0.0
    k6: Coefficient = 0.0


class KannalaBrandt(Frozen):
    """Fisheye: theta' = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8) (OpenCV, fisheye)."""

    model: Literal["kannala_brandt"] = "kannala_brandt"
    k1: Coefficient = 0.0
    k2: Coefficient = 0.0
    k3: Coefficient = 0.0
    k4: Coefficient = 0.0


Distortion = Annotated[BrownConrady | KannalaBrandt, Field(discriminator="model")]
COEFFICIENTS = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")
"""Every coefficient of any model; each is 0 when it is not given."""
