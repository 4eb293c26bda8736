"""Plans and checks the program with surfaces, and the same written as plain moves: surface_program_test.py TRUNNION EXAMPLE"""
import csv, json, pathlib, re, subprocess, sys, tempfile

trunnion, example = sys.argv[1], pathlib.Path(sys.argv[2])


def run(*words):
    done = subprocess.run([str(w) for w in words], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f'{" ".join(map(str, words))}\nended with {done.returncode}\n{done.stdout}{done.stderr}')
    return done.stdout + done.stderr


def plan_and_check(program, machine, folder):
    run(trunnion, 'plan', program, *machine, '-o', folder / 'q.csv', '--summary', folder / 's.json', '--events', folder / 'e.csv', '--quiet')
    run(trunnion, 'check', folder / 'q.csv', '--against', program, *machine, '--quiet')
    return json.loads((folder / 's.json').read_text())


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    machine = ['-m', 'ucp710', '--setup', example / 'setup.toml']
    tolerance = ['--tip-tolerance', '2um']
    program, written = example / 'hillside.ngc', folder / 'hillside.mpf'
    planned = plan_and_check(program, machine + tolerance, folder)
    if not planned['path_length_mm'] > 3000:
        sys.exit(f'the passes are missing: {planned["path_length_mm"]} mm')
    lines = (folder / 'q.csv').read_text().splitlines()[1:]
    machining = {number for number, text in enumerate(program.read_text().splitlines(), 1) if text.startswith('G324')}
    if not machining <= {int(line.split(',')[6]) for line in lines}:
        sys.exit('setpoints of passes do not point at their machining blocks')
    with open(folder / 'e.csv', newline='') as table:
        events = [row['word'] for row in csv.DictReader(table)]
    if events.index('T2') < events.index('T1') or any('G324' in word for word in events):
        sys.exit(f'events: {events}')

    said = run(trunnion, 'convert', program, *machine, '--to', 'sinumerik', '-o', written)
    if said.count('PIPE0121') != 1 or re.search(r'G32\d', written.read_text()):
        sys.exit('passes are told once and written as plain moves\n' + said)
    again = plan_and_check(written, machine + tolerance, folder)
    if abs(again['cycle_time_s'] / planned['cycle_time_s'] - 1) > 0.02:
        sys.exit(f'planned {planned["cycle_time_s"]} s, written and read again {again["cycle_time_s"]} s')
