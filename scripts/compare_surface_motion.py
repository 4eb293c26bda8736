#!/usr/bin/env python3
"""The same passes over a surface three ways: interpolated on the surface itself, as straight moves within 1 µm on our own planner, and
as the same straight moves on the model of LinuxCNC. Prints the table of docs/theory/surface-interpolation.md.

    scripts/compare_surface_motion.py [--trunnion build/release/apps/trunnion/trunnion] [--only NAME…]"""
import argparse
import csv
import json
import pathlib
import subprocess
import tempfile

DOME = """[[surface]]
coefficients_mm = [[[0, 0, 0], [0, 60, 20], [0, 0, -14]], [[80, 0, 12], [0, 0, 0], [0, 0, 0]], [[0, 0, -18], [0, 0, 0], [0, 0, 0]]]
"""
SETUP = """[workpiece]
origin = ["-40 mm", "-30 mm", "-60 mm"]
[tool]
kind = "flat"
diameter = "12 mm"
length = "120 mm"
"""
MACHINE = 'xyzac-trt'
ROOT = pathlib.Path(__file__).resolve().parent.parent
HILLS = ROOT / 'examples/09_surface/hills.toml'

# name, surface (text or file), feed mm/min, options of the passes
CASES = [('dome, flat 12 mm', DOME, 600, []),
         ('dome, flat 12 mm', DOME, 3000, []),
         ('dome, lin-koren', DOME, 600, ['--strategy', 'lin-koren']),
         ('hills, ball 10 mm', HILLS, 600, ['--tool', 'ball 10mm', '--tilt', '20deg', '--scallop', '40um'])]


def run(arguments):
    done = subprocess.run([str(a) for a in arguments], capture_output=True, text=True)
    if done.returncode not in (0, 1):
        raise SystemExit(f"{' '.join(map(str, arguments))}\n{done.stderr}")
    return done.stdout


def peaks(summary):
    axes = summary['axes'].values()
    return [max(axis[key] or 0 for axis in axes) for key in ('velocity_ratio', 'acceleration_ratio', 'jerk_ratio')]


def near_feed(rows, feed, length_mm):
    """Share of the cut, by the way of the tip, at 99 % of the feed or more; and its spread (RMS of feed / programmed − 1) there."""
    at_feed, sum_of_squares, count, before = 0.0, 0.0, 0, None
    with open(rows) as file:
        for row in csv.DictReader(file):
            s, f = float(row['s_mm']), float(row['feed_mm_min'])
            if before is not None and 0.99 * feed <= f <= 1.01 * feed:
                at_feed += s - before
                sum_of_squares += (f / feed - 1) ** 2
                count += 1
            before = s
    return at_feed / length_mm, (sum_of_squares / count) ** 0.5 if count else float('nan')


def table_row(name, feed, how, summary, rows):
    share, spread = near_feed(rows, feed, summary['path_length_mm'])
    velocity, acceleration, jerk = peaks(summary)
    rms = f'{100 * spread:.4f}' if spread == spread else '-'
    print(f"| {name} | {feed} | {how} | {summary['cut_time_s']:.1f} | {velocity:.3f} {acceleration:.3f} {jerk:.3f} | "
          f"{100 * share:.0f} | {rms} |", flush=True)


def compare(trunnion, folder, name, surface, feed, options):
    setup, face = folder / 'setup.toml', folder / 'surface.toml'
    setup.write_text(SETUP if surface is DOME else SETUP.replace('"-40 mm", "-30 mm"', '"-50 mm", "-50 mm"'))
    face.write_text(surface if surface is DOME else surface.read_text())
    shared = ['-m', MACHINE, '--setup', setup]
    passes = ['--feed', f'{feed}mm/min', *options]
    rows, summary, program = folder / 'rows.csv', folder / 'summary.json', folder / 'passes.ngc'
    run([trunnion, 'surface', 'run', face, *shared, *passes, '--feed-of', 'tip', '-o', rows, '--summary', summary, '-q'])
    table_row(name, feed, 'on the surface', json.loads(summary.read_text()), rows)
    run([trunnion, 'surface', 'plan', face, *shared, *passes, '--chord-tolerance', '1um', '-o', program, '-q'])
    run([trunnion, 'plan', program, *shared, '--tip-tolerance', '5um', '-o', rows, '--summary', summary, '-q'])
    table_row(name, feed, 'straight moves, our planner', json.loads(summary.read_text()), rows)
    run([trunnion, 'predict', program, *shared, '-c', 'linuxcnc-2.9', '--samples', rows, '--summary', summary, '-q'])
    table_row(name, feed, 'straight moves, LinuxCNC', json.loads(summary.read_text()), rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--trunnion', default=ROOT / 'build/release/apps/trunnion/trunnion')
    parser.add_argument('--only', nargs='*', help='parts of names')
    args = parser.parse_args()
    print('| surface | feed mm/min | how | cut s | velocity, acceleration, jerk / limit | % of the way at the feed | RMS of it % |')
    print('|---|---|---|---|---|---|---|')
    for case in CASES:
        if not args.only or any(word in case[0] for word in args.only):
            with tempfile.TemporaryDirectory() as folder:
                compare(args.trunnion, pathlib.Path(folder), *case)


if __name__ == '__main__':
    main()
