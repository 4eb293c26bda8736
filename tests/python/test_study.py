"""Studies: rows against single predictions, the same table by every executor, lost workers, Ctrl-C, bad arguments."""
import concurrent.futures
import os
import re
import signal
import threading

import numpy as np
import pytest

import trunnion
from conftest import EXAMPLES, ROOT, refused
from trunnion import study
from trunnion.study import Study, SurfaceProgram

RIM = EXAMPLES / '05_convert'


def rim(**shared):
    return Study(RIM / 'rim.cls', 'ucp710', RIM / 'setup.toml', **{'controller': 'lavernhe-2006', **shared})


GRID = {'x_mm': [-200, 0, 200, 400], 'y_mm': [-100, 0, 100], 'controller': ['lavernhe-2006', 'length-over-feed']}


@pytest.fixture(scope='module')
def cases():
    return rim().over(**GRID)


@pytest.fixture(scope='module')
def table(cases):
    return cases.run()


def same(one, other):
    return one.rows.dtype == other.rows.dtype and all(
        np.array_equal(one[n], other[n], equal_nan=one.rows.dtype[n].kind == 'f') for n in one.rows.dtype.names)


def test_rows_are_single_predictions(table):
    assert len(table) == 24 and table.complete and table.stopped is None and table.parameters == list(GRID)
    assert table['x_mm'][:7].tolist() == [-200] * 6 + [0] and (table['index'] == np.arange(24)).all()
    assert (table['status'][table['x_mm'] == 400] == 'refused').all() and (table['code'][-6:] == 'PATH0102').all()
    machine = trunnion.machine('ucp710')
    program = trunnion.read_program(RIM / 'rim.cls', machine=machine)
    row = next(r for r in table.rows if (r['x_mm'], r['y_mm'], r['controller']) == (-200, 100, 'lavernhe-2006'))
    setup = trunnion.setup({'workpiece': {'origin': ['-200 mm', '100 mm', '20 mm']},
                            'tool': {'kind': 'ball', 'diameter': '8 mm', 'length': '0 mm'}})
    alone = trunnion.predict(program, machine, trunnion.controller('lavernhe-2006'), setup, uncertainty=False)
    assert row['cycle_time_s'] == pytest.approx(alone.cycle_time_s, abs=1e-9)
    assert row['A_jerk_ratio'] == pytest.approx(alone.summary['axes']['A']['jerk_ratio'], abs=1e-9)
    assert 0 < row['tip_feed_loss'] < 0.5 and 0 < row['contact_feed_loss'] < 0.5


def test_a_control_that_holds_the_feed_loses_none(table):
    held = table.rows[(table['controller'] == 'length-over-feed') & table.ok]
    lost = table.rows[(table['controller'] == 'lavernhe-2006') & table.ok]
    assert len(held) == len(lost) == 9
    assert np.abs(held['tip_feed_loss']).max() < 1e-3 < lost['tip_feed_loss'].min()
    changed = rim(controller='length-over-feed').over(feed_override=[0.5, 2], feed_mm_min=[500]).run()
    assert changed.ok.all() and np.abs(changed['tip_feed_loss']).max() < 1e-3


def test_the_best_row(table):
    best = table.best()
    assert best['cycle_time_s'] == table['cycle_time_s'][table.ok].min() and best['status'] == 'ok'
    assert '24 set-ups: 18 ok, 6 refused' in table.report() and 'PATH0102: 6' in table.report()
    with refused('PY0003', 'by'):
        rim().over(x_mm=[2000]).run().best()


def test_a_turned_part_is_a_turned_setup():
    """Turns about Z behind one about X: the machine goes to where the setup's own rotation would send it."""
    row = rim().over(rotate_x_deg=[10], rotate_z_deg=[90]).run().rows[0]
    turned = {'workpiece': {'origin': ['0 mm', '0 mm', '20 mm'], 'rotation': {'axis': [1, 0, 0], 'angle': '10 deg'}},
              'tool': {'kind': 'ball', 'diameter': '8 mm'}}
    again = Study(RIM / 'rim.cls', 'ucp710', turned, controller='lavernhe-2006').over(rotate_z_deg=[90]).run().rows[0]
    plain = rim().over(z_mm=[20]).run().rows[0]
    assert row['status'] == 'ok' and row['cycle_time_s'] == pytest.approx(again['cycle_time_s'], abs=1e-9)
    assert abs(row['Y_velocity_ratio'] - plain['Y_velocity_ratio']) > 1e-3


