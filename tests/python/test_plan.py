import gc
import os
import signal
import threading
import time

import numpy as np
import pytest

import trunnion
from conftest import SHARED, refused, zigzag

CASES = SHARED / 'data/cases'


@pytest.mark.skipif(not CASES.exists(), reason='no shared cases')
@pytest.mark.parametrize('name, seconds', [('line', 1.283), ('fillet', 3.381)])
def test_known_cycle_times(name, seconds):
    import json
    case = next(c for c in json.loads((CASES / 'cases.json').read_text()) if c['name'] == name)
    machine, setup = trunnion.machine(CASES / case['machine']), trunnion.setup(CASES / case['setup'])
    program = trunnion.read_program(CASES / case['program'], machine=machine)
    tolerance = dict(tip_tolerance_mm=0.01, orientation_tolerance_deg=0.1)
    plan = trunnion.plan(program, machine, setup, **tolerance)
    assert plan.cycle_time_s == pytest.approx(seconds, abs=2e-3)
    assert plan.summary['cycle_time_s'] == plan.cycle_time_s and plan.usable
    assert trunnion.check(plan, program, machine, setup, **tolerance)['ok']


@pytest.fixture(scope='module')
def plan(waves, trt, setup):
    return trunnion.plan(waves, trt, setup, path=True)


def test_setpoints(plan, waves, trt, setup):
    assert plan.columns == ['t_s', 'X_mm', 'Y_mm', 'Z_mm', 'A_deg', 'C_deg', 'line', 's_mm', 'feed_mm_min']
    rows = plan.setpoints
    assert rows.dtype == np.float64 and rows.flags.c_contiguous and rows.shape[1] == 9
    assert np.shares_memory(plan['X_mm'], rows) and plan.setpoints is rows
    np.testing.assert_allclose(np.diff(plan['t_s']), 1e-3, atol=1e-12)
    tips, axes = trt.forward(rows[:, 1:6], setup)
    np.testing.assert_allclose(tips[0], waves.positions_mm[0], atol=1e-6)
    np.testing.assert_allclose(tips[-1], waves.positions_mm[-1], atol=1e-6)
    np.testing.assert_allclose(axes[-1], waves.axes[-1], atol=1e-6)
    verdict = trunnion.check(rows, waves, trt, setup)
    assert verdict['ok'] and verdict['tip_deviation_mm'] <= 0.02 and verdict['rows'] == len(rows)
    peaks = [np.abs(np.diff(plan[c], 3)).max() / 1e-9 / a['limits']['jerk'] for c, a in zip(trt.columns, trt.axes)]
    assert 0.9 < max(peaks) <= 1.001
    with pytest.raises(KeyError):
        plan['B_deg']


