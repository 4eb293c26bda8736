#!/usr/bin/python3
"""`trunnion play --linuxcnc` into the real LinuxCNC of Debian, simulated drives, as user `lcnc`.

linuxcnc_play.py TRUNNION SHARED_DIR [SCENARIO …]     exit status 77: LinuxCNC or its user is not there
"""
import array
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

LETTERS = 'XYZAC'
LOCK = pathlib.Path('/tmp/linuxcnc.lock')


def configuration(folder, trunnion, machine, scenario):
    """As `machine export` makes it, with an interface of our own, following errors of 0.001, and what the drives get recorded."""
    subprocess.run([trunnion, 'machine', 'export', machine, '--linuxcnc', '--play', '--display', folder / 'display.sh', '-o', folder,
                    '--period', f'{scenario.get("period_ns", 1000000)}e-9 s'], check=True, stdout=subprocess.DEVNULL)
    ini, hal = next(folder.glob('*.ini')), next(folder.glob('*.hal'))
    text = ini.read_text().replace('FERROR = 0.01\n', 'FERROR = 0.001\n')
    if 'reach' in scenario:
        text = re.sub(r'MIN_LIMIT = .*', f'MIN_LIMIT = -{scenario["reach"]}', text)
        text = re.sub(r'MAX_LIMIT = .*', f'MAX_LIMIT = {scenario["reach"]}', text)
    ini.write_text(text)
    ini.rename(folder / 'play.ini')
    record = 'loadrt sampler depth=60000 cfg=fffff\naddf sampler.0 servo-thread\nsetp sampler.0.enable 0\n'
    record += ''.join(f'net trunnion-axis-{j} => sampler.0.pin.{j}\n' for j in range(5))
    hal.write_text(hal.read_text() + record)
    display = folder / 'display.sh'
    display.write_text(f'#!/bin/sh\nexec /usr/bin/python3 {os.path.abspath(__file__)} --display {folder}\n')
    display.chmod(0o755)


class Display:
    """Runs as LinuxCNC's user interface: homes, plays, records what the drives are given."""

    def __init__(self, folder):
        import hal
        import linuxcnc
        self.folder, self.hal, self.linuxcnc = folder, hal, linuxcnc
        self.scenario = json.loads((folder / 'scenario.json').read_text())
        time.sleep(0.5)
        self.command, self.stat = linuxcnc.command(), linuxcnc.stat()
        self.errors = linuxcnc.error_channel()
        self.component = hal.component('record')
        self.component.ready()
        self.samples = hal.stream(self.component, hal.sampler_base, 'fffff')
        self.rows = array.array('d')

    def make_ready(self):
        if self.scenario.get('off'):
            return
        self.command.state(self.linuxcnc.STATE_ESTOP_RESET)
        self.command.wait_complete()
        self.command.state(self.linuxcnc.STATE_ON)
        self.command.wait_complete()
        if self.scenario.get('unhomed'):
            return
        self.command.mode(self.linuxcnc.MODE_MANUAL)
        self.command.teleop_enable(0)
        self.command.wait_complete()
        self.command.home(-1)
        for _ in range(200):
            self.stat.poll()
            if all(self.stat.homed[:5]):
                break
            time.sleep(0.05)
        self.go_to(self.scenario.get('stand', [0] * 5))

    def go_to(self, place):
        self.command.mode(self.linuxcnc.MODE_MANUAL)
        self.command.wait_complete()
        self.command.teleop_enable(0)
        self.command.wait_complete()
        time.sleep(0.3)
        for joint, at in enumerate(self.places()):
            way = place[joint] - at
            if way:
                self.command.jog(self.linuxcnc.JOG_INCREMENT, True, joint, 50 if way > 0 else -50, abs(way))
                self.command.wait_complete()
        before = None
        while self.places() != before:
            before = self.places()
            time.sleep(0.3)

    def places(self):
        self.stat.poll()
        return [self.stat.joint[j]['output'] for j in range(5)]

    def record(self):
        while self.samples.readable:
            self.rows.extend(self.samples.read())

    def play(self):
        self.hal.set_p('sampler.0.enable', '1')
        with open(self.folder / 'out.txt', 'w') as out, open(self.folder / 'err.txt', 'w') as err:
            player = subprocess.Popen(self.scenario['words'], stdin=subprocess.PIPE, stdout=out, stderr=err, text=True)
            begin, steps = time.monotonic(), list(self.scenario.get('steps', []))
            while (player.poll() is None or self.taken()) and time.monotonic() - begin < self.scenario.get('longest', 60):
                self.record()  # also while a bridge has still to give the axes back
                if steps and time.monotonic() - begin > steps[0][0]:
                    self.do(steps.pop(0)[1], player)
                time.sleep(0.01)
            if player.poll() is None:
                player.kill()
        time.sleep(0.3)
        self.record()
        return player.returncode

    def taken(self):
        return bool(self.hal.get_value('trunnion-play.ok-out'))

    def do(self, step, player):
        if step == 'E-stop':
            self.command.state(self.linuxcnc.STATE_ESTOP)
        elif step == 'kill feeder':
            player.kill()
        elif step == 'kill bridge':  # the older one of two
            bridge = subprocess.run(['pgrep', '-o', '-U', str(os.getuid()), '-f', 'linuxcnc/bridge.py'], capture_output=True, text=True)
            for one in bridge.stdout.split():
                os.kill(int(one), signal.SIGKILL)
        elif step == 'kill planner':
            children = subprocess.run(['pgrep', '-P', str(player.pid), '-x', 'trunnion'], capture_output=True, text=True)
            os.kill(int(children.stdout.split()[0]), signal.SIGKILL)
        else:
            player.stdin.write(step + '\n')
            player.stdin.flush()

    def run(self):
        self.make_ready()
        result = {'before': self.places(), 'status': self.play()}
        result.update(after=self.places(), on=self.stat.task_state == self.linuxcnc.STATE_ON,
                      overruns=self.samples.num_overruns, taken=self.taken(),
                      drives=[self.hal.get_value(f'trunnion-out-{j}.out') for j in range(5)])
        if result['on'] and not self.scenario.get('unhomed'):  # LinuxCNC goes on from there
            self.command.jog(self.linuxcnc.JOG_INCREMENT, True, 0, 20, 1.0)
            time.sleep(1.5)
            result['moved_on'] = self.places()[0] - result['after'][0]
        (self.folder / 'samples.f64').write_bytes(self.rows.tobytes())
        (self.folder / 'result.json').write_text(json.dumps(result))


