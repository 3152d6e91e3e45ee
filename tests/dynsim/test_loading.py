"""Loads against closed forms: tipping, overturning by a pulse, sliding, three hinges, decentring."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from blockstat import Assembly, Block, InputError
from dynsim import (
    Constant,
    DynamicOutcome,
    InertiaScale,
    Pulse,
    Push,
    Ramp,
    Record,
    Removal,
    Settings,
    Settlement,
    Tilt,
    World,
    read_record,
    run_many,
    simulate,
    verify,
    verify_many,
)
from evidence.scenes.small import arch, assembly, box, hexahedron, stack

STANDS, FALLS = DynamicOutcome.STANDS, DynamicOutcome.FALLS
G = 9.81
DOWN = (0, 0, -G)
FAR = Settings(brick_threshold=20.0, roof_threshold=20.0)


def slider(friction):
    """A flat block on wide level ground."""
    return assembly(
        [box((-50, -50, -1), (50, 50, 0)), box((-0.5, -0.5, 0), (0.5, 0.5, 0.2), name="slab")],
        friction=friction, gravity=DOWN,
    )  # fmt: skip


@pytest.mark.parametrize(("axis", "ratio"), [((0, 1, 0), 0.25), ((0, -1, 0), 0.25), ((1, 0, 0), 0.5)])
def test_a_block_tips_at_the_slope_of_its_diagonal(axis, ratio):
    # atan(b / h), width 0.5 or depth 1 on a height of 2.
    asm, angle = stack(1, 0.5, 2.0, gravity=DOWN), np.degrees(np.arctan(ratio))
    assert verify(asm, loads=[Tilt(axis, 0.99 * angle, rate=5.0)]).outcome is STANDS
    assert verify(asm, loads=[Tilt(axis, 1.01 * angle, rate=5.0)]).outcome is FALLS


@pytest.mark.parametrize("length", [0.05, 1.0, 20.0])
def test_overturning_starts_at_wests_acceleration(length):
    # Milne (1885), after West: a / g = b / h.
    asm = stack(1, 0.5, 2.0, gravity=DOWN)
    asm = asm.with_(vertices=length * asm.vertices)
    for factor, outcome in ((0.99, STANDS), (1.01, FALLS)):
        ground = Ramp((factor * 0.25 * G, 0, 0), 1.0 * np.sqrt(length))
        assert verify(asm, loads=[ground]).outcome is outcome


def test_tilt_and_acceleration_add_up():
    asm, angle = stack(1, 0.5, 2.0, gravity=DOWN), 7.0
    a = G * (0.25 * np.cos(np.deg2rad(angle)) - np.sin(np.deg2rad(angle)))
    for factor, outcome in ((0.98, STANDS), (1.02, FALLS)):
        loads = [Tilt((0, 1, 0), angle, rate=5.0), Ramp((factor * a, 0, 0), 1.0)]
        # Gravity turned about +y pulls towards -x, as ground that accelerates towards +x does.
        assert verify(asm, loads=loads).outcome is outcome


@pytest.mark.parametrize("strength", [1.5, 2.5, 4.0])
def test_a_rectangular_pulse_overturns_as_housner_says(strength):
    # Housner (1963): a pulse of a = A alpha g overturns if cosh(p T) > 1 + 1 / (2 A (A - 1)); within 2 %.
    width, height = 0.25, 2.0
    asm = stack(1, width, height, gravity=DOWN, friction=2.0)
    p = np.sqrt(3 * G / (2 * np.hypot(width, height)))
    duration = np.arccosh(1 + 1 / (2 * strength * (strength - 1))) / p
    peak = (strength * width / height * G, 0, 0)
    assert verify(asm, loads=[Pulse(peak, 0.98 * duration)]).outcome is not FALLS  # it rocks for long
    assert verify(asm, loads=[Pulse(peak, 1.02 * duration)]).outcome is FALLS


def test_a_block_slides_under_a_pulse_as_newmark_says():
    # Newmark (1965): a rectangular pulse a of duration T leaves (a T)^2 / (2 mu g) (1 - mu g / a).
    a, mu, duration = 0.5 * G, 0.2, 0.4
    verdict = verify(slider(mu), loads=[Pulse((0, a, 0), duration)], settings=FAR)
    expected = (a * duration) ** 2 / (2 * mu * G) * (1 - mu * G / a)
    assert verdict.outcome is STANDS
    np.testing.assert_allclose(verdict.displacement[1], [0, -expected, 0], atol=0.01 * expected)


SHORT = 3e-4  #: [s], less than a time step


@pytest.mark.parametrize(
    ("ground", "share"),
    [
        (Pulse((1 / SHORT, 0, 0), SHORT, start=0.1003), 1.0),
        (Pulse((1 / SHORT, 0, 0), SHORT, "triangle", start=0.1006), 1 / 2),
        (Pulse((1 / SHORT, 0, 0), SHORT, "half-sine", start=0.1009), 2 / np.pi),
        (Record([0.1, 0.1 + SHORT / 2, 0.1 + SHORT], [[0, 0, 0], [1 / SHORT, 0, 0], [0, 0, 0]]), 1 / 2),
    ],
)
def test_a_pulse_shorter_than_a_time_step_is_an_impulse(ground, share):
    # The block has the velocity of the ground before it, here `share` of 1 m/s, and slides by v^2 / (2 mu g).
    verdict = verify(slider(0.2), loads=[ground], settings=FAR)
    expected = share**2 / (2 * 0.2 * G)
    np.testing.assert_allclose(verdict.displacement[1], [-expected, 0, 0], atol=0.02 * expected)


def test_a_block_slides_under_a_record_with_vertical_motion(tmp_path):
    # The sliding equation integrated by another method; the record goes through its file.
    times = np.arange(0, 1.5, 0.01)
    ground = np.column_stack([8 * np.sin(4 * times), 3 * np.cos(11 * times), 2 * np.sin(9 * times)])
    path = tmp_path / "record.csv"
    path.write_text(
        "time, x, y, z\n" + "\n".join(f"{t},{x},{y},{z}" for t, (x, y, z) in zip(times, ground, strict=True))
    )
    mu = 0.2

    def rate(t, state):
        a = np.array([np.interp(t, times, ground[:, k], right=0.0) for k in range(3)])
        velocity = state[2:]
        speed = np.linalg.norm(velocity)
        held = mu * (G + a[2])
        slip = velocity / speed if speed > 1e-4 else -a[:2] / max(np.linalg.norm(a[:2]), held, 1e-9)
        return [*velocity, *(-a[:2] - held * slip)]

    expected = solve_ivp(rate, (0, 3.0), [0, 0, 0, 0], max_step=2e-4, rtol=1e-6).y[:2, -1]
    verdict = verify(slider(mu), loads=[read_record(path)], settings=FAR)
    assert np.linalg.norm(expected) > 0.1
    np.testing.assert_allclose(verdict.displacement[1, :2], expected, atol=0.03 * np.linalg.norm(expected))


def test_a_block_under_the_yield_acceleration_stays():
    verdict = verify(slider(0.5), loads=[Pulse((0.48 * G, 0, 0), 1.0, "half-sine")])
    assert verdict.max_displacement < 1e-4


def hinges(run, least=0.2):
    """Joints of an arch of n voussoirs that turned by more than a share of the joint that turned most, with sign."""
    n = run.assembly.n_blocks
    order = [0, *range(2, n), 1]
    frame = run.rotation[-1]
    turn = [Rotation.from_matrix(frame[a].T @ frame[b]).as_rotvec()[1] for a, b in pairwise(order)]
    turn = np.array(turn)
    found = np.flatnonzero(np.abs(turn) > least * np.abs(turn).max())
    return found, np.sign(turn[found]), turn


@pytest.mark.parametrize("path", [(0.03, 0, 0), (-0.03, 0, 0), (0, 0, -0.05)])
def test_a_settling_support_opens_three_hinges(path):
    # Heyman (1966): an arch on supports that move cracks into three hinges and stands.
    asm = arch(15, 0.15, gravity=DOWN)
    verdict = verify(asm, loads=[Settlement("right", path, 0.02)])
    assert verdict.outcome is STANDS
    np.testing.assert_allclose(verdict.run.displacement[-1, 1], path, atol=1e-6)
    found, signs, turn = hinges(verdict.run)
    assert len(found) == 3
    rest = np.delete(turn, found)
    assert np.abs(rest).max() < 0.02 * np.abs(turn).max()
    if path[0]:
        assert signs[0] == signs[2] == -signs[1]
    if path[0] > 0:  # a spreading arch sinks at its crown
        assert abs(found[1] - 7.5) <= 1
        assert verdict.displacement[9, 2] < -0.01


def test_a_block_rides_on_a_support_that_moves():
    asm = stack(1, 1.0, 0.5, gravity=DOWN)
    path = [(0.2, 0, 0), (0.2, 0.1, 0), (0.2, 0.1, 0.05)]
    # It slips by v^2 / (2 mu g), 2e-4 m, as the support starts, turns and stops.
    load = Settlement("ground", path, 0.05, start=0.1)
    assert load.end == pytest.approx(0.1 + 0.35 / 0.05)
    verdict = verify(asm, loads=[load])
    np.testing.assert_allclose(verdict.displacement[1], path[-1], atol=1e-3)


def test_a_block_lags_behind_its_support_by_what_friction_takes_to_bring_it_up_to_speed():
    # v^2 / (2 mu g), less half the way of a time step, which has the velocity at its end.
    asm, speed = stack(1, 0.3, 0.3, friction=0.4, gravity=DOWN), 0.1
    run = simulate(asm, loads=[Settlement("ground", (0.1, 0, 0), speed)], settings=Settings(end=0.5))
    late = (run.times > 0.1) & (run.times < 0.4)
    lag = speed * run.times[late] - run.since_release[late, 1, 0]
    step = run.time_step / np.sqrt(0.3 / asm.size[1])
    np.testing.assert_allclose(lag, speed**2 / (2 * 0.4 * G) - speed * step / 2, rtol=2e-3)


def test_a_support_has_the_velocity_that_it_is_given_whatever_gravity_is():
    asm = stack(1, 1.0, 0.5, gravity=(2.0, 0, -G))
    with World(asm, Settings(), [Settlement("ground", (0.1, 0, 0), 0.05)]) as world:
        world.advance(0.1)
        np.testing.assert_allclose(world.velocities()[0][0], [0.05, 0, 0], atol=1e-9)


def test_settlements_of_one_support_add_up():
    # Two at right angles are one along their sum; one that begins later goes on from where the first has ended.
    asm = stack(1, 1.0, 0.5, gravity=DOWN)
    across, along = Settlement("ground", (0.03, 0, 0), 0.03), Settlement("ground", (0, 0.04, 0), 0.04)
    both, one = (verify(asm, loads=loads) for loads in ([across, along], Settlement("ground", (0.03, 0.04, 0), 0.05)))
    np.testing.assert_allclose(both.run.displacement, one.run.displacement, atol=1e-6)
    later = Settlement("ground", (0.03, 0, 0), 0.03, start=1.5)
    verdict = verify(asm, loads=[later, across])
    np.testing.assert_allclose(verdict.run.displacement[-1, 0], [0.06, 0, 0], atol=1e-9)
    np.testing.assert_allclose(verdict.displacement[1], [0.06, 0, 0], atol=1e-3)


def test_what_a_support_carries_has_not_fallen_by_a_threshold_that_is_given():
    asm, ten = stack(1, 1.0, 0.5, gravity=DOWN), Settings(brick_threshold=0.01, roof_threshold=0.01)
    ridden = verify(asm, loads=[Settlement("ground", (0, 0, -0.02), 0.02)], settings=ten)
    assert ridden.outcome is STANDS
    assert ridden.max_drop == pytest.approx(0.02, abs=1e-3)
    assert (ridden.brick_threshold, ridden.roof_threshold) == pytest.approx((0.03, 0.03))
    # Without the way of a support a slide of 28 mm, v^2 / (2 mu g), is one beyond the same threshold.
    slid = verify(slider(0.4), loads=[Push("slab", velocity=(0.47, 0, 0))], settings=ten)
    assert (slid.outcome, slid.brick_threshold) == (FALLS, 0.01)


def test_an_arch_without_its_keystone_falls():
    asm = arch(15, 0.15, gravity=DOWN)
    verdict = verify(asm, loads=[Removal("voussoir7", 0.2)])
    assert verdict.outcome is FALLS
    assert verdict.first_block in ("voussoir6", "voussoir8")
    crossed = np.linalg.norm(verdict.run.since_release[:, 8], axis=1) > 0.001
    assert verdict.run.times[crossed.argmax()] > 0.2
    assert verdict.run.removed[9] == pytest.approx(0.2, abs=0.02)
    assert np.isinf(np.delete(verdict.run.removed, 9)).all()


@pytest.mark.parametrize(("thickness", "outcome"), [(0.15, STANDS), (0.10, FALLS)])
def test_striking_the_centring(thickness, outcome):
    # 15 voussoirs need t/R = .107; on its centring the thin one stands too.
    asm = arch(15, thickness)
    angles = np.pi - np.linspace(0, np.pi, 16)
    r = 1 - thickness / 2
    outline = [(r * np.cos(a), r * np.sin(a)) for a in angles]
    blocks = [
        hexahedron(asm.block_vertices(i)[:4], asm.block_vertices(i)[4:], name=asm.names[i]) for i in range(asm.n_blocks)
    ]
    n = len(outline)
    vertices = [(x, y, z) for y in (0.0, 0.5) for x, z in outline]
    sides = [[i, i + n, (i + 1) % n + n, (i + 1) % n] for i in range(n)]
    centring = Block(vertices, [list(range(n))[::-1], list(range(n, 2 * n)), *[s[::-1] for s in sides]], "centring")
    scene = assembly([*blocks, centring], supports=["left", "right", "centring"], gravity=DOWN)
    assert verify(scene).outcome is STANDS
    assert verify(scene, loads=[Removal("centring", 0.3)]).outcome is outcome


def test_a_pushed_block_slides_to_a_stop():
    # v^2 / (2 mu g)
    verdict = verify(slider(0.4), loads=[Push("slab", velocity=(1.5, 0, 0), time=0.1)], settings=FAR)
    np.testing.assert_allclose(verdict.displacement[1], [1.5**2 / (2 * 0.4 * G), 0, 0], atol=0.005)


@pytest.mark.parametrize("length", [0.1, 5.0])
def test_an_impulse_off_the_centre_spins_a_free_block(length):
    asm = assembly([box((-5, -5, -60), (5, 5, -50)), box((0, 0, 0), (1, 2, 3))], gravity=DOWN)
    asm = asm.with_(vertices=length * asm.vertices)
    impulse, arm = 0.1 * asm.mass[1] * np.array([1.0, 2.0, -1.0]), length * np.array([0.5, 1.0, 1.5])
    push = Push(1, impulse=impulse, point=asm.centroid[1] + arm)
    run = simulate(asm, settings=Settings(end=1.0), loads=[push])
    k = 5
    spin = np.linalg.solve(asm.inertia[1], np.cross(arm, impulse))
    turned = Rotation.from_matrix(run.rotation[k, 1]).as_rotvec()
    assert np.linalg.norm(turned) > 0.01
    # Torque-free motion of a box: the axis drifts a little as it turns.
    np.testing.assert_allclose(turned, spin * run.times[k], atol=0.05 * np.linalg.norm(turned))
    moved = run.since_release[k, 1] / run.times[k]
    np.testing.assert_allclose(moved[:2], [0.1, 0.2], rtol=1e-3)


def test_an_impulse_spins_a_block_of_scaled_inertia_less_and_its_energy_is_that_of_the_spin():
    # w = J^-1 (r x p) / s, and the energy m v^2 / 2 + (r x p) J^-1 (r x p) / (2 s).
    asm, scale = assembly([box((-5, -5, -60), (5, 5, -50)), box((0, 0, 0), (1, 2, 3))], gravity=DOWN), 4.0
    impulse, arm = asm.mass[1] * np.array([1.0, 2.0, -1.0]), np.array([0.5, 1.0, 1.5])
    loads = [Push(1, impulse=impulse, point=asm.centroid[1] + arm)]
    run = simulate(asm, settings=Settings(end=0.1), loads=loads, actions=[InertiaScale(scale)])
    couple = np.cross(arm, impulse)
    spin = np.linalg.solve(asm.inertia[1], couple) / scale
    turned = Rotation.from_matrix(run.rotation[1, 1]).as_rotvec()
    np.testing.assert_allclose(turned, spin * run.times[1], atol=0.03 * np.linalg.norm(turned))
    velocity = impulse / asm.mass[1] + asm.gravity * run.times[1]
    expected = (asm.mass[1] * velocity @ velocity + couple @ spin) / 2
    assert run.kinetic[1] == pytest.approx(expected, rel=0.01)


def test_a_block_that_is_let_go_keeps_the_scale_of_its_inertia():
    asm = assembly([box((-5, -5, -60), (5, 5, -50)), box((0, 0, 0), (1, 2, 3))], gravity=DOWN)
    with World(asm, Settings(), [InertiaScale(4.0)]) as world:
        inertia = world._bullet.getDynamicsInfo(world._bodies[1], -1, physicsClientId=world._client)[2]
        world.hold(1)
        world.let_go(1)
        assert world._bullet.getDynamicsInfo(world._bodies[1], -1, physicsClientId=world._client)[2] == inertia


@pytest.mark.parametrize("kept", [0.0, 0.9, 0.999])
def test_damping_takes_its_share_of_a_second_whatever_the_time_step_becomes(kept):
    # A block that falls freely: what is level of its velocity is left by (1 - d)^t.
    asm = assembly([box((-5, -5, -60), (5, 5, -50)), box((0, 0, 0), (1, 1, 1))], gravity=DOWN)
    with World(asm, Settings(time_step=2e-3), [Pulse((1e-9, 0, 0), 1.0, start=50.0)]) as world:
        world.damp(1 - kept)
        world.set_time_step(5e-4)
        world.set_velocity(1, np.array([3.0, 0, 0]), np.zeros(3))
        for _ in range(5):
            world.advance()
        assert world.velocities()[0][1, 0] == pytest.approx(3.0 * kept**0.1, rel=1e-3)


def test_loads_leave_the_verdict_without_them_as_it_was():
    asm = arch(9, 0.2)
    plain, same = verify(asm), verify(asm, loads=[])
    np.testing.assert_array_equal(plain.run.displacement, same.run.displacement)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Tilt((0, 0, 0), 5), r"tilt: axis is \(0, 0, 0\); it must be three numbers, not all zero"),
        (lambda: Tilt((0, 1, 0), 5, rate=0), "tilt: rate is 0; it must be above 0"),
        (lambda: Settlement("left", (0, 0), 0.1), "settlement: path is"),
        (lambda: Settlement("left", (0, 0, 1), -1), "settlement: speed is -1"),
        (lambda: Removal("a", -1), "removal: time is -1; it must be a number of at least 0"),
        (lambda: Push("a"), "push: a velocity or an impulse is needed"),
        (lambda: Push("a", velocity=(1, 0, np.nan)), "push: velocity"),
        (lambda: Push("a", velocity=(1, 0, 0), point=(0, 0, 0)), "push: a point goes with an impulse"),
        (lambda: Ramp((1, 0, 0), 0), "ramp: duration is 0"),
        (lambda: Pulse((1, 0, 0), 1, "square"), "pulse: shape is 'square'; it must be one of: rectangle"),
        (lambda: Record(np.array([0.0, 0.0]), np.ones((2, 3))), "record: times must grow"),
        (lambda: Record(np.array([0.0, 1.0]), np.ones((2, 2))), "record: times have shape"),
        (lambda: verify(stack(2), loads=[Removal("key")]), 'removal: no block "key"; blocks are: ground, stone0'),
        (lambda: verify(stack(2), loads=[Removal(["stone0", "stone1"])]), "removal: nothing that can move is left"),
        (
            lambda: verify(stack(2), loads=[Removal("stone0"), Removal("stone1", time=0.5)]),
            "removal: nothing that can move is left",
        ),
        (
            lambda: Constant((1, 0, np.nan)),
            r"constant: load is \(1, 0, nan\); it must be an acceleration of three finite",
        ),
        (lambda: Constant((1, 0)), r"constant: load is \(1, 0\); it must be"),
        (lambda: Constant([1, [0, 0]]), r"constant: load is \[1, \[0, 0\]\]; it must be"),
        (
            lambda: verify(stack(2), loads=[Constant(np.ones((2, 6)))]),
            r"constant: load has shape \(2, 6\); it must be \(3,\) or \(3, 6\)",
        ),
        (lambda: verify(stack(2), loads=[Tilt((0, 1, 1), 5)]), r"tilt: axis is \[0.0, 1.0, 1.0\]; it must be at right"),
        (lambda: Push("a", velocity=("x", 0, 0)), r"push: velocity is \('x', 0, 0\); it must be three numbers"),
        (lambda: Push("a", velocity=((1, 0), 0, 0)), r"push: velocity is .*; it must be three numbers"),
        (lambda: verify(stack(2), loads=[Push("ground", velocity=(1, 0, 0))]), 'push: "ground" is a support'),
        (lambda: verify(stack(2), loads=[Settlement(1, (0, 0, 1), 1)]), 'settlement: "stone0" is no support'),
    ],
)
def test_bad_loads(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_a_rocking_block_is_watched_until_it_rests():
    asm = stack(1, 0.5, 2.0, gravity=DOWN, friction=2.0)
    verdict = verify(asm, loads=[Pulse((5.0, 0, 0), 0.17)])
    peak = np.linalg.norm(verdict.run.since_release[:, 1], axis=1).max()
    assert verdict.outcome is STANDS
    assert peak > 0.05
    assert np.linalg.norm(verdict.displacement[1]) < 0.1 * peak


def test_a_run_tells_how_far_it_is():
    told = []
    pulse = Pulse((1.0, 0, 0), duration=0.2)
    verdict = verify(stack(2), loads=[pulse], progress=lambda *times: told.append(times))
    passed, change, latest = np.array(told).T
    assert passed[0] == 0
    assert (np.diff(passed) > 0).all()
    assert passed[-1] == verdict.run.times[-1]
    assert (change == change[0]).all()
    assert pulse.end <= change[0] < pulse.end + 2 * np.diff(passed).max()
    assert (latest == latest[0]).all()
    assert passed[-1] <= latest[0]


def test_a_fall_that_needs_no_settlement_says_so():
    ground = [box((-1, -1, -1), (0.2, 2, 0), name="ground"), box((5, 0, -1), (6, 1, 0), name="far")]
    leaning = Assembly.from_blocks([*ground, box((0, 0, 0), (0.5, 0.5, 2), name="pillar")], supports=["ground", "far"])
    verdict = verify(leaning, loads=[Settlement("far", (0, 0, -0.01), 0.02)])
    assert verdict.outcome.word == "falls"
    assert verdict.summary()["falls_alone"] is True
    assert "without the loads that change, too" in verdict.explain().splitlines()[1]


def test_a_fall_by_a_lost_block_or_beside_a_lasting_load_is_told_apart():
    blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 1), name="foot")]
    tower = Assembly.from_blocks([*blocks, box((0, 0, 1), (1, 1, 3), name="head")], supports=["ground"])
    lost = Removal("foot")
    assert not verify(tower, loads=[lost]).falls_alone
    # A push of seven tenths of the weight turns the tower over its edge, whatever is lost.
    assert verify(tower, loads=[Constant((7.0, 0, 0)), lost]).falls_alone


def test_supports_that_settle_together_leave_the_same_room_to_fall_in_one_load_or_in_ten():
    """The supports go down by 50 mm, and one block by .4 m more: beyond its size of .3 m and these 50 mm."""
    pads = [box((i, 0, -1), (i + 0.9, 1, 0), name=f"pad{i}") for i in range(10)]
    cubes = [box((i + 0.3, 0.3, 0), (i + 0.6, 0.6, 0.3), name=f"cube{i}") for i in range(1, 10)]
    tower = [box((0.3, 0.3, 0), (0.6, 0.6, 0.4), name="prop"), box((0.3, 0.3, 0.4), (0.6, 0.6, 0.7), name="top")]
    names = [pad.name for pad in pads]
    asm = Assembly.from_blocks([*pads, *cubes, *tower], supports=names)
    down, lost = (0, 0, -0.05), Removal("prop", time=1.5)
    for settling in ([Settlement(names, down, 0.05)], [Settlement(name, down, 0.05) for name in names]):
        found = verify(asm, loads=[*settling, lost])
        assert (found.outcome.word, round(found.brick_threshold, 9)) == ("falls", 0.35)


@pytest.mark.parametrize(("wrong", "words"), [
    (lambda asm: verify(asm, actions=[Pulse((1, 0, 0), 0.2)]), "is a load; it must be given as one of the loads"),
    (lambda asm: verify(asm, actions=[InertiaScale]), "is no action"),
    (lambda asm: verify(asm, settings="careful"), r"they must be Settings.named\('careful'\)"),
    (lambda asm: simulate(asm, loads=[Push([0, 1], velocity=(1, 0, 0))]), "push: block is .*; it must be one block"),
    (lambda asm: simulate(asm, loads=[Removal(None)]), "removal: None is neither a block's index nor its name"),
    (lambda asm: simulate(asm, hold=float("nan")), "hold is nan; it must be a number of at least 0"),
    (lambda asm: Settlement(0, [[0, 0, -0.1], [0, 0.1]], 0.1), "settlement: path is .* displacements of three numbers"),
    (lambda asm: Tilt((0, 1, 0), "10"), "tilt: to is '10'; it must be a finite number"),
    (lambda asm: verify_many(asm), "one assembly is given"),
    (lambda asm: verify_many([asm], jobs=1.5), "jobs is 1.5; it must be a whole number"),
    (lambda asm: run_many(abs, [1, 2], names=["one"], jobs=1), "names: there are 1 for 2 arguments"),
])  # fmt: skip
def test_what_is_no_load_and_no_action_is_refused_by_name(wrong, words):
    with pytest.raises(InputError, match=words):
        wrong(stack(1))
