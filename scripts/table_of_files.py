#!/usr/bin/python3
"""Reads, plans and checks every part program of the shared folder, and writes the table of docs/files-read.md.

    scripts/table_of_files.py [--trunnion build/release/apps/trunnion/trunnion] [--shared ../shared] [--only PART_OF_NAME…]
        [--output docs/files-read.md]

Every file is planned on a machine with the letters that it uses, with the limits of `ucp710` and travel that is never in
the way: it is the reading and the motion that are looked at. Tools that a file calls are 100 mm long. Exit status 77: no
shared folder."""
import argparse
import json
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
LINEAR = 'max_velocity = "30 m/min"\nmax_acceleration = "2.5 m/s^2"\nmax_jerk = "50 m/s^3"\n'
ROTARY = 'max_velocity = "20 rpm"\nmax_acceleration = "10 rad/s^2"\nmax_jerk = "500 rad/s^3"\n'
DIRECTION = {'A': [1, 0, 0], 'B': [0, 1, 0], 'C': [0, 0, 1], 'U': [1, 0, 0], 'V': [0, 0, 1]}
# By folder or file: the chain, and what the command line has to say of it.
FILES = {
    'additive/model_1_bc': ('C B X Y Z', ['--feed', '3m/min'], ''),
    'additive/ring_bc': ('C B X Y Z', ['--feed', '3m/min'], '[words]\nfollowing = ["A"]\n'),
    'additive/open5x_uv': ('V U X Y Z', ['--feed', '3m/min'], '[words]\nfollowing = ["E"]\n'),
    'additive/mastercam': ('C X Z Y B', ['--feed', '3m/min'], '[words]\nfollowing = ["E"]\n'),
    'apt': ('C A X Y Z', ['--units', 'mm', '--feed', '3m/min'], ''),
    'fanuc': ('C B X Y Z', [], ''),
    'haas': ('C B X Y Z', [], ''),
    'heidenhain': ('C B X Y Z', [], ''),
    'iso/finition_ab_rad': ('A B X Y Z', ['--feed', '3m/min'], ''),
    'iso': ('C A X Y Z', [], ''),
    'linuxcnc': ('C A X Y Z', ['--feed', '3m/min'], ''),
    'linuxcnc/impeller': ('C A X Y Z', [], ''),
    'siemens/dmu70': ('C B X Y Z', [], ''),
    'siemens/huron': ('C A X Y Z', [], ''),
    'siemens': ('C B X Y Z', [], ''),
}


def entry(name):
    return FILES[max((key for key in FILES if name.startswith(key)), key=len)]


def write_machine(file, chain, words):
    lines = ['name = "with travel"', f'chain = "{chain}"', words]
    for letter in chain.split():
        if letter in DIRECTION:
            kind = '' if letter in 'ABC' else f'type = "rotary"\ndirection = {DIRECTION[letter]}\n'
            lines.append(f'[axes.{letter}]\nrange = "endless"\n{kind}{ROTARY}')
        else:
            lines.append(f'[axes.{letter}]\nrange = ["-20 m", "20 m"]\n{LINEAR}')
    file.write_text('\n'.join(lines))


def write_setup(file, text):
    """The tools by every number or name that the text calls one by."""
    names = {'0', *(str(int(n)) for n in re.findall(r'\b[THD]\s*=?\s*(\d+)', text))}
    names |= set(re.findall(r'\bT\s*=\s*"([^"]+)"', text)) | set(re.findall(r'TOOL CALL\s+"?([\w.-]+)', text))
    names |= set(re.findall(r'(?:LOADTL|TURRET)\s*/\s*([\w.-]+)', text))
    body = 'kind = "flat"\ndiameter = "10 mm"\nlength = "100 mm"\n'
    file.write_text('[workpiece]\norigin = ["0 mm", "0 mm", "0 mm"]\n[tool]\n' + body + ''.join(f'[tools."{n}"]\n{body}' for n in sorted(names)))


def first_error(text):
    found = re.search(r'\b([A-Z]{2,4}\d{4})\b[^\n]*', text)
    return found[0] if found else text.strip().splitlines()[-1] if text.strip() else 'no message'


def run(trunnion, *arguments):
    try:
        return subprocess.run([trunnion, *map(str, arguments), '--quiet'], capture_output=True, text=True, timeout=900, errors='replace')
    except subprocess.TimeoutExpired:
        return subprocess.CompletedProcess(arguments, 124, '', 'longer than 900 s')


