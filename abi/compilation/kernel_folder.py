"""Folders of compiled kernels: a user's, for all clones and environments, and that of a wheel.

Nothing here imports numba, which takes longer than to begin compiling in other processes.
"""

from __future__ import annotations

import logging
import os
import tempfile
from functools import cache
from pathlib import Path

from abi.user_cache import temporary_cache, user_cache

_log = logging.getLogger(__name__)

_ADVICE = "NUMBA_CACHE_DIR can name a folder"

READY = Path(__file__).resolve().parents[1] / "ready_kernels"
"""Where an installed wheel has them; ``tools/ready_kernels.py`` puts them there."""


@cache
def kernel_folder() -> Path | None:
    """Folder of the compiled forms: in ``$NUMBA_CACHE_DIR`` or the user's cache.

    Where that cannot be written it is in the temporary directory, and a line in the log says so.
    None if that is not possible either.
    """
    refused = ""
    for place in (_usual, _in_temporary_cache):
        try:
            folder = place()
            folder.mkdir(parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=folder).close()
        except OSError as error:
            refused = refused or str(error)
            continue
        if refused:
            _log.warning(f"compiled kernels are kept in {folder}: {refused}; {_ADVICE}")
        return folder
    _log.warning(f"compiled kernels are not kept: {refused}; {_ADVICE}")
    return None


def _usual() -> Path:
    named = os.environ.get("NUMBA_CACHE_DIR")
    return Path(named, "abi-visualiser") if named else user_cache() / "kernels"


def _in_temporary_cache() -> Path:
    return temporary_cache() / "kernels"


def is_anything_kept() -> bool:
    """Check whether there is a compiled form of any kernel, which may be of other sources."""
    folder = kernel_folder()
    return READY.exists() or (folder is not None and next(folder.glob("*.nbc"), None) is not None)
