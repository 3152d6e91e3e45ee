"""Load cases: named loads, and combinations of them with factors, as tables of a scene file or of Python."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.contact.interfaces import GAP, Interfaces, find_interfaces
from blockstat.contact.tolerance import ROUNDING
from blockstat.errors import InputError, gathered, is_number, known_options, no_such
from blockstat.loading.ground import dispersed_forces, fill_forces, fluid_forces, warn_of_spread
from blockstat.loading.on_faces import body_load, line_forces, patch_forces, point_forces, surface_forces
from blockstat.loading.placed import PlacedForces, at_centroids, joined
from blockstat.loads import WeightedLoads, acceleration
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: What makes the loads of each kind; the keys of their tables are its parameters. Wrenches act at centroids.
KINDS: dict[str, Callable[..., Floats | PlacedForces]] = {
    "point": point_forces,
    "line": line_forces,
    "patch": patch_forces,
    "surface": surface_forces,
    "body": body_load,
    "acceleration": acceleration,
    "pressure": fluid_forces,
    "fill": fill_forces,
    "dispersed": dispersed_forces,
}
#: Parameters that no table gives.
OURS = ("assembly", "interfaces")
CASE_KEYS = ("factors", "live", "weight", "description")

Tables = Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class LoadCase:
    """A combination of loads; all its wrenches are about the centroids of the blocks."""

    name: str
    permanent: Floats  #: what does not grow in a limit analysis, factors included, shape (n_blocks, 6) [N, N m]
    live: Floats  #: what a load multiplier multiplies, shape (n_blocks, 6) [N, N m]; zeros where nothing does
    description: str = ""
    combination: str = ""  #: the loads and their factors in words, as "0.9 weight + 1.5 wind (live)"
    weight: float = 1.0  #: factor on the weight of the blocks; `permanent` has it, of the blocks as drawn
    #: what stays beside the weight, factors included, shape (n_blocks, 6) [N, N m]; None where `permanent` is no more
    beside: Floats | None = None
    placed_permanent: PlacedForces | None = None  #: the forces of `permanent` at their points; None where not known
    placed_live: PlacedForces | None = None  #: those of `live`
    live_names: tuple[str, ...] = ()  #: the loads under `live`, those with a factor of zero, too
    shaking: Floats | None = None  #: the part of `live` that is accelerations, shape (n_blocks, 6); None: none is known

    @property
    def loads(self) -> Floats:
        """All that acts beside the weight as drawn when the multiplier is one, shape (n_blocks, 6) [N, N m]."""
        return self.permanent + self.live

    @property
    def placed_loads(self) -> PlacedForces | None:
        """The forces of `loads` at their points; None where these are not known."""
        if self.placed_permanent is None or self.placed_live is None:
            return None
        return self.placed_permanent.plus(self.placed_live)

    @property
    def weighted_permanent(self) -> WeightedLoads:
        """What stays, with the factor on the weight apart: for densities or factors that are random or imperfect."""
        return WeightedLoads(self.permanent if self.beside is None else self.beside, self.weight)

    @property
    def weighted_loads(self) -> WeightedLoads:
        """All that acts when the multiplier is one, with the factor on the weight apart as in `weighted_permanent`."""
        own = self.weighted_permanent
        return replace(own, beside=own.beside + self.live)

    @property
    def words(self) -> str:
        """What the case combines: its description, and the loads with their factors."""
        return f"{self.description} ({self.combination})" if self.description else self.combination

    @property
    def left_out(self) -> str:
        """What a verification under an earthquake says of its live loads, which are not permanent; empty without."""
        if not self.live.any():
            return ""
        return (
            f'case "{self.name}": its live loads, of {self.combination}, are left out of the code check, for they are '
            "not permanent; put them under factors if they act with the earthquake"
        )

    def without_mass(self, assembly: Assembly, *, live_grows: bool = False) -> str:
        """Return what is said where an acceleration grows and loads that stay press down, which it does not push.

        Parameters
        ----------
        assembly : Assembly
            The blocks.
        live_grows : bool, optional
            Whether the live loads grow, and not an acceleration beside the case. Then it is those under `shaking` that
            push the blocks, and what the other live loads push along with them has a mass.

        Returns
        -------
        str
            With the force that presses down without mass; empty where there is none.
        """
        held = self.weighted_permanent if live_grows else self.weighted_loads
        idle = held.pressing(assembly)
        if live_grows:
            if self.shaking is None:
                return ""
            push, other = self.shaking[:, :3], (self.live - self.shaking)[:, :3]
            square = (push**2).sum(axis=1)
            own = assembly.mass * np.linalg.norm(assembly.gravity)
            with_mass = own * (push * other).sum(axis=1) / np.where(square > 0, square, 1.0)
            idle = np.where(square > 0, idle - np.maximum(with_mass, 0.0), 0.0)
        idle = idle[assembly.free]
        pressing = float(idle[idle > 0].sum())
        if pressing <= ROUNDING * assembly.free_weight:
            return ""
        return (
            f"the loads that stay press down by {pressing:.6g} N and have no mass, so an acceleration of the blocks "
            "does not push them; where they are weight, what grows must have their inertia, too"
        )

    def under_gravity_of(self, assembly: Assembly) -> LoadCase:
        """Return the case with its factor on the weight under another gravity; all that acts beside stays as it is.

        Parameters
        ----------
        assembly : Assembly
            The blocks with the gravity that counts, for which the case was made under another one.

        Returns
        -------
        LoadCase
            The same loads: heights are measured against the gravity under which the case was made.

        Examples
        --------
        >>> from blockstat import Assembly, box, load_case
        >>> cube = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1))], density=1000.0)
        >>> snow = {"kind": "point", "block": 0, "point": [0, 0, 1], "force": [0, 0, -50]}
        >>> case = load_case(cube, "heavy", {"snow": snow}, {"heavy": {"factors": {"snow": 1}, "weight": 1.5}})
        >>> turned = case.under_gravity_of(cube.with_(gravity=(-10, 0, 0)))
        >>> case.permanent[0, :3].round(6).tolist(), turned.permanent[0, :3].round(6).tolist()
        ([0.0, 0.0, -4955.0], [-5000.0, 0.0, -50.0])
        """
        own = self.weighted_permanent
        permanent = own.beside + own.more_weight(assembly)
        placed = self.placed_permanent
        if placed is not None:
            placed = placed.plus(at_centroids(assembly, permanent - self.permanent))
        return replace(self, permanent=permanent, beside=own.beside, placed_permanent=placed)


@known_options
def load_cases(
    assembly: Assembly, loads: Tables | None = None, cases: Tables | None = None, *, gap: float | str = GAP
) -> dict[str, LoadCase]:
    """Make the load cases of an assembly.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    loads : mapping, optional
        By name: a wrench on each block, shape (n_blocks, 6) [N, N m], or a table as in a scene file, with a `kind` and
        the parameters of the function of that kind.
    cases : mapping, optional
        By name: a table with `factors` (of loads that stay), `live` (of loads that a multiplier multiplies), both
        numbers by the name of a load, and `weight`, the factor on the weight of the blocks, 1 by default. Loads and
        cases are by default those of the assembly's scene file.
    gap : float or str, optional
        Tolerance of the joint search, as of `find_interfaces`: loads on faces leave out what joints cover.

    Returns
    -------
    dict of LoadCase
        By name.

    Raises
    ------
    InputError
        Naming the key, for a load or a case that does not read as it must or does not fit the blocks.

    Examples
    --------
    >>> from blockstat import Assembly, box, load_cases
    >>> blocks = [box((-1, -1, -1), (2, 2, 0)), box((0, 0, 0), (1, 1, 1), name="block")]
    >>> assembly = Assembly.from_blocks(blocks, supports=[0])
    >>> snow = {"kind": "surface", "pressure": [0, 0, -1000], "towards": [0, 0, 1]}
    >>> wind = {"kind": "surface", "pressure": [500, 0, 0], "towards": [-1, 0, 0]}
    >>> case = {"factors": {"snow": 1.5}, "live": {"wind": 1.0}}
    >>> found = load_cases(assembly, {"snow": snow, "wind": wind}, {"winter": case})["winter"]
    >>> found.permanent[1, :3].round(6).tolist(), found.live[1, :3].round(6).tolist()
    ([0.0, 0.0, -1500.0], [500.0, 0.0, 0.0])
    """
    given: Tables = assembly.metadata.get("loads", {}) if loads is None else loads
    asked: Tables = assembly.metadata.get("cases", {}) if cases is None else cases
    check_tables(given, asked)
    used = {name for case in asked.values() for key in ("factors", "live") for name in case.get(key, {})}
    joints: list[Interfaces] = []

    def shared() -> Interfaces:
        joints[:] = joints or [find_interfaces(assembly, gap=gap)]
        return joints[0]

    acting = [name for name in given if name in used]
    forces = gathered(partial(_forces, assembly, given[name], f"loads.{name}", shared) for name in acting)
    made = dict(zip(acting, forces, strict=True))
    of_masses = {name for name in acting if isinstance(given[name], Mapping) and given[name]["kind"] == "acceleration"}
    return {name: _case(assembly, name, table, made, of_masses) for name, table in asked.items()}


@known_options
def load_case(
    assembly: Assembly, name: str, loads: Tables | None = None, cases: Tables | None = None, *, gap: float | str = GAP
) -> LoadCase:
    """Make one load case of an assembly.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    name : str
        Of the case.
    loads, cases : mapping, optional
        As in `load_cases`.
    gap : float or str, optional
        As in `load_cases`.

    Returns
    -------
    LoadCase
        The case.

    Raises
    ------
    InputError
        As `load_cases` does, and naming the cases there are where the one asked for is not among them.

    Examples
    --------
    >>> from blockstat import Assembly, box, load_case
    >>> assembly = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1))])
    >>> load_case(assembly, "light", {}, {"light": {"weight": 0.9}}).permanent[0, 2].round(3).item()
    2639.871
    """
    known: Tables = assembly.metadata.get("cases", {}) if cases is None else cases
    if name not in known:
        raise no_such("case", name, known)
    return load_cases(assembly, loads, {name: known[name]}, gap=gap)[name]


def check_tables(loads: Tables, cases: Tables) -> None:
    """Check the tables of loads and cases as far as no blocks are needed.

    Parameters
    ----------
    loads, cases
        As in `load_cases`.

    Raises
    ------
    InputError
        Naming each key at fault.
    """
    for option, tables in (("loads", loads), ("cases", cases)):
        if not isinstance(tables, Mapping):
            raise InputError(f"{option}: it must be a table by name, not {tables!r}")
    of_loads = [partial(_check_load, f"loads.{name}", table) for name, table in loads.items()]
    gathered([*of_loads, *(partial(_check_case, f"cases.{name}", table, loads) for name, table in cases.items())])


def _check_case(path: str, table: Any, loads: Tables) -> None:
    if not isinstance(table, Mapping):
        raise InputError(f"{path}: it must be a table with factors or live")
    wrong = [
        f"{path}.{key}: unknown key; keys here are: {', '.join(CASE_KEYS)}" for key in table if key not in CASE_KEYS
    ]
    for key in ("factors", "live"):
        factors = table.get(key, {})
        if not isinstance(factors, Mapping):
            wrong.append(f"{path}.{key}: it must give a number to each load, such as {{ snow = 1.5 }}")
            continue
        for load, factor in factors.items():
            if load not in loads:
                wrong.append(f"{path}.{key}.{load}: {no_such('load', load, loads)}")
            wrong += _not_a_number(f"{path}.{key}.{load}", factor)
    wrong += _not_a_number(f"{path}.weight", table.get("weight", 1.0))
    if wrong:
        raise InputError(*wrong)


def _check_load(path: str, table: Any) -> None:
    if isinstance(table, np.ndarray):  # a wrench on each block
        return
    if not isinstance(table, Mapping):
        raise InputError(f"{path}: it must be a table with a kind, or a wrench on each block")
    kind = table.get("kind")
    if not isinstance(kind, str) or kind not in KINDS:
        given = "the kind is missing" if kind is None else f"no kind {kind!r}"
        raise InputError(f"{path}.kind: {given}; kinds are: {', '.join(KINDS)}")
    keys = {name: p for name, p in inspect.signature(KINDS[kind]).parameters.items() if name not in OURS}
    wrong = [
        f"{path}.{key}: unknown key; keys of a {kind} load are: {', '.join(keys)}"
        for key in table
        if key != "kind" and key not in keys
    ]
    wrong += [
        f"{path}: a {kind} load needs {name}; keys are: {', '.join(keys)}"
        for name, parameter in keys.items()
        if parameter.default is parameter.empty and name not in table
    ]
    if wrong:
        raise InputError(*wrong)


def _not_a_number(path: str, value: Any) -> list[str]:
    if not is_number(value) or not np.isfinite(value):
        return [f"{path}: {value!r} is not a finite number"]
    return []


def _forces(assembly: Assembly, table: Any, path: str, shared: Callable[[], Interfaces]) -> PlacedForces:
    """The forces of one load."""
    if isinstance(table, np.ndarray):
        if table.shape != (assembly.n_blocks, 6) or not np.isfinite(table).all():
            raise InputError(
                f"{path}: the array has shape {table.shape}; finite values of shape ({assembly.n_blocks}, 6) are needed"
            )
        return at_centroids(assembly, table)
    make = KINDS[table["kind"]]
    options = {key: value for key, value in table.items() if key != "kind"}
    warn_of_spread(f"{path}.spread", options.get("spread"))
    if "interfaces" in inspect.signature(make).parameters:
        options["interfaces"] = shared()
    try:
        made = make(assembly, **options)
        return made if isinstance(made, PlacedForces) else at_centroids(assembly, made)
    except InputError as error:
        raise error.under(path) from None
    except (TypeError, ValueError):
        raise InputError(f"{path}: a {table['kind']} load cannot be made of {dict(table)}") from None


def _case(
    assembly: Assembly, name: str, table: Tables, made: Mapping[str, PlacedForces], accelerations: set[str]
) -> LoadCase:
    """The combination of one case, and the names of the loads that are accelerations."""

    def summed(factors: Tables) -> PlacedForces:
        return joined(assembly, (made[load].times(factor) for load, factor in factors.items()))

    stay, growing = summed(table.get("factors", {})), table.get("live", {})
    live = summed(growing)
    shaking = {load: factor for load, factor in growing.items() if factor and load in accelerations}
    own = WeightedLoads(stay.wrenches(assembly), table.get("weight", 1.0))
    parts = [f"{own.weight:g} weight"]
    parts += [f"{factor:g} {load}" for load, factor in table.get("factors", {}).items()]
    parts += [f"{factor:g} {load} (live)" for load, factor in growing.items()]
    more = at_centroids(assembly, own.more_weight(assembly))
    return LoadCase(
        name=name,
        permanent=own.beside + own.more_weight(assembly),
        live=live.wrenches(assembly),
        description=str(table.get("description", "")),
        combination=" + ".join(parts),
        weight=own.weight,
        beside=own.beside,
        placed_permanent=joined(assembly, (stay, more)),
        placed_live=live,
        live_names=tuple(growing),
        shaking=summed(shaking).wrenches(assembly) if shaking else None,
    )
