"""Runs planner, attitude and controllers on checked integers with any words for input; a process of its own.

Reads JSON from stdin: params (blocks), attitudes (blocks), ticks. Prints the largest value met, as JSON. Checked
integers replace `array` and all of shared/, so nothing of either may be imported before.
"""

import json
import random
import sys

from host.lab.parity import checked


def word(dice):
    """Return any 30-bit word, of any size."""
    return dice.randint(-(1 << 30), (1 << 30) - 1) >> dice.randrange(30)


def drive_planner(params, ticks, dice):
    """Any words in command and senses, with modes that lead through all states."""
    from shared.body.params import Params
    from shared.planner.command import Command
    from shared.planner.planner import Planner
    from shared.record import pack, unpack
    from shared.sense.sensed import Sensed

    robot = Params()
    unpack(robot, params)
    planner = Planner(robot)
    command, sensed = Command(), Sensed()
    for tick in range(ticks):
        if tick % 4 == 0:
            unpack(command, [word(dice) if dice.randrange(3) == 0 else value for value in pack(command)])
            sensed.unpack([checked.check(word(dice)) if dice.randrange(9) == 0 else value for value in sensed.pack()])
            command.mode = checked.check(dice.choice((0, 1, 2, 2, 2, 2, 2, 2, 3, word(dice))))
        checked.check(planner.tick(command, sensed))


def drive_attitude(array, block, ticks, dice):
    """Any readings, half of them at the ends of int16; every trust and tolerance."""
    from shared.record import unpack
    from shared.sense.attitude import Attitude, attitude_step

    ends = (-32768, -32767, -1, 0, 1, 16384, 32767)
    for trust in (0, 700, 32767):
        made = Attitude()
        unpack(made, block)
        made.trust_q15, made.tolerance, made.align_ticks = map(checked.check, (trust, 32767, 3))
        if trust:
            made.gyro_q30 = checked.check(0x1FFFF)
        reading = array("i", [0] * 6)
        for tick in range(ticks):
            wild = tick > 3
            values = [dice.choice(ends) if dice.randrange(2) else dice.randint(-32768, 32767) for _ in range(6)]
            for at, value in enumerate(values if wild else (0, 0, 0, 0, 0, 16384)):
                reading[at] = value
            checked.check(attitude_step(made, reading))


def drive_pid(ticks, dice):
    """The largest gains and limits, any angles."""
    from shared.num.pid import Pid, pid_step
    from shared.record import unpack

    made = Pid()
    unpack(made, (32767, 32767, 32767, 16383, 16383, 0, 0, 0))
    for _ in range(ticks):
        ends = [dice.choice((-32768, 32767, -(1 << 20), 1 << 20, dice.randint(-9000, 9000))) for _ in range(2)]
        checked.check(pid_step(made, *ends))


def main():
    asked = json.load(sys.stdin)
    checked.install()
    from array import array

    dice = random.Random(5)
    for params in asked["params"]:
        drive_planner(params, asked["ticks"], dice)
    for block in asked["attitudes"]:
        drive_attitude(array, block, asked["ticks"], dice)
    drive_pid(asked["ticks"], dice)
    print(json.dumps({"largest": checked.WATCH.largest}))


main()
