"""The guided set-up of servos, one at a time on the bus: finds it with any settings, and sets it up for its joint.

    plug in one -> find it -> is it the right kind? -> settings, id, rate -> read back -> keep

It writes only settings that differ, so a servo that lost power half-way can be plugged in again and completed. After
every servo a file keeps what is done.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from ...robot.model import Robot
from ...util.console import progress
from ...util.errors import UserError
from ..base import JOINT_LABELS
from . import table as t
from .calibration.person import Person
from .kept import read_kept, write_kept
from .link import Link, ServoError
from .tools import Found, set_baud, set_id

FACTORY_BAUD = t.BAUDS[t.BAUD.initial]
ALWAYS = 2  # rates that are always searched: a new servo's and the bus's
SLOW = 3  # rates that are searched when each id has to be asked separately, two seconds per rate
# All settings as in a new servo, except the delay of answers; id, rate and protocol are not among them.
SETTINGS = {
    name: (register, 0 if register is t.RETURN_DELAY else register.initial)
    for name, register in t.REGISTERS.items()
    if register.eeprom and register.writable and register not in (t.ID, t.BAUD, t.PROTOCOL)
}
# Load to temperature: two servos with the same id differ somewhere in it, and damage each other's answer.
LIVE = t.Register(t.PRESENT_LOAD.address, t.PRESENT_TEMPERATURE.address + 1 - t.PRESENT_LOAD.address, 0, 0, 0, False)


@dataclass(frozen=True)
class Done:
    """One servo set up: its present and former id and rate, and how many other settings were written."""

    id: int
    baud: int
    firmware: int
    found_id: int
    found_baud: int
    written: int


class Setup:
    """The servos of one robot on an open port, and a person who plugs them in.

    ``ids``: one for each joint. ``keep``: the file with what is done so far, or None. ``plug`` plugs servos in for the
    simulation: it is called with the joint whose servo is wanted.
    """

    def __init__(self, robot: Robot, link: Link, person: Person, ids: Sequence[int], baud: int,
                 keep: Path | None = None, plug: Callable[[int], None] | None = None) -> None:
        self.robot, self.link, self.person, self.ids, self.baud = robot, link, person, ids, baud
        self.keep, self._plug = keep, plug
        self.done: dict[int, Done] = {}

    def run(self, joints: Sequence[int]) -> dict[int, Done]:
        """Set up the servos of these joints, one after the other; return what is done, by joint."""
        self.resume()
        for joint in joints:
            while joint not in self.done:
                self.one(joint)
        if self.keep is not None:
            self.keep.unlink(missing_ok=True)
        return self.done

    def one(self, joint: int) -> None:
        """Ask for one servo and set it up; if that fails, say why, and a person who is there may try once more."""
        label = JOINT_LABELS[joint]
        self.person.ask(f"{label} plugged", f"\nPlug in the servo of {label}, and no other.", [])
        if self._plug is not None:
            self._plug(joint)
        try:
            found = self.find()
            if self.is_another(label, found):
                self.done[joint] = self.set_up(self.ids[joint], found)
        except ServoError as error:
            if not self.person.there:
                raise
            self.person.say(f"  {error}")
        else:
            if joint in self.done:
                self.save()
                self.person.say(f'  {label}: id {self.ids[joint]} at {self.baud} baud, was id {found.id} at '
                                f'{found.baud}. Its LED is on: write "{label} {self.ids[joint]}" on it.')

    def find(self) -> Found:
        """Return the only servo on the bus, whatever its id and rate; ServoError if there are none or several."""
        wanted, other = self.link.protocol, 3.0 - self.link.protocol  # 2.0 and 1.0
        found = self._search(wanted) or self._search(other)
        where = self.link.port.port_name
        if not found:
            raise ServoError(f"no servo answers on {where} at any rate: check its power and its cable")
        if len(found) > 1:
            those = ", ".join(f"id {servo.id} at {servo.baud} baud" for servo in found)
            raise ServoError(f"{len(found)} servos answer ({those}): leave one plugged in")
        self._suitable(found[0], wanted)
        self._alone(found[0].id)
        return found[0]

    def _search(self, protocol: float) -> list[Found]:
        """Return the servos that answer at a new servo's rate and the bus's, else at the first rate where one does."""
        link, found = Link(self.link.port, protocol), list[Found]()
        rates = list(dict.fromkeys((FACTORY_BAUD, self.baud, 1_000_000, *t.BAUDS)))
        rates = rates[:SLOW] if protocol == 1.0 != self.link.protocol else rates
        with progress("looking for the servo", len(rates)) as tell:
            for at, baud in enumerate(rates):
                if found and at >= ALWAYS:
                    break
                tell(at, f"at {baud} baud")
                if link.port.setBaudRate(baud):
                    found += [Found(number, baud, model, protocol) for number, model in link.ping_all().items()]
        return found

    def _suitable(self, found: Found, protocol: float) -> None:
        """Refuse a servo of another kind; from then on the port uses the servo's rate."""
        if found.model != t.MODEL_MX28_V2:
            old = "; update its firmware to (2.0) with Dynamixel Wizard" * (found.model == t.MODEL_MX28_V1)
            raise ServoError(f"servo id {found.id} is not an MX-28(2.0) but {found.text}{old}")
        if found.protocol != protocol:
            raise ServoError(f"servo id {found.id} speaks protocol {found.protocol}, but {self.robot.name} needs "
                             f"{protocol}: set its Protocol Type to {protocol:.0f} with Dynamixel Wizard")
        self.link.port.setBaudRate(found.baud)
        firmware = self.link.read(found.id, t.FIRMWARE)
        if firmware < t.WATCHDOG_FIRMWARE:
            raise ServoError(f"servo id {found.id} has firmware {firmware}, but needs {t.WATCHDOG_FIRMWARE} or newer: "
                             f"update it with Dynamixel Wizard")
        tripped = t.hardware_error_text(self.link.read(found.id, t.HARDWARE_ERROR))
        if tripped:
            raise ServoError(f"servo id {found.id} has tripped: {tripped}; switch its power off and on")

    def _alone(self, servo: int) -> None:
        damaged = self.link.counters.corrupted
        try:
            self.link.read(servo, LIVE)
        except ServoError:
            if self.link.counters.corrupted == damaged:
                raise
            raise ServoError(f"the answers of id {servo} are damaged, as if two servos with that id talked at once: "
                             f"leave one plugged in") from None

    def is_another(self, label: str, found: Found) -> bool:
        """Return whether this is another servo than one done before; only a person can tell."""
        former = [joint for joint, done in self.done.items() if (done.id, done.baud) == (found.id, found.baud)]
        if not former:
            return True
        question = f"{JOINT_LABELS[former[0]]} has id {found.id} at {found.baud} baud. Is this another servo?"
        if self.person.ask(f"{label} another", question, ["yes", "no"]) == "yes":
            return True
        self.person.refuse(f"{label} another", f"then unplug it, and plug in the servo of {label}")
        return False

    def set_up(self, number: int, found: Found) -> Done:
        """Write what differs: settings, then id, then rate; read everything back, and light the LED."""
        link, servo = self.link, found.id
        link.write(servo, t.TORQUE_ENABLE, 0)
        differ = self._differing(servo)
        for name in differ:
            link.write(servo, *SETTINGS[name])
        if servo != number:
            set_id(link, servo, number)
        if found.baud != self.baud:
            set_baud(link, number, self.baud)
        lost = self._differing(number)
        if lost:
            raise ServoError(f"servo id {number} did not keep {', '.join(lost)}: plug it in again, or use another")
        link.write(number, t.LED, 1)
        return Done(number, self.baud, link.read(number, t.FIRMWARE), servo, found.baud, len(differ))

    def _differing(self, servo: int) -> list[str]:
        return [name for name, (register, value) in SETTINGS.items() if self.link.read(servo, register) != value]

    def save(self) -> None:
        """Keep what is done so far."""
        if self.keep is not None:
            write_kept(self.keep, self.robot.name, self.done)

    def resume(self) -> None:
        """Go on with an earlier, unfinished set-up if there is one and the person wants it."""
        if self.keep is None or not self.keep.exists():
            return
        done = read_kept(self.keep, self.robot.name, Done)
        if any((it.id, it.baud) != (self.ids[joint], self.baud) for joint, it in done.items()):
            raise UserError(f"{self.keep}: begun with other ids or another rate; delete the file to start again")
        question = f"{len(done)} of {len(JOINT_LABELS)} servos are already set up. Go on with the others?"
        if self.person.ask("resume", question, ["yes", "no"]) == "yes":
            self.done = done
