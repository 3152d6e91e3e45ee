"""Keep an evaluator busy with the newest question, and a second worker with the slower results of its answer."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic
from typing import TYPE_CHECKING, Any

from blockstat.app.background import Crashed, Ended, Limits, Worker
from blockstat.app.design import Began, Failed, Judged, Model, Question, Stopped
from blockstat.app.evaluation import evaluate_designs, slower_results

if TYPE_CHECKING:
    from blockstat.analysis.verdict import Verdict

#: An evaluator that still works on an older design this long after a newer one was asked for is replaced [s].
PATIENCE = 2.0
#: The slower results are asked for once nothing has moved for so long [s].
QUIET = 0.25


class Follower:
    """Two workers that follow the newest question.

    Older questions are dropped unanswered, or left unfinished when they take too long. All methods are called in the
    page's own thread.

    Parameters
    ----------
    post : callable
        Puts a call without arguments into the page's queue; called from any thread.
    tell : callable
        Called in the page's thread with each message that is not out of date.
    limits : Limits, optional
        What a verdict and its slower results may use. An evaluator beyond them is ended, and the question fails.
    """

    def __init__(
        self,
        post: Callable[[Callable[[], None]], None],
        tell: Callable[[Any], None],
        *,
        limits: Limits | None = None,
    ) -> None:
        self._post, self._tell, self._limits = post, tell, limits or Limits()
        self._begun_at = 0.0
        self._evaluator: Worker | None = None
        self._slower: Worker | None = None
        self._question: Question | None = None
        self._began, self._answered = 0, 0
        self._overdue: float | None = None  # since when a question newer than the one begun waits
        self._due: tuple[float, Verdict] | None = None  # when the slower results are to be asked for

    @property
    def pending(self) -> bool:
        """Whether the newest question is still open."""
        return self._question is not None and self._answered < self._question.number

    def ask(self, model: Model, values: dict[str, float]) -> int:
        """Ask for the verdict on a design.

        Parameters
        ----------
        model : Model
            The scene or the assembly.
        values : dict of str to float
            Values of its parameters, by dotted path.

        Returns
        -------
        int
            Number of the question.
        """
        number = self._question.number + 1 if self._question is not None else 1
        self._question = Question(number, model, dict(values))
        self._due = None
        self._stop_slower()
        if self._overdue is None:
            self._overdue = monotonic()
        if self._evaluator is None or not self._evaluator.running:
            self._evaluator = self._new_evaluator()
        self._evaluator.send(self._question)
        return number

    def tick(self) -> None:
        """Replace an evaluator that still works on an old question, and start the slower results when it is quiet."""
        now = monotonic()
        stuck = self._overdue is not None and now - self._overdue > PATIENCE
        if stuck and self._question is not None and self._answered < self._began < self._question.number:
            if self._evaluator is not None:
                self._evaluator.stop()
            self._restart()
        if self._answered < self._began and now - self._begun_at > self._limits.seconds:
            self._give_up()
        if self._due is not None and now >= self._due[0] and self._question is not None:
            verdict, self._due = self._due[1], None
            self._slower = Worker(
                slower_results, self._question.number, verdict, report=self._reported, limits=self._limits, timed=True
            )

    def stop(self) -> None:
        """End both workers."""
        self._stop_slower()
        if self._evaluator is not None:
            self._evaluator.stop()

    def _new_evaluator(self) -> Worker:
        return Worker(evaluate_designs, report=self._reported, limits=self._limits)

    def _give_up(self) -> None:
        """End an evaluator that took too long over a question; an answer of it on its way is dropped."""
        if self._evaluator is not None:
            self._evaluator.stop()
            self._evaluator = None
        self._fail(self._began, self._limits.too_long)

    def _fail(self, number: int, reason: str, is_internal: bool = False) -> None:
        """Tell that a question has no answer, and hand a newer one to a new evaluator."""
        self._answered = number
        self._tell(Failed(number, f"this design cannot be judged here: {reason}", is_internal))
        if self._question is not None and number < self._question.number:
            self._restart()

    def _restart(self) -> None:
        """Hand the newest question to a new evaluator."""
        self._evaluator, self._overdue = self._new_evaluator(), monotonic()
        self._evaluator.send(self._question)

    def _stop_slower(self) -> None:
        if self._slower is not None:
            self._slower.stop()
            self._slower = None

    def _reported(self, worker: Worker, message: Any) -> None:
        self._post(lambda: self._handle(worker, message))

    def _handle(self, worker: Worker, message: Any) -> None:
        if self._question is None or worker not in (self._evaluator, self._slower):
            return
        if isinstance(message, Ended):
            if isinstance(message, Crashed) and worker is self._evaluator:
                # A process that ended before it began anything would end again.
                begun = self._answered < self._began
                self._fail(self._began if begun else self._question.number, message.message, True)
            elif isinstance(message, Crashed):
                self._tell(Stopped(self._question.number, f"limit loads and least friction: {message.message}"))
            return
        if isinstance(message, Began):
            self._began, self._begun_at = message.number, monotonic()
            self._overdue = None if message.number == self._question.number else self._overdue
            return
        if worker is self._evaluator:
            self._answered = max(self._answered, message.number)
        elif message.number != self._question.number:
            return
        if isinstance(message, Judged) and message.number == self._question.number:
            self._due = monotonic() + QUIET, message.verdict
        self._tell(message)
