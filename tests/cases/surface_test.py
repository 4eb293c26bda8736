"""Goes the ways of the examples of surfaces: surface_test.py TRUNNION EXAMPLES

Surface → program → plan → check on a shipped machine, as straight moves, splines and rotary words; what the simulation says; what fails says so
with its exit status."""
import json, math, pathlib, subprocess, sys, tempfile

trunnion, examples = sys.argv[1], pathlib.Path(sys.argv[2])


def run(*words, status=0, code=None):
    done = subprocess.run([trunnion, *map(str, words)], capture_output=True, text=True)
    if done.returncode != status or (code and f'error {code}:' not in done.stderr):
        sys.exit(f'{" ".join(map(str, words))}\nended with {done.returncode}\n{done.stdout}{done.stderr}')
    return done.stdout + done.stderr


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    summary = folder / 's.json'

    def surface_plan(example, surface, out, *options, status=0):
        said = run('surface', 'plan', examples / example / surface, '--setup', examples / example / 'setup.toml', '-o', out,
                   '--summary', summary, *options, status=status)
        return json.loads(summary.read_text()), said

    def plan_and_check(program, example, machine):
        place = ['-m', machine, '--setup', examples / example / 'setup.toml', '--quiet']
        run('plan', program, *place, '-o', folder / 'q.csv')
        run('check', folder / 'q.csv', '--against', program, *place)

    # Coarse, so that it is quick; the README has 10 um.
    coarse = ['--scallop', '200um', '--chord-tolerance', '10um', '--gouge-tolerance', '25um', '--check']
    found, said = surface_plan('09_surface', 'hills.toml', folder / 'hills.mpf', *coarse)
    check = found['check']
    if not (found['usable'] and 'verdict' in said and check['largest_ridge_mm'] <= 0.201 and check['median_ridge_mm'] > 0.17):
        sys.exit(said)
    passes = found['passes']
    plan_and_check(folder / 'hills.mpf', '09_surface', 'ucp710')
    found, said = surface_plan('09_surface', 'hills.toml', folder / 'rows.mpf', *coarse, '--strategy', 'along-u')
    if not (found['usable'] and found['passes'] > passes):
        sys.exit(f'{passes} passes\n{said}')

    ball = ['--tool', '8', '--lead', '15deg', *coarse]
    found, said = surface_plan('11_hollow', 'bowl.toml', folder / 'bowl.mpf', *ball, '--curves', 'splines', '--spindle', '6000rpm')
    text = (folder / 'bowl.mpf').read_text()
    if not (found['usable'] and found['splines']['tip_error_mm'] <= 0.0025 and all(w in text for w in ('BSPLINE', 'T8', 'S6000'))):
        sys.exit(said + text[:1000])
    plan_and_check(folder / 'bowl.mpf', '11_hollow', 'trunnion-bc')
    found, said = surface_plan('11_hollow', 'bowl.toml', folder / 'bowl.ngc', *ball, '-m', 'trunnion-bc')
    if 'B' not in (folder / 'bowl.ngc').read_text():
        sys.exit('no rotary words')
    plan_and_check(folder / 'bowl.ngc', '11_hollow', 'trunnion-bc')

    # A bar that is broken: the program is written, the status says so.
    found, said = surface_plan('09_surface', 'hills.toml', folder / 'deep.mpf', '--scallop', '200um', '--chord-tolerance', '10um',
                               '--check', status=1)
    if found['usable'] or 'NOT USABLE' not in said or not (folder / 'deep.mpf').exists():
        sys.exit(said)
    # A wall that the tool leans into is told without being asked for; freed, the tool stays out of it and cuts what it cut.
    wall = ['--face', '1', '--strategy', 'along-u', '--lead', '15deg', '--scallop', '100um', '--reach', '40mm']
    found, said = surface_plan('12_pocket_wall', 'pocket.toml', folder / 'gouging.mpf', *wall, status=1)
    before = found['part']['in_part']
    if found['usable'] or found['check'] or 'NOT USABLE: the tool goes into the part' not in said or not (
            before['face'] == 3 and 4 < before['depth_mm'] < 6):
        sys.exit(said)
    found, said = surface_plan('12_pocket_wall', 'pocket.toml', folder / 'pocket.mpf', *wall, '--free-gouges')
    freed = found['freed']
    if not (found['usable'] and found['check']['largest_ridge_mm'] <= 0.1005 and found['part']['in_part'] is None
            and freed['gouges']['global'] > 0 and freed['worst']['face'] == 3 and freed['worst']['depth_mm'] > 4
            and 5 < freed['largest_turn_deg'] < 15 and freed['passes_turned'] < found['passes'] / 2):
        sys.exit(said)
    plan_and_check(folder / 'pocket.mpf', '12_pocket_wall', 'trunnion-bc')
    # The same asked for by the program that defines the faces; without its P1 the shank goes as deep as before.
    place = ['-m', 'trunnion-bc', '--setup', examples / '12_pocket_wall/setup.toml']
    program = (examples / '12_pocket_wall/pocket.ngc').read_text().replace('R0.05', 'R0.1')
    into_wall = {}
    for name, text in ('freed', program), ('plain', program.replace('P1 J40', '')):
        (folder / f'{name}.ngc').write_text(text)
        said = run('plan', folder / f'{name}.ngc', *place, '-o', folder / 'q.csv')
        if ('PIPE0124' in said) != (name == 'freed') or 'PIPE0123' in said:
            sys.exit(said)
        run('check', folder / 'q.csv', '--against', folder / f'{name}.ngc', *place, '--quiet')
        run('convert', folder / f'{name}.ngc', *place, '--to', 'apt', '-o', folder / f'{name}.cls', '--quiet')
        nearest = 100  # of the axis to the wall, 30 mm up the tool
        for line in (folder / f'{name}.cls').read_text().splitlines():
            if line.startswith('GOTO/'):
                words = [float(word) for word in line[5:].split(',')]
                axis = words[3:] or axis
                x, y, z = (words[i] + 30 * axis[i] for i in range(3))
                if z < 40:
                    nearest = min(nearest, math.hypot(x, max(0, y - 40, -y)))
        into_wall[name] = 5 - nearest
    if not (into_wall['freed'] < 0.05 and into_wall['plain'] > 3):
        sys.exit(f'the shank goes into the wall by {into_wall} mm')
    # The wall as a part of its own; what is machined counts anyway.
    found, said = surface_plan('12_pocket_wall', 'pocket.toml', folder / 'alone.mpf', *wall, '--part', f'{examples}/12_pocket_wall/pocket.toml:2')
    if not found['usable'] or found['part']['faces'] != 2:
        sys.exit(said)
    # A part of another file: that one of its shells is open is told. One of too many triangles is not looked at: told, or, asked for, refused.
    flat = '[[surface]]\ncoefficients_mm = [[[0, 0, 0], [0, 40, 0]], [[40, 0, 0], [0, 0, 0]]]\n'
    (folder / 'flat.toml').write_text(flat)
    rows = ['--face', '1', '--tool', 'ball 8mm', '--reach', '10mm', '--scallop', '400um', '--strategy', 'along-v', '-o', folder / 'rows.mpf']
    said = run('surface', 'plan', folder / 'flat.toml', *rows, '--part', examples.parent / 'tests/unit/surfacing/faces/open_shell.step',
               status=1)
    if 'SURF0108' not in said:
        sys.exit(said)
    (folder / 'vast.toml').write_text(flat + '[[surface]]\ncoefficients_mm = [[[-2e5, -2e5, -9e5], [0, 4e5, 0], [0, 0, 4e5]], [[4e5, 0, 0], '
                                             '[0, 0, 0], [0, 0, 0]], [[0, 0, 4e5], [0, 0, 0], [0, 0, 0]]]\n')
    said = run('surface', 'plan', folder / 'vast.toml', *rows)
    if 'PIPE0118' not in said or 'SURF0302' in said:
        sys.exit(said)
    run('surface', 'plan', folder / 'vast.toml', *rows, '--part', 'file', status=2, code='SURF0302')
    # Ridges above the scallop that Lin and Koren's rule would leave, by every command that lays its passes.
    (folder / 'triangle.toml').write_text('[[surface]]\ncontrol_points_mm = [[[0, 0, 0], [0, 0, 0]], [[11, -5.5, 0], [11, 5.5, 0]]]\n')
    (folder / 'triangle.ngc').write_text('G21 G90 T1 M6\nG0 X20 Y0 Z90 B0 C0\nG320 P1 I1 J1 K2 L2\nX0 Y0 Z0\nX0 Y0 Z0\nX11 Y-5.5 Z0\n'
                                         'X11 Y5.5 Z0\nG322\nG323 D.001\nG324 P1 R0.05 Q5 J10 F600\nM30\n')
    (folder / 'torus.toml').write_text('[workpiece]\norigin = ["0 mm", "0 mm", "60 mm"]\n[tools.1]\nkind = "torus"\ndiameter = "5 mm"\n'
                                       'corner_radius = "1 mm"\nlength = "90 mm"\n')
    on_machine = ['-m', 'trunnion-bc', '--setup', folder / 'torus.toml']
    triangle = [folder / 'triangle.toml', '--tool', '1', '--lead', '10deg', '--scallop', '50um']
    for words in (['surface', 'plan', *triangle, '--strategy', 'lin-koren', '-o', folder / 'rows.mpf', *on_machine],
                  ['surface', 'run', *triangle, '--strategy', 'lin-koren', '-o', folder / 'q.csv', *on_machine],
                  ['plan', folder / 'triangle.ngc', '-o', folder / 'q.csv', *on_machine]):
        said = run(*words)
        if said.count('warning SURF0212') != 1:
            sys.exit(f'{words}\n{said}')
    if 'SURF0212' in run('surface', 'plan', *triangle, '--strategy', 'along-u', '-o', folder / 'rows.mpf', *on_machine):
        sys.exit('the other strategies correct their ridges')
    # Loose faces that close a body, one of which looks into it: told by every command that reads them.
    box = examples.parent / 'tests/unit/surfacing/faces/loose_box.iges'
    over_box = ['--tool', 'ball 4mm', '--scallop', '200um', '--face', '1', '-o', folder / 'box.mpf']
    for words in ['list', box], ['plan', box, *over_box], ['plan', folder / 'flat.toml', *rows, '--part', box]:
        said = subprocess.run([trunnion, 'surface', *map(str, words)], capture_output=True, text=True).stderr
        if said.count('warning SURF0110') != 1:
            sys.exit(f'{words}\n{said}')
    # A fence between two floors: what is moved at once goes over it as what is planned does.
    (folder / 'fence.toml').write_text(''.join(
        f'[[surface]]\ncontrol_points_mm = [[[{x}, {y}, 0], [{x}, {y + b}, 0]], [[{x + a}, {y}, {c}], [{x + a}, {y + b}, {c}]]]\n'
        for x, y, a, b, c in ((0, 0, 20, 20, 0), (40, 0, 20, 20, 0), (30, -10, 0, 40, 30))))
    fence = [folder / 'fence.toml', '--tool', 'ball 10mm', '--scallop', '200um', '--retract', '5mm']
    for machined in '1,2', '1':
        run('surface', 'run', *fence, '-m', 'trunnion-bc', '--face', machined, *(['--ahead', '--strategy', 'lin-koren']
            if machined == '1' else []), '-o', folder / 'q.csv', '--summary', summary, '--quiet')
        if json.loads(summary.read_text())['surface']['part'] != {'faces': 3, 'in_part': None}:
            sys.exit(summary.read_text())
    # Fronts that fold over in hollows have corners; their curves stay within the face (INTP0002).
    run('surface', 'run', examples / '09_surface' / 'hills.toml', '--ahead', '--strategy', 'lin-koren', '--scallop', '200um', '--tool', 'ball 6mm',
        '-m', 'trunnion-bc', '--period', '10ms', '-o', folder / 'q.csv', '--quiet')
    # Under a lid: less than half of the face left out is usable, more is not.
    for wide, status in (6, 0), (30, 1):
        (folder / 'lid.toml').write_text(flat + '[[surface]]\nside = "against"\ncoefficients_mm = [[[-10, -10, 6], [0, 60, 0]], '
                                                f'[[{wide}, 0, 0], [0, 0, 0]]]\n')
        said = run('surface', 'plan', folder / 'lid.toml', *rows, '--part', 'file', '--leave-out', '--summary', summary, status=status)
        found = json.loads(summary.read_text())
        if found['usable'] != (status == 0) or ('more than half of the area is left out' in said) != (status == 1):
            sys.exit(said)
    said = run('surface', 'list', examples / '11_hollow/bowl.toml')
    if 'whole' not in said:
        sys.exit(said)
