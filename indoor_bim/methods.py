"""The methods of reconstruction by name; each leads from a cloud to storeys of the model."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from indoor_bim.model import Storey
from indoor_bim.params import Params
from indoor_bim.stages import Stages

if TYPE_CHECKING:
    from indoor_bim.cloud.cloud import Cloud
    from indoor_bim.frame import Frame


@dataclass(frozen=True, slots=True, eq=False)
class Reconstruction:
    """What a method returns.

    Parameters
    ----------
    frame : Frame
        Takes scan coordinates to model coordinates.
    storeys : tuple of Storey
        Storeys from the bottom up.
    derived : dict of str to value
        Values of parameters that were derived from the scan, by ``stage.name``.
    warnings : tuple of str
        What is missing or doubtful, in sentences.
    """

    frame: Frame
    storeys: tuple[Storey, ...] = ()
    derived: dict[str, Any] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()


Method = Callable[["Cloud", Params, Stages], Reconstruction]


def slope(cloud: Cloud, params: Params, stages: Stages) -> Reconstruction:
    """Levelling by principal components, thinning, slope lines (Remote Sensing 2021, 13, 4930).

    Parameters
    ----------
    cloud : Cloud
        The scan.
    params : Params
        All parameters.
    stages : Stages
        Keeps every stage's product.
    """
    raise NotImplementedError


METHODS: Mapping[str, Method] = MappingProxyType({"slope": slope})
