"""One program in many set-ups: where on the table the part lies, how it is turned, tolerances, the control, and for
passes over a surface strategy, lead and tilt. What each costs is predicted (`trunnion.predict`; the control 'ideal' is
our own planner).

    from trunnion.study import Study
    study = Study('part.mpf', 'ucp710', 'vice.toml')
    table = study.over(x_mm=range(-100, 101, 20), y_mm=range(-100, 101, 20)).run()
    print(table.report())
    table.heat_map('x_mm', 'y_mm', path='places.svg')

Rows come in the order of the set-ups and are the same whoever works them out: threads of this process, or an executor.
"""
import inspect
import itertools
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

import trunnion

from . import _set_up
from ._cases import Cases
from ._set_up import NUMBERS, PLACE, WORDS, File, Kept, need_count, refuse
from ._table import Table, join, load
from ._toml import text_of

__all__ = ['Cases', 'Study', 'SurfaceProgram', 'Table', 'join', 'load']


@dataclass(frozen=True)
class SurfaceProgram:
    """A program for `Study`: passes over all faces of a file, planned anew for each strategy, lead and tilt.

    Parameters
    ----------
    faces : str
        A file as `read_faces()` takes it.
    kind, diameter_mm, corner_radius_mm, length_mm
        The tool, as `Tool` has it; it should be the setup's of that `tool_name`, for the feed at the contact.
    strategy, scallop_mm, lead_deg, tilt_deg, feed_angle_deg, feed_mm_min, borders, tool_name
        As `plan_surface()`; the first five may be parameters of the study.
    """
    faces: str
    kind: str
    diameter_mm: float
    corner_radius_mm: float = 0.0
    length_mm: float = 0.0
    strategy: str = 'constant-scallop'
    scallop_mm: float = 0.01
    lead_deg: float = 0.0
    tilt_deg: float = 0.0
    feed_angle_deg: float = 0.0
    feed_mm_min: float = 3000.0
    borders: bool = True
    tool_name: str = ''

    def contact_tilt_deg(self, made_with):
        """How far the tool leans along the feed."""
        return made_with.get('lead_deg', self.lead_deg)

    def __call__(self, *, strategy=None, scallop_mm=None, lead_deg=None, tilt_deg=None, feed_angle_deg=None):
        def given(value, otherwise):
            return otherwise if value is None else value
        tool = trunnion.Tool(self.kind, self.diameter_mm, self.corner_radius_mm, self.length_mm)
        return trunnion.plan_surface(
            trunnion.read_faces(self.faces), tool, strategy=given(strategy, self.strategy),
            scallop_mm=given(scallop_mm, self.scallop_mm), lead_deg=given(lead_deg, self.lead_deg),
            tilt_deg=given(tilt_deg, self.tilt_deg), feed_angle_deg=given(feed_angle_deg, self.feed_angle_deg),
            feed_mm_min=self.feed_mm_min, borders=self.borders, tool_name=self.tool_name).program


