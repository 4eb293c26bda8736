import csv
import math

import numpy as np
import pytest

import trunnion
from conftest import EXAMPLES, refused


def dense(points=400):
    """A fan of tool axes along a sine, in short blocks."""
    t = np.linspace(0, 2 * np.pi, points)
    tips = np.column_stack([8 * t, 5 * np.sin(t), 0 * t]).round(3)
    tilt = np.radians(20 + 5 * np.sin(2 * t))
    return tips, np.column_stack([0 * t, np.sin(tilt), np.cos(tilt)])


def test_smoothing(trt, setup):
    program = trunnion.program_from_poses(*dense(), feed_mm_min=2000)
    smooth, facts = trunnion.smooth(program, trt, setup, tip_tolerance_mm=0.02)
    assert 0 < facts['tip_deviation_mm'] <= 0.015 and len(smooth) < len(program)
    assert facts['written_moves'] < facts['smoothed_moves']
    with refused('PIPE0016'):
        trunnion.smooth(program, trt, setup, tip_tolerance_mm=0)
    with refused('PY0004', 'form'):
        trunnion.smooth(program, trt, form='splines')


def past_the_pole():
    x = np.linspace(-20, 20, 41)
    axes = np.column_stack([0.02 * x, np.full(41, 0.02), np.ones(41)])
    return np.column_stack([x, 0 * x, 0 * x]), axes / np.linalg.norm(axes, axis=1)[:, None]


def test_past_the_pole_and_less_turning(trt, setup):
    tips, axes = past_the_pole()
    program = trunnion.program_from_poses(tips, axes, feed_mm_min=110)
    calm, stretches = trunnion.avoid_pole(program, trt, setup, orientation_tolerance_deg=3)
    assert stretches[0]['before'] > 1 >= stretches[0]['after'] * 0.999 and len(calm) > 2
    assert 0 < stretches[0]['orientation_change_deg'] <= 3.001
    less, stretches = trunnion.reduce_rotary(program, trt, setup, orientation_tolerance_deg=1)
    assert stretches[0]['after'] <= stretches[0]['before']
    with refused('DEFO0203'):
        trunnion.avoid_pole(program, trt, setup, orientation_tolerance_deg=1e-4)
    with refused('PY0003', 'chord_tolerance_mm'):
        trunnion.avoid_pole(program, trt, setup, chord_tolerance_mm=0.01)


def guide_curves():
    rows = {}
    with open(EXAMPLES / '07_flank/blade.csv') as file:
        for row in csv.DictReader(file):
            rows.setdefault(int(row['row']), []).append([float(row[k]) for k in ('x_mm', 'y_mm', 'z_mm')])
    return [np.array(rows[k]) for k in sorted(rows)]


def test_flank_and_deflection():
    machine, setup = trunnion.machine('ucp710'), trunnion.setup(EXAMPLES / '07_flank/setup.toml')
    program = trunnion.read_program(EXAMPLES / '07_flank/blade.cls', machine=machine)
    better, stretches = trunnion.deform_flank(program, machine, guide_curves(), setup, to_height_mm=30)
    assert stretches[0]['after'] < 0.5 * stretches[0]['before'] and len(better) > 4
    length = np.linalg.norm(np.diff(program.positions_mm, axis=0), axis=1).sum() + 10
    s = np.linspace(0, length, 30)
    bent = np.column_stack([s, 0 * s, 0.05 * np.sin(s / 20), 0 * s])
    _, stretches = trunnion.compensate_deflection(program, machine, bent, setup)
    assert stretches[0]['before'] == pytest.approx(0.05, rel=0.1) and stretches[0]['after'] <= 1e-3
    with refused('PY0001', 'samples'):
        trunnion.compensate_deflection(program, machine, bent[:, :3], setup)
    with refused('PY0001', 'guide_curves_mm'):
        trunnion.deform_flank(program, machine, 7, setup)
    with refused('PIPE0022'):
        trunnion.deform_flank(program, machine, guide_curves(), to_height_mm=30)


