"""Beudaert 2013: what the drives make of rounded corners, with either link."""
import numpy as np

import trunnion

from ._figures_corners import LINKS, PAPER, POCKET, PYRAMID, eq10, eq11
from ._figures_drawing import GREY, figure


def draw_results(plots, part, link, colour, window):
    """Eq. 11, and Eq. 10 with the planned feed, over the way from the middle of the corner; the least of the two feeds."""
    at, half = part.middle()
    s, tips, axes = part.steps(link, window - half)
    machine, plan = trunnion.machine('ucp710'), part.planned(link)
    limit = eq10(machine.inverse(tips, axes), part.step, machine, part.feed)
    plots[0].semilogy(s[3:], np.maximum(eq11(axes, part.step), 1e-12), color=colour)
    plots[1].plot(s[3:], limit, color=GREY, label='limit, Eq. 10')
    way = plan['s_mm'] - at
    inside = np.abs(way) < window
    plots[1].plot(way[inside], plan['feed_mm_min'][inside], color=colour, label='planned')
    return limit.min(), plan['feed_mm_min'][inside].min()


def results(numbers, link, limit, made):
    almost_zero = 0.0 if link == 'linear' else None
    numbers[f'least limit of Eq. 10, {link} link, mm/min'] = (limit, almost_zero)
    numbers[f'least planned feed, {link} link, mm/min'] = (made, almost_zero)


def draw_swept(plot, plan):
    """The surface that the tool axis sweeps, seen from above, coloured by the feed."""
    from matplotlib.collections import LineCollection
    tips, axes = trunnion.machine('ucp710').forward(plan.setpoints[::10, 1:6])
    tops = tips + POCKET.height * axes / axes[:, 2:]
    lines = LineCollection(np.stack([tips[:, :2], tops[:, :2]], axis=1), array=plan['feed_mm_min'][::10], cmap='viridis')
    lines.set_clim(0, POCKET.feed)
    plot.add_collection(lines)
    plot.set(aspect='equal', xlim=(35, 68), ylim=(-8, 25), xlabel='x in mm', ylabel='y in mm')
    return lines


@figure('beudaert-8', PAPER, 'Fig. 8', 'results for the pocket', kind='stand-in', size=(8.5, 9))
def results_of_the_pocket(picture):
    plots = picture.subplots(3, 2, height_ratios=(2, 2, 3))
    numbers = {}
    for column, (link, colour, _, label) in zip(plots.T, LINKS):
        results(numbers, link, *draw_results(column, POCKET, link, colour, 14))
        swept = draw_swept(column[2], POCKET.planned(link))
        column[0].set(title=label, ylim=(1e-6, 1e2), ylabel='criterion, Eq. 11\nin rad/mm³')
        column[1].set(ylim=(0, 1.1 * POCKET.feed), xlabel='way from the middle of the corner in mm', ylabel='feed in mm/min')
        column[1].legend(loc='lower center')
    picture.colorbar(swept, ax=plots[2], label='feed in mm/min', shrink=0.8)
    return numbers


@figure('beudaert-9', PAPER, 'Fig. 9', 'machining time of the pocket', kind='stand-in', size=(6.4, 3))
def time_of_the_pocket(picture):
    plot = picture.subplots()
    at, half = POCKET.middle()
    whole, inside = {}, {}
    for row, (link, colour, _, label) in enumerate(LINKS):
        plan = POCKET.planned(link)
        whole[link] = plan.cycle_time_s
        inside[link] = plan.period_s * np.count_nonzero(np.abs(plan['s_mm'] - at) < half + 5)
        plot.barh(row, whole[link], color=colour, alpha=0.35)
        plot.barh(row, inside[link], color=colour)
        plot.text(whole[link] + 0.03, row, f'{whole[link]:.2f} s', va='center')
    plot.set(yticks=(0, 1), yticklabels=[label for *_, label in LINKS], xlim=(0, 1.2 * whole['linear']),
             xlabel='time in s; dark: the corner and 5 mm to either side')
    return {'time with the spline / linear, corner': (inside['optimised'] / inside['linear'], 0.5),
            'time with the spline / linear, whole program': (whole['optimised'] / whole['linear'], 0.5)}


@figure('beudaert-10', PAPER, 'Fig. 10', 'the pyramid, coloured by feed', kind='stand-in', size=(6.4, 5))
def feed_on_the_pyramid(picture):
    from mpl_toolkits.mplot3d.art3d import Line3DCollection
    plan = PYRAMID.planned('optimised')
    tips, axes = trunnion.machine('ucp710').forward(plan.setpoints[::12, 1:6])
    lines = Line3DCollection(np.stack([tips, tips + PYRAMID.height * axes / axes[:, 2:]], axis=1),
                             array=plan['feed_mm_min'][::12] / 1000, cmap='viridis', linewidth=1.2)
    plot = picture.add_subplot(projection='3d')
    plot.add_collection3d(lines)
    plot.set(xlim=(-42, 42), ylim=(-42, 42), zlim=(0, 50), xlabel='x in mm', ylabel='y in mm', zlabel='z in mm',
             box_aspect=(84, 84, 50))
    picture.colorbar(lines, ax=plot, label='feed in m/min', shrink=0.6, pad=0.12)
    return {'tip off the program, mm': (plan.summary['tip_deviation_mm'], 0.02), 'cycle time, s': (plan.cycle_time_s, None)}


@figure('beudaert-11', PAPER, 'Fig. 11', 'results for the pyramid, round one corner', kind='stand-in', size=(8.5, 5))
def results_of_the_pyramid(picture):
    plots = picture.subplots(2, 2, sharex=True)
    numbers = {}
    for column, (link, colour, _, label) in zip(plots.T, LINKS):
        results(numbers, link, *draw_results(column, PYRAMID, link, colour, 0.2))
        column[0].set(title=label, ylim=(1e-6, 1e6), ylabel='criterion, Eq. 11\nin rad/mm³')
        column[1].set(xlim=(-0.2, 0.2), ylim=(0, 400), xlabel='way from the middle of the corner in mm', ylabel='feed in mm/min')
        column[1].legend(loc='upper right')
    alike = PYRAMID.corner(top_tolerance=PYRAMID.tip_tolerance).link(np.linspace(0, 1, 101))[:, 1]
    numbers["f ′ with 0.02 mm above as well"] = (alike.max(), None)
    return numbers
