"""The grounds that a simulated drive in space may choose from, by name, and their surface for the page's picture."""

from .export.ground import Ground
from .grounds import GroundSpec, make_ground, make_terrain

NAMES = ("flat", "step", "box", "ramp", "slope-up", "stairs-up")  # alike across the way; stones have no line


def profiles() -> dict[str, tuple[tuple[float, float], ...]]:
    """Return each ground's surface: (x, z) along the way, m."""
    return {name: tuple(make_terrain(GroundSpec(name)).points_m) for name in NAMES}


def ground(name: str) -> Ground:
    """Return a ground in space; ValueError for none of NAMES."""
    if name not in NAMES:
        raise ValueError(f"ground {name}: allowed: {', '.join(NAMES)}")
    return make_ground(GroundSpec(name))
