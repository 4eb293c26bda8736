"""Plans a real part program, has the outside checker judge the setpoints, and compares the time with that of exact stops or with
a given bound.

    real_program_test.py TRUNNION SHARED PROGRAM MOST_SECONDS|half-of-stops raised-jerk|- [option…]
Exit status 77: the shared folder is not there (ctest reports the test as skipped)."""
import json
import pathlib
import subprocess
import sys
import tempfile


def run(command, statuses=(0,)):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode not in statuses:
        sys.exit(f'{" ".join(map(str, command))}\nended with {done.returncode}\n{done.stdout}{done.stderr}')
    return done.stdout


def machine_file(shared, folder, raised):
    """The table of the cases with the words of LinuxCNC's own; with jerk raised where asked."""
    lines = (shared / 'data/cases/peer-trunnion.toml').read_text().splitlines()
    if raised:
        lines = [('max_jerk = "5000 deg/s^3"' if 'deg' in line else 'max_jerk = "50 m/s^3"') if line.startswith('max_jerk') else line
                 for line in lines]
    path = pathlib.Path(folder) / 'machine.toml'
    path.write_text('\n'.join(lines) + '\n[words]\ntcp_on = ["M428"]\ntcp_off = ["M429"]\n')
    return path


def main():
    trunnion, shared, most, raised = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[4], sys.argv[5] == 'raised-jerk'
    program, options = shared / 'data/nc' / sys.argv[3], sys.argv[6:]
    if not program.exists():
        print('skipped: no shared programs')
        sys.exit(77)
    setup = shared / 'data/cases/peer-setup.toml'
    with tempfile.TemporaryDirectory() as folder:
        machine = machine_file(shared, folder, raised)
        q, s, p, n = (pathlib.Path(folder) / f for f in ('q.csv', 's.json', 'p.csv', 'n.json'))
        common = [trunnion, 'plan', program, '-m', machine, '--setup', setup, '--quiet', '--tip-tolerance', '10um', *options]
        run([*common, '-o', q, '--summary', s, '--programmed', p])
        summary = json.loads(s.read_text())
        outside = json.loads(run(['/usr/bin/python3', shared / 'tools/verify_setpoints.py', q, '--machine', machine, '--setup', setup,
                                  '--programmed', p, '--json']))
        if most == 'half-of-stops':
            run([*common, '--rounding', 'none', '--summary', n])
            most = json.loads(n.read_text())['cycle_time_s'] / 2
    wrong = []
    for letter, axis in outside['axes'].items():
        for ratio in ('velocity_ratio', 'acceleration_ratio', 'jerk_ratio'):
            if axis[ratio] > 1.001:
                wrong.append(f'{letter} {ratio} {axis[ratio]:.5f}')
        if axis['range_excess'] > 1e-9:
            wrong.append(f'{letter} out of range')
    for key, limit in (('tip_deviation_mm', 0.01), ('tip_to_poses_mm', 0.01), ('orientation_deviation_deg', 0.1),
                       ('orientation_to_poses_deg', 0.1)):
        if outside[key] > limit:
            wrong.append(f'{key} {outside[key]:.5f}')
    if outside['path_covered'] < 1 - 1e-9:
        wrong.append(f"covered {outside['path_covered']}")
    if summary['cycle_time_s'] > float(most):
        wrong.append(f"{summary['cycle_time_s']:.3f} s, allowed {float(most):.3f}")
    print(f"{summary['cycle_time_s']:.3f} s, allowed {float(most):.3f}")
    if wrong:
        sys.exit('wrong:\n  ' + '\n  '.join(wrong))


main()
