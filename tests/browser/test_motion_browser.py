"""The moving picture in a real browser: it draws, steps and jumps, asks nothing of the network, and
stands still where it must.
"""

from __future__ import annotations

import base64
import io
import json
from dataclasses import replace

import numpy as np
import pytest

from synthetic_study import own_study, rod_run
from system_parts import program
from valvetrain.parameters.loading import load_case
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.views.answer import Answer
from valvetrain.views.motion.project import motion_data
from valvetrain.views.motion.scene import moving_picture
from valvetrain.views.page import motion_script, page_of

playwright = pytest.importorskip("playwright.sync_api")
pytestmark = pytest.mark.chromium

#: No file, no frame, no style element, no attribute of style, no evaluation: only the script that
#: bears the number.
STRICT = (
    "default-src 'none'; script-src 'nonce-7'; style-src 'none'; connect-src 'none'; img-src 'none'"
)
MOUNT = """<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>t</title>
<meta http-equiv="Content-Security-Policy" content="POLICY">
<script nonce="7">window.refused = [];
document.addEventListener("securitypolicyviolation", (event) => refused.push(event.violatedDirective));</script>
<script nonce="7">SCRIPT</script></head><body><div id="place"></div>
<script nonce="7">valvetrainMotion.mount(document.getElementById("place"), DATA);</script></body></html>"""
#: Where ``capture`` is set, the vertices of the wire as the graphics card placed and coloured them.
CARD = """
const card = WebGL2RenderingContext.prototype, link = card.linkProgram, draw = card.drawElements;
card.linkProgram = function (program) {
  this.transformFeedbackVaryings(program, ["gl_Position", "base"], this.SEPARATE_ATTRIBS);
  link.call(this, program);
};
card.drawElements = function (...words) {
  draw.apply(this, words);
  if (!window.capture || this.getVertexAttrib(0, this.VERTEX_ATTRIB_ARRAY_SIZE) !== 4) { return; }
  this.bindBuffer(this.ARRAY_BUFFER, this.getVertexAttrib(0, this.VERTEX_ATTRIB_ARRAY_BUFFER_BINDING));
  const count = this.getBufferParameter(this.ARRAY_BUFFER, this.BUFFER_SIZE) / 16, program = this.getParameter(this.CURRENT_PROGRAM);
  const wanted = [4, 3].map((size) => new Float32Array(size * count)), buffers = wanted.map((values, place) => {
    const buffer = this.createBuffer();
    this.bindBufferBase(this.TRANSFORM_FEEDBACK_BUFFER, place, buffer);
    this.bufferData(this.TRANSFORM_FEEDBACK_BUFFER, values, this.STREAM_READ);
    return buffer;
  });
  this.enable(this.RASTERIZER_DISCARD);
  this.beginTransformFeedback(this.POINTS); this.drawArrays(this.POINTS, 0, count); this.endTransformFeedback();
  this.disable(this.RASTERIZER_DISCARD);
  buffers.forEach((buffer, place) => {
    this.bindBufferBase(this.TRANSFORM_FEEDBACK_BUFFER, place, null);
    this.bindBuffer(this.COPY_READ_BUFFER, buffer); this.getBufferSubData(this.COPY_READ_BUFFER, 0, wanted[place]);
    this.deleteBuffer(buffer);
  });
  window.captured = { positions: Array.from(wanted[0]), colours: Array.from(wanted[1]) };
  ["axes", "middle", "scale"].forEach((name) => { captured[name] = Array.from(this.getUniform(program, this.getUniformLocation(program, name))); });
};
"""
HANDLE = "document.querySelector('.vtm').parentElement.motion"
TWO_FRAMES = "() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"


@pytest.fixture(scope="module")
def study():
    base = own_study((rod_run(),))
    return replace(
        base, record=replace(base.record, text=load_case("gu2021-beehive-blind").record().text)
    )


@pytest.fixture(scope="module")
def browser():
    path = program("chromium")
    assert path
    with playwright.sync_playwright() as driver:
        options = ["--no-sandbox", "--enable-unsafe-swiftshader"]
        found = driver.chromium.launch(executable_path=path, args=options)
        yield found
        found.close()


