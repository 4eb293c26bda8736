import math

import numpy as np
import pytest

import trunnion
from conftest import EXAMPLES, refused


def hump(radius=60.0, width=24.0):
    """A patch of a cylinder of this radius about Y, as a quadratic in u."""
    a = np.zeros((3, 2, 3))
    a[0, 0] = [-width / 2, 0, -(width / 2)**2 / (2 * radius)]
    a[1, 0] = [width, 0, width * width / (2 * radius)]
    a[2, 0] = [0, 0, -width * width / (2 * radius)]
    a[0, 1] = [0, 20, 0]
    return trunnion.Face(trunnion.BsplineSurface.polynomial(a))


BALL = trunnion.Tool('ball', 10)


@pytest.fixture(scope='module')
def passes():
    return trunnion.plan_surface(hump(), BALL, scallop_mm=0.01)


def test_ridges_are_as_high_as_allowed(passes):
    facts, contacts = passes.facts, passes.contacts
    assert 0.009 < facts['highest_ridge_mm'] <= 0.01
    # On a plane a ball leaves ridges of h for passes √(8 R h) apart.
    assert facts['largest_interval_mm'] == pytest.approx(math.sqrt(8 * 5 * 0.01), rel=0.06)
    assert contacts['first'][-1] == len(contacts['points_mm']) and len(contacts['index']) == facts['passes']
    centre = contacts['tips_mm'] + 5 * contacts['axes']
    np.testing.assert_allclose(centre, contacts['points_mm'] + 5 * contacts['normals'], atol=1e-9)
    verdict = passes.check()
    assert verdict['usable'] and 0.009 < verdict['largest_ridge_mm'] <= 0.01005 and verdict['deepest_mm'] < 0.001
    assert len(passes.program) > facts['passes']


def test_motion_over_the_surface(trt):
    passes = trunnion.plan_surface(hump(), BALL, scallop_mm=0.05, strategy='along-v', borders=False)
    setup = trunnion.setup({'workpiece': {'origin': ['0 mm', '0 mm', '-120 mm']},
                            'tool': {'kind': 'ball', 'diameter': '10 mm', 'length': '80 mm'}})
    plan = trunnion.move_surface(passes, trt, setup, period_s=0.004)
    assert plan.usable and plan.summary['surface']['passes'] == passes.facts['passes']
    tips, _ = trt.forward(plan.setpoints[:, 1:6], setup)
    assert np.linalg.norm(tips[:, None] - passes.contacts['tips_mm'][:1], axis=-1).min() < 1e-3
    with pytest.raises(TypeError, match='feed_mm_min'):
        trunnion.move_surface(passes, trt, setup, feed_mm_min=100)
    with refused('PY0004', 'order'):
        trunnion.move_surface(passes, trt, setup, order='third')


def test_passes_laid_while_moving(trt):
    setup = trunnion.setup({'workpiece': {'origin': ['0 mm', '0 mm', '-120 mm']},
                            'tool': {'kind': 'ball', 'diameter': '10 mm', 'length': '80 mm'}})
    shares, options = [], dict(scallop_mm=0.2, period_s=0.004, tilt_deg=10)
    plan = trunnion.move_surface_ahead(hump(), BALL, trt, setup, progress=shares.append, **options)
    surface = plan.summary['surface']
    assert plan.usable and surface['passes'] > 3 and plan.cycle_time_s > 1
    tips, axes = trt.forward(plan.setpoints[:, 1:6], setup)
    centres = tips + 5 * axes  # 5 mm over the hump in passes, higher up in links
    over = np.hypot(centres[:, 0], centres[:, 2] + 60) - 60
    assert over.min() == pytest.approx(5, abs=0.02)
    with refused('PIPE0001'):
        trunnion.move_surface_ahead(hump(), BALL, trt, setup, place_tolerance_mm=0)
    with pytest.raises(TypeError, match='feed_override'):
        trunnion.move_surface_ahead(hump(), BALL, trt, setup, feed_override=0.5)


def test_files():
    faces = trunnion.read_faces(EXAMPLES / '09_surface/hills.toml')
    assert len(faces) == faces.faces_in_file == 1 and faces[0].facts['area_mm2'] > 0 and faces[-1].number == 1
    with pytest.raises(IndexError):
        faces[1]
    with refused('SURF0102'):
        trunnion.read_faces(EXAMPLES / '09_surface/hills.py')


def test_intervals():
    radius, scallop = 50.0, 0.01
    p = 2 * radius / (radius + scallop) * math.sqrt(2 * radius * scallop + scallop**2)
    assert trunnion.flat_interval_mm(radius, scallop) == pytest.approx(p, rel=1e-12)
    assert trunnion.flat_interval_mm([[10, 20]], scallop).shape == (1, 2)
    along = hump().interval_mm(BALL, 0.5, 0.5, 0.01)
    across = hump().interval_mm(BALL, 0.5, 0.5, 0.01, feed_angle_deg=90)
    assert along == pytest.approx(math.sqrt(8 * 5 * 0.01), rel=0.01) and across < along
    with refused('PY0003', 'radius_mm'):
        trunnion.flat_interval_mm([1, -1], scallop)
    with refused('PY0003', 'scallop_mm'):
        trunnion.flat_interval_mm(1, 0)
    with refused('SURF0201'):
        hump().interval_mm(trunnion.Tool('taper', 10), 0.5, 0.5, 0.01)


def test_chord_steps():
    quarter = trunnion.BsplineCurve(2, [0, 0, 0, 1, 1, 1], [[10, 0, 0], [10, 10, 0], [0, 10, 0]], [1, math.sqrt(0.5), 1])
    steps = trunnion.chord_steps(quarter, 0.01, 1)
    middle = np.linalg.norm(0.5 * (quarter(steps[1:]) + quarter(steps[:-1])), axis=1)
    assert 0.009 < (10 - middle).max() <= 0.01 + 1e-9 and steps[0] == 0 and steps[-1] == 1
    with refused('PY0003', 'tolerance_mm'):
        trunnion.chord_steps(quarter, 0, 1)


def test_surfaces_that_are_none():
    with refused('SURF0202'):
        trunnion.plan_surface(hump(), BALL, scallop_mm=-1)
    with refused('SURF0207'):
        trunnion.plan_surface([], BALL)
    with refused('PY0001', 'faces'):
        trunnion.plan_surface([1], BALL)
    with refused('PY0001', 'loops'):
        trunnion.Face(hump().surface, loops=[[[0, 0], [1, 1]]])
    with refused('PY0004', 'side'):
        trunnion.Face(hump().surface, side='up')
    with refused('PY0002', 'scallop_mm'):
        trunnion.plan_surface(hump(), BALL, scallop_mm=math.nan)
