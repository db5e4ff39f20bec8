"""Writes the JSON schemas of the files that Linkwright reads, from the code that reads them.

python docs/make_schemas.py [--check]
"""

import json
import sys
from pathlib import Path

from runtime.cases.fields import schema

FOLDER = Path(__file__).resolve().parent / "schema"
SCHEMAS = {"case.schema.json": schema}


def text_of(name: str) -> str:
    """The text of a schema."""
    return json.dumps(SCHEMAS[name](), indent=2, ensure_ascii=False) + "\n"


def main() -> int:
    """Write the schemas, or with --check say which are stale; the exit status."""
    stale = []
    for name in SCHEMAS:
        path, text = FOLDER / name, text_of(name)
        if path.is_file() and path.read_text(encoding="utf-8") == text:
            continue
        stale.append(path)
        if "--check" not in sys.argv:
            FOLDER.mkdir(exist_ok=True)
            path.write_text(text, encoding="utf-8")
    for path in stale if "--check" in sys.argv else ():
        print(f"stale: {path}; run: make build")
    return int(bool(stale) and "--check" in sys.argv)


if __name__ == "__main__":
    sys.exit(main())
