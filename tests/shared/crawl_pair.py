"""The crawl's machine and its float twin side by side: the same senses, each with its own state.

The ground is a make-believe one: feet that go below it are held up and loaded, those that run into it are stopped.
It is the core whose foot meets it, so both feel the same. Only the plan of the body is taken over from the core,
after it has been compared: the core comes near to the best place, the twin is there.
"""

import math
import pickle
from dataclasses import dataclass, field
from types import SimpleNamespace

from shared.crawl import footholds
from shared.crawl import state as at
from shared.crawl import steps as crawl_steps
from shared.crawl.crawl import move_origin, recentre_map
from shared.crawl.state import HISTORY_TICKS, Crawl
from shared.record import copy, pack, unpack
from tests.float_twin import crawl_machine as twin
from tests.float_twin.doubt import Doubt
from tests.float_twin.si import leg_si

from .robots import block, crawl_si

FINE_RAD = 2 * math.pi / (1 << 24)
FLAT_M = 0.004  # what a foot may be off without a riser


@dataclass
class Trouble:
    """What is drawn of a walk: ground, noise and what goes wrong. Of a leg of 240 mm; others in proportion."""

    steps: list = field(default_factory=list)  # (x, rise) in m
    slope: float = 0.0
    tare: float = 0.0  # what a hanging leg reads
    noise: float = 0.0
    skew: float = 0.0  # load on the wrong diagonal before any offset
    sticks: bool = False  # that load stays on the leg that is to lift
    heavy: float = 0.0
    calves: float = 0.0  # how many of the swings stand on their calf
    straight: float = 0.0  # how many end on a leg too straight to feel the ground, and push the body up from it
    sinks: float = 0.0  # over how many swings the body sinks
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
        self.k = crawl_si(params)
        self.bounds = {**BOUNDS, "tare": twin.FORCE_ROUNDING + twin.tare_rounding(self.k)}
        if name not in ROOMY:
            self.bounds.update(CRAMPED)
        self.origin = [0.0] * 3
        self.pushed, self.straight, self.sunk, self.turned, self.met = 0.0, False, 0.0, 0, set()
        self.stand()

    def stand(self):
        """Both begin on the ground, the first shift planned."""
        c = self.crawl
        for leg, shape in enumerate(self.legs):
            c.support.stance[leg], c.support.share_q12[leg] = 1, 4096
            self.put(c.map.feet[leg], (*shape.rest[:2], self.ground(shape.rest[0])))
        c.path.wanted.z = self.fine(self.k.height)
        c.support.payload_q12 = round(self.trouble.heavy * 4096)
        footholds.footholds_start(c)
        crawl_steps.start_stages(self.crawl)
        pose = [0.0, 0.0, self.k.height, 0.0, 0.0, 0.0]
        self.twin = twin.Machine(self.k, Doubt(), self.feet(self.crawl.map.feet), pose, c.support.payload_q12 / 4096)
        self.compare_plan()

    def fine(self, metres):
        """Return lf."""
        return round(metres / self.fine_m)

    def put(self, place, metres):
        """Write a place of the core's state."""
        unpack(place, [self.fine(value) for value in metres])

    def feet(self, values):
        """Return four places of the core's state in m."""
        return [self.metres(pack(value)) for value in values]

    def footholds(self, side, count):
        """Return the first footholds of a side in m."""
        return self.feet(self.crawl.footholds.sides[side].places[:count])

    def metres(self, values):
        """Return values of the core's state in m."""
        return [value * self.fine_m for value in values]

    def pose(self, values):
        """Return a pose of the core's state in m and rad."""
        values = pack(values)
        return self.metres(values[:3]) + [value * FINE_RAD for value in values[3:]]

    def ground(self, x):
        """Return the height of the ground."""
        x += self.origin[0]
        steps = sum(rise * self.size for edge, rise in self.trouble.steps if edge * self.size <= x)
        return x * self.trouble.slope + steps - self.origin[2]

    # --- senses

    def sense(self):
        """Write what is felt in this tick into the core's state, and return it for the twin."""
        c, dice, trouble = self.crawl, self.dice, self.trouble
        c.swing.limited = int(dice.random() < trouble.clipped)
        for axis in range(6):
            off = round(dice.uniform(-1, 1) * trouble.noise * (300, 800)[axis > 2])
            c.map.body_pose[axis] = c.path.wanted[axis] + off
        for leg in range(4):
            if c.support.stance[leg]:
                self.sense_standing(leg)
            else:
                self.sense_swing(leg)
        way = 0 if dice.random() < trouble.pauses else c_way(self.crawl)
        return self.felt(way), way

    def felt(self, way):
        """Return what is felt, for the twin."""
        c = self.crawl
        return SimpleNamespace(
            measured=self.feet(c.map.measured),
            force=[value / 4096 for value in c.support.force_q12[:4]],
            load=[value / 4096 for value in c.support.load_q12[:4]],
            body=self.pose(c.map.body_pose),
            length=c.swing.leg_length * self.unit_m,
            clipped=c.swing.limited,
            heavy=c.support.payload_q12 / 4096,
            way=way * self.fine_m,
        )

    def sense_standing(self, leg):
        """A foot that stands carries its share, and what is wrong with the diagonals; their offset takes that away."""
        c, trouble = self.crawl, self.trouble
        offset = c.support.diagonal_offset * self.fine_m / (0.04 * self.size)
        share = c.support.share_q12[leg] / 4096
        sign = 1 if leg in (twin.FR, twin.RL) else -1
        load = 0.3 * share
        wrong = trouble.skew - offset + trouble.noise * self.dice.uniform(-0.2, 0.2)
        wrong *= sign * 0.25 * (1.0 if trouble.sticks else share)
        c.support.load_q12[leg], c.support.force_q12[leg] = round(load * 4096), round((load + wrong) * 4096)
        copy(c.map.feet[leg], c.map.measured[leg])

    def sense_swing(self, leg):
        """A foot in the air is where it is wanted, except in front of a riser and on the ground."""
        c, trouble = self.crawl, self.trouble
        x, y, z = self.metres(pack(c.swing.place))
        seen_x = self.stopped(x, z)
        ground = self.ground(seen_x)
        pressed = max(0.0, ground - z)
        self.push(leg, pressed)
        load = (0.0 if self.straight else pressed) / self.size * 40 + trouble.noise * self.dice.uniform(-0.1, 0.1)
        self.put(c.map.measured[leg], (seen_x, y, max(z, ground)))
        c.support.load_q12[leg], c.support.force_q12[leg] = 0, round((trouble.tare + min(load, 0.5)) * 4096)
        hip = [self.pose(self.crawl.path.wanted)[axis] + self.legs[leg].hip[axis] for axis in range(3)]
        away = [a - b for a, b in zip((x, y, z), hip, strict=True)]
        plane = sum(way * way for way in away) - self.legs[leg].l1 ** 2
        c.swing.leg_length = round(math.sqrt(max(0.0, plane)) / self.unit_m)

    def stopped(self, x, z):
        """Return where a foot wanted at (x, z) is stopped by the risers."""
        if self.crawl.stage.stage not in (at.SWING, at.LIFT):
            return x
        for edge, _ in sorted(self.trouble.steps):
            riser = edge * self.size - self.origin[0]
            if riser <= x and self.ground(riser) > z + FLAT_M * self.size:
                return riser - 1e-4
        return x

    def push(self, leg, pressed):
        """Push the corner of the body up over a leg that comes down on its calf, or straight on ground, until it lifts.

        pressed: how far below the ground it is told to be, m.
        """
        c = self.crawl
        if c.stage.stage == at.LOWER and c.stage.stage_tick == 3:
            self.pushed = self.dice.uniform(0.05, 0.15) if self.dice.random() < self.trouble.calves else 0.0
            self.straight = self.dice.random() < self.trouble.straight
        elif c.stage.stage != at.LOWER:
            self.pushed, self.straight = 0.0, False
        if c.stage.stage == at.LIFT and c.stage.stage_tick == 1:
            sinks = self.trouble.sinks and self.dice.random() < self.trouble.sinks
            self.sunk = self.dice.uniform(0.05, 0.15) if sinks else 0.0
        tilt = self.pushed - self.sunk + (pressed / self.k.half_length if self.straight else 0.0)
        c.map.body_pose.pitch += round((-tilt if leg < 2 else tilt) / FINE_RAD)

    # --- any point

    def jump(self):
        """Put both at some point of a crawl that is drawn, whether a walk comes there or not; feel anything there."""
        c, dice = self.crawl, self.dice
        c.stage.order = dice.randrange(4)
        c.stage.leg, c.stage.stage = twin.ORDER[c.stage.order], dice.choice((0, 1, 2, 3, 4, 4, 4, 4, 5))
        self.jump_ground()
        self.jump_body()
        self.jump_swing(c.stage.leg)
        aside = (0.0,) if self.k.planar else (0.0, 0.0, 1.3, -1.3, 1.45, -1.45, 2.6, -2.6)
        far = [self.k.half_leg * dice.choice(values) for values in ((0.0, 0.0, 1.3, -1.3), aside)]
        self.carry_off(*[self.fine(value) for value in (*far, -dice.randrange(2) * self.k.height)])
        self.adopt()
        self.move_origin()
        way = dice.choice((0, c_way(self.crawl)))
        self.both(self.felt(way), way)

    def carry_off(self, dx, dy, dz):
        """Move everything along the map by lf, as if the walk had begun far away."""
        c = self.crawl
        for axis, by in enumerate((dx, dy, dz)):
            move_origin(c, axis, -by)

    def spread(self, millimetres):
        """Return a way that is drawn within +-millimetres of a leg of 240 mm, lf."""
        return self.fine(self.dice.uniform(-millimetres, millimetres) * MM * self.size)

    def jump_ground(self):
        """Draw feet, footholds, shares and loads."""
        c, dice, leg = self.crawl, self.dice, self.crawl.stage.leg
        along = dice.choice((30, 90)) if c.stage.stage == at.SHIFT else 30  # no plan is made there
        for other, shape in enumerate(self.legs):
            for axis, rest, way in ((0, shape.rest[0], along), (1, shape.rest[1], 10), (2, 0.0, 40)):
                c.map.feet[other][axis] = self.fine(rest) + self.spread(way)
                c.map.measured[other][axis] = c.map.feet[other][axis]
            c.support.stance[other] = int(other != leg or c.stage.stage in (at.SHIFT, at.REST))
            c.support.share_q12[other] = dice.choice((0, 100, 2000, 4096))
            c.support.load_q12[other], c.support.force_q12[other] = dice.randrange(2000), dice.randrange(-400, 2400)
        for side in range(2):
            queue = c.footholds.sides[side]
            queue.waiting, queue.occupied = dice.randrange(5), dice.randrange(2)
            queue.guessed = min(queue.waiting, dice.choice((0, 0, 1, 3)))
            for place in queue.places:
                for axis in range(3):
                    place[axis] = c.map.feet[2 + side][axis] + self.spread(60)
        c.support.diagonal_offset, c.ground.even_landings = self.spread(39), dice.choice((0, 1, 2, 3, 4, 5, 7, 8, 9))
        way, step = c_way(self.crawl), self.fine(self.k.stride / 4)
        c.stage.ahead = dice.choice((0, 1, -1, -way, -way - 1, step, -step))
        c.support.payload_q12 = dice.choice((0, 4096))
        if dice.random() < 0.5:
            self.jump_diagonals(leg)

    def jump_diagonals(self, leg):
        """Draw a leg that is free or just not yet, and diagonals that carry nearly what they should, or just not."""
        c, dice = self.crawl, self.dice
        c.support.share_q12[leg] = 0
        c.support.force_q12[leg] = round(2 * twin.NEWTON * 4096) + dice.randint(-40, 400)
        wrong = [c.support.force_q12[other] - c.support.load_q12[other] for other in range(4)]
        off = dice.choice((-1, 1)) * round(4 * twin.NEWTON * 4096) + dice.randint(-40, 40)
        off -= wrong[0] + wrong[3] - wrong[1] - wrong[2]
        c.support.load_q12[leg ^ 1] += off * (1 if leg in (0, 3) else -1)

    def jump_body(self):
        """Draw a move of the body, how far it is, and where the body really is."""
        c, dice = self.crawl, self.dice
        for axis in range(6):
            middle, way = (self.fine(self.k.height) if axis == 2 else 0), (self.spread(30), dice.randint(-40000, 40000))
            c.path.to_pose[axis] = middle + way[axis > 2]
            c.path.from_pose[axis] = c.path.wanted[axis] = middle + way[axis > 2] // 2
            c.map.body_pose[axis] = c.path.wanted[axis] + (self.spread(35), dice.randint(-300000, 300000))[axis > 2]
        c.path.move_ticks = dice.randrange(12, 60)
        c.path.move_tick = dice.choice((c.path.move_ticks, dice.randrange(1, c.path.move_ticks)))

    def jump_swing(self, leg):
        """Draw where a foot in the air is and is to go, what it has met, and what it feels."""
        c, dice, k, foot = self.crawl, self.dice, self.crawl.params.crawl, self.crawl.map.feet[self.crawl.stage.leg]
        for axis in range(3):
            c.swing.target[axis] = foot[axis] + self.spread(60)
            c.swing.place[axis] = foot[axis] + self.spread(60)
        c.swing.departure.x, c.swing.departure.y = foot.x, foot.y
        c.swing.ground = c.swing.place.z + self.spread(dice.choice((30, 100)))
        c.swing.apex = c.swing.place.z + self.spread(60)
        c.swing.speed = dice.randrange(k.known_lower_speed)
        c.swing.way_ticks = dice.randrange(k.swing_ticks, 4 * k.swing_ticks)
        times = (c.path.move_ticks + k.settle_ticks, c.path.move_ticks // 2, c.swing.way_ticks, k.hang_ticks)
        times += (k.hang_skip_ticks, k.riser_skip_ticks, c.path.move_ticks + k.diagonal_ticks)
        c.stage.stage_tick = max(0, dice.choice(times) + dice.randint(-2, 2))
        c.swing.tries, c.swing.risers = dice.randrange(4), dice.randrange(3)
        c.swing.dropped, c.swing.known = (dice.randrange(2), 0) if leg < 2 else (dice.randint(-1, 1), dice.randrange(2))
        c.contact.tare_q12, c.contact.load_ticks = dice.randrange(-400, 600), dice.choice((0, 0, k.contact_ticks - 1))
        c.contact.peak, c.swing.limited = dice.randrange(2), int(dice.random() < 0.2)
        c.contact.past_x[:HISTORY_TICKS] = [c.swing.place.x] * HISTORY_TICKS
        c.contact.past_at = dice.randrange(HISTORY_TICKS)
        c.map.measured[leg].x = c.swing.place.x - self.fine(dice.uniform(0.0, 0.03) * self.size)
        c.map.measured[leg].z = c.swing.ground + self.spread(80)
        c.swing.leg_length = round(dice.choice((self.k.folded, self.k.swing_reach)) / self.unit_m) + dice.randint(-9, 9)

    def adopt(self):
        """Put the twin where the core is."""
        c, other = self.crawl, self.twin
        other.order, other.stage, other.ticks = c.stage.order, c.stage.stage, c.stage.stage_tick
        other.feet, other.stands = self.feet(self.crawl.map.feet), [bool(s) for s in c.support.stance[:4]]
        other.share = [share / 4096 for share in c.support.share_q12[:4]]
        for side in range(2):
            other.footholds[side] = self.footholds(side, c.footholds.sides[side].waiting)
        other.guessed = [queue.guessed for queue in c.footholds.sides]
        other.occupied = [bool(queue.occupied) for queue in c.footholds.sides]
        other.diagonal_offset, other.ahead = self.metres((c.support.diagonal_offset, c.stage.ahead))
        other.even_landings, other.landings = c.ground.even_landings, c.ground.landings
        body = other.body
        poses = c.path.from_pose, c.path.to_pose, c.path.wanted
        body.start, body.goal, body.wanted = (self.pose(pose) for pose in poses)
        body.tick, body.ticks = c.path.move_tick, c.path.move_ticks
        other.swing = None
        if other.stage not in (twin.SHIFT, twin.REST):
            other.swing = self.adopted_swing()

    def adopted_swing(self):
        """Return the core's swing as the twin has it."""
        c = self.crawl
        s = twin.Swing(c.stage.leg, self.metres(pack(c.swing.place)), HISTORY_TICKS)
        s.source, s.target = self.metres(pack(c.swing.departure)), self.metres(pack(c.swing.target))
        s.ground, s.apex, s.speed = self.metres((c.swing.ground, c.swing.apex, c.swing.speed))
        s.ticks_across, s.tries, s.risers = c.swing.way_ticks, c.swing.tries, c.swing.risers
        s.dropped, s.peak, s.load_ticks = c.swing.dropped, bool(c.contact.peak), c.contact.load_ticks
        s.known = bool(c.swing.known)
        s.tare = c.contact.tare_q12 / 4096
        return s

    # --- ticks

    def tick(self):
        """Take one tick of both; where they differ one doubtful answer of the twin must explain it."""
        self.move_origin()
        self.both(*self.sense())

    def both(self, felt, way):
        """Let both take a tick with what is felt, and compare."""
        before = pickle.dumps(self.twin)
        crawl_steps.take_stage(self.crawl, way)
        self.twin.doubt.begin()
        self.twin.tick(felt)
        first, doubts = self.difference(), self.twin.doubt.count
        if first and self.explained(before, felt, doubts):
            self.turned += 1
        elif first:
            raise AssertionError(first)
        self.met.update(event[0] for event in self.twin.events)
        if self.twin.body.planned:
            self.compare_plan()

    def move_origin(self):
        """Both keep their maps under the body: what is measured last is where it is."""
        body = self.pose(self.crawl.map.body_pose)[:3]
        way = self.twin.move_origin(body)
        assert recentre_map(self.crawl) == int(way is not None)
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
        c, other = self.crawl, self.twin
        same = {
            "stage": (c.stage.stage, other.stage),
            "leg": (c.stage.leg, other.leg),
            "tick": (c.stage.stage_tick, other.ticks),
            "stands": (c.support.stance[:4], [int(s) for s in other.stands]),
            "occupied": ([queue.occupied for queue in c.footholds.sides], [int(s) for s in other.occupied]),
            "guessed": ([queue.guessed for queue in c.footholds.sides], other.guessed),
            "footholds": ([queue.waiting for queue in c.footholds.sides], [len(side) for side in other.footholds]),
            "even landings": (c.ground.even_landings, other.even_landings),
            "landings": (c.ground.landings, other.landings),
            "planned": (c.path.move_tick == 0, other.body.planned),
        }
        if other.swing:
            s = other.swing
            same["tries"] = [c.swing.tries, c.swing.risers, c.swing.dropped], [s.tries, s.risers, s.dropped]
            same["known"] = c.swing.known, int(s.known)
            if other.stage in (twin.LOWER, twin.REST):
                same["load ticks"] = (c.contact.load_ticks, c.contact.peak), (s.load_ticks, int(s.peak))
        if other.events:
            event, leg, _ = other.events[-1]
            same["event"] = [c.event.code, c.event.leg], [event, leg]
        for what, (core, exact) in same.items():
            if list_of(core) != list_of(exact):
                return f"{what}: core {core}, twin {exact}"
        return self.far_off()

    def far_off(self):
        """Return what lies farther apart than its bound, or nothing."""
        c, other = self.crawl, self.twin
        pairs = [
            ("feet", self.feet(c.map.feet), other.feet),
            ("shares", [value / 4096 for value in c.support.share_q12[:4]], other.share),
            ("ahead", [c.stage.ahead * self.fine_m], [other.ahead]),
            ("diagonal offset", [c.support.diagonal_offset * self.fine_m], [other.diagonal_offset]),
            ("body", self.pose(c.path.wanted)[:3], other.body.wanted[:3]),
            ("tilt", self.pose(c.path.wanted)[3:], other.body.wanted[3:]),
        ]
        for side, queue in enumerate(other.footholds):
            pairs.append(("footholds", self.footholds(side, len(queue)), queue))
        if other.swing:
            s = other.swing
            pairs += [
                ("foot", self.metres(pack(c.swing.place)), s.place),
                ("target", self.metres(pack(c.swing.target)), s.target),
                ("expected", self.metres([c.swing.ground]), [s.ground]),
                ("apex", self.metres([c.swing.apex]), [s.apex]),
                ("speed", self.metres([c.swing.speed]), [s.speed]),
            ]
            if feels(other):
                pairs.append(("tare", [c.contact.tare_q12 / 4096], [s.tare]))
        if other.events:
            pairs.append(("event", [c.event.z * self.unit_m], other.events[-1][2:]))
        for what, core, exact in pairs:
            off = largest(core, exact) / (self.size if what not in ("shares", "tare", "tilt") else 1)
            if off > self.bounds[what]:
                return f"{what}: core {core}, twin {exact}"
        return ""

    def compare_plan(self):
        """Compare where the body is to go and how long it takes, then let the twin go there too."""
        move, goal, ticks = self.twin.body, self.pose(self.crawl.path.to_pose), self.crawl.path.move_ticks
        off = {
            "plan x y": math.dist(goal[:2], move.goal[:2]) / self.size,
            "plan z": abs(goal[2] - move.goal[2]) / self.size,
            "plan pitch": largest(goal[3:], move.goal[3:]),
        }
        for what, value in off.items():
            assert value <= self.bounds[what], f"{what}: core {goal}, twin {move.goal}"
        move.goal = goal
        exact = move.how_long()
        assert abs(ticks - exact) <= 1.6 + 0.02 * exact, f"core {ticks} ticks, twin {exact}"
        move.ticks = ticks


def c_way(crawl):
    """Return a commanded way, lf a tick, of 50 mm/s of a leg of 240 mm."""
    return crawl.params.crawl.unknown_lower_speed // 2


def feels(other):
    """Return whether the twin's foot has a tare in this swing: until then the core keeps the last one's."""
    return other.stage in (twin.LOWER, twin.REST) or (other.stage == twin.HANG and other.ticks > 0)


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
    "footholds": 0.01 * MM,
    "shares": 1e-9,
    "ahead": 1e-9,
    "diagonal offset": 0.03 * MM,
    "body": 0.2 * MM,
    "tilt": 0.6e-3,
    "foot": 0.2 * MM,
    "target": 0.01 * MM,
    "expected": 0.03 * MM,
    "apex": 0.02 * MM,
    "speed": 0.02 * MM,  # up to an apex that is measured, from a place that is
    "event": 0.03 * MM,
    "plan x y": 0.2 * MM,
    "plan z": 2.5 * MM,
    "plan pitch": 0.2e-3,
}
# Robots whose feet leave little room for the margin: there the core's eight steps towards the nearest point end early
ROOMY = ("caramelo", "parallel")
CRAMPED = {"plan x y": 20 * MM, "plan z": 5 * MM}
