"""Lavernhe, Tournier, Lartigue 2006: Kinematical performances in 5-axis machining.

The blend is the paper's: 5 mm radius, torus tool 10/1 mm, 0.01 mm chord, 5° lead, 5 m/min; its straight parts are 60 mm long.
The machine is the shipped `ucp710` with its A at 25 rpm, which the paper's Fig. 11 asks for.
"""
import functools
import math
import tomllib

import numpy as np

import trunnion

from ._figures_drawing import BLUE, GREEN, GREY, RED, figure

PAPER = 'Lavernhe 2006'
BLEND, STRAIGHT, FEED, LEAD, CHORD = 5.0, 60.0, 5000.0, math.radians(5), 0.01  # mm, mm, mm/min, rad, mm
RADIUS, CORNER_RADIUS = 5.0, 1.0
CYCLE = 0.003  # s: the paper's example
SIDES = ((1, 'concave', BLUE), (-1, 'convex', RED))


def keys_of(thing):
    with open(thing.file, 'rb') as file:
        return tomllib.load(file)


@functools.lru_cache
def machine():
    keys = keys_of(trunnion.machine('ucp710'))
    keys['axes']['A']['max_velocity'] = '25 rpm'
    return trunnion.machine(keys)


def setup():
    return trunnion.setup({'tool': {'kind': 'torus', 'diameter': f'{2 * RADIUS} mm', 'corner_radius': f'{CORNER_RADIUS} mm'}})


def touching(turned, side):
    """Contact, normal and feed in the plane Y Z, of angles along the blend."""
    s, c = np.sin(turned), np.cos(turned)
    none = np.zeros_like(s)
    rows = (none, BLEND * s, side * BLEND * (1 - c)), (none, -side * s, c), (none, c, side * s)
    return [np.stack(row, axis=-1) for row in rows]


def placed(turned, side):
    """Tip, axis and feed of the tool at angles along the blend."""
    contact, normal, feed = touching(np.asarray(turned, float), side)
    axis = math.cos(LEAD) * normal + math.sin(LEAD) * feed
    across = normal - np.sum(normal * axis, axis=-1, keepdims=True) * axis
    across /= np.linalg.norm(across, axis=-1, keepdims=True)
    return contact + CORNER_RADIUS * (normal - axis) + (RADIUS - CORNER_RADIUS) * across, axis, feed


def chords():
    return math.ceil(math.pi / 2 / (2 * math.acos(1 - CHORD / BLEND)))


def blend_poses(side):
    tips, axes, feeds = placed(np.linspace(0, math.pi / 2, chords() + 1), side)
    return (np.vstack([tips[0] - STRAIGHT * feeds[0], tips, tips[-1] + STRAIGHT * feeds[-1]]),
            np.vstack([axes[0], axes, axes[-1]]))


@functools.lru_cache
def followed(side):
    """What the modelled control makes of the blend: its samples by name."""
    tips, axes = blend_poses(side)
    program = trunnion.program_from_poses(tips, axes, feed_mm_min=FEED)
    found = trunnion.predict(program, machine(), trunnion.controller('lavernhe-2006'), setup(),
                             contact_tilt_deg=math.degrees(LEAD), uncertainty=False, samples=True)
    return dict(zip(found.columns, found.samples.T))


def axis_positions(side):
    return machine().inverse(*blend_poses(side), setup())


@figure('lavernhe-table-2', PAPER, 'Table 2', 'how many solutions the range of A leaves', size=(8, 3))
def solutions(picture):
    kinematics = machine().kinematics()
    low, high = machine().axes[3]['range']
    k = np.linspace(-0.9995, 0.9995, 4001)
    tilts = kinematics.branches(np.column_stack([0 * k, np.sqrt(1 - k * k), k]))[:, :, 0]
    count = np.count_nonzero((tilts >= low) & (tilts <= high), axis=1)
    plot = picture.subplots()
    plot.step(k, count, where='mid', color=BLUE)
    for at in (-0.5, 0.866):
        plot.axvline(at, color=RED, linestyle=':', label='published' if at < 0 else None)
    plot.set(xlabel='k of the tool axis', ylabel='solutions', yticks=(0, 1, 2))
    plot.legend(loc='upper left')
    return {'k from which there is one': (k[np.argmax(count == 1)], -0.5),
            'k from which there are two': (k[np.argmax(count == 2)], 0.866)}


