"""The crawl's machine and its float twin side by side: the same senses, each with its own state.

The ground is a make-believe one: feet that go below it are held up and loaded, those that run into it are stopped.
It is the core whose foot meets it, so both feel the same. Only the plan of the body is taken over from the core,
after it has been compared: the core comes near to the best place, the twin is there.
"""

import math
import pickle
from dataclasses import dataclass, field
from types import SimpleNamespace

from shared import crawl_layout as at
from shared import crawl_map, crawl_steps, footholds
from shared.crawl import Crawl
from tests.float_twin import crawl_machine as twin
from tests.float_twin.doubt import Doubt

from .robots import block, crawl_si, leg_si

FINE_RAD = 2 * math.pi / (1 << 24)
FLAT_M = 0.004  # what a foot may be off without a riser


@dataclass
class Trouble:
    """What is drawn of a walk: ground, noise and what goes wrong. Of a leg of 240 mm; others in proportion."""

    steps: list = field(default_factory=list)  # (x, rise) in m
    slope: float = 0.0
    tare: float = 0.0  # what a hanging leg reads
    noise: float = 0.0
    skew: float = 0.0  # load on the wrong diagonal before any warp
    sticks: bool = False  # that load stays on the leg that is to lift
    heavy: float = 0.0
    shins: float = 0.0  # how many of the swings stand on their shin
    clipped: float = 0.0
    pauses: float = 0.0  # how many of the ticks command nothing


