"""One set-up of a study: what another process needs to know of it, and the row that it comes to."""
import functools
import math
import pathlib
import tomllib
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import trunnion

from ._error import Error

PLACE = ('x_mm', 'y_mm', 'z_mm', 'rotate_x_deg', 'rotate_y_deg', 'rotate_z_deg')
NUMBERS = ('tip_tolerance_mm', 'orientation_tolerance_deg', 'flank_tolerance_mm', 'flank_height_mm', 'calm',
           'jerk_margin', 'period_s', 'feed_override', 'feed_mm_min', 'chord_error_mm', 'tip_acceleration_mm_s2',
           'tip_jerk_mm_s3', 'tool_turn_deg_s', 'contact_tilt_deg')
WORDS = ('rounding', 'corners', 'link')
RATIOS = ('velocity_ratio', 'acceleration_ratio', 'jerk_ratio')


def refuse(code, text, **fields):
    raise Error(trunnion.Diagnostic(code, text, **fields))


def need_count(value, name):
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
        refuse('PY0001', f'{name}: a whole number wanted', value=repr(value))
    if value < 1:
        refuse('PY0003', f'{name}: not above 0', value=str(value))


@dataclass(frozen=True)
class File:
    """A file as it was when the study was made: what is kept of it is read again when it changes."""
    path: str
    modified_ns: int
    size: int

    @classmethod
    def of(cls, path, name):
        path = pathlib.Path(path).absolute()
        try:
            state = path.stat()
        except OSError as error:
            refuse('PY0003', f'{name}: no such file', value=str(path), hint=error.strerror)
        return cls(str(path), state.st_mtime_ns, state.st_size)


@dataclass(frozen=True)
class Kept:
    """What every set-up of a study has in common, as far as it can go to another process."""
    program: Any            # a File, a function that gives a Program, or a Program
    machine: str            # keys as TOML, or the name of a shipped one
    machine_is_text: bool
    setup: str              # keys as TOML
    reading: tuple = ()     # options of read_program()


@functools.lru_cache(maxsize=8)
def machine_of(kept):
    if kept.machine_is_text:
        return trunnion._core.read_machine_text(kept.machine, 'machine')
    return trunnion.machine(kept.machine)


@functools.lru_cache(maxsize=16)
def program_of(kept, made_with):
    """`made_with`: what the function that makes the program is given, as sorted pairs."""
    if isinstance(kept.program, trunnion.Program):
        return kept.program
    if isinstance(kept.program, File):
        return trunnion.read_program(kept.program.path, machine=machine_of(kept), **dict(kept.reading))
    return kept.program(**dict(made_with))


def axis_and_angle(rotation):
    """A rotation matrix as a unit vector and rad, 0 to π."""
    axis = np.linalg.svd(rotation - np.eye(3))[2][2]
    odd = np.array([rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]])
    angle = math.atan2(axis @ odd, np.trace(rotation) - 1)
    return (axis, angle) if angle >= 0 else (-axis, -angle)


def turn(axis, degrees):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    out = np.eye(3)
    out[i, i], out[i, j], out[j, i], out[j, j] = c, -s, s, c
    return out


@functools.lru_cache(maxsize=64)
def base_setup(text):
    return tomllib.loads(text), trunnion._core.read_setup_text(text, 'setup')


def placed_setup(text, values):
    """The setup with the part where `values` say: program zero, and turns about X, then Y, then Z of the machine."""
    keys, base = base_setup(text)
    if not any(name in values for name in PLACE):
        return base
    origin = [values.get(f'{letter}_mm', at) for letter, at in zip('xyz', base.origin_mm.tolist())]
    rotation = base.rotation
    for axis, letter in enumerate('xyz'):
        rotation = turn(axis, values.get(f'rotate_{letter}_deg', 0.0)) @ rotation
    axis, angle = axis_and_angle(rotation)
    frame = {'origin': [f'{at!r} mm' for at in map(float, origin)],
             'rotation': {'axis': axis.tolist(), 'angle': f'{math.degrees(angle)!r} deg'}}
    return trunnion.setup({**keys, 'workpiece': frame})


def programmed_feeds(program, values):
    """mm/min of the tip by line, where a line says one; how much the control is told to change them is in `values`."""
    moves = program.moves
    moves = moves[(moves['kind'] == 1) & (moves['feed_rule'] == 1)]
    feeds = np.full(len(moves), values['feed_mm_min']) if values.get('feed_mm_min') else moves['feed'] * 60
    lines, first = np.unique(moves['line'], return_index=True)
    return lines, feeds[first] * values.get('feed_override', 1.0)


def feed_loss(prediction, point, lines, feeds):
    """1 − ∫ min(feed of the point, F) dt / ∫ F dt over moves with a programmed feed F; NaN where it is not known."""
    column = prediction.columns.index
    rows = prediction.samples[:, [column('t_s'), column('line'), column(point)]]
    if not len(lines) or len(rows) < 2:
        return math.nan
    at = np.minimum(np.searchsorted(lines, rows[1:, 1]), len(lines) - 1)
    feed = np.where(lines[at] == rows[1:, 1], feeds[at], 0.0)
    step = np.diff(rows[:, 0])
    wanted = (feed * step).sum()
    if wanted <= 0:
        return math.nan
    made = 0.5 * (np.minimum(rows[1:, 2], feed) + np.minimum(rows[:-1, 2], feed)) * step
    return float(1 - made[feed > 0].sum() / wanted)


@dataclass
class Row:
    """What one set-up came to; `refused`: the code, else empty."""
    index: int
    code: str = ''
    text: str = ''
    line: int = 0
    numbers: dict = field(default_factory=dict)


def predict_row(kept, index, values):
    """Predicts one set-up. A refusal is a row; a wrong argument is an Error."""
    options = {name: values[name] for name in (*NUMBERS, *WORDS) if name in values}
    own = {name: value for name, value in values.items() if name not in (*PLACE, *NUMBERS, *WORDS, 'controller')}
    leans = getattr(kept.program, 'contact_tilt_deg', None)
    if leans is not None:
        options.setdefault('contact_tilt_deg', leans(own))
    try:
        program = program_of(kept, tuple(sorted(own.items())))
        found = trunnion.predict(program, machine_of(kept), trunnion.controller(values.get('controller', 'ideal')),
                                 placed_setup(kept.setup, values), uncertainty=False, samples=True, **options)
    except Error as error:
        if error.code.startswith('PY'):
            raise
        return Row(index, error.code, error.text, error.line)
    summary = found.summary
    feeds = programmed_feeds(program, values)
    numbers = {'cycle_time_s': found.cycle_time_s, 'cut_time_s': summary['cut_time_s'],
               'tip_feed_loss': feed_loss(found, 'feed_mm_min', *feeds),
               'contact_feed_loss': feed_loss(found, 'contact_feed_mm_min', *feeds)}
    for letter, axis in summary['axes'].items():
        numbers |= {f'{letter}_{ratio}': math.nan if axis[ratio] is None else axis[ratio] for ratio in RATIOS}
    return Row(index, numbers=numbers)


def predict_rows(kept, cases):
    """Rows of some set-ups, (index, values) each, and the exception of what went wrong that is no refusal, or None."""
    rows = []
    for index, values in cases:
        try:
            rows.append(predict_row(kept, index, values))
        except Exception as error:  # handed to the caller: executors have exceptions of their own
            return rows, error
    return rows, None
