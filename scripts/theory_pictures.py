#!/usr/bin/env python3
"""Draws the pictures of docs/theory: of feed-planning.md, smoothing.md, kinematics.md and checking.md from formulas and from what
`trunnion plan` and `trunnion check` write, of corner-rounding.md from what examples/03_corner writes.

    scripts/theory_pictures.py [--trunnion build/release/apps/trunnion/trunnion]
                               [--corner build/release/examples/03_corner/example_corner] [--output docs/theory/pictures]

Needs matplotlib: `apt-get install python3-matplotlib`, and then /usr/bin/python3."""
import argparse
import itertools
import json
import pathlib
import re
import subprocess
import sys
import tempfile

try:
    import matplotlib
    import numpy as np
except ImportError:
    sys.exit(__doc__)

matplotlib.use('svg')
from matplotlib import pyplot  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parent.parent
BLADE = ROOT / 'examples/01_first_plan'
MACHINE = 'ucp710'
FEED = '20m/min'
PASS = 3  # which stretch of the blade, from 0: the second cut
AXES = 'XYZAC'
# Okabe and Ito: told apart by people who are colour-blind.
COLOUR = dict(zip(AXES, ('#0072B2', '#D55E00', '#009E73', '#CC79A7', '#000000')))
GREY, BLUE, RED = '#666666', '#0072B2', '#D55E00'
LIMITING_FROM = 0.97  # of a limit, as in plan_stretch.cpp
SAMPLES_PER_PIECE = 4

LINE_LENGTH, LINE_SPEED, LINE_ACCELERATION, LINE_JERK = 100, 100, 1000, 20000  # mm, mm/s, mm/s², mm/s³
LINE_PROGRAM = f'G21 G90 G94\nG0 X0 Y0 Z0\nG1 X{LINE_LENGTH} F{60 * LINE_SPEED}\nM2\n'
LINE_MACHINE = 'name = "line"\nchain = "X Y Z"\n' + ''.join(
    f'[axes.{axis}]\nrange = ["-400 mm", "400 mm"]\nmax_velocity = "{0.06 * LINE_SPEED} m/min"\n'
    f'max_acceleration = "{LINE_ACCELERATION / 1000} m/s^2"\nmax_jerk = "{LINE_JERK / 1000} m/s^3"\n' for axis in 'XYZ')


MIXED_RADIUS, MIXED_CHORD, MIXED_TOLERANCE = 15, 0.3, 0.02  # mm: straight, a dense quarter circle, a corner, straight
CONE_LEAN, CONE_RADIUS, CONE_TURN, CONE_STARTS = 20, 25, 320, (10, 200, 30, 100, 300)  # deg, mm, deg, deg
C_RANGE = 400  # deg to either side
CIRCLE_RADIUS, CIRCLE_SPEED, CIRCLE_PERIODS = 20, 200, (1, 2, 4, 8, 16)  # mm, mm/s, ms
PASS_LENGTH, PASS_APART, PASS_OFF = 10, 0.03, 0.02  # mm


def read_table(file):
    names = file.open().readline().strip().split(',')
    values = np.loadtxt(file, delimiter=',', skiprows=1)
    return {name: values[:, k] for k, name in enumerate(names)}


def plan(trunnion, program, machine, *options):
    """Setpoints and path samples as columns by name."""
    with tempfile.TemporaryDirectory() as folder:
        setpoints, samples = (pathlib.Path(folder) / name for name in ('setpoints.csv', 'path.csv'))
        subprocess.run([trunnion, 'plan', program, '-m', machine, '-o', setpoints, '--path', samples, '--quiet', *options],
                       check=True, stdout=subprocess.DEVNULL)
        return read_table(setpoints), read_table(samples)


def axis_limits(trunnion, machine):
    """Velocity, acceleration and jerk of every axis in mm or degrees, as the program understands the machine."""
    shown = subprocess.run([trunnion, 'machine', 'show', machine], check=True, capture_output=True, text=True).stdout
    number = r'([\d.e+]+) (?:mm|deg)/s'
    rows = re.findall(rf'^\s+(\w) .*?{number}\s+{number}\^2\s+{number}\^3', shown, re.M)
    return {letter: [float(value) for value in values] for letter, *values in rows}


