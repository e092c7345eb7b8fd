"""Four feet, each a point."""

from ..record import parts, record
from .axes import Point
from .params import LEGS


@record
class Feet:
    """A point for each foot; unit and frame are named where it is used."""

    legs: list[Point] = parts(LEGS, Point, "FR, FL, RR, RL")