class Visit:
    """A page that was opened, and everything it said or asked for."""

    def __init__(self, browser, html, folder, width=1000, **more):
        file = folder / "page.html"
        file.write_text(html, encoding="utf-8")
        before = more.pop("before", "")
        self.context = browser.new_context(
            viewport={"width": width, "height": 900}, offline=True, **more
        )
        self.page = self.context.new_page()
        if before:
            self.page.add_init_script(before)
        self.said, self.asked = [], []
        # Reading the picture back is slow without a graphics card, which the browser says by
        # itself.
        self.page.on(
            "console",
            lambda message: (
                self.said.append(message.text) if "GPU stall" not in message.text else None
            ),
        )
        self.page.on("pageerror", lambda error: self.said.append(str(error)))
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.goto(file.as_uri())

    def handle(self, words):
        return self.page.evaluate(f"() => {HANDLE}.{words}")

    def settle(self):
        self.page.evaluate(TWO_FRAMES)

    def wire(self, degrees):
        """Rings (ring, 16, 3) of the wire at a cam angle, in mm, and their colours."""
        self.page.evaluate("window.capture = true")
        self.handle(f"seek({degrees!r})")
        self.settle()
        found = {
            name: np.array(values) for name, values in self.page.evaluate("() => captured").items()
        }
        self.page.evaluate("window.capture = false")
        seen = found["positions"].reshape(-1, 4)[:-2, :3] / found["scale"]
        points = found["middle"] + seen @ found["axes"].reshape(3, 3)
        colours = found["colours"].reshape(-1, 3)[:-2]
        return points.reshape(-1, 16, 3), colours.reshape(-1, 16, 3)


@pytest.fixture(scope="module")
def strict_page(study):
    html = (
        MOUNT.replace("POLICY", STRICT)
        .replace("DATA", json.dumps(motion_data(moving_picture(study))))
        .replace("SCRIPT", motion_script())
    )
    return html


@pytest.fixture(scope="module")
def visit(browser, strict_page, tmp_path_factory):
    found = Visit(browser, strict_page, tmp_path_factory.mktemp("motion"), before=CARD)
    yield found
    assert found.said == [] and found.page.evaluate("refused") == []
    assert [url for url in found.asked if not url.startswith(("file:", "data:"))] == [] and len(
        found.asked
    ) == 1
    found.context.close()


def ink(page) -> float:
    """Share of the pixels of the picture that are not its paper."""
    from PIL import Image

    shot = np.asarray(
        Image.open(io.BytesIO(page.locator(".vtm canvas").screenshot())).convert("RGB")
    ).astype(int)
    return float(np.mean(np.abs(shot - shot[4, 4]).sum(axis=2) > 30))


def test_it_draws_under_a_strict_policy_without_network(visit):
    visit.settle()
    assert visit.handle("webgl") is True
    assert 0.05 < ink(visit.page) < 0.9


