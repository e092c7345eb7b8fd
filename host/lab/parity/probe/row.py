"""Records and arrays as one row of integers, whatever they are made of in this build. Takes no memory once made."""

from shared.record import set_at, size_of, value_at


class Row:
    """The integers of records, arrays, and single ones of them as (block, place), one behind the other."""

    def __init__(self, *blocks) -> None:
        self.blocks = [(block, 1 if isinstance(block, tuple) else size_of(block)) for block in blocks]

    def __len__(self) -> int:
        total = 0
        for _, size in self.blocks:
            total += size
        return total

    def __getitem__(self, at: int) -> int:
        for block, size in self.blocks:
            if at < size:
                return int(value_at(block[0], block[1]) if isinstance(block, tuple) else value_at(block, at))
            at -= size
        raise IndexError  # ends a loop over it

    def __setitem__(self, at: int, value: int) -> None:
        for block, size in self.blocks:
            if at < size:
                if isinstance(block, tuple):
                    set_at(block[0], block[1], value)
                else:
                    set_at(block, at, value)
                return
            at -= size
        raise IndexError


def clear(block) -> None:
    """Make all integers of a record or an array 0."""
    for at in range(size_of(block)):
        set_at(block, at, 0)
