#!/usr/bin/env python3
"""Draws the ball at some poses of the pass through the middle of the bowl: docs/pictures/surface-bowl.svg.

    examples/11_hollow/pictures.py [--trunnion build/release/apps/trunnion/trunnion] [--output docs/pictures]

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

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
RADIUS, REACH = 8, 20  # mm: of the ball, and how far up the tool is drawn
PLACES = (-15, 0, 15)  # x of the poses drawn, mm


def poses(program):
    rows = [line[5:].split(',') for line in program.read_text().splitlines() if line.startswith('GOTO/')]
    return np.array([[float(x) for x in row] for row in rows if len(row) == 6])


def outline():
    """Half of the tool's section by its axis, from the tip's middle outwards and up: distance from the axis, height."""
    turn = np.linspace(-np.pi / 2, 0, 30)
    edge = RADIUS * np.stack([np.cos(turn), 1 + np.sin(turn)], axis=1)
    return np.concatenate([[[0, 0]], edge, [[RADIUS, REACH], [0, REACH]]])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--trunnion', default=ROOT / 'build/release/apps/trunnion/trunnion', type=pathlib.Path)
    parser.add_argument('--output', default=ROOT / 'docs/pictures', type=pathlib.Path)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        program = pathlib.Path(folder) / 'bowl.cls'
        subprocess.run([arguments.trunnion, 'surface', 'plan', HERE / 'bowl.toml', '--setup', HERE / 'setup.toml', '--tool', '8',
                        '--lead', '15deg', '--strategy', 'along-u', '-o', program], check=True)
        all_poses = poses(program)
    figure, panel = pyplot.subplots(figsize=(7, 4.6), layout='constrained')
    x = np.linspace(-20, 20, 200)
    panel.plot(x, 0.025 * x ** 2 - 20, color='black')
    for place in PLACES:
        # Of the pose that leans least out of the plane of the picture and is nearest to it.
        near = all_poses[(np.abs(all_poses[:, 0] - place) < 2) & (all_poses[:, 2] < 0.025 * all_poses[:, 0] ** 2 - 18)]
        tip = near[np.argmin(np.abs(near[:, 1]) + 100 * np.abs(near[:, 4]))]
        axis = tip[[3, 5]] / np.linalg.norm(tip[[3, 5]])
        across = np.array([axis[1], -axis[0]])
        half = outline()
        for side in (-1, 1):
            points = tip[[0, 2]] + side * half[:, :1] * across + half[:, 1:] * axis
            panel.fill(points[:, 0], points[:, 1], color='#0072B2', alpha=0.25, linewidth=0)
        panel.plot(*np.stack([tip[[0, 2]], tip[[0, 2]] + REACH * axis]).T, color='#0072B2', linewidth=0.8, linestyle='--')
    panel.set_aspect('equal')
    panel.set_xlabel('x, mm')
    panel.set_ylabel('z, mm')
    panel.set_title('ball of 16 mm, 15° lead, near y = 0', loc='left', fontsize=10)
    figure.savefig(arguments.output / 'surface-bowl.svg')


if __name__ == '__main__':
    main()