def stretches_of(samples):
    """Slices from standstill to standstill."""
    rest = np.flatnonzero(samples['speed_mm_s'] == 0)
    return [slice(begin, end + 1) for begin, end in zip(rest[:-1], rest[1:]) if end > begin + 1]


class Stretch:
    """x, x′, x″ at the path samples of one stretch, one-sided at knots, and the axes' loads there."""

    def __init__(self, samples, where, limits):
        self.limits = limits
        self.columns = {name: values[where] for name, values in samples.items()}
        p = self.columns['p_mm']
        self.knots = p[::SAMPLES_PER_PIECE] - p[0]
        rows = range(0, len(p) - 1, SAMPLES_PER_PIECE)
        self.index = np.concatenate([np.arange(k, k + SAMPLES_PER_PIECE + 1) for k in rows])
        self.p = p[self.index] - p[0]
        self.speed = self.columns['speed_mm_s'][self.index]
        self.speed_limit = self.columns['speed_limit_mm_s'][self.index]
        pieces = self.p.reshape(-1, SAMPLES_PER_PIECE + 1)
        d, e = zip(*(self.derivatives(k, len(pieces), u - u[0], u[-1] - u[0]) for k, u in enumerate(pieces)))
        self.x, self.d, self.e = self.speed ** 2, np.concatenate(d), np.concatenate(e)

    def derivatives(self, piece, pieces, u, length):
        """x′ and x″ by p: of a cubic between knots, of α u^(4/3) on the arcs at both ends."""
        x = self.speed[piece * len(u):(piece + 1) * len(u)] ** 2
        if 0 < piece < pieces - 1:
            cubic = np.polynomial.Polynomial.fit(u, x, 3)
            return cubic.deriv(1)(u), cubic.deriv(2)(u)
        start = piece == 0
        from_rest = np.maximum(u if start else length - u, 1e-9 * length)
        alpha = (x[-1] if start else x[0]) / length ** (4 / 3)
        return (1 if start else -1) * 4 / 3 * alpha * np.cbrt(from_rest), 4 / 9 * alpha / np.cbrt(from_rest) ** 2

    def rates(self, axis):
        return (self.columns[f'{axis}{order}'][self.index] for order in ('_p', '_pp', '_ppp'))

    def loads(self):
        """Share of every limit, by name; of the feed last."""
        out = {}
        slowest = np.full(len(self.p), np.inf)
        for axis, (velocity, acceleration, jerk) in self.limits.items():
            q1, q2, q3 = self.rates(axis)
            out[f'{axis} velocity'] = np.abs(q1) * self.speed / velocity
            out[f'{axis} acceleration'] = np.abs(q2 * self.x + q1 * self.d / 2) / acceleration
            out[f'{axis} jerk'] = np.abs(q3 * self.x + 1.5 * q2 * self.d + q1 * self.e / 2) * self.speed / jerk
            slowest = np.minimum(slowest, velocity / np.maximum(np.abs(q1), 1e-12))
        out['feed'] = np.where(self.speed_limit < 0.999 * slowest, self.speed / self.speed_limit, 0)
        return out

    def causes(self):
        """What holds the speed down on every piece; None where nothing does."""
        loads = self.loads()
        names = list(loads)
        peaks = np.array([load.reshape(-1, SAMPLES_PER_PIECE + 1).max(axis=1) for load in loads.values()])
        worst = np.argmax(peaks, axis=0)
        return [names[k] if peaks[k, piece] > LIMITING_FROM else None for piece, k in enumerate(worst)]

    def jerk_free_speed(self):
        """The fastest speed under velocities and accelerations alone: a scan backwards, then one forwards."""
        b, c = [], []
        for axis, (_, acceleration, _) in self.limits.items():
            q1, q2, _ = self.rates(axis)
            sign = np.where(q1 < 0, -1, 1) / acceleration
            b.append(q2 * sign)
            c.append(q1 * sign / 2)
        b, c = np.array(b), np.array(c)
        cross = np.abs(b[:, None] * c[None] - b[None] * c[:, None])
        with np.errstate(divide='ignore', invalid='ignore'):
            pairs = np.where(cross > 0, (c[:, None] + c[None]) / cross, np.inf)
        x = np.minimum(self.speed_limit ** 2, np.min(pairs, axis=(0, 1)))
        x[0] = x[-1] = 0
        for k in range(len(x) - 2, -1, -1):
            h = self.p[k + 1] - self.p[k]
            slope, room = c[:, k] - h * b[:, k], c[:, k] * x[k + 1] + h
            x[k] = min([x[k], *(room[slope > 0] / slope[slope > 0])]) if h > 0 else min(x[k], x[k + 1])
        for k in range(len(x) - 1):
            h = self.p[k + 1] - self.p[k]
            moves = c[:, k] > 0
            x[k + 1] = min(x[k + 1], x[k] + h * np.min((1 - b[moves, k] * x[k]) / c[moves, k]))
        return np.sqrt(x)