@pytest.mark.parametrize('degrees', [0, 1e-9, 37, 90, 179.9999999, 180])
def test_a_rotation_as_axis_and_angle(degrees):
    turn = study._set_up.turn
    rotation = turn(2, 33) @ turn(0, degrees) @ turn(2, -33)
    axis, angle = study._set_up.axis_and_angle(rotation)
    assert np.degrees(angle) == pytest.approx(degrees, abs=1e-6) and 0 <= angle <= np.pi + 1e-12
    if degrees > 1:
        expected = np.array([np.cos(np.radians(33)), np.sin(np.radians(33)), 0])
        assert abs(axis @ expected) == pytest.approx(1, abs=1e-9) and (degrees == 180 or axis @ expected > 0)


def test_tolerances_and_our_own_planner():
    table = rim(controller='ideal', period_s=0.01).over(tip_tolerance_mm=[0.001, 0.05], z_mm=[20]).run()
    assert table['cycle_time_s'][1] < table['cycle_time_s'][0] and np.nanmax(table['C_velocity_ratio']) < 1.01
    assert ((0 <= table['contact_feed_loss']) & (table['contact_feed_loss'] < 1)).all()


def test_lead_and_strategy():
    made = SurfaceProgram(str(EXAMPLES / '11_hollow/bowl.toml'), 'ball', 16, scallop_mm=0.3, borders=False, tool_name='8')
    where = Study(made, 'trunnion-bc', EXAMPLES / '11_hollow/setup.toml', controller='length-over-feed')
    table = where.over(strategy=['along-u', 'along-v'], lead_deg=[10, 30]).run()
    assert table.ok.all() and len(set(table['cycle_time_s'].tolist())) > 1
    # The contact counts the lead of the passes as the tool's lean, unless something else is said.
    control, leans = 'lavernhe-2006', {'strategy': ['along-u'], 'lead_deg': [30]}
    by_lead, upright = (where.over(controller=[control], contact_tilt_deg=[30, 0], **leans).run().rows)
    row = where.over(controller=[control], **leans).run().rows[0]
    assert row['contact_feed_loss'] == by_lead['contact_feed_loss'] != upright['contact_feed_loss']
    assert upright['contact_feed_loss'] == pytest.approx(upright['tip_feed_loss'], abs=1e-9)
    with concurrent.futures.ProcessPoolExecutor(1) as pool:
        assert pool.submit(os.getpid).result() != os.getpid()
        assert same(where.over(strategy=['along-u', 'along-v'], lead_deg=[10, 30]).run(pool), table)
    with refused('PY0004', 'splines'):
        where.over(splines=[True])
    with refused('PY0004', 'strategy'):
        where.over(strategy=['spiral']).run()


def test_random_set_ups_are_those_of_their_seed():
    print('seed 11')
    one, two = (rim().random(count, seed=11, x_mm=(-100, 100), controller=['ideal', 'lavernhe-2006']) for count in (5, 8))
    assert one._combinations == two._combinations[:5] and one.seed == 11
    drawn = rim().random(500, seed=5, x_mm=(-100, 100), y_mm=(0, 1)).empty()
    assert -100 <= drawn['x_mm'].min() < -95 and 95 < drawn['x_mm'].max() <= 100
    assert abs(np.corrcoef(drawn['x_mm'], drawn['y_mm'])[0, 1]) < 0.1
    assert f'seed {rim().random(1, x_mm=(0, 1)).seed}' != f'seed {rim().random(1, x_mm=(0, 1)).seed}'
    assert 'seed 11' in one.run().report()


