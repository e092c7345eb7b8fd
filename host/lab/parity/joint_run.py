"""A joint's whole firmware in a VM, as a script: set up, brought to drive, and each of its paths taken with readings.

The same for the emulated Cortex-M4 round the model of the chip (paths_joint.py) and for the WASI VM, whose registers
stand still (paths_fuel.py). Each gives ``gc``, ``timer``, the one that the board has, and

    new_board()      the board
    wait_step()      until the next current step is due
    wait_due(us)     until the joint's clock says so
    bring(number)    a frame of FRAMES has come on the bus
    mark()           a reading

Here the interrupt comes between what the main loop does and not within it, so that a late one is no fault.
"""

from array import array
from typing import Any

from firmware import chip as c
from firmware.encoders import parity
from firmware.joint_bus import Told
from firmware.joint_run import BoardRun
from shared.joint.encoder import home_by_encoder
from shared.joint.layout import JointState
from shared.joint.report import report_position
from shared.joint.tick import joint_reset
from shared.record import unpack
from shared.wire import names as w
from shared.wire.codec import ServiceRequest, Sync, encode_group, encode_service_request, encode_sync

from ...boards.build.records import place_of
from ...boards.runtimes.base import RuntimeFailure
from ...robot.file import load_robot
from ...robot.joint_gains import joint_blocks
from ...robot.joint_units import JointSetup
from .paths import NOTHING, filled

ROBOT = "parallel"  # its joints are the ones with this firmware
ROTOR, JOINT = 1234, 777  # what the encoders say, always
SAMPLES = {"shunt": 2048, "bus": 2291, "thermistor": 2000, "mcu": 950}  # counts
BEYOND_BRAD = 300  # the set-point of what is measured, so that there is a current to be controlled
NODE, SESSION, RANDOM = 1, 17, 4711
SYNC, SETPOINT, STOP, ARM, CLEAR = 1, 2, 3, 4, 5  # numbers of frames
NO_FAULT, FREE_MAILBOXES = 0x1000, 0x1C000000  # of GPIO B's inputs and of the CAN controller

BESIDE = f"""
import firmware.leaves
class Timer:
    def callback(self, handler):
        self.handler = handler
timer = Timer()
class Beside:  # what a board has beside its chip
    def timer(self, period):
        return timer
    def reset_cause(self):
        return 0
    def unique_id(self):
        return bytes(12)
    def random(self):
        return {RANDOM}
"""
SET_UP = """
import json
from firmware.joint import Joint
from firmware.settings import Memory
STORED = {stored}
class Run:
    def __init__(self, board):
        self.board = board
        self.joint = joint = Joint(board, Memory())
        control = self.control = joint.control
        joint.set_node({node})
        gc.collect()
        self.free = gc.mem_free()
        joint.parameters.take(STORED)
        control.run[{late}] = 1 << 29
        joint.start()
        self.handler = timer.handler
        self.poll = joint.poll
    def steps(self, count):
        handler = self.handler
        for _ in range(count):
            wait_step()
            handler(timer)
    def settle(self):
        while self.poll():
            pass
    def millisecond(self):
        self.steps(10)
        self.settle()
    def fed(self):
        for number in ({setpoint}, {sync}):
            bring(number)
            self.settle()
    def due(self):
        wait_due(self.joint._due_us)
    def drive(self):
        self.fed()
        self.millisecond()
        bring({arm})
        for _ in range(6):
            self.millisecond()
        return self.state()
    def state(self):
        return self.control.state[{drive}]
run = Run(new_board())
for _ in range(40):
    run.millisecond()
"""
_MEASURE = """
names, states = [], []
def cost(name, path, *given):
    names.append(name)
    mark(); path(*given); mark()
def nothing(*given):
    pass
def past_millisecond():  # none falls into the poll that is measured next
    run.due()
    run.steps(1)
    run.settle()
poll = run.poll
for _ in range(200):
    run.settle()
    run.due()
    run.steps(1)
    slow, tell = run.control._slow_ticks == 99, run.joint._told[{status_ms}] == 199
    if slow or tell:
        cost("slow" if slow else "tell", poll)
    else:
        poll()
states.append(run.drive())
for number in range(20):
    if number % 5 == 0:
        run.fed()
    run.steps(9)
    wait_step()
    cost("interrupt", run.handler, timer)
    run.settle()
    cost({nothing}, nothing)
for number in range(60):
    if number % 5 == 0:
        run.fed()
    run.settle()
    run.due()
    run.steps(1)
    if run.control._slow_ticks == 99 or run.joint._told[{status_ms}] == 199:
        poll()
    else:
        cost("motion", poll)
for name, frame in (("poll", 0), ("sync", {sync}), ("setpoint", {setpoint}), ("sync", {sync})):
    for _ in range(5):
        run.fed()
        past_millisecond()
        if frame:
            bring(frame)
        cost(name, poll)
states.append(run.state())
past_millisecond()
bring({stop})
cost("stop", poll)
run.due()
cost("stopped", poll)
states.append(run.state())
gc.collect()
print("@@" + json.dumps({"free": run.free, "left": gc.mem_free(), "names": names, "states": states}))
"""


