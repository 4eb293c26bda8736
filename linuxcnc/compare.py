#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-only
"""Runs programs on LinuxCNC 2.9, by its own planner and by Trunnion's (tpmod), with the same limits, and writes one table.

    linuxcnc/compare.py [--trunnion build/release/apps/trunnion/trunnion] [--shared ../shared] [--only NAME…] [-o FILE.md]

As root, on a machine with Debian's linuxcnc-uspace and linuxcnc-uspace-dev; LinuxCNC itself runs as the user lcnc, with simulated
drives and the package's clocks. The joints' commands of every servo period are recorded; times run from the first to the last
movement that a joint makes in the cut (rapids to its begin not counted); deviations, velocity, acceleration and jerk are what `trunnion check` finds in the record. Exit
status 77: LinuxCNC is not to be had here."""
import argparse
import json
import math
import os
import pathlib
import pwd
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import numpy

HERE = pathlib.Path(__file__).resolve().parent
LOCK = pathlib.Path(tempfile.gettempdir()) / 'linuxcnc.lock'
USER = 'lcnc'
JOINTS = 'XYZAC'
SETUP = '[workpiece]\norigin = ["0 mm", "0 mm", "0 mm"]\n[tool]\nkind = "flat"\ndiameter = "10 mm"\nlength = "0 mm"\n'
HASTY = 'Trunnion, jerk x 100'
PLANNERS = ['LinuxCNC', 'Trunnion', HASTY]
JERK_BOUND = {'corner', 'fillet', 'one block at R 250', 'sine-10k, 3-axis', 'impeller, F x 20'}  # where jerk decides
WARP = 8  # how much faster LinuxCNC runs where it plans itself
LAG = 3  # periods from LinuxCNC's position to the joints' commands
TOLERANCE = ['--tip-tolerance', '10um']


# --- the programs

def blocks(text):
    return [line for line in text.splitlines() if re.match(r'\s*G1\b.*[XYZAC]', line)]


def thinned(text, keep):
    """Every so many-th block of a run of G1, the last one too."""
    cut = blocks(text)
    stays = set(cut[keep - 1::keep] + cut[-1:])
    feed = re.search(r'F[\d.]+', text)[0]
    lines = [line for line in text.splitlines() if line in stays or line not in cut]
    lines = [re.sub(r'F[\d.]+', '', line) for line in lines]
    first = next(k for k, line in enumerate(lines) if line in {re.sub(r'F[\d.]+', '', s) for s in stays})
    lines[first] += ' ' + feed
    return '\n'.join(lines) + '\n'


def position(line, letters='XYZ'):
    return [float(re.search(rf'{c}(-?[\d.]+)', line)[1]) for c in letters]


def inverse_time(text):
    """The same blocks, each with the time that its tip takes at the programmed feed."""
    feed = float(re.search(r'F([\d.]+)', text)[1])
    out, at = [], None
    for line in text.splitlines():
        if 'G1' in line and 'X' in line:
            to = position(line)
            way = math.dist(at, to) if at else 0
            out.append('G93 ' + re.sub(r'\s*F[\d.]+', '', line) + f' F{feed / max(way, 1e-3):.5f}')
        else:
            out.append(line)
        at = position(line) if 'X' in line else at
    return '\n'.join(out) + '\n'


def without_rotary(text):
    return re.sub(r'[AC]-?[\d.]+[ ]*', '', text)


def with_feed(text, feed):
    return re.sub(r'F[\d.]+', f'F{feed}', text)


def programs(shared):
    """(name, text, whether LinuxCNC's own planner is wanted too)."""
    cases = shared / 'data' / 'cases'
    read = lambda name: (cases / f'{name}.ngc').read_text().replace('G54\n', 'G54 G64 P0.01\n', 1)
    sine = read('sine-10k')
    long_block = 'G21 G90 G94 G64 P0.01\nG0 X250 Y0 Z0 A0 C0\nG1 X-250 A90 C120 F10000\nM2\n'
    out = [(name, read(name)) for name in ('corner', 'fillet', 'gentle-0.2', 'gentle-0.5', 'gentle-1')]
    out += [('sine-10k', sine), ('sine-10k F3000', with_feed(sine, 3000)), ('sine-10k F30000', with_feed(sine, 30000)),
            ('sine-10k, 1 mm blocks', thinned(sine, 5)), ('sine-10k, G93', inverse_time(sine)),
            ('sine-10k, 3-axis', without_rotary(sine)), ('one block at R 250', long_block)]
    impeller = shared / 'data' / 'nc' / 'linuxcnc' / 'impeller-7bl-xyzac.ngc'
    if impeller.exists():
        out.append(('impeller, F x 20', 'G64 P0.01\n' + re.sub(r'F *([\d.]+)', lambda f: f'F{20 * float(f[1]):g}', re.sub(r'M42[89].*', '', impeller.read_text()))))
    return out


