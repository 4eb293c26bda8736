"""Scenarios of serve_linuxcnc.py: each is a function of the operator's panel that looks at what comes of it."""
import subprocess
import time
import types

try:  # inside LinuxCNC
    import hal
    import linuxcnc
    import numpy
except ImportError:  # where they are only listed
    pass

SCENARIOS = {}


def scenario(function=None, *, machine='peer-trunnion', period_s=1e-3, hal=''):
    """On this machine, with more lines of HAL."""
    def add(what):
        SCENARIOS[what.__name__] = types.SimpleNamespace(machine=machine, period_s=period_s, hal=hal)
        return what
    return add(function) if function else add


HEAD = 'G21 G90 G94 G17 G64 P0.02\n'
MIXED = HEAD + '''G0 X10 Y5 Z3 A0 C0
S1000 M3
G1 X30 A5 F3000
G2 X40 Y15 I0 J10
G3 X50 Y25 I10 J0 A10 C20
G4 P0.2
M5
G61
G1 X20 Y20
X0 Y0 C0
G64 P0.05
G93
G1 X10 A0 F120
G1 X20 C10 F120
G94 F2000
G18
G2 X30 Z3 I5 K0
G17
G0 X0 Y0 Z0 A0 C0
M2
'''
ZIGZAG = HEAD + 'F12000\n' + ''.join(f'G1 X{10 + k % 2 * 40} Y{k} A{k % 2 * 8} C{k}\n' for k in range(30)) + 'M2\n'
PROBE = '''loadrt comp count=1
addf comp.0 servo-thread
setp comp.0.in1 -3
net position-2 => comp.0.in0
net touches comp.0.out => motion.probe-input
'''  # true where Z is below -3


def sine(panel, blocks=2500):
    """The first blocks of sine-10k."""
    lines = (panel.folder / 'sine-10k.ngc').read_text().replace('G54\n', 'G54 G64 P0.01\n', 1).splitlines()
    return '\n'.join(lines[:blocks] + ['M2', ''])


def end_of(text):
    """Where a program of lines with all five words ends."""
    words = {word[0]: float(word[1:]) for line in text.splitlines() if line.startswith('G1') for word in line.split()[1:]}
    return [words[letter] for letter in 'XYZAC']


def standstills(panel, begin, end=None):
    """Times, s, for which all joints stood between the first movement and the last."""
    moves = numpy.nonzero(numpy.abs(numpy.diff(panel.rows(begin, end), axis=0)).max(1) > 0)[0]
    gaps = numpy.diff(moves) - 1
    return [float(gap) * panel.period_s for gap in gaps if gap > 0]


def time_to_stand(panel, begin):
    """From a mark on to the standstill that holds, s."""
    panel.until_it_stands()
    moves = numpy.nonzero(numpy.abs(numpy.diff(panel.rows(begin), axis=0)).max(1) > 0)[0]
    return float(moves[-1] + 1) * panel.period_s if len(moves) else 0.0


# --- programs

@scenario
def words_of_every_kind(panel):
    panel.run(MIXED)
    panel.expect_place([0] * 5, 1e-9)
    panel.expect_limits()
    panel.expect_nothing_said()


@scenario(period_s=250e-6)
def period_of_250_us(panel):
    panel.run(MIXED)
    panel.expect_place([0] * 5, 1e-9)
    begin = panel.mark()
    panel.run(sine(panel))
    panel.note(f'standstills {standstills(panel, begin)}')
    panel.expect_limits()
    panel.expect_nothing_said()


@scenario(machine='xyzbc-trt')
def table_with_b(panel):
    begin = panel.mark()
    panel.run(HEAD + 'G0 X5 Y5 Z-5\nF1200\n' + ''.join(f'G1 X{10 + k % 2 * 30} Y{k} B{-20 + k % 2 * 8} C{k}\n' for k in range(40)) +
              'G2 X20 Y45 I-10 J3\nG0 X0 Y0 Z0 B0 C0\nM2\n')
    panel.expect_place([0] * 5, 1e-9)
    panel.expect_limits(begin)
    panel.expect_nothing_said()


