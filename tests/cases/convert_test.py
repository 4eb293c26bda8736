"""Converts and smooths an example as its README says: convert_test.py TRUNNION EXAMPLE_FOLDER

Every dialect that is read again must give the same poses, the smooth program must keep the tolerance of the first one with fewer moves and
take no longer on LinuxCNC, no file is left half written, and the program is never written over."""
import json, pathlib, shutil, subprocess, sys, tempfile

trunnion, example = sys.argv[1], pathlib.Path(sys.argv[2])
machine = ['-m', 'xyzac-trt', '--setup', example / 'setup.toml', '--quiet']


def run(*words, status=0, code=None):
    done = subprocess.run([trunnion, *map(str, words)], capture_output=True, text=True)
    if done.returncode != status or (code and f'error {code}:' not in done.stderr):
        sys.exit(f'{" ".join(map(str, words))}\nended with {done.returncode}\n{done.stdout}{done.stderr}')
    return done.stdout


def poses(path):
    """Of CL data, the vector kept where a GOTO does not say it."""
    out, vector = [], []
    for line in path.read_text().splitlines():
        if line.startswith('GOTO/'):
            numbers = [float(n) for n in line[5:].split(',')]
            vector = numbers[3:] or vector
            out.append(numbers[:3] + vector)
    return out


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    rim = folder / 'rim.cls'
    shutil.copy(example / 'rim.cls', rim)
    first = poses(rim)

    # There and back. Chords of rotary words are not the poses of the program, but they pass through them.
    for dialect in ('sinumerik', 'rs274'):
        there, back = folder / f'there.{dialect}', folder / f'{dialect}.cls'
        run('convert', rim, '--to', dialect, '-o', there, *machine)
        run('convert', there, '--to', 'apt', '-o', back, *machine)
        found = poses(back)
        for pose in first:
            if not any(max(abs(a - b) for a, b in zip(pose, other)) < 2e-6 for other in found):
                sys.exit(f'{dialect}: the pose {pose} is lost')
        if dialect == 'sinumerik' and len(found) != len(first):
            sys.exit(f'{len(first)} poses became {len(found)}')

    smooth, setpoints, summary = folder / 'smooth.ngc', folder / 'q.csv', folder / 's.json'
    run('smooth', rim, '--to', 'rs274', '-o', smooth, *machine)
    lines = sum(line.lstrip('G01 ').startswith(('X', 'Y', 'Z', 'A', 'C')) for line in smooth.read_text().splitlines())
    if lines >= len(first):
        sys.exit(f'{len(first)} poses became {lines} blocks')
    run('plan', smooth, '-o', setpoints, '--tip-tolerance', '5um', '--orientation-tolerance', '0.025deg', *machine)
    run('check', setpoints, '--against', rim, *machine)
    run('predict', smooth, '-c', 'linuxcnc-2.9', '--before', folder / 'there.rs274', '--summary', summary, *machine)
    text = json.loads(summary.read_text())
    run('predict', folder / 'there.rs274', '-c', 'linuxcnc-2.9', '--summary', folder / 'b.json', *machine)
    if text['cycle_time_s'] > json.loads((folder / 'b.json').read_text())['cycle_time_s']:
        sys.exit('the smooth program takes longer')

    splines = folder / 'smooth.mpf'
    run('smooth', rim, '--to', 'sinumerik', '-o', splines, *machine)
    if 'BSPLINE SD=3' not in splines.read_text():
        sys.exit('no splines')

    # Nothing is written over or left behind.
    here = sorted(path.name for path in folder.iterdir())
    run('convert', rim, '--to', 'apt', '-o', rim, '--quiet', status=2, code='PIPE0011')
    run('convert', rim, '--to', 'rs274', '-o', folder / 'none.ngc', '--quiet', status=2, code='NC0902')
    run('smooth', rim, '-o', folder / 'none.cls', '--tip-tolerance', '0mm', *machine, status=2, code='PIPE0016')
    if sorted(path.name for path in folder.iterdir()) != here or poses(rim) != first:
        sys.exit('a refused conversion left something behind')
