"""Stretches of a path, the speed along them, and motion period by period."""
import numpy as np
import pytest

import trunnion
from conftest import refused

PERIOD = 1e-3


@pytest.fixture(scope='module')
def stretch(waves, trt, setup):
    found = trunnion.stretches(waves, trt, setup)
    assert len(found) == 1 and not found[0].rapid
    return found[0]


@pytest.fixture(scope='module')
def profile(stretch):
    return trunnion.plan_stretch(stretch)


def largest_ratios(rows, machine):
    """Peak of the first three differences of axis positions, a row a period, of the limits."""
    out = []
    for order, name in enumerate(('velocity', 'acceleration', 'jerk'), 1):
        limits = np.array([axis['limits'][name] for axis in machine.axes])
        out.append((np.abs(np.diff(rows, order, axis=0)) / PERIOD**order / limits).max())
    return out


def test_the_path_is_the_program_s(stretch, waves, trt, setup):
    ends = stretch.blocks['p_mm']
    assert (ends[1:, 0] == ends[:-1, 1]).all() and ends[-1, 1] == pytest.approx(stretch.length_mm)
    assert stretch.blocks['line'].tolist() == list(range(2, len(waves) + 1))
    tips, axes = stretch.poses(ends[:, 1])
    off = np.linalg.norm(tips[:, 0] - waves.positions_mm[1:], axis=1)
    assert 0 < off.max() - 1e-9 <= stretch.deviation['tip_mm'] <= 0.02 and stretch.deviation['orientation_deg'] <= 0.1
    positions = stretch.axes(ends[:, 1])[:, 0]
    np.testing.assert_allclose(trt.forward(positions, setup)[0], tips[:, 0], atol=1e-9)
    np.testing.assert_allclose(trt.forward(positions, setup)[1], axes[:, 0], atol=1e-9)


def test_derivatives_against_differences(stretch):
    h, p = 1e-3, np.linspace(1, stretch.length_mm - 1, 50)
    before, at, behind = (stretch.axes(p + k * h) for k in (-1, 0, 1))
    for order in (1, 2, 3):
        slope = (behind[:, order - 1] - before[:, order - 1]) / (2 * h)
        np.testing.assert_allclose(at[:, order], slope, atol=3e-2 * np.abs(slope).max())


def test_the_speed_is_that_of_the_plan(profile, stretch, waves, trt, setup):
    plan = trunnion.plan(waves, trt, setup)
    assert profile.duration_s == pytest.approx(plan.cycle_time_s, abs=2 * PERIOD) and profile.jerk_free_bound_s < profile.duration_s
    time = np.arange(0, profile.duration_s, PERIOD)
    states = profile.state(time)
    np.testing.assert_allclose(np.gradient(states[:, 0], PERIOD)[1:-1], states[1:-1, 1], atol=0.05)
    ratios = largest_ratios(stretch.axes(states[:, 0])[:, 0], trt)
    assert 0.9 < max(ratios) <= 1.001
    peaks = [max(of.values()) for of in profile.peaks.values()]
    assert max(peaks) == pytest.approx(1, abs=2e-2)
    pieces = profile.pieces
    np.testing.assert_allclose(pieces['begin_s'][1:], (pieces['begin_s'] + pieces['duration_s'])[:-1], atol=1e-12)
    assert (pieces['begin_s'] + pieces['duration_s'])[-1] == profile.duration_s
    assert len(pieces['cause']) == len(pieces['p_mm']) and set(pieces['cause']) & {'feed', 'A jerk', 'X jerk', 'Z jerk', 'Y jerk'}
    assert trunnion.plan_stretch(stretch, jerk_margin=0.5).duration_s > profile.duration_s


def moved(planner, most=100_000):
    """States until it stands; a command takes two periods to begin."""
    states = [planner.tick() for _ in range(3)]
    while states[-1]['status'] == 'moving' and len(states) < most:
        states.append(planner.tick())
    return states


def test_period_by_period(profile, stretch, trt):
    states = moved(trunnion.LivePlanner(stretch))
    assert states[-1]['status'] == 'finished' and states[-1]['p_mm'] == pytest.approx(stretch.length_mm, abs=1e-9)
    assert len(states) * PERIOD == pytest.approx(profile.duration_s, rel=0.02)
    assert max(largest_ratios(np.array([s['axes'] for s in states]), trt)) <= 1.001
    assert [s['line'] for s in states] == sorted(s['line'] for s in states)


