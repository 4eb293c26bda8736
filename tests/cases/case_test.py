"""Plans one named case, has the outside checker judge the setpoints, and compares time and counts with what the case must reach.

    case_test.py TRUNNION SHARED CASE

Exit status 77: the shared folder is not there (ctest reports the test as skipped)."""
import json
import pathlib
import subprocess
import sys
import tempfile

# tolerance options, most seconds, exact stops
TOLERANCE = ['--tip-tolerance', '10um', '--orientation-tolerance', '0.1deg']
SPECIAL = {'pyramid': ['--tip-tolerance', '20um', '--flank-tolerance', '20um'],
           'pocket': ['--tip-tolerance', '3mm', '--flank-tolerance', '3mm']}
MOST_SECONDS = {'sine-10k': 45.0, 'fillet': 3.5}
TIP, ORIENTATION = 0.010, 0.1


def run(command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f'{" ".join(map(str, command))}\nended with {done.returncode}\n{done.stdout}{done.stderr}')
    return done.stdout


def main():
    trunnion, shared, name = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
    cases = shared / 'data/cases'
    if not (cases / 'cases.json').exists():
        print('skipped: no shared cases')
        sys.exit(77)
    case = next(c for c in json.loads((cases / 'cases.json').read_text()) if c['name'] == name)
    machine, setup = cases / case['machine'], cases / case['setup']
    with tempfile.TemporaryDirectory() as folder:
        setpoints, summary_file, programmed = (pathlib.Path(folder) / f for f in ('q.csv', 's.json', 'p.csv'))
        options = SPECIAL.get(name, TOLERANCE)
        run([trunnion, 'plan', cases / case['program'], '-m', machine, '--setup', setup, '-o', setpoints, '--summary',
             summary_file, '--programmed', programmed, '--quiet', *options])
        summary = json.loads(summary_file.read_text())
        outside = json.loads(run(['/usr/bin/python3', shared / 'tools/verify_setpoints.py', setpoints, '--machine', machine,
                                  '--setup', setup, '--programmed', cases / case['programmed'], '--json']))
        own = json.loads(run(['/usr/bin/python3', shared / 'tools/verify_setpoints.py', setpoints, '--machine', machine,
                              '--setup', setup, '--programmed', programmed, '--json']))
        run([trunnion, 'check', setpoints, '--against', cases / case['program'], '-m', machine, '--setup', setup, '--quiet',
             *options])
    wrong = []

    def expect(what, good):
        if not good:
            wrong.append(what)

    for verdict in (outside, own):
        for letter, axis in verdict['axes'].items():
            for ratio in ('velocity_ratio', 'acceleration_ratio', 'jerk_ratio'):
                expect(f'{letter} {ratio} {axis[ratio]:.5f}', axis[ratio] <= 1.001)
            expect(f'{letter} out of range', axis['range_excess'] <= 1e-9)
        tip, height = (0.02, 0.02) if name == 'pyramid' else (3.0, 3.0) if name == 'pocket' else (TIP, None)
        for key in ('tip_deviation_mm', 'tip_to_poses_mm'):
            expect(f'{key} {verdict[key]:.5f}', verdict[key] <= tip)
        for key in ('orientation_deviation_deg', 'orientation_to_poses_deg') if height is None else ():
            expect(f'{key} {verdict[key]:.5f}', verdict[key] <= ORIENTATION)
        for key in ('height_deviation_mm', 'height_to_poses_mm') if height is not None else ():
            expect(f'{key} {verdict[key]:.5f}', verdict[key] <= height)
        expect(f"covered {verdict['path_covered']:.6f}", verdict['path_covered'] >= 1 - 1e-9)
        expect(f"start {verdict['start_error_mm']:.2g} end {verdict['end_error_mm']:.2g}",
               max(verdict['start_error_mm'], verdict['end_error_mm']) < 1e-6)
    expect(f"summary's time {summary['cycle_time_s']} is not that of the setpoints {outside['cycle_time_s']}",
           0 <= outside['cycle_time_s'] - summary['cycle_time_s'] <= 1.001e-3)
    expect(f"{summary['cycle_time_s']:.3f} s", summary['cycle_time_s'] <= MOST_SECONDS.get(name, 1e9))
    expect('slower than the bound by far', summary['jerk_free_bound_s'] <= summary['cycle_time_s'] * (1 + 1e-9))
    expect(f"exact stops {summary['exact_stops']}", summary['exact_stops']['total'] == 0)
    expect('not usable', summary['usable'])
    if name in ('corner', 'pyramid', 'pocket', 'fillet'):  # blocks long enough to use it
        expect(f"tolerance used {summary['tolerance_used']:.3f}", summary['tolerance_used'] >= 0.5)
    print(f"{name}: {summary['cycle_time_s']:.4f} s, jerk-free {summary['jerk_free_bound_s']:.4f} s")
    if wrong:
        sys.exit('wrong:\n  ' + '\n  '.join(wrong))


main()
