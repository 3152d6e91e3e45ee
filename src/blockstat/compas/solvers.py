"""Solve COMPAS objects in place, as the functions of compas_cra and compas_dem do."""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import Any

import numpy as np

from blockstat.analysis.assess import assess
from blockstat.analysis.verdict import Outcome, Verdict, relative_motion
from blockstat.assembly import DENSITY, Assembly
from blockstat.compas.objects import Recorded, Source, assembly_of, recorded_joints, source_of
from blockstat.compas.record import MOTION, record, results_of
from blockstat.contact.interfaces import GAP, find_interfaces
from blockstat.errors import InputError, InputWarning, check_choice, known_options
from blockstat.result import listed
from blockstat.typing import Floats

JOINTS = ("recorded", "found")
#: compas_cra takes density times volume as the weight.
UNIT_GRAVITY = (0.0, 0.0, -1.0)


@known_options
def solve(
    thing: Any,
    *,
    friction: float | None = None,
    density: float | None = None,
    gravity: Any = None,
    joints: str = "recorded",
    flow: str = "associated",
    gap: float | str = GAP,
    motion: float = MOTION,
) -> Any:
    """Give a verdict on a COMPAS object, and write forces, mechanism and verdict where COMPAS has them.

    Parameters
    ----------
    thing : Assembly of compas_assembly, Model of compas_model, or Problem of compas_dem
        The object, in metres and with z up. A problem brings its loads and the friction of its contact model.
    friction : float, optional
        Coefficient of friction of all joints; by default that of the problem or the attribute "friction" of the object,
        or 0.7.
    density : float, optional
        Of the blocks that have none of their own [kg/m3], 2691 if nothing says otherwise.
    gravity : sequence of float, shape (3,), optional
        [m/s2]; by default the attribute "gravity" of the object, or 9.81 downwards.
    joints : {"recorded", "found"}, optional
        "recorded" judges the joints that the object holds, and finds them where it holds none; it warns of blocks that
        touch without a recorded joint. "found" finds all joints, and replaces those of the object.
    flow : {"associated", "coulomb"}, optional
        As in `blockstat.assess`.
    gap : float or str, optional
        Tolerance of the search of joints, as in `blockstat.find_interfaces`.
    motion : float, optional
        How far the fastest corner moves in the motion that is written [m].

    Returns
    -------
    object
        `thing` itself; for a problem, a `Results` of compas_dem, which its viewer draws.

    Raises
    ------
    InputError
        For another object, no supports, a block that is no closed solid, or a bad option.

    Notes
    -----
    What is written, in SI units:

    - `forces` of each joint, one `{"c_np", "c_nn", "c_u", "c_v"}` a point: compression, residual tension (where no
      admissible forces exist), and the components along the x and y axes of its frame, as they act on the block that
      the z axis points into [N];
    - `displacement` of each node, six numbers: translation [m] and rotation [rad] about the centroid, of the mechanism
      of an unstable object, or of the Coulomb state of `flow="coulomb"`;
    - `verdict`, the values of `Verdict.summary`: an attribute of an assembly, or of the graph of a model.

    Examples
    --------
    ::

        import compas
        from blockstat.compas import solve

        assembly = solve(compas.json_load("arch.json"), friction=0.6)
        print(assembly.attributes["verdict"]["sentence"])
    """
    check_choice("joints", joints, JOINTS)
    problem = thing if hasattr(thing, "boundary_conditions") and hasattr(thing, "model") else None
    source = source_of(thing.model if problem is not None else thing)
    model = None if problem is None else problem.contact_properties.contact_model
    if friction is None and model is not None:
        friction = float(model.mu)
    assembly = assembly_of(source, density=DENSITY if density is None else density, friction=friction, gravity=gravity)
    loads = None if problem is None else _loads(problem, source, assembly)
    verdict, recorded = _verdict(source, assembly, joints, gap=gap, flow=flow, loads=loads)
    if problem is None:
        record(source, verdict, recorded, motion=motion)
        return thing
    return results_of(problem, source, verdict, recorded, motion=motion)


def _verdict(
    source: Source, assembly: Assembly, joints: str, *, gap: float | str = GAP, **options: Any
) -> tuple[Verdict, Recorded | None]:
    """The verdict on the joints of the source, or on all that are found."""
    recorded = recorded_joints(source, assembly) if joints == "recorded" else None
    if recorded is None:
        return assess(assembly, gap=gap, **options), None
    verdict = assess(assembly, interfaces=recorded.interfaces, **options)
    if missing := _unrecorded(assembly, recorded, gap):
        warnings.warn(InputWarning(missing), stacklevel=4)
        verdict = replace(verdict, warnings=(*verdict.warnings, missing))
    return verdict, recorded


