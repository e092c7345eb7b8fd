"""Who drives: one client at a time, by priority; a dead-man; an emergency stop that anyone may give, which latches."""

from dataclasses import dataclass, field, replace

from .messages import Drive, Message

DEAD_MAN_S = 0.300
# A driver who has been silent for this long has left.
LEFT_S = 3.0
PRIORITY = {"script": 0, "foxglove": 1, "web": 1, "gamepad": 2, "keyboard": 3}


@dataclass(frozen=True)
class Client:
    """A sender of messages: its source, and its number among those of that source."""

    source: str
    number: int = 0

    @property
    def priority(self) -> int:
        """A higher one takes the controls from a lower one."""
        return PRIORITY[self.source]

    def __str__(self) -> str:
        return f"{self.source} {self.number}" if self.number else self.source


@dataclass(frozen=True)
class Stop:
    """An emergency stop: who gave it, when, and when by the sender's own clock (or None)."""

    client: Client
    time_s: float
    t_ms: float | None = None


@dataclass(frozen=True)
class Pending:
    """The oldest drive message not yet sent to the joints: from whom, the sender's time or None, if sticks moved."""

    source: str
    t_ms: float | None
    moved: bool


@dataclass
class Arbiter:
    """Takes checked messages of all clients and holds the present commands. Times are monotonic seconds."""

    gait: str
    gaits: tuple[str, ...]
    posture: str = "rest"
    balance: bool = True
    driver: Client | None = None
    drive: Drive = field(default_factory=Drive)
    stop: Stop | None = None
    refused: int = 0
    obeyed: int = 0
    refusal: str = ""
    _heard_s: float = 0.0
    pending: Pending | None = None

    def handle(self, client: Client, message: Message, now_s: float) -> bool:
        """Obey a message or refuse it; ``refusal`` says why. True if obeyed."""
        kind = message["type"]
        if kind == "stop":
            self._pull(client, now_s, message.get("t_ms"))
            return True
        if kind == "release":
            return self._release(client)
        if not self._admit(client, now_s):
            return False
        obeyed = self._obey(client, message)
        self.obeyed += obeyed
        return obeyed

    def _obey(self, client: Client, message: Message) -> bool:
        """Do what the driver says; False if it is refused."""
        kind = message["type"]
        if kind == "reset":
            self.stop, self.posture, self.drive = None, "rest", Drive()
        elif kind == "drive":
            self._steer(client, message)
        elif kind == "posture":
            if self.stop is not None:
                return self._refuse(f"emergency stop by {self.stop.client}: reset it first")
            self.posture = message["posture"]
        elif kind == "gait":
            if message["gait"] not in self.gaits:
                return self._refuse(f"no such gait; there are {', '.join(self.gaits)}")
            self.gait = message["gait"]
        elif kind == "balance":
            self.balance = message["on"]
        return True

    def drop(self, client: Client) -> None:
        """A client is gone. The robot stops at once if it was the driver."""
        if client == self.driver:
            self.driver, self.drive = None, Drive(pose=self.drive.pose)

    def fresh(self, now_s: float) -> bool:
        """True while the driver's last command is younger than the dead-man's time."""
        return self.driver is not None and now_s - self._heard_s <= DEAD_MAN_S

    def silent_s(self, now_s: float) -> float:
        """How long the driver has been silent."""
        return now_s - self._heard_s

    def update(self, now_s: float) -> Drive:
        """Return the sticks' command now: no speed without a fresh message. A silent driver loses the controls."""
        if self.driver is not None and now_s - self._heard_s > LEFT_S:
            self.drop(self.driver)
        return self.drive if self.fresh(now_s) else Drive(pose=self.drive.pose)

    def _pull(self, client: Client, now_s: float, t_ms: float | None) -> None:
        """Keep the first stop, and drop every command from before it."""
        if self.stop is None:
            self.stop = Stop(client, now_s, t_ms)
        self.posture, self.drive, self.pending = "rest", Drive(), None

    def _steer(self, client: Client, message: Message) -> None:
        before, self.drive = self.drive, Drive.of(message)
        oldest = self.pending or Pending(client.source, message.get("t_ms"), moved=False)
        self.pending = replace(oldest, moved=oldest.moved or self.drive != before)

    def _release(self, client: Client) -> bool:
        if client != self.driver:
            return self._refuse("you do not drive")
        self.drop(client)
        return True

    def _admit(self, client: Client, now_s: float) -> bool:
        """Accept the driver, and a client that finds the seat free or has priority over the driver."""
        driver = self.driver
        if driver is not None and client != driver:
            left = now_s - self._heard_s > LEFT_S
            if not left and client.priority <= driver.priority:
                return self._refuse(f"{driver} drives")
        if client != driver:
            self.driver, self.drive = client, Drive(pose=self.drive.pose)
        self._heard_s = now_s
        self.refusal = ""
        return True

    def _refuse(self, why: str) -> bool:
        self.refused += 1
        self.refusal = why
        return False
