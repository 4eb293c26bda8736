"""Configurations that `machine export --linuxcnc` writes run on the real LinuxCNC as they stand, and there the joints of random
poses are those that `plan` finds.

    linuxcnc_machine_test.py TRUNNION

Exit status 77: LinuxCNC is not there, or is in use by others."""
import csv
import json
import os
import pathlib
import pwd
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

AXES = 'XYZABC'
LOCK = pathlib.Path('/tmp/linuxcnc.lock')
USER = 'lcnc'  # LinuxCNC's real-time host refuses to run as root
TOOL_MM = 63.5
AGREEMENT = 1e-9  # mm, deg

MACHINE = '''chain = "{chain}"
[axes.X]
range = ["-300 mm", "300 mm"]
max_velocity = "60 m/min"
max_acceleration = "20 m/s^2"
max_jerk = "2000 m/s^3"
[axes.Y]
range = ["-310 mm", "310 mm"]
max_velocity = "60 m/min"
max_acceleration = "20 m/s^2"
max_jerk = "2000 m/s^3"
[axes.Z]
range = ["-500 mm", "-1 mm"]
max_velocity = "60 m/min"
max_acceleration = "20 m/s^2"
max_jerk = "2000 m/s^3"
'''
ROTARY = '''[axes.{letter}]
range = {range}
max_velocity = "720 deg/s"
max_acceleration = "20000 deg/s^2"
max_jerk = "1000000 deg/s^3"
reversed = true
point = {point}
'''
KINDS = {'trivkins': ('X Y Z', ''),
         'ac': ('C A X Y Z', ROTARY.format(letter='A', range='["-80 deg", "80 deg"]', point='["1.5 mm", "21.25 mm", "-7.125 mm"]')),
         'bc': ('C B X Y Z', ROTARY.format(letter='B', range='["-80 deg", "80 deg"]', point='["-13.75 mm", "4 mm", "-9.5 mm"]'))}
TABLE = ROTARY.format(letter='C', range='"endless"', point='["3.25 mm", "-6.5 mm", "2.75 mm"]')


def display(folder):
    """Inside LinuxCNC, as its user interface: goes to every pose and notes the joints there."""
    import linuxcnc
    folder = pathlib.Path(folder)
    command, status, errors = linuxcnc.command(), linuxcnc.stat(), linuxcnc.error_channel()
    command.state(linuxcnc.STATE_ESTOP_RESET)
    command.wait_complete()
    command.state(linuxcnc.STATE_ON)
    command.wait_complete()
    command.home(-1)
    poses = json.loads((folder / 'poses.json').read_text())
    end = time.monotonic() + 20
    status.poll()
    while not all(status.homed[:status.joints]) and time.monotonic() < end:
        time.sleep(0.02)
        status.poll()
    command.mode(linuxcnc.MODE_MDI)
    command.wait_complete()
    joints = []
    for words in ['T1 M6', 'G43', *poses]:
        command.mdi(words)
        command.wait_complete(20)
        time.sleep(0.05)
        status.poll()
        joints.append([joint['output'] for joint in status.joint[:status.joints]])
    said = []
    while message := errors.poll():
        said.append(str(message))
    (folder / 'joints.json').write_text(json.dumps({'joints': joints[2:], 'errors': said}))


def poses_of(letters):
    """Random poses near the table, as words."""
    seed = random.randrange(1 << 30)
    print(f'{letters}: seed {seed}')
    chosen = random.Random(seed)
    span = {'X': 40, 'Y': 40, 'Z': 20, 'A': 45, 'B': 45, 'C': 300}
    return [' '.join(f'{letter}{chosen.uniform(-span[letter], span[letter]) - (220 if letter == "Z" else 0):.6f}' for letter in letters)
            for _ in range(8)]


