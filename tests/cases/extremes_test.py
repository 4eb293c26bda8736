"""Tolerances and blocks at the edge of sense: each plan ends in time with motion that holds its tolerance, judged by `trunnion check`
and the outside checker, or with a coded error and no file.

    extremes_test.py TRUNNION SHARED ROUNDING

Exit status 77: this trunnion has no such rounding (ctest reports the test as skipped)."""
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile

SECONDS = 60
OUTPUTS = {'-o': 'q.csv', '--summary': 's.json', '--programmed': 'p.csv', '--path': 'path.csv', '--events': 'e.csv'}
MACHINE = 'name = "table of large ranges"\nchain = "C A X Y Z"\n' + ''.join(
    f'[axes.{axis}]\nrange = ["-9000 mm", "9000 mm"]\nmax_velocity = "500 mm/s"\nmax_acceleration = "3000 mm/s^2"\n'
    'max_jerk = "50000 mm/s^3"\n'
    for axis in 'XYZ') + ''.join(
    f'[axes.{axis}]\nrange = ["-1000 deg", "1000 deg"]\nmax_velocity = "100 deg/s"\nmax_acceleration = "300 deg/s^2"\n'
    'max_jerk = "3000 deg/s^3"\npoint = ["0 mm", "0 mm", "0 mm"]\n' for axis in 'AC')
SETUP = '[workpiece]\norigin = ["0 mm", "0 mm", "50 mm"]\n[tool]\nkind = "flat"\ndiameter = "10 mm"\nlength = "0 mm"\n'


def words(*poses, feed=20000):
    """RS-274: poses (x, y, z[, a, c])."""
    lines = ['G21 G90 G94 G17 G40 G54']
    for n, pose in enumerate(poses):
        x, y, z, a, c = (*pose, 0, 0)[:5]
        motion, f_word = 'G0' if n == 0 else 'G1', f' F{feed}' if n == 1 else ''
        lines.append(f'{motion} X{x:.9f} Y{y:.9f} Z{z:.9f} A{a:.9f} C{c:.9f}{f_word}')
    return 'extreme.ngc', '\n'.join([*lines, 'M2', ''])


def vectors(*poses, feed=20000):
    """APT: poses (x, y, z[, i, j, k])."""
    lines = ['UNITS/MM', f'FEDRAT/{feed},MMPM', 'MULTAX/ON']
    for pose in poses:
        x, y, z, *axis = pose if len(pose) == 6 else (*pose, 0, 0, 1)
        length = math.hypot(*axis)
        lines.append('GOTO/' + ','.join(f'{v:.12f}' for v in (x, y, z, *(n / length for n in axis))))
    return 'extreme.cls', '\n'.join([*lines, 'FINI', ''])


def leaning(degrees, about_z=0.0):
    tilt, turn = math.radians(degrees), math.radians(about_z)
    return math.sin(tilt) * math.cos(turn), math.sin(tilt) * math.sin(turn), math.cos(tilt)


L = [(0, 0, 0), (30, 0, 0), (30, 20, 0), (50, 40, 10)]
TURNING = [(0, 0, 0, 10, 0), (30, 0, 0, 20, 10), (30, 20, 0, 20, 40), (50, 40, 10, 40, 40)]
METRES = [(0, 0, 0), (1000, 0, 0), (1000, 0.000001, 0), (1000.000001, 0.000001, 0), (1000, 1000, 0)]
CIRCLE = [(20 * math.cos(0.02 * k), 20 * math.sin(0.02 * k), 0, 10 + 0.05 * k, 0) for k in range(150)]

