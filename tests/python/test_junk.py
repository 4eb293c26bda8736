"""Every function and class of the module takes anything: it gives a result, a trunnion.Error or a TypeError, and nothing else."""
import inspect
import random

import numpy as np
import pytest

import trunnion
from conftest import EXAMPLES

SEED = 20260211
JUNK = [None, True, 3, -1, 0.5, 1e308, -1e-308, float('nan'), float('inf'), 10**400, 'x', '', 'a\0b', '\ud800', b'x', [], {}, [[]],
        [[1, 2], [3]], np.zeros((2, 3)), np.zeros((2, 2, 3)), np.ones(0), np.ones((0, 3)), np.array('a'), np.array([None]), np.eye(3),
        np.full((4, 3), 1e300), np.zeros((3, 3), complex), np.arange(8)[::-2], object(), range(3), {'tool': {'length': 3}}, np.float32(2)]
CALLS = 1000


@pytest.fixture(scope='module')
def good(trt, setup):
    """One of every class, small enough that what succeeds is quick."""
    tips, axes = np.array([[0, 0, 0], [5, 0, 0], [9, 4, 0], [12, 9, 1]], float), np.array([[0, 0.6, 0.8]] * 4)
    program = trunnion.program_from_poses(tips, axes, feed_mm_min=600)
    curve = trunnion.BsplineCurve(1, [0, 0, 1, 1], tips[:2])
    wall = trunnion.GuidedSurface([tips, tips + [0, 0, 20]])
    return [trt, setup, program, trunnion.plan(program, trt, setup, period_s=0.01), trunnion.controller('ideal'), curve,
            trunnion.DualSpline(curve, curve), wall, wall.surface, trunnion.Face(wall.surface), trunnion.Tool('ball', 8),
            trunnion.FlankTool('cylinder', 4), trunnion.DualPath(tips, axes), trt.kinematics(), tips, axes,
            trunnion.read_faces(EXAMPLES / '09_surface/hills.toml'), *more(trt, setup, program, wall.surface)]


def more(machine, setup, program, surface):
    """What is made by functions."""
    stretch = trunnion.stretches(program, machine, setup)[0]
    flat = trunnion.Face(trunnion.BsplineSurface(1, 1, [0, 0, 9, 9], [0, 0, 9, 9], np.dstack([*np.mgrid[0:10:9, 0:10:9], np.zeros((2, 2))])))
    guiding = trunnion.GuidingSurface(flat, trunnion.Tool('ball', 8))
    return [stretch, trunnion.plan_stretch(stretch), trunnion.LivePlanner(stretch), trunnion.PartBody(flat), guiding,
            trunnion.OrientationSurface(guiding), trunnion.DualCorner([[0, 0, 0], [0, 0, 9]], [[5, 0, 0], [5, 1, 9]], [[5, 5, 0], [4, 6, 9]]),
            trunnion.Diagnostic('A0001', 'a')]


def attempt(call, *arguments, **keywords):
    try:
        call(*arguments, **keywords)
    except trunnion.Error as error:
        assert error.code and error.text
    except (TypeError, UnicodeEncodeError):
        pass


SLOW = {'plan_surface', 'move_surface', 'move_surface_ahead', 'Error'}


@pytest.mark.parametrize('name', sorted(set(trunnion.__all__) - SLOW))
def test_functions_and_classes(name, good):
    draw = random.Random(f'{SEED} {name}')
    thing = getattr(trunnion, name)
    most = 7
    for _ in range(CALLS):
        count = draw.randrange(most)
        attempt(thing, *[draw.choice(JUNK if draw.random() < 0.4 else good) for _ in range(count)])


def test_methods(good):
    draw = random.Random(SEED)
    for one in [one for one in good if type(one).__module__.startswith('trunnion') and not isinstance(one, trunnion.FaceList)]:
        for name, member in inspect.getmembers(one):
            if name.startswith('__') and name != '__call__' or not callable(member) or name == 'write':
                continue
            for junk in JUNK:
                attempt(member, junk)
                attempt(member, draw.choice(JUNK), draw.choice(JUNK))


def test_options(good):
    machine, setup, program = good[:3]
    names = ['tip_tolerance_mm', 'orientation_tolerance_deg', 'flank_height_mm', 'rounding', 'corners', 'link', 'calm', 'jerk_margin',
             'feed_override', 'feed_mm_min', 'chord_error_mm', 'tip_jerk_mm_s3', 'tool_turn_deg_s', 'threads', 'worth', 'path', 'progress']
    for name in names:
        for junk in JUNK:
            attempt(trunnion.plan, program, machine, setup, period_s=0.02, **{name: junk})
    for name in ('scallop_mm', 'lead_deg', 'strategy', 'zigzag', 'splines', 'tool_name'):
        for junk in (None, 'x', float('nan'), -1, [], 10**400, '\ud800'):
            attempt(trunnion.plan_surface, [3], good[10], **{name: junk})
