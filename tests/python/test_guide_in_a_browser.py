"""The guide as rendered by mdBook, in a real browser: no errors, no external requests, nothing cut off."""

import shutil
import subprocess

import pytest

import browser

if browser.program() is None:
    pytest.skip("no Chromium here (Debian: apt-get install chromium)", allow_module_level=True)
if not shutil.which("mdbook"):
    pytest.skip("no mdBook here (cargo install mdbook --locked)", allow_module_level=True)

CUT = """[...document.querySelectorAll('main .table-wrapper, main pre, main code')]
    .filter((e) => e.scrollWidth > e.clientWidth + 1 && e.clientWidth > 0).map((e) => e.textContent.slice(0, 80))"""


@pytest.fixture(scope="module")
def guide(root, tmp_path_factory):
    folder = tmp_path_factory.mktemp("guide")
    subprocess.run(["mdbook", "build", root / "book", "--dest-dir", folder], check=True, capture_output=True)
    return folder


@pytest.fixture(scope="module")
def tab(tmp_path_factory):
    with browser.page(tmp_path_factory.mktemp("profile")) as tab:
        tab.size(1400, 900)
        yield tab


def test_every_page_is_whole_and_still(root, guide, tab):
    pages = sorted((root / "book/src").rglob("*.md"))
    assert len(pages) > 10
    for source in pages:
        if source.name == "SUMMARY.md":
            continue
        page = guide / source.relative_to(root / "book/src").with_suffix(".html")
        tab.complaints.clear()
        tab.requests.clear()
        tab.open(page)
        assert tab.complaints == [], page
        assert not [address for address in tab.requests if not address.startswith(("file:", "data:"))], page
        assert tab.evaluate(CUT) == [], page