@scenario
def from_a_line(panel):
    """LinuxCNC reads what comes before without moving."""
    text = HEAD + 'F3000\n' + ''.join(f'G1 X{5 * k} Y{k % 2 * 10} Z0 A{k} C0\n' for k in range(1, 21)) + 'M2\n'
    begin = panel.mark()
    panel.start(text, 12)
    panel.until_idle()
    lines = panel.lines(begin)
    assert lines[lines > 0].min() >= 12, lines[lines > 0].min()
    panel.expect_limits(begin)
    panel.expect_nothing_said()


@scenario
def exact_stops(panel):
    """G61 and G61.1 stand in the corner, G64 P passes it within P, and uses it."""
    def nearest(mode, feed):
        begin = panel.mark()
        panel.run(f'G21 G90 G94 {mode}\nG1 X20 Y0 Z0 F{feed}\nG1 X20 Y20\nG1 X0 Y0\nM2\n')
        return float(numpy.linalg.norm(panel.rows(begin)[:, :2] - [20, 0], axis=1).min())

    for mode in ('G61', 'G61.1'):
        off = nearest(mode, 3000)
        assert off < 1e-6, (mode, off)
    for tolerance in (0.02, 0.2):
        off = nearest(f'G64 P{tolerance}', 6000)
        panel.note(f'P{tolerance}: {off:.4f} mm off')
        assert 0.3 * tolerance < off <= tolerance, off
    panel.expect_limits()
    panel.expect_nothing_said()


@scenario
def tool_length(panel):
    """G43 and G49 between moves: limits are those of the axes with the new length."""
    panel.run(HEAD + 'G0 X20 Y10\nG43.1 Z80\nF9000\nG1 A20 C40\nG1 X40 Y30 A-20 C0\nG1 X20 Y0 A0\nG49\nG1 A20 C30\nG1 X0 A0 C0\nM2\n')
    panel.expect_limits()
    panel.expect_nothing_said()


# --- the operator

@scenario
def pause_and_resume(panel):
    text = sine(panel)
    panel.start(text)
    for line in (400, 1100, 1800):
        panel.until_line(line)
        begin = panel.mark()
        panel.pause()
        took = time_to_stand(panel, begin)
        panel.note(f'stood {took:.3f} s after the command')
        assert took < 1.5, took
        stood = panel.mark()
        panel.for_a_while(0.5)
        assert numpy.ptp(panel.rows(stood), axis=0).max() == 0, 'it moves while paused'
        panel.resume()
        panel.until_it_moves()
    panel.until_idle()
    panel.expect_place(ends(panel, text), 1e-6)
    panel.expect_limits()
    panel.expect_nothing_said()


def ends(panel, text):
    """Joints at the end of a program: it is run once more, from there on nothing may move."""
    last = panel.place()
    panel.run(text)
    assert numpy.abs(panel.place() - last).max() < 1e-6, (panel.place(), last)
    return last


@scenario
def override(panel):
    text = HEAD + 'F1200\n' + ''.join(f'G1 X{k % 2 * 20} Y{k} A{k % 2 * 3}\n' for k in range(1, 9)) + 'M2\n'
    begin = panel.mark()
    panel.run(text)
    middle = panel.mark()
    panel.start(text)
    panel.until_line(6)
    panel.command.feedrate(0.25)
    panel.until_idle()
    whole, slow = middle - begin, panel.mark() - middle
    panel.note(f'{whole} periods at 1, {slow} at 0.25')
    assert slow > 2 * whole, (slow, whole)
    panel.command.feedrate(1)
    panel.for_a_while(0.3)
    panel.expect_limits()
    panel.expect_nothing_said()


