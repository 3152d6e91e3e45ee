"""Intrinsic parameters: of the stone, of the joints and of ties."""

from __future__ import annotations

from typing import Annotated

import msgspec

from blockstat.model.quantities import Point


class Material(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Intrinsic parameters with the defaults of the procedural-masonry paper.

    Joints are dry. The paper's glue of 10 is a threshold on accumulated impacts in its host program and its rotational
    stiffness scales the inertia there; neither is a property of a joint, so both are kept with the scene and not
    modelled. Glue with a strength in newtons is asked for: `blockstat.glued(build(building), strength)`, rotational
    stiffness too: `dynsim.InertiaScale`, `dynsim.AngularSprings`.
    """

    density: Annotated[float, msgspec.Meta(gt=0)] = 2691.0  #: [kg/m3]
    friction: Annotated[float, msgspec.Meta(ge=0)] = 0.7  #: coefficient on every joint
    glue: Annotated[float, msgspec.Meta(ge=0)] = 10.0  #: kept with the scene; joints are dry
    rotational_stiffness: Annotated[float, msgspec.Meta(ge=0)] = 7000.0  #: [N m/rad], kept with the scene


class Joint(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """What is different about the joints between two groups (see `blockstat.joint.JointLaw`)."""

    between: tuple[str, str]  #: two groups, each with its subgroups; "*" is every block
    friction: Annotated[float, msgspec.Meta(ge=0)] | None = None  #: coefficient, by default the material's
    tension: Annotated[float, msgspec.Meta(ge=0)] = 0.0  #: strength [Pa]
    bond: Annotated[float, msgspec.Meta(ge=0)] = 0.0  #: tensile capacity of each joint whatever its area [N]
    cohesion: Annotated[float, msgspec.Meta(ge=0)] | None = None  #: shear strength without pressure [Pa]
    bond_moment: Annotated[float, msgspec.Meta(ge=0)] | None = None  #: bending and torsion that a bond holds [N m]
    compression: Annotated[float, msgspec.Meta(gt=0)] | None = None  #: strength [Pa], by default without limit
    cells: Annotated[int, msgspec.Meta(ge=0, le=64)] = 0  #: contact cells along each side of a joint


class TieTable(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A tie, an anchor or a strut between two blocks (see `blockstat.Tie`)."""

    between: tuple[str, str]  #: two blocks by name; "ground" for an anchor in the ground
    points: tuple[Point, Point]  #: where it holds each of them [m]
    least: Annotated[float, msgspec.Meta(ge=0)] = 0.0  #: least force [N]
    greatest: Annotated[float, msgspec.Meta(ge=0)] = float("inf")  #: greatest force [N]; as the least: given
    strut: bool = False  #: whether it pushes