def draw_speed(stretch, file):
    figure, (top, bottom) = pyplot.subplots(2, 1, figsize=(8, 5.4), sharex=True, gridspec_kw={'height_ratios': [3, 2]})
    p = stretch.p
    highest = 1.1 * min(np.max(stretch.speed_limit), 1.2 * np.max(stretch.jerk_free_speed()))
    top.plot(p, stretch.speed_limit, color=GREY, linewidth=1, linestyle=':', label='feed and velocities of the axes allow')
    top.plot(p, stretch.jerk_free_speed(), color=RED, linewidth=1.2, linestyle='--', label='and accelerations')
    top.plot(p, stretch.speed, color=BLUE, linewidth=1.8, label='and jerks: the plan')
    top.set(ylabel='path speed ṗ in mm/s', ylim=(0, highest))
    top.legend(loc='lower center', bbox_to_anchor=(0.45, 1), ncols=3, frameon=False, fontsize=10)
    causes = stretch.causes()
    names = [name for name in stretch.loads() if name in causes]
    for cause, pieces in itertools.groupby(range(len(causes)), key=causes.__getitem__):
        pieces = list(pieces)
        begin, end = stretch.knots[pieces[0]], stretch.knots[pieces[-1] + 1]
        if cause:
            bottom.broken_barh([(begin, end - begin)], (names.index(cause) - 0.35, 0.7), color=COLOUR.get(cause[0], GREY))
    bottom.set(xlabel='path parameter p in mm', ylabel='limited by', yticks=range(len(names)), yticklabels=names,
               ylim=(len(names) - 0.4, -0.6))
    bottom.set_axisbelow(True)
    bottom.grid(axis='x', color='#dddddd')
    finish(figure, file)


def shares(setpoints, limits):
    """Velocity, acceleration and jerk of every axis at times, as share of the limits, by differences of the setpoints."""
    t = setpoints['t_s']
    period = t[1] - t[0]
    for axis, axis_limit in limits.items():
        column = next(values for name, values in setpoints.items() if name.startswith(axis + '_'))
        yield axis, [(t[order:] - order * period / 2, np.diff(column, order) / period ** order / limit)
                     for order, limit in enumerate(axis_limit, 1)]


def draw_axes(stretch, setpoints, window, file):
    figure, rows = pyplot.subplots(3, 1, figsize=(8, 6.6), sharex=True)
    edge = 2 * setpoints['t_s'][1]  # beyond it a third difference also sees the standstill
    for axis, by_order in shares(setpoints, stretch.limits):
        for plot, (t, share) in zip(rows, by_order):
            inside = (t > window[0] + edge) & (t < window[1] - edge)
            plot.plot(t[inside] - window[0], share[inside], color=COLOUR[axis], label=axis,
                      linewidth=1.8 if axis == 'C' else 1)
    for plot, what in zip(rows, ('velocity', 'acceleration', 'jerk')):
        plot.axhline(1, color=GREY, linewidth=0.8, linestyle=':')
        plot.axhline(-1, color=GREY, linewidth=0.8, linestyle=':')
        plot.set(ylabel=f'{what}\nof its limit', ylim=(-1.15, 1.15), yticks=(-1, 0, 1))
    rows[0].legend(loc='lower center', bbox_to_anchor=(0.5, 1), ncols=len(stretch.limits), frameon=False)
    rows[2].set_xlabel('time in s')
    finish(figure, file)