@scenario
def override_of_zero(panel):
    text = sine(panel)
    panel.start(text)
    for line in (500, 1500):
        panel.until_line(line)
        begin = panel.mark()
        panel.command.feedrate(0)
        took = time_to_stand(panel, begin)
        panel.note(f'stood {took:.3f} s after the command')
        assert took < 1.5, took
        panel.for_a_while(0.5)
        assert panel.stands(300)
        panel.command.feedrate(1)
        panel.until_it_moves()
    panel.until_idle()
    panel.expect_limits()
    panel.expect_nothing_said()


@scenario
def rapid_override(panel):
    def seconds(scale):
        panel.command.rapidrate(scale)
        panel.for_a_while(0.3)
        begin = panel.mark()
        panel.run('G21 G90\nG0 X100 Y50\nG0 X0 Y0\nM2\n')
        moves = numpy.nonzero(numpy.abs(numpy.diff(panel.rows(begin), axis=0)).max(1) > 0)[0]
        return (moves[-1] - moves[0]) * panel.period_s

    whole, slow = seconds(1), seconds(0.1)
    panel.note(f'{whole:.2f} s, at a tenth {slow:.2f} s')
    assert slow > 1.5 * whole
    panel.expect_limits()


@scenario
def largest_velocity(panel):
    """The slider of the largest velocity: it counts for what is under way, is given back, and holds for rapids too."""
    def speeds(begin, end=None):
        return numpy.linalg.norm(numpy.diff(panel.rows(begin, end)[:, :3], axis=0), axis=1) / panel.period_s

    panel.start(HEAD + 'F4800\n' + ''.join(f'G1 X{k % 2 * 300} Y{5 * k}\n' for k in range(1, 9)) + 'G0 X0 Y0\nM2\n')
    panel.until_line(4)
    for largest in (30, 10, 60):
        before = float(speeds(panel.mark() - 30).max())
        begin = panel.mark()
        panel.command.maxvel(largest)
        panel.for_a_while(1.5)
        measured = speeds(begin)
        late = numpy.nonzero(measured > largest * 1.001)[0]
        reached = (late[-1] + 1 if len(late) else numpy.nonzero(measured > 0.99 * largest)[0][0]) * panel.period_s
        panel.note(f'{before:.1f} to {largest} mm/s: {reached:.3f} s after the command, then at most {measured[-500:].max():.3f}')
        assert reached < 0.7 and 0.99 * largest < measured[-500:].max() < 1.001 * largest, measured[-500:].max()
    panel.command.feedrate(1.2)
    panel.for_a_while(0.5)
    begin = panel.mark()
    panel.until_idle()
    assert 59 < speeds(begin).max() < 60.1, speeds(begin).max()
    panel.command.maxvel(0)
    begin = panel.mark()
    panel.start('G21 G90 G94\nG1 X20 F600\nM2\n')
    panel.for_a_while(1)
    assert speeds(begin).max() == 0
    panel.command.maxvel(1000)
    panel.command.feedrate(1)
    panel.until_idle()
    panel.expect_place([20, 0, 0, 0, 0], 1e-9)
    panel.expect_limits()
    panel.expect_nothing_said()


@scenario
def abort_and_go_on(panel):
    panel.start(sine(panel))
    panel.until_line(800)
    begin = panel.mark()
    panel.abort()
    took = time_to_stand(panel, begin)
    panel.note(f'stood {took:.3f} s after the command')
    assert took < 1.5, took
    panel.until_idle()
    panel.mdi('G1 X10 Y0 Z0 A0 C0 F3000')
    panel.mdi('G0 X0')
    panel.expect_place([0] * 5, 1e-9)
    panel.expect_limits()
    panel.expect_nothing_said()


