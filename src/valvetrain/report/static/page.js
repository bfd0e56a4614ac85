"use strict";
// Draws the figures of a page or of a part of it. A report wires itself; a page that changes calls valvetrainFigures.wire(part).
const valvetrainFigures = (function () {
  const config = { displaylogo: false, responsive: true, showSendToCloud: false, plotlyServerURL: "", displayModeBar: "hover",
    modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"], toImageButtonOptions: { format: "svg" } };
  // Below this width (px) panels stand in one column; plotly_chart.py lays the two-column form out for no less.
  const NARROW = 700;
  const figures = new Map();
  function isNarrow(box) {
    // A figure behind a tab has no width yet; its section has.
    return (box.clientWidth || (box.closest("section") || document.body).clientWidth) < NARROW;
  }
  function layoutOf(box, content) {
    const layout = isNarrow(box) ? content.narrow : content.layout;
    box.style.height = layout.height + "px";
    return layout;
  }
  // The content of a figure, JSON text, drawn into a box; a box that is drawn already changes in place.
  function show(box, text) {
    const content = JSON.parse(text);
    if (content.gap) { box.textContent = content.gap; box.className = "gap"; box.style.height = "auto"; return; }
    const again = figures.has(box);
    figures.set(box, { content: content, narrow: isNarrow(box) });
    Plotly[again ? "react" : "newPlot"](box, content.data, layoutOf(box, content), config);
  }
  function draw(box) {
    if (box.dataset.drawn || typeof Plotly === "undefined") { return; }
    const source = document.getElementById("data-" + box.dataset.chart);
    if (!source) { return; }
    box.dataset.drawn = "1";
    show(box, source.textContent);
  }
  // A page that grows or shrinks past the limit changes between one column and several; boxes that are gone are forgotten.
  function refit() {
    figures.forEach(function (known, box) {
      if (!box.isConnected) { figures.delete(box); return; }
      if (known.narrow !== isNarrow(box)) {
        known.narrow = isNarrow(box);
        Plotly.react(box, known.content.data, layoutOf(box, known.content), config);
      }
    });
  }
  window.addEventListener("resize", refit);
  // Figures are drawn when they come near the window: the page opens at once however many there are.
  const watcher = new IntersectionObserver(function (entries) {
    entries.forEach(function (entry) { if (entry.isIntersecting) { draw(entry.target); watcher.unobserve(entry.target); } });
  }, { rootMargin: "900px 0px" });
  // Paper has nothing to click: what is folded is opened for it and closed again.
  window.addEventListener("beforeprint", function () {
    document.querySelectorAll("details:not([open])").forEach(function (part) { part.dataset.folded = "1"; part.open = true; });
  });
  window.addEventListener("afterprint", function () {
    document.querySelectorAll("details[data-folded]").forEach(function (part) { delete part.dataset.folded; part.open = false; });
  });
  window.addEventListener("beforeprint", function () { document.querySelectorAll(".plot[data-chart]").forEach(draw); });

  // Moving pictures are mounted when they come near, as figures are drawn.
  const moving = new IntersectionObserver(function (entries) {
    entries.forEach(function (entry) {
      if (!entry.isIntersecting) { return; }
      moving.unobserve(entry.target);
      const box = entry.target, source = document.getElementById("motion-" + box.dataset.motion);
      if (source && typeof valvetrainMotion !== "undefined") { box.mounted = valvetrainMotion.mount(box, JSON.parse(source.textContent)); }
    });
  }, { rootMargin: "600px 0px" });

  // Data of a figure as text: two columns a line, seven digits; words that a spreadsheet would take for a formula are disarmed.
  function readable(words) {
    return '"' + (/^[=+\-@\t\r]/.test(words) ? "'" : "") + words.replace(/"/g, '""') + '"';
  }
  const KINDS = { f4: Float32Array, f8: Float64Array, i4: Int32Array, i2: Int16Array, i1: Int8Array, u1: Uint8Array, u2: Uint16Array, u4: Uint32Array };
  function listed(form) {
    if (!form || !form.bdata) { return Array.from(form || []).flat(); }
    const raw = atob(form.bdata), bytes = new Uint8Array(raw.length);
    for (let place = 0; place < raw.length; place += 1) { bytes[place] = raw.charCodeAt(place); }
    return Array.from(new KINDS[form.dtype](bytes.buffer), function (value) { return Number(value.toPrecision(7)); });
  }
  function columnsOf(content) {
    const columns = [];
    content.data.forEach(function (trace) {
      const x = listed(trace.x), y = listed(trace.y), z = listed(trace.z);
      if (!trace.z) { columns.push([trace.meta[0], x], [trace.meta[1], y]); return; }
      columns.push([trace.meta[0], z.map(function (_, place) { return x[place % x.length]; })]);
      columns.push([trace.meta[1], z.map(function (_, place) { return y[Math.floor(place / x.length)]; })], [trace.meta[2], z]);
    });
    return columns;
  }
  function asText(content) {
    const columns = columnsOf(content), rows = Math.max(...columns.map(function (column) { return column[1].length; }));
    const lines = [columns.map(function (column) { return readable(column[0]); }).join(",")];
    for (let row = 0; row < rows; row += 1) {
      lines.push(columns.map(function (column) { return row < column[1].length && !Number.isNaN(column[1][row]) ? column[1][row] : ""; }).join(","));
    }
    return lines.join("\r\n") + "\r\n";
  }
  function wireTables(root) {
    root.querySelectorAll("figcaption button[data-csv]").forEach(function (button) {
      button.hidden = false;
      button.addEventListener("click", function () {
        const content = JSON.parse(document.getElementById("data-" + button.dataset.csv).textContent);
        const link = document.createElement("a");
        link.href = URL.createObjectURL(new Blob(["\ufeff" + asText(content)], { type: "text/csv" }));
        link.download = button.dataset.csv + ".csv";
        link.click();
        setTimeout(function () { URL.revokeObjectURL(link.href); }, 1000);
      });
    });
  }

  function wireLegends(root) {
    root.querySelectorAll(".legend button").forEach(function (button) {
      button.addEventListener("click", function () {
        const shown = button.getAttribute("aria-pressed") !== "true";
        button.setAttribute("aria-pressed", String(shown));
        const box = button.closest("figure").querySelector(".plot");
        draw(box);
        // "stock, not settled" goes with "stock", but not where the key names it.
        const names = Array.from(button.parentElement.children, function (one) { return new Option(one.dataset.name).innerHTML; });
        const escaped = new Option(button.dataset.name).innerHTML;
        const places = box.data.map(function (trace, place) {
          const fits = trace.name === escaped || (!names.includes(trace.name) && trace.name.startsWith(escaped + ", "));
          return fits ? place : -1;
        }).filter(function (place) { return place >= 0; });
        Plotly.restyle(box, { visible: shown }, places);
      });
    });
  }
  function wireTabs(root) {
    root.querySelectorAll(".tabs").forEach(function (tabs) {
      const buttons = Array.from(tabs.querySelectorAll(":scope > .tablist > button"));
      function choose(index) {
        buttons.forEach(function (button, place) { button.setAttribute("aria-selected", String(place === index)); });
        tabs.querySelectorAll(":scope > .tabpanel").forEach(function (panel, place) { panel.hidden = place !== index; });
        tabs.querySelectorAll(":scope > .tabpanel:not([hidden]) .plot").forEach(function (box) {
          draw(box);
          if (typeof Plotly !== "undefined" && figures.has(box)) { Plotly.Plots.resize(box); }
        });
      }
      buttons.forEach(function (button, place) { button.addEventListener("click", function () { choose(place); }); });
    });
  }
  function wireFilters(root) {
    root.querySelectorAll(".gridbox").forEach(function (box) {
      const groups = Array.from(box.querySelectorAll(".filters"));
      groups.forEach(function (group) {
        const buttons = Array.from(group.querySelectorAll("button"));
        buttons.forEach(function (button) {
          button.addEventListener("click", function () {
            buttons.forEach(function (other) { other.setAttribute("aria-pressed", String(other === button)); });
            const wanted = groups.map(function (one) { return [one.dataset.place, one.querySelector("[aria-pressed=true]").dataset.filter]; });
            box.querySelectorAll("tr[data-row]").forEach(function (row) {
              const fits = wanted.every(function (pair) { return pair[1] === "" || row.getAttribute("data-word-" + pair[0]) === pair[1]; });
              row.classList.toggle("off", !fits);
            });
          });
        });
      });
    });
  }
  // Also for figures whose data came later than they did.
  function watch(root) {
    root.querySelectorAll(".plot[data-chart]:not([data-drawn])").forEach(function (box) { watcher.unobserve(box); watcher.observe(box); });
    root.querySelectorAll("[data-motion]").forEach(function (box) { if (!box.motion) { moving.unobserve(box); moving.observe(box); } });
  }
  function wire(root) {
    wireLegends(root);
    wireTabs(root);
    wireFilters(root);
    wireTables(root);
    watch(root);
    root.querySelectorAll("details:not(.part)").forEach(function (part) {
      part.addEventListener("toggle", function () { part.querySelectorAll(".plot").forEach(function (box) { if (part.open) { draw(box); } }); });
    });
  }
  return { wire: wire, watch: watch, show: show, draw: draw };
})();
(function () {
  if (document.documentElement.dataset.workbench !== undefined) { return; }
  // On a phone the sections are a list that a touch opens; verdict and picture stay. A link opens what it leads to.
  const narrow = window.matchMedia("screen and (max-width: 900px)"), folds = document.querySelectorAll("details.part");
  function opened(id) {
    const aim = id && document.getElementById(id);
    if (!aim) { return; }
    const within = aim.querySelector(":scope > details.part");
    for (let part = within || aim; part; part = part.parentElement) { if (part.tagName === "DETAILS") { part.open = true; } }
    aim.scrollIntoView();
  }
  function fold() { folds.forEach(function (part) { part.open = !narrow.matches; }); }
  fold();
  narrow.addEventListener("change", fold);
  window.addEventListener("hashchange", function () { opened(decodeURIComponent(location.hash.slice(1))); });
  valvetrainFigures.wire(document);
  opened(decodeURIComponent(location.hash.slice(1)));
  const links = new Map(Array.from(document.querySelectorAll("nav a")).map(function (a) { return [a.getAttribute("href").slice(1), a]; }));
  const sections = Array.from(document.querySelectorAll("section, details.computed")).filter(function (part) { return links.has(part.id); });
  links.forEach(function (link, key) {
    link.addEventListener("click", function () { opened(key); });
  });
  function mark() {
    let current = sections[0];
    sections.forEach(function (section) { if (section.getBoundingClientRect().top < window.innerHeight * 0.35) { current = section; } });
    links.forEach(function (link, key) { link.classList.toggle("here", Boolean(current) && key === current.id); });
  }
  window.addEventListener("scroll", mark, { passive: true });
  mark();
})();
