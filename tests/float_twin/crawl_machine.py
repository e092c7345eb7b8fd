"""The crawl's machine in floats: which stage follows which, when, and where body and foot are to go.

Lengths in m, angles in rad, times in ticks and speeds per tick, forces as parts of the own weight. Legs FR, FL, RR,
RL. What is felt comes as an object: measured (4 places of the map), force and load (4), body (the measured pose),
length (thigh joint to the foot in the air), clipped, heavy (0 .. 1), way (commanded in this tick).
"""

import math

from . import crawl, crawl_swing
from .crawl_plan import BodyMove
from .fixed import limit

SHIFT, LIFT, SWING, HANG, LOWER, REST = range(6)
LANDED, STEP, DROP, CALF, RISER, NO_GROUND, DIAGONALS, SINKS, RIM = range(1, 10)
FR, FL, RR, RL = range(4)
ORDER = (RL, FL, RR, FR)

NEWTON = 1 / 21.6  # of Caramelo's own weight
FORCE_ROUNDING = 1.5 / 4096
PLACE_ROUNDING = 0.05e-3
TILT_ROUNDING = 0.3e-3  # m at the corners: 0.2 % of a way of 0.3 rad
EVEN_ROUNDING = 0.15e-3
QUINTIC_ROUNDING = 0.0026  # of the way
TRIES, RISERS = 3, 2
SLOPE_LANDINGS = 3
LONG_STRIDE_LANDINGS = 8  # landings on even ground


def tare_rounding(k):
    """Return how far rounding keeps a slow tare from its force: where a step is below half a unit, it stays."""
    return 0.6 / 4096 / k.tare_down_q15


class Swing:
    """A foot in the air: where it is wanted, where it is to land, what it has met and what it feels."""

    def __init__(self, leg, place, past):
        self.leg, self.place, self.source = leg, list(place), list(place[:2])
        self.target, self.ground, self.apex = None, None, None
        self.speed, self.ticks_across = 0.0, 0
        self.tries, self.risers, self.dropped, self.known = 0, 0, 0, False
        self.tare, self.load_ticks, self.peak = 0.0, 0, False
        self.past = [place[0]] * past