def joint_script(board: str) -> str:
    """Return the script that measures; ``board`` is what the VM gives of its own, see above."""
    return filled_in(board + SET_UP + _MEASURE)


def filled_in(script: str) -> str:
    """Return a script with what this file knows in the place of {names}."""
    return filled(script, {
        "stored": _blocks().stored(), "node": NODE, "sync": SYNC, "setpoint": SETPOINT, "stop": STOP, "arm": ARM,
        "clear": CLEAR, "drive": place_of(JointState, "drive_state"), "enabled": w.STATE_OPERATION_ENABLED,
        "fault": w.STATE_FAULT, "late": place_of(BoardRun, "late_after_us"), "status_ms": place_of(Told, "status_ms"),
        "nothing": NOTHING,
    })  # fmt: skip


def check_driven(answer: dict[str, Any]) -> None:
    """RuntimeFailure unless the joint drove until it was stopped."""
    if answer["states"] != [w.STATE_OPERATION_ENABLED, w.STATE_OPERATION_ENABLED, w.STATE_FAULT]:
        raise RuntimeFailure(f"the joint did not drive until it was stopped: its states were {answer['states']}")


def frames(beyond_brad: int) -> dict[int, tuple[int, bytes]]:
    """Return identifier and data of each frame by its number; the set-point lies so far from where the joint is."""
    frame = array("H", [0] * 4)
    made = {STOP: (w.E_STOP_ID, b"")}
    encode_sync(frame, unpack(Sync(), (0, SESSION)))
    made[SYNC] = w.SYNC_ID, frame.tobytes()[: w.SYNC_LENGTH]
    encode_group(frame, array("i", [_position() + beyond_brad] + [w.NO_CHANGE] * 3))
    made[SETPOINT] = w.SETPOINT_POSITION_ID, frame.tobytes()
    request = [w.COMMAND_ARM, 1, SESSION, 0, (RANDOM & 0x3FFF) << 16 | w.PROTOCOL_HASH]
    encode_service_request(frame, unpack(ServiceRequest(), request))
    made[ARM] = w.SERVICE_REQUEST_ID + NODE, frame.tobytes()
    encode_service_request(frame, unpack(ServiceRequest(), (w.COMMAND_CLEAR_FAULT, 2, SESSION, 0, 0)))
    made[CLEAR] = w.SERVICE_REQUEST_ID + NODE, frame.tobytes()
    return made


def mailboxes(beyond_brad: int) -> dict[int, tuple[int, ...]]:
    """Return each frame as the four registers of a CAN controller's mailbox, by its number."""
    found: dict[int, tuple[int, ...]] = {}
    for number, (identifier, data) in frames(beyond_brad).items():
        whole = data.ljust(8, b"\0")
        halves = int.from_bytes(whole[:4], "little"), int.from_bytes(whole[4:], "little")
        found[number] = identifier << 21, len(data), *halves
    return found


def encoder_word(angle: int) -> int:
    """Return an encoder's word for an angle, with its parity."""
    return angle | parity(angle) << 15


def registers_at_rest() -> dict[int, int]:
    """Return what registers that stand still have to say, by their place: all that is waited for is there."""
    found = {c.ADC1_SR_32: c.EOC | c.JEOC, c.ADC2_SR_32: c.JEOC, c.ADC3_SR_32: c.JEOC, c.GPIOB_IDR_32: NO_FAULT}
    found |= {c.SPI1_32 + c.SPI_SR_32: c.RXNE, c.SPI3_32 + c.SPI_SR_32: c.RXNE, c.CAN_TSR_32: FREE_MAILBOXES}
    return found | dict.fromkeys((c.ADC1_JDR1_32, c.ADC2_JDR1_32, c.ADC3_JDR1_32), SAMPLES["shunt"])


def _blocks():  # type: ignore[no-untyped-def]
    blocks = joint_blocks(load_robot(ROBOT).actuator, JointSetup(-1.0, 1.9))  # type: ignore[arg-type]
    blocks.settings.commissioned, blocks.settings.elec_offset = 1, 7000
    return blocks


def _position() -> int:
    """Return where the encoders say that the joint is, as on the wire."""
    blocks = _blocks()
    joint_reset(blocks.loop, blocks.settings, blocks.state, ROTOR)
    blocks.io.joint_raw, blocks.io.joint_valid = JOINT, 1
    home_by_encoder(blocks.settings, blocks.state, blocks.io)
    return report_position(blocks.settings, blocks.state)
