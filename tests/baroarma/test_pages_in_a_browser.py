"""Pages as a reader has them: in a browser, on a telephone, a desk and paper, zoomed, and under attack."""

import json
import re
import shutil
from dataclasses import replace

import numpy as np
import pytest

import baroarma as ba
from baroarma.atmosphere import altitude_pressure
from baroarma.comparison_report import comparison_section, write_comparison_report
from baroarma.experiments import Result, Row
from baroarma.experiments.report import write_report
from baroarma.experiments.scene import Scene
from baroarma.page import Page, write_page
from baroarma.report import identification_section, write_identification_report
from baroarma.simulation import BMP085, simulate, simulate_rest
from baroarma.zoomable import STEPS_Y

playwright = pytest.importorskip("playwright.sync_api", reason="needs the extra `browser`")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no chromium on this machine")

EVIL = '"><script>alert(1)</script><img src=x onerror=alert(1)>]]></text><svg onload=alert(1)>'
NAMES = ("one", "several", "refused", "compare", "compare-without-reference", "experiment", "demo")
PHONE, DESK = 375, 1280


@pytest.fixture(scope="module")
def browser():
    with playwright.sync_playwright() as tools:
        yield tools.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])


@pytest.fixture(scope="module")
def found():
    return ba.identify(replace(simulate_rest(240, seed=1), name=EVIL))


@pytest.fixture(scope="module")
def folder(found, tmp_path_factory):
    folder = tmp_path_factory.mktemp("pages")
    t = np.arange(3000) / 50
    rising = altitude_pressure(0.4 * t + np.random.default_rng(1).normal(size=3000))
    refused = ba.identify(ba.Recording(t=t, pressure=rising, name=EVIL))
    write_identification_report([found], folder / "one.html")
    write_identification_report([found, refused], folder / "several.html")
    write_identification_report([refused], folder / "refused.html")
    squats = replace(simulate("squat", duration=30, seed=1), name=EVIL)
    alone = replace(squats, reference=None, reference_velocity=None)
    for name, ride in (("compare", squats), ("compare-without-reference", alone)):
        bake_off = ba.compare(ride, presets=("sg14-a", "sg14-b", "baroarma"), noise=BMP085.noise)
        write_comparison_report([bake_off], folder / f"{name}.html")
    scene = Scene(EVIL, EVIL, EVIL, EVIL, t, {EVIL: np.sin(t)}, reference=np.cos(t))
    row = Row(EVIL, EVIL, 0.4, 0.15, 0.38, 0.08, 10, f"differs: {EVIL}")
    write_report([Result(EVIL, EVIL, (EVIL,), (row,), (EVIL,))], {EVIL: [scene]}, folder / "experiment.html")
    parts = identification_section(found, "At rest", "rest"), comparison_section(bake_off, "squat")
    write_page(folder / "demo.html", Page("demo", parts))  # as `baroarma demo` does with longer recordings
    return folder


@pytest.fixture
def visit(browser, folder):
    """Open a page; whatever it complains about, asks for or says aloud fails the test at its end."""
    contexts, troubles = [], []

    def open_page(name, width=DESK, **options):
        contexts.append(browser.new_context(viewport={"width": width, "height": 800}, **options))
        page = contexts[-1].new_page()
        address = (folder / f"{name}.html").as_uri()
        page.on("console", lambda m: troubles.append(m.text) if m.type in ("error", "warning") else None)
        page.on("pageerror", lambda error: troubles.append(str(error)))
        page.on("dialog", lambda dialog: (troubles.append(dialog.message), dialog.dismiss()))
        page.on("request", lambda r: None if r.url == address else troubles.append(r.url))
        page.goto(address)
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert troubles == []


def drag(page, figure, start=(0.4, 0.4), end=(0.6, 0.6)):
    """Drag the mouse between two places of a figure's axes, given as parts of them."""
    figure.scroll_into_view_if_needed()
    box = json.loads(figure.get_attribute("data-view"))["box"]
    (x, y), (u, v) = (on_screen(figure, box, *place) for place in (start, end))
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(u, v, steps=3)
    page.mouse.up()


