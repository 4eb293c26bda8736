"""What a study came to, as a table and as pictures."""
import collections
import csv

import numpy as np

from ._set_up import refuse

REFUSED, NOT_RUN = 'refused', 'not run'


def label(name):
    """`x_mm` as `x, mm`."""
    units = {'mm': 'mm', 'deg': '°', 's': 's', 'min': 'mm/min'}
    stem, _, last = name.rpartition('_')
    if last not in units or not stem:
        return name.replace('_', ' ')
    return f'{stem.removesuffix("_mm" if last == "min" else "").replace("_", " ")}, {units[last]}'


class Table:
    """Rows of a study, one a set-up, in the order of the set-ups whoever worked them out.

    `table['cycle_time_s']` is a column, `rows` all of them: a structured array with

    - `index`, then the parameters of the study;
    - `status`: 'ok', 'refused' or 'not run'; `code`, `text` (its first 120 characters), `line` where refused;
    - `cycle_time_s`, `cut_time_s`; `tip_feed_loss`, `contact_feed_loss`: the share of the programmed feed that is missing
      on the average of the cutting time, at the tip and at the contact (the latter NaN with the
      controls 'length-over-feed' and LinuxCNC's, and where the tool is not known);
    - for every axis `X_velocity_ratio`, `X_acceleration_ratio`, `X_jerk_ratio`: peak / limit. NaN where there is none.

    `parameters` are their names; `total` counts the set-ups of the study, of which a part has some; `seed` is None where
    nothing was drawn; `stopped` is what ended the run before its end: None, the KeyboardInterrupt, or what the executor
    raised.
    """

    def __init__(self, rows, parameters, total, seed=None, stopped=None):
        self.rows, self.parameters, self.total, self.seed, self.stopped = rows, list(parameters), total, seed, stopped

    def __len__(self):
        return len(self.rows)

    def __getitem__(self, name):
        return self.rows[name]

    @property
    def ok(self):
        """ndarray of bool: set-ups that the machine can make."""
        return self.rows['status'] == 'ok'

    @property
    def complete(self):
        """bool: every set-up of the table was run."""
        return not (self.rows['status'] == NOT_RUN).any()

    def best(self, by='cycle_time_s'):
        """The row with the least `by`, the first of equals; PY0003 where no set-up can be made."""
        values = np.where(self.ok & ~np.isnan(self.column(by)), self.column(by), np.inf)
        if not np.isfinite(values).any():
            refuse('PY0003', f'by: no set-up has a {by}', hint='the column `code` says why')
        return self.rows[np.argmin(values)]

    def column(self, name):
        """A column of numbers; PY0004 for others."""
        numbers = [n for n in self.rows.dtype.names if n not in ('index', 'line') and self.rows.dtype[n].kind in 'fiu']
        if name not in numbers:
            refuse('PY0004', 'column: not a column of numbers', value=str(name), hint=', '.join(numbers))
        return self.rows[name].astype(float)

    def report(self):
        """str: some lines for a person."""
        counts = collections.Counter(self.rows['status'].tolist())
        codes = collections.Counter(self.rows['code'][self.rows['status'] == REFUSED].tolist())
        lines = [f'{len(self)} set-ups: ' + ', '.join(f'{counts[s]} {s}' for s in ('ok', REFUSED, NOT_RUN) if counts[s])
                 + (f'; seed {self.seed}' if self.seed is not None else '')]
        lines += [f'  {code}: {count}' for code, count in sorted(codes.items())]
        if self.ok.any():
            best = self.best()
            place = ', '.join(f'{name} {best[name]}' for name in self.parameters)
            worst = self['cycle_time_s'][self.ok].max()
            lines.append(f'best {best["cycle_time_s"]:.3f} s at {place}; worst {worst:.3f} s')
        return '\n'.join(lines)

    def frame(self):
        """The same as a pandas.DataFrame; needs pandas."""
        import pandas
        return pandas.DataFrame.from_records(self.rows)

    def save(self, path):
        """Writes the table: `.csv` for others to read, `.npz` for `load()`."""
        if str(path).endswith('.npz'):
            np.savez(path, rows=self.rows, parameters=self.parameters, total=self.total,
                     seed=-1 if self.seed is None else self.seed)
        elif str(path).endswith('.csv'):
            with open(path, 'w', newline='', encoding='utf-8') as file:
                writer = csv.writer(file)
                writer.writerow(self.rows.dtype.names)
                writer.writerows(self.rows.tolist())
        else:
            refuse('PY0003', 'path: neither .csv nor .npz', value=str(path))

    def heat_map(self, x, y, by='cycle_time_s', path=None):
        """A picture of `by` over two parameters, the best set-up marked; crosses are refused. Of several set-ups at one
        place the best counts. Needs matplotlib.

        Parameters
        ----------
        x, y : str
            Parameters with numbers.
        by : str
            A column.
        path : str or os.PathLike, optional
            Where to write it: .svg, .png, .pdf.

        Returns
        -------
        matplotlib.figure.Figure
        """
        return heat_map(self, x, y, by, path)