# --- inside LinuxCNC, as its user interface

def interface(folder):
    import hal
    import linuxcnc
    wanted = json.loads((folder / 'wanted.json').read_text())
    command, stat, errors = linuxcnc.command(), linuxcnc.stat(), linuxcnc.error_channel()
    said, rows = [], []

    def wait(what, seconds=20):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            stat.poll()
            if what():
                return
            time.sleep(0.02)
        raise TimeoutError(what)

    try:
        component = hal.component('trunnion-compare')
        component.ready()
        record = hal.stream(component, hal.sampler_base, 'fffffs')
        time.sleep(0.5)
        for state in (linuxcnc.STATE_ESTOP_RESET, linuxcnc.STATE_ON):
            command.state(state)
            command.wait_complete()
        command.home(-1)
        wait(lambda: all(stat.homed[:5]))
        command.mode(linuxcnc.MODE_AUTO)
        command.wait_complete()
        command.program_open(wanted['program'])
        hal.set_p('sampler.0.enable', '1')
        command.auto(linuxcnc.AUTO_RUN, 0)
        started, begin = False, time.monotonic()
        while time.monotonic() < begin + wanted['seconds']:
            while record.readable:
                rows.append(record.read())
            stat.poll()
            started = started or stat.interp_state != linuxcnc.INTERP_IDLE
            message = errors.poll()
            if message:
                said.append(str(message[1]))
            idle = started and stat.interp_state == linuxcnc.INTERP_IDLE and stat.inpos
            if stat.task_state != linuxcnc.STATE_ON or idle:
                break
            time.sleep(0.01)
        time.sleep(0.1)
        while record.readable:
            rows.append(record.read())
        whole = started and stat.interp_state == linuxcnc.INTERP_IDLE and not said and record.num_overruns == 0
    except Exception as problem:
        whole = False
        said.append(repr(problem))
    numpy.save(folder / 'rows.npy', numpy.array(rows, dtype=float).reshape(-1, 6))
    (folder / 'result.json').write_text(json.dumps({'whole': bool(whole), 'said': said}))
    command.state(linuxcnc.STATE_OFF)


# --- one run

def as_user(words, environment, **more):
    """Before other work on the machine: a control's computer has none."""
    process = subprocess.Popen(['nice', '-n', '-10', 'runuser', '-u', USER, '--', 'env', '-i', f'HOME={pwd.getpwnam(USER).pw_dir}', 'USER=' + USER,
                             'PATH=/usr/bin:/bin', *environment, *words], start_new_session=True, stdin=subprocess.DEVNULL, **more)
    come_first(process)
    return process


def come_first(process):
    """Its session as a whole, where the system shares the processors out by sessions: there `nice` counts only within one."""
    group = pathlib.Path(f'/proc/{process.pid}/autogroup')
    if group.exists():
        group.write_text('-10')


def warped(folder, times):
    """Environment in which LinuxCNC's clocks run so many times faster; its setpoints stay the same bits."""
    if times == 1 or not (folder.parent / 'warp.so').exists():
        return []
    return [f'LD_PRELOAD={folder.parent}/warp.so', f'WARP={times}', f'WARP_BASE_MONO={time.monotonic_ns()}',
            f'WARP_BASE_REAL={time.time_ns()}']


def build_warp(folder, shared):
    """Out of the shared folder's tools; without it LinuxCNC's own runs take the time that they take."""
    source = shared / 'tools' / 'linuxcnc' / 'warp.c'
    if source.exists():
        subprocess.run(['gcc', '-O2', '-shared', '-fPIC', source, '-o', folder / 'warp.so', '-ldl'], check=True)
        os.chmod(shutil.which('rtapi_app'), 0o755)  # a program with the set-user bit takes no preloaded library