# name, program, options, and what comes: a code, or None where it must be planned. A tolerance of 0 gives exact stops.
CASES = [
    ('tip tolerance 0', words(*L), ['--tip-tolerance', '0mm'], None),
    ('tip tolerance negative', words(*L), ['--tip-tolerance', '-10um'], 'PIPE0001'),
    ('tip tolerance not a number', words(*L), ['--tip-tolerance', 'nan mm'], 'BASE0001'),
    ('tip tolerance infinite', words(*L), ['--tip-tolerance', 'inf mm'], 'BASE0001'),
    ('tip tolerance 1 nm', words(*TURNING), ['--tip-tolerance', '0.000001mm'], None),
    ('tip tolerance of 10 m', words(*TURNING), ['--tip-tolerance', '10m'], None),
    ('tip tolerance of 10 m, dense', words(*CIRCLE), ['--tip-tolerance', '10m'], None),
    ('tip tolerance of 10 m, vectors', vectors(*L), ['--tip-tolerance', '10m'], None),
    ('all tolerances large', words(*TURNING), ['--tip-tolerance', '10m', '--orientation-tolerance', '170deg'], None),
    ('all tolerances large, dense', words(*CIRCLE), ['--tip-tolerance', '10m', '--orientation-tolerance', '170deg'], None),
    ('orientation tolerance 0', words(*TURNING), ['--orientation-tolerance', '0deg'], None),
    ('orientation tolerance negative', words(*TURNING), ['--orientation-tolerance', '-1deg'], 'PIPE0001'),
    ('orientation tolerance not a number', words(*TURNING), ['--orientation-tolerance', 'nan deg'], 'BASE0001'),
    ('flank tolerance 0', words(*TURNING), ['--flank-tolerance', '0mm'], None),
    ('flank tolerance negative', words(*TURNING), ['--flank-tolerance', '-1mm'], 'PIPE0001'),
    ('zero length', words((0, 0, 0), (0, 0, 0), (10, 0, 0), (10, 0, 0), (10, 10, 0)), [], None),
    ('zero length, vectors', vectors((0, 0, 0), (0, 0, 0), (10, 0, 0), (10, 0, 0), (10, 10, 0)), [], None),
    ('points a thousand times', words(*(p for p in L for _ in range(1000))), [], None),
    ('points a thousand times, vectors', vectors(*(p for p in L for _ in range(1000))), [], None),
    ('all points equal', words(*[(5, 5, 5)] * 10), [], 'NC0005'),
    ('all points equal, vectors', vectors(*[(5, 5, 5)] * 10), [], 'NC0005'),
    ('there and back', words((0, 0, 0), (30, 0, 0), (0, 0, 0), (30, 0, 0)), [], None),
    ('there and back, vectors, turning',
     vectors((0, 0, 0, *leaning(10)), (30, 0, 0, *leaning(40)), (0, 0, 0, *leaning(10))), [], None),
    ('opposite orientations',
     vectors((0, 0, 0, 0, 0.6, 0.8), (10, 0, 0, 0, -0.6, -0.8), (20, 0, 0, 0, 0.6, 0.8)), [], 'NC0403'),
    ('orientations nearly opposite',
     vectors((0, 0, 0, *leaning(60)), (50, 0, 0, *leaning(119.9, 179)), (100, 5, 0, *leaning(60))), [], None),
    ('words to and fro', words((0, 0, 0, 90, 0), (10, 0, 0, -90, 180), (20, 5, 0, 90, 0), (30, 5, 0, -90, 180)), [], None),
    ('one block', words((0, 0, 0), (10, 20, 30, 40, 50)), [], None),
    ('one block, vectors', vectors((0, 0, 0), (10, 20, 30, *leaning(30))), [], None),
    ('one block of 1 nm', words((0, 0, 0), (0.000001, 0, 0)), [], None),
    ('1 nm beside 1 m', words(*METRES), [], None),
    ('1 nm beside 1 m, turning', words((0, 0, 0), (1000, 0, 0, 10), (1000, 0.000001, 0, 10), (1000, 500, 0, 30, 5)), [], None),
    ('1 nm beside 1 m, vectors', vectors(*METRES), [], None),
    ('1 um steps at a corner', words(*((1e-3 * k, 0, 0) for k in range(500)), *((0.5, 1e-3 * k, 0) for k in range(500))), [], None),
    ('far from zero', words(*((8000 + x, 8000 + y, z) for x, y, z in L)), [], None),
    ('turns of 1e-9 deg', words(*((0, 0, 0, 10 + 1e-9 * k, 0) for k in range(50))), [], None),
    ('noise above the tolerance', words(*((0.1 * k, 0.05 * (-1) ** k, 0) for k in range(60))), [], None),
    ('noise above the tolerance, vectors', vectors(*((0.1 * k, 0, 0, *leaning(10 + 0.3 * (-1) ** k)) for k in range(60))), [], None),
]


# With a tip tolerance far above what the orientation's allows, a lone corner leaves the tool this much more from the place that the
# outside checker takes for the nearest.
FROM_NEAREST_PLACE = {'tip tolerance of 10 m': 1.1}

# A curve through both tolerances at every corner may come out too sharp to plan: said, not made.
MAY_BE_REFUSED = {'beudaert': {'tip tolerance 1 nm': 'FEED0004', 'words to and fro': 'FEED0004'}}