@scenario
def mdi_and_jog_between(panel):
    panel.run(ZIGZAG)
    panel.mdi('G1 X0 Y0 Z5 A0 C0 F3000')
    panel.expect_limits()
    panel.expect_place([0, 0, 5, 0, 0], 1e-9)
    panel.jog(0, 7.5, 20)
    panel.jog(3, -4, 10)
    begin = panel.mark()
    jogged = panel.place()
    panel.mode(linuxcnc.MODE_MDI)
    panel.expect_place(jogged, 1e-9)
    panel.mdi('G1 Y3 F1000')
    panel.run(ZIGZAG)
    panel.mdi('G0 X0 Y0 Z0 A0 C0')
    panel.expect_place([0] * 5, 1e-9)
    panel.expect_limits(begin)
    panel.expect_nothing_said()


CORNERS = HEAD + 'F3000\n' + ''.join(f'G1 X{20 * (k % 2)} Y{4 * k} A{3 * (k % 2)} C{2 * k}\n' for k in range(1, 9)) + (
    'G3 X0 Y52 I0 J10 A0 C0\nG0 X20\nG1 X0 Y0\nM2\n')


def off_corner(panel, line):
    """How far LinuxCNC's commanded place is from the end of a line of CORNERS, mm or degrees."""
    at = dict(zip('XYZABC', panel.look().position))
    words = CORNERS.splitlines()[line - 1].split()[1:]
    return max(abs(at[word[0]] - float(word[1:])) for word in words if word[0] in at)


def step_and_stand(panel):
    """Whether it moved."""
    begin = panel.mark()
    panel.step()
    panel.for_a_while(0.4)
    panel.until_it_stands()
    panel.for_a_while(0.2)
    assert panel.stands(100)
    return bool(numpy.ptp(panel.rows(begin), axis=0).max() > 0)


@scenario
def begun_by_a_step(panel):
    """LinuxCNC hands over a line a step: each is moved to its end, and no farther."""
    panel.load(CORNERS)
    lines = []
    for _ in range(20):
        if step_and_stand(panel):
            lines.append(lines[-1] + 1 if lines else panel.stat.motion_line)
            assert off_corner(panel, lines[-1]) < 1e-9, (lines, panel.stat.position)
        if panel.idle():
            break
    assert panel.idle() and lines == list(range(3, 14)), (lines, panel.stat.interp_state)
    panel.expect_place([0] * 5, 1e-9)
    panel.expect_limits()
    panel.expect_nothing_said()


@scenario
def runs_on_behind_steps(panel):
    """A program that is begun by steps, and that LinuxCNC has not read to its end when it is let go."""
    text = sine(panel)
    panel.load(text)
    moved = [step_and_stand(panel) for _ in range(8)]
    panel.note(f'moved in {moved}')
    assert sum(moved) >= 3
    panel.resume()
    panel.until_it_moves()
    panel.until_idle()
    panel.expect_place(ends(panel, text), 1e-6)
    panel.expect_limits()
    panel.expect_nothing_said()


@scenario
def pause_and_step(panel):
    """Behind a pause every step goes to the end of a move, on the path with its corners rounded; then the program runs on."""
    panel.start(CORNERS)
    panel.until_line(5)
    panel.pause()
    panel.until_it_stands()
    first = panel.stat.motion_line
    for line in range(first, 13):
        assert step_and_stand(panel)
        panel.note(f'line {line}: {off_corner(panel, line):.4f} mm off')
        assert off_corner(panel, line) <= 0.02, (line, panel.stat.position)
    panel.resume()
    panel.until_idle()
    panel.expect_place([0] * 5, 1e-9)
    panel.expect_limits()
    panel.expect_nothing_said()


@scenario
def steps_in_dense_blocks(panel):
    text = sine(panel)
    panel.start(text)
    panel.until_line(800)
    panel.pause()
    panel.until_it_stands()
    line = panel.stat.motion_line
    for k in range(1, 6):
        assert step_and_stand(panel)
        assert panel.stat.motion_line == line + k, (panel.stat.motion_line, line)
    begin = panel.mark()
    panel.resume()
    panel.until_it_moves()
    panel.until_idle()
    gaps = standstills(panel, begin)
    panel.note(f'standstills after it ran on {gaps}')
    assert not gaps
    panel.expect_place(ends(panel, text), 1e-6)
    panel.expect_limits()
    panel.expect_nothing_said()


