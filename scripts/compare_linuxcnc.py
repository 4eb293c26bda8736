#!/usr/bin/python3
"""Runs programs on the real LinuxCNC 2.9 and on Trunnion's model of it, and writes the table of docs/linuxcnc-comparison.md.

    scripts/compare_linuxcnc.py [--model build/release/bench/bench_linuxcnc_model] [--shared ../shared] [--install]
        [--only NAME…] [--runs 5] [--json FILE] [--output docs/linuxcnc-comparison.md]

Needs root, Debian's linuxcnc-uspace (--install fetches it) and the shared folder's tools/linuxcnc, which run the control
without a screen. Exit status 77: not to be had here."""
import argparse
import io
import itertools
import json
import math
import os
import pathlib
import random
import re
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
HEAD = 'G21 G90 G94 G17 '
WARPS = [8, 4, 2, 1]  # run by run, how much faster the control's clocks run; its setpoints stay the same bits if its task keeps up
INI = ['ARC_BLEND_RAMP_FREQ=20', 'MAX_LINEAR_VELOCITY=500']  # as the control is run
SETUP = '[workpiece]\norigin = ["0 mm", "0 mm", "0 mm"]\n[tool]\nkind = "flat"\ndiameter = "10 mm"\nlength = "0 mm"\n'
LOCK = pathlib.Path(tempfile.gettempdir()) / 'linuxcnc.lock'


def program(mode, *blocks):
    return '\n'.join([HEAD + mode, *blocks, 'M2']) + '\n'


def points(rows):
    return ['G1 ' + ' '.join(f'{letter}{value:.5f}' for letter, value in zip('XYZAC', row)) for row in rows]