def row_of(trunnion, shared, folder, name, file):
    chain, options, words = entry(name)
    text = file.read_bytes().decode('latin-1')
    machine, setup, points, summary, poses = (folder / n for n in ('machine.toml', 'setup.toml', 'out.csv', 'summary.json', 'poses.csv'))
    write_machine(machine, chain, words)
    write_setup(setup, text)
    common = ['-m', machine, '--setup', setup, *options]
    done = run(trunnion, 'plan', file, *common, '-o', points, '--summary', summary, '--programmed', poses)
    row = {'file': name, 'chain': chain}
    if done.returncode != 0:
        return row | {'verdict': first_error(done.stderr + done.stdout)}
    account = json.loads(summary.read_text())
    lines, five = blocks_of(poses)
    row |= {'dialect': account.get('dialect', ''), 'blocks': lines, 'five': five, 'time': account['cycle_time_s'],
            'warnings': ' '.join(sorted({d['code'] for d in account['diagnostics']}))}
    checked = run(trunnion, 'check', points, '--against', file, *common)
    row['verdict'] = 'passes' if checked.returncode == 0 else 'check: ' + first_error(checked.stdout + checked.stderr)
    return row | {'outside': outside_verdict(shared, points, machine, setup, poses)}


def outside_verdict(shared, points, machine, setup, poses):
    done = subprocess.run(['/usr/bin/python3', shared / 'tools/verify_setpoints.py', points, '--machine', machine, '--setup', setup,
                           '--programmed', poses, '--json'], capture_output=True, text=True)
    if done.returncode not in (0, 1) or not done.stdout.strip():
        return first_error(done.stderr)
    found = json.loads(done.stdout)
    ratio = max(axis[f'{kind}_ratio'] for axis in found['axes'].values() for kind in ('velocity', 'acceleration', 'jerk'))
    return f"axes {ratio:.3f}, tip {1000 * found['tip_deviation_mm']:.1f} µm, tool {found['orientation_deviation_deg']:.3f}°"


def blocks_of(poses):
    """Lines of the program that move, and those among them that turn the tool."""
    moving, turning, before = set(), set(), None
    with poses.open() as rows:
        names = next(rows).strip().split(',')
        turn = [k for k, n in enumerate(names) if n in 'ijk' or n.endswith('_deg')]
        line = names.index('line')
        for text in rows:
            fields = text.strip().split(',')
            now = [fields[k] for k in turn]
            moving.add(fields[line])
            if before is not None and now != before:
                turning.add(fields[line])
            before = now
    return len(moving), len(turning)


def table(rows):
    yield '| file | axes | dialect | blocks | 5-axis | planned s | told | verdict | outside checker: peak of axes / limit, deviation |'
    yield '|---|---|---|---:|---:|---:|---|---|---|'
    for r in rows:
        numbers = (f"{r['dialect']} | {r['blocks']} | {r['five']} | {r['time']:.3f} | {r['warnings']}" if 'time' in r else ' | | | | ')
        yield f"| {r['file']} | {r['chain']} | {numbers} | {r['verdict'].replace('|', '/')[:150]} | {r.get('outside', '')} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--trunnion', default=ROOT / 'build/release/apps/trunnion/trunnion', type=pathlib.Path)
    parser.add_argument('--shared', default=ROOT.parent / 'shared', type=pathlib.Path)
    parser.add_argument('--only', nargs='+', default=[''])
    parser.add_argument('--output', type=pathlib.Path)
    args = parser.parse_args()
    home = args.shared / 'data/nc'
    if not home.exists():
        print('skipped: no shared folder')
        sys.exit(77)
    names = sorted(str(f.relative_to(home)) for f in home.rglob('*') if f.is_file() and f.suffix != '.tsv')
    rows = []
    with tempfile.TemporaryDirectory(prefix='trunnion-files-') as folder:
        for name in names:
            if any(part in name for part in args.only):
                rows.append(row_of(args.trunnion, args.shared, pathlib.Path(folder), name, home / name))
                print(rows[-1], flush=True)
    body = '\n'.join(table(rows)) + '\n'
    if args.output:
        text = args.output.read_text()
        begin, end = '<!-- table -->\n', '<!-- end -->'
        args.output.write_text(text.split(begin)[0] + begin + body + end + text.split(end)[1])
    print(body)


main()
