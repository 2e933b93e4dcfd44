"""From a laser scan of a building to its model.

The names below are loaded when they are first used, so that ``import indoor_bim`` stays light.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from indoor_bim import cloud, filters, plan, planes, quality, simulate
    from indoor_bim.cloud import levels
    from indoor_bim.cloud.cloud import Cloud
    from indoor_bim.cloud.read import read
    from indoor_bim.cloud.scan_info import info
    from indoor_bim.config import load_params
    from indoor_bim.errors import IndoorBimError
    from indoor_bim.export.json import read_json as read_model
    from indoor_bim.export.registry import write as export
    from indoor_bim.frame import Frame
    from indoor_bim.model import Building
    from indoor_bim.params import Params
    from indoor_bim.pipeline import Result, reconstruct
    from indoor_bim.quality.compare import compare

__version__ = "0.1.0"

__all__ = [
    "Building",
    "Cloud",
    "Frame",
    "IndoorBimError",
    "Params",
    "Result",
    "cloud",
    "compare",
    "export",
    "filters",
    "info",
    "levels",
    "load_params",
    "plan",
    "planes",
    "quality",
    "read",
    "read_model",
    "reconstruct",
    "simulate",
]

_HOME = {
    "Building": "indoor_bim.model:Building",
    "Cloud": "indoor_bim.cloud.cloud:Cloud",
    "Frame": "indoor_bim.frame:Frame",
    "IndoorBimError": "indoor_bim.errors:IndoorBimError",
    "Params": "indoor_bim.params:Params",
    "Result": "indoor_bim.pipeline:Result",
    "cloud": "indoor_bim.cloud",
    "compare": "indoor_bim.quality.compare:compare",
    "export": "indoor_bim.export",
    "filters": "indoor_bim.filters",
    "info": "indoor_bim.cloud.scan_info:info",
    "levels": "indoor_bim.cloud.levels",
    "load_params": "indoor_bim.config:load_params",
    "plan": "indoor_bim.plan",
    "planes": "indoor_bim.planes",
    "quality": "indoor_bim.quality",
    "read": "indoor_bim.cloud.read:read",
    "read_model": "indoor_bim.export.json:read_json",
    "reconstruct": "indoor_bim.pipeline:reconstruct",
    "simulate": "indoor_bim.simulate",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'indoor_bim' has no attribute {name!r}")
    module, _, attribute = _HOME[name].partition(":")
    found = import_module(module)
    value = getattr(found, attribute) if attribute else found
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
