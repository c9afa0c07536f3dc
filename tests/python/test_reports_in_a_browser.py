"""Both HTML reports in a real browser: rendered, without errors and requests, readable, complete on screen and on paper."""

import io
import re

import pytest

import browser

image = pytest.importorskip("PIL.Image")

if browser.program() is None:
    pytest.skip("no Chromium here (Debian: apt-get install chromium)", allow_module_level=True)

SCREEN, WIDE, PAPER = (1100, 800, "screen"), (1400, 900, "screen"), (680, 960, "print")
PHONE = (390, 844, "screen")

# Every text with its colour and background colour, as sRGB bytes, with its size in px and whether it is bold.
TEXTS = """
(() => {
  const found = [];
  const bytes = (text) => (text.match(/[\\d.]+/g) || []).map(Number);
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const text = walker.currentNode.textContent.trim();
    const element = walker.currentNode.parentElement;
    if (!text || element.closest('style, script, title, desc')) continue;
    const style = getComputedStyle(element);
    const inDrawing = element.closest('svg') !== null;
    let behind = [255, 255, 255];
    for (let e = element; e && !inDrawing; e = e.parentElement) {
      const b = bytes(getComputedStyle(e).backgroundColor);
      if (b.length === 3 || b[3] > 0) { behind = b; break; }
    }
    found.push([text, bytes(inDrawing ? style.fill : style.color).slice(0, 3), behind.slice(0, 3)]);
  }
  return found;
})()
"""
# Elements that exceed their box or the page.
CUT = """
(() => [...document.querySelectorAll('body, body *:not(svg *)')]
    .filter((e) => e.scrollWidth > e.clientWidth + 1 && e.clientWidth > 0 && getComputedStyle(e).display !== 'inline')
    .map((e) => `${e.tagName}.${e.className} ${e.scrollWidth} > ${e.clientWidth}: ${e.textContent.slice(0, 80)}`))()
"""
# Texts that extend beyond their drawing.
OUTSIDE = """
(() => [...document.querySelectorAll('svg')].flatMap((drawing) => {
  const box = drawing.getBoundingClientRect();
  return [...drawing.querySelectorAll('text')].filter((text) => {
    const b = text.getBoundingClientRect();
    return b.left < box.left - 1 || b.right > box.right + 1 || b.top < box.top - 1 || b.bottom > box.bottom + 1;
  }).map((text) => text.textContent);
}))()
"""
DRAWINGS = "[...document.querySelectorAll('svg')].map((e) => { const b = e.getBoundingClientRect();"
DRAWINGS += " return {x: b.x + scrollX, y: b.y + scrollY, width: b.width, height: b.height,"
DRAWINGS += " texts: [...e.querySelectorAll('text')].map((t) => t.textContent.trim())}; })"
UNITS = r", (10⁻?[²³⁴⁵⁶⁷⁸⁹] ?)?(s|ms|mbar|bar|bar/s|Pa|Pa/s|Pa/√Hz|Hz|K|K/s|mm|m|m/s|%|W|mg/s|1|W/\(m² ?K\))?$"
# Axis texts without a unit: names, ratios.
NO_UNIT = r"^(predicted τ / measured τ|experiment and actuator, .*|c(_i)? .*)$"


@pytest.fixture(scope="module")
def tab(tmp_path_factory):
    with browser.page(tmp_path_factory.mktemp("profile")) as tab:
        yield tab


@pytest.fixture(scope="module", params=["reproduce", "diagnose"])
def report(request, pneutherm, root, tmp_path_factory):
    """Path of the report."""
    folder = tmp_path_factory.mktemp(request.param)
    if request.param == "reproduce":
        pneutherm("reproduce", "-o", folder)
    else:
        pneutherm("diagnose", root / "examples/cylinder", "--report", folder / "report.html")
    return folder / "report.html"


@pytest.fixture
def shown(tab, report):
    """The tab with the report on a screen."""
    tab.complaints.clear()
    tab.requests.clear()
    tab.size(*SCREEN)
    tab.open(report)
    return tab


def test_the_browser_notices_what_is_wrong(tab, tmp_path):
    """Ensures that silence in the tests below is meaningful."""
    page = tmp_path / "bad.html"
    page.write_text("<title>x</title><img src='absent.png'><script>console.error('one'); throw Error('two')</script>")
    tab.complaints.clear()
    tab.open(page)
    said = str(tab.complaints)
    assert "one" in said and "two" in said and "ERR_FILE_NOT_FOUND" in said


