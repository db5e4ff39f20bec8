"""Numbers and texts of a page as one block: a header in JSON and arrays, compressed, as base64.

The block is gzip of: four bytes, the length of the JSON, little-endian; the JSON, UTF-8, with the
header, in which ``{"array": number}`` stands for an array, and the lengths of the arrays; and all
arrays one after another as float32 in four planes, first the lowest byte of every number, the
highest last. Neighbouring numbers share their high bytes, so that planes compress well.
"""

import base64
import gzip
import json
from typing import Any

import numpy as np
import numpy.typing as npt

_LEVEL = 9  # layout: of compression
_DROPPED = 8  # accuracy: low bits of a mantissa of 24 that curves leave out, 1.5e-5 of a value
FloatArray = npt.NDArray[np.float64]


def rounded(values: FloatArray) -> npt.NDArray[np.float32]:
    """The values with fewer digits, as curves have them."""
    part = values.astype(np.float32)
    half = np.uint32(1 << (_DROPPED - 1))
    mask = np.uint32(0xFFFFFFFF ^ ((1 << _DROPPED) - 1))
    kept = ((part.view(np.uint32) + half) & mask).view(np.float32)
    return np.where(np.isfinite(part) & np.isfinite(kept), kept, part)


def in_two(values: FloatArray) -> list[FloatArray]:
    """Two arrays whose sum has the values to 48 bits."""
    high = values.astype(np.float32).astype(np.float64)
    return [high, values - high]


def block(header: dict[str, Any]) -> str:
    """The block as base64. Complex numbers of the header are pairs x, y there, also in arrays."""
    parts: list[npt.NDArray[np.float32]] = []

    def plain(value: Any) -> Any:
        if isinstance(value, complex):
            return [value.real, value.imag]
        if isinstance(value, np.generic):
            return value.item()
        if np.iscomplexobj(value):
            value = np.stack([value.real, value.imag], axis=-1)
        parts.append(np.asarray(value, dtype=np.float64).ravel().astype("<f4"))
        return {"array": len(parts) - 1}

    options: dict[str, Any] = {"ensure_ascii": False, "separators": (",", ":"), "allow_nan": False}
    text = json.dumps(header, default=plain, **options)
    text = f'{{"header":{text},"arrays":{[len(part) for part in parts]}}}'
    encoded = text.encode()
    planes = np.concatenate([*parts, np.empty(0, "<f4")]).view(np.uint8).reshape(-1, 4).T
    return compressed(len(encoded).to_bytes(4, "little") + encoded + planes.tobytes())


def compressed(data: bytes) -> str:
    """Bytes as gzip and base64; the same bytes give the same text."""
    return base64.b64encode(gzip.compress(data, _LEVEL, mtime=0)).decode("ascii")
