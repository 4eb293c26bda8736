import numpy as np
import pytest

import trunnion
from conftest import EXAMPLES, refused, zigzag


def test_a_control(blade, trt, setup):
    control = trunnion.controller('lavernhe-2006')
    assert 'lavernhe-2006' in trunnion.controllers() and control.kind == 'blocks'
    found = trunnion.predict(blade, trt, control, setup, uncertainty=False, samples=True)
    summary = found.summary
    assert summary['cycle_time_s'] == found.cycle_time_s > 0 and summary['uncertainty_s'] is None
    assert found.samples.shape[1] == len(found.columns) and (np.diff(found.samples[:, 0]) >= 0).all()
    assert found.samples[-1, 0] <= found.cycle_time_s + 1e-6
    lines = found.line_times
    assert lines[:, 2].sum() == pytest.approx(found.cycle_time_s, rel=0.05) and set(lines[:, 0]) <= set(range(1000))
    half = trunnion.predict(blade, trt, control, setup, uncertainty=False, feed_override=0.5)
    assert half.cycle_time_s > found.cycle_time_s and half.samples is None


def test_the_ideal_control_is_the_plan(waves, trt, setup):
    ideal = trunnion.predict(waves, trt, trunnion.controller('ideal'), setup)
    assert ideal.cycle_time_s == pytest.approx(trunnion.plan(waves, trt, setup).cycle_time_s, abs=2e-3)


def turning_about_x():
    """A tool that turns about X while its tip goes along Y: A alone turns."""
    tilt = np.radians(np.linspace(5, 35, 61))
    tips = np.column_stack([0 * tilt, np.linspace(0, 30, 61), 0 * tilt])
    return trunnion.program_from_poses(tips, np.column_stack([0 * tilt, -np.sin(tilt), np.cos(tilt)]), feed_mm_min=1200)


@pytest.mark.parametrize('lead_deg', [0, 20])
def test_the_feed_at_the_contact_of_our_own_plan(trt, lead_deg):
    """Against the contact's place in the tool by hand: V_A = V_B + Omega x AB, all in one plane."""
    setup = trunnion.setup({'tool': {'kind': 'ball', 'diameter': '12 mm', 'length': '50 mm'}})
    found = trunnion.predict(turning_about_x(), trt, trunnion.controller('ideal'), setup, samples=True, contact_tilt_deg=lead_deg)
    rows = dict(zip(found.columns, found.samples.T))
    tips, axes = trt.forward(found.samples[:, 1:6], setup)
    axis, step = 0.5 * (axes[1:] + axes[:-1]), np.diff(rows['t_s'])[:, None]
    velocity, omega = np.diff(tips, axis=0) / step, np.cross(axis, np.diff(axes, axis=0) / step)
    ahead = velocity - (velocity * axis).sum(1)[:, None] * axis
    ahead /= np.maximum(np.linalg.norm(ahead, axis=1), 1e-12)[:, None]
    lead = np.radians(lead_deg)
    arm = 6 * ((1 - np.cos(lead)) * axis + np.sin(lead) * ahead)
    expected = 60 * np.linalg.norm(velocity + np.cross(omega, arm), axis=1)
    moving = rows['feed_mm_min'][1:] > 100
    np.testing.assert_allclose(rows['contact_feed_mm_min'][1:][moving], expected[moving], rtol=5e-3)
    apart = np.abs(expected - 60 * np.linalg.norm(velocity, axis=1))[moving].max()
    assert apart < 1e-6 if lead_deg == 0 else apart > 20
    bare = trunnion.predict(turning_about_x(), trt, trunnion.controller('ideal'), samples=True)
    assert np.isnan(bare.samples[:, bare.columns.index('contact_feed_mm_min')]).all()


@pytest.mark.parametrize('name, threads, size', [('ideal', 1, (30, 60)), ('ideal', 2, (30, 60)), ('lavernhe-2006', 1, (150, 200))])
def test_progress_and_an_end_before_the_end(trt, setup, name, threads, size):
    class Enough(Exception):
        pass

    tips, axes = zigzag(*size)  # long enough to be asked on the way
    program, control, shares = trunnion.program_from_poses(tips, axes, feed_mm_min=3000), trunnion.controller(name), []
    options = dict(uncertainty=False, threads=threads)
    trunnion.predict(program, trt, control, setup, progress=shares.append, **options)
    assert shares and shares == sorted(shares) and 0 <= shares[0] and shares[-1] <= 1

    def stop(share):
        raise Enough

    with pytest.raises(Enough):
        trunnion.predict(program, trt, control, setup, progress=stop, **options)
    assert trunnion.predict(turning_about_x(), trt, control, setup, **options).cycle_time_s > 1


def test_controls_that_are_none(blade, trt):
    with refused('FILE0118'):
        trunnion.controller('none')
    with refused('FILE0103'):
        trunnion.controller({'name': 'nothing'})
    control = trunnion.controller(EXAMPLES / '04_prediction/old_control.toml')
    with refused('CTRL0206'):
        trunnion.predict(blade, trt, control, feed_override=-1)
    for name in ('ideal', 'lavernhe-2006'):
        with refused('CTRL0204'):
            trunnion.predict(blade, trt, trunnion.controller(name), contact_tilt_deg=90)
    with refused('PY0001', 'samples'):
        trunnion.predict(blade, trt, control, samples='p.csv')
