#!/usr/bin/env python3
"""Writes hills.toml, a bicubic surface of 100 × 100 mm with hills and hollows:   hills.py > hills.toml"""
import math

POINTS, SIZE = 14, 100  # control points each way; mm


def place(k):
    """Of a control point, so that the surface's x and y go evenly with u and v: the mean of its three knots."""
    knots = [min(max(k - 3 + i, 0), POINTS - 3) for i in (1, 2, 3)]
    return SIZE * sum(knots) / 3 / (POINTS - 3)


def height(x, y):
    return 5 * math.sin(2 * math.pi * x / 75) * math.cos(2 * math.pi * y / 90) + 0.0012 * (x - 20) * (y - 30)


print(f'''# Hills and hollows over {SIZE} × {SIZE} mm, bicubic, {POINTS} × {POINTS} control points; written by hills.py.
[[surface]]
degree = [3, 3]  # knots: clamped and uniform, as none are given
control_points_mm = [''')
for i in range(POINTS):
    x = place(i)
    print('  [' + ', '.join(f'[{x:.4f}, {place(j):.4f}, {height(x, place(j)):.4f}]' for j in range(POINTS)) + '],')
print(']')
