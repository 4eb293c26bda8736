"""Plans and simulates faces of all STEP and IGES files of a folder and writes what came of it as Markdown.

    nice -n 10 /usr/bin/python3 scripts/table_of_surfaces.py TRUNNION FOLDER [FILE…] > docs/surfaces-planned.md

Of each file, or of those that are named, the FACES largest faces that are curved, or else the largest ones; of faces of equal area and radii, as blades
are, the first. Balls are shares of the face's width, the root of its area; the scallop is such that some PASSES passes are as wide as the face, a
fortieth of the ball at the most; a plan may gouge by a tenth of the scallop; all that is asked stands in the row. What the tool cannot reach is left out. Each ball is
tried upright and leaning, in the order of WAYS, until a plan is usable. No call may take more than SECONDS of processor time, no face more than
SECONDS_A_FACE.
"""
import json
import math
import multiprocessing
import pathlib
import re
import resource
import subprocess
import sys
import tempfile

FACES = 2
STEPS = [1, 2, 5]
WIDTHS_PER_BALL = [8, 16, 32]
WAYS = [['along-u'], ['along-v'], ['along-u', '--tilt=60deg'], ['along-u', '--tilt=-60deg'], ['along-v', '--tilt=60deg'],
        ['along-v', '--tilt=-60deg']]
PASSES = 60
MOST_LEFT = 0.5
SECONDS, SECONDS_A_FACE = 60, 120

BEHIND = """
"goes … into face … of the file": the look at every move finds the tool in the part; such a plan is written, counts as not usable, and the command ends with
status 1. One face of a part is planned against all of its faces: blades beside each other, and shoulders, are what the tool meets. "… % left": the tool
does not reach more of the face. Faces of closed bodies have material behind them, all others are sheets as thin as paper (docs/theory/guiding-surfaces.md, 3).
Codes are those of docs/diagnostics.md; behind each the ball with which it came last."""

trunnion, folder, only = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3:]


def run(*words):
    limit = lambda: resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS + 1))
    return subprocess.run([trunnion, 'surface', *words], capture_output=True, text=True, preexec_fn=limit)


def code_of(done):
    found = re.search(r'error ([A-Z]+\d{4})', done.stderr)
    return found[1] if found else f'stopped after {SECONDS} s'


def radius(text):
    return math.inf if text == 'none' else float(text)


def faces_of(listed):
    """Number, area in mm² and least radii of a hollow and of a hump, of the faces that are looked at."""
    rows = [line.split() for line in listed.splitlines() if re.match(r'\s*\d+\s+[\d.]', line) and len(line.split()) > 7]
    faces = [(int(r[0]), float(r[3]), radius(r[4]), radius(r[5])) for r in rows]
    curved = [f for f in faces if f[2] < math.inf or f[3] < math.inf]
    alike = {}
    for face in curved or faces:
        alike.setdefault(tuple(f'{x:.2g}' for x in face[1:]), face)
    return len(faces), sorted(alike.values(), key=lambda face: -face[1])[:FACES]


def rounded(value, up):
    """To one of STEPS times a power of ten."""
    series = [step * 10.0 ** power for power in range(-5, 6) for step in STEPS]
    return min(x for x in series if x >= value) if up else max(x for x in series if x <= value)


def length(mm):
    return f'{1e3 * mm:g}um' if mm < 0.1 else f'{mm:g}mm'


def asked(area):
    """Options, the largest ball first; nothing for faces that all balls are too large for."""
    width = math.sqrt(area)
    for widths in WIDTHS_PER_BALL:
        ball = rounded(width / widths, False)
        scallop = min(rounded((width / PASSES) ** 2 / (4 * ball), True), rounded(ball / 40, False))
        large = [] if ball <= 20 else ['--retract', length(2 * ball), '--longest-step', length(ball / 5)]
        for way in WAYS:
            yield ['--tool', f'ball {length(ball)}', '--scallop', length(scallop), '--gouge-tolerance', length(scallop / 10),
                   *large, '--leave-out', '--strategy', *way]


