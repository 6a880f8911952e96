"""Records: what a file keeps of the dimensions and variables of a dataset beside their values. They are free attributes of
the file, objects of JSON: axis.t, axis.z, axis.y and axis.x with the name of the dimension and the attributes of its
coordinate, channel.NAME with the attributes of a variable, variable.NAME with a small variable beside the fields, and dataset
with what attributes of the dataset are no texts."""
from __future__ import annotations

import json
from typing import Any, Mapping

import numpy as np

_AXES = ("axis.t", "axis.z", "axis.y", "axis.x")
# Said elsewhere in the file, true of the source's bytes alone, or the names of other variables.
_ELSEWHERE = {"actual_range", "bcc4_error_bound", "_FillValue", "missing_value", "valid_range", "valid_min", "valid_max",
              "scale_factor", "add_offset", "_Unsigned", "coordinates", "bounds", "climatology", "grid_mapping",
              "cell_measures", "ancillary_variables", "formula_terms"}
_OF_TIME = {"units", "calendar"}
# Attributes of the dataset that are no texts.
DATASET = "dataset"


def plain(value: Any) -> Any:
    """Numbers and arrays of numpy as JSON has them; anything else as its text."""
    return value.tolist() if isinstance(value, (np.generic, np.ndarray)) else str(value)


def kept(attrs: Mapping[Any, Any], of_time: bool = False) -> dict[str, Any]:
    """What of the attributes of xarray a record has. Numbers that JSON has not become text."""
    chosen = {str(key): value for key, value in attrs.items() if key not in _ELSEWHERE and not (of_time and key in _OF_TIME)}
    found: dict[str, Any] = json.loads(json.dumps(chosen, default=plain), parse_constant=str)
    return found


def written(record: Mapping[str, Any]) -> str:
    """A record as an attribute of a file."""
    return json.dumps(record, ensure_ascii=False)


def read(attributes: Mapping[str, str], key: str) -> dict[str, Any]:
    """The record of that key in the attributes of a file; empty where there is none."""
    try:
        found = json.loads(attributes.get(key, "{}"))
    except ValueError:
        return {}
    return found if isinstance(found, dict) else {}


def is_there(attributes: Mapping[str, str], key: str) -> bool:
    """Whether the file has that record, which may be empty."""
    return key in attributes


def arrays_of(attrs: Mapping[str, Any]) -> dict[str, Any]:
    """Attributes of a record as xarray has them: lists of numbers are arrays."""
    return {key: np.array(value) if isinstance(value, list) and value and not any(isinstance(one, (str, list, dict)) for one in value)
            else value for key, value in attrs.items()}


def is_record(key: str) -> bool:
    """Whether an attribute of a file is one of these records."""
    return key in _AXES or key == DATASET or key.startswith(("channel.", "variable."))