def start_linuxcnc(folder):
    """As user lcnc, in a session of its own, until its display ends."""
    words = ['linuxcnc', str(folder / 'play.ini')]
    if os.getuid() == 0:
        words = ['nice', '-n', '-10', 'runuser', '-u', 'lcnc', '--', 'env', '-i', 'HOME=/home/lcnc', 'USER=lcnc', 'TERM=dumb',
                 'PATH=/usr/bin:/bin'] + words
    with open(folder / 'linuxcnc.log', 'w') as log:
        process = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT,
                                   start_new_session=True, cwd=folder)
        if os.getuid() == 0:  # sessions share the processors, `nice` counts within one
            pathlib.Path(f'/proc/{process.pid}/autogroup').write_text('-10')
        try:
            process.wait(120)
        except subprocess.TimeoutExpired:
            pass
    end_session(process.pid)


def end_session(session):
    for last in (signal.SIGTERM, signal.SIGKILL):
        left = subprocess.run(['pgrep', '-s', str(session)], capture_output=True, text=True).stdout.split()
        for one in left:
            try:
                os.kill(int(one), last)
            except OSError:
                pass
        if left:
            time.sleep(1)


def run_scenario(name, scenario, trunnion, machine, keep=None):
    folder = pathlib.Path(tempfile.mkdtemp(prefix=f'play-{name}-'))
    folder.chmod(0o777)
    scenario['words'] = [word.replace('FOLDER', str(folder)) for word in scenario['words']]
    (folder / 'scenario.json').write_text(json.dumps(scenario))
    configuration(folder, trunnion, machine, scenario)
    subprocess.run(['chmod', '-R', 'a+rwX', folder], check=True)
    start_linuxcnc(folder)
    if not (folder / 'result.json').exists():
        raise AssertionError(f'{name}: LinuxCNC did not come up:\n' + (folder / 'linuxcnc.log').read_text()[-2000:])
    result = json.loads((folder / 'result.json').read_text())
    samples = array.array('d')
    samples.frombytes((folder / 'samples.f64').read_bytes())
    result['samples'] = [tuple(samples[k:k + 5]) for k in range(0, len(samples), 5)]
    result['out'], result['err'] = (folder / 'out.txt').read_text(), (folder / 'err.txt').read_text()
    rows = folder / 'rows.csv'
    result['rows'] = [tuple(float(v) for v in line.split(',')[1:6]) for line in rows.read_text().splitlines()[1:]] \
        if rows.exists() else []
    if keep:
        keep(folder)
    shutil.rmtree(folder, ignore_errors=True)
    return result


def without_standing(rows):
    return [row for k, row in enumerate(rows) if k == 0 or row != rows[k - 1]]


