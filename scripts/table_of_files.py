#!/usr/bin/python3
"""Reads, plans and checks every part program of the shared folder, and writes the table of docs/files-read.md.

    scripts/table_of_files.py [--trunnion build/release/apps/trunnion/trunnion] [--shared ../shared] [--only PART_OF_NAME…]
        [--cache FOLDER] [--inside-only] [--output docs/files-read.md]

Every file is planned on a machine with the letters that it uses, with the limits of `ucp710` (ten times its jerk) and travel
that is never in the way: it is the reading and the motion that are looked at. All tools that a file calls are 100 mm long,
as the outside checker knows one length. Rows are found again in the cache while file, machine, setup, options, program and
checkers are the same. --inside-only leaves the outside checker out, which takes most of the time, where the cache has no row
of it. Exit status 77: no shared folder."""
import argparse
import hashlib
import json
import math
import os
import pathlib
import re
import resource
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
LINEAR = 'max_velocity = "30 m/min"\nmax_acceleration = "2.5 m/s^2"\nmax_jerk = "50 m/s^3"\n'
ROTARY = 'max_velocity = "20 rpm"\nmax_acceleration = "10 rad/s^2"\nmax_jerk = "500 rad/s^3"\n'
DIRECTION = {'A': [1, 0, 0], 'B': [0, 1, 0], 'C': [0, 0, 1], 'U': [1, 0, 0], 'V': [0, 0, 1]}
SECOND_LOOK = ROOT / 'scripts/least_deviation.py'
LONGEST_S = 3600  # of processor time for one step
FEED = ['--feed', '3m/min']
EXTRUDER = '[words]\nfollowing = ["E"]\n'
OFFSETS = ''.join(f'[offsets."{n}"]\norigin = ["0 mm", "0 mm", "0 mm"]\n'
                  for n in [f'G{n}' for n in range(55, 60)] + [f'G54.1 P{n}' for n in range(1, 49)])
LAST = ['heidenhain/dmc100_tnc_in.h']  # the outside checker needs some 15 GB of memory for it
# By folder or file: the chain, what options, machine file and setup file have to say of it, and the period.
FILES = {
    'additive/model_1_bc': ('C B X Y Z', FEED, EXTRUDER, '', '1ms'),
    'additive/ring_bc': ('C B X Y Z', FEED, '[words]\nfollowing = ["A"]\n', '', '1ms'),
    'additive/open5x_uv': ('V U X Y Z', FEED, EXTRUDER, '', '1ms'),
    'additive/mastercam': ('C X Z Y B', FEED, EXTRUDER, '', '1ms'),
    'apt': ('C A X Y Z', ['--units', 'mm', *FEED], '', '', '1ms'),
    'fanuc': ('C B X Y Z', [], '', OFFSETS, '1ms'),
    'haas': ('C B X Y Z', [], '', '', '1ms'),
    'heidenhain': ('C B X Y Z', ['--units', 'mm'], '', '', '2ms'),
    'iso/aileron': ('C A X Y Z', [], '[words]\ntcp_on = ["M128"]\ntcp_off = ["M126"]\n', '', '1ms'),
    'iso/finition_ab_rad': ('A B X Y Z', FEED, '', '', '1ms'),
    'linuxcnc': ('C A X Y Z', FEED, '', '', '1ms'),
    'linuxcnc/impeller': ('C A X Y Z', [], '', '', '1ms'),
    'siemens/huron': ('C A X Y Z', [], '', '', '1ms'),
    'siemens': ('C B X Y Z', [], '', '', '1ms'),
}


def entry(name):
    return FILES[max((key for key in FILES if name.startswith(key)), key=len)]


def machine_file(chain, words):
    lines = ['name = "with travel"', f'chain = "{chain}"', words]
    for letter in chain.split():
        if letter in DIRECTION:
            kind = '' if letter in 'ABC' else f'type = "rotary"\ndirection = {DIRECTION[letter]}\n'
            lines.append(f'[axes.{letter}]\nrange = "endless"\n{kind}{ROTARY}')
        else:
            lines.append(f'[axes.{letter}]\nrange = ["-20 m", "20 m"]\n{LINEAR}')
    return '\n'.join(lines)


def setup_file(text, offsets):
    """The tools by every number or name that the text calls one by."""
    names = {'0', *(str(int(n)) for n in re.findall(r'\b[THD]\s*=?\s*(\d+)', text))}
    names |= set(re.findall(r'\bT\s*=\s*"([^"]+)"', text)) | set(re.findall(r'TOOL CALL\s+"?([\w.-]+)', text))
    names |= set(re.findall(r'(?:LOADTL|TURRET)\s*/\s*([\w.-]+)', text))
    body = 'kind = "flat"\ndiameter = "10 mm"\nlength = "100 mm"\n'
    tools = ''.join(f'[tools."{n}"]\n{body}' for n in sorted(names))
    return '[workpiece]\norigin = ["0 mm", "0 mm", "0 mm"]\n[tool]\n' + body + tools + offsets


