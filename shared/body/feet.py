"""Four feet, each with a place."""

from ..record import parts, record
from .axes import Point
from .params import LEGS


@record
class Feet:
    """A place of each foot; whose unit and frame are named where it is used."""

    legs: list[Point] = parts(LEGS, Point, "FR, FL, RR, RL")
