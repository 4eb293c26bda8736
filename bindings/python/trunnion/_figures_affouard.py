"""Affouard, Tournier, Lavernhe, Lartigue 2004: Description formats of tool trajectory suited to High-Speed Machining.

It gives no numbers and no part: swing, blade and hollow are our own.
"""
import math

import numpy as np

import trunnion

from ._figures_drawing import BLUE, GREEN, GREY, RED, figure

PAPER = 'Affouard 2004'
HEIGHT = 50.0  # mm between the two curves


def swing(count):
    """Poses along 60 mm, the tool leaning ahead by up to 40° and back."""
    share = np.linspace(0, 1, count)
    angle = np.radians(40) * np.sin(math.pi * share)
    none = 0 * share
    return np.column_stack([60 * share, none, none]), np.column_stack([np.sin(angle), none, np.cos(angle)])


def interpolated(count):
    """The swing as two cubic splines through its poses alone."""
    return trunnion.DualPath(*swing(count), distance_mm=HEIGHT, distance_tolerance_mm=1.0)


def off_distance(path, u):
    spline = path.spline
    return np.abs(np.linalg.norm(spline.top(u) - spline.bottom(u), axis=1) - HEIGHT)


@figure('affouard-1', PAPER, 'Fig. 1', 'a trajectory as two polynomial curves', kind='stand-in', size=(9, 4.2))
def two_curves(picture):
    path = interpolated(8)
    u = np.linspace(path.begin, path.end, 801)
    plot = picture.add_subplot(1, 2, 1, projection='3d')
    for curve, colour, name in ((path.spline.bottom, BLUE, 'f, the tip'), (path.spline.top, RED, 'g, on the tool axis')):
        plot.plot(*curve(u).T, color=colour, label=name)
        plot.plot(*curve.control_points_mm.T, color=colour, linestyle=':', marker='o', markersize=3, linewidth=0.8)
    for ends in zip(path.spline.bottom(u[::50]), path.spline.top(u[::50])):
        plot.plot(*np.array(ends).T, color=GREY, linewidth=0.7)
    plot.set(xlabel='x in mm', ylabel='y in mm', zlabel='z in mm', ylim=(-20, 20), yticks=(-20, 0, 20))
    plot.legend(loc='upper left', fontsize=8)
    right, worst = picture.add_subplot(1, 2, 2), {}
    for count, colour in ((8, BLUE), (30, GREEN)):
        found = interpolated(count)
        at = np.linspace(found.begin, found.end, 4001)
        off = off_distance(found, at)
        worst[count] = off.max()
        right.semilogy((at - found.begin) / (found.end - found.begin), np.maximum(1000 * off, 1e-4), color=colour,
                       label=f'{count} poses')
    right.yaxis.tick_right()
    right.yaxis.set_label_position('right')
    right.set(xlabel='share of the path', ylabel='| |g − f| − 50 mm | in µm', ylim=(1e-3, 1e3))
    right.legend()
    exact = trunnion.DualPath(*swing(8), distance_mm=HEIGHT, distance_tolerance_mm=1e-3)
    at = np.linspace(exact.begin, exact.end, 4001)
    return {'distance off, 8 poses, mm': (worst[8], None), 'distance off, 30 poses, mm': (worst[30], None),
            'distance off where 1 µm is asked for, mm': (off_distance(exact, at).max(), 0.0)}


def hollow():
    """A quadratic face, hollow along the feed."""
    a = np.zeros((3, 3, 3))
    a[0, 0], a[1, 0], a[0, 1] = [-20, -15, 5], [40, 0, -20], [0, 30, 0]
    a[2, 0, 2] = 20
    return trunnion.Face(trunnion.BsplineSurface.polynomial(a))


def draw_surface(plot, points, colour, name):
    plot.plot_surface(*np.moveaxis(points, -1, 0), color=colour, alpha=0.45, linewidth=0)
    plot.plot([], [], color=colour, linewidth=5, alpha=0.45, label=name)


