"""Tooltips with text from files: shown as it is written, never read as HTML, and wrapped."""

from __future__ import annotations

from html import escape


def plain_tip(text: str) -> str:
    """A tooltip that shows this text with its line ends."""
    return f"<p style='white-space: pre-wrap'>{escape(text)}</p>" if text else ""
