"use strict";
// Draws figures and moving pictures of an answer, whose data are packed: the browser unpacks them. A figure is drawn when its fold opens.
const valvetrainFigures = (function () {
  const narrow = window.matchMedia("(max-width: 860px)");
  const config = { displaylogo: false, responsive: true, displayModeBar: "hover",
    modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"], toImageButtonOptions: { format: "svg" } };
  async function unpacked(text) {
    const bytes = Uint8Array.from(atob(text), function (char) { return char.charCodeAt(0); });
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
  }
  // Draws a figure, or changes one that is drawn.
  function draw(box, content) {
    box.content = content;
    return Plotly.react(box, content.data, Object.assign({ autosize: true }, narrow.matches ? content.narrow : content.layout), config);
  }
  narrow.addEventListener("change", function () {
    document.querySelectorAll(".plot").forEach(function (box) { if (box.content) { draw(box, box.content); } });
  });
  function show(root, data) {
    root.querySelectorAll(".plot[data-chart]").forEach(function (box) {
      const content = data["data-" + box.dataset.chart];
      if (content && !box.content) { draw(box, content); }
    });
    root.querySelectorAll("[data-motion]").forEach(function (box) {
      if (!box.mounted) { box.mounted = valvetrainMotion.mount(box, data["motion-" + box.dataset.motion]); }
    });
  }
  // Draws what is seen of an answer, and the rest when its folds open.
  async function begin(root, text) {
    const data = JSON.parse(await unpacked(text));
    root.querySelectorAll("details").forEach(function (part) {
      part.addEventListener("toggle", function () { if (part.open) { show(part, data); } });
    });
    root.querySelectorAll("section[aria-label=answer], details[open]").forEach(function (part) { show(part, data); });
  }
  return { unpacked, draw, begin };
})();
(async function () {
  const packed = function (id) { return document.getElementById(id)?.textContent; };
  if (!packed("plotly")) { return; }
  const code = document.createElement("script");
  code.textContent = await valvetrainFigures.unpacked(packed("plotly"));
  document.head.append(code);
  await valvetrainFigures.begin(document, packed("data"));
  const aim = location.hash && document.getElementById(decodeURIComponent(location.hash.slice(1)));
  const within = aim && (aim.querySelector("details") || aim.closest("details"));
  if (within) { within.open = true; aim.scrollIntoView(); }
  document.body.dataset.ready = "1";
})();