def _unrecorded(assembly: Assembly, recorded: Recorded, gap: float | str) -> str:
    """Name the blocks that touch without a recorded joint; a search of joints drops small ones."""
    # All joints are searched for: a recorded one may hold open what would touch without it.
    have = set(map(tuple, recorded.interfaces.pair.tolist()))
    pairs = sorted(set(map(tuple, find_interfaces(assembly, gap=gap).pair.tolist())) - have)
    if not pairs:
        return ""
    some = listed([f"{assembly.names[a]} | {assembly.names[b]}" for a, b in pairs], 5)
    return f'blocks touch without a recorded joint, which joints="found" would add: {some}'


def _loads(problem: Any, source: Source, assembly: Assembly) -> Floats:
    """Wrenches of the boundary conditions of a problem about the centroids, shape (n_blocks, 6) [N, N m]."""
    from compas_dem.analysis.resolve import (  # pyright: ignore[reportMissingImports]
        resolve_centroidal_displacements,
        resolve_centroidal_loads,
    )

    if resolve_centroidal_displacements(problem.boundary_conditions):
        raise InputError("the problem prescribes displacements; blockstat.settle judges supports that move")
    found = resolve_centroidal_loads(source.made, problem.boundary_conditions)
    loads = np.array([[*found[node]["force"], *found[node]["moment"]] for node in source.nodes], dtype=float)
    loads[assembly.support] = 0.0
    return loads


def rbe_solve(assembly: Any, mu: float = 0.84, density: float = 1.0, verbose: bool = False, timer: bool = False) -> Any:
    """Find forces in balance, with the signature and the units of `compas_cra.equilibrium.rbe_solve`.

    Parameters
    ----------
    assembly : Assembly of compas_assembly
        Such as a `CRA_Assembly`, with its interfaces; they are found where it has none.
    mu : float, optional
        Coefficient of friction.
    density : float, optional
        Of the blocks without an attribute "density". The weight of a block is its density times its volume.
    verbose : bool, optional
        Print the verdict in words.
    timer : bool, optional
        Print the seconds that it took.

    Returns
    -------
    Assembly of compas_assembly
        The same object, with `forces` at its interfaces, and its verdict as the attribute "verdict".

    Raises
    ------
    InputError
        As `solve`.

    Notes
    -----
    Where compas_cra has an octagon of friction, here is the cone. Residual tension, where it is needed, is the least in
    the 2-norm, as with its weights; compression and friction are not weighed against it. Forces without tension prove
    that the assembly is stable; compas_cra minimises their squares too, so it may show another one of many.
    """
    return _drop_in(assembly, mu, density, verbose, timer, flow="associated", motion=None)


def cra_penalty_solve(
    assembly: Any,
    mu: float = 0.84,
    density: float = 1.0,
    d_bnd: float = 1e-3,
    eps: float = 1e-4,
    verbose: bool = False,
    timer: bool = False,
) -> Any:
    """Find forces that a displacement causes, with the signature and the units of `cra_penalty_solve` of compas_cra.

    Parameters
    ----------
    assembly : Assembly of compas_assembly
        As in `rbe_solve`.
    mu, density, verbose, timer
        As in `rbe_solve`.
    d_bnd : float, optional
        The largest relative displacement of two blocks at a contact point, to which displacements are scaled.
    eps : float, optional
        Taken for the sake of the signature: no overlap has to be allowed for.

    Returns
    -------
    Assembly of compas_assembly
        The same object, with `forces` at its interfaces, a `displacement` at each free node, and its verdict as the
        attribute "verdict".

    Raises
    ------
    InputError
        As `solve`.

    Notes
    -----
    The verdict is that of `blockstat.assess(..., flow="coulomb")`: stable if the forces are those of a displacement
    with friction that opposes slip. It finds such a state in joints of several kinds, where compas_cra asks for rigid
    joints that overlap by eps; the two may differ where only self-stress holds an assembly.
    """
    return _drop_in(assembly, mu, density, verbose, timer, flow="coulomb", motion=d_bnd)


def _drop_in(
    thing: Any, mu: float, density: float, verbose: bool, timer: bool, *, flow: str, motion: float | None
) -> Any:
    source = source_of(thing)
    assembly = assembly_of(source, density=density, friction=mu, gravity=UNIT_GRAVITY)
    verdict, recorded = _verdict(source, assembly, "recorded", flow=flow)
    if motion is not None:
        moved = verdict.mechanism if verdict.outcome is Outcome.UNSTABLE else verdict.displacement
        slip = 0.0 if moved is None else np.abs(relative_motion(assembly, verdict.interfaces, moved)).max(initial=0.0)
        motion = motion / slip if slip else 0.0
    record(source, verdict, recorded, motion=motion)
    if verbose:
        print(verdict.explain())
    if timer:
        print(f"--- solving time: {verdict.timings['total']} seconds ---")
    return thing
