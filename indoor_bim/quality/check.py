"""Is an IFC file what its schema, buildingSMART's rules and the deliverable ask for."""

from __future__ import annotations

import logging
import os
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Literal

from indoor_bim.errors import ReadError
from indoor_bim.quality.deliverable import deliverable
from indoor_bim.quality.express import told_assertions
from indoor_bim.quality.ifc_rules import RULES

_END = b"END-ISO-10303-21"
_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that is wrong.

    Parameters
    ----------
    severity : {"error", "warning"}
        Errors break the schema or a rule; warnings concern the deliverable.
    rule : str
        What asks for it: "schema", an EXPRESS rule, a rule of buildingSMART or a specification of the deliverable.
    entity : str
        Entity that is concerned, as in the file.
    message : str
        What was found.
    """

    severity: Literal["error", "warning"]
    rule: str
    entity: str
    message: str


@dataclass(frozen=True, slots=True)
class CheckReport:
    """Outcome of a check.

    Parameters
    ----------
    path : str
        File that was checked.
    schema : str
        Its schema.
    checked : tuple of str
        Groups of requirements that were tested.
    findings : tuple of Finding
        What is wrong, in the order of the groups.
    """

    path: str
    schema: str
    checked: tuple[str, ...]
    findings: tuple[Finding, ...]

    @property
    def ok(self) -> bool:
        """True when nothing at all was found."""
        return not self.findings


def check_ifc(path: str | os.PathLike[str], *, rules: bool = True) -> CheckReport:
    """Check an IFC file.

    Parameters
    ----------
    path : path
        IFC file (STEP).
    rules : bool
        Also run the EXPRESS rules of the schema, which take most of the time.

    Returns
    -------
    CheckReport
        Findings against the schema, its rules, the rules of buildingSMART and the deliverable; empty for a good file. The deliverable is
        left out, which the log tells, where `ifctester` is not installed.

    Raises
    ------
    ReadError
        If the file is missing, damaged or no IFC file.
    """
    name = os.fspath(path)
    file = _open(Path(path))
    checked = ["schema", "rules", "buildingSMART", "deliverable"]
    findings = list(_schema_findings(name, rules=rules))
    if not rules:
        checked.remove("rules")
    if file.schema == "IFC2X3":
        checked = checked[:-2]
    else:
        findings += [Finding("error", rule.__name__, str(entity), message) for rule in RULES for entity, message in rule(file)]
        if find_spec("ifctester") is None:
            _log.info("%s: not checked against the deliverable: pip install 'indoor-bim[ids]' for that.", name)
            checked.remove("deliverable")
        else:
            findings += _deliverable_findings(file)
    return CheckReport(name, str(file.schema_identifier), tuple(checked), tuple(findings))


def _open(path: Path) -> Any:
    import ifcopenshell

    try:
        with path.open("rb") as stream:
            stream.seek(max(0, path.stat().st_size - 1024))
            tail = stream.read()
    except OSError as error:
        raise ReadError(f"{path}: cannot be read ({error.strerror}); expected an IFC file.") from error
    try:
        file = ifcopenshell.open(str(path))
    except (OSError, ifcopenshell.Error) as error:
        raise ReadError(f"{path}: is no IFC file that can be read ({error}); expected a STEP file of IFC2X3, IFC4 or IFC4X3.") from error
    if _END not in tail:
        raise ReadError(f"{path}: the end of the file is missing (no {_END.decode()}); it was cut off, write or copy it again.")
    return file


def _schema_findings(path: str, *, rules: bool) -> Iterator[Finding]:
    from ifcopenshell import validate

    logger: Any = validate.json_logger()  # type: ignore[no-untyped-call]
    with told_assertions(), warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)  # the runner leaves the file of its rules to the garbage collector
        validate.validate(path, logger, express_rules=rules)
    for statement in logger.statements:
        attribute = str(statement.get("attribute") or "")
        kind = str(statement.get("type") or "")
        rule = attribute if kind.endswith("_rule") and attribute else "schema"
        entity = statement.get("instance")
        severity: Literal["error", "warning"] = "warning" if statement.get("level") == "warning" else "error"
        yield Finding(severity, rule, "" if entity is None else str(entity), " ".join(str(statement["message"]).split()))


def _deliverable_findings(file: Any) -> list[Finding]:
    document = deliverable()
    document.validate(file)
    return [
        Finding("warning", specification.name, str(failure["element"]), failure["reason"])
        for specification in document.specifications
        for requirement in specification.requirements
        for failure in requirement.failures
    ]