def made_programs():
    """(name, what it is, text); chaotic ones have short 3-axis blocks with arcs between them."""
    corners = ['G0 X10 Y5 Z3', 'G1 X30 F3000', 'Y25', 'X5 Z8 F6000', 'X0 Y0', 'X-10 Y3 Z-2', 'X-10.5 Y3.2', 'X20 Y-10 Z4 F9000',
               'G0 X0 Y0 Z0', 'G0 X40 Z20']
    table = ['G0 X10 Y5 Z3 A10 C20', 'G1 X30 A15 C40 F3000', 'Y25 A5', 'X5 Z8 C-30 F6000', 'X0 Y0 A0 C0', 'A20 C10 F2000',
             'X-10 Y3 Z-2', 'X-20', 'C45', 'A-10 C60 X0 Y0 Z0 F9000', 'G93', 'G1 X10 A0 C30 F60', 'G1 X20 F120', 'G1 C0 F40', 'G94 F3000',
             'G0 X0 Y0 Z0 A0 C0']
    arcs = ['G0 X10 Y0 Z0', 'G1 X20 F4000', 'G2 X30 Y-10 I0 J-10', 'G1 Y-20', 'G3 X40 Y-30 I10 J0', 'G1 X60', 'G2 X60 Y-30 I0 J-8',
            'G3 X50 Y-20 Z5 I-10 J0', 'G1 X30 Y-15', 'G2 X10 Y5 R30 Z0', 'G18', 'G3 X20 Z10 I0 K10', 'G17', 'G1 X0 Y0',
            'G3 X0 Y0 Z6 I5 J5 P3', 'G0 Z0']
    cornered_arcs = ['G0 X0 Y0 Z0', 'F5000', 'G1 X40', 'G2 X60 Y20 I20 J0', 'G1 X90 Y10', 'G3 X110 Y0 R25', 'G2 X130 Y-20 R22', 'G1 X130 Y-60',
                     'G3 X100 Y-60 R25', 'G1 X80 Y-40', 'G2 X60 Y-40 R12', 'G3 X40 Y-40 R14', 'G1 X20 Y-20', 'G2 X0 Y-20 R30',
                     'G2 X-20 Y-30 R40', 'G1 X0 Y0']
    spirals = ['G0 X0 Y0 Z0', 'F4000', 'G1 X20', 'G3 X40.002 Y0 I10 J0', 'G1 X50 Y20', 'G2 X70 Y20.001 I10 J0 Z5 P2', 'G1 X90 Y25',
               'G2 X110.003 Y25 I10 J0', 'G1 Y0']
    turns = ['G0 X5 Y5 Z5 A5 C5', 'G1 A30 F1500', 'C90', 'A-20 C120 F4000', 'C100 F500', 'C400 F60000', 'G0 A0 C0']
    rapids = ['G0 X0 Y0 Z0 A0 C0', 'X50 Y20 Z10', 'X-30 A20', 'X0 Y0 Z0', 'X1', 'X2 Y1', 'X2.5 Y1.2', 'Y80 C90', 'C0 A0', 'X0 Y0']
    both = ['G0 X5 Y5 Z5 A5 C5', 'G1 X20 F4000', 'Y20', 'X40 A10', 'Y40', 'X60', 'G2 X70 Y50 I0 J10', 'G1 Y60 C20', 'X50 Y62', 'X40 Y60',
            'G0 Z20', 'G1 Z5 F1000']
    inch = 'G20 G90 G94 G17 G64 P0.002\nG0 X0.5 Y0.2 Z0.1 A0 C0\nG1 X1.5 F100\nY1.0\nG2 X2.0 Y0.5 I0 J-0.5\nG1 X0 Y0 Z0 F200\nM2\n'
    waits = ['G0 X10 Y0 Z0', 'G1 X20 F3000', 'G4 P0.25', 'X30', 'S1000 M3', 'X40', 'M5', 'X45 Y5', 'G4 P0.1', 'G0 X0 Y0']
    figure = [(80 * math.cos(t) - 80, 60 * math.sin(2 * t), 12 * math.sin(t)) for t in (2 * math.pi * i / 2500 for i in range(2501))]
    small = [tuple(x / 4 for x in p) for p in figure]
    waves = [(0.2 * i, 5 * math.sin(0.05 * i), 2 * math.cos(0.1 * i) - 2, 10 * math.sin(0.02 * i), 0.3 * i) for i in range(600)]
    draw = random.Random(3)

    def walk(count, reach, feeds):
        at, out = [0, 0, 0], []
        for _ in range(count):
            at = [x + draw.uniform(-reach, reach) for x in at]
            out.append('G1 X%.4f Y%.4f Z%.4f F%d' % (*at, draw.choice(feeds)))
        return out
    long_walk, short_walk = walk(60, 15, [2000, 6000, 12000]), walk(300, 0.58, [6000])
    start = ['G0 X0 Y0 Z0 A0 C0', 'F6000']
    return [
        ('corners-g61', '3-axis corners', program('G61', *corners)),
        ('corners-g611', '3-axis corners', program('G61.1', *corners)),
        ('corners-g64', '3-axis corners', program('G64', *corners)),
        ('corners-g64p', '3-axis corners', program('G64 P0.1', *corners)),
        ('table-g61', '5-axis mix with G93', program('G61', *table)),
        ('table-g611', '5-axis mix with G93', program('G61.1', *table)),
        ('table-g64', '5-axis mix with G93', program('G64', *table)),
        ('table-g64p', '5-axis mix with G93', program('G64 P0.01', *table)),
        ('arcs-g61', 'arcs, helices, planes', program('G61', *arcs)),
        ('arcs-g64p', 'arcs, helices, planes', program('G64 P0.05', *arcs)),
        ('cornered-arcs', 'arc blends beside arcs', program('G64 P0.2 Q0', *cornered_arcs)),
        ('spirals', 'spirals', program('G64 P0.1 Q0', *spirals)),
        ('turns-g61', 'rotary axes alone', program('G61', *turns)),
        ('turns-g64', 'rotary axes alone', program('G64', *turns)),
        ('rapids', 'rapids', program('G64 P0.02', *rapids)),
        ('both', '3- and 5-axis blocks in turn', program('G64 P0.05', *both)),
        ('inch', 'inches', inch),
        ('waits', 'dwells and spindle', program('G64 P0.05', *waits)),
        ('waves-g61', '600 5-axis blocks of 0.3 mm', program('G61', *start, *points(waves))),
        ('waves-g64', '600 5-axis blocks of 0.3 mm', program('G64 P0.01', *start, *points(waves))),
        ('dense-g61', '2500 3-axis blocks of 0.15 mm', program('G61', *start, *points(figure))),
        ('dense-q0', '2500 3-axis blocks of 0.15 mm', program('G64 P0.01 Q0', *start, *points(figure))),
        ('dense-merged', '2500 3-axis blocks of 0.15 mm', program('G64 P0.01 Q0.005', *start, *points(figure))),
        ('walk', '60 random lines up to 15 mm', program('G64 P0.2 Q0', 'G0 X0 Y0 Z0 A0 C0', *long_walk)),
        ('short-walk', '300 random lines up to 1 mm', program('G64 P0.1 Q0', 'G0 X0 Y0 Z0 A0 C0', *short_walk)),
        ('tiny', '2500 blocks of 0.04 mm, under one period each', program('G64 P0.01 Q0', *start, *points(small))),
    ]


