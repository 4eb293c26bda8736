"""Options of `trunnion plan`: what the summary says of them, two threads against one, worth.

    plan_options_test.py TRUNNION PROGRAM SETUP MACHINE"""
import json
import pathlib
import subprocess
import sys
import tempfile

trunnion, program, setup, machine = sys.argv[1:]
wrong = []


def expect(what, good):
    if not good:
        wrong.append(what)


def plan(folder, name, *options):
    """Setpoints, summary and report."""
    setpoints, summary = folder / f'{name}.csv', folder / f'{name}.json'
    done = subprocess.run([trunnion, 'plan', program, '-m', machine, '--setup', setup, '--quiet', '-o', setpoints, '--summary',
                           summary, *options], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f'{options} ends with {done.returncode}\n{done.stdout}{done.stderr}')
    return setpoints.read_bytes(), json.loads(summary.read_text()), done.stdout


def expect_options(summary, wanted):
    for key, value in wanted.items():
        found = summary['options'][key]
        same = abs(found - value) <= 1e-9 * abs(value) if isinstance(value, float) and isinstance(found, (int, float)) else found == value
        expect(f'options.{key} is {found}, not {value}', same)


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    rows, plain, report = plan(folder, 'plain')
    expect_options(plain, {'chord_error_mm': None, 'tip_acceleration_mm_s2': None, 'tip_jerk_mm_s3': None, 'tool_turn_deg_s': None,
                           'calm': 0.001, 'threads': 1, 'worth': False, 'feed_mm_min': None, 'jerk_margin': 0, 'rounding': 'smooth'})
    expect('calm has a price though nobody asked', plain['calm'] == {'weight': 0.001, 'price_s': None, 'price_share': None})
    expect('worth though nobody asked', plain['worth'] == [] and '\nworth ' not in report)
    expect(f'a report of {len(report.splitlines())} lines', len(report.splitlines()) <= 17)

    _, given, _ = plan(folder, 'given', '--chord-error', '50um', '--tip-acceleration', '2 m/s^2', '--tip-jerk', '50 m/s^3', '--tool-turn',
                       '900 deg/s', '--calm', '0.002', '--feed', '3 m/min', '--jerk-margin', '10%', '--period', '2ms')
    expect_options(given, {'chord_error_mm': 0.05, 'tip_acceleration_mm_s2': 2000.0, 'tip_jerk_mm_s3': 50000.0, 'tool_turn_deg_s': 900.0,
                           'calm': 0.002, 'feed_mm_min': 3000.0, 'jerk_margin': 0.1, 'period_s': 0.002})
    expect('no price of calm', isinstance(given['calm']['price_s'], float))

    same_rows, two, _ = plan(folder, 'two', '--threads', '2')
    expect('other setpoints with two threads', same_rows == rows)
    for summary in (plain, two):
        del summary['work'], summary['options']['threads']
    expect('another summary with two threads', two == plain)

    same_rows, worth, report = plan(folder, 'worth', '--worth', '--threads', '2')
    expect('other setpoints with worth', same_rows == rows)
    saved = [w['saves_s'] for w in worth['worth']]
    expect('worth is not sorted', saved == sorted(saved, reverse=True) and saved[0] > 0.01)
    expect('no worth of a limit', {'feed', 'C velocity', 'tip tolerance', 'orientation tolerance', 'calm'} <= {w['what'] for w in worth['worth']})
    expect('no worth in the report', '\nworth ' in report)

if wrong:
    sys.exit('\n'.join(wrong))
