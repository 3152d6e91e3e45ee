"""Write a proof that a structure stands, or that it falls, as rational numbers."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.assess import judged
from blockstat.analysis.limit_load import UNBOUNDED, LimitLoad, LoadOutcome, limit_load
from blockstat.analysis.problem import Problem, pose
from blockstat.analysis.verdict import Outcome, Verdict
from blockstat.certificate.check import balance, point_slack
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.errors import InputError, check_choice, known_options
from blockstat.loads import Loads, as_load, weighted
from blockstat.proof.centre import centred_forces
from blockstat.proof.connectors import connector_forces
from blockstat.proof.exact_check import Power, admissible
from blockstat.proof.forces import balanced_forces
from blockstat.proof.motions import BOUND, driven_motion
from blockstat.proof.parallel import parallel_forces
from blockstat.proof.rational import Exact, exact, text, written
from blockstat.proof.structure import Structure, structure, with_normals_of_faces
from blockstat.result import Result, Sentence, counted
from blockstat.solve.dispatch import CHOICES
from blockstat.system.writing import written_whole
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: What the files are; a number is added when what they say changes.
FORMAT = "blockstat proof 1"
#: How far a multiplier is lowered, if it must be, for forces that have slack.
SHARES = (0.0, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5)
#: Slack and forces below this fraction of a mean weight are none.
IDLE = 1e-12


class ProofOutcome(Sentence):
    """What a proof file proves; each value is the sentence a user reads."""

    STABLE = "Stable: exact forces within every friction cone balance every block."
    UNSTABLE = "Unstable: the loads drive an exact motion that no admissible forces resist."
    LIMIT = "Limit: exact forces carry the lower bound, and an exact motion shows that nothing carries the upper one."
    CARRIED = "Carried: exact forces carry the lower bound; no upper one is proven."


@dataclass(frozen=True, eq=False)
class ProofFile(Result):
    """A proof in rational numbers, which `extras/check_proof.py` checks."""

    outcome: ProofOutcome
    content: dict[str, Any]  #: data, proof and their hashes, numbers as text

    @property
    def bounded(self) -> bool:
        """Whether contact forces beyond `BOUND` dead loads are left out of account: no exact motion was found."""
        return "bound" in self.content["proof"]

    @property
    def _rows(self) -> tuple[int, int]:
        """Contacts, and rows of bonds and ties."""
        rows = self.content["data"]["contacts"]
        contacts = sum("friction" in row for row in rows)
        return contacts, len(rows) - contacts

    def explain(self) -> str:
        """Return what is proved in words, one fact a line.

        Returns
        -------
        str
            One fact a line.
        """
        data, (contacts, connectors) = self.content["data"], self._rows
        more = f", and {connectors} rows of bonds (two each) and ties" if connectors else ""
        lines = [self.outcome.value, f"{counted(len(data['blocks']), 'block')}, {counted(contacts, 'contact')}{more}."]
        if self.bounded:
            lines.append(f"The motion is not exact: it holds for contact forces of up to {BOUND:g} dead loads.")
        return "\n".join([*lines, f"Data {self.content['sha256']['data']}"])

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON.

        Returns
        -------
        dict
            Values by name.
        """
        data = self.content["data"]
        return {
            "outcome": self.outcome.word,
            "sentence": self.outcome.value,
            "blocks": len(data["blocks"]),
            "contacts": self._rows[0],
            "connectors": self._rows[1],
            "distance": float(data["distance"]),
            "sine": float(data["sine"]),
            "bounded": self.bounded,
            "sha256": self.content["sha256"],
        }

    def write(self, path: str | Path) -> None:
        """Write the file.

        Parameters
        ----------
        path
            Of a JSON file.
        """
        with written_whole(path) as place:
            place.write_text(json.dumps(self.content, separators=(",", ":")) + "\n", encoding="utf-8")


