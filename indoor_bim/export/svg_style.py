"""Line weights, type and colours of the plan."""

from __future__ import annotations

from types import MappingProxyType

_THEMES = MappingProxyType(
    {
        "print": {"paper": "#ffffff", "ink": "#000000", "soft": "#555555", "poche": "#dcdcdc", "floor": "#ffffff", "glass": "#1f5f99"},
        "dark": {"paper": "#14181d", "ink": "#e8eaed", "soft": "#9aa4af", "poche": "#39424d", "floor": "#1b2027", "glass": "#6cb6ff"},
    }
)

_STYLE = """
text { font-family: 'DejaVu Sans', Verdana, Arial, Helvetica, sans-serif; fill: {ink}; stroke: none; white-space: pre }
path { fill: none; stroke: {ink}; stroke-width: 0.18; stroke-linecap: butt; stroke-linejoin: miter }
.sheet { fill: {paper} }
.underlay { opacity: 0.5 }
path.room { fill: {floor}; fill-opacity: 0; stroke: none; fill-rule: evenodd }
path.open-border { stroke: {soft}; stroke-width: 0.13; stroke-dasharray: 2 1 }
path.wall-body { fill: {poche}; stroke: none; fill-rule: evenodd }
path.hatch { stroke: {soft}; stroke-width: 0.09 }
path.outline { stroke-width: 0.5; stroke-linecap: square }
path.unsupported { stroke-width: 0.25; stroke-dasharray: 1.6 1; stroke-linecap: butt }
path.unseen { stroke-width: 0.25; stroke-dasharray: 3 1.2; stroke-linecap: butt }
path.column-body { fill: {soft}; stroke-width: 0.35 }
path.threshold { stroke-width: 0.13 }
path.leaf { stroke-width: 0.35 }
path.swing { stroke-width: 0.13 }
path.closed-leaf { fill: {paper}; stroke-width: 0.18 }
path.glass { stroke: {glass}; stroke-width: 0.25 }
path.lintel { stroke-width: 0.18; stroke-dasharray: 1.2 0.8 }
path.dimension-line { stroke: {soft}; stroke-width: 0.13 }
path.tick { stroke-width: 0.35 }
path.frame { stroke-width: 0.5 }
path.cell { stroke-width: 0.18 }
path.bar-dark { fill: {ink}; stroke-width: 0.18 }
path.bar-light { fill: {paper}; stroke-width: 0.18 }
path.north { fill: {ink}; stroke-width: 0.18 }
text.caption { fill: {soft} }
text.dimension-text { fill: {ink} }
"""


def style_sheet(theme: str) -> str:
    """Return the style sheet of a plan.

    Parameters
    ----------
    theme : {"print", "dark"}
        Colours.

    Returns
    -------
    str
        CSS text.

    Raises
    ------
    ValueError
        If there is no such theme.
    """
    if theme not in _THEMES:
        raise ValueError(f'there is no theme "{theme}"; expected one of {", ".join(_THEMES)}')
    text = _STYLE
    for name, colour in _THEMES[theme].items():
        text = text.replace("{" + name + "}", colour)
    return text