def draw_calm(trunnion, file):
    figure, (top, bottom) = pyplot.subplots(2, 1, figsize=(8, 4.6), sharex=True)
    with tempfile.TemporaryDirectory() as folder:
        program, machine = pathlib.Path(folder) / 'line.ngc', pathlib.Path(folder) / 'line.toml'
        program.write_text(LINE_PROGRAM)
        machine.write_text(LINE_MACHINE)
        limits = {'X': [LINE_SPEED, LINE_ACCELERATION, LINE_JERK]}
        for calm, colour, style in ((0.001, RED, '--'), (0.3, BLUE, '-')):
            setpoints, _ = plan(trunnion, program, machine, '--calm', str(calm), '--period', '0.25ms')
            (_, (velocity, _, jerk)), = shares(setpoints, limits)
            label = f'calm {calm}'
            top.plot(*velocity, color=colour, linestyle=style, label=label)
            bottom.plot(*jerk, color=colour, linestyle=style, label=label)
    top.set(ylabel='velocity\nof its limit', ylim=(0, 1.1), yticks=(0, 1), xlim=(0, 0.25))
    bottom.set(ylabel='jerk\nof its limit', xlabel='time from standstill in s', ylim=(-1.15, 1.15), yticks=(-1, 0, 1))
    top.legend(loc='lower right', frameon=False)
    finish(figure, file)


def draw_rest(stretch, file):
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(8, 3.4))
    x = np.interp(stretch.knots, stretch.p, stretch.x)
    shown = stretch.knots <= 12 * stretch.knots[1]
    power = stretch.knots[shown] ** (4 / 3)
    alpha = x[1] / stretch.knots[1] ** (4 / 3)
    left.plot(power, alpha * power, color=RED, linestyle='--', label='α p$^{4/3}$ of the arc')
    left.plot(power, x[shown], color=BLUE, marker='o', markersize=4, label='plan, its knots marked')
    left.set(xlabel='p$^{4/3}$, p in mm', ylabel='x = ṗ² in mm²/s²', xlim=(0, None), ylim=(0, 1.3 * np.max(x[shown])))
    left.legend(loc='lower right', frameon=False)
    right.step(stretch.knots, np.append(np.diff(stretch.knots), np.nan), where='post', color=BLUE)
    right.set(yscale='log', xlabel='p in mm', ylabel='length of the interval in mm')
    right.grid(color='#dddddd')
    finish(figure, file)


def draw_smoothing_kernels(file):
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(8, 3.4))
    t = np.linspace(-1, 1, 401)
    s = t * t
    for name, colour, density, even in (
            ('curve', BLUE, 105 / 64 * (1 - s) ** 2 * (1 - 3 * s), np.array([35, 420, -350, 196, -45]) / 512),
            ('corner', RED, 35 / 32 * (1 - s) ** 3, np.array([35, 140, -70, 28, -5]) / 256)):
        left.plot(t, density, color=colour, label=name)
        right.plot(t, np.polynomial.Polynomial(even)(s) - np.abs(t) / 2, color=colour)
    for plot, what in ((left, 'k(t)'), (right, 'g(t)')):
        plot.axhline(0, color=GREY, linewidth=0.8, linestyle=':')
        plot.set(xlabel='t', ylabel=what)
    left.legend(loc='upper right', frameon=False)
    finish(figure, file)


def mixed_path():
    """Vertices: 20 mm straight, a quarter circle in short chords with three decimals, a corner, 12 mm straight."""
    quarter = np.pi / 2
    angles = np.linspace(0, quarter, int(MIXED_RADIUS * quarter / MIXED_CHORD) + 1)[1:]
    arc = np.round([(20 + MIXED_RADIUS * np.sin(a), MIXED_RADIUS * (1 - np.cos(a))) for a in angles], 3)
    return np.vstack([(0, 0), (20, 0), arc, arc[-1] - (12, 0)])


