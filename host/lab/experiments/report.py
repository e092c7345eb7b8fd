"""One HTML page with every table, picture and animation of the experiments; it needs no other file."""

import base64
import html
from collections.abc import Sequence
from pathlib import Path

from sim2d.view import animation_html

from ...control.gait_changes import change_lines
from ...robot.model import Robot
from .case import Outcome, Table
from .trials import Answer

_STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; color: #222; max-width: 1150px; margin: 2rem auto; padding: 0 1rem }
h1, h2 { color: #2f4a6d } h2 { margin-top: 2.5rem; border-bottom: 1px solid #ccd3dd }
table { border-collapse: collapse; margin: 0.6rem 0 1.2rem }
caption { text-align: left; font-weight: 600; padding: 4px 0 }
th, td { padding: 3px 12px 3px 0; text-align: left; vertical-align: top; border-bottom: 1px solid #e4e8ee }
img { max-width: 100%; display: block; margin: 0.5rem 0 } figcaption { color: #555 }
iframe { width: 100%; height: 640px; border: 1px solid #ccd3dd } summary { cursor: pointer; padding: 3px 0 }
.wide { overflow-x: auto }
"""


def report_html(robot: Robot, outcomes: Sequence[Outcome], folder: Path) -> str:
    """Return the page; the pictures are taken from ``folder``, the animations' trunk is the robot's."""
    title = "Experiments: {robot}, gait {gait}".format(**outcomes[0].found.result)
    parts = [_section(robot, outcome, folder) for outcome in outcomes]
    contents = "".join(f'<li><a href="#{each.name}">{html.escape(each.title)}</a></li>' for each in outcomes)
    intro = ("Plane: the project's own simulator of the sagittal plane. 3-D: the independent check in MuJoCo, with the "
             "same planner and servo law. Paper: the papers' measurements on their robots.")
    return (f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}</title>'
            f'<meta name="viewport" content="width=device-width"><style>{_STYLE}</style></head>\n<body>'
            f"<h1>{html.escape(title)}</h1><p>{intro}</p><ul>{contents}</ul>\n{''.join(parts)}</body></html>\n")


def _section(robot: Robot, outcome: Outcome, folder: Path) -> str:
    parts = [f'<section id="{outcome.name}"><h2>{html.escape(outcome.title)}</h2>']
    parts += [_table(table) for table in outcome.found.tables]
    for picture in outcome.found.pictures:
        data = base64.b64encode((folder / picture.name).read_bytes()).decode()
        caption = html.escape(picture.caption)
        parts.append(f'<figure><img alt="{caption}" src="data:image/png;base64,{data}">'
                     f"<figcaption>{caption}</figcaption></figure>\n")
    parts += [_film(robot, *film) for film in outcome.films]
    return "".join(parts) + "</section>\n"


def _table(table: Table) -> str:
    head = "".join(f"<th>{html.escape(cell)}</th>" for cell in table.head)
    rows = "".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>\n" for row in table.rows)
    return (f'<div class="wide"><table><caption>{html.escape(table.title)}</caption>'
            f"<tr>{head}</tr>\n{rows}</table></div>\n")


def _film(robot: Robot, title: str, answer: Answer) -> str:
    """Return an animation that is loaded when its line is opened."""
    size_m, figures, sentence = robot.links.trunk.size_m, answer.figures, answer.recording.outcome.sentence
    facts = [("speed", f"{figures['mean_speed_m_s']:.4f} m/s"),
             ("pitch range", f"{figures['pitch_range_deg']:.1f} deg"),
             *change_lines(figures["gait_changes"]), ("outcome", str(figures["reason"]))]
    page = animation_html(answer.recording, title, sentence, facts, (size_m[0] / 2, size_m[2] / 2))
    return (f"<details><summary>{html.escape(title)}: {html.escape(sentence)}</summary>"
            f'<iframe loading="lazy" title="{html.escape(title)}" srcdoc="{html.escape(page)}"></iframe>'
            "</details>\n")