def test_the_operator(stretch, profile, trt, setup):
    planner, axes = trunnion.LivePlanner(stretch), []
    for _ in range(400):
        axes.append(planner.tick()['axes'])
    planner.hold()
    held = moved(planner)
    assert held[-1]['status'] == 'holding' and held[-1]['speed_mm_s'] == 0 and len(held) < 500
    assert planner.tick()['p_mm'] == held[-1]['p_mm']
    planner.resume()
    planner.set_feed_override(0.1)
    slow = [planner.tick() for _ in range(600)]
    fastest = profile.state(np.arange(0, profile.duration_s, PERIOD))[:, 1].max()
    assert 0 < max(s['speed_mm_s'] for s in slow[300:]) < 0.3 * fastest
    planner.set_feed_override(1)
    planner.set_largest_speed(0.2 * fastest)
    capped = [planner.tick() for _ in range(400)]
    tips = trt.forward(np.array([s['axes'] for s in capped[200:]]), setup)[0]
    assert 0.19 < np.linalg.norm(np.diff(tips, axis=0), axis=1).max() / PERIOD / fastest < 0.2001
    planner.set_largest_speed(1e6)
    planner.set_single_block(True)
    stop = moved(planner)
    assert stop[-1]['status'] == 'holding'
    assert np.abs(stretch.blocks['p_mm'][:, 1] - stop[-1]['p_mm']).min() < 1e-6
    planner.set_single_block(False)
    planner.resume()
    rest = moved(planner)
    assert rest[-1]['status'] == 'finished'
    axes += [s['axes'] for s in [*held, *slow, *capped, *stop, *rest]]
    assert max(largest_ratios(np.array(axes), trt)) <= 1.001


def test_what_is_refused(stretch, profile, waves, trt):
    planner = trunnion.LivePlanner(stretch)
    for code, name, call in [('FEED0010', '', lambda: planner.set_feed_override(3)),
                             ('FEED0010', '', lambda: planner.set_rapid_override(-1)),
                             ('FEED0010', '', lambda: planner.set_largest_speed(-1)),
                             ('PY0002', 'factor', lambda: planner.set_feed_override(float('nan'))),
                             ('PY0001', 'on', lambda: planner.set_single_block(1)),
                             ('FEED0011', '', lambda: trunnion.LivePlanner(stretch, period_s=0)),
                             ('FEED0001', '', lambda: trunnion.plan_stretch(stretch, calm=-1)),
                             ('PY0003', 'p_mm', lambda: stretch.axes(stretch.length_mm + 1)),
                             ('PY0003', 'p_mm', lambda: stretch.poses([-1])),
                             ('PY0002', 'p_mm', lambda: stretch.poses([np.nan])),
                             ('PY0003', 'time_s', lambda: profile.state(-1)),
                             ('PY0003', 'time_s', lambda: profile.state(profile.duration_s + 1)),
                             ('PY0001', 'setup', lambda: trunnion.stretches(waves, trt, 'setup.toml'))]:
        with refused(code, name):
            call()
    for call in (trunnion.LivePlanner, trunnion.plan_stretch, lambda none: trunnion.stretches(none, trt), trunnion.Kinematics):
        with pytest.raises(TypeError):
            call(None)
    with pytest.raises(TypeError, match='feed_override'):
        trunnion.plan_stretch(stretch, feed_override=1)


def test_stretches_outlive_what_they_came_from():
    tips, axes = np.array([[0, 0, 0], [9, 0, 0], [9, 9, 0.0]]), [[0, 0.6, 0.8]] * 3
    found = trunnion.stretches(trunnion.program_from_poses(tips, axes, feed_mm_min=600, exact_stop=[False, True, False]),
                               trunnion.machine('xyzac-trt'), trunnion.setup({'tool': {'length': '30 mm'}}))
    assert [one.length_mm for one in found] == pytest.approx([9, 9])
    assert trunnion.plan_stretch(found[1]).duration_s > 0.9
    np.testing.assert_allclose(found[1].poses(9.0)[0][0], tips[2], atol=1e-9)