class Machine:
    """The machine of a crawl on ``feet``; k: settings (settings_si in the tests); doubt: a Doubt."""

    def __init__(self, k, doubt, feet, pose, heavy):
        self.k, self.doubt = k, doubt
        self.feet = [list(foot) for foot in feet]
        self.stands, self.share = [True] * 4, [1.0] * 4
        self.footholds = [self.first_footholds(side) for side in range(2)]
        self.occupied = [True, False]
        self.guessed = [2, 3]
        self.order, self.ahead, self.diagonal_offset = 0, 0.0, 0.0
        self.even_landings, self.landings, self.events = 0, 0, []
        self.swing = None
        self.body = BodyMove(k, pose)
        self.plan_shift(heavy)

    @property
    def leg(self):
        """Return the leg it is about."""
        return ORDER[self.order % 4]

    @property
    def long_strides(self):
        """Return whether the ground has been even for long enough to go on in long and quick steps."""
        return self.even_landings >= LONG_STRIDE_LANDINGS

    @property
    def stride(self):
        """Return the stride; one leg brings the body on by a quarter of it."""
        return self.k.long_stride if self.long_strides else self.k.stride

    def quick(self, name):
        """Return a speed or acceleration of the settings, on even ground its quick one."""
        return getattr(self.k, f"quick_{name}" if self.long_strides else name)

    def first_footholds(self, side):
        """Return the footholds that lie behind a robot that came this way."""
        hind, front = self.feet[2 + side], self.feet[side]
        places = crawl_swing.first_footholds((hind[0], hind[2]), (front[0], front[2]), side)
        return [[x, self.k.line[side], z] for x, z in places]

    def enter(self, stage):
        """Begin a stage; a foot begins it at rest."""
        self.stage, self.ticks = stage, 0
        if self.swing:
            self.swing.speed = 0.0

    def note_event(self, event, z):
        """Note what has happened; anything but a landing ends even ground."""
        self.events.append((event, self.leg, z))
        if event != LANDED:
            self.even_landings = 0

    def tick(self, felt):
        """Take one tick: command and body go on whatever the stage is."""
        self.events = []
        self.body.planned = False
        self.ticks += 1
        step = self.stride / 4
        self.ahead = limit(self.ahead + limit(felt.way, 0.0, step), -step, step)
        self.body.step()
        if self.stage == REST:
            self.rest(felt)
        elif self.stage == SHIFT:
            self.shift(felt)
        else:
            self.swing.past.append(self.swing.place[0])
            self.in_the_air(felt)

    def move_origin(self, body):
        """Put the map's origin under the body if it is half a leg away, sideways 3/4 of one; return the way or None.

        Sideways it stays as long as it can: its x axis is the line that is walked along.
        """
        half = self.k.half_leg
        if abs(body[0]) <= half and abs(body[1]) <= 1.5 * half and abs(body[2]) <= half:
            return None
        way = [body[0], body[1] if abs(body[1]) > 1.5 * half else 0.0, body[2]]
        places = self.feet + self.footholds[0] + self.footholds[1] + [self.body.wanted, self.body.start, self.body.goal]
        if self.swing:
            s = self.swing
            places += [s.place, s.target, s.source]
            s.ground, s.apex, s.past = s.ground - way[2], s.apex - way[2], [x - way[0] for x in s.past]
        for place in places:
            place[: len(place[:3])] = [a - b for a, b in zip(place[:3], way)]
        return way

    # --- all feet down

    def rest(self, felt):
        """Go on once the command asks for another step."""
        if felt.way > 0 and self.ahead >= 0:
            self.plan_shift(felt.heavy)

    def plan_shift(self, heavy):
        """Move off the leg to come; before a step down its hip goes over the landing place if that is farther."""
        if self.leg >= RR and not self.long_strides:
            self.lay_between(self.leg)
        wanted = crawl.middle(self.feet)[0] + self.k.payload_forward * heavy
        if self.steps_down():
            wanted = max(wanted, self.hip_over(self.footholds[self.leg - RR][0][0]))
        self.enter(SHIFT)
        self.body.plan(self.feet, self.leg, wanted, heavy, None, self.quick("acceleration"))

    def lay_between(self, leg):
        """After long strides a hind leg has one foothold, where the front foot stands: put two before it."""
        own, footholds = self.feet[leg], self.footholds[leg - RR]
        if len(footholds) == 1:
            last = footholds[0]
            step = min((last[0] - own[0]) / 3, self.k.stride)
            between = [[own[0] + step * count, last[1], own[2]] for count in (1, 2)]
            self.footholds[leg - RR], self.guessed[leg - RR] = [*between, last], 2

    def steps_down(self):
        """Return whether a hind leg's next foothold lies an edge below it."""
        if self.leg < RR or not self.footholds[self.leg - RR]:
            return False
        drop = self.feet[self.leg][2] - self.footholds[self.leg - RR][0][2]
        return self.doubt.above(drop, self.k.edge_height, PLACE_ROUNDING)

    def hip_over(self, x):
        """Return where the centre of mass is when the leg's hip is above ``x``."""
        return x - self.k.hips[self.leg][0] + self.k.com_x

    def shift(self, felt):
        """Unload the leg in the second half of the move, or its last ticks; lift it when it and the body are ready."""
        move, k, leg = self.body, self.k, self.leg
        for other in range(4):
            if other != leg:
                self.share[other] = min(1.0, self.share[other] + k.share)
        if move.ticks - self.ticks < k.share_ticks or self.ticks >= move.ticks / 2:
            self.share[leg] = max(0.0, self.share[leg] - k.share)
        error = self.match_diagonals(felt)
        if self.share[leg] > 0 or self.ticks <= move.ticks + k.settle_ticks:
            return
        if self.ticks > move.ticks + k.diagonal_ticks:
            self.note_event(DIAGONALS, self.diagonal_offset)
            self.lift_off(felt)
        elif not self.doubt.above(abs(error), 4 * NEWTON, FORCE_ROUNDING):
            self.lift_off(felt)

    def match_diagonals(self, felt):
        """Offset the diagonals against too much load on FR and RL; return that. Nothing shows when the leg is free."""
        leg = self.leg
        if self.k.planar:
            return 0.0
        if self.share[leg] == 0 and not self.doubt.above(felt.force[leg], 2 * NEWTON, FORCE_ROUNDING):
            return 0.0
        over = [force - load for force, load in zip(felt.force, felt.load)]
        error = limit(over[FR] + over[RL] - over[FL] - over[RR], -4.0, 4.0)
        step = limit(error * self.k.diagonal_gain, -self.k.diagonal_speed, self.k.diagonal_speed)
        self.diagonal_offset = limit(self.diagonal_offset + step, -self.k.diagonal_max, self.k.diagonal_max)
        return error

    def lift_off(self, felt):
        """Let the leg go, towards its foothold."""
        leg = self.leg
        self.swing = Swing(leg, self.feet[leg], self.k.goal_lag_ticks + 1)
        if leg < RR:
            self.aim_front(self.swing)
            self.occupied[leg] = False
        elif self.long_strides:
            self.aim_hind_even(self.swing)
        else:
            self.aim_hind(self.swing)
        self.stands[leg], self.share[leg] = False, 0.0
        self.enter(LIFT)

    def aim_front(self, swing):
        """Half a stride beyond the other front foot, on the slope if there surely is one, over both feet's ground."""
        own, other = self.feet[swing.leg], self.feet[1 - swing.leg]
        x = crawl_swing.front_target(own[0], other[0], self.stride)
        swing.target = [x, self.k.line[swing.leg], own[2]]
        swing.ground = own[2] + self.expected_rise(x - own[0])
        before = not self.doubt.above(other[0], x + self.k.riser_lag * 5 / 3, PLACE_ROUNDING)
        swing.apex = (max(own[2], other[2]) if before else own[2]) + self.k.front_lift

    def expected_rise(self, way):
        """Return how much the slope of the feet rises over a way; less than 4 mm, or not sure yet, counts as level."""
        if self.even_landings < SLOPE_LANDINGS:
            return 0.0
        front, hind = crawl.middle(self.feet[:2]), crawl.middle(self.feet[2:])
        rise = way * (front[2] - hind[2]) / (front[0] - hind[0])
        return rise if self.doubt.above(abs(rise), self.k.drop_depth / 6, PLACE_ROUNDING) else 0.0

    def aim_hind(self, swing):
        """Into the oldest foothold of its side, or a stride ahead if there is none."""
        own, footholds = self.feet[swing.leg], self.footholds[swing.leg - RR]
        swing.known = bool(footholds) and not self.guessed[swing.leg - RR]
        ahead = [own[0] + self.k.stride, self.k.line[swing.leg - RR], own[2]]
        swing.target = self.take_foothold(swing.leg - RR) if footholds else ahead
        swing.ground = swing.target[2]
        swing.apex = max(own[2], swing.target[2]) + self.k.hind_lift

    def aim_hind_even(self, swing):
        """Keep the hip distance to where the front foot of the side goes next; its footholds do not count."""
        side, own = swing.leg - RR, self.feet[swing.leg]
        to_front = self.feet[side][0] + self.stride - 2 * self.k.half_length
        x = own[0] + limit(to_front - own[0], self.stride / 2, 1.4 * self.stride)
        swing.known = True
        swing.target = [x, self.k.line[side], own[2]]
        swing.ground = own[2] + self.expected_rise(x - own[0])
        swing.apex = max(own[2], swing.ground) + self.k.hind_lift
        self.footholds[side] = []

    def take_foothold(self, side):
        """Take a side's oldest foothold off its queue, the guessed ones first; return it."""
        self.guessed[side] = max(0, self.guessed[side] - 1)
        return self.footholds[side].pop(0)

    # --- a foot in the air

    def in_the_air(self, felt):
        """Go on with the stage, unless the body sinks over the leg: then it comes down where it is."""
        s, sunk, start_z = self.swing, -self.pushed_up(felt), self.feet[self.swing.leg][2]
        if self.doubt.above(sunk, self.k.sink, TILT_ROUNDING) and (s.tries < TRIES or s.place[2] > start_z):
            self.note_event(SINKS, s.place[2] - start_z)
            if s.place[2] > start_z:
                s.place[2] = s.ground = start_z
            s.tries, s.tare, s.load_ticks, s.peak = TRIES, 0.0, 0, False
            self.enter(LOWER)
        else:
            (self.lift, self.move, self.hang, self.lower)[self.stage - LIFT](felt)

    def lift(self, felt):
        """Go up and brake below the apex; a folded leg has its apex where it is."""
        s, k = self.swing, self.k
        braked = math.sqrt(k.lift_brake * max(0.0, s.apex - s.place[2])) + k.apex_speed
        s.speed = min(s.speed + k.lift_acceleration, braked, k.lift_speed)
        z = min(s.apex, s.place[2] + s.speed)
        if felt.length < k.folded:
            s.apex = z
        s.place[2] = max(s.place[2], z)
        if not self.doubt.above(s.apex, z, PLACE_ROUNDING):
            self.start_across()

    def start_across(self):
        """Begin the way across, as long as its mean speed makes it."""
        s = self.swing
        s.source = s.place[:2]
        way = math.sqrt((s.target[0] - s.place[0]) ** 2 + (s.target[1] - s.place[1]) ** 2)
        s.ticks_across = max(self.k.swing_ticks, self.doubt.whole(way / self.quick("swing_speed"), 0.02))
        self.enter(SWING)

    def move(self, felt):
        """Go across; into a riser go back and higher; there, once the body is there too, hang."""
        s, k = self.swing, self.k
        share = crawl.quintic(min(1.0, self.ticks / s.ticks_across))
        s.place[:2] = [a + share * (b - a) for a, b in zip(s.source, s.target)]
        if self.runs_into(felt):
            measured = felt.measured[s.leg]
            s.risers += 1
            self.note_event(RISER, measured[2] - s.ground)
            s.place[0], s.apex = measured[0] - k.riser_retreat, s.place[2] + k.clear_contact
            self.enter(LIFT)
        elif self.ticks >= s.ticks_across and self.body.tick >= self.body.ticks:
            self.enter(HANG)

    def runs_into(self, felt):
        """Return whether the foot is held up; a leg at its limits is not, and twice in a swing is enough."""
        s, k = self.swing, self.k
        if self.ticks <= k.riser_skip_ticks or s.risers == RISERS or felt.clipped:
            return False
        behind = s.past[-1 - k.goal_lag_ticks] - felt.measured[s.leg][0]
        way = s.target[0] - s.source[0]
        late = abs(way) / (s.ticks_across + 1) * k.swing_lag_ticks
        return self.doubt.above(behind, k.riser_lag + late, PLACE_ROUNDING + QUINTIC_ROUNDING * abs(way))

    def hang(self, felt):
        """Creep down and learn what the joints read without load; the first ticks still shake."""
        s, k = self.swing, self.k
        s.place[2] -= k.hang_speed
        gain = 1.0 if self.ticks <= k.hang_skip_ticks + 1 else k.tare_in_q15
        self.follow_tare(felt, gain)
        if self.ticks >= k.hang_ticks:
            self.enter(LOWER)
            s.speed, s.load_ticks, s.peak = k.hang_speed, 0, False

    def follow_tare(self, felt, gain):
        """Learn what the joints read; more than the least of a contact is load."""
        s = self.swing
        s.tare = limit(s.tare + gain * (felt.force[s.leg] - s.tare), -self.k.touch, self.k.touch)

    def lower(self, felt):
        """Go down until something is met: ground, felt or pushed off, an edge under the calf, a drop, or nothing."""
        s, k = self.swing, self.k
        self.go_down(felt)
        touches = self.feels_ground(felt)
        z, below = felt.measured[s.leg][2], s.ground - s.place[2]
        again, pushed = s.tries < TRIES, self.pushed_up(felt)
        near = self.doubt.above(k.drop_depth / 3, abs(z - s.ground), PLACE_ROUNDING)
        if near and self.doubt.above(pushed, k.stand_lift, TILT_ROUNDING):
            self.land(felt)
        elif again and self.doubt.above(pushed, k.calf_lift, TILT_ROUNDING):
            self.free_calf(felt, z)
        elif touches and self.doubt.above(s.ground + k.highest_contact, z, PLACE_ROUNDING):
            self.touch(felt, z)
        elif again and self.lost(s) and self.doubt.above(below, k.drop_depth, PLACE_ROUNDING):
            self.drop(felt)
        elif self.doubt.above(below, k.deepest, PLACE_ROUNDING):
            self.note_event(NO_GROUND, -below)
            self.land(felt)

    def go_down(self, felt):
        """Lower the foot, or with a straight leg the body as long as that follows."""
        s, k = self.swing, self.k
        brake, most = self.quick("lower_acceleration"), k.known_lower_speed if s.known else k.unknown_lower_speed
        if s.load_ticks:
            most = k.loaded_lower_speed
        elif self.long_strides:
            most = k.quick_lower_speed
        above = s.place[2] - s.ground - k.near_foothold
        s.speed = min(s.speed + brake, crawl_swing.fall_speed(above, k.unknown_lower_speed, most, brake))
        lag = felt.body[2] - self.body.wanted[2]
        if felt.length > k.swing_reach and self.doubt.above(k.position_limit, lag, PLACE_ROUNDING):
            self.body.wanted[2] -= k.body_speed
        else:
            s.place[2] -= s.speed

    def feels_ground(self, felt):
        """Return whether 60 ms of a contact's least load, with its peak in them, are under the foot."""
        s, k = self.swing, self.k
        load = felt.force[s.leg] - s.tare
        within = FORCE_ROUNDING + tare_rounding(k)
        if not self.doubt.above(load, k.touch, within):
            s.load_ticks, s.peak = 0, False
            self.follow_tare(felt, k.tare_down_q15)
            return False
        s.load_ticks += 1
        s.peak = s.peak or self.doubt.above(load, k.peak, within)
        return s.peak and s.load_ticks >= k.contact_ticks

    def pushed_up(self, felt):
        """Return how far the corner over the leg is above its plan."""
        wanted = self.body.wanted
        nose_up, left_up = wanted[4] - felt.body[4], felt.body[3] - wanted[3]
        return crawl_swing.corner_lift(nose_up, left_up, self.k.half_length, self.k.half_width, self.swing.leg)

    # --- what is met

    def again(self, felt, x, apex):
        """Try once more from where the foot is, at ``x``."""
        self.swing.tries += 1
        self.swing.place[2] = felt.measured[self.leg][2]
        self.swing.target[0], self.swing.apex = x, apex
        self.enter(LIFT)

    def again_with_hip(self, felt, x, apex):
        """Try once more at ``x`` and bring the hip over it, so that the leg comes down steeply."""
        self.again(felt, x, apex)
        self.body.plan(self.feet, self.leg, self.hip_over(x), felt.heavy, self.leg, self.quick("acceleration"))

    def free_calf(self, felt, z):
        """Off the edge and on a little."""
        s, k = self.swing, self.k
        self.note_event(CALF, z - s.ground)
        self.again_with_hip(felt, s.place[0] + k.edge_advance, max(z + k.calf_clear, s.ground + k.clear_ground))

    def touch(self, felt, z):
        """Stand here, or, on an edge where there should be none, look for a better place.

        Close beside a drop a hind foot is on its rim, and goes as far again. Where nothing is known it has found higher
        ground and goes on; so does a hind foot on its way down an edge; any other is on the corner of what its foothold
        lies on and goes back.
        """
        s, k = self.swing, self.k
        if s.leg >= RR and s.dropped and s.tries < TRIES:
            self.note_event(RIM, z - s.ground)
            self.leave_drop(felt, z)
            s.dropped = 0
            return
        tries = TRIES if s.known else 2
        if s.tries >= tries or not self.doubt.above(z - s.ground, k.edge_height, PLACE_ROUNDING):
            self.land(felt)
            return
        self.note_event(STEP, z - s.ground)
        x = s.place[0] + k.edge_advance
        if not s.known:
            s.ground = z
        elif not self.doubt.above(self.feet[s.leg][2] - k.edge_height, s.ground, PLACE_ROUNDING):
            x = s.place[0] - k.edge_retreat
        self.again(felt, x, z + k.clear_contact)

    def lost(self, s):
        """Return whether the foot may look for ground elsewhere: none has begun; a front foot does so once."""
        return not s.load_ticks and (s.leg >= RR or not s.dropped)

    def drop(self, felt):
        """Look for ground elsewhere: a front foot farther out, a hind foot nearer, or farther on if it climbs."""
        s, k = self.swing, self.k
        if s.leg < RR:
            s.dropped = 1
            if self.other_is_down(s):
                return
        self.note_event(DROP, s.place[2] - s.ground)
        if s.leg < RR:
            self.again_with_hip(felt, s.place[0] + k.drop_advance, s.ground + k.clear_ground)
        else:
            climbs = self.doubt.above(s.target[2] - self.feet[s.leg][2], k.edge_height, PLACE_ROUNDING)
            s.dropped = 1 if climbs else -1
            self.leave_drop(felt, s.ground)

    def leave_drop(self, felt, z):
        """Try beside the drop, the way it sends a hind foot, clear of ground at ``z``."""
        self.again(felt, self.swing.place[0] + self.swing.dropped * self.k.edge_advance, z + self.k.clear_contact)

    def other_is_down(self, s):
        """Return whether the other front foot stands below, and well behind: then the edge is far enough behind."""
        other = self.feet[1 - s.leg]
        down = self.doubt.above(s.ground - self.k.edge_height * 2 / 3, other[2], PLACE_ROUNDING)
        return down and self.doubt.above(s.place[0] - other[0], self.k.edge_advance * 6 / 5, 2 * PLACE_ROUNDING)

    def land(self, felt):
        """Stand where the foot is measured, leave a foothold for the hind foot, and rest before the next leg."""
        s, leg = self.swing, self.leg
        self.feet[leg] = list(felt.measured[leg])
        self.stands[leg], self.share[leg] = True, 0.0
        self.note_event(LANDED, self.feet[leg][2] - s.ground)
        if leg < RR:
            if len(self.footholds[leg]) == 4:
                self.take_foothold(leg)
            down = s.target[2] - self.feet[leg][2]
            if self.footholds[leg] and self.doubt.above(down, self.k.edge_height, PLACE_ROUNDING):
                self.footholds[leg][-1][0] -= self.k.edge_retreat
            self.footholds[leg].append(list(self.feet[leg]))
            self.occupied[leg] = True
        off = crawl.uneven(self.feet, leg, (s.source[0], s.target[2]))
        uneven = self.doubt.above(off, self.k.drop_depth / 3, EVEN_ROUNDING)
        self.even_landings = 0 if uneven else self.even_landings + 1
        self.landings += 1
        self.order += 1
        self.ahead -= self.stride / 4
        self.enter(REST)