class Case:
    def __init__(self, trunnion, shared, rounding, case):
        self.trunnion, self.shared = trunnion, shared
        self.name, (self.file, self.text), self.options, self.code = case
        self.rounding = ['--rounding', rounding]
        self.may_be = MAY_BE_REFUSED.get(rounding, {}).get(self.name)
        self.wrong = []

    def expect(self, what, good):
        if not good:
            self.wrong.append(f'{self.name}: {what}')

    def run(self):
        with tempfile.TemporaryDirectory() as name:
            self.folder, self.out = pathlib.Path(name), pathlib.Path(name) / 'out'
            self.out.mkdir()
            self.common = ['-m', self.folder / 'machine.toml', '--setup', self.folder / 'setup.toml']
            for file, text in (('machine.toml', MACHINE), ('setup.toml', SETUP), (self.file, self.text)):
                (self.folder / file).write_text(text)
            self.plan()
        return self.wrong

    def plan(self):
        outputs = [w for option, file in OUTPUTS.items() for w in (option, self.out / file)]
        try:
            done = subprocess.run([self.trunnion, 'plan', self.folder / self.file, *self.common, *self.options,
                                   *self.rounding, '--quiet', *outputs], capture_output=True, text=True, timeout=SECONDS)
        except subprocess.TimeoutExpired:
            return self.expect(f'takes more than {SECONDS} s', False)
        code = re.search(r'error ([A-Z]+\d{4}):', done.stderr)
        print(f'{self.name}: status {done.returncode}', code[1] if code else '')
        left = sorted(f.name for f in self.out.iterdir())
        if self.may_be and done.returncode == 2:
            self.code = self.may_be
        if self.code:
            self.expect(f'status {done.returncode}, {done.stderr.strip() or "nothing said"}, not {self.code}',
                        done.returncode == 2 and code and code[1] == self.code)
            return self.expect(f'left behind: {left}', not left)
        self.expect(f'status {done.returncode}: {done.stderr.strip()}', done.returncode == 0)
        if done.returncode == 0:
            self.expect(f'files {left}', left == sorted(OUTPUTS.values()))
            self.judge()

    def judge(self):
        summary = json.loads((self.out / 's.json').read_text())
        self.expect('not usable', summary['usable'])
        self.expect_within('summary', summary, summary['options'],
                           ('tip_deviation_mm', 'orientation_deviation_deg'))
        if not summary['setpoints']:
            return
        tip, turn = (max(summary['options'][key], 1e-3) for key in ('tip_tolerance_mm', 'orientation_tolerance_deg'))
        if self.name.endswith('tolerance 0'):
            self.expect('no exact stop at a corner, or not said', summary['exact_stops']['corners'] > 0 and (
                'none' in self.rounding or any(d['code'] == 'PIPE0104' for d in summary['diagnostics'])))
        checked = subprocess.run([self.trunnion, 'check', self.out / 'q.csv', '--against', self.folder / self.file, *self.common,
                                  '--tip-tolerance', f'{tip}mm', '--orientation-tolerance', f'{turn}deg', '--quiet'],
                                 capture_output=True, text=True)
        self.expect(f'check: status {checked.returncode}\n{checked.stdout}{checked.stderr}', checked.returncode == 0)
        tool = self.shared / 'tools/verify_setpoints.py'
        if tool.exists():
            self.judge_from_outside(tool, summary['options'])

    def judge_from_outside(self, tool, options):
        done = subprocess.run(['/usr/bin/python3', tool, self.out / 'q.csv', '--machine', self.folder / 'machine.toml',
                               '--setup', self.folder / 'setup.toml', '--programmed', self.out / 'p.csv', '--json'],
                              capture_output=True, text=True)
        if done.returncode != 0:
            return self.expect(f'outside checker: {done.stderr}', False)
        verdict = json.loads(done.stdout)
        for letter, axis in verdict['axes'].items():
            for ratio in ('velocity_ratio', 'acceleration_ratio', 'jerk_ratio'):
                self.expect(f'{letter} {ratio} {axis[ratio]:.5f}', axis[ratio] <= 1.001)
        self.expect_within('outside', verdict, options, ('tip_deviation_mm', 'tip_to_poses_mm', 'orientation_deviation_deg',
                                                         'orientation_to_poses_deg'), FROM_NEAREST_PLACE.get(self.name, 1))

    def expect_within(self, who, found, options, keys, turned=1):
        seen_mm = 1e-3 if who == 'outside' else 1e-9  # it compares with places some hundredths of a millimetre apart
        tip, turn = options['tip_tolerance_mm'] + seen_mm, options['orientation_tolerance_deg'] * turned + seen_mm
        for key in keys:
            self.expect(f'{who}: {key} {found[key]:.4g}', found[key] <= (tip if 'mm' in key else turn))



def main():
    trunnion, shared, rounding = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
    if rounding not in subprocess.run([trunnion, 'plan', '--help'], capture_output=True, text=True).stdout:
        print(f'skipped: no rounding {rounding}')
        sys.exit(77)
    wrong = [w for case in CASES for w in Case(trunnion, shared, rounding, case).run()]
    if wrong:
        sys.exit('wrong:\n  ' + '\n  '.join(wrong))


main()
