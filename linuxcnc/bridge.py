#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-only
"""Between `trunnion play --linuxcnc` and a running LinuxCNC; started by it, not by hand.   bridge.py PLANS [STREAMER]

PLANS: descriptor of the memory that the rows come from (plan_buffer.h).

Says on stdout, a line each: `facts …` once, then `s WRITTEN DEPTH` now and then, `done` after an order that takes time,
`halt REASON` when LinuxCNC has ended the motion, `missing REASON` when there is nothing to speak to.
Takes on stdin a letter and, with X, A, R and B, a double for every joint:
X  its axis, as numbered in the plans
A  go to this place by LinuxCNC's own jog      R  a row for the streamer
T  from now on the axes follow the rows        B  the axes follow LinuxCNC again, which is to stand at this place

Where stdin ends while the axes follow rows, whoever sent them was killed: the plan that they come from is played to its
standstill, inside all limits, then it does as with B. The axes are given back only where LinuxCNC stands, or
where it has disabled motion; if neither comes about they stay at the last row, and it says so.

A second process of the same kind stands by. Where the first one is killed it says `lost`, plays the plan to its standstill behind the
rows that the streamer holds, and does as with B.
"""
import os
import select
import socket
import struct
import sys
import time

sys.dont_write_bytecode = True

from bridge_machine import Machine, Plans, Ring

LONGEST_ANSWER_S = 5


def say(text):
    sys.stdout.write(text + '\n')
    sys.stdout.flush()


class Spare:
    """A process that stands by, told what it has to know. It sees the end of the socket when this process is killed."""

    def __init__(self, arguments):
        self.socket, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        if os.fork() > 0:
            return
        self.socket.close()
        try:
            if theirs.recv(1) == b'M':  # the bridge has found its LinuxCNC
                stand_by(theirs, Machine(*arguments, 'trunnion-spare'))
        except Exception as error:
            print(f'the bridge that stands by: {error}', file=sys.stderr)
        finally:
            os._exit(0)

    def tell(self, letter, values=()):
        try:
            self.socket.send(letter + struct.pack(f'{len(values)}d', *values))
        except OSError:
            pass  # it has gone

    def is_ready(self, last):
        """Whether it stands by and sees the last row in the streamer."""
        self.tell(b'C', last)
        readable, _, _ = select.select([self.socket], [], [], LONGEST_ANSWER_S)
        return bool(readable) and self.socket.recv(1) == b'y'


def stand_by(bridge, machine):
    while message := bridge.recv(4096):
        values = struct.unpack(f'{len(message) // 8}d', message[1:])
        if message[:1] == b'Q':
            return
        if message[:1] == b'X':
            machine.axes = [round(value) for value in values]
        elif message[:1] == b'C':
            bridge.send(b'y' if Ring(machine.ring_key, machine.joints).tail()[-1] == values else b'n')
    try:
        say('lost')
    except OSError:
        pass  # whoever sent the rows has gone too
    machine.take_over()


def serve(machine, spare):
    size = 8 * machine.joints
    text, told, due = b'', 0.0, None
    say(machine.facts())
    while True:
        readable, _, _ = select.select([0], [], [], 0.002)
        if readable:
            got = os.read(0, 1 << 16)
            if not got:
                return
            text += got
        while text:
            long = 1 + (size if text[:1] in b'XARB' else 0)
            if len(text) < long:
                break
            letter, values = text[:1], struct.unpack(f'{(long - 1) // 8}d', text[1:long])
            text = text[long:]
            if letter == b'R':
                machine.row(values)
            elif letter == b'X':
                machine.axes = [round(value) for value in values]
                spare.tell(b'X', values)
            elif letter == b'T':
                if reason := machine.take():
                    say('halt ' + reason)
            elif letter == b'A':
                machine.flush()
                good = machine.jog_to(values)
                if good:
                    machine.ramp(machine.outputs(), values)
                    if not spare.is_ready(values):
                        print('no other bridge stands by: if this one is killed, no limit is held', file=sys.stderr)
                say('done' if good else 'halt LinuxCNC did not go to where the program begins')
            elif letter == b'B':
                say('done' if machine.give_back(values) else 'halt LinuxCNC did not take over the place')
        trouble = machine.trouble()
        if trouble:
            machine.release()
            say('halt ' + trouble)
            return
        if time.monotonic() - told > 0.002:
            told = time.monotonic()
            say(f's {machine.written} {machine.stream.depth}')


def main():
    arguments = Plans(int(sys.argv[1])), int(sys.argv[2]) if len(sys.argv) > 2 else 0
    spare = Spare(arguments)
    try:
        machine = Machine(*arguments, 'trunnion-bridge')
        spare.tell(b'M')
    except Exception as error:  # whatever LinuxCNC's modules raise, it cannot be spoken to
        say(f'missing {type(error).__name__}: {error}'.replace('\n', ' '))
        return
    try:
        serve(machine, spare)
    finally:
        machine.end()
        spare.tell(b'Q')


if __name__ == '__main__':
    main()
