"use strict";
(function () {
  const config = { displaylogo: false, responsive: true, showSendToCloud: false, plotlyServerURL: "", displayModeBar: "hover",
    modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"], toImageButtonOptions: { format: "svg" } };
  function draw(box) {
    if (box.dataset.drawn || typeof Plotly === "undefined") { return; }
    box.dataset.drawn = "1";
    const content = JSON.parse(document.getElementById("data-" + box.dataset.chart).textContent);
    Plotly.newPlot(box, content.data, content.layout, config);
  }
  const boxes = Array.from(document.querySelectorAll(".plot"));
  // Figures are drawn when they come near the window: the page opens at once however many there are.
  const watcher = new IntersectionObserver(function (entries) {
    entries.forEach(function (entry) { if (entry.isIntersecting) { draw(entry.target); watcher.unobserve(entry.target); } });
  }, { rootMargin: "900px 0px" });
  boxes.forEach(function (box) { watcher.observe(box); });
  window.addEventListener("beforeprint", function () { boxes.forEach(draw); });

  document.querySelectorAll(".tabs").forEach(function (tabs) {
    const buttons = Array.from(tabs.querySelectorAll(":scope > .tablist > button"));
    function choose(index) {
      buttons.forEach(function (button, place) { button.setAttribute("aria-selected", String(place === index)); });
      tabs.querySelectorAll(":scope > .tabpanel").forEach(function (panel, place) { panel.hidden = place !== index; });
      tabs.querySelectorAll(":scope > .tabpanel:not([hidden]) .plot").forEach(function (box) {
        draw(box);
        if (typeof Plotly !== "undefined") { Plotly.Plots.resize(box); }
      });
    }
    buttons.forEach(function (button, place) { button.addEventListener("click", function () { choose(place); }); });
  });

  document.querySelectorAll(".gridbox").forEach(function (box) {
    const buttons = Array.from(box.querySelectorAll(".filters button"));
    buttons.forEach(function (button) {
      button.addEventListener("click", function () {
        buttons.forEach(function (other) { other.setAttribute("aria-pressed", String(other === button)); });
        box.querySelectorAll("tr[data-row]").forEach(function (row) {
          row.classList.toggle("off", button.dataset.filter !== "" && row.dataset.row !== button.dataset.filter);
        });
      });
    });
  });

  const links = new Map(Array.from(document.querySelectorAll("nav a")).map(function (a) { return [a.getAttribute("href").slice(1), a]; }));
  const sections = Array.from(document.querySelectorAll("section"));
  function mark() {
    let current = sections[0];
    sections.forEach(function (section) { if (section.getBoundingClientRect().top < window.innerHeight * 0.35) { current = section; } });
    links.forEach(function (link, key) { link.classList.toggle("here", Boolean(current) && key === current.id); });
  }
  window.addEventListener("scroll", mark, { passive: true });
  mark();
})();
