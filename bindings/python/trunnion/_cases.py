"""Set-ups that are to be run, and how they are handed out and collected."""
import math
import os
import queue
from concurrent.futures import BrokenExecutor, ThreadPoolExecutor

import numpy as np

import trunnion

from ._set_up import RATIOS, need_count, predict_rows, refuse
from ._table import NOT_RUN, Table, fill


class Cases:
    """Set-ups of a study that are still to be run."""

    def __init__(self, study, parameters, combinations, indices, total, seed):
        self._study, self.parameters, self._combinations = study, parameters, combinations
        self._indices, self.total, self.seed = indices, total, seed

    def __len__(self):
        return len(self._combinations)

    def part(self, number, count):
        """Part `number` of `count`, from 0: every count-th set-up, for runs that know nothing of each other. `join()`
        makes one table of what they saved.
        """
        if not 0 <= number < count:
            refuse('PY0003', 'number: not a part', value=f'{number}', limit=f'0 to {count - 1}')
        if self._indices != range(self.total):
            refuse('PY0003', 'part: these set-ups are a part already')
        return Cases(self._study, self.parameters, self._combinations[number::count], self._indices[number::count],
                     self.total, self.seed)

    def run(self, executor=None, *, threads=None, batch=None, go_on=None, progress=None):
        """Predicts every set-up. A refused one is a row with its code. Ctrl-C ends the run when what is being worked out
        is done, and gives the table with the rest 'not run'.

        Parameters
        ----------
        executor : optional
            Anything with `submit` as concurrent.futures has it: a process pool, Dask's Client. Programs are read where the
            work is done, by their paths. None: threads of this process.
        threads : int, optional
            How many without an executor; None: one a processor.
        batch : int, optional
            Set-ups to a task; 1 on threads, 8 elsewhere.
        go_on : Table, optional
            Of an earlier run of the same set-ups: only what is 'not run' there is run.
        progress : callable, optional
            Called with how many are done and how many there are.

        Returns
        -------
        Table

        Raises
        ------
        Error
            PY0001 to PY0004: an argument that no set-up could be run with.
        """
        elsewhere = executor is not None and not isinstance(executor, ThreadPoolExecutor)
        if elsewhere and not callable(getattr(executor, 'submit', None)):
            refuse('PY0001', 'executor: something with submit wanted', value=type(executor).__name__)
        if elsewhere and isinstance(self._study.kept.program, trunnion.Program):
            refuse('PY0001', 'program: a Program stays in its process', hint='give its file, or a function that makes it')
        for name, value in (('threads', threads), ('batch', batch)):
            if value is not None:
                need_count(value, name)
        rows = self.empty() if go_on is None else self._begun(go_on)
        missing = np.flatnonzero(rows['status'] == NOT_RUN)
        size = batch or (8 if elsewhere else 1)
        cases = [(int(i), self._study.shared | dict(zip(self.parameters, self._combinations[i]))) for i in missing]
        batches = [cases[i:i + size] for i in range(0, len(cases), size)]
        stopped = run_batches(self._study.kept, batches, executor, threads or os.cpu_count(), rows, progress)
        return Table(rows, self.parameters, self.total, self.seed, stopped)

    def empty(self):
        columns = [np.array([c[i] for c in self._combinations]) for i in range(len(self.parameters))]
        letters = [axis['letter'] for axis in self._study.machine.axes]
        results = ['cycle_time_s', 'cut_time_s', 'tip_feed_loss', 'contact_feed_loss',
                   *(f'{letter}_{r}' for letter in letters for r in RATIOS)]
        types = [('index', 'i8'), *((name, column.dtype) for name, column in zip(self.parameters, columns)),
                 ('status', 'U8'), ('code', 'U8'), ('line', 'i4'), *((name, 'f8') for name in results), ('text', 'U120')]
        rows = np.zeros(len(self), types)
        rows['index'], rows['status'] = self._indices, NOT_RUN
        for name, column in zip(self.parameters, columns):
            rows[name] = column
        for name in results:
            rows[name] = math.nan
        return rows

    def _begun(self, table):
        rows = self.empty()
        same = isinstance(table, Table) and table.rows.dtype == rows.dtype and len(table) == len(rows) and all(
            (table[name] == rows[name]).all() for name in ('index', *self.parameters))
        if not same:
            refuse('PY0003', 'go_on: not a table of these set-ups')
        return table.rows.copy()


def take(answer, rows):
    """Puts what a task gave into the table; what went wrong in it is raised here."""
    found, wrong = answer
    for one in found:
        fill(rows[one.index], one)
    if wrong is not None:
        raise wrong


def run_batches(kept, batches, executor, threads, rows, progress):
    """Fills the rows; gives what stopped it. A task that its executor lost leaves its rows as they are."""
    done, stopped, futures = queue.SimpleQueue(), None, []
    pool = None if executor is not None else ThreadPoolExecutor(threads)
    count = 0
    try:
        try:
            for batch in batches:
                futures.append((executor or pool).submit(predict_rows, kept, batch))
                futures[-1].add_done_callback(done.put)
        except BrokenExecutor as broken:
            stopped = broken
        for _ in futures:
            try:
                answer = done.get().result()
            except Exception as lost:
                stopped = stopped or lost
                continue
            take(answer, rows)
            count += len(answer[0])
            if progress is not None:
                progress(count, sum(map(len, batches)))
    except KeyboardInterrupt as interrupt:
        stopped = interrupt
    finally:
        for future in futures:
            if not future.done():
                future.cancel()
        if pool is not None:
            pool.shutdown(cancel_futures=True)
    return stopped