@figure('lavernhe-4', PAPER, 'Fig. 4', 'interpolation between axis configurations', kind='stand-in', size=(8, 3.8))
def articular_interpolation(picture):
    places = trunnion.setup({'workpiece': {'origin': ['0 mm', '40 mm', '80 mm']}})
    share = np.linspace(0, 1, 161)
    tilt = np.radians(60) * share
    q = machine().inverse(np.column_stack([0 * share, 60 * share, 0 * share]),
                          np.column_stack([0 * tilt, -np.sin(tilt), np.cos(tilt)]), places)[:, 1:4]
    off, parts = [], (1, 2, 4, 8, 16)
    left, right = picture.subplots(1, 2)
    left.plot(q[:, 0], q[:, 1], color=BLUE, label='the program')
    for n in parts:
        knots = np.linspace(0, 1, n + 1)
        straight = np.column_stack([np.interp(share, knots, np.interp(knots, share, column)) for column in q.T])
        off.append(np.linalg.norm((straight - q)[:, :2], axis=1).max())
        if n in (1, 4):
            left.plot(straight[:, 0], straight[:, 1], color=RED if n == 1 else GREEN, linestyle='--',
                      label=f'straight, {n} part{"s" * (n > 1)}')
    left.set(xlabel='Y in mm', ylabel='Z in mm')
    left.legend()
    right.loglog(parts, off, color=BLUE, marker='o')
    right.set(xlabel='parts of the block', ylabel='largest error of Y, Z in mm', xticks=parts, xticklabels=parts)
    right.minorticks_off()
    return {'largest error in one part, mm': (off[0], None), 'error of 8 parts / of 16': (off[3] / off[4], None)}


@figure('lavernhe-7', PAPER, 'Fig. 7', 'look-ahead and the velocity', kind='stand-in', size=(8, 3.6))
def look_ahead(picture):
    keys = keys_of(trunnion.controller('lavernhe-2006'))
    y = np.arange(0, 81, 2.0)
    upright = np.tile([0, 0, 1.0], (len(y), 1))
    program = trunnion.program_from_poses(np.column_stack([0 * y, y - 40, 0 * y]), upright, feed_mm_min=10000)
    plot, top = picture.subplots(), {}
    for blocks, colour in ((1, RED), (10, BLUE)):
        keys['parameters']['look_ahead_blocks']['value'] = blocks
        found = trunnion.predict(program, machine(), trunnion.controller(keys), uncertainty=False, samples=True)
        time, feed = (found.samples[:, found.columns.index(name)] for name in ('t_s', 'feed_mm_min'))
        plot.plot(time, feed / 1000, color=colour, label=f'{blocks} block{"s" * (blocks > 1)} ahead')
        top[blocks] = feed.max()
    plot.set(xlabel='time in s', ylabel='feed in m/min', ylim=(0, None))
    plot.legend(loc='upper right')
    return {'highest feed, 10 blocks / 1 block': (top[10] / top[1], None), 'highest feed, 10 blocks, mm/min': (top[10], None)}


def outline(tip, axis):
    """The section of the tool in Y Z, 14 mm high."""
    angle = np.linspace(0, math.pi / 2, 15)
    out = np.concatenate([[RADIUS], RADIUS - CORNER_RADIUS + CORNER_RADIUS * np.cos(angle)])
    up = np.concatenate([[14], CORNER_RADIUS - CORNER_RADIUS * np.sin(angle)])
    out, up = np.concatenate([out, -out[::-1]]), np.concatenate([up, up[::-1]])
    aside = np.array([axis[2], -axis[1]])
    return tip[1:] + out[:, None] * aside + up[:, None] * axis[1:]