def configure(folder, trunnion, machine, planner, interface, period='1 ms'):
    """`interface`: what LinuxCNC starts as its user interface; it ends when that does."""
    subprocess.run([trunnion, 'machine', 'export', machine, '--linuxcnc', '-o', folder, '--period', period,
                    *(['--serve'] if planner != 'LinuxCNC' else [])], check=True, stdout=subprocess.DEVNULL)
    ini, hal = next(folder.glob('*.ini')), next(folder.glob('*.hal'))
    interface_file = folder / 'interface.sh'
    interface_file.write_text('#!/bin/sh\nexec /usr/bin/python3 -B ' + ' '.join(str(word) for word in interface) + '\n')
    interface_file.chmod(0o755)
    text = ini.read_text().replace('DISPLAY = dummy', f'DISPLAY = {interface_file}').replace('FERROR = 0.01', 'FERROR = 1000')
    ini.write_text(text.replace('[TRAJ]', '[TRAJ]\nARC_BLEND_RAMP_FREQ = 20'))
    more = 'loadrt sampler depth=20000 cfg=fffffs\naddf sampler.0 servo-thread\nsetp sampler.0.enable 0\n'
    more += ''.join(f'net position-{j} => sampler.0.pin.{j}\n' for j in range(5))
    more += 'net program-line motion.program-line => sampler.0.pin.5\n'
    hal.write_text(hal.read_text().replace('loadusr trunnion', f'loadusr {trunnion}') + more)
    return ini


def leave_no_process(session):
    for sign in (signal.SIGTERM, signal.SIGKILL):
        subprocess.run(['pkill', f'-{sign.value}', '-s', str(session)])
        time.sleep(1)


def run_linuxcnc(folder, ini, seconds, environment=()):
    """Until its user interface ends, which leaves result.json."""
    subprocess.run(['chown', '-R', USER, folder], check=True)
    while LOCK.exists():
        time.sleep(2)
    with open(folder / 'linuxcnc.log', 'w') as log:
        process = as_user(['linuxcnc', str(ini)], environment, stdout=log, stderr=subprocess.STDOUT, cwd=folder)
        try:
            process.wait(seconds + 60)
        except subprocess.TimeoutExpired:
            pass
        leave_no_process(process.pid)
    LOCK.unlink(missing_ok=True)
    if not (folder / 'result.json').exists():
        raise SystemExit(f'{folder}: LinuxCNC did not begin:\n' + (folder / 'linuxcnc.log').read_text()[-2000:])
    return json.loads((folder / 'result.json').read_text())


def run(folder, trunnion, machine, planner, program, seconds):
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    shutil.copy(__file__, folder / 'compare.py')
    ini = configure(folder, trunnion, machine, planner, [folder / 'compare.py', '--interface', folder])
    (folder / 'wanted.json').write_text(json.dumps({'program': str(program), 'seconds': seconds}))
    result = run_linuxcnc(folder, ini, seconds, warped(folder, WARP if planner == 'LinuxCNC' else 1))
    return result, numpy.load(folder / 'rows.npy')


# --- what came of it

def first_cut(lines):
    return next(k for k, line in enumerate(lines) if re.match(r'\s*(G93 )?\s*G1\b', line))


def cut_of(rows, program_text):
    """Rows from the rest before the first cutting block to the last movement; the period is 1 ms."""
    joints, lines = rows[:, :5], rows[:, 5].astype(int)
    first = first_cut(program_text.splitlines()) + 1
    moves = numpy.abs(numpy.diff(joints, axis=0)).max(1) > 1e-9
    moves[:numpy.argmax(lines >= first) + LAG] = False
    at = numpy.nonzero(moves)[0]
    return joints[max(at[0] - 3, 0):at[-1] + 5], (at[-1] - at[0] + 1) * 1e-3


def from_cut_on(text):
    """The program without the rapids before the one that leads to the first cutting block, where `cut_of` begins."""
    lines = text.splitlines()
    first = first_cut(lines)
    rapids = [k for k in range(first) if re.match(r'\s*G0\b', lines[k])]
    return '\n'.join(line for k, line in enumerate(lines) if k not in rapids[:-1]) + '\n'


