"""Beudaert, Lavernhe, Tournier 2013, 5-axis local corner rounding of linear tool path discontinuities: curves and link."""
import math

import numpy as np

import trunnion

from ._figures_corners import LINKS, PAPER, POCKET, drawn_length, eq10, eq11, unit
from ._figures_drawing import BLUE, GREY, RED, figure


@figure('beudaert-1', PAPER, 'Fig. 1', 'a corner rounded in position', size=(6.4, 4.6))
def corner_in_position(picture):
    tolerance = 0.02
    curve = trunnion.corner_curve([-1, 0, 0], [0, 0, 0], [0, 1, 0], tolerance)
    points, polygon = 1000 * curve(np.linspace(0, 1, 401)), 1000 * curve.control_points_mm
    nearest = np.linalg.norm(points, axis=1).min()
    inner, outer = np.linalg.norm(polygon[1]), np.linalg.norm(polygon[0])
    plot = picture.subplots()
    plot.plot(*polygon[:, :2].T, color=GREY, linestyle=':', marker='o', markersize=4, label='segments, control points')
    plot.plot(*points[:, :2].T, color=BLUE, label='curve')
    middle = points[200]
    plot.plot([0, middle[0]], [0, middle[1]], color=RED, label=f'ε = {nearest:.2f} µm')
    for k, at in enumerate(polygon):
        plot.annotate(f'P$_{k}$', at[:2], xytext=(-4, -14) if k < 3 else (6, -4), textcoords='offset points')
    plot.set(aspect='equal', xlabel='x in µm', ylabel='y in µm', ylim=(-12, None))
    plot.legend(loc='upper left')
    return {'distance of the corner, µm': (nearest, 20.0), 'L1 by Eq. 3, µm': (inner, 2 * 20 / math.cos(math.pi / 4)),
            'L2/L1, chosen in the text': (outer / inner, 1.4)}


def draw_rulings(plot, shown, colour, style, label):
    u = np.linspace(0, 1, 21)
    tips, axes = (rows[:, 0] for rows in shown.poses(u))
    tops = shown.curves.top(shown.link(u)[:, 0])
    for k, (tip, top) in enumerate(zip(tips, tops)):
        plot.plot(*np.array([tip, top]).T, color=colour, linestyle=style, linewidth=0.8, label=label if k == 0 else None)
    return axes


@figure('beudaert-2', PAPER, 'Fig. 2', 'a corner of two curves, and the tool along it', kind='stand-in', size=(9.5, 4.6))
def corner_of_two_curves(picture):
    plots = picture.subplots(1, 2, subplot_kw={'projection': '3d'})
    turns = {}
    for plot, (link, colour, _, label) in zip(plots, LINKS):
        shown = POCKET.corner(link)
        for curve in (shown.curves.bottom, shown.curves.top):
            plot.plot(*curve(np.linspace(0, 1, 101)).T, color=GREY)
            plot.plot(*curve.control_points_mm.T, color=GREY, linestyle=':', marker='o', markersize=3)
        axes = draw_rulings(plot, shown, colour, '-', label)
        turns[link] = np.degrees(np.arccos(np.clip(np.sum(axes[1:] * axes[:-1], axis=1), -1, 1)))
        plot.set(title=label, xlabel='x in mm', ylabel='y in mm', zlabel='z in mm', xticks=(50, 55, 60, 65))
        plot.view_init(elev=32, azim=-60)
    u = np.linspace(0, 1, 2001)
    nearest = [np.linalg.norm(curve(u) - ruling, axis=1).min() for curve, ruling in
               zip((shown.curves.bottom, shown.curves.top), POCKET.rulings()[1])]
    return {'tip from its corner, mm': (nearest[0], 3.0), 'top from its corner, mm': (nearest[1], 3.0),
            'first turn of 1/20 of u, linear link, deg': (turns['linear'][0], None),
            'first turn of 1/20 of u, optimised link, deg': (turns['optimised'][0], None)}


def turning_before(shown):
    """Derivative of the orientation by path length at the end of the ruled segment before the corner."""
    before = POCKET.rulings()[:2]
    step = 1e-5
    way = np.linalg.norm(before[1, 0] - before[0, 0])
    entry = shown.curves.bottom(0.0)
    share = np.linalg.norm(entry - before[0, 0]) / way
    rulings = [before[0] + (share + k * step / way) * (before[1] - before[0]) for k in (-1, 1)]
    directions = [unit(top - tip) for tip, top in rulings]
    return (directions[1] - directions[0]) / (2 * step)


