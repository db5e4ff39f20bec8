"""Signatures of result files: whether the user of this machine saved a file, or somebody else.

A file of results tells where its model file lies, and has checkpoints for compiled code. Both are
taken from files alone that bear the signature of this user: HMAC-SHA256 of the content under a key
that never leaves the user's own folder, as Jupyter signs notebooks.
"""

import hmac
import os
import secrets
import sys
import tempfile
from contextlib import suppress
from pathlib import Path

_BYTES = 32  # safety: length of a key, as long as the digest


def signature(content: bytes) -> str:
    """The signature of a content in hexadecimal; empty where no key can be kept."""
    key = _key(create=True)
    return "" if key is None else hmac.digest(key, content, "sha256").hex()


def is_own(content: bytes, signed: str) -> bool:
    """Whether this user signed the content, on this machine."""
    key = _key(create=False)
    if key is None:
        return False
    return hmac.compare_digest(hmac.digest(key, content, "sha256").hex().encode(), signed.encode())


def key_file() -> Path:
    """The file of the user's key; RuntimeError where the user has no home."""
    if sys.platform == "win32" and (local := os.environ.get("LOCALAPPDATA")):
        data = Path(local)
    else:
        given = os.environ.get("XDG_DATA_HOME", "")
        data = Path(given) if Path(given).is_absolute() else Path.home() / ".local" / "share"
    return data / "linkwright" / "signing_key"


def key_problem() -> str:
    """Why no file can be known as this user's own; empty where one can."""
    try:
        place = key_file()
        _make_key(place)
        length = len(place.read_bytes())
    except (OSError, RuntimeError) as error:
        return f"no key can be kept in the user's folder ({error})"
    return "" if length == _BYTES else f"{place} is damaged: it has {length} bytes. Delete it"


def _key(*, create: bool) -> bytes | None:
    """The user's key, made where there is none yet; None where it cannot be kept."""
    try:
        place = key_file()
        if create:
            _make_key(place)
        key = place.read_bytes()
    except (OSError, RuntimeError):
        return None
    return key if len(key) == _BYTES else None


def _make_key(place: Path) -> None:
    """Make the key where there is none; that of another process holds."""
    if place.exists():
        return
    place.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    number, name = tempfile.mkstemp(dir=place.parent)  # readable by the user alone
    try:
        with os.fdopen(number, "wb") as file:
            file.write(secrets.token_bytes(_BYTES))
        try:
            with suppress(FileExistsError):
                os.link(name, place)
        except OSError:  # a file system without hard links
            Path(name).rename(place)
    finally:
        Path(name).unlink(missing_ok=True)
