"""Lin, Koren: Real-Time Interpolator for 5-Axis Surface Machining.

The coefficients of its surface (Fig. 5) are not in the text: a dome of 80 × 60 mm stands in. The curve of its Fig. 6 is Eq. 8.
"""
import math

import numpy as np

import trunnion

from ._figures_drawing import BLUE, GREEN, GREY, RED, figure

PAPER = 'Lin & Koren'
DIAMETER, SCALLOP, TOLERANCE = 12.0, 0.01, 0.001  # mm
PUBLISHED_ERROR = 0.017                           # deg: of Fig. 6
FEED, PERIOD = 3000.0, 0.001                      # mm/min, s


def eq8():
    """x = 10u³ + 10u² + 10, y = 10u² + 10u as a cubic B-spline of one piece."""
    return trunnion.BsplineCurve(3, [0, 0, 0, 0, 1, 1, 1, 1], [[10, 0, 0], [10, 10 / 3, 0], [40 / 3, 10, 0], [30, 20, 0]])


def face(coefficients):
    return trunnion.Face(trunnion.BsplineSurface.polynomial(coefficients))


def plane():
    a = np.zeros((2, 2, 3))
    a[1, 0], a[0, 1] = [60, 0, 0], [0, 40, 0]
    return face(a)


def dome():
    """z falls by 6 mm and 4 mm from the middle to the borders."""
    a = np.zeros((3, 3, 3))
    a[0, 0], a[1, 0], a[0, 1] = [-40, -30, -10], [80, 0, 24], [0, 60, 16]
    a[2, 0, 2], a[0, 2, 2] = -24, -16
    return face(a)


def cylinder(radius=40.0, width=30.0):
    """Quadratic, with this radius along the top line, which is that of y."""
    a = np.zeros((3, 2, 3))
    rise = width**2 / (2 * radius)
    a[0, 0], a[1, 0], a[2, 0], a[0, 1] = [-width / 2, 0, -rise / 4], [width, 0, rise], [0, 0, -rise], [0, 20, 0]
    return face(a)


def flat():
    return trunnion.Tool('flat', DIAMETER)


@figure('lin-koren-3', PAPER, 'Fig. 3', 'a plane and a flat-end cutter', size=(8, 2.8))
def planar_surface(picture):
    found = trunnion.plan_surface(plane(), flat(), scallop_mm=SCALLOP, borders=False)
    contacts = found.contacts
    v = np.unique(np.round(contacts['points_mm'][:, 1], 6))
    plot = picture.subplots()
    plot.fill_between([-8, 48], -4, 0, color='#dddddd')
    for at in v:
        plot.plot([at - DIAMETER / 2, at - DIAMETER / 2, at + DIAMETER / 2, at + DIAMETER / 2], [8, 0, 0, 8], color=BLUE)
    interval = found.facts['largest_interval_mm']
    plot.annotate('', (v[0], 4), (v[1], 4), arrowprops={'arrowstyle': '<->', 'color': RED})
    plot.text(0.5 * (v[0] + v[1]), 5, f'P = {v[1] - v[0]:.2f} mm', ha='center', color=RED, backgroundcolor='white')
    plot.set(aspect='equal', xlabel='across the passes in mm', ylabel='z in mm', xlim=(-8, 48), ylim=(-4, 9))
    return {'interval / cutter diameter': (interval / DIAMETER, 1.0)}


def draw_scallop(plot, radius, scallop):
    """Two positions of a flat on a circle, the tangents of which meet at the height of the scallop."""
    half = math.acos(radius / (radius + scallop))
    angle = np.linspace(-0.5, 0.5, 101)
    plot.plot(radius * np.sin(angle), radius * (np.cos(angle) - 1), color=GREY, label='surface')
    for side in (-1, 1):
        at = radius * np.array([math.sin(side * half), math.cos(half) - 1])
        along = np.array([math.cos(half), -side * math.sin(half)])
        ends = np.array([at - 7 * along, at + 7 * along])
        plot.plot(*ends.T, color=BLUE, label='flat of the cutter' if side < 0 else None)
        plot.plot(*at, color=BLUE, marker='o', markersize=4)
    plot.plot([0, 0], [0, scallop], color=RED, linewidth=2.5, label=f'h = {scallop:g} mm')
    plot.set(aspect='equal', xlim=(-11, 11), xlabel='across the passes in mm', ylabel='height in mm')
    plot.legend(loc='lower center', fontsize=8)


