import concurrent.futures
import gc
import math

import numpy as np
import pytest

import trunnion
from conftest import EXAMPLES, refused


def test_arrays_are_views_that_keep_the_program(trt):
    program = trunnion.read_program(EXAMPLES / '01_first_plan/blade.ngc', machine=trt)
    moves, lines, positions = program.moves, program.lines, program.positions_mm
    assert len(program) == len(moves) == len(lines) > 100
    assert moves.base is program and not moves.flags.owndata and not moves.flags.writeable
    assert np.shares_memory(moves['position_mm'], positions) and np.shares_memory(moves['line'], lines)
    kept = positions.copy()
    del program, moves
    gc.collect()
    waste = [trunnion.read_program(EXAMPLES / '01_first_plan/blade.ngc', machine=trt) for _ in range(3)]
    np.testing.assert_array_equal(positions, kept)
    assert lines[-1] > lines[0] and waste
    with pytest.raises(ValueError):
        positions[0, 0] = 1


def test_what_a_program_says(trt):
    text = 'G21 G90 G94\nT3 M6\nM3 S12000\nG0 X0 Y0 Z10 A0 C0\nG1 X10 A5 F1200\nG4 P0.5\nG1 Y4 C9\nM30\n'
    program = trunnion.read_program_text(text, machine=trt, dialect='rs274', name='part')
    moves = program.moves
    assert program.dialect == 'rs274' and program.rotary_letters == 'AC' and program.source.startswith('part')
    assert moves['feed'][1] == pytest.approx(20) and moves['feed_rule'][1] == 1 and list(moves['kind']) == [0, 1, 1]
    assert math.degrees(moves['rotary_rad'][-1, 1]) == pytest.approx(9) and list(program.lines) == [4, 5, 7]
    dwell = [event for event in program.events if event['kind'] == 'dwell']
    assert [(event['dwell_s'], event['before_move'], event['line']) for event in dwell] == [(0.5, 2, 6)]


def test_an_error_has_its_place(trt):
    with pytest.raises(trunnion.Error) as caught:
        trunnion.read_program_text('G21\nG0 X0 Y0 Z0 A0 C0\nG1 X1 F100 FOO\n', machine=trt, dialect='rs274', name='bad')
    error = caught.value
    assert error.code.startswith('NC') and error.line == 3 and error.file.startswith('bad')
    assert error.code in str(error) and error.diagnostic.severity == 'error'
    with refused('NC0001'):
        trunnion.read_program('/no/such/file.ngc', machine=trt)
    with refused('PY0004', 'dialect'):
        trunnion.read_program_text('G0 X0', dialect='gcode')
    with refused('PY0001', 'machine'):
        trunnion.read_program_text('G0 X0', machine='xyzac-trt')
    with refused('PY0001', 'text'):
        trunnion.read_program_text('\ud800')
    with pytest.raises(TypeError, match='colour'):
        trunnion.read_program_text('G0 X0', colour=1)


def test_a_program_of_poses_written_and_read_again():
    tips = [[0, 0, 0], [10, 0, 0], [10, 5, 1]]
    axes = [[0, 0, 1], [0, 0.6, 0.8], [0, 0.8, 0.6]]
    program = trunnion.program_from_poses(tips, axes, feed_mm_min=[0, 600, 1200], exact_stop=[False, True, False])
    again = trunnion.read_program_text(program.text(dialect='apt'), dialect='apt')
    np.testing.assert_allclose(again.positions_mm, tips, atol=1e-4)
    np.testing.assert_allclose(again.axes, axes, atol=1e-6)
    np.testing.assert_allclose(again.moves['feed'][1:], [10, 20])
    np.testing.assert_allclose(program.moves['exact_stop'], [False, True, False])


