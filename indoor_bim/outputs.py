"""All files of a run, in one folder."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from indoor_bim.config import to_toml
from indoor_bim.errors import ConfigError, WriteError
from indoor_bim.export.files import write_text
from indoor_bim.export.plan_style import PlanStyle, Underlay
from indoor_bim.export.registry import KINDS, write
from indoor_bim.model import Building
from indoor_bim.params import Params

PLANS = ("svg", "dxf", "pdf", "png")
FILES: Mapping[str, str] = MappingProxyType({kind: f"{'plan' if kind in PLANS else 'model'}{ending}" for kind, ending in KINDS.items()})


def prepare_folder(folder: str | Path, *, formats: Sequence[str], known: Collection[str] = tuple(FILES)) -> Path:
    """Make the folder for the results, before anything is computed.

    Parameters
    ----------
    folder : path
        Folder to make or to use.
    formats : sequence of str
        What will be written.
    known : collection of str
        What there is.

    Raises
    ------
    ConfigError
        If there is no such format.
    WriteError
        If the folder cannot be made.
    """
    unknown = [name for name in formats if name not in known]
    if unknown:
        raise ConfigError(f'formats: there is no "{unknown[0]}"; expected some of {", ".join(sorted(known))}')
    path = Path(folder)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise WriteError(f"{path}: cannot make this folder ({error.strerror}); name a folder you may write to.") from None
    return path


def write_outputs(
    building: Building,
    folder: Path,
    *,
    formats: Sequence[str],
    params: Params,
    derived: Mapping[str, Any],
    scan: Path | None,
    underlays: Mapping[str, Underlay] | None = None,
) -> tuple[Path, ...]:
    """Write the model in every format, and the parameters that made it.

    Parameters
    ----------
    building : Building
        The model.
    folder : path
        Folder that exists.
    formats : sequence of str
        Keys of `FILES`.
    params : Params
        Parameters of the run.
    derived : mapping of str to value
        Values derived from the scan, by ``stage.name``.
    scan : path, optional
        Scan file, to note its checksum.
    underlays : mapping of str to Underlay, optional
        Pictures of the scan to lie under the plans, by the identifier of the storey.

    Returns
    -------
    tuple of Path
        The files written.
    """
    from indoor_bim import __version__

    header = [f"indoor-bim {__version__}, method {building.method}", f"scan {building.source}"]
    if scan is not None:
        header.append(f"sha256 {_checksum(scan)}")
    paths = list(dict.fromkeys(folder / FILES[name] for name in FILES if name in formats))
    style = plan_style(params, underlays or {})
    for path in paths:
        write(building, path, schema=params.ifc.version, style=style)
    settings = folder / "params.toml"
    write_text(settings, to_toml(params, header=header, derived=derived))
    return (*paths, settings)


def failed_checks(folder: Path) -> tuple[str, ...]:
    """Check the IFC file of a run, if there is one, against everything but the slow rules of its schema.

    Parameters
    ----------
    folder : path
        Folder that `write_outputs` wrote to.

    Returns
    -------
    tuple of str
        A sentence for each rule that the file breaks.
    """
    path = folder / FILES["ifc"]
    if not path.exists():
        return ()
    from indoor_bim.quality.check import check_ifc

    findings = check_ifc(path, rules=False).findings
    rules = dict.fromkeys(finding.rule for finding in findings)
    return tuple(f"{path.name} does not keep to the rule {rule!r}: {next(f.message for f in findings if f.rule == rule)}" for rule in rules)


def plan_style(params: Params, underlays: Mapping[str, Underlay]) -> PlanStyle:
    """Choices for drawing plans, from the parameters and pictures of the scan by the identifier of the storey."""
    drawing = params.drawing
    return PlanStyle(drawing.scale, drawing.paper, drawing.theme, underlays)


def _checksum(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