def on_screen(figure, box, along, up):
    """Where on the screen a part of the axes is, from the left and from the top."""
    svg = figure.locator("svg")
    frame, view = svg.bounding_box(), [float(v) for v in svg.get_attribute("viewBox").split()]
    scale = frame["width"] / view[2]
    return frame["x"] + scale * (box[0] + along * box[2]), frame["y"] + scale * (box[1] + up * box[3])


def shown(figure):
    return json.loads(figure.get_attribute("data-shown"))


def vertices(figure, curve=0):
    """The corners of a drawn curve, in units of the drawing."""
    d = figure.locator(f"[data-curve='{curve}'] path").first.get_attribute("d")
    return np.array(re.findall(r"[ML]\s*(\S+) ([^\sML]+)", d), dtype=float)


@pytest.mark.parametrize("width", [PHONE, DESK])
@pytest.mark.parametrize("name", NAMES)
def test_a_page_fits_its_window_and_nothing_lies_on_something_else(visit, name, width):
    page = visit(name, width)
    wide, small, empty, over = page.evaluate(LOOK)
    assert wide <= width
    assert small >= 14
    assert empty == []
    assert over == []


LOOK = """() => {
    const all = [...document.querySelectorAll("body *")], box = (e) => e.getBoundingClientRect();
    const says = (e) => [...e.childNodes].some((n) => n.nodeType === 3 && n.data.trim());
    const outside = all.filter((e) => says(e) && !e.closest("svg, script"));
    const sizes = outside.map((e) => parseFloat(getComputedStyle(e).fontSize));
    const flat = all.filter((e) => e.tagName === "svg" && !(box(e).width > 50 && box(e).height > 50));
    const of = "h1, h2, h3, main p, nav, .scroll, figure svg, figcaption, .zoom, pre";
    const parts = [...document.querySelectorAll(of)].map((e) => [e, box(e)]);
    const meet = ([a, p], [b, q]) => !a.contains(b) && !b.contains(a) && p.left < q.right - 1
        && q.left < p.right - 1 && p.top < q.bottom - 1 && q.top < p.bottom - 1;
    const over = parts.flatMap((a, i) => parts.slice(i + 1).filter((b) => meet(a, b)).map((b) => [a, b]));
    const start = ([e]) => e.outerHTML.slice(0, 80);
    return [document.documentElement.scrollWidth, Math.min(...sizes), flat.map((e) => start([e])),
        over.map((pair) => pair.map(start))];
}"""


@pytest.mark.parametrize("name", NAMES)
def test_no_script_of_the_data_is_there_or_could_run(visit, name):
    page = visit(name)
    assert page.locator("script").count() == 1
    assert page.locator("img, iframe, object, link, [onload], [onerror]").count() == 0
    assert page.locator("svg svg").count() == 0
    assert EVIL[:20] in page.locator("body").inner_text()


def test_the_browser_refuses_a_script_that_is_not_ours(browser, folder):
    page = browser.new_page()
    page.goto((folder / "refused.html").as_uri())
    page.evaluate("""() => { const s = document.createElement("script"); s.textContent = "window.ran = 1";
        document.body.append(s); }""")
    assert page.evaluate("window.ran") is None
    page.close()


@pytest.mark.parametrize("name", NAMES)
def test_a_drag_zooms_and_a_double_click_shows_all_again(visit, name):
    page = visit(name)
    figures = page.locator("figure[data-view]")
    assert figures.count() > 0
    for figure in figures.all():
        before, drawn = shown(figure), figure.locator("svg").inner_html()
        drag(page, figure)
        for axis in "xy":
            (lo, hi), (a, b) = before[axis], shown(figure)[axis]
            assert lo < a < b < hi
        figure.locator("svg").dblclick(position={"x": 150, "y": 120})
        page.mouse.move(0, 0)
        page.wait_for_function("(f) => !f.classList.contains('zoomed')", arg=figure.element_handle())
        assert shown(figure) == before
        assert figure.locator("svg").inner_html() == drawn


