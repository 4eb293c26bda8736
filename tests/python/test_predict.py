import numpy as np
import pytest

import trunnion
from conftest import EXAMPLES, refused


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


def test_controls_that_are_none(blade, trt):
    with refused('FILE0118'):
        trunnion.controller('none')
    with refused('FILE0103'):
        trunnion.controller({'name': 'nothing'})
    control = trunnion.controller(EXAMPLES / '04_prediction/old_control.toml')
    with refused('CTRL0206'):
        trunnion.predict(blade, trt, control, feed_override=-1)
    with refused('PY0001', 'samples'):
        trunnion.predict(blade, trt, control, samples='p.csv')
