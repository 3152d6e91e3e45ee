"""Certified rigid-block statics of masonry: whether it stands, and which block moves first.

Lengths are in metres, forces in newtons, z is up unless gravity says otherwise.

Every name that a user is handed is in this module. A room is imported when one of its names is first asked for, so
`import blockstat` costs next to nothing. Builders of walls, arches and vaults are in `blockstat.model`.
"""

from blockstat.system.on_demand import on_demand

TYPE_CHECKING = False  # as typing has it, which takes longer to import than all of this module
if TYPE_CHECKING:
    from blockstat.analysis.assess import assess
    from blockstat.analysis.certificate_cache import Memory
    from blockstat.analysis.coulomb import CoulombState
    from blockstat.analysis.limit_load import LimitLoad, LoadOutcome, limit_load
    from blockstat.analysis.thrust import ThrustOutcome, ThrustRange, thrust_range
    from blockstat.analysis.tilt_friction.bracket import Bracket, BracketOutcome
    from blockstat.analysis.tilt_friction.friction import friction_limit
    from blockstat.analysis.tilt_friction.tilt import tilt_limit
    from blockstat.analysis.verdict import Outcome, Verdict
    from blockstat.assembly import Assembly, Block, glued
    from blockstat.certificate.check import Certificate
    from blockstat.chance.first_order import FirstOrder, FirstOrderOutcome, first_order
    from blockstat.chance.monte_carlo import Reliability, ReliabilityOutcome, fragility, reliability
    from blockstat.chance.variables import Random, random_variables
    from blockstat.code_check.linear import CheckOutcome, LinearCheck, linear_check, side_wall_friction
    from blockstat.code_check.nonlinear import LimitState, NonlinearCheck, nonlinear_check
    from blockstat.code_check.rocking import RockingBlock
    from blockstat.code_check.spectrum import Floor, Site, SpectrumTable
    from blockstat.contact.interfaces import Dropped, Interfaces, find_interfaces
    from blockstat.contact.overlap.penetration import overlaps
    from blockstat.design_search.candidate import Candidate, SearchOutcome, SearchResult
    from blockstat.design_search.margin import Margin
    from blockstat.design_search.search import search
    from blockstat.design_search.space import Space, space_of
    from blockstat.design_search.sweep import SweepOutcome, SweepResult, grid, latin_hypercube, sweep
    from blockstat.design_search.target import FailureTarget
    from blockstat.errors import InputError, InputWarning
    from blockstat.geometry_repair.repair import Change, RepairOutcome, RepairReport, repair
    from blockstat.imperfection.imperfections import Imperfections
    from blockstat.io.files import write
    from blockstat.io.scene_text import scene_text
    from blockstat.joint import JointLaw, Tie
    from blockstat.large_displacement.capacity_analysis import capacity
    from blockstat.large_displacement.capacity_curve import CapacityCurve, CapacityOutcome, CapacityPoint
    from blockstat.large_displacement.linkage.path import PathEvent
    from blockstat.loading.cases import LoadCase, load_case, load_cases
    from blockstat.loading.ground import dispersed_load, fill_load, fluid_pressure
    from blockstat.loading.on_faces import body_load, line_load, patch_load, surface_load
    from blockstat.loading.placed import PlacedForces
    from blockstat.loads import acceleration, point_load
    from blockstat.model.solids import box
    from blockstat.program.bonds import Bonds
    from blockstat.proof.proof_file import ProofFile, ProofOutcome, prove, prove_limit, prove_verdict
    from blockstat.reinforcement.ties import TieOutcome, TieRange, anchor_plate, tendon_load, tie_gain, tie_range
    from blockstat.result import Result, Sentence
    from blockstat.sensitivity.parameters import limit_load_gradient, score_gradient, stone_sensitivity
    from blockstat.sensitivity.reserve import ReserveMap, reserve_map
    from blockstat.sensitivity.vertices import PointGradient, limit_load_by_point, score_by_point, shared_points
    from blockstat.sequence.centring import Decentring, centring, decentring
    from blockstat.sequence.courses import Course, CoursesOutcome, CoursesResult, build_by_courses
    from blockstat.sequence.order import (
        OrderCount,
        OrderOutcome,
        OrderResult,
        SafestOrder,
        count_orders,
        find_order,
        safest_order,
    )
    from blockstat.sequence.plan import Plan, PlanVerdict, Step, assess_plan, check_plan, read_plan, write_plan
    from blockstat.sequence.prop_sets import CentringOrder, fewest_props, least_centring
    from blockstat.sequence.props import (
        Falsework,
        FalseworkOutcome,
        Prop,
        falsework,
        hoists,
    )
    from blockstat.sequence.stages import assess_stages
    from blockstat.sequence.states import assess_states
    from blockstat.sequence.taking_down.removal import RemovalVerdict, remove_each
    from blockstat.spec import (
        Building,
        Composition,
        Range,
        Scene,
        build,
        load_scene,
        parameters,
        read,
        scene_from,
        with_values,
    )
    from blockstat.studies.directions import DirectionalLimits, DirectionOutcome, limit_load_by_direction
    from blockstat.studies.foundations import Crack, Settlement, SettlementOutcome, settle, settlement
    from blockstat.studies.moving_supports import Foundation
    from blockstat.studies.settling_path import PathOutcome, SettlementPath, settle_to_collapse
    from blockstat.studies.two_loads import DomainOutcome, LoadDomain, load_domain
    from blockstat.traffic.envelope import MovingLoad, MovingOutcome, moving_load
    from blockstat.view.animation import write_mechanism, write_motion
    from blockstat.view.assessment import Assessment, assess_fully, assessment_html
    from blockstat.view.attributes import write_verdict
    from blockstat.view.building.film import write_plan_film
    from blockstat.view.building.removal import plot_removal
    from blockstat.view.building.steps import plot_plan
    from blockstat.view.plot import (
        mechanism_pose,
        plot,
        plot_forces,
        plot_mechanism,
        plot_stone_sensitivity,
        plot_verdict,
    )
    from blockstat.view.polar import plot_directions
    from blockstat.view.settling import plot_capacity, plot_settlement, write_path
    from blockstat.view.three_d.page import interactive_html, show
    from blockstat.view.thrust_lines import plot_thrust
    from blockstat.view.utilisation import plot_reserve_map, plot_utilisation, utilisation