@figure('lin-koren-4', PAPER, 'Fig. 4', 'scallop and path interval', size=(9, 3.6))
def scallop_and_interval(picture):
    left, right = picture.subplots(1, 2, width_ratios=(5, 4))
    draw_scallop(left, 20.0, 1.0)
    radius = np.geomspace(5, 500, 60)
    for scallop, colour in ((0.001, GREY), (SCALLOP, BLUE), (0.05, GREEN)):
        right.loglog(radius, trunnion.flat_interval_mm(radius, scallop), color=colour, label=f'h = {1000 * scallop:g} µm')
    eq2 = 2 * radius / (radius + SCALLOP) * np.sqrt(2 * radius * SCALLOP + SCALLOP**2)
    right.loglog(radius[::4], eq2[::4], color=RED, linestyle='', marker='.', label='Eq. 2')
    right.set(xlabel='radius of the surface in mm', ylabel='path interval P in mm')
    right.legend(fontsize=8)
    passes = trunnion.plan_surface(cylinder(), flat(), scallop_mm=SCALLOP, feed_angle_deg=90)
    ridge = passes.check()['largest_ridge_mm']
    return {'largest difference from Eq. 2, of P': (np.abs(trunnion.flat_interval_mm(radius, SCALLOP) / eq2 - 1).max(), 0.0),
            'ridge of simulated passes on a cylinder / h': (ridge / SCALLOP, 1.0)}


@figure('lin-koren-5', PAPER, 'Fig. 5', 'a parametric surface and its tool paths', kind='stand-in', size=(8, 4.8))
def surface_and_paths(picture):
    part = dome()
    found = trunnion.plan_surface(part, flat(), strategy='lin-koren', scallop_mm=SCALLOP)
    contacts = found.contacts
    plot = picture.add_subplot(projection='3d')
    u, v = np.meshgrid(np.linspace(0, 1, 15), np.linspace(0, 1, 15), indexing='ij')
    plot.plot_wireframe(*np.moveaxis(part.surface(u, v), -1, 0), color='#cccccc', linewidth=0.5)
    for begin, end in zip(contacts['first'][:-1], contacts['first'][1:]):
        plot.plot(*contacts['points_mm'][begin:end].T, color=BLUE, linewidth=1)
    plot.set(xlabel='x in mm', ylabel='y in mm', zlabel='z in mm', box_aspect=(80, 60, 22), zticks=(-10, -5, 0))
    verdict = found.check()
    return {'passes': (found.facts['passes'], None), 'highest ridge / allowed': (verdict['largest_ridge_mm'] / SCALLOP, 1.0),
            'deepest cut into the part, µm': (1000 * verdict['deepest_mm'], 0.0)}


def normals_along(curve, u):
    t = curve.derivatives(u)[..., 1, :2]
    return np.stack([-t[..., 1], t[..., 0]], axis=-1) / np.linalg.norm(t, axis=-1, keepdims=True)


def orientation_errors(curve, ends, by_chord):
    """u and the angle in degrees between the normal and the one turned linearly between the ends of chords."""
    out_u, out = [], []
    for begin, end in zip(ends[:-1], ends[1:]):
        u = np.linspace(begin, end, 41)
        share = (u - begin) / (end - begin)
        if by_chord:
            chord = curve(end) - curve(begin)
            share = (curve(u) - curve(begin)) @ chord / (chord @ chord)
        n = normals_along(curve, u)
        linear = n[0] + share[:, None] * (n[-1] - n[0])
        sine = linear[:, 0] * n[:, 1] - linear[:, 1] * n[:, 0]
        out.append(np.degrees(np.abs(np.arctan2(sine, np.sum(linear * n, axis=1)))))
        out_u.append(u)
    return np.concatenate(out_u), np.concatenate(out)


