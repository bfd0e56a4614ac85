// The spring in motion: mount(element, data) draws one moving picture into an element. Data come from report/motion/pack.py.
// Everything it needs is here or in THREE; it loads nothing, evaluates nothing and keeps to the colours of the page around it.
const SLOWNESS = [20, 50, 100, 200, 500, 1000, 2000], USUAL_SLOWNESS = 200;
const AROUND = 16, RINGS_PER_TURN = 24, MOST_PIXELS = 1.5, THUMB = 16, NARROW = 720;
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

function hex(colour) { return [1, 3, 5].map(function (place) { return parseInt(colour.slice(place, place + 2), 16) / 255; }); }

// 256 colours between the stops; lit surfaces want them linear.
function ladder(stops) {
  const ends = stops.map(hex), table = new Float32Array(768);
  for (let i = 0; i < 256; i++) {
    const place = i / 255 * (ends.length - 1), low = Math.min(Math.floor(place), ends.length - 2), share = place - low;
    for (let c = 0; c < 3; c++) {
      const value = ends[low][c] + (ends[low + 1][c] - ends[low][c]) * share;
      table[3 * i + c] = value <= 0.04045 ? value / 12.92 : Math.pow((value + 0.055) / 1.055, 2.4);
    }
  }
  return table;
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
      colours: spring.colours.map(function (one) { return Object.assign({}, one, { values: numbers(one.d, Uint8Array), table: ladder(one.stops) }); }),
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

function at(values, place) { return values[place[0]] + (values[place[1]] - values[place[0]]) * place[2]; }

// A tube along the helix; rings stand between the nodes, cubic in the displacement, exact on them.
function springMesh(spring) {
  const nodes = spring.coil.length, turns = spring.coil[nodes - 1] - spring.coil[0];
  const parts = Math.max(1, Math.ceil(RINGS_PER_TURN * turns / (nodes - 1)));
  const rings = (nodes - 1) * parts + 1;
  const ring = { base: new Int32Array(rings), share: new Float32Array(rings), weights: new Float32Array(4 * rings), cos: new Float32Array(rings),
    sin: new Float32Array(rings), radius: new Float32Array(rings), wire: new Float32Array(rings), coil: new Float32Array(rings), height: new Float32Array(rings) };
  for (let i = 0; i < rings; i++) {
    const base = Math.min(Math.floor(i / parts), nodes - 2), t = (i - base * parts) / parts;
    ring.base[i] = base; ring.share[i] = t;
    const u = spring.coil[base] + (spring.coil[base + 1] - spring.coil[base]) * t;
    ring.coil[i] = u; ring.cos[i] = Math.cos(2 * Math.PI * u); ring.sin[i] = -spring.sign * Math.sin(2 * Math.PI * u);
    ring.radius[i] = spring.radius[base] + (spring.radius[base + 1] - spring.radius[base]) * t;
    ring.wire[i] = spring.wire[base] + (spring.wire[base + 1] - spring.wire[base]) * t;
    // Catmull-Rom; straight where a neighbour is missing.
    const inside = base > 0 && base < nodes - 2;
    ring.weights.set(inside ? [-t * (1 - t) * (1 - t) / 2, 1 - 2.5 * t * t + 1.5 * t * t * t, t * (1 + 4 * t - 3 * t * t) / 2, -t * t * (1 - t) / 2] : [0, 1 - t, t, 0], 4 * i);
  }
  const points = rings * AROUND + 2, position = new Float32Array(3 * points), normal = new Float32Array(3 * points), colour = new Float32Array(3 * points);
  const index = [];
  for (let i = 0; i + 1 < rings; i++) {
    for (let k = 0; k < AROUND; k++) {
      const a = i * AROUND + k, b = i * AROUND + (k + 1) % AROUND, c = a + AROUND, d = b + AROUND;
      if (spring.sign > 0) { index.push(a, c, b, b, c, d); } else { index.push(a, b, c, b, d, c); }
    }
  }
  for (let k = 0; k < AROUND; k++) {
    const next = (k + 1) % AROUND, last = (rings - 1) * AROUND;
    index.push(points - 2, k, next, points - 2, next, k, points - 1, last + k, last + next, points - 1, last + next, last + k);
  }
  const geometry = new THREE.BufferGeometry();
  [["position", position], ["normal", normal], ["color", colour]].forEach(function ([name, values]) {
    const attribute = new THREE.BufferAttribute(values, 3);
    attribute.setUsage(THREE.DynamicDrawUsage);
    geometry.setAttribute(name, attribute);
  });
  geometry.setIndex(index);
  const mesh = new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({ vertexColors: true }));
  mesh.frustumCulled = false;
  const turn = [];
  for (let k = 0; k < AROUND; k++) { turn.push(Math.cos(2 * Math.PI * k / AROUND), Math.sin(2 * Math.PI * k / AROUND)); }
  return { spring: spring, mesh: mesh, ring: ring, rings: rings, nodes: nodes, turn: turn, position: position, normal: normal, colour: colour,
    moved: new Float32Array(nodes), seen: new Float32Array(0) };
}

