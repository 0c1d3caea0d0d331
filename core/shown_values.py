"""Format entropies and shares, in the terminal and in pictures."""

from __future__ import annotations

import math

NONE = "—"
"""Cell of a figure that there is none of."""
SIGNIFICANT_DIGITS = 5


def decimals(largest_nat: float) -> int:
    """Return the decimals in 10³ nat that show about five significant digits of the largest figure."""
    if largest_nat <= 0.0:
        return 1
    return min(8, max(1, SIGNIFICANT_DIGITS - 1 - math.floor(math.log10(largest_nat / 1e3))))


def thousands(value_nat: float, digits: int) -> str:
    """Return nats as 10³ nat, with a true minus sign; a zero has none."""
    text = f"{value_nat / 1e3:,.{digits}f}"
    return text.replace("-", "" if float(text.replace(",", "")) == 0.0 else "\u2212")


def percent(share: float) -> str:
    """Return a fraction as percent with two decimals."""
    return f"{100.0 * share:.2f} %"
