"""The one error that means "the input is wrong": a single line for the user, without a traceback."""


class InputError(ValueError):
    """Bad input or usage; the message is one line with file, field, what was found and what is accepted."""