def draw_smoothing_course(trunnion, file):
    vertices = mixed_path()
    with tempfile.TemporaryDirectory() as folder:
        program, machine = pathlib.Path(folder) / 'mixed.ngc', pathlib.Path(folder) / 'line.toml'
        program.write_text('G21 G90 G94\nG0 X0 Y0 Z0\n' +
                           ''.join(f'G1 X{x:.3f} Y{y:.3f} F6000\n' for x, y in vertices[1:]) + 'M2\n')
        machine.write_text(LINE_MACHINE)
        _, path = plan(trunnion, program, machine, '--tip-tolerance', f'{MIXED_TOLERANCE}mm')
    p = path['p_mm']
    at_vertex = np.append(0, np.cumsum(np.hypot(*np.diff(vertices, axis=0).T)))
    off = [path[f'tip_{axis}_mm'] - np.interp(p, at_vertex, vertices[:, k]) for k, axis in enumerate('xy')]
    figure, (top, bottom) = pyplot.subplots(2, 1, figsize=(8, 5), sharex=True)
    top.plot(p, 1000 * np.hypot(*off), color=BLUE)
    top.axhline(1000 * MIXED_TOLERANCE, color=GREY, linewidth=0.8, linestyle=':')
    top.set(ylabel='off the program\nat the same p in µm', ylim=(0, None))
    bottom.plot(p, np.hypot(path['X_pp'], path['Y_pp']), color=BLUE)
    bottom.axhline(1 / MIXED_RADIUS, color=GREY, linewidth=0.8, linestyle=':')
    bottom.set(ylabel='curvature in 1/mm', xlabel='p in mm', ylim=(0, 2.5 / MIXED_RADIUS))
    finish(figure, file)


def draw_kinematics_cones(file):
    """β over ψ, and how fast the second axis is where the tool leans over at a rate of 1."""
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(8, 3.6))
    psi = np.radians(np.linspace(-180, 180, 721))
    for first, last, colour, style in ((90, 90, BLUE, '-'), (45, 45, RED, '--'), (90, 45, COLOUR['Z'], '-.')):
        e1, e2 = np.radians((first, last))
        beta = np.arccos(np.clip(np.cos(e1) * np.cos(e2) + np.sin(e1) * np.sin(e2) * np.cos(psi), -1, 1))
        left.plot(np.degrees(psi), np.degrees(beta), color=colour, linestyle=style, label=f'{first}°, {last}°')
        inside = (psi > 0) & (psi < np.pi - 1e-9)
        share = np.sin(beta[inside]) / (np.sin(e1) * np.sin(e2) * np.sin(psi[inside]))
        right.plot(np.degrees(beta[inside]), share, color=colour, linestyle=style)
    left.set(xlabel='ψ in degrees', ylabel='β in degrees', xticks=range(-180, 181, 90), yticks=range(0, 181, 45))
    left.legend(title='e₁, e₂', loc='lower right', frameon=False, fontsize=10)
    right.set(xlabel='β in degrees', ylabel='dψ/dβ', xticks=range(0, 181, 45), ylim=(0, 6))
    finish(figure, file)


def cone_program():
    """Cuts round a cone, each beginning anew behind a retract."""
    lean, out = np.radians(CONE_LEAN), ['PARTNO/CONES', 'UNITS/MM', 'MULTAX/ON', 'LOADTL/1']
    for start in CONE_STARTS:
        poses = [(CONE_RADIUS * np.cos(a), CONE_RADIUS * np.sin(a), np.sin(lean) * np.cos(a), np.sin(lean) * np.sin(a))
                 for a in np.radians(start + np.arange(0, CONE_TURN + 1, 5))]
        goto = ['GOTO/{:.6f},{:.6f},{{}},{:.9f},{:.9f},{:.9f}'.format(*pose, np.cos(lean)) for pose in poses]
        out += ['RAPID', goto[0].format(40), 'FEDRAT/3000.0,MMPM', *(line.format(2) for line in goto)]
        out += ['RAPID', goto[-1].format(40)]
    return '\n'.join([*out, 'FINI', ''])


def draw_kinematics_winding(trunnion, file):
    with tempfile.TemporaryDirectory() as folder:
        program, machine, setup = (pathlib.Path(folder) / name for name in ('cones.cls', 'limited.toml', 'setup.toml'))
        program.write_text(cone_program())
        shipped = (ROOT / f'data/machines/{MACHINE}.toml').read_text()
        machine.write_text(shipped.replace('range = "endless"', f'range = ["-{C_RANGE} deg", "{C_RANGE} deg"]'))
        setup.write_text('[tools.1]\nkind = "ball"\ndiameter = "8 mm"\nlength = "0 mm"\n')
        setpoints, _ = plan(trunnion, program, machine, '--setup', setup, '--period', '10ms')
    figure, (top, bottom) = pyplot.subplots(2, 1, figsize=(8, 4.6), sharex=True, gridspec_kw={'height_ratios': [3, 1]})
    for plot, axis in ((top, 'C'), (bottom, 'A')):
        plot.plot(setpoints['t_s'], setpoints[f'{axis}_deg'], color=COLOUR[axis])
        plot.set(ylabel=f'{axis} in degrees')
    for border in (-C_RANGE, C_RANGE):
        top.axhline(border, color=GREY, linewidth=0.8, linestyle=':')
    top.set(yticks=range(-360, 361, 180))
    bottom.set(xlabel='time in s', yticks=(-20, 0, 20))
    finish(figure, file)