def test_the_search_is_near_the_best_of_a_fine_grid():
    pytest.importorskip('nlopt')
    ranges = {'x_mm': (-200, 200), 'y_mm': (-200, 200)}
    fine = rim().over(**{name: np.linspace(*r, 17) for name, r in ranges.items()}).run()
    found = [rim().search(seed=4, samples=10, evaluations=25, **ranges) for _ in range(2)]
    spread = fine['cycle_time_s'][fine.ok].max() - fine.best()['cycle_time_s']
    assert found[0].best()['cycle_time_s'] < fine.best()['cycle_time_s'] + 0.1 * spread
    assert found[0].best()['cycle_time_s'] < found[0]['cycle_time_s'][:10].min()
    assert same(*found) and 12 < len(found[0]) <= 60 and found[0].complete
    with refused('PY0004', 'column'):
        rim().search(by='status', x_mm=(0, 1))
    with refused('PY0003', 'x_mm'):
        rim().search(x_mm=(1, 0))


def test_processes_give_the_same_table(cases, table):
    with concurrent.futures.ProcessPoolExecutor(2) as pool:
        assert same(cases.run(pool), table)


@pytest.mark.parametrize('broken_before', [False, True])
def test_a_pool_that_breaks_loses_no_row(cases, table, broken_before):
    with concurrent.futures.ProcessPoolExecutor(1) as pool:
        killed = pool.submit(os.kill, pool.submit(os.getpid).result(), signal.SIGKILL)
        if broken_before:
            assert isinstance(killed.exception(), concurrent.futures.BrokenExecutor)
        broken = cases.run(pool)
    assert isinstance(broken.stopped, concurrent.futures.BrokenExecutor) and not broken.complete
    assert (broken['status'] != 'ok').all() or same(broken, table)
    assert same(cases.run(go_on=broken), table)
    with refused('PY0003', 'go_on'):
        rim().over(x_mm=[0]).run(go_on=broken)


def test_a_dask_worker_that_is_killed(cases, table):
    """A scheduler and two worker processes on this machine; one is killed when a part of the rows is there."""
    distributed = pytest.importorskip('distributed')
    killed, counts = [], []

    def kill_one(done, count):
        counts.append(done)
        if not killed and done < count:
            killed.append(min(client.run(os.getpid).values()))
            os.kill(killed[0], signal.SIGKILL)

    cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1, host='127.0.0.1', dashboard_address=None)
    with cluster, distributed.Client(cluster) as client:
        found = cases.run(client, batch=2, progress=kill_one)
        assert killed and same(found, table) and counts == list(range(2, 25, 2))
        assert same(cases.run(client.get_executor(pure=False), batch=5), table)


def test_ctrl_c_keeps_what_is_done():
    cases = rim(controller='ideal').over(x_mm=np.linspace(-100, 100, 400))
    counts = []

    def interrupt(done, count):
        counts.append(done)
        if done == 5:
            threading.Thread(target=os.kill, args=(os.getpid(), signal.SIGINT)).start()

    table = cases.run(threads=2, progress=interrupt)
    assert isinstance(table.stopped, KeyboardInterrupt) and 5 <= table.ok.sum() < 100 and not table.complete
    assert '400 set-ups' in table.report() and 'not run' in table.report()


def test_parts_joined_are_the_whole(cases, table, tmp_path):
    for k in range(3):
        cases.part(k, 3).run().save(tmp_path / f'{k}.npz')
    parts = [study.load(tmp_path / f'{k}.npz') for k in (2, 0, 1)]
    assert same(study.join(parts), table)
    with refused('PY0003', 'tables: set-up 1 is missing'):
        study.join(parts[:2])
    with refused('PY0003', 'tables: set-up 0 is there twice'):
        study.join([*parts, parts[1]])
    table.save(tmp_path / 'all.csv')
    assert (tmp_path / 'all.csv').read_text().startswith('index,x_mm,y_mm,controller,status,code,line,cycle_time_s')
    with refused('PY0003', 'path'):
        table.save(tmp_path / 'all.txt')


def test_pictures(tmp_path):
    pytest.importorskip('matplotlib')
    table = rim().over(x_mm=GRID['x_mm'], y_mm=GRID['y_mm']).run()
    figure = table.heat_map('x_mm', 'y_mm', path=tmp_path / 'map.svg')
    panel, bar = figure.axes
    assert panel.get_xlabel() == 'x, mm' and bar.get_ylabel() == 'cycle time, s'
    assert (tmp_path / 'map.svg').stat().st_size > 1000
    crosses, star = panel.get_lines()
    assert len(crosses.get_xdata()) == 3 and star.get_xdata()[0] == table.best()['x_mm']
    assert star.get_label() == f'best: {table.best()["cycle_time_s"]:.4g}'
    with refused('PY0004', 'column'):
        table.heat_map('controller', 'y_mm')