function moveSpring(tube, place, key) {
  const spring = tube.spring, nodes = tube.nodes, ring = tube.ring, moved = tube.moved;
  const a = place[0] * nodes, b = place[1] * nodes, share = place[2];
  for (let n = 0; n < nodes; n++) { moved[n] = spring.rest[n] + spring.scale * (spring.move[a + n] + (spring.move[b + n] - spring.move[a + n]) * share); }
  const painted = spring.colours.find(function (one) { return one.key === key; });
  // Values at the nodes, of a surface at some fibres of each from the outward one upward.
  const fibres = painted ? painted.fibres : 1, count = painted ? nodes * fibres : 0;
  if (tube.seen.length < count) { tube.seen = new Float32Array(count); }
  const seen = tube.seen, first = place[0] * count, second = place[1] * count;
  for (let n = 0; n < count; n++) { seen[n] = painted.values[first + n] + (painted.values[second + n] - painted.values[first + n]) * share; }
  const top = at(spring.retainer, place), rings = tube.rings;
  for (let i = 0; i < rings; i++) {
    const base = ring.base[i], w = 4 * i;
    ring.height[i] = (base > 0 ? ring.weights[w] * moved[base - 1] : 0) + ring.weights[w + 1] * moved[base] + ring.weights[w + 2] * moved[base + 1]
      + (base < nodes - 2 ? ring.weights[w + 3] * moved[base + 2] : 0);
  }
  for (let i = 0; i < rings; i++) {
    const before = Math.max(i - 1, 0), after = Math.min(i + 1, rings - 1);
    const rise = (ring.height[after] - ring.height[before]) / Math.max(ring.coil[after] - ring.coil[before], 1e-9), around = 2 * Math.PI * ring.radius[i];
    const length = Math.hypot(rise, around), c = around / length, s = rise / length * spring.sign;
    const cos = ring.cos[i], sin = ring.sin[i], r = ring.radius[i], wire = ring.wire[i], base = ring.base[i];
    // The section's second axis: up, less what the wire climbs along the coil.
    const bx = spring.sign * s * sin, by = c, bz = -spring.sign * s * cos;
    let tone = 0;
    for (let k = 0; k < AROUND; k++) {
      if (painted && (k === 0 || fibres > 1)) {
        const turned = k * fibres / AROUND, low = Math.floor(turned), f = base * fibres + low, g = base * fibres + (low + 1) % fibres, t = turned - low;
        const here = seen[f] + (seen[g] - seen[f]) * t, next = seen[f + fibres] + (seen[g + fibres] - seen[f + fibres]) * t;
        tone = 3 * Math.max(0, Math.min(255, Math.round(here + (next - here) * ring.share[i])));
      }
      const p = 3 * (i * AROUND + k), out = tube.turn[2 * k], up = tube.turn[2 * k + 1];
      const nx = out * cos + up * bx, ny = up * by, nz = out * sin + up * bz;
      tube.position[p] = r * cos + wire * nx;
      tube.position[p + 1] = Math.min(Math.max(ring.height[i] + wire * ny, 0), top);
      tube.position[p + 2] = r * sin + wire * nz;
      tube.normal[p] = nx; tube.normal[p + 1] = ny; tube.normal[p + 2] = nz;
      if (painted) { tube.colour[p] = painted.table[tone]; tube.colour[p + 1] = painted.table[tone + 1]; tube.colour[p + 2] = painted.table[tone + 2]; }
      else { tube.colour[p] = 0.25; tube.colour[p + 1] = 0.34; tube.colour[p + 2] = 0.45; }
    }
  }
  [0, rings - 1].forEach(function (i, end) {
    const p = 3 * (rings * AROUND + end), from = 3 * i * AROUND;
    tube.position[p] = ring.radius[i] * ring.cos[i]; tube.position[p + 1] = Math.min(Math.max(ring.height[i], 0), top); tube.position[p + 2] = ring.radius[i] * ring.sin[i];
    tube.normal[p + 1] = 1;
    for (let c = 0; c < 3; c++) { tube.colour[p + c] = tube.colour[from + c]; }
  });
  ["position", "normal", "color"].forEach(function (name) { tube.mesh.geometry.attributes[name].needsUpdate = true; });
}