__version__ = "0.2.0"
# fmt: off
__all__ = [
    "Assembly", "Assessment", "Block", "Bonds", "Bracket", "BracketOutcome", "Building", "Candidate",
    "CapacityCurve", "CapacityOutcome", "CapacityPoint", "CentringOrder", "Certificate", "Change", "CheckOutcome",
    "Composition", "CoulombState", "Course", "CoursesOutcome", "CoursesResult", "Crack", "Decentring",
    "DirectionOutcome", "DirectionalLimits", "DomainOutcome", "Dropped", "FailureTarget", "Falsework",
    "FalseworkOutcome", "FirstOrder", "FirstOrderOutcome", "Floor", "Foundation", "Imperfections", "InputError",
    "InputWarning", "Interfaces", "JointLaw", "LimitLoad", "LimitState", "LinearCheck", "LoadCase", "LoadDomain",
    "LoadOutcome", "Margin", "Memory", "MovingLoad", "MovingOutcome", "NonlinearCheck", "OrderCount",
    "OrderOutcome", "OrderResult", "Outcome", "PathEvent", "PathOutcome", "PlacedForces", "Plan", "PlanVerdict",
    "PointGradient", "ProofFile", "ProofOutcome", "Prop", "Random", "Range", "Reliability", "ReliabilityOutcome",
    "RemovalVerdict", "RepairOutcome", "RepairReport", "ReserveMap", "Result", "RockingBlock", "SafestOrder", "Scene",
    "SearchOutcome", "SearchResult", "Sentence", "Settlement", "SettlementOutcome", "SettlementPath", "Site",
    "Space", "SpectrumTable", "Step", "SweepOutcome", "SweepResult", "ThrustOutcome", "ThrustRange", "Tie",
    "TieOutcome", "TieRange", "Verdict", "acceleration", "anchor_plate", "assess", "assess_fully", "assess_plan",
    "assess_stages", "assess_states", "assessment_html", "body_load", "box", "build", "build_by_courses",
    "capacity", "centring", "check_plan", "count_orders", "decentring", "dispersed_load", "falsework",
    "fewest_props", "fill_load", "find_interfaces", "find_order", "first_order", "fluid_pressure", "fragility",
    "friction_limit", "glued", "grid", "hoists", "interactive_html", "latin_hypercube", "least_centring",
    "limit_load", "limit_load_by_direction", "limit_load_by_point", "limit_load_gradient", "line_load",
    "linear_check", "load_case", "load_cases", "load_domain", "load_scene", "mechanism_pose", "moving_load",
    "nonlinear_check", "overlaps", "parameters", "patch_load", "plot", "plot_capacity", "plot_directions",
    "plot_forces", "plot_mechanism", "plot_plan", "plot_removal", "plot_reserve_map", "plot_settlement",
    "plot_stone_sensitivity", "plot_thrust", "plot_utilisation", "plot_verdict", "point_load", "prove",
    "prove_limit", "prove_verdict", "random_variables", "read", "read_plan", "reliability", "remove_each", "repair",
    "reserve_map", "safest_order", "scene_from", "scene_text", "score_by_point", "score_gradient", "search",
    "settle", "settle_to_collapse", "settlement", "shared_points", "show", "side_wall_friction", "space_of",
    "stone_sensitivity", "surface_load", "sweep", "tendon_load", "thrust_range", "tie_gain", "tie_range",
    "tilt_limit", "utilisation", "with_values", "write", "write_mechanism", "write_motion", "write_path",
    "write_plan", "write_plan_film", "write_verdict",
]
# fmt: on

