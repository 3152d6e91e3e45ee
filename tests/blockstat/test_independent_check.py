"""Damage to forces, mechanism or geometry shows in the certificate and in the independent check of the tests."""

import sys
from dataclasses import replace

import numpy as np
import pytest

import blockstat
from blockstat import LoadOutcome, Outcome, assess, limit_load, thrust_range
from blockstat.analysis.problem import pose
from blockstat.certificate import check as certificate
from evidence.checks import independent
from evidence.scenes.small import SCENES, arch, running_bond, stack

STANDING = ["stack", "arch", "wall", "heavy on light"]
FALLING = ["stack tipping", "thin arch", "slippery arch", "thin sticky arch", "wall pushed out", "offset cube"]
MAKERS = {name: (make, options) for name, make, options in SCENES}


def verdict_on(name):
    make, options = MAKERS[name]
    return assess(make(), **options)


def own_certificate(verdict):
    """What `blockstat` itself makes of the numbers in a verdict."""
    problem = pose(verdict.assembly, friction=None, gravity=None, loads=None, gap=1e-2, interfaces=verdict.interfaces)
    program, unit = problem.program, np.repeat([1.0, problem.program.length_unit], 3)
    twist = (verdict.mechanism[problem.eq.blocks] * unit).reshape(-1)
    return certificate.check(program, verdict.forces[problem.eq.points] / program.force_unit, twist)


def believed(verdict):
    """Whether both accept the evidence; they must agree."""
    proof = own_certificate(verdict)
    own = proof.proves_stable if verdict.outcome is Outcome.STABLE else proof.proves_unstable
    try:
        independent.check_verdict(verdict)
    except AssertionError:
        assert not own
        return False
    assert own
    return True


def changed(values, index, by):
    values = values.copy()
    values[index] += by
    return values


def with_interfaces(verdict, **changes):
    return replace(verdict, interfaces=replace(verdict.interfaces, **changes))


def with_assembly(verdict, **changes):
    return replace(verdict, assembly=verdict.assembly.with_(**changes))


def strongest(verdict):
    return int(np.argmax(verdict.forces[:, 0]))


def pinched(verdict):
    """Two corners of a joint pushed together along their line: in balance, and far beyond friction."""
    faces = verdict.interfaces
    first = faces.start[faces.point_interface[strongest(verdict)]]
    line = faces.frame[faces.point_interface[first]] @ (faces.point[first + 1] - faces.point[first])
    push = 10 * verdict.forces.max() * line / np.linalg.norm(line)
    return replace(verdict, forces=changed(changed(verdict.forces, first, push), first + 1, -push))


def scaled(verdict, factor):
    """The same forces and mechanism on a larger building."""
    larger = verdict.assembly.with_(vertices=factor * verdict.assembly.vertices)
    return replace(verdict, assembly=larger, interfaces=blockstat.find_interfaces(larger))


#: Functions whose every answer in these tests is checked a second time.
CHECKED = (
    "assess", "limit_load", "thrust_range", "settlement", "settle", "assess_plan", "load_domain", "moving_load",
    "tie_range", "tilt_limit", "friction_limit", "limit_load_by_direction", "capacity", "settle_to_collapse",
    "assess_states", "remove_each", "falsework", "decentring", "find_order", "safest_order", "build_by_courses",
)  # fmt: skip
DAMAGED_FORCES = {
    "none at all": lambda v: replace(v, forces=0 * v.forces),
    "one a little stronger": lambda v: replace(v, forces=changed(v.forces, (strongest(v), 0), 1e-6 * v.forces.max())),
    "one that pulls": lambda v: replace(v, forces=changed(v.forces, (strongest(v), 0), -2 * v.forces.max())),
    "beyond friction": pinched,
    "a denser block": lambda v: with_assembly(v, density=v.assembly.density * (1 + 1e-6)),
    "more gravity": lambda v: with_assembly(v, gravity=(1 + 1e-6) * v.assembly.gravity),
    "a larger building": lambda v: scaled(v, 1.001),
    "joints elsewhere": lambda v: with_interfaces(v, point=v.interfaces.point + [1e-3, 0, 1e-3]),
    "joints turned": lambda v: with_interfaces(v, frame=v.interfaces.frame[:, [1, 2, 0]]),
}
DAMAGED_MECHANISMS = {
    "none at all": lambda v: replace(v, mechanism=0 * v.mechanism),
    "backwards": lambda v: replace(v, mechanism=-v.mechanism),
    "one block sinks": lambda v: replace(v, mechanism=changed(v.mechanism, (v.moving[0], 2), -0.5)),
    "gravity upwards": lambda v: with_assembly(v, gravity=-v.assembly.gravity),
    "a larger building": lambda v: scaled(v, 1.01),
    "joints elsewhere": lambda v: with_interfaces(v, point=1.01 * v.interfaces.point),
    "joints the wrong way": lambda v: with_interfaces(v, frame=v.interfaces.frame * np.array([-1, 1, -1])[:, None]),
}


