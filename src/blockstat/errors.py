"""The one exception that bad input raises."""


class InputError(ValueError):
    """The input cannot be used; the message says what was given, where, and what is allowed.

    The command line prints the message on one line and exits with status 2.
    """


class InputWarning(UserWarning):
    """The input can be used, but a person should look at it."""
