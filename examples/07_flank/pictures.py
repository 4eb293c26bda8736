#!/usr/bin/env python3
"""Draws what the side of the tool leaves of examples/07_flank before and after `trunnion deform`: the picture of
docs/theory/deformation.md. Envelope and deviation are computed here anew, from the poses of both programs.

    examples/07_flank/pictures.py [--trunnion build/release/apps/trunnion/trunnion] [--output docs/theory/pictures]

Needs matplotlib and scipy: `apt-get install python3-matplotlib python3-scipy`, and then /usr/bin/python3."""
import argparse
import pathlib
import subprocess
import sys
import tempfile

try:
    import matplotlib
    import numpy as np
    from scipy.interpolate import CubicSpline
except ImportError:
    sys.exit(__doc__)

matplotlib.use('svg')
from matplotlib import pyplot  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
RADIUS, FROM_HEIGHT, TO_HEIGHT = 5, 2, 27  # mm


def cutting_poses(program):
    """Tip and axis at the ends of the cutting moves of a CL file, and where the first of them begins."""
    poses, cutting, before = [], False, None
    for line in program.read_text().splitlines():
        word, _, values = line.partition('/')
        if word.strip() == 'RAPID':
            cutting = False
        elif word.strip() == 'FEDRAT':
            cutting = True
        elif word.strip() == 'GOTO':
            pose = [float(x) for x in values.split(',')]
            if cutting:
                poses += [pose] if poses else [before, pose]
            before = pose
    return np.array(poses)


class Blade:
    """The surface between the two guide curves."""

    def __init__(self, file):
        table = np.loadtxt(file, delimiter=',', skiprows=1)
        rows = [table[table[:, 0] == r, 1:] for r in (0, 1)]
        steps = np.mean([np.linalg.norm(np.diff(row, axis=0), axis=1) for row in rows], axis=0)
        u = np.concatenate([[0], np.cumsum(steps)])
        self.length = u[-1]
        self.bottom, self.top = (CubicSpline(u, row) for row in rows)

    def foot(self, point, u, v):
        """Nearest place by Gauss and Newton; point and normal towards the tool."""
        for _ in range(30):
            by_v = self.top(u) - self.bottom(u)
            by_u = (1 - v) * self.bottom(u, 1) + v * self.top(u, 1)
            off = point - self.bottom(u) - v * by_v
            step = np.linalg.lstsq(np.stack([by_u, by_v], axis=1), off, rcond=None)[0]
            u, v = u + step[0], v + step[1]
        normal = np.cross(by_v, by_u)
        return self.bottom(u) + v * (self.top(u) - self.bottom(u)), normal / np.linalg.norm(normal)


def deviations(poses, blade, heights):
    """Micrometres, by place and height: the envelope of a cylinder against the blade."""
    p = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(poses[:, :3], axis=0), axis=1))])
    tip, axis = CubicSpline(p, poses[:, :3]), CubicSpline(p, poses[:, 3:])
    places = np.linspace(0, p[-1], 81)
    out = np.empty((len(places), len(heights)))
    for i, at in enumerate(places):
        a, a_rate = axis(at), axis(at, 1)
        a_rate = (a_rate - a * (a @ a_rate) / (a @ a)) / np.linalg.norm(a)
        a = a / np.linalg.norm(a)
        for j, height in enumerate(heights):
            across = np.cross(a, tip(at, 1) + height * a_rate)
            across /= np.linalg.norm(across)
            guess = blade.length * at / p[-1], (height - FROM_HEIGHT) / (TO_HEIGHT - FROM_HEIGHT)
            normal = blade.foot(tip(at) + height * a, *guess)[1]
            envelope = tip(at) + height * a - RADIUS * across * np.sign(across @ normal)
            foot, normal = blade.foot(envelope, *guess)
            out[i, j] = 1000 * (envelope - foot) @ normal
    return places, out


def draw(before, after, heights, file):
    figure, panels = pyplot.subplots(2, 1, figsize=(8, 5.2), sharex=True, layout='constrained')
    largest = np.abs(before[1]).max()
    for panel, (places, map_um), name in zip(panels, (before, after), ('positioned on both edges', 'deformed')):
        picture = panel.pcolormesh(places, heights, map_um.T, cmap='RdBu', vmin=-largest, vmax=largest, shading='gouraud',
                                   rasterized=True)
        panel.set_title(f'{name}: {map_um.min():.2f} … {map_um.max():.2f} µm', loc='left', fontsize=10)
        panel.set_ylabel('height on the tool, mm')
    panels[1].set_xlabel('way of the tip, mm')
    figure.colorbar(picture, ax=panels, label='material left (+) or cut (−), µm')
    figure.savefig(file)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--trunnion', default=ROOT / 'build/release/apps/trunnion/trunnion', type=pathlib.Path)
    parser.add_argument('--output', default=ROOT / 'docs/theory/pictures', type=pathlib.Path)
    arguments = parser.parse_args()
    heights = np.linspace(FROM_HEIGHT, TO_HEIGHT, 26)
    blade = Blade(HERE / 'blade.csv')
    with tempfile.TemporaryDirectory() as folder:
        deformed = pathlib.Path(folder) / 'blade.cls'
        subprocess.run([arguments.trunnion, 'deform', HERE / 'blade.cls', '-m', 'ucp710', '--setup', HERE / 'setup.toml',
                        '--flank', HERE / 'blade.csv', '--from-height', f'{FROM_HEIGHT}mm', '--to-height', f'{TO_HEIGHT}mm',
                        '--chord-tolerance', '0.1um', '--to', 'apt', '-o', deformed], check=True)
        before, after = (deviations(cutting_poses(file), blade, heights) for file in (HERE / 'blade.cls', deformed))
    draw(before, after, heights, arguments.output / 'flank-deviation.svg')


if __name__ == '__main__':
    main()
