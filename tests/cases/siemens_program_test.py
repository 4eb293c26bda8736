"""Plans a Siemens program of the shared folder on the machine and setup beside this file and has both checkers judge the setpoints:
the project's own with tools of different lengths, the outside one with tools of no length (it knows one length only). Or expects the
program to be refused.

    siemens_program_test.py TRUNNION SHARED PROGRAM plans|plans-long|CODE [--until TEXT] [option…]
plans-long: only the outside checker, for programs of many minutes, which `plans` leaves out.
--until: the part before the first line with this text, where what follows is rightly refused.
Exit status 77: the shared folder is not there (ctest reports the test as skipped)."""
import json
import pathlib
import re
import subprocess
import sys
import tempfile

here = pathlib.Path(__file__).parent
machine = here / 'siemens-machine.toml'
outside_most_s = 100  # longer motions take the outside checker minutes


def run(command, status=0):
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    if done.returncode != status:
        sys.exit(f'{" ".join(map(str, command))}\nended with {done.returncode}, not {status}\n{done.stdout}{done.stderr}')
    return done


def part_of(program, end, folder):
    """The program up to the line with the text `end`."""
    if not end:
        return program
    text = program.read_text(errors='replace')
    part = folder / program.name
    part.write_text(text[:text.rindex('\n', 0, text.index(end)) + 1] + 'M30\n')
    return part


def plan(trunnion, program, setup, folder, options):
    q, p = folder / 'q.csv', folder / 'p.csv'
    run([trunnion, 'plan', program, '-m', machine, '--setup', setup, '--quiet', '-o', q, '--programmed', p, *options])
    return q, p


def judged_by_ourselves(trunnion, program, folder, options):
    """Every tool with its own length, work offsets in different places."""
    setup, verdict = here / 'siemens-setup.toml', folder / 'v.json'
    q, _ = plan(trunnion, program, setup, folder, options)
    run([trunnion, 'check', q, '--against', program, '-m', machine, '--setup', setup, '--summary', verdict, '--quiet'])
    found = json.loads(verdict.read_text())
    return {**found, 'axes': {k: {'range_excess': 0, **a} for k, a in found['axes'].items()}}


def judged_outside(trunnion, shared, program, folder, options, step):
    setup = folder / 's.toml'
    setup.write_text(re.sub(r'(?m)^length = .*$', 'length = "0 mm"', (here / 'siemens-setup.toml').read_text()))
    q, p = plan(trunnion, program, setup, folder, options)
    return json.loads(run(['/usr/bin/python3', shared / 'tools/verify_setpoints.py', q, '--machine', machine, '--setup', setup,
                           '--programmed', p, '--json', '--step', step]).stdout)


def faults(verdict):
    for letter, axis in verdict['axes'].items():
        for ratio in ('velocity_ratio', 'acceleration_ratio', 'jerk_ratio'):
            if axis[ratio] > 1.005:
                yield f'{letter} {ratio} {axis[ratio]:.5f}'
        if axis['range_excess'] > 1e-9:
            yield f'{letter} out of range'
    if max(axis['velocity_ratio'] for axis in verdict['axes'].values()) < 0.95:
        yield 'no axis comes near its velocity: the rapids are not those of the machine'
    for key, limit in (('tip_deviation_mm', 0.02), ('tip_to_poses_mm', 0.02), ('orientation_deviation_deg', 0.1),
                       ('orientation_to_poses_deg', 0.1)):
        if verdict[key] > limit:
            yield f'{key} {verdict[key]:.5f}'
    if verdict['path_covered'] < 1 - 1e-9:
        yield f"covered {verdict['path_covered']}"


def main():
    trunnion, shared, expected, options = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[4], sys.argv[5:]
    end = options[1] if options[:1] == ['--until'] else ''
    options = options[2:] if end else options
    program = shared / 'data/nc/siemens' / sys.argv[3]
    if not program.exists():
        print('skipped: no shared programs')
        sys.exit(77)
    if not expected.startswith('plans'):
        done = run([trunnion, 'plan', program, '-m', machine, '--setup', here / 'siemens-setup.toml', '--quiet'], status=2)
        if f'error {expected}' not in done.stderr:
            sys.exit(f'not refused with {expected}:\n{done.stderr}')
        return
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        program = part_of(program, end, folder)
        verdicts = []
        if expected == 'plans':
            verdicts.append(judged_by_ourselves(trunnion, program, folder, options))
        if expected == 'plans-long':
            verdicts.append(judged_outside(trunnion, shared, program, folder, options, 0.02))
        elif verdicts[0]['cycle_time_s'] < outside_most_s:
            verdicts.append(judged_outside(trunnion, shared, program, folder, options, 0.005))
        wrong = [fault for one in verdicts for fault in faults(one)]
    if wrong:
        sys.exit('wrong:\n  ' + '\n  '.join(wrong))


main()