def test_zoomed_in_one_sees_the_samples_themselves(visit, found):
    page = visit("one")
    figure = page.locator("figure[data-view]").first
    assert len(vertices(figure)) < 1500
    drag(page, figure, (0.5, 0.5), (0.53, 0.5))
    low, high = shown(figure)["x"]
    recording = found.recording
    inside = (recording.t > low) & (recording.t < high)
    height = recording.height() - np.median(recording.height())
    page.wait_for_function(
        "(f) => !f.querySelector('[data-curve] path').hasAttribute('transform')", arg=figure.element_handle()
    )
    drawn = vertices(figure)
    assert 200 < inside.sum() <= len(drawn) <= inside.sum() + 3  # with a neighbour on each side
    left, top, width, tall = json.loads(figure.get_attribute("data-view"))["box"]
    bottom, roof = shown(figure)["y"]
    sample = np.rint((low + (drawn[:, 0] - left) / width * (high - low)) * 50).astype(int)
    seen = roof - (drawn[:, 1] - top) / tall * (roof - bottom)
    rounding = (0.005 / tall + 0.5 / STEPS_Y) * (roof - bottom)  # of the path's two decimals, and of the code
    assert (np.diff(sample) == 1).all()
    assert np.abs(seen - height[sample]).max() < rounding + 1e-9


def test_the_pointer_reads_values_off_the_axes(visit):
    page = visit("one")
    figure = page.locator("figure[data-view]").first
    figure.scroll_into_view_if_needed()
    view = json.loads(figure.get_attribute("data-view"))
    page.mouse.move(*on_screen(figure, view["box"], 0.25, 0.5))
    low, high = view["x"]["limits"]
    said = figure.locator("output").text_content()
    name, value, unit = re.match(r"(\w+) (\S+) (\w+),", said).groups()
    pixel = (high - low) / 250  # the axes are at least so many pixels wide
    assert (name, unit) == ("time", "s")
    assert float(value) == pytest.approx(low + (high - low) / 4, abs=pixel)


def test_the_wheel_zooms_with_control_only(visit):
    page = visit("one")
    figure = page.locator("figure[data-view]").first
    figure.scroll_into_view_if_needed()
    before, scrolled = shown(figure), page.evaluate("scrollY")
    box = json.loads(figure.get_attribute("data-view"))["box"]
    page.mouse.move(*on_screen(figure, box, 0.5, 0.5))
    page.mouse.wheel(0, 120)
    page.wait_for_function("(y) => scrollY > y", arg=scrolled)
    assert shown(figure) == before
    page.mouse.move(*on_screen(figure, box, 0.5, 0.5))
    page.keyboard.down("Control")
    page.mouse.wheel(0, -120)
    page.keyboard.up("Control")
    page.wait_for_function("(f) => f.classList.contains('zoomed')", arg=figure.element_handle())
    assert shown(figure)["y"] == before["y"]


def test_the_keyboard_zooms_moves_and_shows_all(visit):
    page = visit("one")
    figure = page.locator("figure[data-view]").first
    (low, high), buttons = shown(figure)["x"], figure.locator("button")
    assert [b.is_enabled() for b in buttons.all()] == [True, False, False, False, False]
    buttons.nth(0).focus()
    page.keyboard.press("Enter")
    quarter = (high - low) / 4
    assert shown(figure)["x"] == pytest.approx([low + quarter, high - quarter])
    buttons.nth(3).press("Space")
    assert shown(figure)["x"] == pytest.approx([low + 1.5 * quarter, high - 0.5 * quarter])
    buttons.nth(4).press("Enter")
    assert shown(figure)["x"] == [low, high]