function bodyGroup(body) {
  const group = new THREE.Group(), material = new THREE.MeshLambertMaterial({ color: body.colour, side: THREE.DoubleSide });
  body.shapes.forEach(function (shape) {
    const points = [];
    for (let i = 0; i < shape.points.length; i += 2) { points.push(new THREE.Vector2(shape.points[i], shape.points[i + 1])); }
    let geometry;
    if (shape.kind === "lathe") {
      geometry = new THREE.LatheGeometry(points, 40);
    } else {
      geometry = new THREE.ExtrudeGeometry(new THREE.Shape(points), { depth: shape.depth[1] - shape.depth[0], bevelEnabled: false, curveSegments: 1 });
      geometry.translate(0, 0, shape.depth[0]);
    }
    group.add(new THREE.Mesh(geometry, material));
  });
  return { body: body, group: group };
}

function moveBody(shown, place) {
  const pose = shown.body.pose, a = shown.body.fixed ? 0 : 3 * place[0], b = shown.body.fixed ? 0 : 3 * place[1], share = place[2];
  let turn = pose[b + 2] - pose[a + 2];
  turn -= 2 * Math.PI * Math.round(turn / (2 * Math.PI));
  shown.group.position.set(pose[a] + (pose[b] - pose[a]) * share, pose[a + 1] + (pose[b + 1] - pose[a + 1]) * share, 0);
  shown.group.rotation.z = pose[a + 2] + turn * share;
}

// Seat and retainer of a spring that stands alone.
function discs(spring) {
  const last = spring.coil.length - 1, thick = 2.5;
  const sizes = [spring.radius[0] + spring.wire[0], spring.radius[last] + spring.wire[last]].map(function (size) { return size * 1.12; });
  return sizes.map(function (size) {
    const geometry = new THREE.LatheGeometry([[size * 0.45, 0], [size, 0], [size, thick], [size * 0.45, thick], [size * 0.45, 0]].map(function (one) { return new THREE.Vector2(one[0], one[1]); }), 48);
    return new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({ color: "#8a919b", side: THREE.DoubleSide }));
  });
}

// What the picture must hold: least and largest x and y over the cycle, and the largest depth.
function extent(one, only) {
  const box = [Infinity, Infinity, -Infinity, -Infinity, 1];
  function take(x, y) { box[0] = Math.min(box[0], x); box[1] = Math.min(box[1], y); box[2] = Math.max(box[2], x); box[3] = Math.max(box[3], y); }
  const count = one.angle.length, step = Math.max(1, Math.floor(count / 24));
  one.bodies.forEach(function (body) {
    if (only && !only(body.name)) { return; }
    for (let f = 0; f < (body.fixed ? 1 : count); f += step) {
      const x = body.pose[3 * f], y = body.pose[3 * f + 1], c = Math.cos(body.pose[3 * f + 2]), s = Math.sin(body.pose[3 * f + 2]);
      body.shapes.forEach(function (shape) {
        for (let i = 0; i < shape.points.length; i += 2) {
          const u = shape.points[i], v = shape.points[i + 1];
          take(x + c * u - s * v, y + s * u + c * v);
          if (shape.kind === "lathe") { take(x - c * u - s * v, y - s * u + c * v); box[4] = Math.max(box[4], u); } else { box[4] = Math.max(box[4], shape.depth[1]); }
        }
      });
    }
  });
  if (!only || only("spring")) { one.springs.forEach(function (spring) {
    const wide = Math.max.apply(null, Array.from(spring.radius)) + Math.max.apply(null, Array.from(spring.wire)), tall = Math.max.apply(null, Array.from(spring.retainer)) + 3;
    const x = Math.cos(spring.direction), y = Math.sin(spring.direction);
    [[-1.12, -3], [1.12, -3], [-1.12, tall], [1.12, tall]].forEach(function ([side, up]) { take(spring.seat[0] + up * x - side * wide * y, spring.seat[1] + up * y + side * wide * x); });
    box[4] = Math.max(box[4], wide);
  }); }
  return box;
}

