"""Answers with one number wrong, which a second opinion has to notice."""

from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np

from blockstat import Assembly, Interfaces

#: Of each array or tuple, so many places are tried.
PLACES = 10
#: Of the largest number of an array, below which a number may be rounding.
TINY = 0.05


def damaged(found: Any, by: float, *, but: tuple[str, ...] = (), places: int = PLACES) -> Iterator[tuple[str, Any]]:
    """The answer with one number larger or smaller: each value, and of each array those that are not tiny.

    What an answer is made of is damaged too, but not its blocks and joints, which are what it is about; `but` are the
    names of other fields to leave alone. Of a list of numbers of blocks or joints the last is missing.
    """
    random = np.random.default_rng(5)
    for field in fields(found):
        if field.name not in but:
            for where, wrong in _wrong(getattr(found, field.name), by, but, places, random):
                yield f"{field.name}{where}", replace(found, **{field.name: wrong})


def _wrong(value: Any, by: float, but: tuple[str, ...], places: int, random: np.random.Generator) -> Iterator[Any]:
    """Where a value is wrong, and the value."""
    if isinstance(value, float):
        if value and np.isfinite(value):
            yield from ((f" {sign:+g}", value * (1 + sign * by)) for sign in (1, -1))
    elif isinstance(value, np.ndarray) and value.dtype == float:
        large = np.argwhere(np.isfinite(value) & (np.abs(value) > TINY * np.abs(value).max(initial=0.0)))
        for place in random.permutation(large)[:places]:
            for sign in (1, -1):
                wrong = value.copy()
                wrong[tuple(place)] *= 1 + sign * by
                yield f"{place.tolist()} {sign:+g}", wrong
    elif isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype.kind == "i":
        if len(value):
            yield " without the last", value[:-1]
    elif isinstance(value, tuple):
        for place in sorted(random.permutation(len(value))[:places].tolist()):
            for where, wrong in _wrong(value[place], by, but, places, random):
                changed = (*value[:place], wrong, *value[place + 1 :])
                yield f"[{place}]{where}", type(value)(*changed) if hasattr(value, "_fields") else changed
    elif is_dataclass(value) and not isinstance(value, (Assembly, Interfaces, type)):
        yield from ((f".{where}", wrong) for where, wrong in damaged(value, by, but=but, places=places))


def believed(check: Callable[[Any], None], answer: Any) -> bool:
    """Whether an answer passes its check."""
    try:
        check(answer)
    except AssertionError:
        return False
    return True


def assert_noticed(found: Any, check: Callable[[Any], None], by: float = 1e-3, **options: Any) -> None:
    """The answer passes its check, and with any number wrong it does not."""
    check(found)
    wrong = list(damaged(found, by, **options))
    assert len(wrong) > 1
    missed = [name for name, answer in wrong if believed(check, answer)]
    assert not missed, f"not noticed: {', '.join(missed)}"