def first_error(text):
    found = re.search(r'\b([A-Z]{2,4}\d{4}|BROKEN)\b[^\n]*', text)
    return found[0] if found else text.strip().splitlines()[-1] if text.strip() else 'no message'


def run(*words):
    """Exit status, what was said, processor time in s and peak of memory in MB."""
    with tempfile.TemporaryFile('w+', errors='replace') as said:
        job = subprocess.Popen(list(map(str, words)), stdout=said, stderr=subprocess.STDOUT,
                               preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (LONGEST_S, LONGEST_S)))
        _, status, used = os.wait4(job.pid, 0)
        said.seek(0)
        return os.waitstatus_to_exitcode(status), said.read(), used.ru_utime + used.ru_stime, used.ru_maxrss / 1000


class Judge:
    """Plans one file and asks the checkers; everything that they write stays in one folder."""

    def __init__(self, trunnion, shared, folder, inside_only):
        self.trunnion = trunnion
        self.inside_only = inside_only
        self.checker = shared / 'tools/verify_setpoints.py'
        names = ('machine.toml', 'setup.toml', 'out.csv', 'summary.json', 'poses.csv', 'verdict.json')
        self.machine, self.setup, self.points, self.summary, self.poses, self.verdict = (folder / n for n in names)

    def row(self, name, file):
        chain, options, words, offsets, period = entry(name)
        self.machine.write_text(machine_file(chain, words))
        self.setup.write_text(setup_file(file.read_bytes().decode('latin-1'), offsets))
        row = {'file': name, 'chain': chain, 'period': period}
        common = ['-m', self.machine, '--setup', self.setup, '--quiet', *options]
        status, said, seconds, _ = run(self.trunnion, 'plan', file, *common, '--period', period, '-o', self.points,
                                       '--summary', self.summary, '--programmed', self.poses)
        if status != 0:
            return row | {'refused': first_error(said)}
        row |= self.account() | {'plan_s': seconds} | self.inside(file, common)
        return row if self.inside_only else row | self.outside()

    def account(self):
        found = json.loads(self.summary.read_text())
        lines, five = blocks_of(self.poses)
        return {'dialect': found['dialect'], 'blocks': lines, 'five': five, 'time': found['cycle_time_s'],
                'setpoints': found['setpoints'], 'warnings': sorted({d['code'] for d in found['diagnostics']})}

    def inside(self, file, common):
        status, said, seconds, megabytes = run(self.trunnion, 'check', self.points, '--against', file, *common, '--summary', self.verdict)
        out = {'check_s': seconds, 'check_mb': megabytes, 'check': 'passes' if status == 0 else first_error(said)}
        return out | {'inside': deviations(json.loads(self.verdict.read_text()))} if status in (0, 1) else out

    def outside(self):
        given = ['--machine', self.machine, '--setup', self.setup, '--programmed', self.poses]
        status, said, _, _ = run('/usr/bin/python3', self.checker, self.points, *given, '--json')
        if status != 0:
            return {'outside_says': first_error(said)}
        found = json.loads(said)
        out = {'outside': deviations(found), 'axes': max(axis[f'{kind}_ratio'] for axis in found['axes'].values()
                                                         for kind in ('velocity', 'acceleration', 'jerk'))}
        if keeps_tolerances(out['outside']):
            return out
        status, said, _, _ = run('/usr/bin/python3', SECOND_LOOK, self.points, '--checker', self.checker, *given)
        return out | ({'anew': json.loads(said), 'anew_by': digest_of(SECOND_LOOK)} if status == 0 else {'outside_says': first_error(said)})


def deviations(found):
    """The larger of what the rows and what the programmed poses show, µm and degrees."""
    return [1000 * max(found['tip_deviation_mm'], found['tip_to_poses_mm']),
            max(found['orientation_deviation_deg'], found['orientation_to_poses_deg'])]


def keeps_tolerances(pair):
    """As the outside checker samples the path every 5 µm, it sees up to a hundredth more."""
    return pair[0] <= 20 * 1.015 and pair[1] <= 0.1 * 1.015


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


def passes(row):
    """Both checkers, where both were asked."""
    outside = 'outside' not in row or keeps_tolerances(row['outside']) or all(
        s['least_share'] <= 1.015 for s in row.get('anew', {'stretches': [{'least_share': math.inf}]})['stretches'])
    return row.get('check') == 'passes' and 'outside_says' not in row and outside and row.get('axes', 0) <= 1.001


def verdict(row):
    if 'refused' in row:
        return row['refused']
    said = ['passes' if passes(row) else 'fails']
    if row['check'] != 'passes':
        said.append(row['check'])
    if 'outside_says' in row:
        said.append(row['outside_says'])
    elif 'outside' not in row:
        said.append('outside checker not run')
    places = row.get('anew', {}).get('stretches')
    if places:
        where = ', '.join(sorted({str(s['line']) for s in places})[:3])
        said.append(f"matched anew: {max(s['least_share'] for s in places):.3f} of the tolerances (line {where})")
    return '; '.join(said)


