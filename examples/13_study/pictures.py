#!/usr/bin/env python3
"""Where on the table of a machine should the part lie? Prints the reports of a grid and of a search and draws
docs/pictures/study-rim.svg.

    PYTHONPATH=build/release/python /usr/bin/python3 examples/13_study/pictures.py [--output docs/pictures] [--steps 21]

Needs matplotlib and NLopt: `apt-get install python3-matplotlib python3-nlopt`, and then /usr/bin/python3."""
import argparse
import pathlib

import numpy as np
from trunnion.study import Study

ROOT = pathlib.Path(__file__).resolve().parents[2]
REACH = 300  # mm from the middle of the table


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--output', default=ROOT / 'docs/pictures', type=pathlib.Path)
    parser.add_argument('--steps', default=21, type=int)
    arguments = parser.parse_args()
    rim = Study(ROOT / 'examples/05_convert/rim.cls', 'ucp710', ROOT / 'examples/05_convert/setup.toml',
                controller='lavernhe-2006')
    along = np.linspace(-REACH, REACH, arguments.steps)
    table = rim.over(x_mm=along, y_mm=along).run()
    print(table.report())
    table.heat_map('x_mm', 'y_mm', path=arguments.output / 'study-rim.svg')
    print(rim.search(seed=1, x_mm=(-REACH, REACH), y_mm=(-REACH, REACH), rotate_z_deg=(0, 360)).report())


if __name__ == '__main__':
    main()
