#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-only
"""Between `trunnion play --linuxcnc` and a running LinuxCNC; started by it, not by hand.   bridge.py PLANS [STREAMER]

PLANS: descriptor of the memory that the rows come from (plan_buffer.h).

Says on stdout, a line each: `facts …` once, then `s WRITTEN DEPTH` now and then, `done` after an order that takes time,
`halt REASON` when LinuxCNC has ended the motion, `missing REASON` when there is nothing to speak to.
Takes on stdin a letter and, with X, A, R and B, a double for every joint:
X  its axis, as numbered in the plans
A  go to this place by LinuxCNC's own jog      R  a row for the streamer
T  from now on the axes follow the rows        B  the axes follow LinuxCNC again, which is to stand at this place

Where stdin ends while the axes follow rows, whoever sent them was killed: the plan that they come from is played to its
standstill, inside all limits, then it does as with B. The axes are given back only where LinuxCNC stands, or
where it has disabled motion; if neither comes about they stay at the last row, and it says so.
"""
import mmap
import os
import select
import struct
import subprocess
import sys
import time

PLAY = 'trunnion-play'
NEAR = 1.1e-3  # of what a joint's acceleration makes in one period: LinuxCNC ends a jog that near to its goal
RAMP = 8  # rows


def say(text):
    sys.stdout.write(text + '\n')
    sys.stdout.flush()


