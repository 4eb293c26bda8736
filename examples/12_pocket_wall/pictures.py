#!/usr/bin/env python3
"""Draws the tool at the wall, as it is planned and freed of its gouge: docs/pictures/surface-wall.svg.

    examples/12_pocket_wall/pictures.py [--trunnion build/release/apps/trunnion/trunnion] [--output docs/pictures]

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
RADIUS, REACH, ROUNDING, WALL = 5, 40, 8, 40  # mm


def plan(trunnion, program, *options, status):
    done = subprocess.run([trunnion, 'surface', 'plan', HERE / 'pocket.toml', '--setup', HERE / 'setup.toml', '--face', '1', '--strategy',
                           'along-u', '--lead', '15deg', '--scallop', '50um', '--reach', f'{REACH}mm', '-o', program, *options])
    if done.returncode != status:
        sys.exit(f'surface plan ended with {done.returncode}')
    out = []
    for line in program.read_text().splitlines():
        if line.startswith('GOTO/'):
            numbers = [float(x) for x in line[5:].split(',')]
            out.append(numbers if len(numbers) == 6 else numbers + out[-1][3:])  # an axis holds until another one
    return np.array(out)


def into_the_wall(poses):
    """Of the poses on the bottom that are led towards the wall, one a place along x; the ball's centre stands over its contact."""
    centres = poses[:, :3] + RADIUS * poses[:, 3:]
    led = poses[(np.abs(centres[:, 2] - RADIUS) < 0.01) & (np.abs(centres[:, 1] - 20) < 2) & (poses[:, 3] < -0.01)]
    return led[np.argmin(np.abs((led[:, :3] + RADIUS * led[:, 3:])[:, 0] - ROUNDING))]


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
        program = pathlib.Path(folder) / 'pocket.cls'
        planned = plan(arguments.trunnion, program, status=1)
        freed = plan(arguments.trunnion, program, '--free-gouges', status=0)
    figure, panel = pyplot.subplots(figsize=(5, 5), layout='constrained')
    turn = np.linspace(np.pi, 1.5 * np.pi, 40)
    panel.plot(np.concatenate([[0], ROUNDING * (1 + np.cos(turn)), [30]]), np.concatenate([[WALL], ROUNDING * (1 + np.sin(turn)), [0]]),
               color='black')
    for poses, colour, label in ((planned, '#D55E00', 'as planned, lead 15°'), (freed, '#0072B2', 'freed')):
        tip = into_the_wall(poses)
        axis = tip[[3, 5]] / np.linalg.norm(tip[[3, 5]])
        across = np.array([axis[1], -axis[0]])
        half = outline()
        for side in (-1, 1):
            points = tip[[0, 2]] + side * half[:, :1] * across + half[:, 1:] * axis
            panel.fill(points[:, 0], points[:, 1], color=colour, alpha=0.25, linewidth=0, label=label if side > 0 else None)
        panel.plot(*np.stack([tip[[0, 2]], tip[[0, 2]] + REACH * axis]).T, color=colour, linewidth=0.8, linestyle='--')
    panel.set_aspect('equal')
    panel.set_xlabel('x, mm')
    panel.set_ylabel('z, mm')
    panel.set_title('where a pass ends at the wall, near y = 20', loc='left', fontsize=10)
    panel.legend(loc='upper right', fontsize=8)
    figure.savefig(arguments.output / 'surface-wall.svg')


if __name__ == '__main__':
    main()
