// The spring in motion: mount(element, data) draws one moving picture into an element. Data come from views/motion/pack.py.
// The picture is in scene.js, its film in film.js; it loads nothing, evaluates nothing and keeps to the colours of the page around it.
const SLOWNESS = [20, 50, 100, 200, 500, 1000, 2000], USUAL_SLOWNESS = 200;
const THUMB = 16, NARROW = 720;
const STYLE = `
.vtm { --line: rgba(128, 136, 148, .42); --soft: rgba(128, 136, 148, .14); --mark: #c2410c; color: inherit; font: inherit; font-size: 14px; max-width: 976px; }
.vtm[hidden], .vtm [hidden] { display: none; }
.vtm-bar { display: flex; flex-wrap: wrap; gap: 6px 14px; align-items: center; margin: 0 0 8px; }
.vtm label { display: inline-flex; align-items: center; gap: 6px; min-width: 0; }
.vtm button, .vtm select { font: inherit; color: inherit; background: transparent; border: 1px solid var(--line); border-radius: 5px; padding: 4px 10px; cursor: pointer; min-height: 32px; }
.vtm select { max-width: 100%; min-width: 0; }
.vtm select option { color: #1b2430; background: #fff; }
.vtm button:hover { background: var(--soft); }
.vtm :focus-visible { outline: 2px solid #3f7fd6; outline-offset: 2px; }
.vtm-group button { padding: 4px 6px; font-size: 13.5px; }
.vtm .vtm-play { min-width: 60px; font-weight: 600; }
.vtm-stage { display: grid; grid-template-columns: minmax(0, 1.15fr) minmax(0, 1fr); gap: 10px 20px; align-items: start; }
.vtm-narrow .vtm-stage { grid-template-columns: minmax(0, 1fr); }
.vtm-view { position: relative; border: 1px solid var(--line); border-radius: 6px; overflow: hidden; height: 460px; }
.vtm-narrow .vtm-view { height: 340px; }
.vtm-view canvas { display: block; width: 100%; height: 100%; touch-action: pan-y; cursor: grab; }
.vtm-view svg { display: none; width: 100%; height: 100%; }
.vtm-still svg { display: block; }
.vtm-turn { display: flex; flex-wrap: wrap; gap: 4px; margin: 6px 0 0; }
.vtm-turn button { padding: 2px 10px; font-size: 12.5px; min-height: 28px; }
.vtm-group { display: inline-flex; flex-wrap: wrap; gap: 4px; }
.vtm-scale { margin: 6px 0 0; font-size: 12.5px; }
.vtm-scale div { height: 12px; border-radius: 3px; }
.vtm-scale p { display: flex; justify-content: space-between; gap: 12px; margin: 2px 0 0; max-width: none; font-variant-numeric: tabular-nums; }
.vtm-scale strong { font-weight: 550; } .vtm-scale span { white-space: nowrap; }
.vtm-plot svg { display: block; width: 100%; overflow: visible; cursor: crosshair; touch-action: pan-y; }
.vtm-plot text { fill: currentColor; font-size: 12px; }
.vtm-key { display: flex; flex-wrap: wrap; gap: 2px 14px; margin: 0 0 2px; font-size: 12.5px; }
.vtm-key i { display: inline-block; width: 18px; height: 0; border-top: 3px solid; margin-right: 6px; vertical-align: middle; }
.vtm-list { position: relative; list-style: none; margin: 6px 0 0; padding: 0; max-height: 172px; overflow-y: auto; border-top: 1px solid var(--line); }
.vtm-list button { display: flex; gap: 10px; width: 100%; text-align: left; border: 0; border-bottom: 1px solid var(--soft); border-radius: 0; padding: 4px 6px; font-size: 13px; }
.vtm-list b { flex: 0 0 62px; text-align: right; font-weight: 600; font-variant-numeric: tabular-nums; }
.vtm-list [aria-current=true] { background: var(--soft); box-shadow: inset 3px 0 var(--mark); }
.vtm-slide { position: relative; margin: 10px 0 2px; padding-top: 12px; }
.vtm-slide input { width: 100%; margin: 0; display: block; accent-color: #3f7fd6; height: 22px; }
.vtm-slide i { position: absolute; top: 0; width: 2px; height: 11px; margin-left: -1px; background: currentColor; opacity: .55; }
.vtm-slide i.clash { background: var(--mark); opacity: 1; }
.vtm-slide i.peak { width: 0; margin-left: -4px; height: 0; border: 4px solid transparent; border-top: 9px solid currentColor; background: none; opacity: .9; }
.vtm-ends { display: flex; justify-content: space-between; font-size: 12px; opacity: .8; }
.vtm-now { display: block; margin: 2px 0 0; font-variant-numeric: tabular-nums; min-height: 3em; }
.vtm-recorded { display: block; }
.vtm-told { font-size: 13.5px; }
.vtm-told ul { margin: 4px 0 0; padding-left: 18px; }
@media print { .vtm-bar, .vtm-slide, .vtm-turn, .vtm-list, .vtm-view canvas { display: none; } .vtm-view svg { display: block; } }
`;
let styled = false;

