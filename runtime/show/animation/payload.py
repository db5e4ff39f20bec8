"""Numbers and texts of a page as one block: a header in JSON and arrays, compressed, as base64.

The block is gzip of: four bytes, the length of the header, little-endian; the header, UTF-8; and
all arrays one after another as float32 in four planes, first the lowest byte of every number, the
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


class Arrays:
    """The arrays of a page, which the header names by their numbers."""

    def __init__(self) -> None:
        self._parts: list[npt.NDArray[np.float32]] = []

    def add(self, values: npt.ArrayLike, *, rounded: bool = False) -> int:
        """Number of a new array, which has the values as float32, those of curves `rounded`."""
        part = np.asarray(values, dtype=np.float64).astype(np.float32).ravel()
        if rounded:
            bits = part.view(np.uint32)
            half = np.uint32(1 << (_DROPPED - 1))
            mask = np.uint32(0xFFFFFFFF ^ ((1 << _DROPPED) - 1))
            kept = ((bits + half) & mask).view(np.float32)
            part = np.where(np.isfinite(part) & np.isfinite(kept), kept, part)
        self._parts.append(part)
        return len(self._parts) - 1

    def add_exactly(self, values: npt.ArrayLike) -> tuple[int, int]:
        """Numbers of two arrays whose sum has the values to 48 bits."""
        whole = np.asarray(values, dtype=np.float64)
        high = whole.astype(np.float32)
        return self.add(high), self.add(whole - high)

    @property
    def lengths(self) -> list[int]:
        """Lengths of the arrays, in their order."""
        return [len(part) for part in self._parts]

    def planes(self) -> bytes:
        """All arrays, byte by byte."""
        joined = np.concatenate([*self._parts, np.empty(0, np.float32)]).astype("<f4")
        return joined.view(np.uint8).reshape(-1, 4).T.tobytes()


def block(header: dict[str, Any], arrays: Arrays) -> str:
    """The block as base64."""
    words = {**header, "arrays": arrays.lengths}
    text = json.dumps(words, ensure_ascii=False, separators=(",", ":"), allow_nan=False).encode()
    return compressed(len(text).to_bytes(4, "little") + text + arrays.planes())


def compressed(data: bytes) -> str:
    """Bytes as gzip and base64; the same bytes give the same text."""
    return base64.b64encode(gzip.compress(data, _LEVEL, mtime=0)).decode("ascii")
