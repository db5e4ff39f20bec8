"""Data as the text of a YAML or JSON document, from which it is read again with the same bits."""

import json
from functools import cache
from pathlib import Path
from typing import Any

from runtime.cases.document import with_core_schema, yaml_module

_WIDTH = 100  # layout: characters of a line


def text_of(data: dict[str, Any], path: Path) -> str:
    """The document by the ending of `path`, its keys in their order."""
    if path.suffix.lower() == ".json":
        return json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    written: str = yaml_module(path).dump(
        data, Dumper=_dumper(), sort_keys=False, allow_unicode=True, width=_WIDTH
    )
    return written


@cache
def _dumper() -> Any:
    """A dumper that quotes the texts which YAML's core schema would read as something else."""
    dumper = with_core_schema(yaml_module("YAML").SafeDumper)
    dumper.ignore_aliases = lambda *_: True
    return dumper