function numbers(text, Kind) {
  const raw = atob(text), bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) { bytes[i] = raw.charCodeAt(i); }
  return new Kind(bytes.buffer);
}

function make(tag, options, ...children) {
  const element = document.createElement(tag);
  Object.entries(options || {}).forEach(function ([name, value]) {
    if (name === "text") { element.textContent = value; } else if (name === "class") { element.className = value; } else { element.setAttribute(name, value); }
  });
  element.append(...children);
  return element;
}

function svg(tag, options) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  Object.entries(options || {}).forEach(function ([name, value]) { element.setAttribute(name, value); });
  return element;
}

function number(value) {
  const size = Math.abs(value);
  if (value < 0) { return "\u2212" + number(size); }
  return size === 0 ? "0" : size >= 1000 ? value.toFixed(0) : size >= 100 ? value.toFixed(0) : size >= 10 ? value.toFixed(1) : size >= 0.1 ? value.toFixed(2) : value.toPrecision(2);
}

// Unpacks a variant once; a page with several unpacks those that are looked at.
function unpack(packed) {
  const one = { packed: packed, closed: packed.closed, rpm: packed.rpm, words: packed.words, units: packed.units };
  one.angle = numbers(packed.angle, Float32Array);
  one.lift = numbers(packed.lift, Float32Array);
  one.forces = packed.forces.map(function (force) {
    return { words: force.words, colour: force.colour, angle: numbers(force.angle, Float32Array), values: numbers(force.values, Float32Array) };
  });
  one.springs = packed.springs.map(function (spring) {
    return {
      name: spring.name, sign: spring.sign, seat: spring.seat, direction: spring.direction, coil: numbers(spring.coil, Float32Array),
      radius: numbers(spring.radius, Float32Array), wire: numbers(spring.wire, Float32Array), rest: numbers(spring.rest, Float32Array),
      move: numbers(spring.move.d, Int16Array), scale: spring.move.scale, retainer: numbers(spring.retainer, Float32Array),
      colours: spring.colours.map(function (one) { return Object.assign({}, one, { values: numbers(one.d, Uint8Array) }); }),
    };
  });
  one.bodies = packed.bodies.map(function (body) {
    return {
      name: body.name, colour: body.colour, fixed: body.fixed, pose: numbers(body.pose, Float32Array),
      shapes: body.shapes.map(function (shape) { return { kind: shape.kind, depth: shape.depth, points: numbers(shape.points, Float32Array) }; }),
    };
  });
  one.marks = packed.marks;
  return one;
}

// The two frames around an angle (deg) and the share of the second: straight between frames, exact on them.
function between(one, angle) {
  const known = one.angle, count = known.length;
  let low = 0, high = count;
  while (low < high) { const middle = (low + high) >> 1; if (known[middle] <= angle + 1e-6) { low = middle + 1; } else { high = middle; } }
  const first = low - 1;
  if (first >= 0 && first < count - 1) { return [first, first + 1, Math.max(0, angle - known[first]) / (known[first + 1] - known[first])]; }
  if (!one.closed) { return first < 0 ? [0, 0, 0] : [count - 1, count - 1, 0]; }
  const from = known[count - 1] - (first < 0 ? 360 : 0), to = known[0] + (first < 0 ? 0 : 360);
  return [count - 1, 0, (angle - from) / (to - from)];
}

