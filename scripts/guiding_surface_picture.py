#!/usr/bin/env python3
"""Draws docs/theory/pictures/guiding-surfaces.svg: a section of a hollow face with its guiding and orientation surface.

    scripts/guiding_surface_picture.py [--output docs/theory/pictures]

Needs matplotlib: `apt-get install python3-matplotlib`, and then /usr/bin/python3."""
import argparse
import math
import pathlib
import sys

try:
    import matplotlib
    import numpy as np
except ImportError:
    sys.exit(__doc__)

matplotlib.use('svg')
from matplotlib import pyplot  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parent.parent
GREY, BLUE, RED, GREEN = '#666666', '#0072B2', '#D55E00', '#009E73'
RADIUS, CORNER, HEIGHT, HOLLOW = 8, 2.5, 22, 30  # mm


def normal(x):
    return np.array([-math.sin(x / HOLLOW), math.cos(x / HOLLOW)])


def surface(x):
    return np.array([HOLLOW * math.sin(x / HOLLOW), HOLLOW * (1 - math.cos(x / HOLLOW))])


def axis(x, lead):
    n = normal(x)
    feed = np.array([n[1], -n[0]])
    return math.cos(lead) * n + math.sin(lead) * feed


def outline(x, lead):
    """The tool's section from the shank on one side round its end to the other side."""
    u = axis(x, lead)
    n = normal(x)
    v = n - n.dot(u) * u
    v /= np.linalg.norm(v)
    centre = surface(x) + CORNER * n + (RADIUS - CORNER) * v
    points = [(-RADIUS, HEIGHT)]
    points += [(-RADIUS + CORNER - CORNER * math.cos(a), -CORNER * math.sin(a)) for a in np.linspace(0, math.pi / 2, 20)]
    points += [(-out, up) for out, up in reversed(points)]
    return np.array([centre + out * v + up * u for out, up in points])


def draw(axes, lead, colour, name):
    places = np.linspace(-17, 17, 100)
    lower = np.array([surface(x) + CORNER * normal(x) for x in places])
    upper = np.array([surface(x) + CORNER * normal(x) + HEIGHT * axis(x, lead) for x in places])
    below = np.array([surface(x) for x in places])
    axes.fill_between(below[:, 0], below[:, 1], -3, color='#dddddd')
    axes.plot(*lower.T, color=BLUE, label='$S_1$')
    axes.plot(*upper.T, color=GREEN, label='$S_2$')
    axes.plot(*outline(2, lead).T, color=colour)
    k = surface(2) + CORNER * normal(2)
    axes.plot(*np.array([k, k + HEIGHT * axis(2, lead)]).T, color=GREY, linestyle=':', marker='o', markersize=3)
    axes.set(aspect='equal', xlim=(-20, 20), ylim=(-3, 30), title=name, xlabel='feed → / mm')
    axes.legend(loc='upper left', frameon=False)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--output', type=pathlib.Path, default=ROOT / 'docs/theory/pictures')
    output = parser.parse_args().output
    matplotlib.rcParams['svg.hashsalt'] = 'trunnion'
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(9, 4), layout='constrained', sharey=True)
    draw(left, math.radians(4), RED, 'lead 4°: the rear of the end gouges')
    draw(right, math.radians(17), BLUE, 'lead 17°: same contact, same $S_1$, another $S_2$')
    figure.savefig(output / 'guiding-surfaces.svg', metadata={'Date': None})


if __name__ == '__main__':
    main()