@known_options
def prove(
    assembly: Assembly,
    load: Any = None,
    *,
    friction: float | None = None,
    gravity: Any = None,
    loads: Loads | None = None,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
    solver: str = "auto",
) -> ProofFile:
    """Prove in rational numbers that an assembly stands or falls, or how much of a load it carries.

    The forces or the mechanism of a verdict are corrected by what rounding has left of them, until blocks balance and
    cones hold exactly. `extras/check_proof.py` checks the file with nothing but Python's standard library.

    Parameters
    ----------
    assembly
        The blocks, with their ties and joint laws.
    load
        As in `blockstat.limit_load`: proves both of its bounds. None proves the verdict.
    friction, gravity, loads, gap, interfaces, solver
        As in `blockstat.assess`.

    Returns
    -------
    ProofFile
        The proof, and `write` to write it.

    Raises
    ------
    InputError
        For an undecided assembly, for one that stands or falls by no more than rounding, for a bond at the centre of
        a joint of several patches, and as `blockstat.assess`.

    Notes
    -----
    Floats are taken for the decimals that Python prints. Coulomb's cone is about the normal that the file gives,
    whatever its length: `F.n >= 0` and `|F|^2 |n|^2 <= (1 + mu^2) (F.n)^2`, so no rounding of a frame enters. "Stable"
    means that an admissible force field exists.

    Examples
    --------
    >>> from blockstat import Assembly, box, prove
    >>> blocks = [box((-1, -1, -1), (2, 2, 0)), box((0, 0, 0), (1, 1, 1))]
    >>> proof = prove(Assembly.from_blocks(blocks, supports=[0]))
    >>> proof.outcome.word, len(proof.content["proof"]["forces"])
    ('stable', 4)
    """
    check_choice("solver", solver, CHOICES)
    options: dict[str, Any] = {"friction": friction, "gravity": gravity, "gap": gap, "interfaces": interfaces}
    problem = pose(assembly, loads=loads, **options)
    if load is None:
        return prove_verdict(judged(problem, loads=loads, solver=solver, reserve=False), loads=loads, problem=problem)
    found = limit_load(problem.assembly, load, loads=loads, gap=gap, interfaces=problem.interfaces, solver=solver)
    return prove_limit(found, load, loads=loads, problem=problem)


def prove_verdict(verdict: Verdict, *, loads: Loads | None = None, problem: Problem | None = None) -> ProofFile:
    """Prove a verdict in rational numbers.

    Parameters
    ----------
    verdict
        Stable, also by self-stress only, or unstable.
    loads
        Not needed: a verdict has its own, of the worst case of imperfections those of this case.
    problem
        As it was posed, if that is at hand.

    Returns
    -------
    ProofFile
        As of `prove`.

    Raises
    ------
    InputError
        As in `prove`.
    """
    loads = _loads_of(verdict, loads)
    problem = problem or _posed(verdict.assembly, verdict.interfaces, loads)
    if verdict.outcome is Outcome.UNDECIDED:
        raise InputError(f'"{problem.assembly.name}" is undecided: there is nothing to prove')
    if problem.assembly.support.all():
        raise InputError(f'"{problem.assembly.name}": all blocks are supports; there is nothing to prove')
    found = structure(problem, loads, None)
    if verdict.outcome is Outcome.UNSTABLE:
        motion, power = driven_motion(problem, found, verdict.mechanism)
        if not power.drives(BOUND):
            raise InputError(f'"{problem.assembly.name}" falls by less than rounding: there is no exact proof')
        return _file(ProofOutcome.UNSTABLE, found, _told(motion, power))
    force = _forces(problem, found, verdict.forces, None, 0.0)
    if force is None:
        found = with_normals_of_faces(found)
        force = parallel_forces(found)
    if force is None:
        raise InputError(f'"{problem.assembly.name}" is balanced without any reserve: there is no exact proof')
    return _file(ProofOutcome.STABLE, found, {"forces": written(force)})