#: The module of each name.
_HOMES = {
    name: module
    for module, names in {
        "analysis.assess": "assess",
        "analysis.certificate_cache": "Memory",
        "analysis.coulomb": "CoulombState",
        "analysis.limit_load": "LimitLoad LoadOutcome limit_load",
        "analysis.thrust": "ThrustOutcome ThrustRange thrust_range",
        "analysis.tilt_friction.bracket": "Bracket BracketOutcome",
        "analysis.tilt_friction.friction": "friction_limit",
        "analysis.tilt_friction.tilt": "tilt_limit",
        "analysis.verdict": "Outcome Verdict",
        "assembly": "Assembly Block glued",
        "certificate.check": "Certificate",
        "chance.first_order": "FirstOrder FirstOrderOutcome first_order",
        "chance.monte_carlo": "Reliability ReliabilityOutcome fragility reliability",
        "chance.variables": "Random random_variables",
        "contact.interfaces": "Dropped Interfaces find_interfaces",
        "contact.overlap.penetration": "overlaps",
        "design_search.candidate": "Candidate SearchOutcome SearchResult",
        "design_search.margin": "Margin",
        "design_search.search": "search",
        "design_search.space": "Space space_of",
        "design_search.sweep": "SweepOutcome SweepResult grid latin_hypercube sweep",
        "design_search.target": "FailureTarget",
        "errors": "InputError InputWarning",
        "geometry_repair.repair": "Change RepairOutcome RepairReport repair",
        "imperfection.imperfections": "Imperfections",
        "io.files": "write",
        "io.scene_text": "scene_text",
        "joint": "JointLaw Tie",
        "loading.on_faces": "body_load line_load patch_load surface_load",
        "loading.ground": "dispersed_load fill_load fluid_pressure",
        "large_displacement.capacity_analysis": "capacity",
        "large_displacement.capacity_curve": "CapacityCurve CapacityOutcome CapacityPoint",
        "large_displacement.linkage.path": "PathEvent",
        "loading.cases": "LoadCase load_case load_cases",
        "loading.placed": "PlacedForces",
        "proof.proof_file": "ProofFile ProofOutcome prove prove_limit prove_verdict",
        "reinforcement.ties": "TieOutcome TieRange anchor_plate tendon_load tie_gain tie_range",
        "studies.settling_path": "PathOutcome SettlementPath settle_to_collapse",
        "traffic.envelope": "MovingLoad MovingOutcome moving_load",
        "code_check.nonlinear": "LimitState NonlinearCheck nonlinear_check",
        "code_check.rocking": "RockingBlock",
        "code_check.spectrum": "Floor Site SpectrumTable",
        "code_check.linear": "CheckOutcome LinearCheck linear_check side_wall_friction",
        "loads": "acceleration point_load",
        "model.solids": "box",
        "program.bonds": "Bonds",
        "result": "Result Sentence",
        "sensitivity.parameters": "limit_load_gradient score_gradient stone_sensitivity",
        "sensitivity.reserve": "ReserveMap reserve_map",
        "sensitivity.vertices": "PointGradient limit_load_by_point score_by_point shared_points",
        "sequence.props": "Falsework FalseworkOutcome Prop falsework hoists",
        "sequence.taking_down.removal": "RemovalVerdict remove_each",
        "sequence.courses": "Course CoursesOutcome CoursesResult build_by_courses",
        "sequence.centring": "Decentring centring decentring",
        "sequence.prop_sets": "CentringOrder fewest_props least_centring",
        "sequence.order": "OrderCount OrderOutcome OrderResult SafestOrder count_orders find_order safest_order",
        "sequence.plan": "Plan PlanVerdict Step assess_plan check_plan read_plan write_plan",
        "sequence.stages": "assess_stages",
        "sequence.states": "assess_states",
        "spec": "Building Composition Range Scene build load_scene parameters read scene_from with_values",
        "studies.directions": "DirectionOutcome DirectionalLimits limit_load_by_direction",
        "studies.two_loads": "DomainOutcome LoadDomain load_domain",
        "studies.foundations": "Crack Settlement SettlementOutcome settle settlement",
        "studies.moving_supports": "Foundation",
        "view.animation": "write_mechanism write_motion",
        "view.assessment": "Assessment assess_fully assessment_html",
        "view.attributes": "write_verdict",
        "view.building.film": "write_plan_film",
        "view.building.removal": "plot_removal",
        "view.building.steps": "plot_plan",
        "view.plot": "mechanism_pose plot plot_forces plot_mechanism plot_stone_sensitivity plot_verdict",
        "view.polar": "plot_directions",
        "view.settling": "plot_capacity plot_settlement write_path",
        "view.three_d.page": "interactive_html show",
        "view.thrust_lines": "plot_thrust",
        "view.utilisation": "plot_reserve_map plot_utilisation utilisation",
    }.items()
    for name in names.split()
}
__getattr__ = on_demand(__name__, _HOMES, globals())


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