def in_order(squares):
    """The column of every row, never going back, with the least sum."""
    came_from, cost = [], squares[0]
    for row in squares[1:]:
        best = np.minimum.accumulate(cost)
        came_from.append(np.maximum.accumulate(np.where(cost == best, np.arange(len(cost)), 0)))
        cost = best + row
    out = [int(np.argmin(cost))]
    for step in reversed(came_from):
        out.append(int(step[out[-1]]))
    return np.array(out[::-1])


def draw_checking_order(file):
    corners = np.array([(0, 0), (PASS_LENGTH, 0), (PASS_LENGTH, PASS_APART), (0, PASS_APART)])
    way = np.append(0, np.cumsum(np.hypot(*np.diff(corners, axis=0).T)))
    places = np.arange(0, way[-1], 0.02)
    path = np.stack([np.interp(places, way, corners[:, k]) for k in range(2)], axis=1)
    rows = np.linspace(0, PASS_LENGTH, 101)
    there = np.stack([rows, np.where(rows > 1, PASS_OFF, PASS_OFF * rows)], axis=1)
    motion = np.vstack([there, np.stack([rows[::-1], np.full_like(rows, PASS_APART)], axis=1)])
    squares = ((motion[:, None] - path[None]) ** 2).sum(axis=2)
    figure, (top, bottom) = pyplot.subplots(2, 1, figsize=(8, 5), gridspec_kw={'height_ratios': [2, 3]})
    top.plot(*corners.T, color=GREY, label='program')
    top.plot(*motion.T, color=BLUE, linewidth=1, marker='.', markersize=3, label='motion')
    top.set(xlabel='x in mm', ylabel='y in mm')
    top.legend(loc='center', ncols=2, frameon=False)
    bottom.plot(places[np.argmin(squares, axis=1)], color=RED, linestyle='--', label='nearest place')
    bottom.plot(places[in_order(squares)], color=BLUE, label='by order')
    bottom.set(xlabel='row', ylabel='way of its place in mm')
    bottom.legend(loc='lower right', frameon=False)
    finish(figure, file)


def pose_deviation(trunnion, folder, period_ms):
    """Of the poses of a full circle from its motion, by `trunnion check`, mm."""
    program, machine, setpoints, verdict = (folder / name for name in ('circle.ngc', 'line.toml', 'circle.csv', 'v.json'))
    program.write_text(f'G21 G90 G94 G17\nG0 X{CIRCLE_RADIUS} Y0 Z0\n'
                       f'G3 X{CIRCLE_RADIUS} Y0 I-{CIRCLE_RADIUS} J0 F{60 * CIRCLE_SPEED}\nM2\n')
    machine.write_text(LINE_MACHINE.replace(f'{0.06 * LINE_SPEED} m/min', '30 m/min')
                       .replace(f'{LINE_ACCELERATION / 1000} m/s', '5 m/s').replace(f'{LINE_JERK / 1000} m/s', '100 m/s'))
    options = ['-m', machine, '--quiet']
    subprocess.run([trunnion, 'plan', program, *options, '--rounding', 'none', '--period', f'{period_ms}ms', '-o', setpoints],
                   stdout=subprocess.DEVNULL, check=True)
    subprocess.run([trunnion, 'check', setpoints, '--against', program, *options, '--summary', verdict],
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)  # breaks the tolerance where periods are long
    return json.loads(verdict.read_text())['tip_to_poses_mm']


