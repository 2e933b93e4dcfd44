"""EXPRESS rules of the IFC schema, run without a test framework installed."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType

_MODULE = "_pytest"


@contextmanager
def told_assertions() -> Iterator[None]:
    """Let the rule runner of ifcopenshell say which condition failed.

    The runner takes the rewriting of assertions from pytest. Within this context it gets `explain_assertions` in its place: a
    fifth of the time, and nothing to install.
    """
    package, assertion, rewrite = ModuleType(_MODULE), ModuleType(f"{_MODULE}.assertion"), ModuleType(f"{_MODULE}.assertion.rewrite")
    rewrite.rewrite_asserts = explain_assertions  # type: ignore[attr-defined]
    assertion.rewrite = rewrite  # type: ignore[attr-defined]
    package.assertion = assertion  # type: ignore[attr-defined]
    before = {_MODULE: sys.modules[_MODULE]} if _MODULE in sys.modules else {}
    sys.modules[_MODULE] = package
    try:
        yield
    finally:
        del sys.modules[_MODULE]
        sys.modules.update(before)


def explain_assertions(mod: ast.Module, source: str | bytes) -> None:
    """Give every assertion without a message its own condition as the message, in place.

    Parameters
    ----------
    mod : ast.Module
        Parsed rules.
    source : str or bytes
        Their source; conditions are read from the tree.

    Examples
    --------
    >>> tree = ast.parse("assert 1 > 2")
    >>> explain_assertions(tree, "")
    >>> ast.unparse(tree)
    "assert 1 > 2, '1 > 2'"
    """
    for node in ast.walk(mod):
        if isinstance(node, ast.Assert) and node.msg is None:
            node.msg = ast.copy_location(ast.Constant(ast.unparse(node.test)), node.test)
