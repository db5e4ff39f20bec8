"""The check of the built site finds the links that lead nowhere."""

import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

import pytest

Check = Callable[[Path], list[str]]
HEAD = "<html><head><link href='_static/site.css?v=1' rel='stylesheet'></head><body>"


@pytest.fixture
def broken_links(root: Path, monkeypatch: pytest.MonkeyPatch) -> Check:
    monkeypatch.syspath_prepend(root / "docs" / "_extensions")
    monkeypatch.delitem(sys.modules, "built_links", raising=False)
    check: Check = import_module("built_links").broken_links
    return check


@pytest.fixture
def site(tmp_path: Path) -> Path:
    (tmp_path / "_static").mkdir()
    (tmp_path / "_static" / "site.css").write_text("")
    (tmp_path / "how-to").mkdir()
    (tmp_path / "how-to" / "two words.html").write_text("<h1 id='a-b'>A b</h1>")
    return tmp_path


def test_links_that_lead_somewhere(site: Path, broken_links: Check) -> None:
    (site / "index.html").write_text(
        f"{HEAD}<h1 id='top'>T</h1><a href='#top'></a><a href='#'></a>"
        "<a href='how-to/two%20words.html#a-b'></a><a href='https://example.org/none#here'></a>"
        "<img src='data:image/png;base64,AAAA'><iframe srcdoc=\"<a href='none.html'>\"></iframe>"
    )
    assert broken_links(site) == []


def test_links_that_lead_nowhere(site: Path, broken_links: Check) -> None:
    (site / "index.html").write_text(
        f"{HEAD}<a href='#bottom'></a><img src='figure.png'><a href='how-to/two%20words.html#c'>"
        "</a><a href='how-to/'></a><script src='_static/none.js'></script>"
    )
    assert broken_links(site) == [
        "index.html links to #bottom: there is no such anchor",
        "index.html links to _static/none.js: there is no such file",
        "index.html links to figure.png: there is no such file",
        "index.html links to how-to/: there is no such file",
        "index.html links to how-to/two%20words.html#c: there is no such anchor",
    ]
