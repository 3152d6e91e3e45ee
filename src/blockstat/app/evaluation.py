"""What workers do for the page: evaluate design after design, and the slower results of one design."""

from __future__ import annotations

from dataclasses import replace
from math import isnan, nan
from time import process_time

from blockstat.analysis.assess import assess
from blockstat.analysis.certificate_cache import Memory
from blockstat.analysis.limit_load import limit_load
from blockstat.analysis.tilt_friction.bracket import BracketOutcome
from blockstat.analysis.tilt_friction.friction import friction_limit
from blockstat.analysis.verdict import Verdict
from blockstat.app.background import Channel
from blockstat.app.design import EDGES, PUSHES, Began, Failed, Judged, Pushed, Question, Scored, Slipped
from blockstat.assembly import Assembly
from blockstat.contact.interfaces import Interfaces
from blockstat.errors import InputError
from blockstat.imperfection.imperfections import Imperfections

#: The least friction is found this closely: a bisection to the last digit would take twice as long.
NEAR = 2e-3


def evaluate_designs(channel: Channel) -> None:
    """Evaluate the newest question, again and again, until the page closes the channel.

    Evidence of earlier designs is kept between questions.

    Parameters
    ----------
    channel : Channel
        Questions come through it. Each is answered by `Began`, then by `Judged` or `Failed`.
    """
    memory = Memory()
    while True:
        question = channel.receive()
        channel.send(Began(question.number))
        channel.send(evaluated(question, memory))


def evaluated(question: Question, memory: Memory) -> Judged | Failed:
    """Return the static verdict on a question, or why there is none.

    Parameters
    ----------
    question : Question
        The design.
    memory : Memory
        Evidence of earlier designs; that of this one is added.

    Returns
    -------
    Judged or Failed
        The answer. Bad input and a fault of the program both give `Failed`.

    Raises
    ------
    MemoryError
        For a design that needs more memory than the process may use.
    """
    begin = process_time()
    try:
        assembly = question.model.built(question.values)
        built = process_time()
        worst = rounded(question.values)
        # Evidence of sharp edges is none of rounded ones. The score of a design that falls follows later.
        near = question.model.gap
        verdict = assess(assembly, gap=near, score=False, imperfections=worst, memory=None if worst else memory)
    except InputError as error:
        return Failed(question.number, str(error))
    except MemoryError:
        raise  # the worker says what it may use
    except Exception as error:
        return Failed(question.number, f"internal error ({type(error).__name__}: {error})", is_internal=True)
    now = process_time()
    seconds = {"build": built - begin, **verdict.timings}
    seconds["total"] = now - begin
    return Judged(question.number, verdict, seconds)


def rounded(values: dict[str, float]) -> Imperfections | None:
    """Return what joints lose at their edges, as the page has it.

    Parameters
    ----------
    values : dict of str to float
        Values of the page by dotted path; that of "rounded_edges" is in millimetres.

    Returns
    -------
    Imperfections or None
        None for sharp edges.
    """
    lost = 1e-3 * values.get(EDGES, 0.0)
    return Imperfections(edge=lost) if lost else None


def slower_results(channel: Channel, number: int, verdict: Verdict) -> None:
    """Send the limit loads and the least friction of a design that was evaluated, each as it comes.

    The verdict with its score comes before them, where an earlier mechanism had decided and left the score open.

    Parameters
    ----------
    channel : Channel
        `Scored` (only for an open score), a `Pushed` for each of `PUSHES`, and `Slipped` are sent through it.
    number : int
        Number of the question.
    verdict : Verdict
        The static verdict on the design.
    """
    assembly, interfaces = verdict.assembly, verdict.interfaces
    if isnan(verdict.score):
        scored = assess(assembly, interfaces=interfaces, gap=interfaces.searched)
        channel.send(Scored(number, replace(scored, worst=verdict.worst)))
    for push in PUSHES:
        channel.send(_pushed(number, assembly, interfaces, push))
    begin, least, reason = process_time(), nan, ""
    try:
        found = friction_limit(assembly, width=NEAR, interfaces=interfaces, gap=interfaces.searched)
        least = found.value
        if found.outcome is BracketOutcome.UNDECIDED:
            reason = found.outcome.value
    except InputError as error:
        reason = str(error)
    channel.send(Slipped(number, least, process_time() - begin, reason))


def _pushed(number: int, assembly: Assembly, interfaces: Interfaces, push: str) -> Pushed:
    begin = process_time()
    try:
        limit = limit_load(assembly, PUSHES[push], interfaces=interfaces, gap=interfaces.searched)
    except InputError as error:
        return Pushed(number, push, None, str(error), process_time() - begin)
    return Pushed(number, push, limit, "", process_time() - begin)
