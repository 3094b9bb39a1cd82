"""Parameters of a scene as axes: words, symbol and unit."""

from __future__ import annotations

import re
from typing import NamedTuple

_KNOWN = {
    "contacts.*.friction": "friction of the fingers $\\mu_H$ [-]",
    "table.friction": "friction of the table $\\mu_T$ [-]",
    "contacts.*.normal_force_N.max": "largest force of a finger $f_{max}$ [N]",
    "contacts.*.normal_force_N.min": "least force of a finger [N]",
    "table.normal_force_N.max": "largest force of the tip [N]",
    "tool.mass_scale": "mass of the tool over its own [-]",
    "tool.pitch_deg": "pitch of the tool [deg]",
    "tool.roll_deg": "roll of the tool [deg]",
    "tool.yaw_deg": "yaw of the tool [deg]",
    "lift.duration_s": "duration of the lift [s]",
    "removal.duration_s": "duration of the removal [s]",
    "addition.duration_s": "duration of the addition [s]",
    "removal.steps": "steps of the removal $K$ [-]",
    "allocation.friction_reserve": "reserve of friction [-]",
}
_FIELDS = {
    "along_m": ("along the handle [mm]", 1e3),
    "around_deg": ("around the handle [deg]", 1.0),
    "friction": ("friction $\\mu$ [-]", 1.0),
    "max": ("largest force [N]", 1.0),
    "min": ("least force [N]", 1.0),
}


class ParameterLabel(NamedTuple):
    """How a parameter is written at an axis.

    Attributes:
        text: words and unit.
        scale: factor from the parameter's own unit to that of the text.
    """

    text: str
    scale: float = 1.0


def parameter_label(parameter: str) -> ParameterLabel:
    """The label of a parameter; one that is not known keeps its path."""
    if parameter in _KNOWN:
        return ParameterLabel(_KNOWN[parameter])
    first, *rest = parameter.split(".")
    if first == "contacts" and len(rest) > 1 and rest[-1] in _FIELDS:
        words, scale = _FIELDS[rest[-1]]
        return ParameterLabel(f"{rest[0].replace('_', ' ')} {words}", scale)
    return ParameterLabel(parameter)


def parameter_words(parameter: str) -> str:
    """``pitch of the tool [deg]``: the label as plain text, without symbols."""
    return " ".join(re.sub(r"\$[^$]*\$", "", parameter_label(parameter).text).split())


def parameter_value(parameter: str, value: float | str) -> str:
    """``pitch of the tool 25 deg``: the parameter with one value, for a title."""
    label = parameter_label(parameter)
    words, _, unit = label.text.rpartition(" [")
    if not words:
        words, unit = label.text, ""
    shown = f"{label.scale * value:.4g}" if isinstance(value, int | float) else value or "none"
    return f"{words} {shown} {unit.rstrip(']').replace('-', '')}".strip()
