"""Names of version 0.1: they work, and those that moved warn and say where; the rest stands in the upgrade notes."""

import importlib
import inspect
import re
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

import blockstat
from blockstat.model import arch, assemble
from blockstat.system.old_names import MODULES, NAMES

NOTES = (Path(__file__).parents[2] / "docs" / "upgrading.md").read_text()
#: What `import blockstat` and `import dynsim` handed out in version 0.1 (commit d9631ae), and what its reference, its
#: pages, examples and notebooks showed to be imported from modules.
PUBLIC = {
    "blockstat": """
        Assembly Block Building Composition InputError InputWarning Interfaces JointLaw LimitLoad LoadOutcome
        Memory Outcome Verdict acceleration assess build find_interfaces friction_limit glued heal limit_load
        load_domain load_scene parameters point_load read scene_from search settlement show thrust_range
        tilt_limit with_values write write_verdict
    """,
    "dynsim": """
        AngularSprings Comparison Comparisons Constant DynamicLimit DynamicOutcome DynamicVerdict InertiaScale
        Pulse Push Ramp Record Removal Run Settings Settlement Tilt World compare limit read_record read_run
        run_many simulate verify verify_many write_run
    """,
    "blockstat.model": """
        Buttress Coping Opening Run Through arc_wall arch assemble barrel_vault build buttress column dome drum
        fan_vault flying_buttress freeform groin_vault height_field jack_arch mesh_vault moved pavilion_vault
        pier rib sail_vault surface_points walls
    """,
    "blockstat.spec": """
        Brick Building Buttress Composition Joint Material Opening Plan Range Scene Vault Wall is_present
        parameters resolve scene_from value_of with_values
    """,
    "blockstat.search": "Candidate Dynamic Margin SearchResult Space search space_of",
    "blockstat.sweep": "SweepResult grid latin_hypercube sweep verdict_row",
    "blockstat.sensitivity": "lacking limit_load_gradient pinned score_gradient stone_sensitivity",
    "blockstat.vertex_sensitivity": "PointGradient limit_load_by_point score_by_point shared_points",
    "blockstat.solve.certificate": """
        Certificate balance check cone_room force_errors opening_room power pressed room_of settle
    """,
    "blockstat.coulomb": "CoulombState coulomb_state settling_share",
    "blockstat.equilibrium": "Columns Equilibrium column_rates equilibrium in_place split_floating weight",
    "blockstat.program": "PenaltyProgram penalty_program",
    "blockstat.solve.dual": "open_joints solve solve_dual solve_margin solve_pressure",
    "blockstat.solve.interior_point": "ConicAnswer Early solve",
    "blockstat.plot": """
        SUPPORT joint_resultants mechanism_pose moving_twist picture picture_of_forces picture_of_help
        picture_of_mechanism picture_of_verdict resultants
    """,
    "blockstat.animate": "write_mechanism write_motion",
    "blockstat.utilisation": "eccentricity picture_of_utilisation utilisation",
    "blockstat.report": "Figure page write_designs write_report",
    "dynsim.causes": "Cause agrees find_cause finer likely_reason with_coulomb",
    "dynsim.first_motion": "cosine",
    "dynsim.optimise": "optimise picture_of_run",
    "dynsim.cracks": "Cracks find_cracks",
    "dynsim.film": "film_strip",
    "blockstat.reserve": "Bracket",
    "blockstat.paint": "posed view_of visible",
    "dynsim.buttresses": "buttress_loop",
    "dynsim.compare": "compare_one",
    "dynsim.criteria": "drops group_box_centre",
    "dynsim.pool": "Row",
    "dynsim.stiffness": "AngularSprings",
}
#: Of these, what nothing stands for now.
GONE = """
    blockstat.equilibrium.column_rates blockstat.solve.dual.solve_dual blockstat.solve.dual.solve_pressure
    blockstat.solve.interior_point.ConicAnswer blockstat.solve.interior_point.Early
""".split()
PAIRS = [(module, name) for module, names in PUBLIC.items() for name in names.split()]
SAID = re.compile(r"(\S+) is now (\S+), and goes with 0.3")


def asked(module, name):
    """What an import of the name gives, and the warnings of it."""
    scope = {}
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        exec(f"from {module} import {name} as found", scope)
    return scope["found"], told


def named(path):
    """What has a dotted name, None where nothing has."""
    home, _, name = path.rpartition(".")
    return getattr(importlib.import_module(home), name, None)