function niceStep(span, most) {
  const raw = span / most, size = Math.pow(10, Math.floor(Math.log10(raw)));
  return size * [1, 2, 5, 10].find(function (one) { return one * size >= raw; });
}

// Forces over the cam angle with a cursor; a click or a drag goes to an angle.
function makePlot(box, seek) {
  const known = { left: 52, right: 10, top: 8, bottom: 34, height: 230 };
  let shown = null, width = 0, low = 0, high = 1, cursor = null, dots = [], drawing = null;
  function x(angle) { return known.left + (width - known.left - known.right) * angle / 360; }
  function y(value) { return known.top + (known.height - known.top - known.bottom) * (high - value) / (high - low); }
  function draw() {
    if (!shown || !width) { return; }
    box.replaceChildren();
    drawing = svg("svg", { height: known.height, viewBox: "0 0 " + width + " " + known.height, role: "img", "aria-label": "Forces over the cam angle in " + shown.units.force + ", with the moment shown" });
    const step = niceStep(high - low, 5);
    for (let value = Math.ceil(low / step) * step; value <= high + 1e-9; value += step) {
      drawing.append(svg("line", { x1: known.left, x2: width - known.right, y1: y(value), y2: y(value), stroke: "currentColor", "stroke-opacity": Math.abs(value) < 1e-9 ? 0.5 : 0.15 }));
      const label = svg("text", { x: known.left - 6, y: y(value) + 4, "text-anchor": "end" });
      label.textContent = Math.round(value * 1000) / 1000;
      drawing.append(label);
    }
    for (let angle = 0; angle <= 360; angle += width < 340 ? 90 : 60) {
      const label = svg("text", { x: x(angle), y: known.height - known.bottom + 15, "text-anchor": angle === 360 ? "end" : "middle" });
      label.textContent = angle + "°";
      drawing.append(label);
    }
    const below = svg("text", { x: (known.left + width) / 2, y: known.height - 4, "text-anchor": "middle" });
    below.textContent = "cam angle";
    const beside = svg("text", { x: 12, y: known.height / 2 - 10, "text-anchor": "middle", transform: "rotate(-90 12 " + (known.height / 2 - 10) + ")" });
    beside.textContent = "force (" + shown.units.force + ")";
    drawing.append(below, beside);
    shown.marks.forEach(function (mark) {
      if (mark.kind === "clash") { drawing.append(svg("line", { x1: x(mark.angle), x2: x(mark.angle), y1: known.height - known.bottom, y2: known.height - known.bottom - 7, stroke: "#c2410c", "stroke-width": 2 })); }
    });
    shown.forces.forEach(function (force) {
      let path = "";
      for (let i = 0; i < force.angle.length; i++) { path += (i ? "L" : "M") + x(force.angle[i]).toFixed(1) + " " + y(force.values[i]).toFixed(1); }
      drawing.append(svg("path", { d: path, fill: "none", stroke: force.colour, "stroke-width": 1.5, "stroke-linejoin": "round" }));
    });
    cursor = svg("line", { y1: known.top, y2: known.height - known.bottom, stroke: "currentColor", "stroke-width": 1.2, "class": "vtm-cursor" });
    drawing.append(cursor);
    dots = shown.forces.map(function (force) { const dot = svg("circle", { r: 3.5, fill: force.colour }); drawing.append(dot); return dot; });
    box.append(drawing);
    let down = false;
    function go(event) { const frame = drawing.getBoundingClientRect(); seek((event.clientX - frame.left - known.left) / (width - known.left - known.right) * 360); }
    drawing.addEventListener("pointerdown", function (event) { down = true; drawing.setPointerCapture(event.pointerId); go(event); });
    drawing.addEventListener("pointermove", function (event) { if (down) { go(event); } });
    ["pointerup", "pointercancel"].forEach(function (name) { drawing.addEventListener(name, function () { down = false; }); });
  }
  function value(force, angle) {
    const known = force.angle;
    let low = 0, high = known.length;
    while (low < high) { const middle = (low + high) >> 1; if (known[middle] <= angle) { low = middle + 1; } else { high = middle; } }
    const first = Math.max(low - 1, 0), next = Math.min(first + 1, known.length - 1);
    const share = next > first ? Math.min(1, Math.max(0, (angle - known[first]) / (known[next] - known[first]))) : 0;
    return force.values[first] + (force.values[next] - force.values[first]) * share;
  }
  return {
    value: value,
    show: function (one) {
      shown = one; low = 0; high = 1;
      one.forces.forEach(function (force) { force.values.forEach(function (v) { low = Math.min(low, v); high = Math.max(high, v); }); });
      high += 0.05 * (high - low);
      draw();
    },
    size: function () { if (box.clientWidth && box.clientWidth !== width) { width = box.clientWidth; draw(); } },
    move: function (angle) {
      if (!cursor) { return; }
      cursor.setAttribute("x1", x(angle)); cursor.setAttribute("x2", x(angle));
      shown.forces.forEach(function (force, place) { dots[place].setAttribute("cx", x(angle)); dots[place].setAttribute("cy", y(value(force, angle))); });
    },
  };
}

