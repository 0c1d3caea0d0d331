"""Errors with a meaning of their own: wrong input, and work that was given up."""


class InputError(ValueError):
    """Bad input or usage; the message is one line with file, field, what was found and what is accepted."""


class Cancelled(Exception):
    """Raised by work that was given up, and by the callbacks that give it up."""