class Pair:
    """One crawl and its twin on made-up ground; ``dice`` draws the noise."""

    def __init__(self, trouble, dice, name="caramelo", rate_hz=50, planar=False):
        params = block(name, rate_hz)
        if planar:
            params.lateral_q12 = 0
        self.crawl, self.trouble, self.dice = Crawl(params), trouble, dice
        self.legs = [leg_si(params, leg) for leg in range(4)]
        self.unit_m = self.legs[0].unit_m
        self.fine_m = self.unit_m / 256
        self.size = (self.legs[0].l2 + self.legs[0].l3) / 0.24
        self.k = crawl_si(params, self.crawl.settings)
        self.bounds = {**BOUNDS, "tare": twin.FORCE_ROUNDING + twin.tare_rounding(self.k)}
        if name not in ROOMY:
            self.bounds.update(CRAMPED)
        self.origin = [0.0] * 3
        self.far, self.pushed, self.doubts, self.turned, self.met = {}, 0.0, 0, 0, set()
        self.stand()

    def stand(self):
        """Both begin on the ground, the first shift planned."""
        c = self.crawl.state
        for leg, shape in enumerate(self.legs):
            c[at.C_STANDS + leg], c[at.C_SHARE + leg] = 1, 4096
            foot = shape.rest[0], shape.rest[1], self.ground(shape.rest[0])
            for axis in range(3):
                c[at.C_FOOT + leg * 3 + axis] = self.fine(foot[axis])
        c[at.C_REF + 2] = self.fine(self.k.height)
        c[at.C_HEAVY] = round(self.trouble.heavy * 4096)
        footholds.prints_start(self.crawl.limbs, c)
        crawl_steps.start_machine(self.crawl)
        pose = [0.0, 0.0, self.k.height, 0.0, 0.0, 0.0]
        self.twin = twin.Machine(self.k, Doubt(), self.feet(at.C_FOOT), pose, c[at.C_HEAVY] / 4096)
        self.compare_plan()

    def fine(self, metres):
        """Return lf."""
        return round(metres / self.fine_m)

    def feet(self, place):
        """Return four places of the core's state in m."""
        return [self.metres(place + leg * 3) for leg in range(4)]

    def metres(self, place, count=3):
        """Return values of the core's state in m."""
        return [value * self.fine_m for value in self.crawl.state[place : place + count]]

    def pose(self, place):
        """Return a pose of the core's state in m and rad."""
        angles = [value * FINE_RAD for value in self.crawl.state[place + 3 : place + 6]]
        return self.metres(place) + angles

    def ground(self, x):
        """Return the height of the ground."""
        x += self.origin[0]
        steps = sum(rise * self.size for edge, rise in self.trouble.steps if edge * self.size <= x)
        return x * self.trouble.slope + steps - self.origin[2]

    # --- senses

    def sense(self):
        """Write what is felt in this tick into the core's state, and return it for the twin."""
        c, dice, trouble = self.crawl.state, self.dice, self.trouble
        c[at.C_CLIPPED] = int(dice.random() < trouble.clipped)
        for axis in range(6):
            c[at.C_BODY + axis] = c[at.C_REF + axis] + round(dice.uniform(-1, 1) * trouble.noise * (300, 800)[axis > 2])
        for leg in range(4):
            if c[at.C_STANDS + leg]:
                self.sense_standing(leg)
            else:
                self.sense_swing(leg)
        way = 0 if dice.random() < trouble.pauses else c_way(self.crawl)
        return self.felt(way), way

    def felt(self, way):
        """Return what is felt, for the twin."""
        c = self.crawl.state
        return SimpleNamespace(
            seen=self.feet(at.C_SEEN),
            force=[value / 4096 for value in c[at.C_FORCE : at.C_FORCE + 4]],
            load=[value / 4096 for value in c[at.C_LOAD : at.C_LOAD + 4]],
            body=self.pose(at.C_BODY),
            length=c[at.C_LENGTH] * self.unit_m,
            clipped=c[at.C_CLIPPED],
            heavy=c[at.C_HEAVY] / 4096,
            way=way * self.fine_m,
        )

    def sense_standing(self, leg):
        """A foot that stands carries its share, and what is wrong with the diagonals; a warp takes that away."""
        c, trouble = self.crawl.state, self.trouble
        warp = c[at.C_WARP] * self.fine_m / (0.04 * self.size)
        share = c[at.C_SHARE + leg] / 4096
        sign = 1 if leg in (twin.FR, twin.RL) else -1
        load = 0.3 * share
        wrong = trouble.skew - warp + trouble.noise * self.dice.uniform(-0.2, 0.2)
        wrong *= sign * 0.25 * (1.0 if trouble.sticks else share)
        c[at.C_LOAD + leg], c[at.C_FORCE + leg] = round(load * 4096), round((load + wrong) * 4096)
        for axis in range(3):
            c[at.C_SEEN + leg * 3 + axis] = c[at.C_FOOT + leg * 3 + axis]

    def sense_swing(self, leg):
        """A foot in the air is where it is wanted, except in front of a riser and on the ground."""
        c, trouble = self.crawl.state, self.trouble
        x, y, z = self.metres(at.C_POS)
        seen_x = self.stopped(x, z)
        ground = self.ground(seen_x)
        load = max(0.0, ground - z) / self.size * 40 + trouble.noise * self.dice.uniform(-0.1, 0.1)
        seen = seen_x, y, max(z, ground)
        for axis in range(3):
            c[at.C_SEEN + leg * 3 + axis] = self.fine(seen[axis])
        c[at.C_LOAD + leg], c[at.C_FORCE + leg] = 0, round((trouble.tare + min(load, 0.5)) * 4096)
        hip = [self.pose(at.C_REF)[axis] + self.legs[leg].hip[axis] for axis in range(3)]
        away = [a - b for a, b in zip((x, y, z), hip, strict=True)]
        plane = sum(way * way for way in away) - self.legs[leg].l1 ** 2
        c[at.C_LENGTH] = round(math.sqrt(max(0.0, plane)) / self.unit_m)
        self.push(leg)

    def stopped(self, x, z):
        """Return where a foot wanted at (x, z) is stopped by the risers."""
        if self.crawl.state[at.C_PHASE] not in (at.MOVE, at.LIFT):
            return x
        for edge, _ in sorted(self.trouble.steps):
            riser = edge * self.size - self.origin[0]
            if riser <= x and self.ground(riser) > z + FLAT_M * self.size:
                return riser - 1e-4
        return x

    def push(self, leg):
        """Push the corner of the body over a leg that comes down on its shin, until it lifts."""
        c = self.crawl.state
        if c[at.C_PHASE] == at.DOWN and c[at.C_TICK] == 3 and self.dice.random() < self.trouble.shins:
            self.pushed = self.dice.uniform(0.05, 0.15)
        elif c[at.C_PHASE] != at.DOWN:
            self.pushed = 0.0
        c[at.C_BODY + 4] += round((-self.pushed if leg < 2 else self.pushed) / FINE_RAD)

    # --- any point

    def jump(self):
        """Put both at some point of a crawl that is drawn, whether a walk comes there or not; feel anything there."""
        c, dice = self.crawl.state, self.dice
        c[at.C_TURN] = dice.randrange(4)
        c[at.C_LEG], c[at.C_PHASE] = twin.ORDER[c[at.C_TURN]], dice.choice((0, 1, 2, 3, 4, 4, 4, 4, 5))
        self.jump_ground()
        self.jump_body()
        self.jump_swing(c[at.C_LEG])
        aside = (0.0,) if self.k.planar else (0.0, 0.0, 1.3, -1.3, 1.45, -1.45, 2.6, -2.6)
        far = [self.k.rebase * dice.choice(values) for values in ((0.0, 0.0, 1.3, -1.3), aside)]
        self.carry_off(*[self.fine(value) for value in (*far, -dice.randrange(2) * self.k.height)])
        self.adopt()
        self.move_origin()
        way = dice.choice((0, c_way(self.crawl)))
        self.both(self.felt(way), way)

    def carry_off(self, dx, dy, dz):
        """Move everything along the map by lf, as if the walk had begun far away."""
        c = self.crawl.state
        for place, count in ((at.C_FOOT, 4), (at.C_SEEN, 4), (at.C_PRINT, 8), (at.C_POS, 1), (at.C_TARGET, 1)):
            crawl_map.shift_points(c, place, count, -dx, -dy, -dz)
        for place in (at.C_BODY, at.C_REF, at.C_FROM, at.C_TO):
            crawl_map.shift_points(c, place, 1, -dx, -dy, -dz)
        c[at.C_SOURCE], c[at.C_SOURCE + 1] = c[at.C_SOURCE] + dx, c[at.C_SOURCE + 1] + dy
        c[at.C_EXPECT], c[at.C_TOP] = c[at.C_EXPECT] + dz, c[at.C_TOP] + dz
        for place in range(at.C_PAST, at.C_PAST + at.PAST_SIZE):
            c[place] += dx

    def spread(self, millimetres):
        """Return a way that is drawn within +-millimetres of a leg of 240 mm, lf."""
        return self.fine(self.dice.uniform(-millimetres, millimetres) * MM * self.size)

    def jump_ground(self):
        """Draw feet, prints, shares and loads."""
        c, dice, leg = self.crawl.state, self.dice, self.crawl.state[at.C_LEG]
        along = dice.choice((30, 90)) if c[at.C_PHASE] == at.SHIFT else 30  # no plan is made there
        for other, shape in enumerate(self.legs):
            for axis, rest, way in ((0, shape.rest[0], along), (1, shape.rest[1], 10), (2, 0.0, 40)):
                c[at.C_FOOT + other * 3 + axis] = self.fine(rest) + self.spread(way)
                c[at.C_SEEN + other * 3 + axis] = c[at.C_FOOT + other * 3 + axis]
            c[at.C_STANDS + other] = int(other != leg or c[at.C_PHASE] in (at.SHIFT, at.REST))
            c[at.C_SHARE + other] = dice.choice((0, 100, 2000, 4096))
            c[at.C_LOAD + other], c[at.C_FORCE + other] = dice.randrange(2000), dice.randrange(-400, 2400)
        for side in range(2):
            c[at.C_PRINTS + side], c[at.C_ON_PRINT + side] = dice.randrange(5), dice.randrange(2)
            for value in range(12):
                c[at.C_PRINT + side * 12 + value] = c[at.C_FOOT + 6 + side * 3 + value % 3] + self.spread(60)
        c[at.C_WARP], c[at.C_STEPS_EVEN] = self.spread(39), dice.randrange(6)
        way, pace = c_way(self.crawl), self.fine(self.k.pace)
        c[at.C_PACE] = dice.choice((0, 1, -1, -way, -way - 1, pace, -pace))
        c[at.C_HEAVY] = dice.choice((0, 4096))
        if dice.random() < 0.5:
            self.jump_diagonals(leg)

    def jump_diagonals(self, leg):
        """Draw a leg that is free or just not yet, and diagonals that carry nearly what they should, or just not."""
        c, dice = self.crawl.state, self.dice
        c[at.C_SHARE + leg] = 0
        c[at.C_FORCE + leg] = round(2 * twin.NEWTON * 4096) + dice.randint(-40, 400)
        wrong = [c[at.C_FORCE + other] - c[at.C_LOAD + other] for other in range(4)]
        off = dice.choice((-1, 1)) * round(4 * twin.NEWTON * 4096) + dice.randint(-40, 40)
        c[at.C_LOAD + (leg ^ 1)] += (off - (wrong[0] + wrong[3] - wrong[1] - wrong[2])) * (1 if leg in (0, 3) else -1)

    def jump_body(self):
        """Draw a move of the body, how far it is, and where the body really is."""
        c, dice = self.crawl.state, self.dice
        for axis in range(6):
            middle, way = (self.fine(self.k.height) if axis == 2 else 0), (self.spread(30), dice.randint(-40000, 40000))
            for place in (at.C_FROM, at.C_TO, at.C_REF):
                c[place + axis] = middle + way[axis > 2] // (1 if place == at.C_TO else 2)
            c[at.C_BODY + axis] = c[at.C_REF + axis] + (self.spread(35), dice.randint(-300000, 300000))[axis > 2]
        c[at.C_BODY_TICKS] = dice.randrange(12, 60)
        c[at.C_BODY_TICK] = dice.choice((c[at.C_BODY_TICKS], dice.randrange(1, c[at.C_BODY_TICKS])))

    def jump_swing(self, leg):
        """Draw where a foot in the air is and is to go, what it has met, and what it feels."""
        c, dice, k, foot = self.crawl.state, self.dice, self.crawl.settings, at.C_FOOT + self.crawl.state[at.C_LEG] * 3
        for axis in range(3):
            c[at.C_TARGET + axis] = c[foot + axis] + self.spread(60)
            c[at.C_POS + axis] = c[foot + axis] + self.spread(60)
        c[at.C_SOURCE : at.C_SOURCE + 2] = c[foot : foot + 2]
        c[at.C_EXPECT] = c[at.C_POS + 2] + self.spread(dice.choice((30, 100)))
        c[at.C_TOP] = c[at.C_POS + 2] + self.spread(60)
        c[at.C_SPEED] = dice.randrange(k[at.K_V_REAR])
        c[at.C_MOVE_TICKS] = dice.randrange(k[at.K_MOVE_TICKS], 4 * k[at.K_MOVE_TICKS])
        times = (c[at.C_BODY_TICKS] + k[at.K_SETTLE], c[at.C_BODY_TICKS] // 2, c[at.C_MOVE_TICKS], k[at.K_TARE_TICKS])
        times += (k[at.K_TARE_SKIP], k[at.K_HIT_AFTER], c[at.C_BODY_TICKS] + k[at.K_WARP_TICKS])
        c[at.C_TICK] = max(0, dice.choice(times) + dice.randint(-2, 2))
        c[at.C_TRIES], c[at.C_HITS] = dice.randrange(4), dice.randrange(3)
        c[at.C_DROPPED] = dice.randrange(2) if leg < 2 else 0
        c[at.C_TARE], c[at.C_TOUCHED] = dice.randrange(-400, 600), dice.choice((0, 0, k[at.K_TOUCH_TICKS] - 1))
        c[at.C_PEAK], c[at.C_CLIPPED] = dice.randrange(2), int(dice.random() < 0.2)
        c[at.C_PAST : at.C_PAST + at.PAST_SIZE] = [c[at.C_POS]] * at.PAST_SIZE
        c[at.C_PAST_AT] = dice.randrange(at.PAST_SIZE)
        c[at.C_SEEN + leg * 3] = c[at.C_POS] - self.fine(dice.uniform(0.0, 0.03) * self.size)
        c[at.C_SEEN + leg * 3 + 2] = c[at.C_EXPECT] + self.spread(80)
        c[at.C_LENGTH] = round(dice.choice((self.k.near, self.k.reach_swing)) / self.unit_m) + dice.randint(-9, 9)

    def adopt(self):
        """Put the twin where the core is."""
        c, other = self.crawl.state, self.twin
        other.turn, other.stage, other.ticks = c[at.C_TURN], c[at.C_PHASE], c[at.C_TICK]
        other.feet, other.stands = self.feet(at.C_FOOT), [bool(s) for s in c[at.C_STANDS : at.C_STANDS + 4]]
        other.share = [share / 4096 for share in c[at.C_SHARE : at.C_SHARE + 4]]
        for side in range(2):
            first, count = at.C_PRINT + side * 12, c[at.C_PRINTS + side]
            other.prints[side] = [self.metres(first + place * 3) for place in range(count)]
        other.on_print = [bool(value) for value in c[at.C_ON_PRINT : at.C_ON_PRINT + 2]]
        (other.warp,), (other.pace,) = self.metres(at.C_WARP, 1), self.metres(at.C_PACE, 1)
        other.steps_even, other.landed = c[at.C_STEPS_EVEN], c[at.C_LANDED]
        body = other.body
        body.start, body.goal, body.wanted = self.pose(at.C_FROM), self.pose(at.C_TO), self.pose(at.C_REF)
        body.tick, body.ticks = c[at.C_BODY_TICK], c[at.C_BODY_TICKS]
        other.swing = None
        if other.stage not in (twin.SHIFT, twin.REST):
            other.swing = self.adopted_swing()

    def adopted_swing(self):
        """Return the core's swing as the twin has it."""
        c = self.crawl.state
        s = twin.Swing(c[at.C_LEG], self.metres(at.C_POS), at.PAST_SIZE)
        s.source, s.target = self.metres(at.C_SOURCE, 2), self.metres(at.C_TARGET)
        (s.expect,), (s.top,), (s.speed,) = (self.metres(place, 1) for place in (at.C_EXPECT, at.C_TOP, at.C_SPEED))
        s.ticks_across, s.tries, s.hits = c[at.C_MOVE_TICKS], c[at.C_TRIES], c[at.C_HITS]
        s.dropped, s.peak, s.touched = bool(c[at.C_DROPPED]), bool(c[at.C_PEAK]), c[at.C_TOUCHED]
        s.tare = c[at.C_TARE] / 4096
        return s

    # --- ticks

    def tick(self):
        """Take one tick of both; where they differ one doubtful answer of the twin must explain it."""
        self.move_origin()
        self.both(*self.sense())

    def both(self, felt, way):
        """Let both take a tick with what is felt, and compare."""
        before = pickle.dumps(self.twin)
        crawl_steps.machine(self.crawl, way)
        self.twin.doubt.begin()
        self.twin.tick(felt)
        first, doubts = self.difference(), self.twin.doubt.count
        self.doubts += doubts > 0
        if first and self.explained(before, felt, doubts):
            self.turned += 1
        elif first:
            raise AssertionError(first)
        self.met.update(event[0] for event in self.twin.events)
        if self.twin.body.planned:
            self.compare_plan()

    def move_origin(self):
        """Both keep their maps under the body: what is measured last is where it is."""
        body = self.metres(at.C_BODY)
        way = self.twin.move_origin(body)
        assert crawl_map.rebase(self.crawl.settings, self.crawl.state) == int(way is not None)
        if way:
            self.origin = [a + b for a, b in zip(self.origin, way, strict=True)]

    def explained(self, before, felt, doubts):
        """Return whether the twin comes out as the core with one of its doubtful answers the other way."""
        for turned in range(doubts):
            self.twin = pickle.loads(before)
            self.twin.doubt.begin(turned)
            self.twin.tick(felt)
            if not self.difference():
                return True
        return False

    def difference(self):
        """Return what differs first between core and twin after a tick, or nothing."""
        c, other = self.crawl.state, self.twin
        same = {
            "stage": (c[at.C_PHASE], other.stage),
            "leg": (c[at.C_LEG], other.leg),
            "tick": (c[at.C_TICK], other.ticks),
            "stands": (c[at.C_STANDS : at.C_STANDS + 4], [int(s) for s in other.stands]),
            "on print": (c[at.C_ON_PRINT : at.C_ON_PRINT + 2], [int(s) for s in other.on_print]),
            "prints": (c[at.C_PRINTS : at.C_PRINTS + 2], [len(side) for side in other.prints]),
            "even": (c[at.C_STEPS_EVEN], other.steps_even),
            "landed": (c[at.C_LANDED], other.landed),
            "planned": (c[at.C_BODY_TICK] == 0, other.body.planned),
        }
        if other.swing:
            s = other.swing
            same["tries"] = c[at.C_TRIES : at.C_DROPPED + 1], [s.tries, s.hits, int(s.dropped)]
            if other.stage in (twin.DOWN, twin.REST):
                same["touched"] = (c[at.C_TOUCHED], c[at.C_PEAK]), (s.touched, int(s.peak))
        if other.events:
            event, leg, _, _ = other.events[-1]
            same["event"] = c[at.C_EVENT : at.C_EVENT + 2], [event, leg]
        for what, (core, exact) in same.items():
            if list_of(core) != list_of(exact):
                return f"{what}: core {core}, twin {exact}"
        return self.far_off()

    def far_off(self):
        """Return what lies farther apart than its bound, or nothing; keep the largest distances."""
        c, other = self.crawl.state, self.twin
        pairs = [
            ("feet", self.feet(at.C_FOOT), other.feet),
            ("shares", [value / 4096 for value in c[at.C_SHARE : at.C_SHARE + 4]], other.share),
            ("pace", [c[at.C_PACE] * self.fine_m], [other.pace]),
            ("warp", [c[at.C_WARP] * self.fine_m], [other.warp]),
            ("body", self.metres(at.C_REF), other.body.wanted[:3]),
            ("tilt", self.pose(at.C_REF)[3:], other.body.wanted[3:]),
        ]
        for side, prints in enumerate(other.prints):
            places = [self.metres(at.C_PRINT + side * 12 + place * 3) for place in range(len(prints))]
            pairs.append(("prints", places, prints))
        if other.swing:
            s = other.swing
            pairs += [
                ("foot", self.metres(at.C_POS), s.place),
                ("target", self.metres(at.C_TARGET), s.target),
                ("expected", self.metres(at.C_EXPECT, 1), [s.expect]),
                ("top", self.metres(at.C_TOP, 1), [s.top]),
                ("speed", self.metres(at.C_SPEED, 1), [s.speed]),
            ]
            if feels(other):
                pairs.append(("tare", [c[at.C_TARE] / 4096], [s.tare]))
        if other.events:
            pairs.append(("event", [v * self.unit_m for v in c[at.C_EVENT_X : at.C_EVENT_Z + 1]], other.events[-1][2:]))
        for what, core, exact in pairs:
            off = largest(core, exact) / (self.size if what not in ("shares", "tare", "tilt") else 1)
            if off > self.bounds[what]:
                return f"{what}: core {core}, twin {exact}"
            self.far[what] = max(self.far.get(what, 0.0), off)
        return ""

    def compare_plan(self):
        """Compare where the body is to go and how long it takes, then let the twin go there too."""
        move, goal, ticks = self.twin.body, self.pose(at.C_TO), self.crawl.state[at.C_BODY_TICKS]
        off = {
            "plan x y": math.dist(goal[:2], move.goal[:2]) / self.size,
            "plan z": abs(goal[2] - move.goal[2]) / self.size,
            "plan pitch": largest(goal[3:], move.goal[3:]),
        }
        for what, value in off.items():
            self.far[what] = max(self.far.get(what, 0.0), value)
            assert value <= self.bounds[what], f"{what}: core {goal}, twin {move.goal}"
        move.goal = goal
        exact = move.how_long()
        assert abs(ticks - exact) <= 1.6 + 0.02 * exact, f"core {ticks} ticks, twin {exact}"
        move.ticks = ticks


def c_way(crawl):
    """Return a commanded way, lf a tick, of 50 mm/s of a leg of 240 mm."""
    return crawl.settings[at.K_V_SLOW] * 5 // 6


def feels(other):
    """Return whether the twin's foot has a tare in this swing: until then the core keeps the last one's."""
    return other.stage in (twin.DOWN, twin.REST) or (other.stage == twin.TARE and other.ticks > 0)


def list_of(values):
    """Return a list of values, or one."""
    return list(values) if isinstance(values, (list, tuple)) else values


def largest(core, exact):
    """Return the largest difference between numbers or points."""
    flat = [(a, b) for a, b in zip(core, exact, strict=True)]
    return max((largest(a, b) if isinstance(a, list) else abs(a - b) for a, b in flat), default=0.0)


MM = 1e-3
# Of a leg of 240 mm; a foot's and the body's way by the quintic's 0.2 %
BOUNDS = {
    "feet": 1e-9,
    "prints": 0.01 * MM,
    "shares": 1e-9,
    "pace": 1e-9,
    "warp": 0.03 * MM,
    "body": 0.2 * MM,
    "tilt": 0.6e-3,
    "foot": 0.2 * MM,
    "target": 0.01 * MM,
    "expected": 0.03 * MM,
    "top": 0.02 * MM,
    "speed": 0.01 * MM,
    "event": 0.03 * MM,
    "plan x y": 0.2 * MM,
    "plan z": 2.5 * MM,
    "plan pitch": 0.2e-3,
}
# Robots whose feet leave little room for the margin: there the core's eight steps towards the nearest point end early
ROOMY = ("caramelo", "parallel")
CRAMPED = {"plan x y": 20 * MM, "plan z": 5 * MM}
