"""Diagnostics of one's own, and errors on their way through executors."""
import concurrent.futures
import copy
import math
import pickle

import pytest

import trunnion
from conftest import refused

FIELDS = ('code', 'severity', 'text', 'value', 'limit', 'hint', 'count', 'file', 'line', 'column')


def full():
    return trunnion.Diagnostic('PY0003', 'x: out of range', value='3', limit='2', hint='less', severity='warning', count=4,
                               file='a.ngc', line=5, column=6, path_length_mm=7.5)


def test_a_diagnostic_of_one_s_own():
    one = full()
    assert [getattr(one, name) for name in FIELDS] == ['PY0003', 'warning', 'x: out of range', '3', '2', 'less', 4, 'a.ngc', 5, 6]
    assert one.path_length_mm == 7.5 and 'a.ngc:5:6' in str(one)
    plain = trunnion.Diagnostic('PY0001', 'y')
    assert (plain.severity, plain.count, plain.line, plain.value) == ('error', 1, 0, '') and math.isnan(plain.path_length_mm)
    for code, name, call in [('PY0001', 'code', lambda: trunnion.Diagnostic(3, 'y')),
                             ('PY0004', 'severity', lambda: trunnion.Diagnostic('A', 'y', severity='fatal')),
                             ('PY0002', 'path_length_mm', lambda: trunnion.Diagnostic('A', 'y', path_length_mm=math.inf)),
                             ('PY0001', 'line', lambda: trunnion.Diagnostic('A', 'y', line='5'))]:
        with refused(code, name):
            call()
    with pytest.raises(TypeError, match='colour'):
        trunnion.Diagnostic('A', 'y', colour=1)


def test_they_can_be_pickled():
    for again in (pickle.loads(pickle.dumps(full())), copy.deepcopy(full())):
        assert [getattr(again, name) for name in FIELDS] == [getattr(full(), name) for name in FIELDS]
    error = pickle.loads(pickle.dumps(trunnion.Error(full())))
    assert isinstance(error, trunnion.Error) and error.code == 'PY0003' and error.line == 5
    assert str(error) == str(full()) and math.isnan(pickle.loads(pickle.dumps(trunnion.Diagnostic('A', 'b'))).path_length_mm)


def no_such_machine():
    trunnion.machine('no-such-machine')


def test_an_error_of_another_process():
    with concurrent.futures.ProcessPoolExecutor(1) as pool:
        with refused('FILE0112'):
            pool.submit(no_such_machine).result()
