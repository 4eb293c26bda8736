#!/usr/bin/env python3
"""Draws the pictures of docs/theory/surface-interpolation.md: the ripple of the feed on Lin & Koren's curve (Eq. 8), computed here, and
the feed along passes beside the pole from what `trunnion surface run` and `trunnion predict` write.

    scripts/surface_interpolation_pictures.py [--trunnion build/release/apps/trunnion/trunnion] [--output docs/theory/pictures]

Needs matplotlib: `apt-get install python3-matplotlib`, and then /usr/bin/python3."""
import argparse
import pathlib
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
GREY, BLUE, RED = '#666666', '#0072B2', '#D55E00'
STEP = 0.05  # mm: F3000 at 1 ms
SHOWN = (25, 75)  # s of the motion


def slope(u):
    return np.array([30 * u ** 2 + 20 * u, 20 * u + 10])


def bend(u):
    return np.array([60 * u + 20, 20.0])


def rate(u):
    return np.hypot(*slope(u))


def way(begin, end):
    x, w = np.polynomial.legendre.leggauss(16)
    u = (begin + end) / 2 + (end - begin) / 2 * x
    return (end - begin) / 2 * np.dot(w, rate(u))


def ripple(order):
    """Way of every step over the wanted one, less 1, over u."""
    u, out = 0.0, []
    while True:
        sigma, sigma1 = rate(u), np.dot(slope(u), bend(u)) / rate(u)
        du = STEP / sigma
        if order > 1:
            du -= du ** 2 * sigma1 / (2 * sigma)
        if order > 2:
            du += (STEP - way(u, u + du)) / rate(u + du)
        if u + du > 1:
            return np.array(out).T
        out.append((u, abs(way(u, u + du) / STEP - 1)))
        u += du


def draw_ripple(output):
    figure, axes = pyplot.subplots(figsize=(6.4, 3.2))
    for order, name, colour in ((1, 'first order', RED), (2, 'second order', BLUE), (3, 'with the corrector', GREY)):
        u, r = ripple(order)
        axes.semilogy(u, np.maximum(r, 1e-14), color=colour, label=name)
    axes.set_xlabel('u')
    axes.set_ylabel('|way / wanted − 1|')
    axes.legend(frameon=False)
    axes.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(output / 'surface-ripple.svg')


def read(file, columns):
    names = file.open().readline().strip().split(',')
    values = np.genfromtxt(file, delimiter=',', skip_header=1, usecols=[names.index(c) for c in columns])
    return values.T


def draw_feed(trunnion, output):
    import compare_surface_motion as compare
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / 'setup.toml').write_text(compare.SETUP)
        (folder / 'dome.toml').write_text(compare.DOME)
        shared = ['-m', compare.MACHINE, '--setup', folder / 'setup.toml']
        passes = ['--feed', '600mm/min']
        compare.run([trunnion, 'surface', 'run', folder / 'dome.toml', *shared, *passes, '-o', folder / 'q.csv', '-q'])
        compare.run([trunnion, 'surface', 'plan', folder / 'dome.toml', *shared, *passes, '--chord-tolerance', '1um', '-o',
                     folder / 'p.ngc', '-q'])
        compare.run([trunnion, 'predict', folder / 'p.ngc', *shared, '-c', 'linuxcnc-2.9', '--samples', folder / 'l.csv', '-q'])
        ours = read(folder / 'q.csv', ['t_s', 'feed_mm_min'])
        theirs = read(folder / 'l.csv', ['t_s', 'feed_mm_min'])
    figure, axes = pyplot.subplots(2, 1, figsize=(6.4, 4.2), sharex=True, sharey=True)
    for plot, (time, feed), name, colour in ((axes[0], ours, 'on the surface', BLUE), (axes[1], theirs, 'lines, LinuxCNC', RED)):
        shown = (time >= SHOWN[0]) & (time <= SHOWN[1])
        plot.plot(time[shown][::20], feed[shown][::20], color=colour, linewidth=0.8, label=name)
        plot.set_ylim(0, 700)
        plot.set_ylabel('feed, mm/min')
        plot.legend(frameon=False, loc='lower right')
        plot.grid(alpha=0.3)
    axes[1].set_xlabel('s')
    figure.tight_layout()
    figure.savefig(output / 'surface-feed.svg')


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--trunnion', default=ROOT / 'build/release/apps/trunnion/trunnion')
    parser.add_argument('--output', type=pathlib.Path, default=ROOT / 'docs/theory/pictures')
    args = parser.parse_args()
    matplotlib.rcParams['svg.hashsalt'] = 'trunnion'
    draw_ripple(args.output)
    draw_feed(args.trunnion, args.output)


main()