def pair(values, form):
    return ' / '.join(format(v, form) for v in values)


def cells(row):
    if 'refused' in row:
        return [''] * 9
    time = f"{row['time']:.3f}" + (f" ({row['period'][:-2]} ms)" if row['period'] != '1ms' else '')
    both = [row[k] for k in ('inside', 'outside') if k in row]
    told = ' '.join(row['warnings'])
    return [row['dialect'], row['blocks'], row['five'], time, told, pair([b[0] for b in both], '.1f'), pair([b[1] for b in both], '.3f'),
            f"{row['axes']:.4f}" if 'axes' in row else '', f"{row['plan_s']:.1f}, {row['check_s']:.1f}, {row['check_mb']:.0f}"]


def table(rows):
    yield ('| file | axes | dialect | blocks | 5-axis | planned s | told | tip µm: check / outside | tool °: check / outside | axes | '
           'plan s, check s, MB | verdict |')
    yield '|---|---|---|---:|---:|---:|---|---:|---:|---:|---:|---|'
    for r in rows:
        yield f"| {' | '.join(map(str, [r['file'], r['chain'], *cells(r), verdict(r).replace('|', '/')[:220]]))} |"


def five_axis(row, manifest):
    """Programs whose lines turn the tool, but for those that turn one axis alone."""
    key = max((k for k in manifest if row['file'].startswith(k)), key=len)
    lines, note = manifest[key]
    return lines > 0 and '4-axis' not in note


def read_manifest(home):
    rows = [line.split('\t') for line in (home / 'MANIFEST.tsv').read_text().splitlines()[1:]]
    return {r[0]: (int(r[7]), r[5] + r[9]) for r in rows}


def share(rows, manifest):
    asked = [r for r in rows if five_axis(r, manifest)]
    good = [r for r in asked if passes(r)]
    both = sum('outside' in r for r in good)
    yield (f'{len(rows)} files, {len(asked)} of them 5-axis programs; of these {len(good)} plan and pass: '
           f'{100 * len(good) / max(1, len(asked)):.1f} %. Both checkers judged {both} of them, `trunnion check` alone {len(good) - both}.')
    yield ''


def digest_of(file):
    return hashlib.sha256(file.read_bytes()).hexdigest()


class Cache:
    """Rows by what they come from."""

    def __init__(self, folder, *programs):
        self.folder = folder
        self.programs = [p.read_bytes() for p in programs]
        if folder:
            folder.mkdir(parents=True, exist_ok=True)

    def file(self, name, source):
        digest = hashlib.sha256(repr(entry(name)).encode())
        for part in (source.read_bytes(), LINEAR.encode(), ROTARY.encode(), *self.programs):
            digest.update(part)
        return self.folder / f'{digest.hexdigest()[:24]}.json'

    def row(self, name, source, inside_only, make):
        if not self.folder:
            return make()
        file = self.file(name, source)
        for kept in (file, file.with_suffix('.inside')) if inside_only else (file,):
            row = json.loads(kept.read_text()) if kept.exists() else None
            if row and row.get('anew_by', digest_of(SECOND_LOOK)) == digest_of(SECOND_LOOK):
                return row
        row = make()
        (file.with_suffix('.inside') if inside_only else file).write_text(json.dumps(row))
        return row


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--trunnion', default=ROOT / 'build/release/apps/trunnion/trunnion', type=pathlib.Path)
    parser.add_argument('--shared', default=ROOT.parent / 'shared', type=pathlib.Path)
    parser.add_argument('--only', nargs='+', default=[''])
    parser.add_argument('--cache', type=pathlib.Path)
    parser.add_argument('--inside-only', action='store_true')
    parser.add_argument('--output', type=pathlib.Path)
    args = parser.parse_args()
    home = args.shared / 'data/nc'
    if not home.exists():
        print('skipped: no shared folder')
        sys.exit(77)
    names = sorted(str(f.relative_to(home)) for f in home.rglob('*') if f.is_file() and f.suffix != '.tsv')
    cache = Cache(args.cache, args.trunnion, args.shared / 'tools/verify_setpoints.py')
    rows = []
    for name in sorted((n for n in names if any(part in n for part in args.only)), key=lambda n: (n in LAST, (home / n).stat().st_size)):
        with tempfile.TemporaryDirectory(prefix='trunnion-files-') as folder:
            judge = Judge(args.trunnion, args.shared, pathlib.Path(folder), args.inside_only)
            rows.append(cache.row(name, home / name, args.inside_only, lambda: judge.row(name, home / name)))
        print(rows[-1], flush=True)
    rows.sort(key=lambda r: r['file'])
    body = '\n'.join([*share(rows, read_manifest(home)), *table(rows)]) + '\n'
    if args.output:
        text = args.output.read_text()
        begin, end = '<!-- table -->\n', '<!-- end -->'
        args.output.write_text(text.split(begin)[0] + begin + body + end + text.split(end)[1])
    print(body)


main()
