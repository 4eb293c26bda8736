"""Deforms the examples as their READMEs say: deform_test.py TRUNNION EXAMPLES EXAMPLE_POLE MACHINES

A blade is milled to a third of its deviation at most and its splines are planned and checked; a pass beside the pole takes half the time;
nothing is left where the aim cannot be reached."""
import pathlib, re, subprocess, sys, tempfile

trunnion, examples, example_pole, machines = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3], pathlib.Path(sys.argv[4])


def run(*words, status=0):
    done = subprocess.run([str(w) for w in words], capture_output=True, text=True)
    if done.returncode != status:
        sys.exit(f'{" ".join(map(str, words))}\nended with {done.returncode}\n{done.stdout}{done.stderr}')
    return done.stdout + done.stderr


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    flank, written, setpoints = examples / '07_flank', folder / 'blade.mpf', folder / 'q.csv'
    machine = ['-m', 'ucp710', '--setup', flank / 'setup.toml']
    aim = ['--flank', flank / 'blade.csv', '--from-height', '2mm', '--to-height', '27mm']
    said = run(trunnion, 'deform', flank / 'blade.cls', *machine, *aim, '--to', 'sinumerik', '-o', written)
    before, after = map(float, re.search(r'peak deviation (\S+) mm before, (\S+) mm after', said).groups())
    if not after <= before / 3:
        sys.exit(said)
    if 'BSPLINE' not in written.read_text():
        sys.exit('no splines were written')
    run(trunnion, 'plan', written, *machine, '-o', setpoints, '--quiet')
    run(trunnion, 'check', setpoints, '--against', written, *machine, '--quiet')

    fails = folder / 'fails.ngc'
    blade = examples / '01_first_plan'
    said = run(trunnion, 'deform', blade / 'blade.ngc', '-m', 'xyzac-trt', '--setup', blade / 'setup.toml', '--avoid-pole', '-o', fails, status=2)
    if 'DEFO0204' not in said or fails.exists():
        sys.exit('a cone that cannot be left is refused with the feed that could, and leaves no file\n' + said)

    said = run(example_pole, machines / 'ucp710.toml', folder)
    planned = {row: float(time) for row, time in re.findall(r'^(\S+) .*planned (\S+) s', said, re.M)}
    travel = {row: float(turn) for row, turn in re.findall(r'^(\S+) +rotary travel +(\S+) deg', said, re.M)}
    for path, of_time, of_travel in (('through', 0.5, 0.12), ('blade', 1, 0.7), ('around', 1, 1)):
        if not (planned[f'{path}_after'] <= of_time * planned[f'{path}_before'] and travel[f'{path}_after'] <= of_travel * travel[f'{path}_before']):
            sys.exit(said)