def test_nothing_is_complained_about_and_nothing_else_is_loaded(shown, report):
    shown.evaluate("document.fonts.ready.then(() => true)")
    assert shown.complaints == []
    assert shown.requests == [report.resolve().as_uri()]


def test_the_page_and_each_of_its_drawings_are_not_blank(shown):
    picture = image.open(io.BytesIO(shown.screenshot())).convert("RGB")
    assert picture.height > 1500 and len(picture.getcolors(1 << 24)) > 200
    drawings = shown.evaluate(DRAWINGS)
    assert len(drawings) >= 4
    for drawing in drawings:
        corner = (drawing["x"], drawing["y"])
        box = [*corner, corner[0] + drawing["width"], corner[1] + drawing["height"]]
        colours = picture.crop([round(edge) for edge in box]).getcolors(1 << 24)
        whitest = max(count for count, colour in colours if min(colour) > 240)
        total = sum(count for count, _ in colours)
        vivid = sum(count for count, colour in colours if max(colour) - min(colour) > 60)
        assert len(colours) > 30 and whitest < 0.99 * total and vivid > 50, drawing["texts"]


def luminance(colour):
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in (v / 255 for v in colour)]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one, other):
    """Contrast ratio of WCAG 2.2."""
    light, dark = sorted((luminance(one), luminance(other)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def test_every_text_stands_out_from_what_is_behind_it(shown):
    texts = shown.evaluate(TEXTS)
    assert len(texts) > 100
    pale = {(text, *map(tuple, (colour, behind))) for text, colour, behind in texts if contrast(colour, behind) < 4.5}
    assert not pale, sorted(pale)[:10]


def test_it_is_light_whatever_the_reader_prefers(shown):
    shown.call("Emulation.setEmulatedMedia", media="screen", features=[{"name": "prefers-color-scheme", "value": "dark"}])
    corner = image.open(io.BytesIO(shown.screenshot())).convert("RGB").getpixel((2, 2))
    assert corner == (255, 255, 255)


@pytest.mark.parametrize("view", [SCREEN, WIDE, PAPER], ids=["screen", "wide", "paper"])
def test_nothing_is_cut_off(shown, view):
    shown.size(*view)
    assert shown.evaluate(CUT) == [] and shown.evaluate(OUTSIDE) == []


def test_a_phone_shows_it_whole_and_large_enough_to_read(shown):
    shown.size(*PHONE)
    assert shown.evaluate("document.documentElement.scrollWidth") <= PHONE[0]
    # Content wider than the screen scrolls in its own frame.
    assert [e for e in shown.evaluate(CUT) if not e.startswith(("DIV.scroll", "DIV.wide"))] == []
    heights = shown.evaluate("[...document.querySelectorAll('svg text')].filter((t) => t.textContent.length > 3)"
                             ".map((t) => t.getBoundingClientRect())"
                             ".map((b) => Math.min(b.width, b.height))")
    assert min(heights) >= 8


def test_every_axis_names_its_unit(shown):
    for drawing in shown.evaluate(DRAWINGS):
        described = [t for t in drawing["texts"] if re.search(UNITS, t) or re.search(NO_UNIT, t)]
        assert len(described) >= 2, drawing["texts"]


def test_it_prints_on_several_pages(shown):
    shown.size(*PAPER)
    pdf = shown.pdf()
    assert pdf.startswith(b"%PDF") and 3 <= len(re.findall(rb"/Type\s*/Page\b", pdf)) <= 10


PAIRS = """
(() => [...document.querySelectorAll('.charts')].filter((e) => e.children.length > 1).map((e) => {
  const [one, other] = [...e.children].map((c) => c.getBoundingClientRect());
  return Math.abs(one.top - other.top) < 2 && one.right <= other.left + 1;
}))()
"""


def test_paper_has_two_charts_side_by_side(shown):
    """One above the other, each would take half of a separate sheet and leave the rest blank."""
    shown.size(*PAPER)
    assert all(shown.evaluate(PAIRS))
    texts = shown.evaluate("[...document.querySelectorAll('.charts svg text')].filter((t) => t.textContent.length > 3)"
                           ".map((t) => t.getBoundingClientRect()).map((b) => Math.min(b.width, b.height))")
    assert min(texts, default=9) >= 8