def test_poses_without_axes_are_upright(trt):
    program = trunnion.program_from_poses([[0, 0, 0], [10, 0, 0]], feed_mm_min=600)
    np.testing.assert_array_equal(program.axes, [[0, 0, 1], [0, 0, 1]])
    assert list(program.moves['law']) == [0, 0] and trunnion.plan(program, trt).usable


def test_moves_from_many_threads(waves):
    """The type of the rows is made once: numpy's own way from text fails in two threads at once before Python 3.11.5."""
    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        lines = list(pool.map(lambda _: int(waves.moves['line'][-1]), range(4000)))
    assert set(lines) == {len(waves)}


def test_writing(tmp_path, waves, trt):
    file = tmp_path / 'waves.mpf'
    told = waves.write(file, dialect='sinumerik', head=['by a test'])
    assert all(isinstance(one, trunnion.Diagnostic) for one in told)
    again = trunnion.read_program(file, machine=trt)
    assert len(again) == len(waves) and 'by a test' in file.read_text()
    with refused('FILE0201'):
        waves.write(tmp_path / 'no/such/folder.mpf', dialect='sinumerik')
    with refused('PY0003', 'precision_mm'):
        waves.write(file, precision_mm=-1)
    with refused('PY0001', 'head'):
        waves.write(file, head=[3])


def test_rotary_words(trt):
    program = trunnion.program_from_poses([[0, 0, 0], [5, 0, 0]], feed_mm_min=600, rotary_letters='AC', rotary_deg=[[0, 0], [10, 20]])
    assert list(program.moves['law']) == [1, 1]
    np.testing.assert_allclose(np.degrees(program.moves['rotary_rad'][1, :2]), [10, 20])
    vectors = program.translate(trt, law='vector')
    np.testing.assert_allclose(vectors.axes[-1], trt.forward([0, 0, 0, 10, 20])[1], atol=1e-9)
    assert list(vectors.moves['law'][1:]) == [0] * (len(vectors) - 1)


@pytest.mark.parametrize('code, name, given', [
    ('PY0001', 'tips', dict(tips=[[0, 0]], axes=[[0, 0, 1]], feed_mm_min=1)),
    ('PY0001', 'tips', dict(tips=np.zeros((0, 3)), axes=np.zeros((0, 3)), feed_mm_min=1)),
    ('PY0002', 'tips', dict(tips=[[0, 0, math.nan]], axes=[[0, 0, 1]], feed_mm_min=1)),
    ('PY0003', 'axes', dict(tips=[[0, 0, 0]], axes=[[0, 0, 0]], feed_mm_min=1)),
    ('PY0003', 'axes', dict(tips=[[0, 0, 0]], axes=[[0, 0, 1]], feed_mm_min=1, rotary_letters='A', rotary_deg=[[0]])),
    ('PY0001', 'rotary_letters', dict(tips=[[0, 0, 0]], feed_mm_min=1, rotary_deg=[[0]])),
    ('PY0001', 'feed_mm_min', dict(tips=[[0, 0, 0]], axes=[[0, 0, 1]])),
    ('PY0001', 'feed_mm_min', dict(tips=[[0, 0, 0]], axes=[[0, 0, 1]], feed_mm_min=[1, 2])),
    ('PY0003', 'feed_mm_min', dict(tips=np.eye(3), axes=[[0, 0, 1]] * 3, feed_mm_min=-1)),
    ('PY0001', 'rapid', dict(tips=[[0, 0, 0]], axes=[[0, 0, 1]], feed_mm_min=1, rapid=[1.0])),
    ('PY0003', 'rotary_letters', dict(tips=[[0, 0, 0]], feed_mm_min=1, rotary_letters='ac', rotary_deg=[[0, 0]])),
    ('PY0001', 'rotary_deg', dict(tips=[[0, 0, 0]], feed_mm_min=1, rotary_letters='AC', rotary_deg=[[0]]))])
def test_poses_that_are_none(code, name, given):
    with refused(code, name):
        trunnion.program_from_poses(**given)