def test_two_fingers_zoom_and_one_still_scrolls_the_page(visit):
    page = visit("one", PHONE, has_touch=True, is_mobile=True)
    figure = page.locator("figure[data-view]").first
    figure.scroll_into_view_if_needed()
    box, before = json.loads(figure.get_attribute("data-view"))["box"], shown(figure)
    tools = page.context.new_cdp_session(page)

    def touch(kind, *places):
        fingers = [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(places)]
        tools.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": fingers})

    places = [on_screen(figure, box, along, 0.5) for along in (0.4, 0.6, 0.3, 0.7)]
    touch("touchStart", *places[:2])
    touch("touchMove", *places[2:])
    touch("touchEnd")
    (low, high), (a, b) = before["x"], shown(figure)["x"]
    assert b - a == pytest.approx((high - low) / 2, rel=0.01)  # fingers twice as far apart
    assert (a + b) / 2 == pytest.approx((low + high) / 2, abs=0.01 * (high - low))
    scrolled = page.evaluate("scrollY")
    x, y = on_screen(figure, box, 0.5, 0.8)
    touch("touchStart", (x, y))
    for way in range(10, 160, 10):
        touch("touchMove", (x, y - way))
    touch("touchEnd")
    page.wait_for_function("(y) => scrollY > y + 100", arg=scrolled)
    assert shown(figure)["x"] == [a, b]


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_stands_out_from_the_paper_in_the_readers_scheme(visit, scheme):
    page = visit("several", color_scheme=scheme)
    paper = luminance(page.evaluate("getComputedStyle(document.body).backgroundColor"))
    assert (paper < 0.1) == (scheme == "dark")
    for what in ("p", "a", "caption", "figcaption", "thead th", "svg text", "li.error b", ".zoom output"):
        style = "(e) => getComputedStyle(e)." + ("fill" if "svg" in what else "color")
        ink = luminance(page.locator(what).first.evaluate(style))
        low, high = sorted((ink, paper))
        assert (high + 0.05) / (low + 0.05) >= 4.5, what  # WCAG 2.2, 1.4.3


def luminance(colour):
    """Relative luminance of an "rgb(r, g, b)", as WCAG 2.2 defines it."""
    parts = np.array(re.findall(r"[\d.]+", colour)[:3], dtype=float) / 255
    linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    return float(linear @ (0.2126, 0.7152, 0.0722))


@pytest.mark.parametrize(("name", "most"), [("one", 4), ("compare", 2), ("experiment", 2), ("demo", 6)])
def test_a_page_prints_whole_on_a_few_sheets(visit, name, most):
    page = visit(name)
    sheets = page.pdf(format="A4", prefer_css_page_size=True)
    assert 1 <= len(re.findall(rb"/Type\s*/Page\b", sheets)) <= most
    page.emulate_media(media="print")
    page.set_viewport_size({"width": 680, "height": 1000})  # A4 less its margins, at 96 dots an inch
    assert page.evaluate("document.documentElement.scrollWidth") <= 680
    assert not page.locator(".zoom, nav").and_(page.locator(":visible")).count()
    assert page.locator("figure").first.evaluate("(e) => getComputedStyle(e).breakInside") == "avoid"
    heights = [figure.bounding_box()["height"] for figure in page.locator("figure").all()]
    assert max(heights) < 1000


def test_ticks_of_the_zoomed_view_are_round_and_apart(visit):
    page = visit("demo")
    for figure in page.locator("figure[data-view]").all():
        drag(page, figure, (0.3, 0.3), (0.5, 0.45))
        texts = figure.locator("svg > g text.x, svg > g text.y")
        boxes = [text.bounding_box() for text in texts.all()]
        for axis in "xy":
            words = figure.locator(f"svg > g text.{axis}").all_text_contents()
            values = [float(word.replace("\u2212", "-")) for word in words]
            low, high = shown(figure)[axis]
            assert len(values) >= 2
            assert all(low <= v <= high for v in values)
            assert all(len(word) < 8 for word in words)
        assert not [1 for i, a in enumerate(boxes) for b in boxes[i + 1 :] if meet(a, b)]


def meet(a, b):
    """Whether two boxes share a point."""
    sides = (("x", "width"), ("y", "height"))
    return all(a[k] < b[k] + b[size] and b[k] < a[k] + a[size] for k, size in sides)
