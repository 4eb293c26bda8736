#!/usr/bin/env python3
"""Draws passes over the hills and what the ball leaves between them: docs/pictures/surface-hills.svg. What is left is computed here
anew, from the poses of the program.

    examples/09_surface/pictures.py [--trunnion build/release/apps/trunnion/trunnion] [--output docs/pictures]

Needs matplotlib and scipy: `apt-get install python3-matplotlib python3-scipy`, and then /usr/bin/python3."""
import argparse
import pathlib
import subprocess
import sys
import tempfile
import tomllib

try:
    import matplotlib
    import numpy as np
    from scipy.interpolate import BSpline
    from scipy.spatial import cKDTree
except ImportError:
    sys.exit(__doc__)

matplotlib.use('svg')
from matplotlib import pyplot  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
RADIUS = 5  # mm, of the ball
WINDOW, STEP = (62, 66, 38, 42), 0.02  # mm: x and y of the place that is looked at closely
EVERY = 8  # passes drawn


def passes(program):
    """The passes of a CL file: poses that follow each other without a rapid and without going up or down the tool axis."""
    out, current, rapid, before = [], [], False, None
    for line in program.read_text().splitlines():
        word, _, values = line.partition('/')
        rapid = rapid or word.strip() == 'RAPID'
        if word.strip() != 'GOTO':
            continue
        numbers = [float(x) for x in values.split(',')]
        pose = np.array(numbers if len(numbers) == 6 else [*numbers, *before[3:]])
        step = pose[:3] - before[:3] if before is not None else np.zeros(3)
        if rapid or abs(step @ pose[3:]) > 0.9 * np.linalg.norm(step):
            if len(current) > 3:
                out.append(np.array(current))
            current = []
        current.append(pose)
        rapid, before = False, pose
    return out


class Surface:
    """The first surface of a file, by its net."""

    def __init__(self, file):
        table = tomllib.loads(file.read_text())['surface'][0]
        self.net = np.array(table['control_points_mm'], float)
        self.u, self.v = (np.concatenate([[0] * 3, np.linspace(0, 1, n - 2), [1] * 3]) for n in self.net.shape[:2])

    def at(self, u, v, du=0, dv=0):
        rows = [BSpline(knots, np.eye(n), 3)(w, nu=order)
                for knots, n, w, order in ((self.u, self.net.shape[0], u, du), (self.v, self.net.shape[1], v, dv))]
        return np.einsum('pi,pj,ijk->pk', *rows, self.net)


def left_um(surface, x, y, centres):
    """Height of the material above the surface at (x, y), along its normal; x and y go evenly with u and v."""
    u, v = x / 100, y / 100
    point = surface.at(u, v)
    normal = np.cross(surface.at(u, v, du=1), surface.at(u, v, dv=1))
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    near = cKDTree(centres).query(point + RADIUS * normal, k=60)[1]
    off = centres[near] - point[:, None]
    along = np.einsum('pkx,px->pk', off, normal)
    inside = RADIUS ** 2 - np.einsum('pkx,pkx->pk', off, off) + along ** 2
    return 1000 * np.where(inside > 0, along - np.sqrt(np.maximum(inside, 0)), np.inf).min(axis=1)


def centres_of(ways):
    """Of the ball, closely along every pass near the window."""
    out = []
    for way in ways:
        c = way[:, :3] + RADIUS * way[:, 3:]
        near = np.all((c[:, :2] > np.array(WINDOW[::2]) - 9) & (c[:, :2] < np.array(WINDOW[1::2]) + 9), axis=1)
        for a, b in zip(c[:-1][near[:-1]], c[1:][near[:-1]]):
            steps = max(2, int(np.linalg.norm(b - a) / 0.01))
            out.append(a + (b - a) * np.linspace(0, 1, steps)[:, None])
    return np.concatenate(out)


def draw(surface, ways, file):
    figure, (above, close) = pyplot.subplots(1, 2, figsize=(10, 4.4), layout='constrained')
    x, y = np.meshgrid(np.linspace(0, 100, 201), np.linspace(0, 100, 201))
    heights = surface.at(x.ravel() / 100, y.ravel() / 100)[:, 2].reshape(x.shape)
    picture = above.pcolormesh(x, y, heights, cmap='terrain', shading='gouraud', rasterized=True)
    for way in ways[::EVERY]:
        above.plot(way[:, 0], way[:, 1], color='black', linewidth=0.6)
    above.set_title(f'every {EVERY}th of {len(ways)} passes', loc='left', fontsize=10)
    figure.colorbar(picture, ax=above, label='height, mm')
    x, y = np.meshgrid(np.arange(*WINDOW[:2], STEP), np.arange(*WINDOW[2:], STEP))
    left = left_um(surface, x.ravel(), y.ravel(), centres_of(ways)).reshape(x.shape)
    picture = close.pcolormesh(x, y, left, cmap='viridis', shading='gouraud', rasterized=True)
    close.set_title(f'left by the ball: {left.min():.2f} … {left.max():.2f} µm', loc='left', fontsize=10)
    figure.colorbar(picture, ax=close, label='material above the surface, µm')
    for panel in (above, close):
        panel.set_aspect('equal')
        panel.set_xlabel('x, mm')
        panel.set_ylabel('y, mm')
    figure.savefig(file)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--trunnion', default=ROOT / 'build/release/apps/trunnion/trunnion', type=pathlib.Path)
    parser.add_argument('--output', default=ROOT / 'docs/pictures', type=pathlib.Path)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        program = pathlib.Path(folder) / 'hills.cls'
        subprocess.run([arguments.trunnion, 'surface', 'plan', HERE / 'hills.toml', '--setup', HERE / 'setup.toml', '--scallop',
                        '10um', '-o', program], check=True)
        ways = passes(program)
    draw(Surface(HERE / 'hills.toml'), ways, arguments.output / 'surface-hills.svg')


if __name__ == '__main__':
    main()
