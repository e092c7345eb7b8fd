"""What a crawl of a robot's shape may plan with, in floats (m, rad): reach by the cosine rule, height, stride."""

import math

from .reach import leg_lengths

BEND = math.radians(30)


def shape(legs):
    """Return the lengths that the crawl plans with, by their names.

    Hips are carried at 0.865 of the straightest leg. A calf is bent by 30 degrees at least: planned reach stays 2 %
    inside that, a leg in the air 0.4 %; a leg within 1.4 % of the most bent is folded. The stride is a third of the
    hips' distance, at most 90 mm of a leg of 240.
    """
    straight = min([leg_lengths(leg)[0] for leg in legs])
    felt = min([straight] + [math.hypot(leg.l2 + leg.l3 * math.cos(BEND), leg.l3 * math.sin(BEND)) for leg in legs])
    bent = max([leg_lengths(leg)[1] for leg in legs])
    hips = legs[0].hip[0] - legs[2].hip[0]
    return {
        "height": 0.865 * straight,
        "reach": felt * 48 / 49,
        "swing_reach": felt * 239 / 240,
        "folded": bent * 73 / 72,
        "stride": min(hips / 3, (legs[0].l2 + legs[0].l3) * 90 / 240),
        "half_length": hips / 2,
        "half_width": abs(legs[0].hip[1] + legs[0].side_l1),
    }