// Whether the processor draws: smooth edges then cost half the pictures, so they are drawn finer only while nothing moves.
function isSoftware() {
  const context = document.createElement("canvas").getContext("webgl2"), told = context && context.getExtension("WEBGL_debug_renderer_info");
  const words = told ? String(context.getParameter(told.UNMASKED_RENDERER_WEBGL)) : "";
  const lose = context && context.getExtension("WEBGL_lose_context");
  if (lose) { lose.loseContext(); }
  return /swiftshader|llvmpipe|software|basic render/i.test(words);
}

// The picture in three dimensions, orthographic so that it stays to scale; null where the browser has no WebGL.
function makeView(box, changed) {
  const canvas = make("canvas", { tabindex: "0", role: "img", "aria-label": "Spring in three dimensions. Arrow keys turn it, plus and minus zoom, 0 shows the whole." });
  let context = null, soft = false;
  try { soft = isSoftware(); context = canvas.getContext("webgl2", { antialias: !soft, alpha: true }); } catch (error) { context = null; }
  if (!context) { return null; }
  const renderer = new THREE.WebGLRenderer({ canvas: canvas, context: context, alpha: true });
  renderer.setClearColor(0x000000, 0);
  let fine = null;
  function refine(on) {
    if (on === fine) { return; }
    fine = on;
    renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, MOST_PIXELS) * (soft && on ? 2 : 1));
    if (box.clientWidth) { renderer.setSize(box.clientWidth, box.clientHeight, false); }
  }
  refine(true);
  const scene = new THREE.Scene(), camera = new THREE.OrthographicCamera(-1, 1, 1, -1, 0.1, 4000), light = new THREE.DirectionalLight(0xffffff, 2.1);
  scene.add(new THREE.HemisphereLight(0xffffff, 0xb4b8bf, 1.9), light);
  const home = { azimuth: 0.45, elevation: 0.3, zoom: 1 }, view = Object.assign({}, home);
  let extents = [-1, -1, 1, 1, 1], all = extents, root = new THREE.Group();
  scene.add(root);
  function aim() {
    const width = canvas.clientWidth || 1, height = canvas.clientHeight || 1;
    const [x0, y0, x1, y1, depth] = extents, ca = Math.abs(Math.cos(view.azimuth)), sa = Math.abs(Math.sin(view.azimuth)), ce = Math.abs(Math.cos(view.elevation)), se = Math.abs(Math.sin(view.elevation));
    const wide = (x1 - x0) * ca + 2 * depth * sa, deep = (x1 - x0) * sa + 2 * depth * ca, tall = (y1 - y0) * ce + deep * se;
    const half = 0.53 * Math.max(tall, wide * height / width) / view.zoom;
    camera.top = half; camera.bottom = -half; camera.right = half * width / height; camera.left = -camera.right;
    const far = 1000, middle = [(x0 + x1) / 2, (y0 + y1) / 2];
    const dx = Math.sin(view.azimuth) * Math.cos(view.elevation), dy = Math.sin(view.elevation), dz = Math.cos(view.azimuth) * Math.cos(view.elevation);
    camera.position.set(middle[0] + far * dx, middle[1] + far * dy, far * dz);
    camera.lookAt(middle[0], middle[1], 0);
    camera.updateProjectionMatrix();
    light.position.set(dx + 0.5 * dz, dy + 0.8, dz - 0.5 * dx);
  }
  function turn(sideways, upwards) {
    view.azimuth += sideways; view.elevation = Math.max(-1.5, Math.min(1.5, view.elevation + upwards));
    changed();
  }
  function zoom(factor) { view.zoom = Math.max(0.5, Math.min(20, view.zoom * factor)); changed(); }
  function whole() { extents = all; Object.assign(view, home); changed(); }
  function look(at) { if (at[2] > at[0]) { extents = at; view.zoom = 1; changed(); } }
  // One pointer turns, two pinch; a wheel zooms once the picture has the focus, so that the page still scrolls.
  const pointers = new Map();
  let apart = 0;
  canvas.addEventListener("pointerdown", function (event) { canvas.setPointerCapture(event.pointerId); pointers.set(event.pointerId, [event.clientX, event.clientY]); apart = 0; });
  canvas.addEventListener("pointermove", function (event) {
    const last = pointers.get(event.pointerId);
    if (!last) { return; }
    const now = [event.clientX, event.clientY];
    pointers.set(event.pointerId, now);
    if (pointers.size === 1) { turn((last[0] - now[0]) * 0.008, (now[1] - last[1]) * 0.008); return; }
    const ends = Array.from(pointers.values()), wide = Math.hypot(ends[0][0] - ends[1][0], ends[0][1] - ends[1][1]);
    if (apart > 0 && wide > 0) { zoom(wide / apart); }
    apart = wide;
  });
  ["pointerup", "pointercancel"].forEach(function (name) { canvas.addEventListener(name, function (event) { pointers.delete(event.pointerId); apart = 0; }); });
  canvas.addEventListener("wheel", function (event) {
    if (document.activeElement !== canvas) { return; }
    event.preventDefault();
    zoom(Math.exp(-event.deltaY * 0.0012));
  }, { passive: false });
  canvas.addEventListener("keydown", function (event) {
    const step = { ArrowLeft: [0.12, 0], ArrowRight: [-0.12, 0], ArrowUp: [0, -0.12], ArrowDown: [0, 0.12] }[event.key];
    if (step) { turn(step[0], step[1]); } else if (event.key === "+" || event.key === "=") { zoom(1.2); } else if (event.key === "-") { zoom(1 / 1.2); } else if (event.key === "0") { whole(); } else { return; }
    event.preventDefault(); event.stopPropagation();
  });
  canvas.addEventListener("webglcontextlost", function (event) { event.preventDefault(); });
  canvas.addEventListener("webglcontextrestored", changed);
  box.append(canvas);
  function free(group) { group.traverse(function (one) { if (one.geometry) { one.geometry.dispose(); one.material.dispose(); } }); }
  let tubes = [], bodies = [], ends = [];
  return {
    canvas: canvas, refine: refine, turn: turn, zoom: zoom, whole: whole, look: look,
    show: function (one) {
      free(root); scene.remove(root);
      root = new THREE.Group(); scene.add(root);
      extents = all = extent(one);
      home.azimuth = one.bodies.length ? 0.32 : 0.45; home.elevation = one.bodies.length ? 0.2 : 0.3;
      Object.assign(view, home);
      bodies = one.bodies.map(bodyGroup);
      bodies.forEach(function (shown) { root.add(shown.group); });
      ends = [];
      tubes = one.springs.map(function (spring) {
        const tube = springMesh(spring), group = new THREE.Group();
        group.position.set(spring.seat[0], spring.seat[1], 0); group.rotation.z = spring.direction - Math.PI / 2;
        group.add(tube.mesh);
        if (!one.bodies.length) { const pair = discs(spring); pair[0].position.y = -2.5; group.add(pair[0], pair[1]); ends.push([spring, pair[1]]); }
        root.add(group);
        return tube;
      });
    },
    move: function (place, key) {
      tubes.forEach(function (tube) { moveSpring(tube, place, key); });
      bodies.forEach(function (shown) { moveBody(shown, place); });
      ends.forEach(function ([spring, disc]) { disc.position.y = at(spring.retainer, place); });
    },
    draw: function () { aim(); renderer.render(scene, camera); },
    size: function () { renderer.setSize(box.clientWidth, box.clientHeight, false); },
    tubes: function () { return tubes; }, bodies: function () { return bodies; },
    destroy: function () { free(root); renderer.dispose(); renderer.forceContextLoss(); },
  };
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
 * Returns {seek, angle, play, pause, playing, variant, colour, statistics, destroy}; angles are cam degrees.
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
  const state = { variant: 0, angle: 0, slow: USUAL_SLOWNESS, playing: false, key: "", frames: 0, drawn: [], apart: [], before: 0, dirty: true, last: 0 };
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
  function pause() { state.playing = false; playButton.textContent = "Play"; now.setAttribute("aria-live", "polite"); request(); }

  const playButton = make("button", { type: "button", class: "vtm-play", text: "Play" });
  playButton.addEventListener("click", function () { if (state.playing) { pause(); } else { play(); } });
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
  bar.append(variantLabel, colourLabel, slowLabel, make("span", { class: "vtm-group" }, playButton, ...steps, ...jumps));
  right.append(key, plotBox, list);
  stage.append(left, right);
  box.append(bar, stage, slide, now, told);

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

  function paint() {
    const painted = one.springs.map(function (spring) { return spring.colours.find(function (each) { return each.key === state.key; }); }).find(Boolean);
    scale.hidden = !painted;
    if (!painted) { return; }
    scale.replaceChildren();
    const strip = make("div", {}), ends = make("p", {});
    strip.style.background = "linear-gradient(to right, " + painted.stops.join(", ") + ")";
    ends.append(make("span", { text: number(painted.low) + " " + painted.unit }), make("strong", { text: painted.words + " (" + painted.unit + ")" }), make("span", { text: number(painted.high) + " " + painted.unit }));
    scale.append(strip, ends);
  }

  function choose(place) {
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
      view.canvas.setAttribute("aria-label", (one.bodies.length ? "Train and spring" : "Spring") + " in three dimensions, " + one.words + ". Arrow keys turn it, plus and minus zoom, 0 shows the whole.");
    }
    plot.show(one);
    paint();
    request();
  }

  function say() {
    const turn = 120000 / one.rpm, place = between(one, state.angle);
    const parts = ["cam angle " + state.angle.toFixed(1) + "°", "time " + (turn * state.angle / 360).toFixed(2) + " ms", "valve lift " + at(one.lift, place).toFixed(3).replace("-", "\u2212") + " " + one.units.lift];
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
      if (state.last) { state.angle = (state.angle + Math.min((time - state.last) / 1000, 0.5) * one.rpm * 3 / state.slow) % 360; state.dirty = true; }
      state.last = time;
    }
    if (state.dirty) {
      const begun = performance.now();
      state.dirty = false;
      const place = between(one, state.angle);
      if (view) { view.refine(!state.playing); view.move(place, state.key); view.draw(); }
      plot.move(state.angle);
      say();
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
    if (view) { view.size(); }
    plot.size();
    request();
  }
  const watch = new ResizeObserver(fit);
  watch.observe(box);
  fit();
  const handle = {
    seek: seek, angle: function () { return state.angle; }, play: play, pause: pause, playing: function () { return state.playing; },
    variant: function (place) { if (place !== undefined) { choose(place); variantSelect.value = String(place); } return state.variant; },
    colour: function (name) { if (name !== undefined) { state.key = name; colourSelect.value = name; paint(); request(); } return state.key; },
    webgl: Boolean(view), shown: function () { return view ? { tubes: view.tubes(), bodies: view.bodies() } : null; },
    statistics: function () {
      function middle(values) { return values.length ? values.slice().sort(function (a, b) { return a - b; })[values.length >> 1] : NaN; }
      return { frames: state.frames, drawing: middle(state.drawn), interval: middle(state.apart), counted: state.apart.length };
    },
    destroy: function () { gone = true; watch.disconnect(); window.removeEventListener("beforeprint", forPrint); cancelAnimationFrame(asked); if (view) { view.destroy(); } element.replaceChildren(...still); delete element.motion; },
  };
  element.motion = handle;
  return handle;
}

globalThis.valvetrainMotion = { mount: mount };
