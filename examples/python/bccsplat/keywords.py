"""Keywords that functions hand on. Each function names its own, so that mypy finds one that is misspelt."""
from __future__ import annotations

from typing import Any


def given(**values: Any) -> dict[str, Any]:
    """Those that are not None."""
    return {key: value for key, value in values.items() if value is not None}
