"""The work of `caramelo servos` on single servos: find them, number them, set their rate, read their status."""

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from typing import Any

from ...util.errors import UserError
from ..base import JOINTS
from . import table as t
from .link import PING_PATIENCE_MS, Link, ServoError, Silent
from .roll_call import IDS

AGAIN_MS = 20.0  # 241 absent ids then take five seconds (chosen)


@dataclass(frozen=True)
class Found:
    """A servo that answered."""

    id: int
    baud: int
    model: int
    protocol: float

    @property
    def text(self) -> str:
        """The model's name."""
        names = {t.MODEL_MX28_V2: "MX-28(2.0)", t.MODEL_MX28_V1: "MX-28 (old firmware)"}
        return names.get(self.model, f"model {self.model}")


def find(link: Link, progress: Callable[[float], None] = lambda done: None) -> list[Found]:
    """Return all servos that answer at the port's present rate, by id.

    All are asked together, then each id separately that has not answered. If fewer than a robot has answer, they are
    asked once more.
    """
    models = link.ping_all()
    models |= _ask_each(link, models, PING_PATIENCE_MS, progress)
    if 0 < len(models) < JOINTS:
        models |= _ask_each(link, models, AGAIN_MS, progress) if link.protocol == 1.0 else link.ping_all()
    return [Found(number, link.port.getBaudRate(), models[number], link.protocol) for number in sorted(models)]


def _ask_each(link: Link, known: Collection[int], patience_ms: float,
              progress: Callable[[float], None]) -> dict[int, int]:
    """Return the models of servos other than the known ones, which are asked one by one."""
    found = dict[int, int]()
    for number in range(IDS):
        model = None if number in known else link.ping(number, 1, patience_ms)
        if model is not None:
            found[number] = model
        progress((number + 1) / IDS)
    return found


def find_at_all_rates(link: Link, progress: Callable[[float], None] = lambda done: None) -> Iterator[Found]:
    """Yield the servos at every rate; the port keeps the last rate that the machine supports."""
    for at, baud in enumerate(t.BAUDS):
        if link.port.setBaudRate(baud):
            yield from find(link, lambda done, at=at: progress((at + done) / len(t.BAUDS)))  # type: ignore[misc]


def set_id(link: Link, old: int, new: int) -> None:
    """Give a servo another id; ServoError if that id is taken: two servos would talk at once."""
    for number in (old, new):
        if not 0 <= number < IDS:
            raise UserError(f"id {number}: allowed 0 .. {IDS - 1}")
    if old == new:
        raise UserError(f"id {new}: the servo has this id already")
    if link.ping(old) is None:
        raise ServoError(f"no servo answers with id {old}: find it with: caramelo servos scan")
    if link.ping(new) is not None:
        raise ServoError(f"id {new} is taken by another servo: renumber or unplug that one first")
    link.write(old, t.TORQUE_ENABLE, 0)
    _write_unless_moved(link, old, t.ID, new, lambda: link.ping(new) is not None)
    if link.ping(new) is None:
        raise ServoError(f"the servo no longer answers as {old} or as {new}: check its cable, then scan")


def set_baud(link: Link, servo: int, baud: int) -> None:
    """Set a servo's rate; from then on it answers only at that rate."""
    if baud not in t.BAUDS:
        raise UserError(f"{baud} baud: allowed {', '.join(map(str, t.BAUDS))}")
    if link.ping(servo) is None:
        raise ServoError(f"no servo answers with id {servo}: find it with: caramelo servos scan --all-bauds")
    link.write(servo, t.TORQUE_ENABLE, 0)

    def answers_there() -> bool:
        return bool(link.port.setBaudRate(baud)) and link.ping(servo) is not None

    _write_unless_moved(link, servo, t.BAUD, t.BAUDS.index(baud), answers_there)
    if not answers_there():
        raise ServoError(
            f"servo id {servo} does not answer at {baud} baud: find it with: caramelo servos scan --all-bauds"
        )


def _write_unless_moved(link: Link, servo: int, register: Any, value: int, moved: Callable[[], bool]) -> None:
    """Write a register that changes how the servo is reached; a lost confirmation is not an error."""
    try:
        link.write(servo, register, value)
    except ServoError:
        if not moved():
            raise


@dataclass(frozen=True)
class Status:
    """One servo at one moment."""

    id: int
    model: int
    firmware: int
    position: int
    load: float
    voltage_V: float
    temperature_C: int
    torque: bool
    error: str


def status(link: Link, servo: int) -> Status | None:
    """Return what a servo reports about itself, or None if it does not answer, or no longer."""
    model = link.ping(servo)
    if model is None:
        return None
    try:
        return _report(link, servo, model)
    except Silent:
        return None


def _report(link: Link, servo: int, model: int) -> Status:
    return Status(
        id=servo,
        model=model,
        firmware=link.read(servo, t.FIRMWARE),
        position=link.read(servo, t.PRESENT_POSITION),
        load=link.read(servo, t.PRESENT_LOAD) * t.LOAD_SHARE,
        voltage_V=round(link.read(servo, t.PRESENT_VOLTAGE) * t.VOLTS, 1),
        temperature_C=link.read(servo, t.PRESENT_TEMPERATURE),
        torque=bool(link.read(servo, t.TORQUE_ENABLE)),
        error=t.hardware_error_text(link.read(servo, t.HARDWARE_ERROR)),
    )
