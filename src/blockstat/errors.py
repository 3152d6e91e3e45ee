"""The exception that bad input raises, and checks of options and of single values that raise it."""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Callable, Iterable, Sequence
from functools import wraps
from os import PathLike
from typing import Any, ParamSpec, TypeVar

import numpy as np

from blockstat.typing import Floats

MOST_TOLD = 20  #: errors that one message tells
LISTED = 20  #: names that are listed where one does not exist
HUGE = 1e30  #: no length, density, acceleration or force of a building comes near it
ROUGH = 3.0  #: friction above it is none of stone on stone; the tangent of 70 degrees occurs
ROUGHEST = 1e6  #: the largest coefficient of friction that is finite: cones that are wider lose the digits of forces
NAMELESS = "the name of a file is empty"
TOO_ROUGH = "friction is {!r}; it must be at most 1e6, or inf for no sliding"


class InputError(ValueError):
    """The input cannot be used; the message says what was given, where, and what is allowed.

    Where several things are wrong, `args` has a text for each, and the message a line. The command line prints the
    lines and exits with status 2.
    """

    def __str__(self) -> str:
        return "\n".join(self.told())

    def told(self) -> list[str]:
        """Return the texts of the first errors, and how many more there are.

        Returns
        -------
        list of str
            The lines of the message.
        """
        told = [str(text) for text in self.args[:MOST_TOLD]]
        more = len(self.args) - len(told)
        return [*told, f"and {more:,} more errors"] if more else told

    def under(self, path: str) -> InputError:
        """Return the same error with a path in front of each of its texts.

        Parameters
        ----------
        path : str
            Where the fault is: a file, a key, a block.

        Returns
        -------
        InputError
            Of the same class.

        Examples
        --------
        >>> from blockstat import InputError
        >>> print(InputError("height is 0", "width is 0").under("door"))
        door: height is 0
        door: width is 0
        """
        return type(self)(*(f"{path}: {text}" for text in self.args))

    @property
    def line(self) -> str:
        """The message in one line, as for a cell of a table."""
        return str(self).replace("\n", "; ")


class NoSupportError(InputError):
    """Blocks without a support; the message names some, and whoever asks a person can ask again."""


class InputWarning(UserWarning):
    """The input can be used, but a person should look at it."""


P = ParamSpec("P")
R = TypeVar("R")


def gathered(readings: Iterable[Callable[[], Any]]) -> list[Any]:
    """Return what each of several independent readings gives, or raise one error that tells all of theirs.

    Parameters
    ----------
    readings : iterable of callable
        Without arguments; none depends on what another returns.

    Returns
    -------
    list
        What they return, in their order.

    Raises
    ------
    InputError
        With the texts of all errors that the readings raise, each once.

    Examples
    --------
    >>> gathered([lambda: check_friction(0.5), lambda: check_density("brick", 1800)])
    [0.5, 1800.0]
    >>> gathered([lambda: check_friction(-1), lambda: check_density("brick", 0)])
    Traceback (most recent call last):
    ...
    blockstat.errors.InputError: friction is -1; it must be a number of at least 0 (inf for no sliding)
    block "brick": density is 0; it must be a positive number of kg/m3
    """
    results: list[Any] = []
    texts: dict[str, None] = {}
    kinds: set[type[InputError]] = set()
    for reading in readings:
        try:
            results.append(reading())
        except InputError as error:
            texts |= dict.fromkeys(error.args)
            kinds.add(type(error))
    if texts:
        raise (kinds.pop() if len(kinds) == 1 else InputError)(*texts)
    return results


