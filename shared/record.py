"""Records: blocks of integers whose places have names, declared once with unit and meaning.

    @record
    class Sway:
        now: int = field("lu", "body to the left of the feet")
        age: Ints = vector(LEGS, "ticks", "since the planned touchdown, 0 in swing")

``Sway()`` has every value at its default. Here it is an object with one attribute per field; for viper, native code and
C the build (host/boards/build/records.py) makes one array of it, and each name becomes an index. A record may hold
others: ``part`` one, ``parts`` a list of them. If loops treat all fields alike, as a filter does the axes of a pose, it
is an ``Axes``. ``pack`` and ``unpack`` turn a record into integers, where it leaves the program, and back.
"""

from array import array

from .runtime import CPYTHON

_made = [0]  # how many fields have been declared: MicroPython does not keep a class's names in order


class Field:
    """One entry of a record: ``count`` integers, a single one if None; or as many records of the class ``of``."""

    def __init__(self, unit, meaning, default, count, of):
        _made[0] += 1
        self.order = _made[0]
        self.unit = unit
        self.meaning = meaning
        self.default = default
        self.count = count
        self.of = of

    def make(self):
        """Return a new value for it."""
        if self.count is None:
            return self.of() if self.of else self.default
        return [self.of() for _ in range(self.count)] if self.of else [self.default] * self.count


def field(unit, meaning, default=0):
    """Declare one integer: ``name: int = field(unit, meaning)``."""
    return Field(unit, meaning, default, None, None)


def vector(count, unit, meaning, default=0):
    """Declare ``count`` integers: ``name: Ints = vector(count, unit, meaning)``."""
    return Field(unit, meaning, default, count, None)


def part(of, meaning):
    """Declare a record in the record: ``name: Leg = part(Leg, meaning)``."""
    return Field("", meaning, 0, None, of)


def parts(count, of, meaning):
    """Declare ``count`` records in the record: ``name: list[Leg] = parts(LEGS, Leg, meaning)``."""
    return Field("", meaning, 0, count, of)


class Axes:
    """Base of records of single integers whose fields are also read and written by number, in loops.

    ``pose[axis]`` is the field that stands at place ``axis`` of its declaration, the first at 0.
    """

    __slots__ = ()
    FIELDS: tuple = ()

    def __getitem__(self, axis: int) -> int:
        return getattr(self, self.FIELDS[axis][0])

    def __setitem__(self, axis: int, value: int) -> None:
        setattr(self, self.FIELDS[axis][0], value)


def record(declared):
    """Return the class whose objects have the fields that the class ``declared`` declares."""
    found = [(name, place) for name, place in declared.__dict__.items() if isinstance(place, Field)]
    found.sort(key=lambda pair: pair[1].order)

    def begin(self):
        for name, place in found:
            setattr(self, name, place.make())

    if CPYTHON:  # with slots an attribute is read as fast as a list's element
        names = [name for name, _ in found]
        body = {"__slots__": names, "__doc__": declared.__doc__, "__module__": declared.__module__}
        declared = type(declared.__name__, declared.__bases__, body)
    declared.__init__ = begin
    declared.FIELDS = tuple(found)
    return declared


def block(size, given=()):
    """Return what the build makes of a record: ``size`` integers, 0 except the pairs of place and value ``given``."""
    made = array("i", [0] * size)
    for at, value in given:
        made[at] = value
    return made


def pack(values):
    """Return the integers of a record, or of an array, in the order of their declaration."""
    fields = getattr(values, "FIELDS", None)
    if fields is None:
        return list(values)
    made = []
    for name, place in fields:
        value = getattr(values, name)
        for one in [value] if place.count is None else value:
            if place.of:
                made += pack(one)
            else:
                made.append(one)
    return made


def copy(values, into):
    """Copy the values of a record into another one of its kind. Takes no memory."""
    fields = getattr(values, "FIELDS", None)
    if fields is None:
        for at in range(len(values)):
            into[at] = values[at]
        return
    for name, place in fields:
        value = getattr(values, name)
        if place.count is None and place.of is None:
            setattr(into, name, value)
        elif place.count is None or place.of is None:
            copy(value, getattr(into, name))
        else:
            for at in range(place.count):
                copy(value[at], getattr(into, name)[at])


def size_of(values):
    """Return how many integers a record, or an array, has. Takes no memory."""
    fields = getattr(values, "FIELDS", None)
    if fields is None:
        return len(values)
    total = 0
    for name, place in fields:
        total += _span(getattr(values, name), place)
    return total


def _span(value, place):
    """Return how many integers a field with this value has."""
    if place.of is None:
        return 1 if place.count is None else place.count
    return size_of(value) if place.count is None else place.count * size_of(value[0])


def value_at(values, at):
    """Return the integer at place ``at`` of a record, in the order of declaration, or of an array. Takes no memory."""
    fields = getattr(values, "FIELDS", None)
    if fields is None:
        return values[at]
    for name, place in fields:
        value = getattr(values, name)
        span = _span(value, place)
        if at < span:
            if place.of is None:
                return value if place.count is None else value[at]
            size = span if place.count is None else span // place.count
            return value_at(value if place.count is None else value[at // size], at % size)
        at -= span
    raise IndexError


def set_at(values, at, new):
    """Write the integer at place ``at`` of a record, in the order of declaration, or of an array. Takes no memory."""
    fields = getattr(values, "FIELDS", None)
    if fields is None:
        values[at] = new
        return
    for name, place in fields:
        value = getattr(values, name)
        span = _span(value, place)
        if at < span:
            if place.of:
                size = span if place.count is None else span // place.count
                set_at(value if place.count is None else value[at // size], at % size, new)
            elif place.count is None:
                setattr(values, name, new)
            else:
                value[at] = new
            return
        at -= span
    raise IndexError


def unpack(values, integers):
    """Write integers into a record or array, in the order declared; return it. ValueError if too many or too few."""
    left = list(integers)
    left.reverse()
    _take(values, left)
    if left:
        raise ValueError(f"{len(left)} integers too many")
    return values


def _take(values, left):
    """Take the record's integers off the end of ``left``."""
    fields = getattr(values, "FIELDS", None)
    if fields is None:
        for at in range(len(values)):
            values[at] = _next(left)
        return
    for name, place in fields:
        if place.of:
            value = getattr(values, name)
            for one in [value] if place.count is None else value:
                _take(one, left)
        elif place.count is None:
            setattr(values, name, _next(left))
        else:
            _take(getattr(values, name), left)


def _next(left):
    if not left:
        raise ValueError("integers are missing")
    return left.pop()