@scenario
def abort_in_a_step(panel):
    for begun in (False, True):
        if begun:
            panel.start(CORNERS)
            panel.until_line(5)
            panel.pause()
            panel.until_it_stands()
        else:
            panel.load(CORNERS)
            while not step_and_stand(panel):
                pass
        panel.step()
        panel.until_it_moves()
        begin = panel.mark()
        panel.abort()
        took = time_to_stand(panel, begin)
        panel.note(f'stood {took:.3f} s after the command')
        assert took < 1.5, took
        panel.until_idle()
        panel.mdi('G1 X0 Y0 Z0 A0 C0 F3000')
        panel.expect_place([0] * 5, 1e-9)
    panel.run(CORNERS)
    panel.expect_place([0] * 5, 1e-9)
    panel.expect_limits()
    panel.expect_nothing_said()


@scenario
def stops_of_the_program(panel):
    """M0, M1 with and without the operator's switch, M60."""
    text = HEAD + 'F3000\nG1 X10\nM0\nG1 X20\nM1\nG1 X30\nM60\nG1 X0\nM2\n'
    for optional in (True, False):
        panel.command.set_optional_stop(optional)
        panel.for_a_while(0.2)
        panel.start(text)
        for place in (10, 20, 30) if optional else (10, 30):
            panel.until(lambda: panel.stat.interp_state == linuxcnc.INTERP_PAUSED and panel.stands())
            panel.expect_place([place, 0, 0, 0, 0], 1e-9)
            panel.resume()
        panel.until_idle()
        panel.expect_place([0] * 5, 1e-9)
    panel.expect_limits()
    panel.expect_nothing_said()


@scenario
def spindle_at_speed(panel):
    hal.set_p('spindle.0.at-speed', '0')
    panel.start(HEAD + 'G0 X5\nS1000 M3\nG1 X20 F3000\nG1 Y10\nG0 X0 Y0\nM5\nM2\n')
    panel.for_a_while(2)
    panel.expect_place([5, 0, 0, 0, 0], 1e-9)
    hal.set_p('spindle.0.at-speed', '1')
    panel.until_idle()
    panel.expect_place([0] * 5, 1e-9)
    panel.expect_limits()
    panel.expect_nothing_said()


@scenario
def outputs_with_motion(panel):
    """M62 and M63 count when the next move begins."""
    pin = 'motion.digital-out-00'
    panel.start(HEAD + 'F600\nG1 X5\nM62 P0\nG1 X10\nG1 X15\nM63 P0\nG1 X20\nM2\n')
    seen = {True: [], False: []}
    while not panel.idle():
        panel.look()
        seen[bool(hal.get_value(pin))].append(panel.recorded[-1][0])
        time.sleep(0.002)
    panel.note(f'on from X{min(seen[True]):.2f} to X{max(seen[True]):.2f}')
    assert 4.5 < min(seen[True]) < 6 and 14.5 < max(seen[True]) < 16
    panel.expect_nothing_said()


# --- probing

@scenario(hal=PROBE)
def probing(panel):
    for feed in (60, 600):
        panel.mdi('G0 Z0')
        panel.mode(linuxcnc.MODE_MDI)
        begin = panel.mark()
        panel.mdi(f'G38.2 Z-20 F{feed}')
        assert panel.stat.probe_tripped
        probed, lowest = panel.stat.probed_position[2], float(panel.rows(begin)[:, 2].min())
        panel.note(f'F{feed}: touched at {probed:.4f}, went to {lowest:.4f}')
        assert -3 - 3 * feed / 60 * panel.period_s < probed <= -3, probed
        assert lowest > -3 - feed / 60 * 0.5, lowest  # half a second
        panel.mdi('G38.4 Z10 F60')
        assert panel.stat.probe_tripped
        panel.until_idle()
    panel.expect_limits()
    panel.expect_nothing_said()