def prove_limit(
    limit: LimitLoad, load: Any, *, loads: Loads | None = None, problem: Problem | None = None
) -> ProofFile:
    """Prove both bounds of a limit load in rational numbers.

    Parameters
    ----------
    limit
        The bracket.
    load
        The load that it was asked for.
    loads
        Not needed: a bracket has its own, of the worst case of imperfections those of this case.
    problem
        As it was posed, if that is at hand.

    Returns
    -------
    ProofFile
        As of `prove`; its bounds may be wider than those of the bracket by rounding, and the checker prints them. Of a
        load without limit it has a lower bound alone.

    Raises
    ------
    InputError
        As in `prove`.
    """
    loads = _loads_of(limit, loads)
    problem = problem or _posed(limit.assembly, limit.interfaces, loads)
    if limit.outcome is LoadOutcome.DEAD_LOAD_UNSTABLE:
        return prove_verdict(judged(problem, loads=loads, reserve=False), loads=loads, problem=problem)
    if limit.outcome is LoadOutcome.UNDECIDED:
        raise InputError(f'"{problem.assembly.name}" is undecided under this load: there is nothing to prove')
    live = as_load(problem.assembly, load)
    found = structure(problem, loads, live)
    proof: dict[str, Any] = {}
    lower = limit.lower if np.isfinite(limit.lower) else UNBOUNDED
    for share in SHARES:
        multiplier = (1.0 - share) * lower
        force = _forces(problem, found, limit.forces if not share else None, live, multiplier)
        if force is not None:
            proof |= {"multiplier": text(exact(multiplier)[()]), "forces": written(force)}
            break
    if np.isfinite(limit.upper):
        motion, power = driven_motion(problem, found, limit.mechanism)
        if power.live > 0:
            proof |= _told(motion, power)
    if "forces" not in proof or (np.isfinite(limit.upper) and "motion" not in proof):
        raise InputError(f'the bounds of "{problem.assembly.name}" rest on rounding: there is no exact proof')
    return _file(ProofOutcome.LIMIT if "motion" in proof else ProofOutcome.CARRIED, found, proof)


def _posed(assembly: Assembly, interfaces: Interfaces, loads: Loads | None) -> Problem:
    return pose(assembly, friction=None, gravity=None, loads=loads, gap=GAP, interfaces=interfaces)


def _loads_of(found: Verdict | LimitLoad, given: Loads | None) -> Loads | None:
    """The loads that an answer was found under; InputError where others are given."""
    if given is not None and not found.worst:
        none = np.zeros((found.assembly.n_blocks, 6))
        own, other = (weighted(none if loads is None else loads) for loads in (found.loads, given))
        if own.weight != other.weight or not np.array_equal(own.beside, other.beside):
            raise InputError(
                "loads: they are not those that the answer was found under; leave them out, it has its own"
            )
    return found.loads


def _forces(
    problem: Problem, structure: Structure, given: Floats | None, live: Floats | None, multiplier: float
) -> Exact | None:
    """Exact admissible forces: those given corrected, or the best centred ones; None if neither does."""
    program = problem.program
    if program is None:
        return np.full((0, 3), Fraction(0), dtype=object)
    load = program.load if live is None else program.load + multiplier * problem.scaled(live)
    connected = len(program.friction) > program.n_points  # by bonds and ties, whose forces those given lack
    for attempt in ("given", "centred"):
        if attempt == "given":
            scaled = None if given is None or connected else _scaled(problem, given)
        else:
            scaled = centred_forces(program, load)
            scaled = None if scaled is None else balance(replace(program, load=load), scaled)
        if scaled is None:
            continue
        frame = problem.interfaces.frame[problem.interfaces.point_interface]
        world = np.einsum("nij,ni->nj", frame, problem.to_points(scaled))
        slack = np.zeros(len(world))
        slack[problem.eq.points] = point_slack(program, scaled)[: problem.eq.n_points]
        if connected:
            more, room = connector_forces(problem, scaled)
            world, slack = np.concatenate([world, more]), np.concatenate([slack, room])
        idle = slack <= IDLE
        world[idle & (np.linalg.norm(world, axis=1) <= IDLE * program.force_unit)] = 0.0
        try:
            force = balanced_forces(structure, world, np.where(idle, 0.0, slack), exact(multiplier)[()])
        except ArithmeticError:
            continue
        if admissible(structure, force).all():
            return force
    return None


def _scaled(problem: Problem, forces: Floats) -> Floats:
    """Contact forces [N] as forces of the program."""
    program = problem.program
    assert program is not None
    scaled = forces[problem.eq.points] / program.force_unit
    scaled[:, 0] += program.shift
    return scaled


def _told(motion: Exact, power: Power) -> dict[str, Any]:
    """A motion as a file gives it, with the bound that it needs."""
    return {"motion": written(motion)} | ({"bound": str(BOUND)} if power.closing else {})


def _digest(part: Any) -> str:
    return hashlib.sha256(json.dumps(part, sort_keys=True, separators=(",", ":")).encode()).hexdigest()


def _file(outcome: ProofOutcome, found: Structure, proof: dict[str, Any]) -> ProofFile:
    hashes = {"data": _digest(found.data), "proof": _digest(proof)}
    return ProofFile(outcome, {"format": FORMAT, "data": found.data, "proof": proof, "sha256": hashes})