@pytest.mark.parametrize("damage", DAMAGED_FORCES)
@pytest.mark.parametrize("name", STANDING)
def test_damaged_forces_prove_nothing(name, damage):
    verdict = verdict_on(name)
    assert verdict.outcome is Outcome.STABLE
    assert believed(verdict)
    assert not believed(DAMAGED_FORCES[damage](verdict))


@pytest.mark.parametrize("damage", DAMAGED_MECHANISMS)
@pytest.mark.parametrize("name", FALLING)
def test_damaged_mechanisms_prove_nothing(name, damage):
    verdict = verdict_on(name)
    assert verdict.outcome is Outcome.UNSTABLE
    assert believed(verdict)
    assert not believed(DAMAGED_MECHANISMS[damage](verdict))


@pytest.mark.parametrize(
    "damage",
    [lambda v: {"lower": v.lower * (1 + 1e-6)}, lambda v: {"lower": v.lower * (1 - 1e-6)},
     lambda v: {"upper": v.upper * (1 - 1e-6)}, lambda v: {"upper": v.upper * (1 + 1e-6)},
     lambda v: {"lower": v.upper * 1.1}, lambda v: {"forces": 1.001 * v.forces}, lambda v: {"mechanism": -v.mechanism},
     lambda v: {"mechanism": changed(v.mechanism, (slice(2, None), 2), -0.1)}],
)  # fmt: skip
@pytest.mark.parametrize("make", [lambda: arch(20, 0.2), lambda: running_bond(4, 3), lambda: stack(3)])
def test_damaged_bounds_are_noticed(make, damage):
    found = limit_load(make(), (1, 0, 0))
    independent.check_limit(found, (1, 0, 0))
    with pytest.raises(AssertionError):
        independent.check_limit(replace(found, **damage(found)), (1, 0, 0))
    with pytest.raises(AssertionError):
        independent.check_limit(found, (-1, 0, 0.1))


def test_a_false_unbounded_load_is_noticed():
    found = limit_load(stack(3), (0, 0, -1))
    assert found.outcome is LoadOutcome.UNBOUNDED
    with pytest.raises(AssertionError, match="thousand times"):
        independent.check_limit(found, (1, 0, -1))


def test_a_thrust_that_the_forces_do_not_make_is_noticed():
    asm = arch(20, 0.2)
    found = thrust_range(asm, ["right"], (1, 0, 0))
    for lie in ({"least": 0.99 * found.least}, {"greatest_forces": 1.01 * found.greatest_forces}):
        with pytest.raises(AssertionError):
            independent.check_thrust(replace(found, **lie), ["right"], (1, 0, 0))


def test_every_answer_in_these_tests_is_checked():
    for name in CHECKED:
        home = getattr(blockstat, name).__module__
        for module in list(sys.modules.values()):
            found = vars(module).get(name)
            own = getattr(module, "__name__", "").startswith(("blockstat", "dynsim", "test_"))
            if own and getattr(found, "__module__", "") == home:  # others have the same name
                assert found.checked, module

    def lying(*args, **options):
        verdict = assess(*args, **options)
        return replace(verdict, forces=1.001 * verdict.forces)

    with pytest.raises(AssertionError, match="not balanced"):
        independent.checked(lying, lambda verdict, _: independent.check_verdict(verdict))(stack(2))
