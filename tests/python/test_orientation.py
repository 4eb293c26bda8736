"""The surfaces that lead a tool, the part as a body, and gouges found and removed."""
import math

import numpy as np
import pytest

import trunnion
from conftest import EXAMPLES, refused

BALL, TORUS = trunnion.Tool('ball', 10), trunnion.Tool('torus', 10, 2)


def ground(height=0.0):
    """A plane of 40 × 40 mm, normal up."""
    corners = [[[0, 0, height], [0, 40, height]], [[40, 0, height], [40, 40, height]]]
    return trunnion.Face(trunnion.BsplineSurface(1, 1, [0, 0, 40, 40], [0, 0, 40, 40], corners))


def bowl():
    return trunnion.read_faces(EXAMPLES / '11_hollow/bowl.toml')[0]


def grid(surface, count=7):
    (u0, u1), (v0, v1) = surface.domain
    u, v = np.meshgrid(np.linspace(u0, u1, count), np.linspace(v0, v1, count), indexing='ij')
    return np.stack([u, v], -1)


def test_the_guiding_surface_is_offset_by_the_corner_radius():
    face = bowl()
    guiding = trunnion.GuidingSurface(face, BALL)
    places = grid(guiding.surface, 9)
    u, v = places[..., 0], places[..., 1]
    normal = face.surface.shape(u, v, face.side)['normal']
    off = np.linalg.norm(guiding.surface(u, v) - face.surface(u, v) - 5 * normal, axis=-1)
    assert 0 < off.max() <= guiding.error_bound_mm <= 0.0005 and guiding.patches > 1
    with refused('SURF0304'):
        trunnion.GuidingSurface(face, trunnion.Tool('ball', 60))
    with refused('SURF0301'):
        trunnion.GuidingSurface(face, BALL, tolerance_mm=0)
    with refused('SURF0201'):
        trunnion.GuidingSurface(face, trunnion.Tool('taper', 10))


@pytest.fixture(scope='module')
def leaning():
    return trunnion.OrientationSurface(trunnion.GuidingSurface(ground(), TORUS), lead_deg=15, least_lead_deg=0, most_lead_deg=30,
                                       most_tilt_deg=20)


def test_lead_tilt_and_limits(leaning):
    places = grid(leaning.surface)
    np.testing.assert_allclose(leaning.axis(places), np.broadcast_to([math.sin(math.radians(15)), 0, math.cos(math.radians(15))],
                                                                    (7, 7, 3)), atol=2e-4)
    assert leaning.limits == pytest.approx({'least_lead_deg': 0, 'most_lead_deg': 30, 'most_tilt_deg': 20})
    low, high = leaning.distance_range_mm
    assert low <= 50 <= high and high - low < 0.1 and leaning.error_bound_mm <= 0.01
    assert leaning.lower_limit.axis([20, 20]) == pytest.approx([0, 0, 1], abs=1e-3)
    assert leaning.upper_limit.axis([20, 20])[0] == pytest.approx(0.5, abs=1e-3)
    assert leaning.beyond_limits[0].shape == (0, 2)
    field = trunnion.OrientationSurface(trunnion.GuidingSurface(ground(), TORUS), axis=lambda point, normal: normal + [0, 0.2, 0])
    assert field.axis([5, 5])[1] == pytest.approx(0.2 / math.hypot(1, 0.2), abs=1e-3)
    across = trunnion.OrientationSurface(trunnion.GuidingSurface(ground(), TORUS), lead_deg=15, feed=[0, 3, 0])
    assert across.axis([5, 5])[1] == pytest.approx(math.sin(math.radians(15)), abs=1e-3)


def test_editing(leaning):
    wanted = np.array([math.sin(math.radians(25)), 0, math.cos(math.radians(25))])
    changed = leaning.towards([[20, 20]], [wanted])
    assert changed.axis([20, 20]) == pytest.approx(wanted, abs=1e-3)
    turned = leaning.turned([20, 20], 30, [0, 8, 0])
    lead = math.degrees(math.asin(turned.axis([20, 20])[0]))
    assert 15 + 0.7 * 8 < lead < 23 and turned.axis([0, 0]) == pytest.approx(leaning.axis([0, 0]), abs=0.02)
    half = leaning.blended(changed, 0.5).axis([20, 20])[0]
    assert leaning.axis([20, 20])[0] < half < wanted[0]
    assert leaning.blended(changed, lambda u, v: u / 40).axis([0, 20]) == pytest.approx(leaning.axis([0, 20]), abs=1e-3)
    with refused('SURF0308'):
        leaning.turned([20, 20], 30, [0, 40, 0])
    with refused('SURF0309', 'places'):
        leaning.axis([41, 0])
    with refused('SURF0301'):
        leaning.blended(changed, 2)
    with pytest.raises(ZeroDivisionError):
        leaning.blended(changed, lambda u, v: 1 / 0)


