#!/usr/bin/python3
"""What Python adds: the cost of small calls, and of planning against the command line.

    PYTHONPATH=build/release/python bench/python_overhead.py build/release/apps/trunnion/trunnion [RUNS]

Small calls: the least mean of 500 calls in a row, of 300 such rows. Planning: 60 000 blocks of a wavy surface, both ways by
turns, the least processor time of RUNS (5) runs each. The command line writes .npy; what it takes to start is measured by
`--version` and taken off."""
import pathlib
import resource
import subprocess
import sys
import tempfile
import time
import timeit

import numpy as np

import trunnion

ROOT = pathlib.Path(__file__).resolve().parents[1]
SETUP = ROOT / 'examples/01_first_plan/setup.toml'


def least_us(call, number=500):
    return min(timeit.repeat(call, number=number, repeat=300)) / number * 1e6


def small_calls():
    machine = trunnion.machine('xyzac-trt')
    kinematics = machine.kinematics()
    curve = trunnion.BsplineCurve(3, [0, 0, 0, 0, 1, 1, 1, 1], np.eye(4, 3))
    surface = trunnion.BsplineSurface.polynomial(np.random.default_rng(1).normal(size=(4, 4, 3)))
    program = trunnion.program_from_poses(np.eye(3), [[0, 0, 1]] * 3, feed_mm_min=600)
    stretch = trunnion.stretches(waves(4000), machine, trunnion.setup(SETUP))[0]
    profile, planner = trunnion.plan_stretch(stretch), trunnion.LivePlanner(stretch)
    planner.hold()  # planning is not what is measured
    position, tip, axis, u = np.zeros(5), np.zeros(3), np.array([0.0, 0.6, 0.8]), np.array([0.3])
    for name, call in [('kinematics.forward, 1 pose', lambda: kinematics.forward(position)),
                       ('kinematics.inverse, 1 pose', lambda: kinematics.inverse(tip, axis)),
                       ('curve(u), 1 place', lambda: curve(u)),
                       ('surface(u, v), 1 place', lambda: surface(u, u)),
                       ('program.positions_mm', lambda: program.positions_mm),
                       ('stretch.axes(p), 1 place', lambda: stretch.axes(u)),
                       ('profile.state(t), 1 time', lambda: profile.state(u)),
                       ('planner.tick(), held', planner.tick),
                       ('corner_curve', lambda: trunnion.corner_curve(tip, position[:3] + axis, 2 * axis + u, 0.01))]:
        print(f'{name:<30}{least_us(call):8.2f} µs')


def processor_s(who):
    used = resource.getrusage(who)
    return used.ru_utime + used.ru_stime


def waves(blocks=60_000):
    """Passes over a wavy surface, 0.3 mm between them."""
    x = np.linspace(-40, 40, 400)
    k = np.arange(blocks // len(x))[:, None]
    along = np.where(k % 2 == 0, x, x[::-1])
    tilt = np.radians(15 + 8 * np.sin(along / 9))
    tips = np.stack([along, 0.3 * k + 0 * along, 2 * np.sin(along / 6)], -1).reshape(-1, 3)
    axes = np.stack([0 * tilt, np.sin(tilt), np.cos(tilt)], -1).reshape(-1, 3)
    return trunnion.program_from_poses(tips, axes, feed_mm_min=5000)


def used_by(*command):
    before = processor_s(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return processor_s(resource.RUSAGE_CHILDREN) - before


def by_command_line(program, folder):
    return used_by(sys.argv[1], 'plan', program, '-m', 'xyzac-trt', '--setup', SETUP, '-o', folder / 's.npy', '-q')


def by_python(program):
    before = time.process_time()
    machine, setup = trunnion.machine('xyzac-trt'), trunnion.setup(SETUP)
    trunnion.plan(trunnion.read_program(program, machine=machine), machine, setup)
    return time.process_time() - before


def main():
    small_calls()
    runs = int(sys.argv[2]) if len(sys.argv) > 2 else 5
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        program = folder / 'waves.cls'
        waves().write(program, dialect='apt')
        rows = [(used_by(sys.argv[1], '--version'), by_command_line(program, folder), by_python(program)) for _ in range(runs)]
    start, line, python = (min(column) for column in zip(*rows))
    line -= start
    print(f'plan, command line {line:.3f} s (and {start:.3f} s to start), Python {python:.3f} s: {100 * (python / line - 1):+.1f} %')


main()
