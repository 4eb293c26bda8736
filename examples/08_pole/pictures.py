#!/usr/bin/env python3
"""Draws the pictures of docs/theory/singular-cone.md and rotary-motion.md from what examples/08_pole writes.

    examples/08_pole/pictures.py [--pole build/release/examples/08_pole/example_pole] [--output docs/theory/pictures]

Needs matplotlib: `apt-get install python3-matplotlib`, and then /usr/bin/python3."""
import argparse
import pathlib
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

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
MACHINE = ROOT / 'data/machines/ucp710.toml'
GREY, BLUE, RED = '#666666', '#0072B2', '#D55E00'
# Half angle of the cone of `around`: 250 mm/min of the ball's centre, 0.5 deg of turn a mm of the tip, C at 120 deg/s.
CONE = np.degrees(np.arcsin(0.5 / (1 + 4 * np.radians(0.5)) * 250 / 60 / 120))
STYLES = (('before', GREY, '--'), ('after', BLUE, '-'))


def read_table(file):
    names = file.open().readline().strip().split(',')
    values = np.loadtxt(file, delimiter=',', skiprows=1)
    return {name: values[:, k] for k, name in enumerate(names)}


def tables_of(program):
    if not program.exists():
        sys.exit(f'{program} is missing: scripts/build.sh release example_pole')
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([program, MACHINE, folder], check=True)
        return {file.stem: read_table(file) for file in pathlib.Path(folder).glob('*.csv')}


def draw_directions(plot, tables, name, window):
    """The tool axis as seen along the pole, in degrees from it."""
    for stem, colour, style in STYLES:
        table = tables[f'{name}_{stem}']
        tilt = np.degrees(np.arctan2(np.hypot(table['i'], table['j']), table['k']))
        scale = tilt / np.maximum(np.hypot(table['i'], table['j']), 1e-15)
        plot.plot(scale * table['i'], scale * table['j'], color=colour, linestyle=style, label=stem)
    plot.plot(0, 0, marker='+', color=RED, markersize=10, linestyle='none', label='pole')
    plot.set(xlabel='tool axis towards X, deg', ylabel='towards Y, deg', xlim=(-window, window))


def draw_axis(plot, tables, name, axis):
    for stem, colour, style in STYLES:
        table = tables[f'{name}_{stem}_plan']
        plot.plot(table['t_s'], table[f'{axis}_deg'], color=colour, linestyle=style, label=stem)
    plot.set(xlabel='s', ylabel=f'{axis} in deg')


def draw_passage(tables, name, window, cone, file):
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(8, 3.4))
    draw_directions(left, tables, name, window)
    if cone:
        turn = np.linspace(0, 2 * np.pi, 200)
        left.plot(cone * np.cos(turn), cone * np.sin(turn), color=RED, linewidth=0.8, label='cone')
    left.legend(frameon=False, fontsize=9)
    draw_axis(right, tables, name, 'C')
    finish(figure, file)


def draw_blade(tables, file):
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(8, 3.4))
    for plot, axis in ((left, 'A'), (right, 'C')):
        draw_axis(plot, tables, 'blade', axis)
    left.legend(frameon=False)
    finish(figure, file)


def finish(figure, file):
    figure.tight_layout()
    figure.savefig(file, metadata={'Date': None})
    pyplot.close(figure)
    print(file)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--pole', type=pathlib.Path, default=ROOT / 'build/release/examples/08_pole/example_pole')
    parser.add_argument('--output', type=pathlib.Path, default=ROOT / 'docs/theory/pictures')
    args = parser.parse_args()
    args.output.mkdir(parents=True, exist_ok=True)
    matplotlib.rcParams.update({'font.size': 11, 'axes.spines.top': False, 'axes.spines.right': False,
                                'svg.hashsalt': 'trunnion'})
    tables = tables_of(args.pole)
    draw_passage(tables, 'through', 2, 0, args.output / 'pole-through.svg')
    draw_passage(tables, 'around', 10, CONE, args.output / 'pole-around.svg')
    draw_blade(tables, args.output / 'rotary-blade.svg')


if __name__ == '__main__':
    main()
