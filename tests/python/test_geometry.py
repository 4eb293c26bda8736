import math

import numpy as np
import pytest

import trunnion
from conftest import refused

KNOTS = [0, 0, 0, 0, 1, 1, 1, 1]
BEZIER = np.array([[0, 0, 0], [1, 2, 0], [3, 3, 1], [4, 0, 2]], float)


def test_a_bezier_curve_by_its_polynomials():
    curve = trunnion.BsplineCurve(3, KNOTS, BEZIER)
    u = np.linspace(0, 1, 12).reshape(3, 4)
    bernstein = np.stack([(1 - u)**3, 3 * u * (1 - u)**2, 3 * u * u * (1 - u), u**3], -1)
    np.testing.assert_allclose(curve(u), bernstein @ BEZIER, atol=1e-14)
    derivatives = curve.derivatives(0.0)
    np.testing.assert_allclose(derivatives[1], 3 * (BEZIER[1] - BEZIER[0]))
    np.testing.assert_allclose(derivatives[3], 6 * (BEZIER[3] - 3 * BEZIER[2] + 3 * BEZIER[1] - BEZIER[0]))
    assert curve(0.5).shape == (3,) and curve([]).shape == (0, 3) and (curve.begin, curve.end) == (0, 1)
    assert np.shares_memory(curve.control_points_mm, curve.control_points_mm)


def test_a_quarter_circle_has_weights():
    curve = trunnion.BsplineCurve(2, [0, 0, 0, 1, 1, 1], [[1, 0, 0], [1, 1, 0], [0, 1, 0]], [1, math.sqrt(0.5), 1])
    np.testing.assert_allclose(np.linalg.norm(curve(np.linspace(0, 1, 30)), axis=-1), 1, atol=1e-14)


@pytest.mark.parametrize('code, arguments', [
    ('GEOM0101', (9, KNOTS, BEZIER)), ('GEOM0102', (3, KNOTS[:-1], BEZIER)), ('GEOM0103', (3, KNOTS[::-1], BEZIER)),
    ('GEOM0107', (3, KNOTS, BEZIER, [1, 1, 1, -1])), ('PY0001', (3.5, KNOTS, BEZIER)), ('PY0001', (3, KNOTS, BEZIER[:, :2])),
    ('PY0002', (3, KNOTS, BEZIER * math.nan)), ('PY0001', (3, [KNOTS], BEZIER))])
def test_curves_that_are_none(code, arguments):
    with refused(code):
        trunnion.BsplineCurve(*arguments)


def test_dual_spline():
    bottom = trunnion.BsplineCurve(3, KNOTS, BEZIER)
    top = trunnion.BsplineCurve(3, KNOTS, BEZIER + [0, 0, 50])
    np.testing.assert_allclose(trunnion.DualSpline(bottom, top).axis([0, 0.3])[:, 0], [[0, 0, 1]] * 2)
    with refused('GEOM0106'):
        trunnion.DualSpline(bottom, trunnion.BsplineCurve(1, [0, 0, 1, 1], BEZIER[:2]))


def test_a_polynomial_surface():
    # z = u², x = 10 u, y = 20 v
    a = np.zeros((3, 2, 3))
    a[1, 0, 0], a[0, 1, 1], a[2, 0, 2] = 10, 20, 1
    surface = trunnion.BsplineSurface.polynomial(a)
    u, v = np.array([0.0, 0.5, 1.0]), np.array([0.1, 0.2, 0.9])
    np.testing.assert_allclose(surface(u, v), np.column_stack([10 * u, 20 * v, u * u]), atol=1e-13)
    derivatives = surface.derivatives(u, v)
    np.testing.assert_allclose(derivatives[:, 1], np.column_stack([[10] * 3, [0] * 3, 2 * u]), atol=1e-12)
    np.testing.assert_allclose(derivatives[:, 3], [[0, 0, 2]] * 3, atol=1e-12)
    shape = surface.shape(u, v)
    hollow = -2 / 100 / (1 + (0.2 * u)**2)**1.5
    np.testing.assert_allclose(shape['curvatures_per_mm'][:, 1], hollow * (1 + (0.2 * u)**2)**1.5 / (1 + (2 * u / 10)**2)**1.5)
    np.testing.assert_allclose(surface.shape(u, v, side='against')['normal'], -shape['normal'])
    np.testing.assert_allclose(surface.closest(surface(u, v) + 0.1 * shape['normal']), np.column_stack([u, v]), atol=1e-9)
    with refused('PY0001', 'v'):
        surface(u, 0.5)
    with refused('PY0001', 'coefficients_mm'):
        trunnion.BsplineSurface.polynomial(np.zeros((3, 3)))
    with refused('GEOM0102', 'knots_v'):
        trunnion.BsplineSurface(1, 1, [0, 0, 1, 1], [0, 0, 1, 1], np.zeros((2, 3, 3)))
    with refused('PY0001', 'weights'):
        trunnion.BsplineSurface(1, 1, [0, 0, 1, 1], [0, 0, 1, 1], np.zeros((2, 2, 3)), [1, 1, 1, 1])


def test_a_corner_uses_its_tolerance():
    corner = trunnion.corner_curve([0, 0, 0], [10, 0, 0], [10, 10, 0], 0.05)
    assert np.linalg.norm(corner(0.5) - [10, 0, 0]) == pytest.approx(0.05, rel=1e-9)
    np.testing.assert_allclose(corner.knots, [0, 0, 0, 0, 0.5, 1, 1, 1, 1])
    for code, arguments in [('SMTH0101', (0.0,)), ('SMTH0104', (0.05, 1.0))]:
        with refused(code):
            trunnion.corner_curve([0, 0, 0], [10, 0, 0], [10, 10, 0], *arguments)
    with refused('PY0001', 'corner_mm'):
        trunnion.corner_curve([0, 0, 0], [[10, 0, 0]], [10, 10, 0], 0.05)