def draw_checking_sagitta(trunnion, file):
    periods = np.array(CIRCLE_PERIODS)
    with tempfile.TemporaryDirectory() as folder:
        seen = [pose_deviation(trunnion, pathlib.Path(folder), period) for period in CIRCLE_PERIODS]
    figure, plot = pyplot.subplots(figsize=(8, 3.2))
    plot.loglog(periods, 1000 * (CIRCLE_SPEED * periods / 1000) ** 2 / (8 * CIRCLE_RADIUS), color=GREY, linestyle='--',
                label='(vτ)²/8R')
    plot.loglog(periods, 1000 * np.array(seen), color=BLUE, marker='o', linestyle='none', label='poses off the motion')
    plot.set(xlabel='period in ms', ylabel='µm')
    plot.set_xticks(periods, [str(period) for period in periods])
    plot.minorticks_off()
    plot.legend(frameon=False)
    finish(figure, file)


def corner_tables(program):
    """What examples/03_corner writes, by the name of the table."""
    if not program.exists():
        sys.exit(f'{program} is missing: scripts/build.sh release example_corner')
    with tempfile.TemporaryDirectory() as folder:
        machine = ROOT / f'data/machines/{MACHINE}.toml'
        subprocess.run([program, machine, folder], check=True, stdout=subprocess.DEVNULL)
        return {file.stem: read_table(file) for file in pathlib.Path(folder).glob('*.csv')}


def draw_corner_curves(tables, file):
    figure, plot = pyplot.subplots(figsize=(8, 5))
    curves, polygon, link = (tables[name] for name in ('curves', 'polygon', 'link_closed'))
    for prefix, colour, label in (('', BLUE, 'tip'), ('top_', RED, 'top point')):
        plot.plot(polygon[prefix + 'x_mm'], polygon[prefix + 'y_mm'], color=colour, linewidth=0.8, linestyle=':', marker='o',
                  markersize=4)
        plot.plot(curves[prefix + 'x_mm'], curves[prefix + 'y_mm'], color=colour, linewidth=1.8, label=label)
    for u_bottom in np.linspace(0, 1, 21):
        u_top = np.interp(u_bottom, link['u_bottom'], link['u_top'])
        ends = [[np.interp(u, curves['u'], curves[prefix + axis + '_mm']) for prefix, u in (('', u_bottom), ('top_', u_top))]
                for axis in 'xy']
        plot.plot(*ends, color=GREY, linewidth=0.7)
    plot.set(aspect='equal', xlabel='x in mm', ylabel='y in mm')
    plot.legend(loc='upper left', frameon=False)
    finish(figure, file)


LINKS = (('linear', GREY, '--', 'linear'), ('closed', BLUE, '-', 'closed form'), ('discrete', RED, ':', 'as published'))


def draw_corner_link(tables, file):
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(8, 3.4))
    for name, colour, style, label in LINKS:
        link = tables['link_' + name]
        left.plot(link['u_bottom'], link['u_top'] - link['u_bottom'], color=colour, linestyle=style, label=label)
        right.plot(link['u_bottom'], link['first'], color=colour, linestyle=style)
    left.set(xlabel='u of the bottom', ylabel='u of the top − u of the bottom')
    right.set(xlabel='u of the bottom', ylabel='f′', ylim=(0, None))
    left.legend(frameon=False)
    finish(figure, file)


def draw_corner_way(tables, file):
    figure, (top, middle, bottom) = pyplot.subplots(3, 1, figsize=(8, 7), sharex=True)
    for name, colour, style, label in LINKS:
        steps, way = tables['steps_' + name], tables['way_' + name]
        top.plot(steps['s_mm'], steps['criterion_rad_mm3'], color=colour, linestyle=style, label=label)
        middle.plot(steps['s_mm'], steps['feed_limit_mm_s'], color=colour, linestyle=style)
        bottom.plot(way['s_mm'], way['second_rad_mm2'], color=colour, linestyle=style)
    top.set(yscale='log', ylabel='‖n‴‖ in rad/mm³\nby steps of 0.05 mm', ylim=(1e-6, None))
    middle.set(ylabel='Eq. 10 in mm/s\nby steps of 0.05 mm', ylim=(0, None))
    bottom.set(ylabel='‖n″‖ in rad/mm²\nexact', xlabel='way of the tip in mm, 0 at the entry', ylim=(0, None))
    top.legend(loc='lower center', bbox_to_anchor=(0.5, 1), ncols=3, frameon=False)
    finish(figure, file)


