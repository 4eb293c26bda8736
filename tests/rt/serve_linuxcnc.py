"""LinuxCNC's queue, planned by `trunnion serve`, on the real LinuxCNC: what an operator does, and a planner that is killed.

    serve_linuxcnc.py TRUNNION SOURCE_DIR SHARED_DIR [SCENARIO …]

Exit status 77: LinuxCNC or its development package is not there, or LinuxCNC runs."""
import importlib.util
import pathlib
import shutil
import sys

import numpy

LIMITS = numpy.array([[500, 2500, 5000], [500, 3000, 5000], [500, 2100, 50000], [90, 300, 1800], [120, 300, 1800]], dtype=float)
MIXED = '''G21 G90 G94 G17 G64 P0.02
G0 X10 Y5 Z3 A0 C0
S1000 M3
G1 X30 A5 F3000
G2 X40 Y15 I0 J10
G3 X50 Y25 I10 J0 A10 C20
G4 P0.2
M5
G61
G1 X20 Y20
X0 Y0 C0
G64 P0.05
G93
G1 X10 A0 F120
G1 X20 C10 F120
G94 F2000
G18
G2 X30 Z3 I5 K0
G17
G0 X0 Y0 Z0 A0 C0
M2
'''


def worst(rows):
    """Peaks of velocity, acceleration and jerk of the recorded joint commands, of the limits."""
    out, values = [], rows[:, :5]
    for order in range(3):
        values = numpy.diff(values, axis=0) / 1e-3
        out.append(float((numpy.abs(values) / LIMITS[:, order]).max()))
    return out


class Test:
    def __init__(self, trunnion, source, shared):
        spec = importlib.util.spec_from_file_location('compare', pathlib.Path(source) / 'linuxcnc' / 'compare.py')
        self.compare = importlib.util.module_from_spec(spec)
        sys.dont_write_bytecode = True
        spec.loader.exec_module(self.compare)
        self.shared = pathlib.Path(shared)
        if self.compare.absent() or self.compare.LOCK.exists():
            sys.exit(77)
        self.folder, self.trunnion, self.machine = self.compare.prepare(trunnion, self.shared)

    def run(self, name, text, steps=(), seconds=60):
        program = self.folder / f'{name}.ngc'
        program.write_text(text)
        result, rows = self.compare.run(self.folder / name, self.trunnion, self.machine, 'Trunnion', program, seconds, steps)
        peaks = worst(rows)
        print(f'{name}: {len(rows)} periods, peaks of the limits {[round(x, 5) for x in peaks]}', *result['said'], flush=True)
        assert max(peaks) < 1.001, peaks
        assert numpy.abs(numpy.diff(rows[-4:, :5], axis=0)).max() == 0, 'it does not stand at the end'
        return result, rows

    def case(self, name):
        return (self.shared / 'data' / 'cases' / f'{name}.ngc').read_text()


def standing_in_the_middle(rows):
    """The longest time that all joints stood between the first movement and the last, s."""
    moves = numpy.nonzero(numpy.abs(numpy.diff(rows[:, :5], axis=0)).max(1) > 0)[0]
    return float(numpy.diff(moves).max() - 1) * 1e-3


def words_of_every_kind(test):
    result, rows = test.run('mixed', MIXED)
    assert result['whole'], result
    assert numpy.abs(rows[-1, :5]).max() < 1e-9, rows[-1]


def pause_and_resume(test):
    result, rows = test.run('pause', test.case('gentle-0.5'), [(0.6, 'pause'), (3.0, 'resume')])
    assert result['whole'], result
    assert 1.2 < standing_in_the_middle(rows) < 2.6, standing_in_the_middle(rows)


def override(test):
    result, rows = test.run('override', test.case('gentle-0.5'), [(0.5, 'override 0.5')])
    plain, unchanged = test.run('plain', test.case('gentle-0.5'))
    assert result['whole'] and plain['whole']
    assert len(rows) > len(unchanged) + 200, (len(rows), len(unchanged))


def abort_and_go_on(test):
    result, rows = test.run('abort', test.case('sine-10k'), [(4, 'abort'), (6, 'mdi G1 X10 Y0 Z0 A0 C0 F3000'), (7, 'mdi G0 X0')])
    assert abs(rows[-1, 0]) < 1e-9, rows[-1]


def kill_the_planner(test):
    """The last plan ends at a standstill inside all limits; LinuxCNC's operator is told."""
    result, rows = test.run('kill', test.case('sine-10k'), [(4, 'kill'), (14, 'abort')], seconds=20)
    assert any('no answer' in said for said in result['said']), result


SCENARIOS = [words_of_every_kind, pause_and_resume, override, abort_and_go_on, kill_the_planner]


def main():
    test = Test(*sys.argv[1:4])
    for scenario in SCENARIOS:
        if not sys.argv[4:] or scenario.__name__ in sys.argv[4:]:
            scenario(test)
    shutil.rmtree(test.folder, ignore_errors=True)


if __name__ == '__main__':
    main()
