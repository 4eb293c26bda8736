import math

import numpy as np
import pytest

import trunnion
from conftest import refused



@pytest.mark.parametrize('name', ['xyzac-trt', 'ucp710', 'nutating-head'])
def test_inverse_is_the_reverse_of_forward(name):
    machine = trunnion.machine(name)
    draw = np.random.default_rng(7)
    low = [-50, -50, -50, 5, -170][:len(machine.axes)]
    positions = draw.uniform(low, [50, 50, 50, 25, 170], (40, len(machine.axes)))
    setup = trunnion.setup({'workpiece': {'origin': ['1 mm', '2 mm', '-30 mm']}, 'tool': {'length': '80 mm'}})
    kinematics = machine.kinematics(setup)
    for row in positions:  # one by one, each near to where it is
        tip, axis = kinematics.forward(row)
        assert abs(np.linalg.norm(axis) - 1) < 1e-12
        back = kinematics.inverse(tip, axis, near_deg=row[3:])
        again, same = kinematics.forward(back)
        np.testing.assert_allclose(again, tip, atol=1e-9)
        np.testing.assert_allclose(same, axis, atol=1e-9)
    assert kinematics.forward(positions.reshape(4, 10, -1))[0].shape == (4, 10, 3)


def test_a_trunnion_by_hand():
    # C A X Y Z, all at 0 but A = 90°: the tool lies along Y of the workpiece.
    machine = trunnion.machine('ucp710')
    tip, axis = machine.forward([1, 2, 3, 90, 0])
    assert axis == pytest.approx([0, 1, 0], abs=1e-12) or axis == pytest.approx([0, -1, 0], abs=1e-12)
    tip, axis = machine.forward([1, 2, 3, 0, 0])
    assert tip == pytest.approx([1, 2, 3]) and axis == pytest.approx([0, 0, 1])


def test_derivatives_against_differences(trt, setup):
    kinematics = trt.kinematics(setup)

    def pose(t):  # exact derivatives of a curve of poses
        tip = [[10 * t, t * t, 3], [10, 2 * t, 0], [0, 2, 0], [0, 0, 0]]
        s, c = math.sin(0.2 + t), math.cos(0.2 + t)
        return tip, [[0, s, c], [0, c, -s], [0, -s, -c], [0, -c, s]]

    h = 1e-3
    rows = [kinematics.inverse_derivatives(*pose(k * h)) for k in (-2, -1, 0, 1, 2)]
    p = np.array([row[0] for row in rows])
    np.testing.assert_allclose((p[3] - p[1]) / (2 * h), rows[2][1], rtol=1e-5, atol=1e-4)
    np.testing.assert_allclose((p[3] - 2 * p[2] + p[1]) / h**2, rows[2][2], rtol=1e-4, atol=1e-3)
    np.testing.assert_allclose((p[4] - 2 * p[3] + 2 * p[1] - p[0]) / (2 * h**3), rows[2][3], rtol=1e-3, atol=1e-1)


def test_both_branches_give_the_orientation():
    machine = trunnion.machine('ucp710')
    axis = np.array([0.3, 0.2, math.sqrt(1 - 0.13)])
    branches = machine.kinematics().branches(axis)
    assert branches.shape == (2, 2) and np.isfinite(branches).all()
    for rotary in branches:
        np.testing.assert_allclose(machine.forward([0, 0, 0, *rotary])[1], axis, atol=1e-12)
    assert np.isnan(machine.kinematics().branches([0, 0, 1])[1]).all()


def test_a_machine_of_three_axes_by_dict():
    axis = {'range': ['-100 mm', '100 mm'], 'max_velocity': '30 m/min', 'max_acceleration': '2.5 m/s^2', 'max_jerk': '50 m/s^3'}
    machine = trunnion.machine({'name': 'three', 'chain': 'X Y Z', 'axes': {'X': axis, 'Y': axis, 'Z': axis}})
    assert machine.name == 'three' and machine.columns == ['X_mm', 'Y_mm', 'Z_mm']
    assert machine.axes[0]['limits'] == pytest.approx({'velocity': 500, 'acceleration': 2500, 'jerk': 50000})
    assert machine.axes[0]['range'] == (-100, 100)


def test_what_is_wrong_is_said(trt, tmp_path):
    with refused('FILE0112'):
        trunnion.machine('no-such-machine')
    with refused('BASE0002'):  # a bare number
        trunnion.setup({'tool': {'length': '100'}})
    with refused('FILE0104'):
        trunnion.setup({'tol': {}})
    with refused('FILE0101'):
        trunnion.setup(tmp_path / 'none.toml')
    with refused('PY0001', 'source'):
        trunnion.machine(3)
    with refused('PY0003', 'source'):
        trunnion.machine('a\0b')
    with refused('PATH0101', 'axes'):  # head down
        trunnion.machine('nutating-head').inverse([0, 0, 0], [0, 0, -1])


@pytest.mark.parametrize('positions, code', [
    ([1, 2, 3], 'PY0001'), ([[1, 2, 3, 4, float('nan')]], 'PY0002'), (['a'] * 5, 'PY0001'), (None, 'PY0001'),
    ([1, 2, 3, 4, float('inf')], 'PY0002'), (np.zeros(5, complex), 'PY0001'), ([[1, 2], [3]], 'PY0001'),
    (np.zeros(5, bool), 'PY0001'), (7.0, 'PY0001')])
def test_positions_that_are_none(trt, positions, code):
    with refused(code, 'positions'):
        trt.forward(positions)


def test_poses_that_are_none(trt):
    with refused('PY0001', 'tips'):
        trt.inverse([1, 2], [0, 0, 1])
    with refused('PY0001', 'axes'):
        trt.inverse([1, 2, 3], [[0, 0, 1], [0, 0, 1]])
    with refused('PY0003', 'axes'):
        trt.inverse([1, 2, 3], [0, 0, 2])
    with refused('PY0001', 'near_deg'):
        trt.inverse([1, 2, 3], [0, 0, 1], near_deg=[1, 2, 3])
    with refused('PY0001', 'setup'):
        trt.forward([0] * 5, 'setup.toml')
    with refused('PY0001', 'tips'):
        trt.kinematics().inverse_derivatives(np.zeros((3, 3)), np.ones((3, 3)))
    with refused('PY0003', 'axes'):
        trt.kinematics().inverse_derivatives(np.zeros((4, 3)), np.zeros((4, 3)))


def test_arrays_of_any_layout_and_size(trt):
    positions = np.zeros((6, 5))
    positions[:, 0] = range(6)
    assert trt.forward(np.asfortranarray(positions))[0][:, 0] == pytest.approx(trt.forward(positions)[0][:, 0])
    assert trt.forward(positions[::2].astype(np.float32))[0].shape == (3, 3)
    assert trt.forward(positions.astype(int))[0].shape == (6, 3)
    assert trt.forward(np.zeros((0, 5)))[0].shape == (0, 3)


def test_tools():
    assert trunnion.Tool('ball', 10).corner_radius_mm == 5
    with refused('PY0004', 'kind'):
        trunnion.Tool('round', 10)
    with refused('PY0003', 'diameter_mm'):
        trunnion.Tool('flat', 0)
    with refused('PY0003', 'corner_radius_mm'):
        trunnion.Tool('torus', 10, 6)
    with refused('PY0001', 'diameter_mm'):
        trunnion.Tool('flat', '10 mm')