@figure('beudaert-3', PAPER, 'Fig. 3', 'orientation at the connection', kind='stand-in', size=(8, 3.4))
def orientation_at_the_connection(picture):
    plot = picture.subplots()
    numbers = {}
    before = np.linalg.norm(turning_before(POCKET.corner()))
    for link, colour, style, label in LINKS:
        shown = POCKET.corner(link)
        u = np.linspace(0, 0.5, 201)
        tips, axes = shown.poses(u)
        plot.plot(drawn_length(tips[:, 0]), np.degrees(np.linalg.norm(axes[:, 1], axis=1)), color=colour, linestyle=style,
                  label=label)
        jump = np.linalg.norm(axes[0, 1] - turning_before(shown)) / before
        numbers[f'jump of dn/ds at the entry, {link} link, of dn/ds'] = (jump, 0.0 if link == 'optimised' else None)
    plot.hlines(np.degrees(before), -2, 0, color=GREY, label='segment before')
    plot.set(xlabel='way of the tip in mm, 0 at the entry', ylabel='‖dn/ds‖ in deg/mm', ylim=(0, None))
    plot.legend()
    return numbers


@figure('beudaert-5', PAPER, 'Fig. 5', 'parametrization spline', kind='stand-in', size=(8, 3.4))
def parametrization_spline(picture):
    left, right = picture.subplots(1, 2)
    u = np.linspace(0, 1, 201)
    for link, colour, style, label in LINKS:
        values = POCKET.corner(link).link(u)
        left.plot(u, values[:, 0], color=colour, linestyle=style, label=label)
        right.plot(u, values[:, 1], color=colour, linestyle=style)
    left.set(xlabel='u of the bottom', ylabel='u of the top')
    right.set(xlabel='u of the bottom', ylabel="f ′", ylim=(0, None))
    left.legend()
    return {"f ′ at the entry": (values[0, 1], None), "least f ′": (values[:, 1].min(), None),
            'u_top at the exit': (values[-1, 0], 1.0)}


def first_orientation(u_top, tips, axes, shown, machine):
    """Eq. 11 and Eq. 10 with the first top point at u_top: three poses up to the entry, and the tip of the next one."""
    axes = np.vstack([axes, unit(shown.curves.top(u_top) - tips[3])])
    return eq11(axes, POCKET.step)[0], eq10(machine.inverse(tips, axes), POCKET.step, machine, POCKET.feed)[0]


@figure('beudaert-6', PAPER, 'Fig. 6', 'the first point u_top1', kind='stand-in', size=(8, 3.6))
def first_point(picture):
    shown, machine = POCKET.corner(), trunnion.machine('ucp710')
    _, tips, axes = POCKET.steps('optimised', 2 * POCKET.step)
    u = np.linspace(0, 0.2, 20001)
    u_bottom = np.interp(POCKET.step, drawn_length(shown.curves.bottom(u)), u)

    def tried(u_top):
        return np.array([first_orientation(u, tips[:4], axes[:3], shown, machine) for u in np.atleast_1d(u_top)])

    coarse = np.linspace(0.5 * u_bottom, 1.2 * u_bottom, 141)
    criterion = tried(coarse)[:, 0]
    best = coarse[np.argmin(criterion)]
    for width in 10.0 ** -np.arange(4, 11):
        around = best + np.linspace(-width, width, 81)
        best = around[np.argmin(tried(around)[:, 0])]
    fine = best + np.linspace(-2e-5, 2e-5, 201)
    linear = tried(u_bottom)[0]
    left, right = picture.subplots(1, 2)
    left.plot(coarse, criterion, color=BLUE)
    left.plot(u_bottom, linear[0], color=RED, marker='o', linestyle='', label='u_top1 = u_bottom1')
    left.set(xlabel='u_top1', ylabel='criterion, Eq. 11, in rad/mm³', ylim=(0, None))
    left.legend(loc='upper center')
    right.plot(1e6 * (fine - best), tried(fine)[:, 1], color=BLUE)
    right.axhline(linear[1], color=RED, linestyle='--', label='u_top1 = u_bottom1')
    right.set(xlabel='u_top1 − optimum, 10⁻⁶', ylabel='feed limit, Eq. 10, in mm/min', ylim=(0, None))
    right.legend(loc='center right')
    found = tried([best, best + 1e-6])
    slopes = np.diff(criterion)
    return {'feed limit at u_top1 = u_bottom1, mm/min': (linear[1], 0.0), 'feed limit at the optimum, mm/min':
            (found[0, 1], None), 'feed limit 1e-6 beside it, mm/min': (found[1, 1], None),
            'minima of the criterion': (np.count_nonzero((slopes[:-1] < 0) & (slopes[1:] > 0)), 1.0)}
