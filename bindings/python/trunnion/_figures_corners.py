"""The corners of the figures of Beudaert 2013, and what a machine makes of steps along them.

Pocket, pyramid and drive limits are not in the text. The pocket is the corner of two walls with 10° of draft, 25 mm high;
the pyramid is 80 mm wide below, 50 mm above and 50 mm high; the drives are those of the shipped machine `ucp710`.
"""
import functools
import math
from dataclasses import dataclass

import numpy as np

import trunnion

from ._figures_drawing import BLUE, RED

PAPER = 'Beudaert 2013'
LINKS = (('linear', RED, '--', 'u_top = u_bottom'), ('optimised', BLUE, '-', 'parametrization spline'))


def unit(rows):
    rows = np.asarray(rows, float)
    return rows / np.linalg.norm(rows, axis=-1, keepdims=True)


def drawn_length(points):
    return np.append(0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))


def eq10(positions, step, machine, feed):
    """Eq. 10 in mm/min of every axis position but the first three, by backward differences over equal steps in mm."""
    limit = np.full(len(positions) - 3, feed / 60)
    for axis, q in zip(machine.axes, positions.T):
        for order, name in enumerate(('velocity', 'acceleration', 'jerk'), 1):
            rate = np.abs(np.diff(q, order))[3 - order:] / step**order
            limit = np.minimum(limit, (axis['limits'][name] / np.maximum(rate, 1e-300))**(1 / order))
    return 60 * limit


def eq11(axes, step):
    """Eq. 11 in rad/mm³ of every orientation but the first three."""
    return np.linalg.norm(np.diff(axes, 3, axis=0), axis=1) / step**3


@dataclass(frozen=True, eq=False)
class Part:
    """Straight blocks for the flank of a tool: poses, height of the flank and tolerances in mm, feed in mm/min.

    `step`: of differences along its corner, mm; about a period of 1 ms at the feed there.
    """
    tips: np.ndarray
    axes: np.ndarray
    height: float
    tip_tolerance: float
    top_tolerance: float
    feed: float
    step: float

    def rulings(self):
        """Tip and the point of the axis that lies `height` above it, of the three poses of the first corner."""
        return np.stack([self.tips, self.tips + self.height * self.axes / self.axes[:, 2:]], axis=1)[:3]

    def corner(self, link='optimised', top_tolerance=None):
        return trunnion.DualCorner(*self.rulings(), tip_tolerance_mm=self.tip_tolerance,
                                   top_tolerance_mm=top_tolerance or self.top_tolerance, link=link)

    @functools.lru_cache
    def planned(self, link):
        program = trunnion.program_from_poses(self.tips, self.axes, feed_mm_min=self.feed)
        return trunnion.plan(program, trunnion.machine('ucp710'), tip_tolerance_mm=self.tip_tolerance,
                             orientation_tolerance_deg=20, flank_tolerance_mm=self.top_tolerance,
                             flank_height_mm=self.height, rounding='beudaert', corners='beudaert', link=link)

    def middle(self):
        """Path length of the middle of the first corner, and half the length of its curve."""
        bottom = self.corner().curves.bottom
        half = 0.5 * drawn_length(bottom(np.linspace(0, 1, 2001)))[-1]
        return np.linalg.norm(bottom(0.0) - self.tips[0]) + half, half

    def steps(self, link, window):
        """Way from the middle, tips and axes at equal steps, from `window` mm before the corner to as far behind it."""
        shown, given, u = self.corner(link), self.rulings(), np.linspace(0, 1, 100001)
        bottom = shown.curves.bottom
        way = drawn_length(bottom(u))
        s = self.step * np.arange(-round(window / self.step), round((way[-1] + window) / self.step) + 1)
        before, behind = s < 0, s > way[-1]
        inside = ~(before | behind)
        entry, leave = (np.linalg.norm(bottom(end) - given[k, 0]) for k, end in enumerate((0.0, 1.0)))
        legs = np.linalg.norm(np.diff(given[:, 0], axis=0), axis=1)
        lines = np.empty((len(s), 2, 3))
        lines[before] = given[0] + ((entry + s[before]) / legs[0])[:, None, None] * (given[1] - given[0])
        lines[behind] = given[1] + ((leave + s[behind] - way[-1]) / legs[1])[:, None, None] * (given[2] - given[1])
        at = np.interp(s[inside], way, u)
        lines[inside] = np.stack([bottom(at), shown.curves.top(shown.link(at)[:, 0])], axis=1)
        return s - 0.5 * way[-1], lines[:, 0], unit(lines[:, 1] - lines[:, 0])


def pocket():
    """Tolerances and feed are the paper's. The tool leans out of the pocket; at the corner it lies along both walls."""
    s = math.tan(math.radians(10))
    return Part(np.array([[0, 0, 0], [60, 0, 0], [60, 50, 0.0]]), unit([[0, -s, 1], [s, -s, 1], [s, 0, 1]]), height=25.0,
                tip_tolerance=3.0, top_tolerance=3.0, feed=3000.0, step=0.05)


def pyramid():
    """The tolerance of the tip is the paper's.

    That of the top is 0.02 mm there as well. On our pyramid the outer length of the top is then too short for its inner one,
    which is made shorter, both curves become alike, and u_top = u_bottom is the best link there is.
    """
    tips = np.array([[-40, -40, 0], [40, -40, 0], [40, 40, 0], [-40, 40, 0], [-40, -40, 0.0]])
    inwards = -15 / 50 / 40 * tips[:, :2]  # 15 mm in on 50 mm up
    return Part(tips, unit(np.column_stack([inwards, np.ones(len(tips))])), height=50.0, tip_tolerance=0.02,
                top_tolerance=0.01, feed=30000.0, step=0.003)


POCKET, PYRAMID = pocket(), pyramid()
