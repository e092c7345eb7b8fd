"""Records and arrays as one row of integers, whatever they are made of in this build."""


class Row:
    """The integers of records, arrays, and single ones of them as (block, place), one behind the other."""

    def __init__(self, *blocks) -> None:
        self.places: list = []
        for block in blocks:
            if isinstance(block, tuple):
                self.places.append(_places(block[0])[block[1]])
            else:
                self.places += _places(block)

    def __len__(self) -> int:
        return len(self.places)

    def __getitem__(self, at: int) -> int:
        if at >= len(self.places):  # ends a loop over it
            raise IndexError
        owner, name = self.places[at]
        return int(getattr(owner, name) if isinstance(name, str) else owner[name])

    def __setitem__(self, at: int, value: int) -> None:
        owner, name = self.places[at]
        if isinstance(name, str):
            setattr(owner, name, value)
        else:
            owner[name] = value


def _places(block) -> list:
    """Return (owner, name or index) of each integer of a record or an array, in the order of its declaration."""
    fields = getattr(block, "FIELDS", None)
    if fields is None:
        return [(block, at) for at in range(len(block))]
    found = []
    for name, place in fields:
        value = getattr(block, name)
        if place.of:
            for one in [value] if place.count is None else value:
                found += _places(one)
        elif place.count is None:
            found.append((block, name))
        else:
            found += [(value, at) for at in range(place.count)]
    return found