def known_options(function: Callable[P, R]) -> Callable[P, R]:
    """Make a function refuse unknown keyword arguments, and what is no Assembly where it needs one, with an InputError.

    Parameters
    ----------
    function : callable
        A function, perhaps with keyword-only options and a parameter whose annotation is Assembly. Used as a decorator.

    Returns
    -------
    callable
        The same function, with the same signature.

    Raises
    ------
    InputError
        When the function that is returned is called with an unknown option, or with something else for the assembly.

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
    open_ended = any(found.kind is found.VAR_KEYWORD for found in signature.parameters.values())
    options = [name for name, found in signature.parameters.items() if found.kind is found.KEYWORD_ONLY]
    blocks = [
        (place, name)
        for place, (name, found) in enumerate(signature.parameters.items())
        if found.annotation == "Assembly"
    ]

    @wraps(function)
    def checked(*args: P.args, **kwargs: P.kwargs) -> R:
        if not open_ended and not known.issuperset(kwargs):
            unknown = next(name for name in kwargs if name not in known)
            raise InputError(
                f'{function.__name__}: unknown option "{unknown}"; options are: {", ".join(options) or "none"}'
            )
        for place, name in blocks:
            if place < len(args) or name in kwargs:
                check_assembly(name, args[place] if place < len(args) else kwargs[name])
        return function(*args, **kwargs)

    return checked


def check_assembly(what: str, value: Any) -> None:
    """Raise InputError for anything but an Assembly.

    Parameters
    ----------
    what : str
        What it is; the message begins with it.
    value : object
        What was given.

    Raises
    ------
    InputError
        Saying what makes an Assembly of a scene or of a file.

    Examples
    --------
    >>> check_assembly("assembly", "wall.toml")  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ...
    blockstat.errors.InputError: assembly is a str, 'wall.toml'; it must be an Assembly: blockstat.read ...
    """
    kinds = type(value).__mro__  # by name, because the module of Assembly imports this one
    if any((kind.__module__, kind.__name__) == ("blockstat.assembly", "Assembly") for kind in kinds):
        return
    shown = f", {str(value)!r}" if isinstance(value, (str, PathLike)) else ""
    made = "blockstat.read makes one of a file, blockstat.build of a scene"
    raise InputError(f"{what} is {with_article(type(value).__name__)}{shown}; it must be an Assembly: {made}")


def no_such(what: str, given: Any, existing: Iterable[str]) -> InputError:
    """Return the error for a name that nothing has; raise what it returns.

    Parameters
    ----------
    what : str
        What was looked for, in the singular: "group".
    given : object
        The name that was given.
    existing : iterable of str
        The names that exist.

    Returns
    -------
    InputError
        The error, with the names in its message.

    Examples
    --------
    >>> str(no_such("group", "wal", ["ground", "wall"]))
    'no group "wal"; groups are: ground, wall'
    """
    return InputError(f'no {what} "{given}"; {what}s are: {some(list(existing), LISTED) or "none"}')


def some(names: Sequence[Any], limit: int = 8) -> str:
    """Return the first of some names or numbers, and how many there are.

    Parameters
    ----------
    names : sequence
        The names or numbers.
    limit : int, optional
        At most so many are listed.

    Returns
    -------
    str

    Examples
    --------
    >>> some(range(30), 4)
    '0, 1, 2, 3, ... (30 in all)'
    """
    return ", ".join(map(str, names[:limit])) + (f", ... ({len(names)} in all)" if len(names) > limit else "")


def with_article(word: str) -> str:
    """Return a word with its indefinite article.

    Parameters
    ----------
    word : str
        Such as "elliptic".

    Returns
    -------
    str

    Examples
    --------
    >>> with_article("elliptic"), with_article("flat")
    ('an elliptic', 'a flat')
    """
    return f"{'an' if word[:1] in set('aeiou') else 'a'} {word}"


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
    if not is_number(value) or not 0 < value < HUGE:
        raise InputError(f'block "{label}": density is {value!r}; it must be a positive number of kg/m3')
    return float(value)


def is_number(value: Any) -> bool:
    """Return whether a value is a number, which True and False are not.

    Parameters
    ----------
    value : object
        What was given.

    Returns
    -------
    bool

    Examples
    --------
    >>> is_number(1), is_number(True), is_number("1")
    (True, False, False)
    """
    return isinstance(value, (int, float, np.number)) and not isinstance(value, bool)


def check_friction(value: Any, *, doubted: bool = False) -> float:
    """Return a coefficient of friction as a number.

    Parameters
    ----------
    value : object
        What was given; infinite for no sliding.
    doubted : bool, optional
        Whether to warn of one that may be an angle.

    Returns
    -------
    float
        The coefficient.

    Raises
    ------
    InputError
        For anything but a number of at least 0, and for finite ones above 1e6.

    Warns
    -----
    InputWarning
        See `doubted`.

    Examples
    --------
    >>> check_friction(-0.5)
    Traceback (most recent call last):
    ...
    blockstat.errors.InputError: friction is -0.5; it must be a number of at least 0 (inf for no sliding)
    """
    if not is_number(value) or not value >= 0:
        raise InputError(f"friction is {value!r}; it must be a number of at least 0 (inf for no sliding)")
    if ROUGHEST < value < np.inf:
        raise InputError(TOO_ROUGH.format(value))
    if doubted and (doubt := rough("friction", float(value))) is not None:
        warnings.warn(InputWarning(doubt), stacklevel=4)
    return float(value)


def rough(what: str, friction: float) -> str | None:
    """Return what is odd about a coefficient of friction that may be an angle.

    Parameters
    ----------
    what : str
        What it is; the sentence begins with it.
    friction : float
        The coefficient.

    Returns
    -------
    str or None
        None for one that stones may have, and for one without limit.

    Examples
    --------
    >>> rough("friction", 35)
    'friction is 35; it is the tangent of an angle: 35 degrees are 0.7'
    """
    if not ROUGH < friction < np.inf:
        return None
    angle = f": {friction:g} degrees are {np.tan(np.radians(friction)):.3g}" if friction < 90 else ""
    return f"{what} is {friction:g}; it is the tangent of an angle{angle}"


def check_positive(what: str, value: Any, *, least: float = 0.0) -> None:
    """Raise InputError unless a value is a finite number above 0, or of at least another bound.

    Parameters
    ----------
    what : str
        What it is; the message begins with it.
    value : object
        What was given.
    least : float, optional
        The bound; 0 is not allowed itself.

    Raises
    ------
    InputError
        For anything else.
    """
    if is_number(value) and value >= least and 0 < value < np.inf:
        return
    bound = f"at least {least:g}" if least else "above 0"
    finite = " and finite" if isinstance(value, (float, np.floating)) and not np.isfinite(value) else ""
    raise InputError(f"{what} is {value!r}; it must be {bound}{finite}")


def check_number(what: str, value: Any, *, least: float = -np.inf, most: float = np.inf) -> None:
    """Raise InputError unless a value is a finite number between two bounds.

    Parameters
    ----------
    what : str
        What it is; the message begins with it.
    value : object
        What was given.
    least, most : float, optional
        The bounds, allowed themselves.

    Raises
    ------
    InputError
        For anything else.

    Examples
    --------
    >>> check_number("settlement: start", -1.0, least=0)
    Traceback (most recent call last):
    ...
    blockstat.errors.InputError: settlement: start is -1.0; it must be a number of at least 0
    """
    if is_number(value) and np.isfinite(value) and least <= value <= most:
        return
    if np.isfinite(least) and np.isfinite(most):
        raise InputError(f"{what} is {value!r}; it must be from {least:g} to {most:g}")
    allowed = f" of at least {least:g}" if np.isfinite(least) else f" of at most {most:g}" if np.isfinite(most) else ""
    raise InputError(f"{what} is {value!r}; it must be a {'' if allowed else 'finite '}number{allowed}")


def check_count(what: str, value: Any, *, least: int = 1) -> None:
    """Raise InputError unless a value is a whole number of at least a bound.

    Parameters
    ----------
    what : str
        What it is; the message begins with it.
    value : object
        What was given.
    least : int, optional
        The bound.

    Raises
    ------
    InputError
        For anything else.

    Examples
    --------
    >>> check_count("batch", 0)
    Traceback (most recent call last):
    ...
    blockstat.errors.InputError: batch is 0; it must be a whole number of at least 1
    """
    if not isinstance(value, (int, np.integer)) or isinstance(value, bool) or value < least:
        raise InputError(f"{what} is {value!r}; it must be a whole number of at least {least}")


def check_names(what: str, given: Any) -> tuple[str, ...]:
    """Return names as a tuple of text.

    Parameters
    ----------
    what : str
        What they are; the message begins with it.
    given : object
        What was given.

    Returns
    -------
    tuple of str
        The names.

    Raises
    ------
    InputError
        For one name where several stand.
    """
    if isinstance(given, str):
        raise InputError(f"{what} is {given!r}; it must be a list of names")
    return tuple(str(name) for name in given)


def check_seed(value: Any) -> None:
    """Raise InputError unless random numbers can be drawn from a seed.

    Parameters
    ----------
    value : object
        What was given.

    Raises
    ------
    InputError
        For anything but a whole number of at least 0.
    """
    check_count("seed", value, least=0)


def check_seconds(value: Any) -> None:
    """Raise InputError unless a search can be given so much time.

    Parameters
    ----------
    value : object
        What was given [s]; None for no limit.

    Raises
    ------
    InputError
        For anything but a number of at least 0.
    """
    if value is not None and not (isinstance(value, (int, float)) and value >= 0):
        raise InputError(f"seconds is {value!r}; it must be a number of at least 0")


def check_vector(what: str, value: Any, *, zero: bool = False) -> Floats:
    """Return a direction, a displacement or a point as an array.

    Parameters
    ----------
    what : str
        What it is; the message of an error begins with it.
    value : object
        What was given, three numbers.
    zero : bool, optional
        All may be zero, as those of a point.

    Returns
    -------
    array of float, shape (3,)
        The vector.

    Raises
    ------
    InputError
        For anything but three numbers of a usable size, not all zero where that is not allowed.

    Examples
    --------
    >>> check_vector("direction", [0, 0, 0])
    Traceback (most recent call last):
    ...
    blockstat.errors.InputError: direction is [0, 0, 0]; it must be three numbers, not all zero
    """
    try:
        vector = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        vector = np.empty(0)
    least = -1.0 if zero else 1 / HUGE
    if vector.shape != (3,) or not least < np.abs(vector).max() < HUGE:
        allowed = "three finite numbers" if zero else "three numbers, not all zero"
        raise InputError(f"{what} is {value!r}; it must be {allowed}")
    return vector


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