def poses():
    return [[[0, 0, 0], [0, 0, 30]], [[10, 0, 0], [10, 3, 29.8]], [[10, 10, 0], [12, 14, 29.6]]]


def test_a_linked_corner_turns_smoothly(trt):
    shape = dict(tip_tolerance_mm=0.02, top_tolerance_mm=0.005)
    linked, linear = trunnion.DualCorner(*poses(), **shape), trunnion.DualCorner(*poses(), **shape, link='linear')
    f = linked.link([0, 0.5, 1])
    assert f[0, 0] == 0 and f[2, 0] == 1 and (f[:, 1] > 0).all()
    before = trunnion.DualSpline(*[trunnion.BsplineCurve(1, [0, 0, 1, 1], [p[0], p[1]]) for p in
                                   zip(poses()[0], poses()[1])])
    tips, axes = linked.poses(0.0)
    # The segment's axis by the tip's length, 10 mm long, where the corner begins.
    u = tips[0, 0] / 10
    segment = before.axis(u) / np.array([1, 10, 100, 1000])[:, None]
    np.testing.assert_allclose(axes[:3], segment[:3], atol=1e-9)
    assert np.abs(linear.poses(0.0)[1][1] - segment[1]).max() > 1e-4
    sampled = linked.sample(trt, feed_mm_min=3000)
    assert sampled['axes'].shape == (len(sampled['length_mm']), 4, 5)
    assert 0 < sampled['feed_limit_mm_min'].min() < 3000 * 1.0001
    with refused('PY0003', 'u'):
        linked.link(1.5)
    with refused('PY0001', 'before_mm'):
        trunnion.DualCorner([0, 0, 0], *poses()[1:])
    with refused('PY0003', 'per_part'):
        linked.sample(trt, per_part=0)


def rulings():
    """The segments before and behind the corner of poses(), as paths."""
    pairs = zip(poses(), poses()[1:])
    return [trunnion.DualSpline(*[trunnion.BsplineCurve(1, [0, 0, 1, 1], [a[k], b[k]]) for k in (0, 1)]) for a, b in pairs]


def test_a_link_between_any_paths():
    corner = trunnion.DualCorner(*poses(), tip_tolerance_mm=0.02, top_tolerance_mm=0.005)
    bottom, top = corner.curves.bottom, corner.curves.top
    before, after = (part(segment, corner) for segment, part in zip(rulings(), (before_corner, behind_corner)))
    link = trunnion.connect(before, bottom, top, after)
    f = link([0, 0.5, 1])
    assert f[0, 0] == 0 and f[2, 0] == 1 and (f[:, 1] > 0).all()
    np.testing.assert_allclose(f[[0, 2], 1], corner.link([0.0, 1.0])[:, 1], rtol=1e-6)
    np.testing.assert_allclose(link.inverse(f[:, 0]), [0, 0.5, 1], atol=1e-12)
    tips, axes = link.poses(bottom, top, [0.0, 0.5])
    np.testing.assert_allclose(np.linalg.norm(axes[:, 0], axis=1), 1, atol=1e-12)
    length = np.linalg.norm(before.bottom.derivatives(before.end)[1])
    np.testing.assert_allclose(axes[0, 1], before.axis(before.end)[1] / length, atol=1e-9)
    assert np.abs(trunnion.DualCorner(*poses(), tip_tolerance_mm=0.02, top_tolerance_mm=0.005, link='linear').poses(0.0)[1][1]
                  - axes[0, 1]).max() > 1e-4
    with refused('SMTH0112'):
        trunnion.connect(after, bottom, top, before)
    with refused('PY0003', 'u'):
        link(1.5)
    with refused('PY0003', 'tangent_tolerance_deg'):
        trunnion.connect(before, bottom, top, after, 0)


def before_corner(segment, corner):
    """The segment up to where the corner's curves begin."""
    ends = [curve(curve.begin) for curve in (corner.curves.bottom, corner.curves.top)]
    starts = [segment.bottom(0.0), segment.top(0.0)]
    return trunnion.DualSpline(*[trunnion.BsplineCurve(1, [0, 0, 1, 1], [a, b]) for a, b in zip(starts, ends)])


def behind_corner(segment, corner):
    starts = [curve(curve.end) for curve in (corner.curves.bottom, corner.curves.top)]
    ends = [segment.bottom(1.0), segment.top(1.0)]
    return trunnion.DualSpline(*[trunnion.BsplineCurve(1, [0, 0, 1, 1], [a, b]) for a, b in zip(starts, ends)])


def test_the_link_as_it_was_published():
    corner = trunnion.DualCorner(*poses(), tip_tolerance_mm=0.02, top_tolerance_mm=0.005)
    found = corner.discrete_link(0.002)
    assert found['bottom'][[0, -1]].tolist() == found['top'][[0, -1]].tolist() == [0, 1] and (np.diff(found['top']) > 0).all()
    np.testing.assert_allclose(found['spline'](found['bottom'])[:, 1], found['top'], atol=1e-9)
    np.testing.assert_allclose(found['top'], corner.link(found['bottom'])[:, 0], atol=0.02)
    for code, step in [('SMTH0121', 0), ('SMTH0121', 10), ('PY0002', math.nan)]:
        with refused(code):
            corner.discrete_link(step)
