"""Comparisons between real numbers of which another implementation knows only rounded ones.

Where both sides lie within rounding of each other, either answer is right. A tick that came out differently may be
taken again with one of its doubtful answers turned round; everywhere else the two must agree.
"""

import math


class Doubt:
    """Counts the doubtful answers since ``begin`` and turns round the one that is asked for."""

    def __init__(self):
        self.count, self.turned = 0, -1

    def begin(self, turned=-1):
        """Begin a tick in which doubtful answer number ``turned`` is the other one; -1: none."""
        self.count, self.turned = 0, turned

    def otherwise(self):
        """Note one more doubtful answer; return True if it is the one to be turned round."""
        self.count += 1
        return self.count - 1 == self.turned

    def above(self, value, limit, within):
        """Return whether ``value`` is above ``limit``; in doubt if they are not farther than ``within`` apart."""
        answer = value > limit
        return answer != (abs(value - limit) <= within and self.otherwise())

    def whole(self, value, within):
        """Return the whole number not above ``value``; in doubt if a whole number is not farther than ``within``."""
        floor, near = math.floor(value), round(value)
        if abs(value - near) > within or not self.otherwise():
            return floor
        return near - 1 if floor == near else near