def row(words, of, seconds):
    check = of['check']
    into = check.get('in_part')
    told = f'goes {into["depth_mm"]:.3g} mm into face {into["face"]} of the file' if into else ''
    if not into and not of['usable']:
        told = 'does not hold what was asked'
    ridges = f'{1e3 * check["least_ridge_mm"]:.2f}-{1e3 * check["largest_ridge_mm"]:.2f}' if check['ridges'] else 'none away from borders'
    left = f'{100 * check["left_share"]:.1f} %' if of['left'] else ''
    return (f'`{" ".join(words)}` | {of["passes"]} | {ridges} | {1e3 * check["highest_mm"]:.2f} | '
            f'{1e3 * check["deepest_mm"]:.2f} | {left} | {seconds:.1f} | {told}')


def planned(file, number, area, work):
    """The row of one face: of the first plan that is usable, else of the last one, or what refused it."""
    summary, last, refused = work / 'summary.json', None, {}
    spent = lambda: sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])
    begun = spent()
    for words in asked(area):
        if spent() - begun > SECONDS_A_FACE:
            refused[f'stopped after {SECONDS_A_FACE} s'] = words[1]
            break
        before = spent()
        summary.unlink(missing_ok=True)
        done = run('plan', str(file), '--face', str(number), *words, '--check', '--summary', str(summary), '-o',
                   str(work / 'program.apt'), '-q')
        if not summary.exists():
            refused[code_of(done)] = words[1]
            continue
        of = json.loads(summary.read_text())
        if of['left'] and of['check']['left_share'] > MOST_LEFT:
            refused[f'{100 * of["check"]["left_share"]:.0f} % left'] = words[1]
            continue
        last = row(words, of, spent() - before)
        if of['usable']:
            return last
    told = '; '.join(f'{code} (last with {ball})' for code, ball in refused.items())
    return last or f' | | | | | | | {told}'


def wanted():
    """File, its number of faces, and a face; or, of a file that is not read, the code."""
    for file in sorted(folder.iterdir()):
        if only and file.name not in only or file.suffix not in ('.step', '.stp', '.iges', '.igs', '.3dm'):
            continue
        listed = run('list', str(file), '-q')
        if listed.returncode:
            yield file, 0, code_of(listed)
            continue
        count, chosen = faces_of(listed.stdout)
        for face in chosen:
            yield file, count, face


def line_of(task):
    file, count, face = task
    if not count:
        return f'| {file.name} | | | | | | | | | | {face} |'
    with tempfile.TemporaryDirectory() as name:
        return f'| {file.name} | {count} | {face[0]} | {planned(file, face[0], face[1], pathlib.Path(name))} |'


def main():
    print(__doc__.split('\n', 1)[0].replace('Plans and simulates', '# Surfaces planned\nWritten by `scripts/table_of_surfaces.py`: it plans and simulates'))
    print(f'\nOf each file the {FACES} largest curved faces that are not alike (flat ones where none is curved). Balls of 1/{", 1/".join(map(str, WIDTHS_PER_BALL))} of the face\'s width,\n'
          f'rounded down; a scallop with which some {PASSES} passes are as wide as the face, a fortieth of the ball at the most; gouges up to a tenth of the scallop; the tool\n'
          f'upright, or leaning by 60° across the feed; the first plan that is usable. Ridges, highest and deepest in µm; left: share of the area that is left out,\n'
          f'at most {100 * MOST_LEFT:g} %; seconds of processor time: reading, planning, simulation and the check against the whole part. Up to {SECONDS} s a plan, {SECONDS_A_FACE} s a face.\n')
    print('| file | faces | face | asked | passes | ridges | highest | deepest | left | seconds | told |\n|---|---|---|---|---|---|---|---|---|---|---|')
    with multiprocessing.Pool(2) as pool:
        for line in pool.imap(line_of, wanted()):
            print(line, flush=True)
    print(BEHIND)


main()
