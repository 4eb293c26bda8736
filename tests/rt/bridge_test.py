"""What stands by for linuxcnc/bridge.py finds its place again: in plans, and in the streamer's memory.   bridge_test.py LINUXCNC_FOLDER"""
import ctypes
import os
import struct
import sys
import tempfile

sys.dont_write_bytecode = True
sys.path.insert(0, sys.argv[1])

import bridge_machine
from bridge_machine import TAIL, Plans, Ring

ROWS = 16384  # TRUNNION_PLAN_ROWS
AXES = (1, 0)  # of the joints


def plan(first, rows):
    out = Plans.PLAN.pack(first, first, len(rows)) + b''.join(Plans.ROW.pack(*row, *[0.0] * (9 - len(row)), 0) for row in rows)
    return out.ljust(Plans.PLAN.size + ROWS * Plans.ROW.size, b'\0')


def plans(first, rows, following, in_use=2):
    """Memory with this plan in use, and another one beside it."""
    file = tempfile.TemporaryFile()
    both = [plan(first, rows), plan(0, [(7, 7)] * 50)]
    file.write(Plans.HEAD.pack(1, 2, 1e-3, in_use, in_use, in_use, following) + both[in_use & 1] + both[1 - (in_use & 1)])
    file.flush()
    return Plans(file.fileno())


def joints(rows):
    return [tuple(float(row[axis]) for axis in AXES) for row in rows]


def places_are_found_again():
    way = [(k * k * 1e-3, -k) for k in range(100)]
    for in_use in (2, 3):
        memory = plans(500, way, 560, in_use)
        for last in (1, 2, 5, 59, 60, 61, 99, 100):  # rows that were given, and some of the plan that were not
            assert memory.rows_behind(joints(way[:last])[-TAIL:], AXES) == joints(way[last:]), last
    assert plans(500, way, 560).rows_behind(joints([(5, 5)] * TAIL), AXES) == []
    assert plans(500, [], 500).rows_behind(joints(way[:TAIL]), AXES) == []


def a_standstill_is_left_by_its_end():
    way = [(k, 0) for k in range(20)] + [(20, 0)] * 30 + [(20, k) for k in range(1, 20)]
    behind = plans(0, way, 45).rows_behind(joints(way[:30])[-TAIL:], AXES)
    assert behind == joints(way[45:])  # what is left of it behind the rows that were given


def ring_is_read_as_linuxcnc_lays_it_out():
    libc = ctypes.CDLL(None)
    libc.shmat.restype = ctypes.c_void_p
    key, depth = 0x54520000 + os.getpid() % 0xffff, 16
    shared = libc.shmget(key, 128 + depth * 24, 0o1600)
    try:
        at = libc.shmat(shared, None, 0)

        def lay(following, magic=Ring.MAGIC, pins=2):
            data = struct.pack('=6I', magic, following, 3, 0, depth, pins).ljust(128, b'\0')
            data += b''.join(struct.pack('=2dQ', k, -k, k) for k in range(depth))
            ctypes.memmove(at, data, len(data))

        lay(9)
        assert Ring(key, 2).tail() == [(float(k), float(-k)) for k in (5, 6, 7, 8)]
        lay(2)
        assert Ring(key, 2).tail() == [(float(k), float(-k)) for k in (14, 15, 0, 1)]
        for wrong in ({'magic': 1}, {'pins': 3}):
            lay(2, **wrong)
            try:
                Ring(key, 2)
            except OSError:
                continue
            raise AssertionError(wrong)
    finally:
        libc.shmctl(shared, 0, None)
    try:
        Ring(key, 2)
    except OSError:
        return
    raise AssertionError('memory that is not there')


if __name__ == '__main__':
    places_are_found_again()
    a_standstill_is_left_by_its_end()
    ring_is_read_as_linuxcnc_lays_it_out()
