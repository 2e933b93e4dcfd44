"""Book-keeping of a run: the product and the time of every stage, and progress reports."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

logger = logging.getLogger(__name__)

Progress = Callable[[str, float], None]


@dataclass(slots=True)
class Stages:
    """Collects the product and the time of every stage and reports progress.

    Parameters
    ----------
    progress : callable, optional
        Called with the name of a stage and the share of it that is done, 0 to 1.

    Examples
    --------
    >>> stages = Stages()
    >>> with stages("count") as keep:
    ...     keep(3)
    >>> stages.products
    {'count': 3}
    """

    progress: Progress | None = None
    products: dict[str, Any] = field(default_factory=dict)
    timings: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def __call__(self, name: str) -> Iterator[Callable[[Any], None]]:
        """Run a stage and keep its product."""
        self._report(name, 0.0)
        start = time.perf_counter()
        yield lambda product: self.products.__setitem__(name, product)
        self.timings[name] = self.timings.get(name, 0.0) + time.perf_counter() - start
        logger.info("%s took %.2f s", name, self.timings[name])
        self._report(name, 1.0)

    def _report(self, name: str, share: float) -> None:
        if self.progress is not None:
            self.progress(name, share)
