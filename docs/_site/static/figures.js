// Turns the pictures of gallery figures into interactive figures. Without scripts the pictures stay.
(() => {
  const base = document.currentScript.src.replace(/figures\.js.*$/, "");
  const SERIES = ["#1f5aa6", "#d9772b", "#16877a", "#7a4fa0", "#7b8794", "#a33b53", "#8c6d1f", "#3c7d3f", "#4b5aa8"];
  const colours = () => document.documentElement.dataset.theme === "dark"
    ? { ink: "#d8dee6", grid: "#39424d", rule: "#5d6875" }
    : { ink: "#1b2430", grid: "#e9edf1", rule: "#c9d0d9" };

  function look(layout, narrow) {
    const { ink, grid, rule } = colours();
    const shown = { ...layout, autosize: true, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)" };
    shown.font = { ...layout.font, color: ink, size: narrow ? 11 : 13 };
    delete shown.width;
    for (const key of Object.keys(shown)) {
      if (/^[xy]axis\d*$/.test(key)) {
        shown[key] = { ...shown[key], gridcolor: grid, linecolor: rule, color: ink, automargin: true };
      }
    }
    shown.colorway = layout.colorway || SERIES;
    shown.modebar = { bgcolor: "rgba(0,0,0,0)", color: rule, activecolor: ink };
    shown.title = narrow ? undefined : layout.title;
    shown.margin = { l: 60, r: 16, t: narrow ? 16 : 48, b: 50 };
    shown.legend = { orientation: "h", y: -0.18, yanchor: "top", x: 0 };
    return shown;
  }

  function draw(figure) {
    const data = JSON.parse(figure.querySelector(".figure-data").textContent);
    const place = document.createElement("div");
    place.className = "figure-place";
    figure.append(place);
    const narrow = figure.clientWidth < 500;
    place.style.height = `${data.layout.height || (narrow ? 360 : 460)}px`;
    const options = { responsive: true, displaylogo: false, modeBarButtons: [["zoom2d", "pan2d", "resetScale2d", "toImage"]] };
    window.Plotly.newPlot(place, data.data, look(data.layout, narrow), options).then(() => {
      figure.querySelector("img").hidden = true;
      new MutationObserver(() => window.Plotly.react(place, data.data, look(data.layout, narrow), options))
        .observe(document.documentElement, { attributeFilter: ["data-theme"] });
    });
  }

  document.addEventListener("DOMContentLoaded", () => {
    const figures = [...document.querySelectorAll(".gallery-figure")];
    if (!figures.length) return;
    const script = document.createElement("script");
    script.src = `${base}plotly.min.js`;
    script.onload = () => figures.forEach(draw);
    document.head.append(script);
  });
})();
