#!/usr/bin/env python3
"""Plans every named case and every real program that must plan, has the outside checker judge the setpoints, and prints the
table of docs/performance.md.

    bench/measure.py [--trunnion build/release/apps/trunnion/trunnion] [--shared ../shared] [--only NAME…] [--jobs 2]
        [--options="--rounding beudaert --calm 0"]"""
import argparse
import concurrent.futures
import json
import pathlib
import subprocess
import tempfile
import time

CREO = ['--units', 'mm', '--feed', '20m/min']
TIGHT = ['--tip-tolerance', '10um']


def jobs(shared):
    cases = shared / 'data/cases'
    for case in json.loads((cases / 'cases.json').read_text()):
        options = {'pyramid': ['--tip-tolerance', '20um', '--flank-tolerance', '20um'],
                   'pocket': ['--tip-tolerance', '3mm', '--flank-tolerance', '3mm']}.get(case['name'], TIGHT)
        yield case['name'], cases / case['program'], cases / case['programmed'], 'peer-trunnion', options
    nc = shared / 'data/nc'
    for name, file, options in (('finition_creo', 'apt/finition_creo.ncl', CREO), ('hust_yelun', 'apt/hust_yelun_impeller.cls', CREO),
                                ('hust_pathpoints', 'apt/hust_pathpoints.cls', CREO)):
        yield name, nc / file, None, 'peer-trunnion', options + TIGHT
        yield f'{name}, no rounding', nc / file, None, 'peer-trunnion', options + ['--rounding', 'none']
    yield 'impeller, as posted', nc / 'linuxcnc/impeller-7bl-xyzac.ngc', None, 'peer-tcp', TIGHT
    yield 'impeller, 2000 %', nc / 'linuxcnc/impeller-7bl-xyzac.ngc', None, 'peer-tcp', TIGHT + ['--feed-override', '2000%']
    yield 'impeller, 2000 %, more jerk', nc / 'linuxcnc/impeller-7bl-xyzac.ngc', None, 'peer-more-jerk', TIGHT + ['--feed-override', '2000%']


def machine_file(shared, kind, folder):
    """The machine of the cases; for the impeller with the control's own words, and with jerk raised."""
    source = (shared / 'data/cases/peer-trunnion.toml').read_text()
    words = '[words]\ntcp_on = ["M428"]\ntcp_off = ["M429"]\n'
    if kind == 'peer-more-jerk':
        out = []
        for line in source.splitlines():
            if line.startswith('max_jerk'):
                line = 'max_jerk = "5000 deg/s^3"' if 'deg' in line else 'max_jerk = "50 m/s^3"'
            out.append(line)
        source = '\n'.join(out) + '\n'
    path = pathlib.Path(folder) / f'{kind}.toml'
    path.write_text(source + ('' if kind == 'peer-trunnion' else words))
    return path


def measure(args, name, program, programmed, kind, options):
    with tempfile.TemporaryDirectory() as folder:
        machine = machine_file(args.shared, kind, folder)
        setup = args.shared / 'data/cases/peer-setup.toml'
        q, s, p = (pathlib.Path(folder) / f for f in ('q.csv', 's.json', 'p.csv'))
        start = time.time()
        done = subprocess.run([args.trunnion, 'plan', program, '-m', machine, '--setup', setup, '-o', q, '--summary', s,
                               '--programmed', p, '--quiet', *options, *args.options], capture_output=True, text=True)
        wall = time.time() - start
        if done.returncode not in (0, 1):
            return f'| {name} | **{done.stderr.strip()}** |'
        summary = json.loads(s.read_text())
        if 'no rounding' in name:  # only its time is of interest
            return (f"| {name} | {summary['blocks']} | {summary['cycle_time_s']:.3f} | {summary['jerk_free_bound_s']:.3f} | | | | | | | "
                    f"{summary['exact_stops']['total']} | {summary['fallbacks']} | | {wall:.1f} |")
        checked = subprocess.run(['/usr/bin/python3', args.shared / 'tools/verify_setpoints.py', q, '--machine', machine, '--setup',
                                  setup, '--programmed', programmed or p, '--json'], capture_output=True, text=True)
        v = json.loads(checked.stdout)
    ratio = [max(a[k] for a in v['axes'].values()) for k in ('velocity_ratio', 'acceleration_ratio', 'jerk_ratio')]
    w = summary['work']
    return (f"| {name} | {summary['blocks']} | {summary['cycle_time_s']:.3f} | {summary['jerk_free_bound_s']:.3f} | "
            f"{ratio[0]:.4f} {ratio[1]:.4f} {ratio[2]:.4f} | {v['tip_deviation_mm']*1e3:.2f} / {v['tip_to_poses_mm']*1e3:.2f} | "
            f"{v['orientation_deviation_deg']:.4f} | {v['height_deviation_mm']*1e3:.1f} | {v['path_covered']:.6f} | "
            f"{summary['tolerance_used']:.2f} | {summary['exact_stops']['total']} | {summary['fallbacks']} | "
            f"{w['read_s']:.2f} {w['smooth_s']:.2f} {w['plan_s']:.2f} {w['sample_s']:.2f} | {wall:.1f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--trunnion', default='build/release/apps/trunnion/trunnion')
    parser.add_argument('--shared', type=pathlib.Path, default=pathlib.Path('../shared'))
    parser.add_argument('--only', nargs='*')
    parser.add_argument('--jobs', type=int, default=2)
    parser.add_argument('--options', type=str.split, default=[], help='of plan, for all programs')
    args = parser.parse_args()
    wanted = [j for j in jobs(args.shared) if not ('--rounding' in args.options and 'no rounding' in j[0]) and (
              not args.only or any(o in j[0] for o in args.only))]
    print('| program | blocks | time s | jerk-free s | velocity, acceleration, jerk / limit | tip µm: motion / poses | orientation deg '
          '| 30 mm up µm | covered | tolerance used | exact stops | fallbacks | read smooth plan sample s | wall s |')
    print('|' + '---|' * 14)
    with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        for row in pool.map(lambda job: measure(args, *job), wanted):
            print(row, flush=True)


main()