def test_nodes_on_the_screen_are_those_of_the_solution(visit, study):
    """The middle of every ring that stands on a node, as the graphics card got it, against the
    channel.
    """
    cycle = reported_cycle(study.solutions[0])
    wire = load_case("gu2021-beehive-blind").springs[0].wire
    coil = np.arange(0, 7.25, 0.5)
    for sample in (0, 347, 500):
        points, _ = visit.wire(float(np.degrees(cycle.cam_angle[sample])))
        rings = points.mean(axis=1)
        nodes = rings[:: (len(rings) - 1) // 14]
        # At the ground ends the wire is cut by seat and retainer, so its middle moves.
        inner, line = slice(3, 12), 1e3 * wire.centreline(coil)
        wanted = np.column_stack(
            [line[:, 0], 1e3 * cycle.channel("axial_position")[sample], -line[:, 1]]
        )
        np.testing.assert_allclose(nodes[inner], wanted[inner], atol=1e-3)
        # Between them the tube winds as the wire does, and not the other way round; the radius goes
        # straight from node to node.
        between = np.linspace(0, 7, len(rings))[30:-30]
        whole = 1e3 * wire.centreline(between)
        np.testing.assert_allclose(
            rings[30:-30, [0, 2]], np.column_stack([whole[:, 0], -whole[:, 1]]), atol=0.2
        )
        # Sections are square to the wire.
        off, along = points[30:-30] - rings[30:-30, None], rings[31:-29] - rings[29:-31]
        lean = np.einsum("rkc,rc->rk", off, along) / np.linalg.norm(along, axis=1)[:, None]
        assert np.abs(lean).max() < 0.03 * np.linalg.norm(off, axis=2).min()


#: Duration, width, height and pictures (as bytes of RGBA) of a film at shares of its duration.
WATCH = """async ([address, shares]) => {
  const video = document.createElement("video"), event = (name) => new Promise((done) => video.addEventListener(name, done, { once: true }));
  video.muted = true; video.src = address;
  await event("loadeddata");
  const pen = new OffscreenCanvas(video.videoWidth, video.videoHeight).getContext("2d"), pictures = [];
  for (const share of shares) {
    const there = event("seeked");
    video.currentTime = share * video.duration;
    await there;
    pen.drawImage(video, 0, 0);
    pictures.push(btoa(Array.from(pen.getImageData(0, 0, video.videoWidth, video.videoHeight).data, (part) => String.fromCharCode(part)).join("")));
  }
  return [video.duration, video.videoWidth, video.videoHeight, pictures];
}"""


def test_a_film_is_recorded_that_plays(visit, study, tmp_path):
    """One cam turn at a hundredth of real time: its length, white paper with a spring that moves,
    and the ends of the colour scale.
    """
    page = visit.page
    page.get_by_label("speed").select_option("100")
    visit.handle("colour('stress')")
    with page.expect_download() as download:
        page.get_by_role("button", name="Record").click()
    file = tmp_path / download.value.suggested_filename
    download.value.save_as(file)
    kind = file.suffix.lstrip(".")
    assert kind in ("mp4", "webm") and file.stem == "finite-element-5600-rpm"
    assert visit.handle("playing()") is False and file.name in page.locator(".vtm").inner_text()
    watch = visit.context.new_page()
    address = f"data:video/{kind};base64,{base64.b64encode(file.read_bytes()).decode()}"
    duration, width, height, pictures = watch.evaluate(WATCH, [address, [0.05, 0.4, 0.6, 0.95]])
    watch.close()
    assert duration == pytest.approx(100 * 120 / 5600, abs=0.6)
    seen = [
        np.frombuffer(base64.b64decode(one), dtype=np.uint8)
        .reshape(height, width, 4)[:, :, :3]
        .astype(int)
        for one in pictures
    ]
    box = page.locator(".vtm canvas").bounding_box()
    part = height / (box["height"] + 76)
    stops = moving_picture(study).variants[0].springs[0].colourings[0].stops
    for picture in seen:
        assert picture[4, 4].min() > 240
        drawn = picture[: int(part * box["height"])]
        assert 0.05 < np.mean(np.abs(drawn - drawn[4, 4]).sum(axis=2) > 30) < 0.9
        bar = picture[int(part * (box["height"] + 6))]
        for x, stop in ((14, stops[0]), (width / part - 14, stops[-1])):
            wanted = [int(stop[place : place + 2], 16) for place in (1, 3, 5)]
            np.testing.assert_allclose(bar[int(part * x)], wanted, atol=30)
    assert np.abs(seen[1] - seen[2]).mean() > 0.5


@pytest.fixture(scope="module")
def report(study):
    return page_of(Answer(study))


def opened(*given, **more) -> Visit:
    """A visit of the report whose fold with the moving picture is open."""
    visit = Visit(*given, **more)
    visit.page.wait_for_selector("body[data-ready]")
    visit.page.locator("#in-motion summary").click()
    return visit


@pytest.mark.parametrize("width", [1400, 390])
def test_the_report_mounts_it_and_nothing_scrolls_sideways(browser, report, tmp_path, width):
    visit = opened(browser, report, tmp_path, width)
    visit.page.wait_for_selector(".vtm canvas")
    visit.settle()
    assert visit.page.evaluate("document.documentElement.scrollWidth - window.innerWidth") <= 0
    assert ink(visit.page) > 0.04 and visit.said == [] and len(visit.asked) == 1
    visit.context.close()


def test_without_webgl_the_forces_move(browser, report, tmp_path):
    visit = opened(
        browser,
        report,
        tmp_path,
        before="HTMLCanvasElement.prototype.getContext = function () { return null; };",
    )
    visit.page.wait_for_selector(".vtm")
    assert "no WebGL" in visit.page.locator(".vtm").inner_text()
    visit.handle("seek(42)")
    visit.settle()
    assert visit.said == []
    visit.context.close()


def test_nothing_serious_is_wrong_for_screen_readers(browser, report, tmp_path):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright")
    visit = opened(browser, report, tmp_path, 390)
    visit.page.wait_for_selector(".vtm canvas")
    found = axe.Axe().run(visit.page).response["violations"]
    assert [one["id"] for one in found if one["impact"] in ("serious", "critical")] == []
    visit.context.close()
