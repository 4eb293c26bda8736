#!/usr/bin/python3
"""Whether some matching in order keeps the tolerances where the outside checker found none.

    scripts/least_deviation.py SETPOINTS.csv --checker ../shared/tools/verify_setpoints.py --machine M.toml --setup S.toml
        --programmed P.csv [--tip 0.02] [--angle 0.1]

The outside checker goes to the nearest place from row to row: where a path comes near itself again it may take the later
place too early, or stay on the earlier branch. Here every stretch in which it finds more than the tolerances (mm, degrees)
is matched anew: of all matchings of its rows with the samples of its path, in order and with none left out on either side,
the one whose largest deviation is least (the discrete Fréchet distance, of the larger share of the two tolerances). At both
ends the stretch is held to the places that the outside checker found. Written as JSON: the stretches with their rows, the
line of the program and the shares. Readers of files, kinematics and samples of the path are the outside checker's own."""
import argparse
import importlib.util
import json
import pathlib

import numpy as np

HEIGHT = 30.0  # mm up the tool axis, as the outside checker has it
STEP = 0.005  # mm between samples of the programmed path
MARGIN = 150  # rows to either side of a stretch
AT_ENDS = 40  # samples by which a stretch may begin and end elsewhere than the outside checker says


def load_checker(file):
    spec = importlib.util.spec_from_file_location('outside_checker', file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def motion(checker, args):
    """Rows as (tip, height · tool axis), their lines, and the machine."""
    machine = checker.Machine(args.machine)
    setup = checker.tomllib.loads(pathlib.Path(args.setup).read_text())
    with open(args.setpoints) as file:
        head = next(file).strip().split(',')
        data = np.loadtxt(file, delimiter=',', ndmin=2)
    column = {name: data[:, n] for n, name in enumerate(head)}
    turned = {a: np.pi / 180 if machine.axes[a]['rotary'] else 1 for a in machine.chain}
    axes = {a: column[machine.axes[a]['column']] * turned[a] for a in machine.chain}
    origin = np.array([checker.quantity(x) for x in setup.get('workpiece', {}).get('origin', ['0 mm'] * 3)])
    tip, axis = machine.forward(axes, checker.quantity(setup['tool']['length']), origin, np.eye(3))
    return np.hstack([tip, HEIGHT * axis]), column['line'], machine


def shares(a, b, args):
    """Of the tolerances, the larger one, between points (tip, height · axis)."""
    off = a - b
    tip = np.linalg.norm(off[..., :3], axis=-1) / args.tip
    turn = 2 * np.arcsin(np.minimum(1, np.linalg.norm(off[..., 3:], axis=-1) / (2 * HEIGHT)))
    return np.maximum(tip, np.degrees(turn) / args.angle)


def shares_of_poses(points, line, at, places, args):
    """For the row at every programmed pose the largest share that the outside checker finds there: it looks at 40 rows to
    either side."""
    out = np.zeros(len(points))
    for place, row in zip(at, np.searchsorted(np.maximum.accumulate(places), at)):
        near = points[max(0, row - 40):row + 41]
        chords = np.diff(near, axis=0)
        length2 = np.maximum((chords**2).sum(1), 1e-30)
        along = np.clip(((line[place] - near[:-1]) * chords).sum(1) / length2, 0, 1)
        feet = near[:-1] + along[:, None] * chords
        nearest = feet[((feet - line[place])**2).sum(1).argmin()]
        row = min(row, len(points) - 1)
        out[row] = max(out[row], shares(nearest, line[place], args))
    return out


def stretches(bad):
    """First and last of rows that are no more than two margins apart."""
    if len(bad) == 0:
        return []
    parts = np.split(bad, np.nonzero(np.diff(bad) > 2 * MARGIN)[0] + 1)
    return [(int(p[0]), int(p[-1])) for p in parts]


def next_row(before, here):
    """Least largest share up to every sample of the path, one row on: each pair comes from the pair before in the rows, in
    the path, or in both."""
    through_rows = np.minimum(before, np.concatenate(([np.inf], before[:-1])))
    out, last = [], np.inf
    for come, share in zip(through_rows.tolist(), here.tolist()):
        last = max(share, min(come, last))
        out.append(last)
    return np.array(out)


def filled(points):
    """The chords between rows in parts no longer than the samples of the path are apart."""
    out = [points[:1]]
    for a, b in zip(points[:-1], points[1:]):
        parts = max(1, int(np.ceil(np.linalg.norm(b - a) / STEP)))
        out.append(a + np.arange(1, parts + 1)[:, None] / parts * (b - a))
    return np.vstack(out)


def least_share(points, line, args):
    """The line begins and ends AT_ENDS samples before and after the places that the first and last point may have."""
    reached = np.where(np.arange(len(line)) <= 2 * AT_ENDS, 0.0, np.inf)
    for point in filled(points):
        reached = next_row(reached, shares(point, line, args))
    return float(reached[-2 * AT_ENDS:].min())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('setpoints')
    for name in ('checker', 'machine', 'setup', 'programmed'):
        parser.add_argument(f'--{name}', required=True)
    parser.add_argument('--tip', type=float, default=0.02)
    parser.add_argument('--angle', type=float, default=0.1)
    args = parser.parse_args()
    checker = load_checker(args.checker)
    points, lines, machine = motion(checker, args)
    poses, kinds, words = checker.read_programmed(args.programmed)
    line, at = checker.densify(poses, kinds, words, machine, np.eye(3), STEP, HEIGHT)
    found, fraction = checker.follow(points, line, STEP)
    wanted = line[found] + fraction[:, None] * (line[np.minimum(found + 1, len(line) - 1)] - line[found])
    share = np.maximum(shares(points, wanted, args), shares_of_poses(points, line, at, found + fraction, args))
    out = []
    for first, last in stretches(np.nonzero(share > 1.005)[0]):
        low, high = max(0, first - MARGIN), min(len(points) - 1, last + MARGIN)
        begin, end = max(0, found[low] - AT_ENDS), min(len(line), found[high] + AT_ENDS)
        out.append({'rows': [first, last], 'line': int(lines[first]), 'share': float(share[first:last + 1].max()),
                    'least_share': least_share(points[low:high + 1], line[begin:end], args)})
    print(json.dumps({'stretches': out, 'largest_elsewhere': float(share[share <= 1.005].max(initial=0))}))


if __name__ == '__main__':
    main()
