"""What a page of the player carries."""

import base64
import gzip
import json
import re
from typing import Any


def header_of(text: str) -> dict[str, Any]:
    """The header of the data that a page carries."""
    found = re.search(r'<script type="text/plain" id="data">([^<]*)<', text)
    assert found is not None
    data = gzip.decompress(base64.b64decode(found[1]))
    size = int.from_bytes(data[:4], "little")
    return dict(json.loads(data[4 : 4 + size])["header"])
