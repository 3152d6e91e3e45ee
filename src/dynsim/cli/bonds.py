"""Options for glue and rotational stiffness."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from blockstat.assembly import Assembly
    from dynsim.engine.world import Action

Glue = Annotated[
    float | None, typer.Option(metavar="N", help="Glue every joint: tension in newtons that it holds; dry by default.")
]
ScaleInertia = Annotated[
    float | None, typer.Option("--inertia-scale", metavar="S", help="Multiply the inertia of every block.")
]
AngularStiffness = Annotated[
    float | None, typer.Option(metavar="K", help="A spring against rotation at every joint, in N m/rad.")
]


def with_glue(assembly: Assembly, glue: float | None) -> Assembly:
    """Return the assembly with the glue that was asked for.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    glue : float or None
        Tension that each joint holds [N]; None for the joints as they are.

    Returns
    -------
    Assembly
        The same blocks.

    Raises
    ------
    InputError
        For a tension that is negative or not finite.
    """
    from blockstat.assembly import glued

    return assembly if glue is None else glued(assembly, glue)


def stiffness_of(inertia_scale: float | None, angular_stiffness: float | None) -> list[Action]:
    """Return the actions for the rotational stiffness that was asked for.

    Parameters
    ----------
    inertia_scale : float or None
        Factor on the inertia of every block [-]; None for the inertia as it is.
    angular_stiffness : float or None
        Stiffness of a spring at every joint [N m/rad]; None for no springs.

    Returns
    -------
    list of Action
        None of them, one or both.

    Raises
    ------
    InputError
        For a factor or a stiffness that is not positive.
    """
    from dynsim.bonds.stiffness import AngularSprings, InertiaScale

    actions: list[Action] = []
    if inertia_scale is not None:
        actions.append(InertiaScale(inertia_scale))
    if angular_stiffness is not None:
        actions.append(AngularSprings(angular_stiffness))
    return actions