function choice(words, options, chosen, changed) {
  const select = make("select", {});
  options.forEach(function ([value, text]) { const option = make("option", { value: value, text: text }); option.selected = value === chosen; select.append(option); });
  select.addEventListener("change", function () { changed(select.value); });
  return [make("label", {}, make("span", { text: words }), select), select];
}

/**
 * Draw a moving picture into an element, in place of what stands there (a still picture, kept where there is no WebGL).
 * Returns {seek, angle, play, pause, playing, record, variant, colour, statistics, destroy}; angles are cam degrees.
 */
function mount(element, data) {
  if (!styled && "adoptedStyleSheets" in document) {
    const sheet = new CSSStyleSheet();
    sheet.replaceSync(STYLE);
    document.adoptedStyleSheets = document.adoptedStyleSheets.concat([sheet]);
    styled = true;
  }
  const variants = data.variants.map(function () { return null; });
  const still = Array.from(element.childNodes);
  const state = { variant: 0, angle: 0, slow: USUAL_SLOWNESS, playing: false, key: "", frames: 0, drawn: [], apart: [], before: 0, dirty: true, last: 0, film: null };
  let one = null, asked = 0, gone = false;

  const box = make("div", { class: "vtm", role: "group", "aria-label": data.title + ": space plays, arrow keys step by cam angle, page keys go from mark to mark" });
  const bar = make("div", { class: "vtm-bar" }), stage = make("div", { class: "vtm-stage" }), viewBox = make("div", { class: "vtm-view" });
  const left = make("div", {}, viewBox), right = make("div", {}), key = make("div", { class: "vtm-key" }), plotBox = make("div", { class: "vtm-plot" });
  const scale = make("div", { class: "vtm-scale" }), list = make("ol", { class: "vtm-list", "aria-label": "Moments to jump to" });
  const slide = make("div", { class: "vtm-slide" }), now = make("output", { class: "vtm-now", "aria-live": "polite" });
  const slider = make("input", { type: "range", min: "0", max: "360", step: "0.01", value: "0", "aria-label": "cam angle in degrees" });
  const told = make("details", { class: "vtm-told" }, make("summary", { text: "About this drawing" }), make("ul", {}));

  function request() { state.dirty = true; if (!asked && !gone) { asked = requestAnimationFrame(frame); } }
  function seek(angle) { state.angle = Math.max(0, Math.min(360, angle)); request(); }
  function step(by) { pause(); const next = state.angle + by; seek(((by % 1 ? next : Math.round(next)) % 360 + 360) % 360); }
  function jump(way) {
    const marks = one.marks.filter(function (mark) { return way > 0 ? mark.angle > state.angle + 0.005 : mark.angle < state.angle - 0.005; });
    const mark = way > 0 ? marks[0] || one.marks[0] : marks[marks.length - 1] || one.marks[one.marks.length - 1];
    if (mark) { pause(); seek(mark.angle); }
  }
  function play() { state.playing = true; state.last = 0; playButton.textContent = "Pause"; now.setAttribute("aria-live", "off"); request(); }
  function pause() { if (state.film) { state.film.stop(); state.film = null; recordButton.textContent = "Record"; } state.playing = false; playButton.textContent = "Play"; now.setAttribute("aria-live", "polite"); request(); }

  const playButton = make("button", { type: "button", class: "vtm-play", text: "Play" });
  playButton.addEventListener("click", function () { if (state.playing) { pause(); } else { play(); } });
  const recordButton = make("button", { type: "button", text: "Record", title: "One cam turn at this speed, as a film" }), recorded = make("output", { class: "vtm-recorded" });
  recordButton.addEventListener("click", function () { if (state.film) { pause(); } else { record(); } });
  const steps = [[-10, "−10°"], [-1, "−1°"], [1, "+1°"], [10, "+10°"]].map(function ([by, text]) {
    const button = make("button", { type: "button", text: text, "aria-label": "step " + (by > 0 ? "forward " : "back ") + Math.abs(by) + " cam degrees" });
    button.addEventListener("click", function () { step(by); });
    return button;
  });
  const jumps = [[-1, "◀ mark", "previous mark"], [1, "mark ▶", "next mark"]].map(function ([way, text, words]) {
    const button = make("button", { type: "button", text: text, "aria-label": words });
    button.addEventListener("click", function () { jump(way); });
    return button;
  });
  const [slowLabel] = choice("speed", SLOWNESS.map(function (slow) { return [String(slow), "1/" + slow + " of real time"]; }), String(USUAL_SLOWNESS), function (value) { state.slow = Number(value); request(); });
  const [colourLabel, colourSelect] = choice("colour", [], "", function (value) { state.key = value; paint(); request(); });
  const [variantLabel, variantSelect] = choice("run", data.variants.map(function (variant, place) { return [String(place), variant.words]; }), "0", function (value) { choose(Number(value)); });
  variantLabel.hidden = data.variants.length < 2;
  bar.append(variantLabel, colourLabel, slowLabel, make("span", { class: "vtm-group" }, playButton, ...steps, ...jumps, recordButton));
  right.append(key, plotBox, list);
  stage.append(left, right);
  box.append(bar, stage, slide, now, recorded, told);

  const view = makeView(viewBox, request), plot = makePlot(plotBox, function (angle) { pause(); seek(angle); });
  const parts = [], picture = still.find(function (node) { return node.nodeName.toLowerCase() === "svg"; });
  // The still picture is what is printed, and what is seen without WebGL.
  if (picture) { viewBox.append(picture); }
  if (view) {
    const turns = make("div", { class: "vtm-turn" });
    [["⟲", "turn left", function () { view.turn(-0.3, 0); }], ["⟳", "turn right", function () { view.turn(0.3, 0); }], ["+", "zoom in", function () { view.zoom(1.25); }],
      ["−", "zoom out", function () { view.zoom(0.8); }], ["whole", "show the whole", view.whole], ["cam", "look at the cam", function () { view.look(extent(one, function (name) { return name === "cam"; })); }],
      ["valve", "look at spring and valve", function () { view.look(extent(one, function (name) { return /spring|valve|seat|retainer/.test(name); })); }]].forEach(function ([text, words, act]) {
      const button = make("button", { type: "button", text: text, "aria-label": words });
      button.addEventListener("click", act);
      turns.append(button);
    });
    parts.push(...Array.from(turns.children).slice(-2));
    left.append(turns, scale);
  } else {
    viewBox.classList.add("vtm-still");
    left.append(make("p", { text: "This browser shows no WebGL, so the picture stands still; forces and marks move." }));
  }

  recordButton.hidden = !view || !filmType() || !view.canvas.captureStream;

  // One cam turn from the start; it plays once the recorder runs, and a pause ends it.
  function record() {
    pause();
    seek(0);
    const run = one;
    view.move(between(one, 0), state.key, "film");
    view.draw();
    const film = makeFilm(view.canvas, function () { if (state.film === film) { play(); } }, function (file, failure) {
      if (state.film === film) { pause(); }
      if (gone) { return; }
      const name = run.words.toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^-|-$/g, "") + (filmType().includes("mp4") ? ".mp4" : ".webm");
      recorded.textContent = file ? "Saved as " + name + ", " + number(file.size / 1e6) + " MB." : "The browser could not record the film: " + failure + ".";
      if (file) { saveFile(file, name); }
    });
    state.film = film;
    recordButton.textContent = "Stop";
    recorded.textContent = "";
  }

  slider.addEventListener("input", function () { pause(); seek(Number(slider.value)); });
  box.addEventListener("keydown", function (event) {
    const on = event.target.nodeName;
    if (on === "SELECT" || event.ctrlKey || event.altKey || event.metaKey || (view && event.target === view.canvas && event.key !== " ")) { return; }
    const by = event.shiftKey ? 10 : 1;
    const act = { ArrowLeft: function () { step(-by); }, ArrowRight: function () { step(by); }, PageUp: function () { jump(-1); }, PageDown: function () { jump(1); },
      Home: function () { pause(); seek(0); }, End: function () { pause(); seek(360); },
      " ": on === "BUTTON" || on === "SUMMARY" ? null : function () { if (state.playing) { pause(); } else { play(); } } }[event.key];
    if (act) { act(); event.preventDefault(); }
  });

  function colouring() { return one.springs.map(function (spring) { return spring.colours.find(function (each) { return each.key === state.key; }); }).find(Boolean); }

  function paint() {
    const painted = colouring();
    scale.hidden = !painted;
    if (!painted) { return; }
    scale.replaceChildren();
    const strip = make("div", {}), ends = make("p", {});
    strip.style.background = "linear-gradient(to right, " + painted.stops.join(", ") + ")";
    ends.append(make("span", { text: number(painted.low) + " " + painted.unit }), make("strong", { text: painted.words + " (" + painted.unit + ")" }), make("span", { text: number(painted.high) + " " + painted.unit }));
    scale.append(strip, ends);
  }

  function choose(place) {
    if (state.film) { pause(); }
    state.variant = place;
    one = variants[place] = variants[place] || unpack(data.variants[place]);
    const known = [];
    one.springs.forEach(function (spring) { spring.colours.forEach(function (each) { if (!known.some(function (other) { return other.key === each.key; })) { known.push(each); } }); });
    if (!known.some(function (each) { return each.key === state.key; })) { state.key = known.length ? known[0].key : ""; }
    colourSelect.replaceChildren();
    known.forEach(function (each) { const option = make("option", { value: each.key, text: each.key }); option.selected = each.key === state.key; colourSelect.append(option); });
    colourLabel.hidden = !known.length || !view;
    key.replaceChildren();
    one.forces.forEach(function (force) { const line = make("i", {}); line.style.borderTopColor = force.colour; key.append(make("span", {}, line, force.words)); });
    list.replaceChildren();
    slide.replaceChildren(slider, make("div", { class: "vtm-ends" }, make("span", { text: "0°" }), make("span", { text: "180°" }), make("span", { text: "360°" })));
    one.marks.forEach(function (mark) {
      const button = make("button", { type: "button" }, make("b", { text: mark.angle.toFixed(1) + "°" }), make("span", { text: mark.words }));
      button.addEventListener("click", function () { pause(); seek(mark.angle); });
      list.append(make("li", {}, button));
      const tick = make("i", { class: mark.kind, title: mark.angle.toFixed(1) + "° " + mark.words, "aria-hidden": "true" });
      tick.style.left = "calc(" + THUMB / 2 + "px + (100% - " + THUMB + "px) * " + mark.angle / 360 + ")";
      slide.append(tick);
    });
    list.hidden = !one.marks.length;
    jumps.forEach(function (button) { button.disabled = !one.marks.length; });
    const notes = one.packed.notes.concat(data.notes);
    told.hidden = !notes.length;
    told.lastChild.replaceChildren(...notes.map(function (words) { return make("li", { text: words.charAt(0).toUpperCase() + words.slice(1) + (/[.!?]$/.test(words) ? "" : ".") }); }));
    parts.forEach(function (button) { button.hidden = !one.bodies.length; });
    if (view) {
      view.show(one);
      view.canvas.setAttribute("aria-label", (one.bodies.length ? "Train and spring" : "Spring") + " in three dimensions, " + one.words + ". Arrow keys turn it, with shift they move it, plus and minus zoom, 0 shows the whole.");
    }
    plot.show(one);
    paint();
    request();
  }

  function moment() {
    const lift = at(one.lift, between(one, state.angle)).toFixed(3).replace("-", "\u2212");
    return ["cam angle " + state.angle.toFixed(1) + "°", "time " + (120000 / one.rpm * state.angle / 360).toFixed(2) + " ms", "valve lift " + lift + " " + one.units.lift];
  }

  function say() {
    const turn = 120000 / one.rpm, parts = moment();
    one.forces.forEach(function (force) { parts.push(force.words + " " + number(plot.value(force, state.angle)) + " " + one.units.force); });
    now.textContent = parts.join(" · ") + " · 1/" + state.slow + " of real time: a cam turn in " + number(turn * state.slow / 1000) + " s";
    slider.value = String(state.angle);
    slider.setAttribute("aria-valuetext", state.angle.toFixed(1) + " degrees");
    let nearest = null;
    one.marks.forEach(function (mark, which) { if (Math.abs(mark.angle - state.angle) < 0.05) { nearest = which; } });
    Array.from(list.children).forEach(function (row, which) { row.firstChild.setAttribute("aria-current", String(which === nearest)); });
    // The list follows, the page does not.
    if (nearest !== null && nearest !== state.near) { const row = list.children[nearest]; list.scrollTop = row.offsetTop - list.clientHeight / 2 + row.offsetHeight / 2; }
    state.near = nearest;
  }

  function frame(time) {
    asked = 0;
    if (gone || !element.isConnected) { return; }
    if (state.playing) {
      const gap = state.last ? (time - state.last) / 1000 : 0, next = state.angle + (gap < 0.5 ? gap : 0) * one.rpm * 3 / state.slow;  // more: the page was hidden
      state.angle = state.film && next >= 360 ? 360 : next % 360;
      state.last = time; state.dirty = true;
    }
    if (state.dirty) {
      const begun = performance.now();
      state.dirty = false;
      const place = between(one, state.angle);
      if (view) { view.move(place, state.key, state.film ? "film" : state.playing ? "play" : "rest"); view.draw(); }
      plot.move(state.angle);
      say();
      if (state.film) {
        state.film.take(colouring(), [one.words + ", 1/" + state.slow + " of real time", moment().join(" · ")]);
        if (state.angle === 360) { pause(); }
      }
      state.frames += 1;
      state.drawn.push(performance.now() - begun);
      if (state.drawn.length > 240) { state.drawn.shift(); }
      if (state.playing && state.before) { state.apart.push(time - state.before); if (state.apart.length > 240) { state.apart.shift(); } }
      state.before = state.playing ? time : 0;
    }
    if (state.playing && !asked) { asked = requestAnimationFrame(frame); }
  }

  element.replaceChildren(box);
  choose(0);
  state.angle = data.variants[0].start;
  // Printed is the still picture of the first run, at its moment.
  function forPrint() { if (state.variant === 0) { pause(); state.angle = data.variants[0].start; frame(0); } }
  window.addEventListener("beforeprint", forPrint);
  function fit() {
    box.classList.toggle("vtm-narrow", box.clientWidth < NARROW);
    plot.size();
    request();
  }
  const watch = new ResizeObserver(fit);
  watch.observe(box);
  fit();
  const handle = {
    seek: seek, angle: function () { return state.angle; }, play: play, pause: pause, playing: function () { return state.playing; }, record: record,
    variant: function (place) { if (place !== undefined) { choose(place); variantSelect.value = String(place); } return state.variant; },
    colour: function (name) { if (name !== undefined) { state.key = name; colourSelect.value = name; paint(); request(); } return state.key; },
    webgl: Boolean(view),
    statistics: function () {
      function middle(values) { return values.length ? values.slice().sort(function (a, b) { return a - b; })[values.length >> 1] : NaN; }
      return { frames: state.frames, drawing: middle(state.drawn), interval: middle(state.apart), counted: state.apart.length };
    },
    destroy: function () { gone = true; pause(); watch.disconnect(); window.removeEventListener("beforeprint", forPrint); cancelAnimationFrame(asked); if (view) { view.destroy(); } element.replaceChildren(...still); delete element.motion; },
  };
  element.motion = handle;
  return handle;
}

globalThis.valvetrainMotion = { mount: mount };