def judge(folder, trunnion, machine, program, cut):
    rest = numpy.abs(numpy.diff(cut[:4], axis=0)).max() < 1e-9
    rows = cut if rest else numpy.vstack([cut[:1]] * 3 + [cut])
    setpoints = folder / 'setpoints.csv'
    with open(setpoints, 'w') as file:
        file.write('t_s,' + ','.join(f'{c}_{"deg" if c in "ABC" else "mm"}' for c in JOINTS) + '\n')
        for k, row in enumerate(rows):
            file.write(f'{k * 1e-3!r},' + ','.join(repr(float(x)) for x in row) + '\n')
    (folder / 'setup.toml').write_text(SETUP)
    verdict, checked = folder / 'verdict.json', folder / 'checked.ngc'
    checked.write_text(from_cut_on(pathlib.Path(program).read_text()))
    subprocess.run([trunnion, 'check', setpoints, '--against', checked, '-m', machine, '--setup', folder / 'setup.toml', '--quiet',
                    *TOLERANCE, '--summary', verdict], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return json.loads(verdict.read_text()) if verdict.exists() else {}


def largest(verdict, what):
    return max((axis.get(f'{what}_ratio', 0) for axis in verdict.get('axes', {}).values()), default=math.nan)


def line_of(name, planner, result, seconds, verdict):
    number = lambda value, form: '' if value is None else format(value, form)
    return [name, planner + ('' if result['whole'] else ' (not to its end)'), f'{seconds:.3f}',
            number(verdict.get('tip_deviation_mm'), '.4f'), number(verdict.get('orientation_deviation_deg'), '.3f'),
            *(f'{largest(verdict, what):.4g}' for what in ('velocity', 'acceleration', 'jerk'))]


HEAD = ['program', 'planner', 'time s', 'tip mm', 'orientation deg', 'velocity', 'acceleration', 'jerk']


def write_table(table, output):
    text = ['| ' + ' | '.join(HEAD) + ' |', '|---|---|' + '---:|' * (len(HEAD) - 2)]
    text += ['| ' + ' | '.join(line) + ' |' for line in table]
    page = pathlib.Path(output).read_text()
    begin, end = page.index('<!-- table -->'), page.index('<!-- end of table -->')
    pathlib.Path(output).write_text(page[:begin] + '<!-- table -->\n' + '\n'.join(text) + '\n' + page[end:])


def absent():
    return os.getuid() != 0 or not shutil.which('linuxcnc') or not shutil.which('halcompile')


def prepare(trunnion, shared):
    """A folder that LinuxCNC's user can read, with program and machine; the module is compiled and installed."""
    folder = pathlib.Path(tempfile.mkdtemp(prefix='trunnion-compare-'))
    folder.chmod(0o755)
    shutil.copytree(HERE, folder / 'linuxcnc')
    subprocess.run(['halcompile', '--install', 'trunnion_tp.c'], cwd=folder / 'linuxcnc' / 'tpmod', check=True, stdout=subprocess.DEVNULL)
    if subprocess.run(['id', USER], capture_output=True).returncode:
        subprocess.run(['useradd', '-m', USER], check=True)
    return folder, shutil.copy(trunnion, folder / 'trunnion'), shutil.copy(shared / 'data' / 'cases' / 'peer-trunnion.toml', folder)


def main():
    if sys.argv[1:2] == ['--interface']:
        return interface(pathlib.Path(sys.argv[2]))
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    root = HERE.parent
    words.add_argument('--trunnion', type=pathlib.Path, default=root / 'build/release/apps/trunnion/trunnion')
    words.add_argument('--shared', type=pathlib.Path, default=root.parent / 'shared')
    words.add_argument('--only', nargs='*')
    words.add_argument('--planner', choices=PLANNERS)
    words.add_argument('--seconds', type=float, default=600, help='of one run')
    words.add_argument('-o', '--output', help='page with a table between <!-- table --> and <!-- end of table -->')
    args = words.parse_args()
    if absent():
        print('needed: root, linuxcnc-uspace and linuxcnc-uspace-dev')
        return 77
    folder, trunnion, machine = prepare(args.trunnion, args.shared)
    hasty = folder / 'hasty.toml'
    hasty.write_text(re.sub(r'(max_jerk = ")(\d+)', lambda m: f'{m[1]}{100 * int(m[2])}', pathlib.Path(machine).read_text()))
    build_warp(folder, args.shared)
    table = []
    for name, text in programs(args.shared):
        if args.only and name not in args.only:
            continue
        program = folder / (re.sub(r'\W+', '-', name) + '.ngc')
        program.write_text(text)
        for planner in [args.planner] if args.planner else PLANNERS:
            if planner == HASTY and name not in JERK_BOUND:
                continue
            at = folder / re.sub(r'\W+', '-', f'{program.stem}-{planner}')
            used = hasty if planner == HASTY else machine
            result, rows = run(at, trunnion, used, planner, program, args.seconds)
            cut, seconds = cut_of(rows, text)
            table.append(line_of(name, planner, result, seconds, judge(at, trunnion, used, program, cut)))
            print('| ' + ' | '.join(table[-1]) + ' |', *result['said'], flush=True)
    if args.output:
        write_table(table, args.output)
    return 0


if __name__ == '__main__':
    sys.exit(main())
