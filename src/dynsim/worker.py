"""A process that does tasks for `dynsim.pool`: pickles in on standard input, pickles out on standard output.

A process of its own, not a fork and not a re-import of the caller's script: nothing the caller did can reach a run,
and nothing a run does can reach the caller.
"""

from __future__ import annotations

import os
import pickle
import sys

from blockstat.errors import InputError


def main() -> None:
    """Do tasks (function, argument) until the input ends; each answer is (result, what went wrong or "")."""
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
            pickle.dump((None, f"a process of its own cannot import the task ({error})"), answers)
            answers.flush()
            return
        try:
            answer = (function(argument), "")
        except InputError as error:
            answer = (None, str(error))
        except MemoryError:
            answer = (None, "not enough memory")
        except Exception as error:
            answer = (None, f"internal error ({type(error).__name__}: {error})")
        pickle.dump(answer, answers, protocol=pickle.HIGHEST_PROTOCOL)
        answers.flush()


if __name__ == "__main__":
    main()