def draw_corner_sensitivity(tables, file):
    tried = tables['sensitivity']
    order = np.argsort(tried['u_top'])
    u, criterion, feed = (tried[name][order] for name in ('u_top', 'criterion_rad_mm3', 'feed_limit_mm_s'))
    best = u[np.argmin(criterion)]
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(8, 3.4))
    left.plot(1e6 * (u - best), criterion, color=BLUE)
    left.set(xlabel='u of the top − best, 10⁻⁶', ylabel='criterion in rad/mm³', ylim=(0, None))
    right.plot(1e6 * (u - best), feed, color=BLUE)
    right.set(xlabel='u of the top − best, 10⁻⁶', ylabel='Eq. 10 in mm/s', ylim=(0, None), xlim=(-20, 20))
    finish(figure, file)


def draw_corner_ratio(tables, file):
    figure, plot = pyplot.subplots(figsize=(8, 3.4))
    ratio = tables['ratio']
    for angle, colour, style in zip(np.unique(ratio['angle_deg']), (BLUE, RED, COLOUR['Z']), ('-', '--', ':')):
        shown = ratio['angle_deg'] == angle
        feed = ratio['feed_limit_mm_s'][shown]
        plot.plot(ratio['ratio'][shown], feed / np.max(feed), color=colour, linestyle=style,
                  label=f'{angle:g}°, at best {np.max(feed):.2f} mm/s')
    plot.axvspan(1.4, 1.75, color='#eeeeee')
    plot.set(xlabel='outer length / inner length', ylabel='least of Eq. 10\nof its best', ylim=(0, 1.05))
    plot.legend(loc='lower right', frameon=False)
    finish(figure, file)


def finish(figure, file):
    figure.align_ylabels()
    figure.tight_layout()
    figure.savefig(file, metadata={'Date': None})
    pyplot.close(figure)
    print(file)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--trunnion', type=pathlib.Path, default=ROOT / 'build/release/apps/trunnion/trunnion')
    parser.add_argument('--corner', type=pathlib.Path, default=ROOT / 'build/release/examples/03_corner/example_corner')
    parser.add_argument('--output', type=pathlib.Path, default=ROOT / 'docs/theory/pictures')
    args = parser.parse_args()
    args.output.mkdir(parents=True, exist_ok=True)
    matplotlib.rcParams.update({'font.size': 11, 'axes.spines.top': False, 'axes.spines.right': False,
                                'svg.hashsalt': 'trunnion', 'axes.titlesize': 11})
    setpoints, samples = plan(args.trunnion, BLADE / 'blade.ngc', MACHINE, '--setup', BLADE / 'setup.toml', '--feed', FEED,
                              '--period', '0.5ms')
    stretches = stretches_of(samples)
    stretch = Stretch(samples, stretches[PASS], axis_limits(args.trunnion, MACHINE))
    begin = np.interp(samples['s_mm'][stretches[PASS].start], setpoints['s_mm'], setpoints['t_s'])
    end = np.interp(samples['s_mm'][stretches[PASS].stop - 1], setpoints['s_mm'], setpoints['t_s'])
    draw_speed(stretch, args.output / 'speed.svg')
    draw_axes(stretch, setpoints, (begin, end), args.output / 'axes.svg')
    draw_calm(args.trunnion, args.output / 'calm.svg')
    draw_rest(stretch, args.output / 'rest.svg')
    draw_smoothing_kernels(args.output / 'smoothing-kernels.svg')
    draw_smoothing_course(args.trunnion, args.output / 'smoothing-course.svg')
    draw_kinematics_cones(args.output / 'kinematics-cones.svg')
    draw_kinematics_winding(args.trunnion, args.output / 'kinematics-winding.svg')
    draw_checking_order(args.output / 'checking-order.svg')
    draw_checking_sagitta(args.trunnion, args.output / 'checking-sagitta.svg')
    tables = corner_tables(args.corner)
    for draw in (draw_corner_curves, draw_corner_link, draw_corner_way, draw_corner_sensitivity, draw_corner_ratio):
        draw(tables, args.output / (draw.__name__.removeprefix('draw_').replace('_', '-') + '.svg'))


if __name__ == '__main__':
    main()
