"use strict";
// Plotting code and data are packed: the browser unpacks them. A figure is drawn when its section opens.
(function () {
  const narrow = window.matchMedia("(max-width: 860px)");
  const config = { displaylogo: false, responsive: true, showSendToCloud: false, plotlyServerURL: "", displayModeBar: "hover",
    modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"], toImageButtonOptions: { format: "svg" } };
  async function unpacked(id) {
    const text = atob(document.getElementById(id).textContent), bytes = Uint8Array.from(text, function (char) { return char.charCodeAt(0); });
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
  }
  function layoutOf(content) { return Object.assign({ autosize: true }, narrow.matches ? content.narrow : content.layout); }
  function start(data) {
    function show(root) {
      root.querySelectorAll(".plot[data-chart]:not([data-drawn])").forEach(function (box) {
        const content = data["data-" + box.dataset.chart];
        box.dataset.drawn = "1";
        Plotly.newPlot(box, content.data, layoutOf(content), config);
      });
      root.querySelectorAll("[data-motion]").forEach(function (box) {
        if (!box.motion) { box.mounted = valvetrainMotion.mount(box, data["motion-" + box.dataset.motion]); }
      });
    }
    narrow.addEventListener("change", function () {
      document.querySelectorAll(".plot[data-drawn]").forEach(function (box) {
        const content = data["data-" + box.dataset.chart];
        Plotly.react(box, content.data, layoutOf(content), config);
      });
    });
    const folds = Array.from(document.querySelectorAll("details"));
    folds.forEach(function (part) { part.addEventListener("toggle", function () { if (part.open) { show(part); } }); });
    show(document.getElementById("opening"));
    folds.filter(function (part) { return part.open; }).forEach(show);
    const aim = location.hash && document.getElementById(decodeURIComponent(location.hash.slice(1)));
    const within = aim && (aim.querySelector("details") || aim.closest("details"));
    if (within) { within.open = true; aim.scrollIntoView(); }
    document.body.dataset.ready = "1";
  }
  async function begin() {
    const code = document.createElement("script");
    code.textContent = await unpacked("plotly");
    document.head.append(code);
    start(JSON.parse(await unpacked("data")));
  }
  begin();
})();
