"""One public function with everything the checks need to know about it."""

from shared.record import pack

from .draw import Dice, Digest, Range
from .row import Row


class Block:
    """An array or record that is filled anew for each vector: ``(count, Range)`` pairs in order."""

    def __init__(self, array, *parts) -> None:
        self.array = array
        self.row = Row(array)
        self.parts = parts

    def fill(self, dice: Dice) -> None:
        at = 0
        for count, spread in self.parts:
            for _ in range(count):
                self.row[at] = spread.any(dice)
                at += 1


class Pick:
    """An argument chosen for each vector among objects, e.g. among the parameters of both robots."""

    def __init__(self, *choices) -> None:
        self.choices = choices

    def any(self, dice: Dice):
        return dice.choose(self.choices)


class Head:
    """A record without its last field, ``size`` numbers that never change: to be watched without them."""

    def __init__(self, values, size: int) -> None:
        self.values = values
        self.FIELDS = getattr(values, "FIELDS", None)  # None: the build has made an array of it
        if self.FIELDS is None:
            self.size = len(values) - size
        else:
            self.FIELDS = self.FIELDS[:-1]

    def __getattr__(self, name: str):
        return getattr(self.values, name)

    def __len__(self) -> int:
        return self.size

    def __getitem__(self, at: int) -> int:
        if at >= self.size:  # ends a loop over it
            raise IndexError
        return int(self.values[at])

    def __setitem__(self, at: int, value: int) -> None:
        self.values[at] = value


class Probe:
    """How to feed one function of a module or object, and what is promised about it.

    name: the function's, and behind a colon which of its probes this is, if it has several.
    arguments: a Range draws an integer, a Block fills its array, a Pick chooses; any other object
    is passed as it is. watch: arrays digested after every call, besides the result.
    fit(values, dice): mends drawn values that the function's contract excludes together.
    begin(): puts state back before the first vector.
    ticks: False for what runs once at set-up and may allocate. vectors: how many times the usual
    number of vectors it gets.
    """

    is_walk = False  # True: each call goes on from the one before, and what it is given answers that one

    def __init__(self, source, name, arguments, watch=(), fit=None, begin=None, ticks=True, vectors=1) -> None:
        self.name = name
        colon = name.find(":")
        self.function = getattr(source, name if colon < 0 else name[:colon])
        self.arguments = arguments
        self.watch = watch
        self.fit = fit
        self.begin = begin
        self.ticks = ticks
        self.vectors = vectors
        self.values = list(arguments)
        self.wrap = None  # a type to pass integers in, for the overflow check
        self.dice = Dice(1)

    def count(self, usual: int) -> int:
        """Return how many vectors this function gets when the usual number is ``usual``."""
        return self.vectors * usual

    def start(self) -> None:
        """Go back to the first vector."""
        seed = 0
        for letter in self.name:
            seed = (seed * 31 + ord(letter)) & 0x3FFFFF
        self.dice = Dice(seed)
        if self.begin:
            self.begin()

    def draw(self, index: int, count: int) -> None:
        """Put the arguments of vector ``index`` of ``count`` into ``values``."""
        stride = 1
        for at in range(len(self.arguments)):
            argument = self.arguments[at]
            if isinstance(argument, Range):
                if index < count >> 1 and index < 400:
                    self.values[at] = argument.edge(index // stride)
                    stride *= len(argument.edges)
                else:
                    self.values[at] = argument.any(self.dice)
            elif isinstance(argument, Block):
                argument.fill(self.dice)
                self.values[at] = argument.array
            elif isinstance(argument, Pick):
                self.values[at] = argument.any(self.dice)
        if self.fit:
            self.fit(self.values, self.dice)
        if self.wrap:
            for at in range(len(self.values)):
                if isinstance(self.values[at], int):
                    self.values[at] = self.wrap(self.values[at])

    def call(self):
        """Call the function on ``values``; without star arguments, which would allocate."""
        f = self.function
        v = self.values
        n = len(v)
        if n == 0:
            return f()
        if n == 1:
            return f(v[0])
        if n == 2:
            return f(v[0], v[1])
        if n == 3:
            return f(v[0], v[1], v[2])
        if n == 4:
            return f(v[0], v[1], v[2], v[3])
        if n == 5:
            return f(v[0], v[1], v[2], v[3], v[4])
        if n == 6:
            return f(v[0], v[1], v[2], v[3], v[4], v[5])
        return f(*v)

    def digest(self, count: int, total: int) -> int:
        """Return the digest of the first ``count`` of ``total`` vectors."""
        digest = Digest()
        self.start()
        for index in range(count):
            self.draw(index, total)
            result = self.call()
            if result is None or isinstance(result, int):
                digest.add(result or 0)
            else:
                _add(result, digest)
            for block in self.watch:
                _add(block, digest)
        return digest.number()

    def show(self, index: int, count: int):
        """Return the inputs, the result and the watched arrays of vector ``index`` of ``count``."""
        self.start()
        for at in range(index + 1):
            self.draw(at, count)
            if at < index:
                self.call()
        inputs = [_plain(value) for value in self.values]
        result = _plain(self.call())
        return inputs, result, [_plain(block) for block in self.watch]


def probe_with(watch=(), fit=None, begin=None, ticks=True, vectors=1):
    """Return what makes a Probe with these options, unless it is given its own."""

    def made(source, name, arguments, watch=watch, fit=fit, begin=begin, ticks=ticks, vectors=vectors):
        return Probe(source, name, arguments, watch, fit, begin, ticks, vectors)

    return made


def _add(block, digest: Digest) -> None:
    """Digest an array, or a record in the order of its declaration. Takes no memory: the VMs collect no garbage."""
    fields = getattr(block, "FIELDS", None)
    if fields is None:
        digest.add_all(block, len(block))
        return
    row, filled = digest.row, 0
    for name, place in fields:
        value = getattr(block, name)
        if place.count is None and place.of is None:
            row[filled] = value
            filled += 1
            continue
        digest.add_all(row, filled)
        filled = 0
        if place.of is None:
            digest.add_all(value, place.count)
        elif place.count is None:
            _add(value, digest)
        else:
            for one in value:
                _add(one, digest)
    digest.add_all(row, filled)


def _plain(value):
    """Return what JSON can hold: numbers as they are, arrays as lists, other objects by their kind."""
    if value is None or isinstance(value, int):
        return value
    if hasattr(value, "FIELDS"):
        return pack(value)
    try:
        return [_plain(part) for part in value]
    except TypeError:
        return type(value).__name__
