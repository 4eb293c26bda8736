"""Machines, programs and plans that several tests share. Arguments are judged by `refused(code, name)`."""
import contextlib
import os
import pathlib

import numpy as np
import pytest

import trunnion

ROOT = pathlib.Path(__file__).resolve().parents[2]
SHARED = pathlib.Path(os.environ.get('TRUNNION_SHARED_DIR', ROOT.parent / 'shared'))
EXAMPLES = ROOT / 'examples'


@contextlib.contextmanager
def refused(code, name=''):
    """An Error with this code whose text begins with the argument's name."""
    with pytest.raises(trunnion.Error) as caught:
        yield
    assert caught.value.code == code, str(caught.value)
    assert caught.value.text.startswith(name), str(caught.value)


@pytest.fixture(scope='session')
def trt():
    return trunnion.machine('xyzac-trt')


@pytest.fixture(scope='session')
def setup():
    return trunnion.setup(EXAMPLES / '01_first_plan/setup.toml')


@pytest.fixture(scope='session')
def blade(trt):
    return trunnion.read_program(EXAMPLES / '01_first_plan/blade.ngc', machine=trt)


def zigzag(passes=4, points=60):
    """Poses of passes over a wavy surface: long enough that planning takes a while."""
    x = np.linspace(-20, 20, points)
    tips, axes = [], []
    for k in range(passes):
        along = x if k % 2 == 0 else x[::-1]
        tips.append(np.column_stack([along, np.full(points, 0.5 * k), 2 * np.sin(along / 6)]))
        tilt = np.radians(15 + 8 * np.sin(along / 9))
        axes.append(np.column_stack([0 * along, np.sin(tilt), np.cos(tilt)]))
    return np.concatenate(tips), np.concatenate(axes)


@pytest.fixture(scope='session')
def waves():
    tips, axes = zigzag()
    return trunnion.program_from_poses(tips, axes, feed_mm_min=3000)