def planned(trunnion, folder, letters, poses):
    """Axis positions at the poses, each the end of a way."""
    (folder / 'setup.toml').write_text(f'[tool]\nkind = "ball"\ndiameter = "6 mm"\nlength = "{TOOL_MM} mm"\n')
    ends = []
    for near, pose in zip(poses[1:] + poses[:1], poses):
        (folder / 'pose.ngc').write_text(f'G21 G90 G94\nG1 F60000 {near}\n{pose}\nM2\n')
        subprocess.run([trunnion, 'plan', folder / 'pose.ngc', '-m', folder / 'm.toml', '--setup', folder / 'setup.toml', '--rounding',
                        'none', '-q', '-o', folder / 'q.csv'], check=True, stdout=subprocess.DEVNULL)
        with open(folder / 'q.csv') as file:
            *_, end = csv.DictReader(file)
        ends.append([float(end[f'{letter}_{"mm" if letter in "XYZ" else "deg"}']) for letter in letters])
    return ends


def run_linuxcnc(folder, ini):
    environment = {'PATH': '/usr/bin:/bin', 'TERM': 'dumb', 'HOME': str(folder)}
    before = ['runuser', '-u', USER, '--'] if os.getuid() == 0 else []
    with open(folder / 'log.txt', 'w') as log:
        run = subprocess.Popen([*before, 'env', '-i', *(f'{k}={v}' for k, v in environment.items()), 'linuxcnc', ini], cwd=folder,
                               stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT, start_new_session=True)
        try:
            run.wait(120)
        except subprocess.TimeoutExpired:
            os.killpg(run.pid, signal.SIGTERM)
            run.wait(30)
    return (folder / 'log.txt').read_text()


def wait_for_others():
    end = time.monotonic() + 120
    while LOCK.exists():
        if time.monotonic() > end:
            print('skipped: another LinuxCNC runs')
            sys.exit(77)
        time.sleep(0.5)


def check(trunnion, kind, folder, *options):
    chain, tilt = KINDS[kind]
    letters = ''.join(sorted(chain.replace(' ', ''), key=AXES.index))
    (folder / 'm.toml').write_text(MACHINE.format(chain=chain) + tilt + (TABLE if tilt else ''))
    (folder / 'ui.sh').write_text(f'#!/bin/sh\nexec /usr/bin/python3 {folder}/display.py --display {folder}\n')
    shutil.copy(__file__, folder / 'display.py')
    os.chmod(folder / 'ui.sh', 0o755)
    subprocess.run([trunnion, 'machine', 'export', folder / 'm.toml', '--linuxcnc', '-o', folder, '--display', folder / 'ui.sh', *options],
                   check=True)
    (folder / 'm.tbl').write_text(f'T1 P1 Z{TOOL_MM} D6\n')
    poses = poses_of(letters)
    (folder / 'poses.json').write_text(json.dumps([f'G0 {words}' for words in poses]))
    os.chmod(folder, 0o755)
    if os.getuid() == 0:
        user = pwd.getpwnam(USER)
        for path in [folder, *folder.iterdir()]:
            os.chown(path, user.pw_uid, user.pw_gid)
    wait_for_others()
    log = run_linuxcnc(folder, folder / 'm.ini')
    if not (folder / 'joints.json').exists():
        sys.exit(f'{kind}: LinuxCNC did not come to its end:\n{log}')
    found = json.loads((folder / 'joints.json').read_text())
    off = max(abs(there - here) for pair in zip(found['joints'], planned(trunnion, folder, letters, poses)) for there, here in zip(*pair))
    print(f'{kind}: {len(poses)} poses, joints differ by at most {off:.2e}')
    if found['errors'] or len(found['joints']) != len(poses) or not off < AGREEMENT:
        sys.exit(f'{kind}: {found["errors"]}')


def main():
    if sys.argv[1] == '--display':
        return display(sys.argv[2])
    known = os.getuid() != 0 or USER in [user.pw_name for user in pwd.getpwall()]
    if not shutil.which('linuxcnc') or not known:
        print('skipped: LinuxCNC, or the user under which it runs, is not there')
        sys.exit(77)
    for kind, *options in (['trivkins'], ['ac'], ['bc', '--play']):
        with tempfile.TemporaryDirectory() as folder:
            check(sys.argv[1], kind, pathlib.Path(folder), *options)


main()