@figure('affouard-2', PAPER, 'Fig. 2', 'guiding and orientation surfaces', kind='stand-in', size=(8, 5.4))
def guiding_and_orientation(picture):
    part, radius, corner, lead = hollow(), 6.0, 2.0, math.radians(15)
    u, v = np.meshgrid(np.linspace(0, 1, 13), np.linspace(0, 1, 13), indexing='ij')
    rates = part.surface.derivatives(u, v)
    n = part.surface.shape(u, v)['normal']
    along = rates[..., 1, :] / np.linalg.norm(rates[..., 1, :], axis=-1, keepdims=True)
    guide = part.surface(u, v) + corner * n

    def orientation(angle):
        axis = math.cos(angle) * n + math.sin(angle) * along
        across = n - np.sum(n * axis, axis=-1, keepdims=True) * axis
        return guide + (radius - corner) * across / np.linalg.norm(across, axis=-1, keepdims=True)

    plot = picture.add_subplot(projection='3d')
    draw_surface(plot, part.surface(u, v), GREY, 'S')
    draw_surface(plot, guide, BLUE, 'S₁, guiding')
    draw_surface(plot, orientation(lead), GREEN, 'S₂, orientation')
    draw_surface(plot, orientation(math.pi / 2), RED, 'S_upp, axis along the feed')
    plot.set(xlabel='x in mm', ylabel='y in mm', zlabel='z in mm', box_aspect=(40, 30, 16))
    plot.legend(loc='upper left', bbox_to_anchor=(-0.3, 1))
    found = trunnion.plan_surface(part, trunnion.Tool('torus', 2 * radius, corner), lead_deg=math.degrees(lead),
                                  scallop_mm=0.05)
    return {'planned contacts off Eq. 1, mm': (off_eq1(found.contacts, radius, corner), 0.0),
            'largest distance S to S₁, mm': (np.linalg.norm(guide - part.surface(u, v), axis=-1).max(), corner)}


def off_eq1(contacts, radius, corner):
    """How far C_L of planned passes is from S + r n + (R − r) v."""
    n, axis = contacts['normals'], contacts['axes']
    v = n - np.sum(n * axis, axis=1, keepdims=True) * axis
    v /= np.linalg.norm(v, axis=1, keepdims=True)
    wanted = contacts['points_mm'] + corner * n + (radius - corner) * v
    return np.linalg.norm(contacts['tips_mm'] + corner * axis - wanted, axis=1).max()


def blade(count=21):
    """Lower and upper curve of a ruled blade, 100 mm long, 30 mm high and twisted by 30°."""
    share = np.linspace(0, 1, count)
    twist = np.radians(30) * (share - 0.5)
    lower = np.column_stack([100 * share, 0 * share, 0 * share])
    return lower, lower + 30 * np.column_stack([0 * share, np.sin(twist), np.cos(twist)])


@figure('affouard-deformation', PAPER, 'text', 'deviation of a flank before and after deformation', kind='stand-in',
        size=(8.5, 3.8))
def deformation(picture):
    surface, tool = trunnion.GuidedSurface(blade()), trunnion.FlankTool('cylinder', 5)
    path = trunnion.DualPath(*trunnion.two_point_poses(surface, tool, 21), distance_mm=HEIGHT)
    span = {'from_height_mm': 0.0, 'to_height_mm': 30.0}
    deformed, _ = trunnion.deform_flank_path(path, tool, surface, **span)
    plots, peaks = picture.subplots(1, 2, sharey=True), []
    for plot, one, name in zip(plots, (path, deformed), ('from two points', 'deformed')):
        found = trunnion.deviation_map(one, tool, surface, **span)
        micrometres = 1000 * found['deviation_mm']
        limit = np.abs(micrometres).max()
        share = (found['u'] - found['u'][0]) / np.ptp(found['u'])
        shown = plot.pcolormesh(share, found['height_mm'], micrometres.T, cmap='coolwarm', vmin=-limit, vmax=limit,
                                shading='gouraud', rasterized=True)
        picture.colorbar(shown, ax=plot, label='deviation in µm')
        plot.set(title=name, xlabel='share of the path')
        peaks.append(1000 * found['peak_mm'])
    plots[0].set(ylabel='height on the tool in mm')
    return {'peak before, µm': (peaks[0], None), 'peak after, µm': (peaks[1], None)}
