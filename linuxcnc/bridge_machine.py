# SPDX-License-Identifier: GPL-2.0-only
"""The LinuxCNC that runs on this computer, and the plans that its rows come from, as bridge.py sees them."""
import collections
import ctypes
import mmap
import os
import struct
import subprocess
import sys
import time

PLAY = 'trunnion-play'
NEAR = 1.1e-3  # of what a joint's acceleration makes in one period: LinuxCNC ends a jog that near to its goal
RAMP = 8  # rows
TAIL = 4  # rows by which a place in a plan is known again: position, speed, acceleration, jerk


class Plans:
    """Plans in memory that is shared with whoever sends the rows, as plan_buffer.h lays them out."""
    HEAD, PLAN, ROW = struct.Struct('=QQdQQQQ'), struct.Struct('=QQQ'), struct.Struct('=9dq')

    def __init__(self, descriptor):
        self.memory = mmap.mmap(descriptor, 0, prot=mmap.PROT_READ)

    def in_use(self):
        return self.HEAD.unpack_from(self.memory)[-2:]

    def copy(self, axes):
        """The rows of the plan in use, a joint each, of these axes, and how many of them were given. Whoever gives them may go over to
        another plan meanwhile: then it is that one."""
        while True:
            in_use, following = self.in_use()
            begin = self.HEAD.size + (in_use & 1) * ((len(self.memory) - self.HEAD.size) // 2)
            first, _, count = self.PLAN.unpack_from(self.memory, begin)
            begin += self.PLAN.size
            rows = [tuple(values[axis] for axis in axes)
                    for values in self.ROW.iter_unpack(self.memory[begin:begin + count * self.ROW.size])]
            if self.in_use()[0] == in_use:
                return rows, min(following - first, count)

    def rows_behind(self, tail, axes):
        """Rows of the plan in use behind these: given as the last ones of all, or played from the plan behind what was given."""
        rows, given = self.copy(axes)
        for k in (*range(given, 0, -1), *range(given + 1, len(rows) + 1)):
            known = min(k, len(tail))
            if known and rows[k - known:k] == tail[-known:]:
                return rows[k:]
        return []


class Ring:
    """What the streamer's memory holds (struct hal_stream_shm of LinuxCNC 2.9), read without taking anything out of it."""
    HEAD, DATA, MAGIC = struct.Struct('=6I'), 128, 0x4649464F

    def __init__(self, key, joints):
        libc = ctypes.CDLL(None, use_errno=True)
        libc.shmat.restype = ctypes.c_void_p
        self.at, self.row = libc.shmat(libc.shmget(key, 0, 0), None, 0o10000), struct.Struct(f'={joints}dQ')  # SHM_RDONLY
        if self.at in (None, ctypes.c_void_p(-1).value) or self.head()[0] != self.MAGIC or self.head()[5] != joints:
            raise OSError('the streamer has another layout')

    def head(self):
        return self.HEAD.unpack(ctypes.string_at(self.at, self.HEAD.size))

    def tail(self):
        """The newest rows, the last one written last."""
        _, following, _, _, depth, _ = self.head()
        rows = [ctypes.string_at(self.at + self.DATA + (k % depth) * self.row.size, self.row.size)
                for k in range(following - TAIL, following)]
        return [self.row.unpack(row)[:-1] for row in rows]


def signal_of(pin):
    """The signal that a pin is linked to."""
    pins = subprocess.run(['halcmd', '-s', 'show', 'pin', pin], capture_output=True, text=True, timeout=10).stdout
    return next(line.split()[-1] for line in pins.splitlines() if '==>' in line)


def servo_period_ns():
    threads = subprocess.run(['halcmd', '-s', 'show', 'thread'], capture_output=True, text=True, timeout=10).stdout
    for line in threads.splitlines():
        words = line.split()
        if len(words) > 2 and words[0].isdigit() and 'servo' in words[2]:
            return int(words[0])
    return 0


class Machine:
    """The LinuxCNC that runs on this computer."""

    def __init__(self, plans, streamer, name):
        import hal
        import linuxcnc
        self.hal, self.linuxcnc = hal, linuxcnc
        self.plans, self.axes = plans, None
        self.stat, self.command, self.errors = linuxcnc.stat(), linuxcnc.command(), linuxcnc.error_channel()
        self.stat.poll()
        self.joints = self.stat.joints
        self.component = hal.component(f'{name}-{os.getpid()}')
        self.component.newpin('follows', hal.HAL_BIT, hal.HAL_IN)  # read without HAL's lock, which who was killed may hold
        self.component.ready()
        hal.connect(f'{name}-{os.getpid()}.follows', signal_of(PLAY + '.ok-out'))
        self.stream = hal.stream(self.component, hal.streamer_base + streamer, 'f' * self.joints)
        self.ring_key = hal.streamer_base + streamer
        self.written, self.recent, self.place = 0, collections.deque(maxlen=TAIL), None
        ini = linuxcnc.ini(self.stat.ini_filename)
        self.letters = (ini.find('TRAJ', 'COORDINATES') or '').replace(' ', '').upper()
        self.period_ns = servo_period_ns()
        self.near = [NEAR * float(ini.find(f'JOINT_{j}', 'MAX_ACCELERATION') or 1) * (1e-9 * self.period_ns) ** 2
                     for j in range(self.joints)]
        self.speeds = [float(ini.find(f'JOINT_{j}', 'MAX_VELOCITY') or 1) for j in range(self.joints)]
        self.taken = False

    def follows(self):
        """Whether the axes follow the rows."""
        return bool(self.component['follows'])

    def facts(self):
        stat, linuxcnc = self.stat, self.linuxcnc
        out = [f'letters={self.letters}', f'on={int(stat.task_state == linuxcnc.STATE_ON)}',
               f'idle={int(stat.interp_state == linuxcnc.INTERP_IDLE and stat.inpos)}',
               f'homed={int(all(stat.homed[:self.joints]))}', f'period_ns={self.period_ns}',
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
        self.write(values)
        self.written += 1

    def write(self, values):
        self.stream.write(values)
        self.recent.append(values)

    def ramp(self, begin, end):
        """Rows over the way that a jog has left, smoothly."""
        for k in range(1, RAMP + 1):
            share = k / RAMP
            weight = share ** 3 * (10 - 15 * share + 6 * share ** 2)
            self.write(end if k == RAMP else tuple(a + (b - a) * weight for a, b in zip(begin, end)))

    def outputs(self):
        self.stat.poll()
        return tuple(self.stat.joint[j]['output'] for j in range(self.joints))

    def take(self):
        """From now on the axes follow the rows; else why not."""
        self.stat.poll()
        if not self.stands_at(self.place) or self.stat.task_state != self.linuxcnc.STATE_ON:
            return 'it does not stand where the program begins any more'
        self.hal.set_p(PLAY + '.fault-in', '0')
        self.hal.set_p(PLAY + '.reset', '0')
        time.sleep(0.003)
        self.hal.set_p(PLAY + '.reset', '1')
        for _ in range(500):
            self.taken = self.follows()
            if self.taken:
                return None
            time.sleep(0.001)
        self.release()
        return 'its component trunnion-play does not answer'

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
        while self.stream.depth > 0 and self.follows():
            time.sleep(0.001)
        time.sleep(0.01)

    def play_to_standstill(self):
        for values in self.plans.rows_behind(list(self.recent), self.axes):
            while not self.stream.writable and self.follows():
                time.sleep(0.001)
            if not self.follows():
                return
            self.write(values)

    def take_over(self):
        """In the place of another one that was killed: the rows go on behind those that it has written."""
        self.recent.extend(Ring(self.ring_key, self.joints).tail())
        self.taken = self.follows()
        self.end(self.wait_still)

    def end(self, before_the_jog=lambda: True):
        """Whoever sent the rows has gone."""
        if not self.taken:
            return
        self.play_to_standstill()
        self.run_dry()
        if not self.follows():
            self.release()
        elif self.recent and not (before_the_jog() and self.give_back(self.recent[-1])):
            print('the axes stay where the last row says; switch the machine off before anything else', file=sys.stderr)

    def trouble(self):
        """Why the axes do not follow the rows any more; nothing while they do."""
        if not self.taken or self.follows():
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
