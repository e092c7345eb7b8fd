"""matplotlib, for pictures in files."""

import logging
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def make_figure(width: float, height: float) -> "Figure":
    """Return an empty figure, in inches. matplotlib is imported here, as it takes half a second."""
    logging.getLogger("matplotlib").setLevel(logging.ERROR)  # where its settings can't be kept, it writes two lines
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")
