"""What an operator of LinuxCNC has before him, for scenarios that run as LinuxCNC's user interface."""
import time

import hal
import linuxcnc
import numpy

JOINTS = 5


class Panel:
    """LinuxCNC switched on and homed; the joints' commands of every servo period are recorded."""

    def __init__(self, folder, period_s=1e-3, limits=None):
        self.folder, self.period_s, self.limits = folder, period_s, limits
        self.command, self.stat, self.errors = linuxcnc.command(), linuxcnc.stat(), linuxcnc.error_channel()
        self.said, self.notes, self.recorded, self.programs = [], [], [], 0
        self.component = hal.component('operator-panel')
        self.component.ready()
        self.record = hal.stream(self.component, hal.sampler_base, 'f' * JOINTS + 's')
        time.sleep(0.5)
        self.switch_on()
        self.command.home(-1)
        self.until(lambda: all(self.stat.homed[:JOINTS]))
        self.mode(linuxcnc.MODE_MDI)
        hal.set_p('sampler.0.enable', '1')
        self.until(lambda: len(self.recorded) > 0)

    # --- looking

    def look(self):
        while self.record.readable:
            self.recorded.append(self.record.read())
        self.stat.poll()
        message = self.errors.poll()
        if message:
            self.said.append(str(message[1]))
        return self.stat

    def until(self, what, seconds=60):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.look()
            if what():
                return
            time.sleep(0.005)
        raise AssertionError(f'not within {seconds} s; line {self.stat.motion_line}, state {self.stat.interp_state}, said {self.said}')

    def for_a_while(self, seconds):
        end = time.monotonic() + seconds
        self.until(lambda: time.monotonic() > end, seconds + 1)

    def mark(self):
        """Number of the period that is recorded next."""
        self.look()
        return len(self.recorded)

    def rows(self, begin=0, end=None):
        """Joint positions of these periods."""
        return numpy.array(self.recorded[begin:end], dtype=float).reshape(-1, JOINTS + 1)[:, :JOINTS]

    def lines(self, begin=0, end=None):
        """Program lines of these periods."""
        return numpy.array(self.recorded[begin:end], dtype=float).reshape(-1, JOINTS + 1)[:, JOINTS].astype(int)

    def place(self):
        self.look()
        return numpy.array(self.recorded[-1][:JOINTS])

    def stands(self, periods=20):
        """No joint has moved for so long."""
        last = self.rows(-periods - 1)
        return len(last) > periods and numpy.abs(last - last[0]).max() == 0

    def moves(self):
        return not self.stands(5)

    def until_it_moves(self, seconds=20):
        self.until(self.moves, seconds)

    def until_it_stands(self, seconds=20):
        self.until(self.stands, seconds)

    def idle(self):
        return self.stat.interp_state == linuxcnc.INTERP_IDLE and self.stat.inpos and self.stat.queue == 0 and self.stands()

    def until_idle(self, seconds=100):
        self.until(self.idle, seconds)

    def until_said(self, words, seconds=20):
        self.until(lambda: any(words in said for said in self.said), seconds)

    # --- doing

    def wait_complete(self):
        assert self.command.wait_complete(20) != -1, 'LinuxCNC does not answer'

    def switch_on(self):
        for state in (linuxcnc.STATE_ESTOP_RESET, linuxcnc.STATE_ON):
            self.command.state(state)
            self.wait_complete()

    def switch_off(self):
        self.command.state(linuxcnc.STATE_OFF)
        self.wait_complete()

    def mode(self, which):
        self.command.mode(which)
        self.wait_complete()

    def load(self, text):
        self.programs += 1
        program = self.folder / f'program-{self.programs}.ngc'
        program.write_text(text)
        self.mode(linuxcnc.MODE_AUTO)
        self.command.program_open(str(program))
        self.wait_complete()

    def start(self, text, line=0):
        """Runs a program, from a line on."""
        self.load(text)
        self.command.auto(linuxcnc.AUTO_RUN, line)
        self.until(lambda: self.stat.interp_state != linuxcnc.INTERP_IDLE)

    def run(self, text, seconds=100):
        self.start(text)
        self.until_idle(seconds)

    def until_line(self, number, seconds=60):
        """The motion has come to this line of the program."""
        self.until(lambda: self.stat.motion_line >= number, seconds)

    def pause(self):
        self.command.auto(linuxcnc.AUTO_PAUSE)

    def resume(self):
        self.command.auto(linuxcnc.AUTO_RESUME)

    def step(self):
        self.command.auto(linuxcnc.AUTO_STEP)

    def abort(self):
        self.command.abort()
        self.wait_complete()

    def mdi(self, block, seconds=60):
        self.mode(linuxcnc.MODE_MDI)
        self.command.mdi(block)
        self.command.wait_complete(0.05)
        self.for_a_while(0.05)
        self.until_idle(seconds)

    def jog(self, axis, way, speed):
        """An axis of the world, by an increment."""
        self.mode(linuxcnc.MODE_MANUAL)
        self.command.teleop_enable(1)
        self.wait_complete()
        self.command.jog(linuxcnc.JOG_INCREMENT, False, axis, speed if way > 0 else -speed, abs(way))
        self.until_it_moves()
        self.until_it_stands()

    # --- judging

    def peaks(self, begin=0, end=None):
        """Of velocity, acceleration and jerk, in shares of the limits."""
        out, values = [], self.rows(begin, end)
        for order in range(3):
            values = numpy.diff(values, axis=0) / self.period_s
            out.append(float((numpy.abs(values) / self.limits[:, order]).max()) if len(values) else 0.0)
        return out

    def expect_limits(self, begin=0, end=None):
        self.look()
        peaks = self.peaks(begin, end)
        self.note('peaks ' + ' '.join(f'{peak:.4f}' for peak in peaks))
        assert max(peaks) < 1.001, peaks

    def expect_place(self, place, within=1e-6):
        off = numpy.abs(self.place() - numpy.array(place, dtype=float)).max()
        assert off <= within, (self.place(), place)

    def expect_nothing_said(self):
        assert not self.said, self.said

    def note(self, text):
        self.notes.append(text)
