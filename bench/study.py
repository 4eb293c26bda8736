#!/usr/bin/python3
"""A study of 1000 set-ups of a program of 1000 blocks, by each kind of control: processor time of all threads together.

    PYTHONPATH=build/release/python bench/study.py [CONTROL…]
"""
import pathlib
import sys
import tempfile
import time

import numpy as np

import trunnion
from trunnion.study import Study

SETUP = pathlib.Path(__file__).resolve().parents[1] / 'examples/01_first_plan/setup.toml'


def waves(passes=10, points=100):
    """Passes over a wavy surface, 0.8 mm from pose to pose."""
    x = np.linspace(-40, 40, points)
    k = np.arange(passes)[:, None]
    along = np.where(k % 2 == 0, x, x[::-1])
    tilt = np.radians(15 + 8 * np.sin(along / 9))
    tips = np.stack([along, 0.3 * k + 0 * along, 2 * np.sin(along / 6)], -1).reshape(-1, 3)
    return trunnion.program_from_poses(tips, np.stack([0 * tilt, np.sin(tilt), np.cos(tilt)], -1).reshape(-1, 3), feed_mm_min=3000)


def main():
    with tempfile.TemporaryDirectory() as folder:
        program, machine = pathlib.Path(folder) / 'waves.ngc', trunnion.machine('xyzac-trt')
        waves().translate(machine, trunnion.setup(SETUP), law='rotary', precision_deg=1).write(program, dialect='rs274', machine=machine)
        print(f'{len(trunnion.read_program(program, machine=machine))} moves')
        for control in sys.argv[1:] or ['length-over-feed', 'linuxcnc-2.9', 'lavernhe-2006', 'ideal']:
            cases = Study(program, 'xyzac-trt', SETUP, controller=control).over(x_mm=np.linspace(-20, 20, 25), y_mm=np.linspace(-20, 20, 40))
            begin, used = time.perf_counter(), time.process_time()
            table = cases.run(threads=2)
            print(f'{control:<18}{time.process_time() - used:8.1f} s of processors, {time.perf_counter() - begin:6.1f} s gone; '
                  + table.report().splitlines()[0], flush=True)


main()
