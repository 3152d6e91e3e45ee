"""The joints of an assembly are searched for once in whatever is asked of it, and not at all where they are given."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest

from blockstat import InputError, find_interfaces, glued, search
from blockstat.contact import interfaces as contact
from blockstat.spec import scene_from
from dynsim import AngularSprings, Constant, Settings, compare, limit, simulate, verify, verify_many
from dynsim.comparison.compare import compare_one
from evidence.scenes.small import arch, assembly, box, stack

FAST = Settings.named("fast")


@pytest.fixture
def searches(monkeypatch):
    """The assemblies whose joints were searched for, in this process."""
    found = []

    def counted(asm, **options):
        found.append(asm)
        return original(asm, **options)

    original = contact.find_interfaces
    holders = [
        module
        for name, module in list(sys.modules.items())  # old names import as they are asked
        if name.startswith(("blockstat", "dynsim")) and getattr(module, "find_interfaces", None) is original
    ]
    assert len(holders) > 4
    for module in holders:
        monkeypatch.setattr(module, "find_interfaces", counted)
    return found


def heavy_on_light():
    """Masses so far apart that the engine asks which blocks touch."""
    blocks = [box((0, 0, z), (1, 1, z + 1), density=density) for z, density in ((0, 1.0), (1, 60.0), (2, 3000.0))]
    return assembly([box((-5, -5, -1), (5, 5, 0)), *blocks])


#: A fall that is not clear asks for three runs of the same assembly.
THREE_RUNS = SimpleNamespace(scene=lambda: arch(15, 0.107 * 0.99), options={})
SCENES = {
    "dry": SimpleNamespace(scene=lambda: stack(2), options={}),
    "falls late": THREE_RUNS,
    "glued": SimpleNamespace(scene=lambda: glued(stack(2), 0.5), options={}),
    "uneven masses": SimpleNamespace(scene=heavy_on_light, options={}),
    "springs": SimpleNamespace(scene=lambda: stack(2), options={"actions": [AngularSprings(50.0)]}),
    "loaded": SimpleNamespace(scene=lambda: stack(2), options={"loads": [Constant((0.01, 0, 0))]}),
}


@pytest.mark.parametrize("case", SCENES.values(), ids=SCENES)
def test_a_verdict_takes_one_search_and_none_where_the_joints_are_given(searches, case):
    asm = case.scene()
    joints = find_interfaces(asm)
    found = verify(asm, **case.options)
    assert len(searches) == 1
    given = verify(asm, interfaces=joints, **case.options)
    assert len(searches) == 1
    np.testing.assert_array_equal(found.run.displacement, given.run.displacement)
    np.testing.assert_array_equal(found.cracks.slip, given.cracks.slip)


def test_a_run_takes_one_search_dry_or_glued(searches):
    simulate(stack(2), settings=FAST)
    assert len(searches) == 1
    simulate(glued(stack(2), 0.5), settings=FAST)
    assert len(searches) == 2


def test_statics_and_bullet_share_a_search(searches):
    asm = stack(2)
    joints = find_interfaces(asm)
    compare_one(asm, settings=FAST)
    assert len(searches) == 1
    compare_one(asm, settings=FAST, interfaces=joints)
    assert len(searches) == 1


def test_a_limit_takes_one_search(searches):
    asm = stack(1, 0.5, 2.0)
    joints = find_interfaces(asm)
    found = limit(asm, (1, 0, 0), settings=FAST, width=0.1, check=False)
    assert len(searches) == 1
    given = limit(asm, (1, 0, 0), settings=FAST, width=0.1, check=False, interfaces=joints)
    assert len(searches) == 1
    assert (given.lower, given.upper) == (found.lower, found.upper)


ARCHES = {
    "name": "arches",
    "parameters": {"t": {"value": 0.18, "min": 0.16, "max": 0.18, "step": 0.01}},
    "elements": {"arch": {"kind": "arch", "span": 2.0, "thickness": "= t", "depth": 0.6, "voussoirs": 7}},
}


def test_statics_of_a_search_share_their_joints_with_the_verifier(searches):
    found = search(scene_from(ARCHES), verify=verify, strategy="paper")
    assert found.dynamic_runs > 1
    assert len(searches) == len(found.history)


def test_a_verifier_without_the_option_is_asked_about_the_assembly_alone(searches):
    found = search(scene_from(ARCHES), verify=lambda asm: verify(asm))
    assert len(searches) == len(found.history) + found.dynamic_runs


def test_joints_of_many_assemblies_are_given_one_a_design():
    designs = [stack(1), stack(2)]
    joints = [find_interfaces(design) for design in designs]
    rows = verify_many(designs, settings=FAST, interfaces=joints, jobs=1)
    assert [row.result.cracks.pair.tolist() for row in rows] == [part.pair.tolist() for part in joints]
    assert [row.interfaces for row in compare(designs, settings=FAST, interfaces=joints, jobs=1)] == [1, 2]
    for function in (verify_many, compare):
        with pytest.raises(InputError, match="interfaces of 1 assemblies are given; there are 2"):
            function(designs, interfaces=joints[:1])