@scenario
def probing_without_touch(panel):
    panel.mdi('G38.3 Z-5 F600')
    assert not panel.stat.probe_tripped and not panel.said
    panel.expect_place([0, 0, -5, 0, 0], 1e-9)
    panel.mdi('G38.2 Z-10 F600')
    panel.until_said('without making contact')
    panel.expect_place([0, 0, -10, 0, 0], 1e-9)
    panel.abort()
    panel.mdi('G0 Z0')
    panel.expect_place([0] * 5, 1e-9)
    panel.expect_limits()


# --- what goes wrong

@scenario
def kill_the_planner(panel):
    """The last plan ends at a standstill inside all limits; the operator is told, and goes on with another planner."""
    panel.start(sine(panel))
    panel.until_line(800)
    planner = subprocess.run(['pgrep', '-u', 'lcnc', '-x', 'trunnion'], capture_output=True, text=True, check=True).stdout.split()
    begin = panel.mark()
    subprocess.run(['kill', '-9', *planner], check=True)
    took = time_to_stand(panel, begin)
    panel.note(f'stood {took:.3f} s later')
    assert took < 8, took
    panel.until_said('no answer')
    panel.abort()
    panel.until_idle()
    stood = panel.place()
    with subprocess.Popen(panel.trunnion, stderr=subprocess.DEVNULL) as again:
        panel.for_a_while(1)
        panel.expect_place(stood, 0)
        panel.mdi('G1 X10 Y0 Z0 A0 C0 F3000')
        panel.expect_place([10, 0, 0, 0, 0], 1e-9)
        again.terminate()
    panel.expect_limits()


@scenario
def switched_off_under_way(panel):
    """LinuxCNC stops the joints at once, as it does by itself; then it goes on from there."""
    panel.start(sine(panel))
    panel.until_line(800)
    panel.switch_off()
    panel.until_it_stands()
    begin = panel.mark()
    stood = panel.place()
    panel.for_a_while(1)
    panel.switch_on()
    panel.for_a_while(0.5)
    panel.expect_place(stood, 1e-9)
    panel.mdi('G1 X10 Y0 Z0 A0 C0 F3000')
    panel.run(ZIGZAG)
    panel.mdi('G0 X0 Y0 Z0 A0 C0')
    panel.expect_place([0] * 5, 1e-9)
    panel.expect_limits(begin)


@scenario
def spindle_synchronised(panel):
    """Refused: nothing moves, and the operator is told."""
    for block, words in (('G33 Z-5 K1', 'synchronised with the spindle'), ('G33.1 Z-5 K1', 'rigid tapping'),
                         ('G95 G1 Z-5 F0.1', 'synchronised with the spindle')):
        panel.said.clear()
        panel.mdi('S100 M3')
        place = panel.place()
        panel.command.mdi(block)
        panel.until_said(words)
        panel.for_a_while(0.5)
        panel.expect_place(place, 0)
        panel.abort()
        panel.mdi('G94 F1000')
        panel.mdi(f'G1 X{panel.place()[0] + 1}')
    panel.expect_place([3, 0, 0, 0, 0], 1e-9)
    panel.expect_limits()


@scenario
def out_of_range_between(panel):
    """Both ends of a turn are inside the ranges, its middle is not: only a planner that knows the joints sees that."""
    panel.mdi('G1 X990 Y-200 F30000')
    place = panel.place()
    panel.mode(linuxcnc.MODE_MDI)
    panel.command.mdi('G1 C180 F3000')
    panel.until_said('axis X leaves its range')
    panel.note(panel.said[-1])
    panel.until_it_stands()
    panel.expect_place(place, 0)
    panel.abort()
    panel.mdi('G1 X0 Y0 F30000')
    panel.expect_place([0] * 5, 1e-9)
    panel.expect_limits()
