"""A process that does tasks for `dynsim.parallel.pool`: pickles in on standard input, pickles out on standard output.

A process of its own, not a fork and not a re-import of the caller's script: nothing the caller did can reach a run,
and nothing a run does can reach the caller.
"""

from __future__ import annotations

import os
import pickle
import sys
import warnings
from collections.abc import Callable
from typing import Any

from blockstat.errors import InputError, InputWarning
from blockstat.system.process import end_with_parent


def main() -> None:
    """Do tasks (function, argument) until the input ends; each answer is (result, what went wrong or "", warnings)."""
    end_with_parent()
    source = sys.stdin.buffer
    # What libraries print must not get between the answers.
    answers = os.fdopen(os.dup(1), "wb")
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    while True:
        try:
            function, argument = pickle.load(source)
        except EOFError:
            return
        except Exception as error:
            # What follows in the stream has no known beginning.
            pickle.dump((None, f"a process of its own cannot import the task ({error})", ()), answers)
            answers.flush()
            return
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("default", InputWarning)
            answer = _answer(function, argument)
        told = tuple(str(w.message) for w in caught if issubclass(w.category, InputWarning))
        answer = (*answer, told)
        pickle.dump(answer, answers, protocol=pickle.HIGHEST_PROTOCOL)
        answers.flush()


def _answer(function: Callable[[Any], Any], argument: Any) -> tuple[Any, str]:
    try:
        return function(argument), ""
    except InputError as error:
        return None, error.line
    except MemoryError:
        return None, "not enough memory"
    except Exception as error:
        return None, f"internal error ({type(error).__name__}: {error})"


if __name__ == "__main__":
    main()