def shared_programs(shared):
    def read(path):
        return (shared / 'data' / path).read_text()
    cases = [('corner', 'case corner'), ('fillet', 'case fillet'), ('gentle-0.5', 'case gentle-0.5'), ('sine-10k', 'case sine-10k, 10 000 blocks')]
    for name, kind in cases:
        yield name, kind, 'G64 P0.01\n' + read(f'cases/{name}.ngc')
    text = re.sub(r'M42[89].*', '', read('nc/linuxcnc/impeller-7bl-xyzac.ngc'))
    faster = re.sub(r'^(G1.*F)\s*([\d.]+)', lambda m: f'{m[1]}{20 * float(m[2]):g}', text, flags=re.M)
    yield 'impeller', 'impeller shipped with LinuxCNC, F × 20', 'G21 G17\n' + faster
    yield 'impeller-g64p', 'the same', 'G21 G17 G64 P0.01\n' + faster


def varied_programs(made):
    """The same with other settings: of the control, of the model."""
    text = {name: (kind, body) for name, kind, body in made}
    variants = [('2 ms', ['--period-ns', '2000000'], ['SERVO_PERIOD=0.002']), ('depth 5', ['--lookahead', '5'], ['ARC_BLEND_OPTIMIZATION_DEPTH=5']),
                ('ramps 100 Hz', ['--ramp-freq', '100'], ['ARC_BLEND_RAMP_FREQ=100']),
                ('at most 30 mm/s', ['--max-lin-vel', '30'], ['MAX_LINEAR_VELOCITY=30']),
                ('half the acceleration', ['--acc-scale', '0.5'], ['ACCELERATION_FACTOR=0.5'])]
    for name in ('walk', 'dense-q0', 'arcs-g64p', 'table-g64p'):
        for what, control, model in variants:
            yield f'{name}, {what}', *text[name], control, model


def absent(why):
    print(f'skipped: {why}')
    sys.exit(77)


def prepare(folder, shared, install):
    tools = shared / 'tools/linuxcnc'
    if not (tools / 'setup.sh').exists():
        absent('no shared tools/linuxcnc')
    if os.getuid() != 0:
        absent('LinuxCNC is run by root in the name of a user of its own')
    installed = subprocess.run(['dpkg', '-s', 'linuxcnc-uspace'], capture_output=True).returncode == 0
    if not installed and not install:
        absent('LinuxCNC is not installed; scripts/compare_linuxcnc.py --install fetches Debian\'s linuxcnc-uspace')
    done = subprocess.run(['bash', tools / 'setup.sh', folder], capture_output=True, text=True)
    if done.returncode != 0:
        absent(f'LinuxCNC cannot be installed: {done.stderr[-300:]}')


def run_control(folder, name, file, warp, settings):
    """Position of the planner, of the joints, and time of the real control."""
    import numpy as np
    for _ in range(60):
        if not LOCK.exists():
            break
        time.sleep(1)
    else:
        absent('another LinuxCNC runs')
    command = [folder / 'run_linuxcnc.py', file, '--name', name, '--csv', '--warp', str(warp), '--timeout', '300', *settings]
    # Ahead of what else the machine does: a task that is late sends its commands late.
    done = subprocess.run(['nice', '-n', '-15', *command], capture_output=True, text=True)
    report_file = folder / 'runs' / name / 'report.json'
    if done.returncode != 0 or not report_file.exists():
        sys.exit(f'LinuxCNC did not run {name}: {done.stdout[-600:]}{done.stderr[-600:]}')
    samples = np.loadtxt(folder / 'runs' / name / 'samples.csv', delimiter=',', skiprows=1)
    return samples[:, 6:11], samples[:, 1:6], json.loads(report_file.read_text())['motion']


def run_model(model, file, machine, setup, *more):
    import numpy as np
    done = subprocess.run([model, file, machine, setup, *INI, *more], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f'{model} {file}: {done.stderr}')
    if '--rows' not in more:
        return json.loads(done.stdout)
    rows = np.loadtxt(io.StringIO(done.stdout), delimiter=',', ndmin=2)
    return rows[:, [1, 2, 3, 4, 6]], rows[:, 7:12], json.loads(done.stderr)


def from_first_motion(rows):
    import numpy as np
    moving = np.nonzero(np.abs(np.diff(rows, axis=0)).max(1) > 1e-12)[0]
    return rows[moving[0]:]


def deviation(control, model):
    """Largest distance in any axis, mm or deg, period by period from the first motion on."""
    import numpy as np
    a, b = from_first_motion(control), from_first_motion(model)
    count = min(len(a), len(b))
    return float(np.abs((a[:count] - a[0]) - (b[:count] - b[0])).max())


def peak_difference(control, model):
    """Largest relative difference of peaks; axes that hardly move do not count."""
    return max((abs(m / c - 1) for c, m in zip(control, model) if c > 1e-3), default=0.0)