class Plans:
    """Plans in memory that is shared with whoever sends the rows, as plan_buffer.h lays them out."""
    HEAD, PLAN, ROW = struct.Struct('=QQdQQQQ'), struct.Struct('=QQQ'), struct.Struct('=9dq')

    def __init__(self, descriptor):
        self.memory = mmap.mmap(descriptor, 0, prot=mmap.PROT_READ)

    def rows_behind(self, last, axes):
        """Rows of the plan in use behind the one that is `last`; a joint each, of these axes."""
        *_, in_use, following = self.HEAD.unpack_from(self.memory)
        begin = self.HEAD.size + (in_use & 1) * ((len(self.memory) - self.HEAD.size) // 2)
        first, _, count = self.PLAN.unpack_from(self.memory, begin)

        def row(k):
            values = self.ROW.unpack_from(self.memory, begin + self.PLAN.size + k * self.ROW.size)
            return tuple(values[axis] for axis in axes)

        for k in range(min(following - first, count) - 1, -1, -1):
            if row(k) == last:
                return [row(behind) for behind in range(k + 1, count)]
        return []


class Machine:
    """The LinuxCNC that runs on this computer."""

    def __init__(self, plans, streamer):
        import hal
        import linuxcnc
        self.hal, self.linuxcnc = hal, linuxcnc
        self.plans, self.axes = plans, None
        self.stat, self.command, self.errors = linuxcnc.stat(), linuxcnc.command(), linuxcnc.error_channel()
        self.stat.poll()
        self.joints = self.stat.joints
        self.component = hal.component(f'trunnion-bridge-{os.getpid()}')
        self.component.ready()
        self.stream = hal.stream(self.component, hal.streamer_base + streamer, 'f' * self.joints)
        self.written, self.last, self.place = 0, None, None
        ini = linuxcnc.ini(self.stat.ini_filename)
        self.letters = (ini.find('TRAJ', 'COORDINATES') or '').replace(' ', '').upper()
        self.near = [NEAR * float(ini.find(f'JOINT_{j}', 'MAX_ACCELERATION') or 1) * (1e-9 * self.period_ns()) ** 2
                     for j in range(self.joints)]
        self.speeds = [float(ini.find(f'JOINT_{j}', 'MAX_VELOCITY') or 1) for j in range(self.joints)]
        self.taken = False

    def pin(self, name):
        return self.hal.get_value(name)

    def period_ns(self):
        threads = subprocess.run(['halcmd', '-s', 'show', 'thread'], capture_output=True, text=True, timeout=10).stdout
        for line in threads.splitlines():
            words = line.split()
            if len(words) > 2 and words[0].isdigit() and 'servo' in words[2]:
                return int(words[0])
        return 0

    def facts(self):
        stat, linuxcnc = self.stat, self.linuxcnc
        out = [f'letters={self.letters}', f'on={int(stat.task_state == linuxcnc.STATE_ON)}',
               f'idle={int(stat.interp_state == linuxcnc.INTERP_IDLE and stat.inpos)}',
               f'homed={int(all(stat.homed[:self.joints]))}', f'period_ns={self.period_ns()}',
               f'linear_units={stat.linear_units!r}', f'angular_units={stat.angular_units!r}',
               f'room={self.stream.maxdepth}']
        for number in range(self.joints):
            joint = stat.joint[number]
            values = (joint['output'], joint['min_position_limit'], joint['max_position_limit'], joint['min_ferror'])
            out.append('joint=' + ','.join(repr(value) for value in values))
        return 'facts ' + ' '.join(out)

    def flush(self):
        """Rows that a play before this one has left."""
        while self.stream.readable:
            self.stream.read()

    def row(self, values):
        while not self.stream.writable:
            time.sleep(0.001)
        self.stream.write(values)
        self.written += 1
        self.last = values

    def ramp(self, begin, end):
        """Rows over the way that a jog has left, smoothly."""
        for k in range(1, RAMP + 1):
            share = k / RAMP
            weight = share ** 3 * (10 - 15 * share + 6 * share ** 2)
            self.stream.write(end if k == RAMP else tuple(a + (b - a) * weight for a, b in zip(begin, end)))

    def outputs(self):
        self.stat.poll()
        return tuple(self.stat.joint[j]['output'] for j in range(self.joints))

    def take(self):
        """Whether LinuxCNC still stands where the rows begin."""
        self.stat.poll()
        if not self.stands_at(self.place) or self.stat.task_state != self.linuxcnc.STATE_ON:
            return False
        self.hal.set_p(PLAY + '.fault-in', '0')
        self.hal.set_p(PLAY + '.reset', '0')
        time.sleep(0.003)
        self.hal.set_p(PLAY + '.reset', '1')
        for _ in range(50):
            self.taken = self.pin(PLAY + '.ok-out')
            if self.taken:
                break
            time.sleep(0.001)
        return self.taken

    def stands_at(self, place):
        return all(abs(place[j] - self.stat.joint[j]['output']) <= self.near[j] for j in range(self.joints))

    def release(self):
        self.hal.set_p(PLAY + '.reset', '0')
        self.hal.set_p(PLAY + '.fault-in', '1')
        self.taken = False

    def jog_to(self, place):
        """Joint by joint, all at once, each by its own limits. While the axes follow rows they do not move with it."""
        self.command.mode(self.linuxcnc.MODE_MANUAL)
        self.command.wait_complete()
        self.command.teleop_enable(0)
        self.command.wait_complete()
        for _ in range(5):
            self.stat.poll()
            ways = [place[j] - self.stat.joint[j]['output'] for j in range(self.joints)]
            if self.stands_at(place):
                self.place = place
                return True
            for j, way in enumerate(ways):
                if abs(way) > self.near[j]:
                    speed = self.speeds[j] if way > 0 else -self.speeds[j]
                    self.command.jog(self.linuxcnc.JOG_INCREMENT, True, j, speed, abs(way))
                    self.command.wait_complete()
            if not self.wait_still():
                return False
        return False

    def wait_still(self):
        still, before = 0, None
        for _ in range(60000):
            time.sleep(0.02)
            self.stat.poll()
            if self.stat.task_state != self.linuxcnc.STATE_ON:
                return False
            now = [self.stat.joint[j]['output'] for j in range(self.joints)]
            still = still + 1 if now == before else 0
            before = now
            if still >= 10:
                return True
        return False

    def give_back(self, place):
        """LinuxCNC goes to where the axes stand, then they follow it again. Whether it came there."""
        if not self.jog_to(place):
            return False
        self.ramp(place, self.outputs())
        self.run_dry()
        self.release()
        return True

    def run_dry(self):
        while self.stream.depth > 0 and self.pin(PLAY + '.ok-out'):
            time.sleep(0.001)
        time.sleep(0.01)

    def play_to_standstill(self):
        for values in self.plans.rows_behind(self.last, self.axes):
            while not self.stream.writable and self.pin(PLAY + '.ok-out'):
                time.sleep(0.001)
            if not self.pin(PLAY + '.ok-out'):
                return
            self.stream.write(values)
            self.last = values

    def end(self):
        """Whoever sent the rows has gone."""
        if not self.taken:
            return
        self.play_to_standstill()
        self.run_dry()
        if not self.pin(PLAY + '.ok-out'):
            self.release()
        elif self.last and not self.give_back(self.last):
            print('the axes stay where the last row says; switch the machine off before anything else', file=sys.stderr)

    def trouble(self):
        """Why the axes do not follow the rows any more; nothing while they do."""
        if not self.taken or self.pin(PLAY + '.ok-out'):
            return None
        for _ in range(50):  # until LinuxCNC's task has noticed as well
            time.sleep(0.01)
            self.stat.poll()
            if self.stat.task_state == self.linuxcnc.STATE_ESTOP:
                break
        reasons = []
        for _ in range(20):
            message = self.errors.poll()
            if not message:
                break
            reasons.append(str(message[1]))
        state = {self.linuxcnc.STATE_ESTOP: 'E-stop', self.linuxcnc.STATE_OFF: 'machine off',
                 self.linuxcnc.STATE_ESTOP_RESET: 'machine off'}
        reasons.insert(0, state.get(self.stat.task_state, 'motion disabled'))
        return ', '.join(reasons).replace('\n', ' ')


def serve(machine):
    size = 8 * machine.joints
    text, told, due = b'', 0.0, None
    say(machine.facts())
    while True:
        readable, _, _ = select.select([0], [], [], 0.002)
        if readable:
            got = os.read(0, 1 << 16)
            if not got:
                return
            text += got
        while text:
            long = 1 + (size if text[:1] in b'XARB' else 0)
            if len(text) < long:
                break
            letter, values = text[:1], struct.unpack(f'{(long - 1) // 8}d', text[1:long])
            text = text[long:]
            if letter == b'R':
                machine.row(values)
            elif letter == b'X':
                machine.axes = [round(value) for value in values]
            elif letter == b'T':
                if not machine.take():
                    say('halt it does not stand where the program begins any more')
            elif letter == b'A':
                machine.flush()
                good = machine.jog_to(values)
                if good:
                    machine.ramp(machine.outputs(), values)
                say('done' if good else 'halt LinuxCNC did not go to where the program begins')
            elif letter == b'B':
                say('done' if machine.give_back(values) else 'halt LinuxCNC did not take over the place')
        trouble = machine.trouble()
        if trouble:
            machine.release()
            say('halt ' + trouble)
            return
        if time.monotonic() - told > 0.002:
            told = time.monotonic()
            say(f's {machine.written} {machine.stream.depth}')


def main():
    try:
        machine = Machine(Plans(int(sys.argv[1])), int(sys.argv[2]) if len(sys.argv) > 2 else 0)
        machine.pin(PLAY + '.ok-out')
    except Exception as error:  # whatever LinuxCNC's modules raise, it cannot be spoken to
        say(f'missing {type(error).__name__}: {error}'.replace('\n', ' '))
        return
    try:
        serve(machine)
    finally:
        machine.end()


if __name__ == '__main__':
    main()
