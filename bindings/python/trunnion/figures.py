"""The figures of the four papers that Trunnion implements, drawn by it.

    python -m trunnion.figures --list
    python -m trunnion.figures [NAME…] -o DIR

writes every figure that the papers' text allows as PNG and SVG, and tells our numbers beside the published ones. Needs
matplotlib. What stands in for a part that a paper does not give is named so in the picture; docs/figures.md has the list.
"""
import argparse
import pathlib
import sys

from . import _figures_affouard, _figures_beudaert, _figures_beudaert_motion, _figures_lavernhe, _figures_lin_koren
from ._error import Error
from ._figures_drawing import declared, write

FIGURES = {name: one for module in (_figures_beudaert, _figures_beudaert_motion, _figures_affouard, _figures_lin_koren,
                                    _figures_lavernhe)
           for name, one in declared(vars(module)).items()}


def numbers_of(name):
    """The numbers of a figure without a file: {name: (ours, published or None)}."""
    return FIGURES[name].drawn()[1]


def table(numbers):
    """Numbers as lines of text, the published one behind ours."""
    width = max(map(len, numbers))
    return [f'  {name:{width}}  {ours:.6g}' + ('' if published is None else f'  (published {published:g})')
            for name, (ours, published) in numbers.items()]


def listed():
    width = max(map(len, FIGURES))
    return [f'{one.name:{width}}  {one.paper}, {one.number}: {one.title} [{one.kind}]' for one in FIGURES.values()]


def arguments(given):
    parser = argparse.ArgumentParser(prog='python -m trunnion.figures', description='Draws the figures of the papers.')
    parser.add_argument('names', nargs='*', metavar='NAME', help='which ones; all of them if none is named')
    parser.add_argument('-o', '--output', type=pathlib.Path, metavar='DIR', help='where PNG and SVG go')
    parser.add_argument('--list', action='store_true', help='tells names, papers and numbers of the figures')
    chosen = parser.parse_args(given)
    unknown = [name for name in chosen.names if name not in FIGURES]
    if unknown:
        parser.error(f'no such figure: {", ".join(unknown)}; --list has the names')
    if not chosen.list and chosen.output is None:
        parser.error('-o DIR is missing')
    return chosen


def main(given=None):
    chosen = arguments(given)
    if chosen.list:
        print('\n'.join(listed()))
        return 0
    chosen.output.mkdir(parents=True, exist_ok=True)
    for name in chosen.names or FIGURES:
        numbers = write(FIGURES[name], chosen.output)
        print('\n'.join([f'{chosen.output / name}.svg', *table(numbers)]))
    return 0


if __name__ == '__main__':
    try:
        sys.exit(main())
    except ImportError as error:
        sys.exit(f'{error}; figures need matplotlib: apt-get install python3-matplotlib')
    except Error as error:
        sys.exit(str(error))