def moved_by(error_deg):
    """Micrometres by which the axes of the paper's machine, tool upright, answer to orientations off by so much about A."""
    setup = trunnion.setup({'workpiece': {'origin': ['8 mm', '96 mm', '120 mm']}})
    error = np.radians(np.append(0, error_deg))
    axes = np.column_stack([0 * error, -np.sin(error), np.cos(error)])
    q = trunnion.machine('lin-koren').inverse(np.zeros_like(axes), axes, setup, near_deg=[0, 0])[:, :3]
    return 1000 * np.linalg.norm(q[1:] - q[0], axis=1)


def greatest_chord_error(curve, ends):
    worst = 0.0
    for begin, end in zip(ends[:-1], ends[1:]):
        along = curve(end) - curve(begin)
        off = np.cross(curve(np.linspace(begin, end, 41)) - curve(begin), along / np.linalg.norm(along))
        worst = max(worst, np.linalg.norm(off, axis=1).max())
    return worst


def length_of(curve, begin=0.0, end=1.0):
    x, w = np.polynomial.legendre.leggauss(24)
    u = 0.5 * (begin + end) + 0.5 * (end - begin) * x
    return 0.5 * (end - begin) * w @ np.linalg.norm(curve.derivatives(u)[:, 1], axis=1)


@figure('lin-koren-6', PAPER, 'Fig. 6', 'orientation errors of straight segments, curve of Eq. 8', size=(8, 5.4))
def straight_segments(picture):
    curve = eq8()
    ends = trunnion.chord_steps(curve, TOLERANCE, 1)
    top, bottom = picture.subplots(2, 1, sharex=True)
    u, by_chord = orientation_errors(curve, ends, True)
    _, by_parameter = orientation_errors(curve, ends, False)
    top.plot(u, by_chord, color=BLUE, linewidth=0.9, label='linear along the chord')
    top.plot(u, by_parameter, color=GREEN, linewidth=0.9, label='linear in u, Eq. 7 as printed')
    top.axhline(PUBLISHED_ERROR, color=RED, linestyle=':', label='published maximum')
    top.set(ylabel='orientation error in deg', ylim=(0, 0.023))
    top.legend(loc='upper right', ncols=3, fontsize=8)
    bottom.plot(u, moved_by(by_chord), color=BLUE, linewidth=0.9)
    bottom.axhline(45, color=RED, linestyle=':')
    bottom.set(xlabel='u', ylabel='position error in µm', ylim=(0, None))
    return {'segments within 1 µm': (len(ends) - 1, 52.0), 'chord error, µm': (1000 * greatest_chord_error(curve, ends), 1.0),
            'largest orientation error, deg': (by_chord.max(), PUBLISHED_ERROR),
            'linear in u instead, deg': (by_parameter.max(), None),
            'position error of 0.017°, µm': (moved_by([PUBLISHED_ERROR])[0], 45.0),
            'length of the curve, mm': (length_of(curve), None)}


def ripple_of(curve, step, order):
    """u and the way of every step over the wanted one, less 1, by Taylor's series of first (Eq. 5) or second order."""
    u, out = 0.0, []
    while True:
        rates = curve.derivatives(u)
        rate = np.linalg.norm(rates[1])
        du = step / rate - (order == 2) * step**2 * (rates[1] @ rates[2]) / (2 * rate**4)
        if u + du > 1:
            return np.array(out).T
        out.append((u, length_of(curve, u, u + du) / step - 1))
        u += du


@figure('lin-koren-eq5', PAPER, 'Eq. 5', 'ripple of the feed, curve of Eq. 8', kind='text', size=(8, 3.4))
def ripple(picture):
    plot, numbers = picture.subplots(), {}
    for step, order, colour in ((FEED / 60 * PERIOD, 1, RED), (0.01, 1, GREEN), (FEED / 60 * PERIOD, 2, BLUE)):
        u, off = ripple_of(eq8(), step, order)
        name = f'order {order}, {step:g} mm a period'
        plot.semilogy(u, 100 * np.abs(off), color=colour, label=name)
        numbers[f'ripple, {name}, %'] = (100 * np.abs(off).max(), 0.1)
    plot.axhline(0.1, color=GREY, linestyle=':', label='published bound')
    plot.set(xlabel='u', ylabel='way of a step off by, %', ylim=(1e-5, 2))
    plot.legend(ncols=2, fontsize=8)
    return numbers