class Study:
    """A program, a machine, a setup, and values that all set-ups share.

    Parameters
    ----------
    program : str, os.PathLike, Program or function
        A function makes the program; its arguments are parameters of the study (`SurfaceProgram`, or one of yours). A
        Program stays in its process, so that it is for threads only; a function has to be one that the executor can
        send.
    machine : str, os.PathLike or dict
        As `trunnion.machine()`.
    setup : str, os.PathLike or dict, optional
        As `trunnion.setup()`.
    dialect, units, feed_given_elsewhere : optional
        As `read_program()`.
    **shared
        What all set-ups have, by the names of parameters.

    Parameters by which set-ups differ:

    - `x_mm`, `y_mm`, `z_mm`: program zero in the machine frame, all axes at 0; otherwise the setup's;
    - `rotate_x_deg`, `rotate_y_deg`, `rotate_z_deg`: turns of the part about X, then Y, then Z of the machine through
      program zero, behind the setup's own;
    - `controller`: a shipped one by name, or a file; 'ideal';
    - the options of `predict()` and `plan()`: `contact_tilt_deg`, `feed_override`, `feed_mm_min` for every control,
      `tip_tolerance_mm`, `rounding` … for 'ideal';
    - the arguments of the function that makes the program.

    Raises
    ------
    Error
        PY0001 to PY0004 by the argument's name; the codes of machine and setup.
    """

    def __init__(self, program, machine, setup=None, *, dialect=None, units=None, feed_given_elsewhere=False, **shared):
        reading = {'dialect': dialect, 'units': units, 'feed_given_elsewhere': feed_given_elsewhere}
        self.kept = Kept(_program_source(program), *_machine_source(machine), _setup_text(setup),
                          tuple((name, value) for name, value in reading.items() if value))
        self.machine = _set_up.machine_of(self.kept)
        self._made_with = _arguments_of(program)
        _set_up.placed_setup(self.kept.setup, {})
        self.shared = {name: self._values(name, [value])[0] for name, value in shared.items()}

    def over(self, **values):
        """All combinations of these values, the last parameter changing fastest: Cases."""
        columns = {name: self._values(name, each) for name, each in values.items()}
        return self._cases(columns, list(itertools.product(*columns.values())))

    def each(self, **values):
        """One set-up for each place in these sequences, which have one length: Cases."""
        columns = {name: self._values(name, each) for name, each in values.items()}
        if len({len(column) for column in columns.values()}) > 1:
            name = min(columns, key=lambda n: len(columns[n]))
            refuse('PY0001', f'{name}: fewer values than other parameters have')
        return self._cases(columns, list(zip(*columns.values())))

    def random(self, count, *, seed=None, **ranges):
        """`count` set-ups drawn evenly: Cases. A range is (from, to) of a parameter with numbers, or a list of words.
        Without a seed one is drawn; `Table.seed` and the report say it.
        """
        need_count(count, 'count')
        seed = _seed(seed)
        # One stream a parameter, by its place: further set-ups do not change the first ones.
        streams = [np.random.Generator(np.random.PCG64([seed, i])).random(count) for i in range(len(ranges))]
        columns = {name: self._drawn(name, given, stream) for (name, given), stream in zip(ranges.items(), streams)}
        return self._cases(columns, list(zip(*columns.values())), seed)

    def search(self, *, by='cycle_time_s', samples=20, starts=2, evaluations=40, seed=None, executor=None, **ranges):
        """Looks for the set-up with the least `by`: `samples` drawn evenly, and from the best `starts` of them a local
        search without derivatives (Subplex by NLopt, Debian's python3-nlopt) of at most so many `evaluations` each. It
        finds a good set-up, not surely the best one.

        Parameters
        ----------
        by : str
            A column of the table.
        **ranges
            (from, to) of parameters with numbers.

        Returns
        -------
        Table
            All that was tried: samples, then one search behind the other.
        """
        need_count(starts, 'starts')
        need_count(evaluations, 'evaluations')
        bounds = np.array([self._range(name, given) for name, given in ranges.items()]).reshape(-1, 2)
        if not len(bounds):
            refuse('PY0001', 'ranges: none given', hint='x_mm=(-100, 100)')
        from ._search import search
        return search(self, self.random(samples, seed=seed, **ranges), bounds, by, starts, evaluations, executor)

    def _cases(self, columns, combinations, seed=None):
        if not columns or not combinations:
            refuse('PY0001', 'values: no set-ups', hint='x_mm=[0, 50, 100]')
        return Cases(self, list(columns), combinations, range(len(combinations)), len(combinations), seed)

    def _values(self, name, given):
        """The values of one parameter, as plain numbers or words."""
        if isinstance(given, (str, int, float)):
            given = [given]
        try:
            given = np.asarray(given).tolist() if not isinstance(given, (list, tuple)) else list(given)
        except (TypeError, ValueError):
            given = None
        if not isinstance(given, list) or not given:
            refuse('PY0001', f'{name}: values wanted, one or more')
        return [self._value(name, value) for value in given]

    def _value(self, name, value):
        known = (*PLACE, 'controller', *NUMBERS, *WORDS, *self._made_with)
        if name not in known and '**' not in self._made_with:
            refuse('PY0004', f'{name}: not a parameter', hint=', '.join(n for n in known))
        if isinstance(value, np.generic):
            value = value.item()
        if name in ('controller', *WORDS) and not isinstance(value, str):
            refuse('PY0001', f'{name}: text wanted', value=repr(value))
        if name == 'controller' and os.path.isfile(value):
            value = os.path.abspath(value)
        if name in (*PLACE, *NUMBERS):
            if isinstance(value, bool) or not isinstance(value, (int, float)):
                refuse('PY0001', f'{name}: a number wanted', value=repr(value))
            value = float(value)
        if isinstance(value, float) and not math.isfinite(value):
            refuse('PY0002', f'{name}: not finite', value=repr(value))
        if not isinstance(value, (str, bool, int, float)):
            refuse('PY0001', f'{name}: numbers or words wanted', value=repr(value))
        return value

    def _range(self, name, given):
        values = self._values(name, given)
        if len(values) != 2 or any(isinstance(v, (str, bool)) for v in values) or not values[0] < values[1]:
            refuse('PY0003', f'{name}: (from, to) wanted, the first one below the second', value=repr(given))
        return values

    def _drawn(self, name, given, stream):
        values = self._values(name, given)
        if isinstance(values[0], (str, bool)):
            return [values[int(u * len(values))] for u in stream]
        low, high = self._range(name, given)
        return [low + u * (high - low) for u in stream.tolist()]


def _program_source(program):
    if isinstance(program, trunnion.Program) or callable(program):
        return program
    if isinstance(program, (str, os.PathLike)):
        return File.of(program, 'program')
    refuse('PY0001', 'program: a file, a trunnion.Program or a function wanted', value=type(program).__name__)


def _arguments_of(program):
    """Names that a function takes; '**': any."""
    if isinstance(program, trunnion.Program) or not callable(program):
        return ()
    parameters = inspect.signature(program).parameters.values()
    return tuple('**' if p.kind is p.VAR_KEYWORD else p.name for p in parameters)


def _machine_source(machine):
    if isinstance(machine, Mapping):
        return text_of(machine), True
    if not isinstance(machine, (str, os.PathLike)):
        refuse('PY0001', 'machine: a name, a file or its keys wanted', value=type(machine).__name__)
    if not os.path.isfile(machine):
        return str(machine), False
    trunnion.machine(machine)  # says what is wrong with the file's name and place
    with open(machine, encoding='utf-8') as file:
        return file.read(), True


def _setup_text(setup):
    if setup is None:
        return ''
    if isinstance(setup, Mapping):
        return text_of(setup)
    if not isinstance(setup, (str, os.PathLike)):
        refuse('PY0001', 'setup: a file or its keys wanted', value=type(setup).__name__)
    trunnion.setup(setup)  # says what is wrong with the file's name and place
    with open(setup, encoding='utf-8') as file:
        return file.read()


def _seed(seed):
    if seed is None:
        return int.from_bytes(os.urandom(4), 'little')
    if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or seed < 0:
        refuse('PY0003', 'seed: a whole number from 0 wanted', value=repr(seed))
    return int(seed)