def test_a_table_for_pandas(table):
    pytest.importorskip('pandas')
    assert table.frame()['cycle_time_s'].notna().sum() == 18


def test_a_program_in_memory_is_for_threads(blade):
    here = Study(blade, 'xyzac-trt', EXAMPLES / '01_first_plan/setup.toml', controller='lavernhe-2006')
    assert here.over(feed_override=[0.5, 1]).run().ok.all()
    with concurrent.futures.ProcessPoolExecutor(1) as pool, refused('PY0001', 'program'):
        here.over(feed_override=[1]).run(pool)


def fails(x):
    raise ZeroDivisionError


@pytest.mark.parametrize('code, name, act', [
    ('PY0003', 'program', lambda: Study('none.cls', 'ucp710')),
    ('PY0001', 'program', lambda: Study(3, 'ucp710')),
    ('PY0001', 'machine', lambda: Study(RIM / 'rim.cls', trunnion.machine('ucp710'))),
    ('PY0001', 'setup', lambda: Study(RIM / 'rim.cls', 'ucp710', 3)),
    ('PY0004', 'x', lambda: rim().over(x=[1])),
    ('PY0004', 'colour', lambda: rim(colour=1)),
    ('PY0001', 'x_mm', lambda: rim().over(x_mm=['1'])),
    ('PY0001', 'x_mm', lambda: rim().over(x_mm=[])),
    ('PY0001', 'x_mm', lambda: rim().over(x_mm=None)),
    ('PY0002', 'x_mm', lambda: rim().over(x_mm=[0, float('nan')])),
    ('PY0001', 'controller', lambda: rim().over(controller=[1])),
    ('PY0001', 'y_mm', lambda: rim().each(x_mm=[1, 2], y_mm=[1])),
    ('PY0001', 'values', lambda: rim().over()),
    ('PY0003', 'count', lambda: rim().random(0, x_mm=(0, 1))),
    ('PY0003', 'seed', lambda: rim().random(1, seed=-1, x_mm=(0, 1))),
    ('PY0001', 'threads', lambda: rim().over(x_mm=[0]).run(threads=1.5)),
    ('PY0003', 'batch', lambda: rim().over(x_mm=[0]).run(batch=0)),
    ('PY0001', 'executor', lambda: rim().over(x_mm=[0]).run('dask')),
    ('PY0003', 'number', lambda: rim().over(x_mm=[0]).part(1, 1)),
    ('PY0004', 'rounding', lambda: rim(controller='ideal').over(rounding=['sharp']).run()),
])
def test_arguments_that_are_wrong(code, name, act):
    with refused(code, name):
        act()


def test_what_a_function_raises_is_raised():
    with pytest.raises(ZeroDivisionError):
        Study(fails, 'ucp710').over(x=[1]).run()


def test_a_control_that_is_none_is_a_row():
    assert rim().over(controller=['none']).run()['code'].tolist() == ['FILE0118']


def test_the_page(monkeypatch, capsys, tmp_path):
    """Every block of docs/how-to/study-set-ups.md runs, in order; those of Slurm as Slurm would run them."""
    (tmp_path / 'examples').symlink_to(EXAMPLES)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv('SLURM_ARRAY_TASK_COUNT', '2')
    blocks = re.findall(r'^```python\n(.*?)^```', (ROOT / 'docs/how-to/study-set-ups.md').read_text(), re.M | re.S)
    assert len(blocks) == 6
    names = {}
    for block in blocks:
        for task in '01' if 'SLURM_ARRAY_TASK_ID' in block else '0':
            monkeypatch.setenv('SLURM_ARRAY_TASK_ID', task)
            exec(compile(block, 'study-set-ups.md', 'exec'), names)
    assert 'set-ups' in capsys.readouterr().out and (tmp_path / 'places.svg').exists()