@pytest.mark.parametrize(("module", "name"), [pair for pair in PAIRS if ".".join(pair) not in GONE])
def test_a_name_of_0_1_can_be_imported_and_says_where_it_is_now(module, name):
    found, told = asked(module, name)
    assert not inspect.ismodule(found)
    moved = f"{module}.{name}" in NAMES or module in MODULES
    assert bool(told) == moved
    for warning in told:
        assert (warning.category, warning.filename) == (DeprecationWarning, "<string>")
        old, new = SAID.fullmatch(str(warning.message)).groups()
        assert old == f"{module}.{name}"
        assert not asked(*new.rsplit(".", 1))[1]
        assert found is named(new)
        assert new == NAMES.get(old, new)
        assert old in NAMES or new.endswith(f".{name}")
        short = f"{old.partition('.')[0]}.{new.rpartition('.')[2]}"
        assert new == short or named(short) is not found, "the warning names the place that users import from"


@pytest.mark.parametrize("name", GONE)
def test_what_is_gone_cannot_be_imported_and_stands_in_the_notes(name):
    module, _, last = name.rpartition(".")
    with pytest.raises(ImportError):
        asked(module, last)
    assert f"`{name}`" in NOTES


@pytest.mark.parametrize("old", [*NAMES, *MODULES])
def test_the_notes_have_every_old_name_and_the_new_one(old):
    (row,) = [line for line in NOTES.splitlines() if line.startswith(f"| `{old}` |")]
    for new in [NAMES[old]] if old in NAMES else MODULES[old].split():
        assert f"`{new}`" in row


def test_an_import_from_an_old_module_leaves_the_function_of_its_name():
    code = "from blockstat.search import Margin; from dynsim.compare import compare_one; import blockstat, dynsim"
    code += "; print(blockstat.search.__module__, dynsim.compare.__module__, Margin is blockstat.Margin)"
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert answer.stdout.split() == ["blockstat.design_search.search", "dynsim.comparison.compare", "True"]


@pytest.mark.parametrize("module", ["blockstat.plot", "blockstat.program", "blockstat.model", "dynsim.causes"])
def test_a_name_that_never_was_is_none_of_an_old_module(module):
    with pytest.raises(ImportError, match="cannot import name 'nothing'"):
        asked(module, "nothing")


def test_a_module_that_never_was_is_none():
    with pytest.raises(ModuleNotFoundError):
        importlib.import_module("blockstat.nothing")


def test_the_first_import_of_an_old_module_costs_no_heavy_library():
    code = "import sys, blockstat.plot, dynsim.causes; print([m for m in ('scipy', 'matplotlib') if m in sys.modules])"
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "[]"


def ring():
    return assemble(arch(span=2.0, thickness=0.3, depth=0.5, voussoirs=5, springers=0.3))


def test_repair_takes_the_tolerance_weld_as_merge():
    with pytest.warns(DeprecationWarning, match="the option 'weld' of repair is now 'merge'"):
        old, _ = blockstat.repair(ring(), weld=1e-3)
    new, _ = blockstat.repair(ring(), merge=1e-3)
    assert (old.vertices == new.vertices).all()
    with pytest.warns(DeprecationWarning, match="weld"), pytest.raises(blockstat.InputError, match="merge is 2"):
        blockstat.repair(ring(), weld=2)


def test_an_option_by_both_names_is_refused():
    with pytest.raises(TypeError, match="both 'merge' and 'weld', its old name"):
        blockstat.repair(ring(), weld=1e-3, merge=1e-3)


def test_search_takes_ahead_as_speculative():
    scene = blockstat.scene_from(
        {
            "name": "pier",
            "parameters": {"width": {"value": 0.3, "min": 0.3, "max": 0.4, "step": 0.1}},
            "elements": {"pier": {"kind": "pier", "size": ["= width", 0.3], "height": 1.0, "courses": 2}},
        }
    )
    with pytest.warns(DeprecationWarning, match="the option 'ahead' of search is now 'speculative'"):
        found = blockstat.search(scene, verify=None, over="grid", names="parameters.width", ahead=0)
    assert (
        found.outcome
        is blockstat.search(scene, verify=None, over="grid", names="parameters.width", speculative=0).outcome
    )


def test_a_warning_stands_at_the_line_of_the_user():
    with pytest.warns(DeprecationWarning, match="blockstat.heal is now blockstat.repair, and goes with 0.3") as name:
        assert blockstat.heal is blockstat.repair
    with pytest.warns(DeprecationWarning, match="weld") as option:
        blockstat.repair(ring(), weld=1e-3)
    assert {warning.filename for warning in [*name, *option]} == {__file__}