def worst_ratios(samples, limits, period=1e-3):
    """Peaks of velocity, acceleration and jerk of the samples, of the limits."""
    out = [0.0, 0.0, 0.0]
    for axis, of_axis in enumerate(limits):
        values = [row[axis] for row in samples]
        for order, limit in enumerate(of_axis):
            values = [b - a for a, b in zip(values, values[1:])]
            out[order] = max([out[order]] + [abs(v) / period ** (order + 1) / limit for v in values])
    return out


class Test:
    PEER = [(500, 2500, 5000), (500, 3000, 5000), (500, 2100, 50000), (90, 300, 1800), (120, 300, 1800)]

    def __init__(self, trunnion, shared):
        self.cases = pathlib.Path(shared) / 'data/cases'
        self.begin = [trunnion, 'play']
        self.end = ['-m', str(self.cases / 'peer-trunnion.toml'), '--setup', str(self.cases / 'peer-setup.toml'),
                    '--linuxcnc']

    def words(self, program, *more):
        return [*self.begin, str(self.cases / program), *self.end, *more]

    def run(self, name, program, more=('-o', 'FOLDER/rows.csv', '--depth', '300ms'), **scenario):
        scenario['words'] = self.words(program, *more)
        return run_scenario(name, scenario, self.begin[0], self.cases / 'peer-trunnion.toml')

    def expect_played(self, result, status=0, period=1e-3):
        assert result['status'] == status, (result['status'], result['err'], result['out'])
        assert result['overruns'] == 0
        drives = without_standing(result['samples'])
        played = without_standing(result['rows'])
        at = drives.index(played[0])
        assert drives[at:at + len(played)] == played, 'rows of the drives are not those that were planned'
        assert len(drives) <= at + len(played) + 32, 'the drives moved on'
        ratios = worst_ratios(result['samples'], self.PEER, period)
        assert max(ratios) < 1.001, ratios
        self.expect_given_back(result, played[-1])
        return played, ratios

    def expect_given_back(self, result, last):
        assert not result['taken'] and result['drives'] == result['after'], (result['drives'], result['after'])
        near = max(abs(a - b) for a, b in zip(result['after'], last))
        assert near < 4e-6, (result['after'], last)  # LinuxCNC's jog: 0.001 of the acceleration, in one period
        assert abs(result['moved_on'] - 1) < 1e-5, 'LinuxCNC does not go on from there'

    def stand(self, program):
        """Where a program begins."""
        with tempfile.NamedTemporaryFile(suffix='.csv') as rows:
            subprocess.run([*self.begin, str(self.cases / program), *self.end[:-1], '--dry-run', '--wait', '-q', '-o',
                            rows.name], input='start\nstop\n', capture_output=True, text=True, timeout=60, check=True)
            return [float(v) for v in pathlib.Path(rows.name).read_text().splitlines()[1].split(',')[1:6]]


def play_to_the_end(test):
    result = test.run('end', 'fillet.ngc', more=('-o', 'FOLDER/rows.csv', '--depth', '300ms', '--wait'),
                      stand=test.stand('fillet.ngc'), steps=[(2, 'start')])
    played, ratios = test.expect_played(result)
    print(result['out'].splitlines()[0])
    print(f'{len(played)} rows reached the drives to the last bit; peaks of the limits {ratios}')


def play_under_commands(test):
    result = test.run('commands', 'gentle-1.ngc', more=('-o', 'FOLDER/rows.csv', '--depth', '300ms', '--wait'), stand=test.stand('gentle-1.ngc'),
                      steps=[(2, 'start'), (2.3, 'hold'), (3.1, 'resume'), (3.3, 'override 30'), (4.3, 'override 100')])
    played, ratios = test.expect_played(result)
    assert len(played) > 1700, f'{len(played)} rows: the commands did not count'
    print(f'hold and override: {len(played)} rows, peaks of the limits {ratios}')
    print(result['out'])


def stop_in_the_middle(test):
    result = test.run('stop', 'sine-10k.ngc', stand=test.stand('sine-10k.ngc'), steps=[(4, 'stop')])
    played, ratios = test.expect_played(result)
    print(f'stop: {len(played)} rows, peaks of the limits {ratios}')


def kill_the_planner(test):
    result = test.run('kill', 'sine-10k.ngc', stand=test.stand('sine-10k.ngc'), steps=[(4, 'kill planner')])
    played, ratios = test.expect_played(result, status=1)
    assert 'RT0008' in result['err'], result['err']
    print(f'planner killed: {len(played)} rows, peaks of the limits {ratios}')