def test_passes_on_it(leaning):
    places = np.column_stack([np.linspace(5, 35, 5), np.full(5, 20.0)])
    contacts = leaning.pass_over(places)
    np.testing.assert_allclose(contacts['points_mm'][:, 2], 0, atol=1e-9)
    np.testing.assert_allclose(contacts['axes'][:, 0], math.sin(math.radians(15)), atol=1e-3)
    # The torus touches with its round edge behind the tip: R - r + r sin(lead) away in the plane, by its section.
    behind = contacts['tips_mm'][:, 0] - contacts['points_mm'][:, 0]
    s, c = math.sin(math.radians(15)), math.cos(math.radians(15))
    np.testing.assert_allclose(np.abs(behind), 3 * c + 2 * s, atol=2e-3)
    spline, facts = leaning.spline_over(places)
    np.testing.assert_allclose(spline.bottom(spline.begin), contacts['tips_mm'][0], atol=2e-3)
    assert facts['tip_error_mm'] <= 0.001
    with refused('SURF0309'):
        leaning.pass_over(places[:1])


def test_orientations_that_are_none():
    guiding = trunnion.GuidingSurface(ground(), TORUS)
    for code, name, options in [('SURF0308', '', dict(lead_deg=50, most_lead_deg=30)), ('SURF0301', '', dict(height_mm=-1)),
                                ('PY0004', 'feed', dict(feed='w')), ('PY0003', 'feed', dict(feed=[0, 0, 0])),
                                ('PY0001', 'axis', dict(axis=3)), ('PY0001', 'axis', dict(axis=lambda p, n: 'up')),
                                ('PY0002', 'lead_deg', dict(lead_deg=math.nan))]:
        with refused(code, name):
            trunnion.OrientationSurface(guiding, **options)


def test_how_deep_a_tool_is():
    part = trunnion.PartBody([ground(), ground(-30)], tolerance_mm=0.001)
    tips = np.array([[20, 20, 1], [20, 20, -0.25]])
    found = part.penetrations(BALL, tips, [[0, 0, 1]] * 2)
    np.testing.assert_allclose(found['depth_mm'], [0, 0.25], atol=2e-3)
    assert found['face'].tolist() == [-1, 0] and np.isnan(found['at_mm'][0]).all() and not found['by_holder'].any()
    held = part.penetrations(BALL, tips[:1], [[0, 1, 0]], holder_mm=[12, 4, 18])
    assert held['by_holder'][0] and held['depth_mm'][0] == pytest.approx(5, abs=0.1)
    np.testing.assert_allclose(part.signed_distance_mm([[20, 20, 3], [20, 20, -2]]), [3, -2], atol=2e-3)
    assert part.triangles >= 4 and part.tolerance_mm == 0.001
    for code, name, call in [('SURF0302', '', lambda: trunnion.PartBody([])), ('SURF0301', '', lambda: trunnion.PartBody(ground(), 0)),
                             ('PY0001', 'faces', lambda: trunnion.PartBody(3)),
                             ('PY0003', 'holder_mm', lambda: part.penetrations(BALL, tips[0], [0, 0, 1], [30, 60, 20])),
                             ('PY0001', 'holder_mm', lambda: part.penetrations(BALL, tips[0], [0, 0, 1], [30])),
                             ('PY0003', 'reach_mm', lambda: part.penetrations(BALL, tips[0], [0, 0, 1], reach_mm=-1)),
                             ('PY0003', 'axes', lambda: part.penetrations(BALL, tips[0], [0, 0, 2]))]:
        with refused(code, name):
            call()


def test_gouges_found_and_removed():
    """A ball that leans towards a wall goes into it until it is freed."""
    faces = trunnion.read_faces(EXAMPLES / '12_pocket_wall/pocket.toml')
    bottom, others = faces[0], [faces[i] for i in range(1, len(faces))]
    options = dict(strategy='along-u', lead_deg=15, scallop_mm=0.6, reach_mm=40)
    planned = trunnion.plan_surface(bottom, BALL, **options)
    part = trunnion.PartBody([bottom, *others], tolerance_mm=0.0004)
    found = planned.gouges(part, tolerance_mm=0.001)
    assert found['poses'] > 100 and found['deepest_mm'] > 0.1
    worst = max(found['gouges'], key=lambda one: one['depth_mm'])
    assert worst['depth_mm'] == found['deepest_mm'] and worst['kind'] in ('global', 'rear', 'local')
    assert worst['pass'] < planned.facts['passes'] and planned.facts['freed'] is None
    assert planned.check([bottom, *others])['in_part_mm'] > 0.1
    freed = trunnion.plan_surface(bottom, BALL, free_gouges=True, others=others, **options)
    facts = freed.facts['freed']
    assert facts['gouges'] > 0 and facts['passes_turned'] > 0 and facts['largest_turn_deg'] > 0.1
    assert freed.gouges(part, tolerance_mm=0.0015)['gouges'] == [] and freed.check([bottom, *others])['in_part_mm'] == 0
    with refused('PY0003', 'others'):
        trunnion.plan_surface(bottom, BALL, others=others)
    with refused('PY0003', 'most_lead_deg'):
        trunnion.plan_surface(bottom, BALL, most_lead_deg=20)
    with refused('PY0002', 'step_mm'):
        planned.gouges(part, step_mm=math.nan)
    with refused('SURF0301'):
        planned.gouges(part, step_mm=0)
