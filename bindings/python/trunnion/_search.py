"""Local searches among set-ups, without derivatives: Subplex of NLopt (Rowan 1990), each from a place of its own."""
import threading
from concurrent.futures import ThreadPoolExecutor

import nlopt
import numpy as np

from ._set_up import predict_rows
from ._table import Table, fill

FIRST_STEP, LAST_STEP = 0.1, 1e-3  # of each range


class Search:
    """Searches of one study that share the executor and the wish to stop."""

    def __init__(self, study, names, bounds, by, evaluations, executor):
        self.study, self.names, self.by, self.evaluations, self.executor = study, names, by, evaluations, executor
        self.low, self.reach = bounds[:, 0], bounds[:, 1] - bounds[:, 0]
        self.stop = threading.Event()

    def predict(self, values):
        case = [(0, self.study.shared | dict(zip(self.names, values)))]
        if self.executor is None:
            rows, wrong = predict_rows(self.study.kept, case)
        else:
            rows, wrong = self.executor.submit(predict_rows, self.study.kept, case).result()
        if wrong is not None:
            raise wrong
        return rows[0]

    def run(self, start, refused_cost, tried):
        """From a place in the unit cube; appends (values, row) to `tried`. Refused places cost more than any drawn one."""
        def cost(place, _):
            if self.stop.is_set():
                raise nlopt.ForcedStop
            values = (self.low + place * self.reach).tolist()
            row = self.predict(values)
            tried.append((values, row))
            found = row.numbers.get(self.by, np.nan)
            return refused_cost if np.isnan(found) else found

        method = nlopt.opt(nlopt.LN_SBPLX, len(self.low))
        method.set_lower_bounds(np.zeros(len(self.low)))
        method.set_upper_bounds(np.ones(len(self.low)))
        method.set_min_objective(cost)
        method.set_initial_step(FIRST_STEP)
        method.set_xtol_abs(LAST_STEP)
        method.set_maxeval(self.evaluations)
        try:
            method.optimize(start)
        except (nlopt.ForcedStop, nlopt.RoundoffLimited):
            pass  # what was tried counts


def search(study, cases, bounds, by, starts, evaluations, executor):
    """Runs the cases, then searches from the best of them; a Table of all that was tried."""
    Table(cases.empty(), cases.parameters, len(cases)).column(by)
    first = cases.run(executor)
    costs = np.where(first.ok, first.column(by), np.nan)
    begin = [i for i in np.argsort(costs, kind='stable')[:starts] if not np.isnan(costs[i])]
    if first.stopped is not None or not begin:
        return first
    refused_cost = 2 * np.nanmax(costs) - np.nanmin(costs) + abs(np.nanmax(costs))
    work = Search(study, cases.parameters, bounds, by, evaluations, executor)
    drawn = np.array([[row[name] for name in cases.parameters] for row in first.rows])
    tried, stopped = [[] for _ in begin], None
    pool = ThreadPoolExecutor(len(begin))
    futures = [pool.submit(work.run, (drawn[i] - work.low) / work.reach, refused_cost, one)
               for i, one in zip(begin, tried)]
    try:
        for future in futures:
            future.result()
    except KeyboardInterrupt as interrupt:
        stopped = interrupt
    finally:
        work.stop.set()
        pool.shutdown()
    return joined(study, first, sum(tried, []), stopped)


def joined(study, first, tried, stopped):
    """The samples, and behind them what was tried."""
    places = [[row[name] for name in first.parameters] for row in first.rows] + [values for values, _ in tried]
    rows = study.each(**{name: [p[i] for p in places] for i, name in enumerate(first.parameters)}).empty()
    rows[:len(first)] = first.rows
    for row, (_, found) in zip(rows[len(first):], tried):
        fill(row, found)
    return Table(rows, first.parameters, len(rows), first.seed, stopped)
