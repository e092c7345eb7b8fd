"""What is sent and believed, in rad: goals no faster than the joints, and no reading that stands alone."""

from .fixed import limit


def follow(wanted, joints, tops, coupled):
    """Return ``joints`` moved towards ``wanted``; a coupled calf's motor turns thigh + calf."""
    made = []
    for at in range(0, 12, 3):
        hip, thigh, calf = [wanted[at + i] - joints[at + i] for i in range(3)]
        thigh_made, calf_made = limit(thigh, -tops[1], tops[1]), limit(calf, -tops[2], tops[2])
        if coupled:
            calf_pitch = limit(thigh + calf, -tops[2], tops[2])
            calf_made = limit(calf_pitch - thigh_made, min(0, calf), max(0, calf))
            thigh_made = limit(thigh_made, -tops[2] - calf_made, tops[2] - calf_made)
        made += [joints[at] + limit(hip, -tops[0], tops[0]), joints[at + 1] + thigh_made, joints[at + 2] + calf_made]
    return made


class Believer:
    """Readings of some values: those near what is believed count, and those near an odd reading just before them."""

    def __init__(self, step, most_odd=10):
        self.step = step
        self.most_odd = most_odd
        self.believed = None
        self.sure = False
        self.before = None  # the set of readings before, if it was odd
        self.row = 0

    def near(self, a, b):
        return abs(a - b) <= self.step

    def take(self, readings):
        """Take a set; return how many of it are odd, -1 while nothing is known."""
        if not self.sure:
            self.sure = self.believed is not None and all(self.near(a, b) for a, b in zip(readings, self.believed))
            self.believed, self.before, self.row = list(readings), None, 0
            return 0 if self.sure else -1
        odd = 0
        for at, reading in enumerate(readings):
            if self.near(reading, self.believed[at]) or (self.before and self.near(reading, self.before[at])):
                self.believed[at] = reading
            else:
                odd += 1
        plain = odd == 0
        self.before = None if plain else list(readings)
        self.row = 0 if plain else self.row + 1
        if self.row > self.most_odd:
            self.sure, self.believed, self.before = False, list(readings), None
            return -1
        return odd