def compare(folder, args, machine, setup, name, kind, text, control_settings=(), model_settings=()):
    stem = re.sub('[^a-z0-9-]', '_', name)
    file = folder / f'{stem}.ngc'
    file.write_text(text)
    file.chmod(0o644)
    period_s = 0.002 if 'SERVO_PERIOD=0.002' in model_settings else 0.001
    planned, joints, account = run_model(args.model, file, machine, setup, *model_settings, '--rows')
    best, runs = None, []
    for attempt in range(1, args.runs + 1):
        control, control_joints, motion = run_control(folder, stem, file, WARPS[min(attempt, len(WARPS)) - 1], control_settings)
        row = {'name': name, 'kind': kind, 'mode': ' '.join(re.findall(r'G6[14](?:\.1)?(?: [PQ][\d.]+)*', text.split('G0')[0])),
               'control_s': motion['cycle_time_s'], 'model_s': account['cycle_time_s'], 'length_over_feed_s': account['length_over_feed_s'],
               'periods': round((account['cycle_time_s'] - motion['cycle_time_s']) / period_s),
               'position_mm': deviation(control, planned), 'joint_mm': deviation(control_joints, joints),
               'velocity': peak_difference(motion['all']['vmax'], account['velocity']),
               'acceleration': peak_difference(motion['all']['amax'], account['acceleration'])}
        runs.append(control)
        if best is None or row['position_mm'] < best['position_mm']:
            best = row
        if best['position_mm'] < 1e-6:
            break
    best['runs'] = attempt
    best['repeated'] = any(deviation(a, b) < 1e-6 for a, b in itertools.combinations(runs, 2))
    if best['position_mm'] >= 1e-6:
        nearby = [run_model(args.model, file, machine, setup, *model_settings, f'ACCELERATION_FACTOR={1 + k * 1e-13!r}')['cycle_time_s']
                  for k in range(-8, 9)] if not model_settings else [account['cycle_time_s']]
        best['spread_s'] = [min(nearby), max(nearby)]
    print(f"{name}: LinuxCNC {best['control_s']:.3f} s, model {best['model_s']:.3f} s, {best['periods']} periods, "
          f"{best['position_mm']:.1e} mm, {best['runs']} runs", flush=True)
    return best


def table(rows):
    yield '| program | blocks are | mode | LinuxCNC s | model s | periods | time % | position mm | velocity % | acceleration % | length / F s | % |'
    yield '|---|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|'
    for r in rows:
        percent = 100 * (r['model_s'] / r['control_s'] - 1)
        naive = 100 * (r['length_over_feed_s'] / r['control_s'] - 1)
        yield (f"| {r['name']} | {r['kind']} | {r['mode'] or 'none said'} | {r['control_s']:.3f} | {r['model_s']:.3f} | {r['periods']} | {percent:.3f} | "
               f"{r['position_mm']:.1e} | {100 * r['velocity']:.1e} | {100 * r['acceleration']:.1e} | {r['length_over_feed_s']:.3f} | {naive:.0f} |")


def spreads(rows):
    for r in rows:
        if 'spread_s' in r:
            low, high = r['spread_s']
            yield f"- `{r['name']}`: {low:.3f} … {high:.3f} s in the model ({100 * (high / low - 1):.2f} %), LinuxCNC {r['control_s']:.3f} s."


def write(output, rows):
    """Between the two marks of the page; the text around them stays."""
    text = output.read_text()
    begin, end = '<!-- table -->\n', '<!-- end -->'
    head, rest = text.split(begin)
    body = '\n'.join(table(rows)) + '\n\nTimes of the model when the accelerations are changed by up to 8·10⁻¹³ of themselves:\n' + '\n'.join(spreads(rows)) + '\n'
    output.write_text(head + begin + body + end + rest.split(end)[1])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--model', default=ROOT / 'build/release/bench/bench_linuxcnc_model', type=pathlib.Path)
    parser.add_argument('--shared', default=ROOT.parent / 'shared', type=pathlib.Path)
    parser.add_argument('--install', action='store_true')
    parser.add_argument('--only', nargs='+', default=[])
    parser.add_argument('--runs', type=int, default=5, help='of the control, until positions agree: commands may come late')
    parser.add_argument('--json', type=pathlib.Path)
    parser.add_argument('--output', type=pathlib.Path)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix='trunnion-linuxcnc-') as name:
        folder = pathlib.Path(name)
        folder.chmod(0o755)
        prepare(folder, args.shared, args.install)
        setup, machine = folder / 'setup.toml', args.shared / 'data/cases/peer-trunnion.toml'
        setup.write_text(SETUP)
        made = made_programs()
        jobs = made + list(shared_programs(args.shared)) + list(varied_programs(made))
        rows = [compare(folder, args, machine, setup, *job) for job in jobs if not args.only or job[0] in args.only]
    if args.json:
        args.json.write_text(json.dumps(rows, indent=1))
    if args.output:
        write(args.output, rows)
    print('\n'.join(table(rows)))


main()
