"""A gait table in floats: how long, which legs, how far the body goes in each tick. Layout: shared/gait/gaits.py."""

from .swing import advance, instants


class Gait:
    """One gait at one rate. Times are whole ticks; ways of the body are in ticks of the commanded speed."""

    def __init__(self, table, rate_hz):
        (self.height_m, p_t, p_n, self.cycloid), rows = table
        self.height_m /= 1000
        self.p_t, self.p_n = p_t / 100, p_n / 100
        self.ticks = [max(1, int(row[0] * rate_hz / 1000 + 0.5)) for row in rows]
        self.legs = [[leg for leg in range(4) if row[1] >> leg & 1] for row in rows]
        self.cycle = sum(self.ticks)
        shares = sum([row[2] for row in rows])
        self.ways = [self.cycle * row[2] / shares for row in rows]
        self.places = [(i, tick) for i in range(len(rows)) for tick in range(self.ticks[i])]
        standing = [[place for place in range(self.cycle) if not self.swings(leg, place)] for leg in range(4)]
        self.way_of_stance = [sum([self.way(place) for place in places]) for places in standing]

    def way(self, place):
        """Return how far the body goes in one tick of the cycle."""
        segment, tick = self.places[place]
        ticks = self.ticks[segment]
        if self.cycloid and ticks > 1:
            made = advance(tick / (ticks - 1)) - (advance((tick - 1) / (ticks - 1)) if tick else 0.0)
        else:
            made = 1.0 / ticks
        return made * self.ways[segment]

    def lifts(self, leg, place):
        """Return the ticks of the swing that starts at this tick of the cycle, 0 if none does."""
        if not self.swings(leg, place) or self.swings(leg, place - 1):
            return 0
        count = 1
        while self.swings(leg, place + count):
            count += 1
        return count

    def swings(self, leg, place):
        """Return True if the leg is in the air at this tick, counted round the cycle."""
        return leg in self.legs[self.places[place % self.cycle][0]]

    def way_ahead(self, place, count):
        """Return how far the body goes in ``count`` ticks from this one on."""
        return sum([self.way((place + i) % self.cycle) for i in range(count)])

    def phases(self, ticks):
        """Return t / T at each tick of a swing.

        Re-timed, both ends are among them, as in the paper; evenly, the next stance tick is the other end.
        """
        if self.p_t < 1 and self.p_n < 1:
            return instants(ticks, self.p_t, self.p_n)
        return [i / ticks for i in range(ticks)]