@figure('lavernhe-8', PAPER, 'Fig. 8', 'the blending radius', size=(8, 3.8))
def blend(picture):
    for plot, (side, name, colour) in zip(picture.subplots(1, 2), SIDES):
        contact, _, feed = touching(np.linspace(0, math.pi / 2, 91), side)
        surface = np.vstack([contact[0] - 15 * feed[0], contact, contact[-1] + 15 * feed[-1]])
        plot.plot(surface[:, 1], surface[:, 2], color=GREY, linewidth=2, label='surface')
        tips, axes = blend_poses(side)
        plot.plot(tips[1:-1, 1], tips[1:-1, 2], color=colour, marker='.', label='Cl points')
        for k in (1, 1 + chords() // 2, 1 + chords()):
            plot.plot(*outline(tips[k], axes[k]).T, color=GREEN, linewidth=1)
        plot.set(aspect='equal', xlabel='y in mm', ylabel='z in mm', title=name)
        plot.legend(loc='lower left' if side < 0 else 'upper left', fontsize=8)
    return {'chords on the blend': (chords(), 25.0)}


@figure('lavernhe-9', PAPER, 'Fig. 9', 'axis configurations at the Cl points', size=(8, 3.6))
def configurations(picture):
    linear, rotary = picture.subplots(1, 2)
    q = axis_positions(1)
    for column, letter, colour in ((1, 'Y', BLUE), (2, 'Z', GREEN)):
        linear.plot(q[:, column], color=colour, marker='.', label=letter)
    rotary.plot(q[:, 3], color=RED, marker='.', label='A')
    linear.set(xlabel='Cl point', ylabel='position in mm')
    rotary.set(xlabel='Cl point', ylabel='position in deg')
    linear.legend()
    rotary.legend()
    return {'movement of X, mm': (np.ptp(q[:, 0]), 0.0), 'movement of C, deg': (np.ptp(q[:, 4]), 0.0),
            'movement of A, deg': (np.ptp(q[:, 3]), 90.0)}


@figure('lavernhe-10', PAPER, 'Fig. 10', 'inverse-time limits of every block', size=(8, 3.8))
def inverse_time(picture):
    q = axis_positions(1)
    moved = np.abs(np.diff(q, axis=0))
    programmed = FEED / 60 / np.linalg.norm(np.diff(blend_poses(1)[0], axis=0), axis=1)
    block = np.arange(1, len(moved) + 1)
    plot = picture.subplots()
    plot.step(block, programmed, where='mid', color='black', label='programmed, 1/Δt')
    limits = {}
    for k, colour in ((1, BLUE), (2, GREEN), (3, RED)):
        axis = machine().axes[k]
        limits[axis['letter']] = axis['limits']['velocity'] / np.where(moved[:, k] > 1e-9, moved[:, k], np.nan)
        plot.step(block, limits[axis['letter']], where='mid', color=colour, label=axis['letter'])
    plot.axhline(1 / CYCLE, color=GREY, linestyle=':', label='interpolator cycle, 3 ms')
    plot.set(yscale='log', xlabel='block', ylabel='inverse time in 1/s')
    plot.legend(ncols=3, loc='lower center')
    on_blend = slice(1, -1)
    lowest = min(limits, key=lambda letter: np.min(limits[letter][on_blend]))
    return {'limit of A / programmed, on the blend': (np.median(limits['A'][on_blend] / programmed[on_blend]), None),
            'A is the lowest there': (float(lowest == 'A'), 1.0),
            'way of a cycle at 20 m/min, mm': (20000 / 60 * CYCLE, 1.0)}


@figure('lavernhe-11', PAPER, 'Fig. 11', 'predicted velocities of the axes', size=(8, 4.6))
def velocities(picture):
    rows = followed(1)
    linear, rotary = picture.subplots(2, 1, sharex=True)
    for name, colour in (('Y', BLUE), ('Z', GREEN)):
        linear.plot(rows['t_s'], 0.06 * rows[f'{name}_mm_s'], color=colour, label=name)
    rotary.plot(rows['t_s'], rows['A_deg_s'] / 6, color=RED, label='A')
    linear.set(ylabel='velocity in m/min')
    rotary.set(ylabel='velocity in rpm', xlabel='time in s')
    linear.legend(loc='upper center')
    rotary.legend(loc='upper right')
    return {'highest velocity of A, rpm': (np.abs(rows['A_deg_s']).max() / 6, None),
            'highest velocity of Y, m/min': (0.06 * np.abs(rows['Y_mm_s']).max(), 5.0)}


@figure('lavernhe-12', PAPER, 'Fig. 12', 'feed along the path', size=(8, 5))
def feed_along_the_path(picture):
    numbers = {}
    for plot, (side, name, colour) in zip(picture.subplots(2, 1), SIDES):
        rows = followed(side)
        blend_rows = (rows['line'] > rows['line'][0]) & (rows['line'] < rows['line'][-1])
        plot.axhline(FEED / 1000, color=GREY, linestyle=':', label='programmed')
        plot.plot(rows['s_mm'], rows['feed_mm_min'] / 1000, color=colour, label='tip')
        plot.plot(rows['s_mm'], rows['contact_feed_mm_min'] / 1000, color='black', linewidth=0.8, label='contact')
        plot.set(title=name, ylabel='feed in m/min', ylim=(0, 6))
        step = np.diff(rows['t_s'])[blend_rows[1:]]
        ways = [np.sum(step * (rows[key][1:] + rows[key][:-1])[blend_rows[1:]]) / 120
                for key in ('feed_mm_min', 'contact_feed_mm_min')]
        numbers |= {f'{name}: feed on the straights, mm/min': (rows['feed_mm_min'].max(), 5000.0),
                    f'{name}: feed at the ends of the blend, mm/min': (rows['feed_mm_min'][blend_rows].min(), 0.0),
                    f'{name}: highest on the blend, mm/min': (rows['feed_mm_min'][blend_rows].max(), 1000.0),
                    f'{name}: way of the tip / of the contact': (ways[0] / ways[1], 1.0)}
    plot.set(xlabel='way of the tip in mm')
    plot.legend(loc='upper center', ncols=3)
    return numbers
