"""Records and arrays as one row of integers, whatever they are made of in this build. Takes no memory once made."""


class Row:
    """The integers of records, arrays, and single ones of them as (block, place), one behind the other."""

    def __init__(self, *blocks) -> None:
        self.blocks = blocks

    def __len__(self) -> int:
        total = 0
        for block in self.blocks:
            total += _size(block)
        return total

    def __getitem__(self, at: int) -> int:
        for block in self.blocks:
            size = _size(block)
            if at < size:
                return int(_get(block, at))
            at -= size
        raise IndexError  # ends a loop over it

    def __setitem__(self, at: int, value: int) -> None:
        for block in self.blocks:
            size = _size(block)
            if at < size:
                _set(block, at, value)
                return
            at -= size
        raise IndexError


def _size(block) -> int:
    """Return how many integers a block has."""
    if isinstance(block, tuple):
        return 1
    fields = getattr(block, "FIELDS", None)
    if fields is None:
        return len(block)
    total = 0
    for name, place in fields:
        total += _span(getattr(block, name), place)
    return total


def _span(value, place) -> int:
    """Return how many integers a field has."""
    if place.of is None:
        return place.count or 1
    return _size(value) if place.count is None else place.count * _size(value[0])


def _get(block, at: int) -> int:
    if isinstance(block, tuple):
        return _get(block[0], block[1])
    fields = getattr(block, "FIELDS", None)
    if fields is None:
        return block[at]
    for name, place in fields:
        value = getattr(block, name)
        span = _span(value, place)
        if at < span:
            if place.of is None:
                return value if place.count is None else value[at]
            size = _size(value) if place.count is None else _size(value[0])
            return _get(value if place.count is None else value[at // size], at % size)
        at -= span
    raise IndexError


def _set(block, at: int, value: int) -> None:
    if isinstance(block, tuple):
        _set(block[0], block[1], value)
        return
    fields = getattr(block, "FIELDS", None)
    if fields is None:
        block[at] = value
        return
    for name, place in fields:
        inner = getattr(block, name)
        span = _span(inner, place)
        if at < span:
            if place.of is None and place.count is None:
                setattr(block, name, value)
            elif place.of is None:
                inner[at] = value
            else:
                size = _size(inner) if place.count is None else _size(inner[0])
                _set(inner if place.count is None else inner[at // size], at % size, value)
            return
        at -= span
    raise IndexError


def clear(block) -> None:
    """Make all integers of a record or an array 0."""
    for at in range(_size(block)):
        _set(block, at, 0)