def fill(row, found):
    """Puts a result in its row; the status last, so that no row is half there."""
    for name, value in found.numbers.items():
        row[name] = value
    row['code'], row['text'], row['line'] = found.code, found.text, found.line
    row['status'] = REFUSED if found.code else 'ok'


def load(path):
    """A table that was saved as .npz."""
    with np.load(path) as file:
        seed = int(file['seed'])
        return Table(file['rows'], file['parameters'].tolist(), int(file['total']), None if seed < 0 else seed)


def join(tables):
    """The parts of a study as one table, in the order of the set-ups.

    Raises
    ------
    Error
        PY0003 parts of different studies; a set-up that is missing, or there twice.
    """
    tables = list(tables)
    if not tables:
        refuse('PY0003', 'tables: none')
    first = tables[0]
    if any((t.rows.dtype, t.parameters, t.total, t.seed) != (first.rows.dtype, first.parameters, first.total, first.seed)
           for t in tables):
        refuse('PY0003', 'tables: not parts of one study')
    rows = np.concatenate([t.rows for t in tables])
    rows = rows[np.argsort(rows['index'], kind='stable')]
    times = np.bincount(rows['index'], minlength=first.total)
    for words, wrong in (('is missing', times == 0), ('is there twice', times > 1)):
        if wrong.any():
            refuse('PY0003', f'tables: set-up {np.argmax(wrong)} {words}', value=f'{wrong.sum()} such set-ups')
    return Table(rows, first.parameters, first.total, first.seed)


def best_by_place(table, x, y, by):
    """(places, values): for each pair of x and y the least value there, NaN where all are refused."""
    places, which = np.unique(np.column_stack([table.column(x), table.column(y)]), axis=0, return_inverse=True)
    values = np.full(len(places), np.inf)
    np.minimum.at(values, which.ravel(), np.where(table.ok & ~np.isnan(table.column(by)), table.column(by), np.inf))
    return places, np.where(np.isfinite(values), values, np.nan)


def heat_map(table, x, y, by, path):
    from matplotlib.figure import Figure
    places, values = best_by_place(table, x, y, by)
    refused = np.isnan(values)
    if refused.all():
        refuse('PY0003', f'by: no set-up has a {by}', hint='the column `code` says why')
    figure = Figure(figsize=(6, 4.6), layout='constrained')
    panel = figure.add_subplot()
    across, up = np.unique(places[:, 0]), np.unique(places[:, 1])
    if len(across) * len(up) == len(places) and len(across) > 1 and len(up) > 1:
        shown = panel.pcolormesh(across, up, values.reshape(len(across), len(up)).T, cmap='viridis_r', shading='nearest')
    else:
        shown = panel.scatter(*places.T, c=values, cmap='viridis_r', s=18, plotnonfinite=False)
    if refused.any():
        panel.plot(*places[refused].T, 'x', color='0.55', markersize=4, label='refused')
    best = np.nanargmin(values)
    panel.plot(*places[best], '*', color='#D55E00', markeredgecolor='white', markersize=16, clip_on=False,
               label=f'best: {values[best]:.4g}')
    panel.set_xlabel(label(x))
    panel.set_ylabel(label(y))
    figure.colorbar(shown, label=label(by))
    panel.legend(loc='lower left', bbox_to_anchor=(0, 1), ncols=2, frameon=False)
    if path is not None:
        figure.savefig(path)
    return figure
