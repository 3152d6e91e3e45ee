"""The exception that bad input raises, and checks of options and of single values that raise it."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable
from functools import wraps
from typing import Any, ParamSpec, TypeVar

import numpy as np

from blockstat.typing import Floats

HUGE = 1e30  #: no length, density or acceleration of a building comes near it


class InputError(ValueError):
    """The input cannot be used; the message says what was given, where, and what is allowed.

    The command line prints the message on one line and exits with status 2.
    """


class NoSupportError(InputError):
    """Blocks without a support; the message names some, and whoever asks a person can ask again."""


class InputWarning(UserWarning):
    """The input can be used, but a person should look at it."""


P = ParamSpec("P")
R = TypeVar("R")


def known_options(function: Callable[P, R]) -> Callable[P, R]:
    """Make a function refuse unknown keyword arguments with an InputError that names the known ones.

    Parameters
    ----------
    function : callable
        A function with keyword-only options. Used as a decorator.

    Returns
    -------
    callable
        The same function, with the same signature.

    Raises
    ------
    InputError
        When the function that is returned is called with an unknown option.

    Examples
    --------
    >>> @known_options
    ... def span(length, *, unit="m"):
    ...     return f"{length} {unit}"
    >>> span(3, units="ft")
    Traceback (most recent call last):
    ...
    blockstat.errors.InputError: span: unknown option "units"; options are: unit
    """
    signature = inspect.signature(function)
    known = set(signature.parameters)
    options = [name for name, found in signature.parameters.items() if found.kind is found.KEYWORD_ONLY]

    @wraps(function)
    def checked(*args: P.args, **kwargs: P.kwargs) -> R:
        if not known.issuperset(kwargs):
            unknown = next(name for name in kwargs if name not in known)
            raise InputError(
                f'{function.__name__}: unknown option "{unknown}"; options are: {", ".join(options) or "none"}'
            )
        return function(*args, **kwargs)

    return checked


def no_such(what: str, given: Any, existing: Iterable[str], *, plural: str = "", limit: int = 20) -> InputError:
    """Return the error for a name that nothing has; raise what it returns.

    Parameters
    ----------
    what : str
        What was looked for, in the singular: "group".
    given : object
        The name that was given.
    existing : iterable of str
        The names that exist.
    plural : str, optional
        The plural of `what` where it is not `what` with an s.
    limit : int, optional
        At most so many names are listed.

    Returns
    -------
    InputError
        The error, with the names in its message.

    Examples
    --------
    >>> str(no_such("group", "wal", ["ground", "wall"]))
    'no group "wal"; groups are: ground, wall'
    """
    names = list(existing)
    listed = ", ".join(names[:limit]) + (f", ... ({len(names)} in all)" if len(names) > limit else "")
    return InputError(f'no {what} "{given}"; {plural or what + "s"} are: {listed or "none"}')


def check_choice(option: str, given: Any, choices: Iterable[str]) -> None:
    """Raise InputError unless the value of an option is one of its choices.

    Parameters
    ----------
    option : str
        The name of the option.
    given : object
        The value.
    choices : iterable of str
        The values that the option may have.

    Raises
    ------
    InputError
        For any other value.

    Examples
    --------
    >>> check_choice("flow", "plastic", ["associated", "coulomb"])
    Traceback (most recent call last):
    ...
    blockstat.errors.InputError: flow is 'plastic'; it must be one of: associated, coulomb
    """
    choices = list(choices)
    if given not in choices:
        raise InputError(f"{option} is {given!r}; it must be one of: {', '.join(choices)}")


def check_density(label: str, value: Any) -> float:
    """Return the density of a block as a number.

    Parameters
    ----------
    label : str
        The name of the block.
    value : object
        What was given [kg/m3].

    Returns
    -------
    float
        The density [kg/m3].

    Raises
    ------
    InputError
        For anything but a positive number.

    Examples
    --------
    >>> check_density("brick", 1800)
    1800.0
    """
    number = isinstance(value, (int, float, np.number)) and not isinstance(value, bool)
    if not number or not 0 < value < HUGE:
        raise InputError(f'block "{label}": density is {value!r}; it must be a positive number of kg/m3')
    return float(value)


def check_friction(value: Any) -> float:
    """Return a coefficient of friction as a number.

    Parameters
    ----------
    value : object
        What was given; infinite for no sliding.

    Returns
    -------
    float
        The coefficient.

    Raises
    ------
    InputError
        For anything but a number of at least 0.

    Examples
    --------
    >>> check_friction(-0.5)
    Traceback (most recent call last):
    ...
    blockstat.errors.InputError: friction is -0.5; it must be a number of at least 0 (inf for no sliding)
    """
    if not isinstance(value, (int, float, np.number)) or isinstance(value, bool) or not value >= 0:
        raise InputError(f"friction is {value!r}; it must be a number of at least 0 (inf for no sliding)")
    return float(value)


def check_gravity(value: Any) -> Floats:
    """Return a gravity vector as an array.

    Parameters
    ----------
    value : object
        What was given, three numbers [m/s2].

    Returns
    -------
    array of float, shape (3,)
        The vector [m/s2].

    Raises
    ------
    InputError
        For anything but three numbers of a usable size, not all zero.

    Examples
    --------
    >>> check_gravity([0, 0, -10]).tolist()
    [0.0, 0.0, -10.0]
    """
    try:
        gravity = np.array(value, dtype=float)
    except (TypeError, ValueError):
        gravity = np.array([np.nan])
    if gravity.shape != (3,) or not 1 / HUGE < np.linalg.norm(gravity) < HUGE:
        raise InputError(f"gravity is {value!r}; it must be three numbers gx, gy, gz in m/s2, not all zero")
    return gravity