def test_a_broken_limit_is_told(plan, waves, trt, setup):
    rows = plan.setpoints.copy()
    rows[len(rows) // 2, 1] += 0.01
    verdict = trunnion.check(rows, waves, trt, setup)
    assert not verdict['ok'] and any('X' in breach['what'] for breach in verdict['broken'])


def test_path_samples(plan):
    assert plan.path.shape[1] == len(plan.path_columns) == 11 + 4 * 5
    p, speed = plan.path_column('p_mm'), plan.path_column('speed_mm_s')
    assert (np.diff(p) >= 0).all() and (speed <= plan.path_column('speed_limit_mm_s') * 1.001).all()
    moved = np.diff(p) > 1e-9
    slope = np.diff(plan.path_column('A'))[moved] / np.diff(p)[moved]
    middle = 0.5 * (plan.path_column('A_p')[1:] + plan.path_column('A_p')[:-1])[moved]
    np.testing.assert_allclose(slope, middle, atol=0.02 * np.abs(middle).max())


def test_programmed_poses(waves, trt, setup):
    poses = trunnion.programmed_poses(waves, trt, setup)
    np.testing.assert_allclose(poses['tips_mm'], waves.positions_mm, atol=1e-12)
    np.testing.assert_allclose(poses['axes'], waves.axes, atol=1e-12)
    assert poses['kinds'][1:] == ['vector'] * (len(waves) - 1) and len(poses['lines']) == len(waves)


def test_two_threads_give_the_same_bits(plan, waves, trt, setup):
    assert np.array_equal(trunnion.plan(waves, trt, setup, threads=2).setpoints, plan.setpoints)


def test_options_count(plan, waves, trt, setup):
    slow = trunnion.plan(waves, trt, setup, feed_override=0.25, period_s=0.004)
    assert slow.cycle_time_s > 1.5 * plan.cycle_time_s and slow.period_s == 0.004 and slow.path is None
    stops = trunnion.plan(waves, trt, setup, rounding='none', feed_mm_min=6000)
    assert stops.summary['exact_stops']['total'] > 100 and stops.cycle_time_s > plan.cycle_time_s


def test_arrays_outlive_the_plan(waves, trt, setup):
    column = trunnion.plan(waves, trt, setup, period_s=0.01)['X_mm']
    kept = column.copy()
    gc.collect()
    waste = [trunnion.plan(waves, trt, setup, period_s=0.01) for _ in range(2)]
    np.testing.assert_array_equal(column, kept)
    assert waste


@pytest.fixture(scope='module')
def long_program():
    tips, axes = zigzag(passes=150)
    return trunnion.program_from_poses(tips, axes, feed_mm_min=3000)


def test_other_threads_run_meanwhile(waves, trt, setup):
    counted, done = 0, threading.Event()

    def count():
        nonlocal counted
        while not done.is_set():
            counted += 1
            time.sleep(0)

    thread = threading.Thread(target=count)
    thread.start()
    try:
        before = counted
        trunnion.plan(waves, trt, setup)
        during = counted - before
    finally:
        done.set()
        thread.join()
    assert during > 100  # holding the GIL it were none or one


def test_ctrl_c(long_program, trt, setup):
    interrupt = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    shares = []
    interrupt.start()
    with pytest.raises(KeyboardInterrupt):
        trunnion.plan(long_program, trt, setup, progress=shares.append)
    interrupt.join()
    assert not shares or shares[-1] < 0.9
    assert trunnion.plan(trunnion.program_from_poses(np.eye(3), [[0, 0, 1]] * 3, feed_mm_min=600), trt, setup).usable


def test_progress(long_program, trt, setup):
    class Enough(Exception):
        pass

    shares = []

    def stop_soon(share):
        shares.append(share)
        if len(shares) == 3:
            raise Enough

    with pytest.raises(Enough):
        trunnion.plan(long_program, trt, setup, progress=stop_soon)
    assert len(shares) == 3 and shares == sorted(shares) and 0 <= shares[0] and shares[-1] < 1


@pytest.mark.parametrize('code, name, options', [
    ('PY0002', 'tip_tolerance_mm', dict(tip_tolerance_mm=float('nan'))),
    ('PY0001', 'tip_tolerance_mm', dict(tip_tolerance_mm='20um')),
    ('PY0001', 'calm', dict(calm=[0.1])),
    ('PY0001', 'threads', dict(threads=1.5)),
    ('PY0003', 'threads', dict(threads=2**70)),
    ('PY0001', 'worth', dict(worth=1)),
    ('PY0004', 'rounding', dict(rounding='round')),
    ('PY0001', 'setup', dict(setup={'tool': {}})),
    ('PIPE0001', '', dict(period_s=0)),
    ('PIPE0001', '', dict(feed_override=-1)),
    ('PIPE0001', '', dict(threads=3)),
    ('FEED0001', '', dict(calm=-1))])
def test_options_that_are_none(waves, trt, code, name, options):
    with refused(code, name):
        trunnion.plan(waves, trt, **options)


def test_unknown_options_and_objects(waves, trt):
    with pytest.raises(TypeError, match='tip_tolerance'):
        trunnion.plan(waves, trt, tip_tolerance=0.1)
    with pytest.raises(TypeError):
        trunnion.plan('part.ngc', trt)
    with pytest.raises(TypeError):
        trunnion.plan(None, None)


def test_setpoints_that_are_none(waves, trt, setup, plan):
    with refused('PY0001', 'setpoints'):
        trunnion.check(np.zeros((5, 3)), waves, trt, setup)
    with refused('PY0002', 'setpoints'):
        trunnion.check(np.full((5, 9), np.nan), waves, trt, setup)
    with refused('PY0003', 'setpoints'):
        trunnion.check(np.full((5, 9), -1.0), waves, trt, setup)
    with refused('VER0206'):
        trunnion.check(plan.setpoints[[0, 1, 5]], waves, trt, setup)
    with refused('VER0201'):
        trunnion.check(np.zeros((0, 9)), waves, trt, setup)
    with refused('PY0003', 'name'):
        trunnion.plan(trunnion.program_from_poses(np.eye(3), [[0, 0, 1]] * 3, feed_mm_min=600), trt).path_column('p_mm')
