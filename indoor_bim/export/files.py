"""Files that are either complete or not there."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from indoor_bim.errors import WriteError


@contextmanager
def replace_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a path to write to; when the block ends well, the file takes the place of `path`.

    The given path has the same file name, in a hidden folder beside the target. When the block raises, that folder goes and
    what stood at `path` before stays untouched.

    Parameters
    ----------
    path : path
        File to create or to replace. Its folder must exist.

    Yields
    ------
    pathlib.Path
        Path that the block writes the whole file to.

    Raises
    ------
    WriteError
        If the folder is missing or not writable, if `path` is a folder, or if the disk refuses.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with replace_file(Path(folder, "note.txt")) as draft:
    ...         _ = draft.write_text("complete")
    ...     Path(folder, "note.txt").read_text()
    'complete'
    """
    target = Path(path)
    if target.is_dir():
        raise WriteError(f"{target}: is a folder, expected the name of a file to write.")
    if not target.parent.is_dir():
        raise WriteError(f"{target}: there is no folder {target.parent}; create it or name another one.")
    try:
        folder = Path(tempfile.mkdtemp(prefix=".", suffix=".partial", dir=target.parent))
    except OSError as error:
        raise WriteError(
            f"{target}: cannot write into the folder {target.parent} ({error.strerror}); name a folder you may write to."
        ) from error
    try:
        draft = folder / target.name
        yield draft
        os.replace(draft, target)
    except OSError as error:
        raise WriteError(f"{target}: could not be written ({error.strerror or error}).") from error
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write a whole text file as UTF-8 with Unix line ends, or nothing.

    Parameters
    ----------
    path : path
        File to create or to replace.
    text : str
        Contents.

    Raises
    ------
    WriteError
        As `replace_file`.
    """
    with replace_file(path) as draft:
        draft.write_bytes(text.encode("utf-8"))
