"""Writers of the building model: each reads the model and nothing else.

The package is also the function that chooses the writer: ``indoor_bim.export(building, "model.ifc")``.
"""

from __future__ import annotations

import os
import sys
from types import ModuleType

from indoor_bim.model import Building


class _Export(ModuleType):
    """Package that can be called as `indoor_bim.export.registry.write`."""

    def __call__(self, building: Building, path: str | os.PathLike[str]) -> None:
        from indoor_bim.export.registry import write

        write(building, path)


sys.modules[__name__].__class__ = _Export
