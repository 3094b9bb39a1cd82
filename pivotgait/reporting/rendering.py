"""Templates filled: the one place where jinja is set up."""

from __future__ import annotations

import base64
from types import MappingProxyType
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from pivotgait.reporting.numbers import number, quantity

_MEDIA = MappingProxyType(
    {b"\x89PNG": "image/png", b"<?xml": "image/svg+xml", b"RIFF": "image/webp"}
)


def data_uri(image: bytes) -> str:
    """An SVG, PNG or WebP image as a data URI.

    Raises:
        ValueError: if it is none of them.
    """
    for start, media in _MEDIA.items():
        if image.startswith(start):
            return f"data:{media};base64,{base64.b64encode(image).decode()}"
    raise ValueError(f"an image is neither SVG, PNG nor WebP: it starts with {image[:8]!r}")


def render(template: str, **values: Any) -> str:
    """A page's HTML: the template with these values and the style of all pages as ``style``."""
    loader = PackageLoader("pivotgait.reporting", "templates")
    environment = Environment(
        loader=loader,
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"number": number, "quantity": quantity, "data_uri": data_uri}
    # ours, not a user's: the only text of a page that is not escaped
    style = Markup(loader.get_source(environment, "report.css")[0])
    return environment.get_template(template).render(style=style, **values)
