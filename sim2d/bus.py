"""Carries goals from the controller to the drives with a delay."""

from collections import deque
from collections.abc import Sequence

from .world import World


class LateBus:
    """Goals under way: each acts a fixed number of sub-steps after it was sent."""

    def __init__(self, world: World, delay_s: float, goal_rad: Sequence[float]) -> None:
        if not 0 <= delay_s <= 1.0:
            raise ValueError(f"bus_delay_s = {delay_s}: allowed 0 .. 1")
        self._world, self._delay_steps = world, round(delay_s / world.dt_s)
        self._acting = list(goal_rad)
        self._sent: deque[tuple[int, list[float]]] = deque()

    def send(self, goal_rad: list[float]) -> None:
        """Send eight planar goals now."""
        self._sent.append((self._world.steps + self._delay_steps, goal_rad))

    def advance_to(self, step: int) -> None:
        """Run the world up to a sub-step, each goal from the instant it arrives."""
        world, sent = self._world, self._sent
        while sent and sent[0][0] <= step:
            due, goal = sent.popleft()
            world.advance(self._acting, due - world.steps)
            self._acting = goal
        world.advance(self._acting, step - world.steps)
