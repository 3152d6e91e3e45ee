"""The joints that statics found, handed on to a verifier that would search for them again."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import TypeVar
from weakref import WeakKeyDictionary

from blockstat.analysis.verdict import Verdict
from blockstat.assembly import Assembly
from blockstat.contact.interfaces import Interfaces

T = TypeVar("T")


class SharedJoints:
    """The interfaces of the designs of one search, for as long as the designs are kept."""

    def __init__(self) -> None:
        self._found: WeakKeyDictionary[Assembly, Interfaces] = WeakKeyDictionary()

    def kept(self, static: Callable[[Assembly], Verdict]) -> Callable[[Assembly], Verdict]:
        """Return a function that also keeps the interfaces of its verdicts.

        Parameters
        ----------
        static : callable
            Gives the static verdict on an assembly.

        Returns
        -------
        callable
            The same function of an assembly.
        """

        def keeping(assembly: Assembly) -> Verdict:
            verdict = static(assembly)
            found = getattr(verdict, "interfaces", None)
            # Those that are divided into cells for a joint law are not what a search finds.
            if found is not None and found.share is None:
                self._found[assembly] = found
            return verdict

        return keeping

    def handed(self, function: Callable[..., T]) -> Callable[[Assembly], T]:
        """Return a function of an assembly that is handed the interfaces, if it has an option for them.

        Parameters
        ----------
        function : callable
            A function of an assembly, with or without an option `interfaces`.

        Returns
        -------
        callable
            A function of an assembly alone.
        """
        if "interfaces" not in inspect.signature(function).parameters:
            return function
        return lambda assembly: function(assembly, interfaces=self._found.get(assembly))