def expect_stopped(test, result, what):
    """At the standstill of a plan, inside all limits, and LinuxCNC goes on from there."""
    ratios = worst_ratios(result['samples'], test.PEER)
    rows = without_standing(result['samples'])
    print(f'{what}: {len(rows)} rows, peaks of the limits {ratios}')
    assert max(ratios) < 1.001 and len(rows) > 1000, (ratios, len(rows))
    test.expect_given_back(result, rows[-1])


def kill_the_feeder(test):
    """What hands out the rows; the bridge plays the last plan to its standstill."""
    result = test.run('feeder', 'sine-10k.ngc', stand=test.stand('sine-10k.ngc'), steps=[(4, 'kill feeder')])
    assert result['status'] == -signal.SIGKILL, result['status']
    expect_stopped(test, result, 'feeder killed')


def kill_the_bridge(test):
    """The bridge that stands by goes on behind the rows that LinuxCNC holds."""
    for at in (3.1, 4.7):
        result = test.run('bridge', 'sine-10k.ngc', stand=test.stand('sine-10k.ngc'), more=('-o', 'FOLDER/rows.csv'),
                          steps=[(at, 'kill bridge')])
        assert result['status'] == 1 and 'RT0014' in result['err'], (result['status'], result['err'])
        expect_stopped(test, result, f'bridge killed after {at} s')


def kill_feeder_and_bridge(test):
    """The one soon behind the other, and while LinuxCNC is taken to where the axes stand."""
    for both in (4, 4.1), (4, 4.5), (2.2, 9):
        result = test.run('both', 'sine-10k.ngc', stand=test.stand('sine-10k.ngc'),
                          steps=[(both[0], 'kill feeder'), (both[1], 'kill bridge')])
        assert result['status'] == -signal.SIGKILL, result['status']
        expect_stopped(test, result, f'feeder and bridge killed after {both} s')


def period_of_250_us(test):
    result = test.run('fast', 'fillet.ngc', more=('-o', 'FOLDER/rows.csv', '--depth', '200ms', '--period', '0.25ms'), period_ns=250000,
                      stand=test.stand('fillet.ngc'))
    played, ratios = test.expect_played(result, period=250e-6)
    print(f'250 us: {len(played)} rows reached the drives to the last bit; peaks of the limits {ratios}')


def press_estop(test):
    result = test.run('estop', 'sine-10k.ngc', stand=test.stand('sine-10k.ngc'), steps=[(4, 'E-stop')])
    assert result['status'] == 1 and 'RT0009' in result['err'], (result['status'], result['err'])
    assert not result['taken'] and not result['on']
    print('E-stop: ' + result['err'].strip())


def refused(test, name, code, program='fillet.ngc', more=(), **scenario):
    result = test.run(name, program, more=more, **scenario)
    assert result['status'] == 2 and code in result['err'], (name, result['status'], result['err'])
    assert len(set(result['samples'])) <= 1, 'something moved'
    print(f'{name}: ' + result['err'].strip().splitlines()[-1])


def refuse_off(test):
    refused(test, 'off', 'RT0002', off=True)


def refuse_unhomed(test):
    refused(test, 'unhomed', 'RT0002', unhomed=True)


def refuse_other_period(test):
    refused(test, 'period', 'RT0003', period_ns=2000000)


def refuse_other_axes(test):
    end = test.end
    test.end = ['-m', 'xyzbc-trt', '--linuxcnc']
    refused(test, 'axes', 'RT0003')
    test.end = end


def refuse_other_place(test):
    refused(test, 'place', 'RT0004', stand=[v + 0.01 for v in test.stand('fillet.ngc')])


def refuse_narrower_limits(test):
    refused(test, 'reach', 'PATH0102', reach=55, stand=[0, 0, 0, 0, 0])


SCENARIOS = [play_to_the_end, play_under_commands, stop_in_the_middle, kill_the_planner, kill_the_feeder, kill_the_bridge, kill_feeder_and_bridge,
             period_of_250_us, press_estop, refuse_off, refuse_unhomed, refuse_other_period, refuse_other_axes, refuse_other_place, refuse_narrower_limits]


def main():
    if sys.argv[1] == '--display':
        return Display(pathlib.Path(sys.argv[2])).run()
    if not shutil.which('linuxcnc') or subprocess.run(['id', 'lcnc'], capture_output=True).returncode or LOCK.exists():
        print('LinuxCNC or its user `lcnc` is not there, or it runs')
        return 77
    test = Test(*sys.argv[1:3])
    wanted = sys.argv[3:]
    for scenario in SCENARIOS:
        if not wanted or scenario.__name__ in wanted:
            scenario(test)


if __name__ == '__main__':
    sys.exit(main())
