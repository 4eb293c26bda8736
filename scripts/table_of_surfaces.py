"""Plans and simulates faces of all STEP and IGES files of a folder and writes what came of it as Markdown.

    nice -n 10 /usr/bin/python3 scripts/table_of_surfaces.py TRUNNION FOLDER > docs/surfaces-planned.md

Of each file the first FACES faces that are curved, or else the first ones. The tool is the largest ball of SERIES with
which a strategy of STRATEGIES, tried in that order, gives a plan that holds what was asked and cuts nothing else of the
file; the scallop the least of SCALLOPS with which the passes stay below LONGEST_CUT_M. No call may take more than SECONDS
of processor time, no face more than SECONDS_A_FACE.
"""
import json
import math
import pathlib
import re
import resource
import subprocess
import sys
import tempfile

FACES = 2
SERIES = [500, 200, 100, 50, 20, 16, 12, 10, 8, 6, 5, 4, 3, 2, 1]
STRATEGIES = ['constant-scallop', 'along-u', 'along-v', 'parallel-planes']
SCALLOPS = [0.01, 0.03, 0.1, 0.3, 1, 3]
LONGEST_CUT_M = 40
SECONDS, SECONDS_A_FACE = 15, 30

trunnion, folder = sys.argv[1], pathlib.Path(sys.argv[2])


def run(*words):
    limit = lambda: resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS + 1))
    return subprocess.run([trunnion, 'surface', *words], capture_output=True, text=True, preexec_fn=limit)


def code_of(done):
    found = re.search(r'error ([A-Z]+\d{4})', done.stderr)
    return found[1] if found else f'stopped after {SECONDS} s'


def radius(text):
    return math.inf if text == 'none' else float(text)


def faces_of(listed):
    """Number, area in mm² and least radius of a hollow, of the faces that are looked at."""
    rows = [line.split() for line in listed.splitlines() if re.match(r'\s*\d+\s+[\d.]', line) and len(line.split()) > 7]
    faces = [(int(r[0]), float(r[3]), radius(r[4]), radius(r[5])) for r in rows]
    curved = [f for f in faces if f[2] < math.inf or f[3] < math.inf]
    return len(faces), (curved or faces)[:FACES]


def scallop_for(area, ball):
    for scallop in SCALLOPS:
        if area / math.sqrt(8 * scallop * ball / 2) < 1000 * LONGEST_CUT_M and scallop < ball / 4:
            return scallop
    return None


def attempts(area, hollow):
    """Ball, scallop and strategy, the coarsest first. A face is at least some balls wide."""
    for ball in SERIES:
        scallop = scallop_for(area, ball)
        if ball / 2 < hollow and 4 * ball < math.sqrt(area) and scallop:
            for strategy in STRATEGIES:
                yield ball, scallop, strategy


def row(ball, scallop, strategy, of, seconds):
    check = of['check']
    into = check.get('in_part')
    told = f'goes {into["depth_mm"]:.3g} mm into face {into["face"]} of the file' if into else ''
    if not into and not of['usable']:
        told = 'does not hold what was asked'
    ridges = f'{1e3 * check["least_ridge_mm"]:.2f}-{1e3 * check["largest_ridge_mm"]:.2f}' if check['ridges'] else 'none away from borders'
    return (f'{ball} mm | {1e3 * scallop:g} | {strategy} | {of["passes"]} | {ridges} | {1e3 * check["highest_mm"]:.2f} | '
            f'{1e3 * check["deepest_mm"]:.2f} | {seconds:.1f} | {told}')


def planned(file, number, area, hollow, work):
    """The row of one face: of the first plan that is usable, else of the last one, or what refused it."""
    summary, last, refused = work / 'summary.json', None, {}
    spent = lambda: sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])
    begun = spent()
    for ball, scallop, strategy in attempts(area, hollow):
        if spent() - begun > SECONDS_A_FACE:
            refused[f'stopped after {SECONDS_A_FACE} s'] = ball
            break
        before = spent()
        summary.unlink(missing_ok=True)
        done = run('plan', str(file), '--face', str(number), '--tool', f'ball {ball}mm', '--scallop', f'{scallop}mm', '--strategy', strategy,
                   '--check', '--summary', str(summary), '-o', str(work / 'program.apt'), '-q')
        if not summary.exists():
            refused[code_of(done)] = ball
            continue
        of = json.loads(summary.read_text())
        last = row(ball, scallop, strategy, of, spent() - before)
        if of['usable']:
            return last
    if last:
        return last
    told = '; '.join(f'{code} (last with {ball} mm)' for code, ball in refused.items())
    return f' | | | | | | | | {told or f"too large, too small or too hollow for the balls of this table (hollow of {hollow:.3g} mm)"}'


def main():
    print(__doc__.split('\n', 1)[0].replace('Plans and simulates', '# Surfaces planned\nWritten by `scripts/table_of_surfaces.py`: it plans and simulates'))
    print(f'\nOf each file the first {FACES} curved faces (flat ones where none is curved). Ball: the largest of {", ".join(map(str, SERIES))} mm with which\n'
          f'a strategy ({", ".join(STRATEGIES)}, in this order) gives a plan that holds what was asked and cuts nothing else of the file.\n'
          f'Scallop: the least of {", ".join(f"{1e3 * s:g}" for s in SCALLOPS)} µm with which the passes stay below about {LONGEST_CUT_M} m; ridges, highest and deepest in µm;\n'
          f'seconds of processor time: reading, planning, simulation and the check against the whole part. Up to {SECONDS} s a plan, {SECONDS_A_FACE} s a face.\n')
    print('| file | faces | face | ball | scallop | strategy | passes | ridges | highest | deepest | seconds | told |\n|---|---|---|---|---|---|---|---|---|---|---|---|')
    with tempfile.TemporaryDirectory() as name:
        for file in sorted(folder.iterdir()):
            if file.suffix not in ('.step', '.stp', '.iges', '.igs', '.3dm'):
                continue
            listed = run('list', str(file), '-q')
            if listed.returncode:
                print(f'| {file.name} | | | | | | | | | | | {code_of(listed)} |', flush=True)
                continue
            count, chosen = faces_of(listed.stdout)
            for number, area, hollow, _ in chosen:
                print(f'| {file.name} | {count} | {number} | {planned(file, number, area, hollow, pathlib.Path(name))} |', flush=True)


main()
