"""All files of a village, in one folder."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from types import MappingProxyType

from indoor_bim.outdoor.model import Village
from indoor_bim.params import Params

FILES: Mapping[str, tuple[str, str, str]] = MappingProxyType(
    {
        "geojson": ("footprints.geojson", "indoor_bim.export.footprints", "write_footprints"),
        "ifc": ("village.ifc", "indoor_bim.export.ifc_houses", "write_houses_ifc"),
        "svg": ("map.svg", "indoor_bim.export.map_svg", "write_map_svg"),
        "dxf": ("map.dxf", "indoor_bim.export.map_dxf", "write_map_dxf"),
        "ply": ("village.ply", "indoor_bim.export.house_meshes", "write_houses_ply"),
        "obj": ("village.obj", "indoor_bim.export.house_meshes", "write_houses_obj"),
        "cityjson": ("village.city.json", "indoor_bim.export.cityjson", "write_cityjson"),
    }
)


def write_outputs(village: Village, folder: Path, *, formats: Sequence[str], params: Params) -> tuple[Path, ...]:
    """Write the village in every format, and the parameters that made it.

    Parameters
    ----------
    village : Village
        Houses, metres.
    folder : path
        Folder that exists.
    formats : sequence of str
        Keys of `FILES`.
    params : Params
        Parameters of the run.

    Returns
    -------
    tuple of Path
        The files written.
    """
    from indoor_bim import __version__
    from indoor_bim.config import to_toml
    from indoor_bim.export.files import write_text

    paths = []
    for name, (file, module, function) in FILES.items():
        if name in formats:
            writer: Callable[[Village, Path], None] = getattr(import_module(module), function)
            writer(village, folder / file)
            paths.append(folder / file)
    settings = folder / "params.toml"
    write_text(settings, to_toml(params, header=[f"indoor-bim {__version__}, houses, method {village.method}", f"scan {village.source}"]))
    return (*paths, settings)