def test_a_dual_path():
    tips, axes = dense(40)
    path = trunnion.DualPath(tips, axes)
    at, axis = path.poses(path.fit['parameters'])
    np.testing.assert_allclose(at, tips, atol=1e-9)
    np.testing.assert_allclose(axis, axes, atol=1e-9)
    near = trunnion.DualPath(tips, axes, tip_tolerance_mm=0.05, orientation_tolerance_deg=0.1)
    assert 0 < near.fit['tip_deviation_mm'] <= 0.05
    assert len(near.spline.bottom.knots) < len(path.spline.bottom.knots)
    u = np.linspace(0, 1, 40)**1.1
    own = trunnion.DualPath(tips, axes, parameters=u)
    assert (own.begin, own.end) == (0, 1)
    np.testing.assert_allclose(own.poses(u)[0], tips, atol=1e-9)
    weights = np.where(np.arange(40) == 20, 1000.0, 1.0)
    drawn = trunnion.DualPath(tips, axes, tip_tolerance_mm=0.3, orientation_tolerance_deg=0.5, weights=weights)
    even = trunnion.DualPath(tips, axes, tip_tolerance_mm=0.3, orientation_tolerance_deg=0.5)
    off = [np.linalg.norm(one.poses(one.fit['parameters'][20])[0] - tips[20]) for one in (drawn, even)]
    assert off[0] < 0.5 * off[1]
    for code, name, options in [('PY0001', 'parameters', dict(parameters=u[:-1])), ('PY0001', 'parameters', dict(parameters=[])),
                                ('PY0001', 'weights', dict(weights=[1])), ('PY0002', 'parameters', dict(parameters=u * np.nan)),
                                ('DEFO0105', '', dict(parameters=u[::-1]))]:
        with refused(code, name):
            trunnion.DualPath(tips, axes, **options)
    with refused('DEFO0101'):
        trunnion.DualPath(tips[:2], axes[:2])
    with refused('PY0003', 'axes'):
        trunnion.DualPath(tips, 2 * axes)


def test_the_side_of_a_tool():
    # A cylinder of radius 5 stands beside a plane wall and goes along it: no deviation; 0.1 mm off: 0.1 mm.
    x = np.linspace(0, 40, 9)
    rows = [np.column_stack([x, 0 * x, 0 * x]), np.column_stack([x, 0 * x, 0 * x + 20])]
    wall = trunnion.GuidedSurface(rows, side='against')
    normal = wall.surface.shape(0.5 * sum(wall.surface.domain[0]), 0.5, side='against')['normal']
    tool = trunnion.FlankTool('cylinder', 5)
    tips, axes = trunnion.two_point_poses(wall, tool, 12)
    np.testing.assert_allclose(tips[:, 1], 5 * normal[1], atol=1e-6)
    path = trunnion.DualPath(tips + 0.1 * normal, axes)
    found = trunnion.deviation_map(path, tool, wall, to_height_mm=18)
    assert found['deviation_mm'].shape == (len(found['u']), len(found['height_mm']))
    np.testing.assert_allclose(found['deviation_mm'], 0.1, atol=1e-6)
    better, facts = trunnion.deform_flank_path(path, tool, wall, to_height_mm=18)
    assert facts['after']['peak_mm'] < 1e-3 < facts['before']['peak_mm'] and better.begin == path.begin
    with refused('DEFO0111'):
        trunnion.deviation_map(path, tool, wall, from_height_mm=9, to_height_mm=3)
    with refused('PY0003', 'heights'):
        trunnion.deviation_map(path, tool, wall, heights=1)
    with refused('DEFO0112'):
        trunnion.GuidedSurface(rows[:1])


def test_singular_cones(trt):
    cones = trunnion.singular_cones(trt, 10)
    assert len(cones) == 2 and all(cone['pole'] for cone in cones)
    assert abs(cones[0]['direction'][2]) == pytest.approx(1)
    velocity = next(axis for axis in trt.axes if axis['letter'] == 'C')['limits']['velocity']
    assert math.sin(math.radians(cones[0]['half_angle_deg'])) == pytest.approx(10 / velocity, rel=1e-3)
    with refused('PY0003', 'turn_rate_deg_s'):
        trunnion.singular_cones(trt, 0)
