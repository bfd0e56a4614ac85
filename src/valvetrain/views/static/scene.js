// The picture in three dimensions: makeView(box, changed) draws springs and bodies by WebGL2 into a canvas. Lengths are mm.
// The graphics card bends the wire, so a picture costs the page one row of numbers for each spring: heights and colours of its nodes.
const AROUND = 16, RINGS_PER_TURN = 24, FACETS = 48, MOST_PIXELS = 1.5, DISC_THICKNESS = 2.5;
const PLAIN_WIRE = [0.25, 0.34, 0.45], DISC_COLOUR = "#8a919b";

// Every point: turned and moved with its body, then seen along the eye without perspective, so that the picture stays to scale.
const PLACED = `#version 300 es
precision highp float; precision highp int; precision highp sampler2D;
uniform mat3 axes;           // columns: to the right, upward, towards the eye
uniform vec3 middle, scale;  // centre of the picture in mm; picture per mm
uniform vec3 pose;           // x and y in mm, turn in rad
uniform vec3 plain;
out vec3 normal, base;
void place(vec3 point, vec3 facing) {
  mat2 turn = mat2(cos(pose.z), sin(pose.z), -sin(pose.z), cos(pose.z));
  normal = vec3(turn * facing.xy, facing.z);
  gl_Position = vec4((vec3(turn * point.xy + pose.xy, point.z) - middle) * axes * scale, 1.0);
}`;
const SOLID = PLACED + `
layout(location = 0) in vec3 point; layout(location = 1) in vec3 facing;
void main() { base = plain; place(point, facing); }`;
// The wire: exact on the nodes, between them cubic in the height (Catmull-Rom), straight where a neighbour is missing.
const WIRE = PLACED + `
layout(location = 0) in vec4 spot;      // place along the wire in nodes; cosine, sine and share of the way around the section
uniform sampler2D shape, now, ladder;   // of a node: coil number, radius, wire radius; height and values; 256 colours
uniform float hand, top; uniform int fibres;
float height(int n) { return texelFetch(now, ivec2(n, 0), 0).x; }
float value(int n, int fibre) { return texelFetch(now, ivec2(n, 1 + fibre % fibres), 0).x; }
void main() {
  int last = textureSize(shape, 0).x - 1, n = min(int(spot.x), last - 1);
  float t = spot.x - float(n), low = height(n), high = height(n + 1), y = mix(low, high, t), climb = high - low;
  if (n > 0 && n + 1 < last) {
    float p = 0.5 * (high - height(n - 1)), q = 0.5 * (height(n + 2) - low);
    float two = 3.0 * (high - low) - 2.0 * p - q, three = p + q - 2.0 * (high - low);
    y = low + t * (p + t * (two + t * three)); climb = p + t * (2.0 * two + 3.0 * t * three);
  }
  vec3 from = texelFetch(shape, ivec2(n, 0), 0).xyz, to = texelFetch(shape, ivec2(n + 1, 0), 0).xyz, here = mix(from, to, t);
  float turn = 6.283185307 * here.x, c = cos(turn), s = -hand * sin(turn);
  vec2 along = normalize(vec2(6.283185307 * here.y, climb / max(to.x - from.x, 1e-9)));
  // The section's second axis points up, less what the wire climbs along the coil.
  vec3 outward = vec3(c, 0.0, s), up = vec3(-hand * along.y * s, along.x, hand * along.y * c), facing = spot.y * outward + spot.z * up;
  vec3 point = here.y * outward + vec3(0.0, y, 0.0) + here.z * facing;
  point.y = clamp(point.y, 0.0, top);   // ground ends: seat and retainer cut the wire
  base = plain;
  if (fibres > 0) {
    float f = spot.w * float(fibres); int g = int(f);
    float tone = mix(mix(value(n, g), value(n, g + 1), f - float(g)), mix(value(n + 1, g), value(n + 1, g + 1), f - float(g)), t);
    base = texelFetch(ladder, ivec2(int(clamp(tone, 0.0, 255.0) + 0.5), 0), 0).rgb;
  }
  place(point, dot(facing, facing) > 0.0 ? facing : vec3(0.0, 1.0, 0.0));
}`;
// Light from the side of the eye and from a bright sky; colours are linear until the last line. Open shapes are lit on both sides.
const LIT = `#version 300 es
precision highp float;
uniform vec3 eye, light; uniform bool wire;
in vec3 normal, base; out vec4 colour;
void main() {
  vec3 n = normalize(normal), sky = vec3(1.0), ground = vec3(0.456, 0.479, 0.521);
  if (!wire && dot(n, eye) < -0.08) { n = -n; }
  vec3 lit = min(base * (2.1 * max(dot(n, light), 0.0) + 1.9 * mix(ground, sky, 0.5 + 0.5 * n.y)) / 3.14159265, 1.0);
  colour = vec4(mix(12.92 * lit, 1.055 * pow(lit, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, lit)), 1.0);
}`;

function at(values, place) { return values[place[0]] + (values[place[1]] - values[place[0]]) * place[2]; }

function linear(share) { return share <= 0.04045 ? share / 12.92 : Math.pow((share + 0.055) / 1.055, 2.4); }

function hex(colour) { return [1, 3, 5].map(function (place) { return parseInt(colour.slice(place, place + 2), 16) / 255; }); }

// 256 linear colours between the stops, which are laid out in sRGB.
function ladder(stops) {
  const ends = stops.map(hex), table = new Float32Array(768);
  for (let i = 0; i < 256; i++) {
    const place = i / 255 * (ends.length - 1), low = Math.min(Math.floor(place), ends.length - 2), share = place - low;
    for (let c = 0; c < 3; c++) { table[3 * i + c] = linear(ends[low][c] + (ends[low + 1][c] - ends[low][c]) * share); }
  }
  return table;
}

// Rings along the wire, of points around its section, and a point in the middle of each end.
function wireMesh(spring) {
  const last = spring.coil.length - 1, parts = Math.max(1, Math.ceil(RINGS_PER_TURN * (spring.coil[last] - spring.coil[0]) / last));
  const rings = last * parts + 1, mesh = { values: [], index: [] };
  for (let i = 0; i < rings; i++) {
    for (let k = 0; k < AROUND; k++) {
      const angle = 2 * Math.PI * k / AROUND, a = i * AROUND + k, b = i * AROUND + (k + 1) % AROUND;
      mesh.values.push(i / parts, Math.cos(angle), Math.sin(angle), k / AROUND);
      if (i + 1 < rings) { mesh.index.push(a, b, a + AROUND, b, b + AROUND, a + AROUND); }
    }
  }
  [0, rings - 1].forEach(function (ring, end) {
    mesh.values.push(end * last, 0, 0, 0);
    for (let k = 0; k < AROUND; k++) { mesh.index.push(rings * AROUND + end, ring * AROUND + k, ring * AROUND + (k + 1) % AROUND); }
  });
  return mesh;
}

function quad(mesh, corners, normals) {
  const first = mesh.values.length / 6;
  corners.forEach(function (corner, place) { mesh.values.push(...corner, ...normals[place]); });
  mesh.index.push(first, first + 1, first + 2, first, first + 2, first + 3);
}

function turnedMesh(mesh, points) {
  for (let i = 0; i + 3 < points.length; i += 2) {
    const [r0, y0, r1, y1] = points.slice(i, i + 4), length = Math.hypot(r1 - r0, y1 - y0) || 1, out = (y1 - y0) / length, up = (r0 - r1) / length;
    for (let k = 0; k < FACETS; k++) {
      const [[c0, s0], [c1, s1]] = [k, k + 1].map(function (step) { return [Math.cos(2 * Math.PI * step / FACETS), Math.sin(2 * Math.PI * step / FACETS)]; });
      const here = [out * c0, up, out * s0], next = [out * c1, up, out * s1];
      quad(mesh, [[r0 * c0, y0, r0 * s0], [r1 * c0, y1, r1 * s0], [r1 * c1, y1, r1 * s1], [r0 * c1, y0, r0 * s1]], [here, here, next, next]);
    }
  }
}

function area(a, b, c) { return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]); }

// Triangles of a counter-clockwise outline: ears are cut off one by one, corners without area first.
function triangles(corners) {
  const left = corners.map(function (corner, place) { return place; }), cut = [];
  while (left.length > 2) {
    function around(place) { return [-1, 0, 1].map(function (by) { return left[(place + by + left.length) % left.length]; }); }
    const ear = left.findIndex(function (unused, place) {
      const [a, b, c] = around(place).map(function (corner) { return corners[corner]; }), size = area(a, b, c);
      return size === 0 || (size > 0 && !left.some(function (corner) { const p = corners[corner]; return area(a, b, p) > 0 && area(b, c, p) > 0 && area(c, a, p) > 0; }));
    });
    cut.push(...around(Math.max(ear, 0)));
    left.splice(Math.max(ear, 0), 1);
  }
  return cut;
}

function plateMesh(mesh, points, depths) {
  const corners = [];
  for (let i = 0; i < points.length; i += 2) { corners.push([points[i], points[i + 1]]); }
  if (corners.reduce(function (sum, corner, i) { return sum + area([0, 0], corner, corners[(i + 1) % corners.length]); }, 0) < 0) { corners.reverse(); }
  corners.forEach(function (a, i) {
    const b = corners[(i + 1) % corners.length], length = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1;
    quad(mesh, [[...a, depths[0]], [...b, depths[0]], [...b, depths[1]], [...a, depths[1]]], Array(4).fill([(b[1] - a[1]) / length, (a[0] - b[0]) / length, 0]));
  });
  const flat = triangles(corners);
  depths.forEach(function (depth, side) {
    const first = mesh.values.length / 6;
    corners.forEach(function (corner) { mesh.values.push(...corner, depth, 0, 0, side ? 1 : -1); });
    mesh.index.push(...flat.map(function (corner) { return first + corner; }));
  });
}

function solidMesh(shapes) {
  const mesh = { values: [], index: [] };
  shapes.forEach(function (shape) { if (shape.kind === "lathe") { turnedMesh(mesh, Array.from(shape.points)); } else { plateMesh(mesh, shape.points, shape.depth); } });
  return mesh;
}

// Seat and retainer of a spring that stands alone.
function disc(spring, node, bottom) {
  const size = 1.12 * (spring.radius[node] + spring.wire[node]), hole = 0.45 * size, top = bottom + DISC_THICKNESS;
  return [{ kind: "lathe", points: [hole, bottom, size, bottom, size, top, hole, top, hole, bottom] }];
}

function bodyPose(body, [first, second, share]) {
  const pose = body.pose, a = body.fixed ? 0 : 3 * first, b = body.fixed ? 0 : 3 * second, turn = pose[b + 2] - pose[a + 2];
  return [pose[a] + (pose[b] - pose[a]) * share, pose[a + 1] + (pose[b + 1] - pose[a + 1]) * share,
    pose[a + 2] + (turn - 2 * Math.PI * Math.round(turn / (2 * Math.PI))) * share];
}

// What the picture must hold: least and largest x and y over the cycle, and the largest depth.
function extent(one, only) {
  const box = [Infinity, Infinity, -Infinity, -Infinity, 1];
  function take(x, y, depth) { [box[0], box[1], box[2], box[3], box[4]] = [Math.min(box[0], x), Math.min(box[1], y), Math.max(box[2], x), Math.max(box[3], y), Math.max(box[4], depth)]; }
  const count = one.angle.length, step = Math.max(1, Math.floor(count / 24));
  one.bodies.forEach(function (body) {
    if (only && !only(body.name)) { return; }
    for (let f = 0; f < (body.fixed ? 1 : count); f += step) {
      const [x, y, turn] = bodyPose(body, [f, f, 0]), c = Math.cos(turn), s = Math.sin(turn);
      body.shapes.forEach(function (shape) {
        const turned = shape.kind === "lathe";
        for (let i = 0; i < shape.points.length; i += 2) {
          const u = shape.points[i], v = shape.points[i + 1];
          (turned ? [u, -u] : [u]).forEach(function (side) { take(x + c * side - s * v, y + s * side + c * v, turned ? u : shape.depth[1]); });
        }
      });
    }
  });
  if (!only || only("spring")) { one.springs.forEach(function (spring) {
    const wide = 1.12 * (Math.max(...spring.radius) + Math.max(...spring.wire)), tall = spring.retainer.reduce(function (a, b) { return Math.max(a, b); }) + DISC_THICKNESS;
    const x = Math.cos(spring.direction), y = Math.sin(spring.direction);
    [[-wide, -DISC_THICKNESS], [wide, -DISC_THICKNESS], [-wide, tall], [wide, tall]].forEach(function ([side, up]) { take(spring.seat[0] + up * x - side * y, spring.seat[1] + up * y + side * x, wide); });
  }); }
  return box;
}

// Whether the processor draws: smooth edges then cost half the pictures, so they are drawn finer only while nothing moves.
function isSoftware() {
  const gl = document.createElement("canvas").getContext("webgl2"), card = gl && gl.getExtension("WEBGL_debug_renderer_info");
  const words = card ? String(gl.getParameter(card.UNMASKED_RENDERER_WEBGL)) : "", lose = gl && gl.getExtension("WEBGL_lose_context");
  if (lose) { lose.loseContext(); }
  return /swiftshader|llvmpipe|software|basic render/i.test(words);
}

function program(gl, vertex) {
  const linked = gl.createProgram(), where = {};
  [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, LIT]].forEach(function ([kind, source]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source); gl.compileShader(shader); gl.attachShader(linked, shader);
  });
  gl.linkProgram(linked);
  if (!gl.getProgramParameter(linked, gl.LINK_STATUS) && !gl.isContextLost()) { throw new Error(gl.getProgramInfoLog(linked) || "the picture's program does not link"); }
  for (let i = 0; i < gl.getProgramParameter(linked, gl.ACTIVE_UNIFORMS); i++) {
    const { name } = gl.getActiveUniform(linked, i);
    where[name] = gl.getUniformLocation(linked, name);
  }
  return { linked: linked, where: where };
}

// A mesh on the card; sizes are those of its vertex attributes.
function upload(gl, mesh, sizes) {
  const array = gl.createVertexArray(), values = gl.createBuffer(), index = gl.createBuffer();
  const stride = 4 * sizes.reduce(function (a, b) { return a + b; });
  gl.bindVertexArray(array);
  gl.bindBuffer(gl.ARRAY_BUFFER, values); gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(mesh.values), gl.STATIC_DRAW);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, index); gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(mesh.index), gl.STATIC_DRAW);
  sizes.forEach(function (size, place) { gl.enableVertexAttribArray(place); gl.vertexAttribPointer(place, size, gl.FLOAT, false, stride, 12 * place); });
  gl.bindVertexArray(null);
  return { array: array, count: mesh.index.length, free: function () { gl.deleteVertexArray(array); gl.deleteBuffer(values); gl.deleteBuffer(index); } };
}

// A table that a shader reads by place; `parts` numbers for each place.
function tableOf(gl, width, height, parts, values) {
  const table = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, table);
  gl.texImage2D(gl.TEXTURE_2D, 0, parts === 1 ? gl.R32F : gl.RGB32F, width, height, 0, parts === 1 ? gl.RED : gl.RGB, gl.FLOAT, values);
  [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER].forEach(function (name) { gl.texParameteri(gl.TEXTURE_2D, name, gl.NEAREST); });
  return table;
}

// A spring on the card; move(place, key) sends heights and values of its nodes between two frames.
function wireItem(gl, spring) {
  const nodes = spring.coil.length, most = Math.max(1, ...spring.colours.map(function (each) { return each.fibres; })), now = new Float32Array(nodes * (1 + most));
  const shape = new Float32Array(3 * nodes), mesh = upload(gl, wireMesh(spring), [4]), tables = {};
  for (let n = 0; n < nodes; n++) { shape.set([spring.coil[n], spring.radius[n], spring.wire[n]], 3 * n); }
  const shapeTable = tableOf(gl, nodes, 1, 3, shape), nowTable = tableOf(gl, nodes, 1 + most, 1, now);
  const pose = [spring.seat[0], spring.seat[1], spring.direction - Math.PI / 2];
  return {
    mesh: mesh, wire: true, colour: PLAIN_WIRE, pose: function () { return pose; },
    move: function (where, place, key) {
      const a = place[0] * nodes, b = place[1] * nodes, share = place[2], painted = spring.colours.find(function (each) { return each.key === key; });
      for (let n = 0; n < nodes; n++) { now[n] = spring.rest[n] + spring.scale * (spring.move[a + n] + (spring.move[b + n] - spring.move[a + n]) * share); }
      const fibres = painted ? painted.fibres : 0;
      for (let f = 0; f < fibres; f++) {
        for (let n = 0; n < nodes; n++) {
          const from = painted.values[(a + n) * fibres + f];
          now[nodes * (1 + f) + n] = from + (painted.values[(b + n) * fibres + f] - from) * share;
        }
      }
      if (painted && !tables[key]) { tables[key] = tableOf(gl, 256, 1, 3, ladder(painted.stops)); }
      [shapeTable, nowTable, tables[key] || null].forEach(function (table, unit) { gl.activeTexture(gl.TEXTURE0 + unit); gl.bindTexture(gl.TEXTURE_2D, table); });
      gl.activeTexture(gl.TEXTURE1);
      gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, nodes, 1 + most, gl.RED, gl.FLOAT, now);
      [where.shape, where.now, where.ladder].forEach(function (name, unit) { gl.uniform1i(name, unit); });
      gl.uniform1f(where.hand, spring.sign); gl.uniform1f(where.top, at(spring.retainer, place)); gl.uniform1i(where.fibres, fibres);
    },
    free: function () { mesh.free(); [shapeTable, nowTable, ...Object.values(tables)].forEach(function (table) { gl.deleteTexture(table); }); },
  };
}

function solidItem(gl, shapes, colour, pose) {
  const mesh = upload(gl, solidMesh(shapes), [3, 3]);
  return { mesh: mesh, wire: false, colour: hex(colour).map(linear), pose: pose, move: function () {}, free: mesh.free };
}

function itemsOf(gl, one) {
  const items = one.bodies.map(function (body) { return solidItem(gl, body.shapes, body.colour, function (place) { return bodyPose(body, place); }); });
  one.springs.forEach(function (spring) {
    const wire = wireItem(gl, spring), [x, y, lean] = wire.pose();
    items.push(wire);
    if (one.bodies.length) { return; }
    items.push(solidItem(gl, disc(spring, 0, -DISC_THICKNESS), DISC_COLOUR, wire.pose), solidItem(gl, disc(spring, spring.coil.length - 1, 0), DISC_COLOUR, function (place) {
      const up = at(spring.retainer, place);
      return [x - up * Math.sin(lean), y + up * Math.cos(lean), lean];
    }));
  });
  return items;
}

// One pointer turns; with shift or another button it moves the picture; two pinch and move it. A wheel zooms once the picture has the focus.
function listen(canvas, turn, pan, zoom, whole) {
  const pointers = new Map();
  canvas.addEventListener("pointerdown", function (event) { canvas.setPointerCapture(event.pointerId); pointers.set(event.pointerId, [event.clientX, event.clientY]); });
  canvas.addEventListener("pointermove", function (event) {
    const last = pointers.get(event.pointerId), now = [event.clientX, event.clientY];
    if (!last) { return; }
    const by = [now[0] - last[0], now[1] - last[1]], [other] = [...pointers].filter(function ([id]) { return id !== event.pointerId; });
    pointers.set(event.pointerId, now);
    if (other) {
      const [was, is] = [last, now].map(function (place) { return Math.hypot(place[0] - other[1][0], place[1] - other[1][1]); });
      if (was > 0 && is > 0) { zoom(is / was); }
      pan(by[0] / 2, by[1] / 2);
    } else if (event.shiftKey || event.buttons > 1) { pan(by[0], by[1]); } else { turn(-0.008 * by[0], 0.008 * by[1]); }
  });
  ["pointerup", "pointercancel"].forEach(function (name) { canvas.addEventListener(name, function (event) { pointers.delete(event.pointerId); }); });
  canvas.addEventListener("contextmenu", function (event) { event.preventDefault(); });
  canvas.addEventListener("wheel", function (event) {
    if (document.activeElement === canvas) { event.preventDefault(); zoom(Math.exp(-0.0012 * event.deltaY)); }
  }, { passive: false });
  canvas.addEventListener("keydown", function (event) {
    const step = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key], by = { "+": 1.2, "=": 1.2, "-": 1 / 1.2 }[event.key];
    if (event.ctrlKey || event.altKey || event.metaKey) { return; }
    if (step && event.shiftKey) { pan(-20 * step[0], 20 * step[1]); } else if (step) { turn(0.12 * step[0], 0.12 * step[1]); } else if (by) { zoom(by); } else if (event.key === "0") { whole(); } else { return; }
    event.preventDefault(); event.stopPropagation();
  });
}

// The view on a run, in a canvas that fills the box; null where the browser has no WebGL2.
function makeView(box, changed) {
  const canvas = make("canvas", { tabindex: "0", role: "img" });
  let gl = null, soft = false;
  try { soft = isSoftware(); gl = canvas.getContext("webgl2", { antialias: !soft }); } catch (error) { gl = null; }
  if (!gl) { return null; }
  const home = { azimuth: 0.45, elevation: 0.3, zoom: 1, shift: [0, 0, 0] }, view = Object.assign({}, home);
  let one = null, items = [], programs = null, extents = [-1, -1, 1, 1, 1], place = [0, 0, 0], key = "", mode = "rest", half = 1;
  function build() {
    items = [];
    if (gl.isContextLost()) { return; }
    programs = { wire: program(gl, WIRE), solid: program(gl, SOLID) };
    items = itemsOf(gl, one);
    gl.enable(gl.DEPTH_TEST);
  }
  function clear() {
    items.forEach(function (item) { item.free(); });
    if (programs) { gl.deleteProgram(programs.wire.linked); gl.deleteProgram(programs.solid.linked); }
  }
  function directions() {
    const [ca, sa, ce, se] = [Math.cos(view.azimuth), Math.sin(view.azimuth), Math.cos(view.elevation), Math.sin(view.elevation)];
    return { right: [ca, 0, -sa], up: [-se * sa, ce, -se * ca], eye: [sa * ce, se, ca * ce] };
  }
  function draw() {
    const usual = Math.min(window.devicePixelRatio || 1, MOST_PIXELS), ratio = soft ? usual * (mode === "rest" ? 2 : 1) : mode === "film" ? 2 : usual, [wide, high] = [box.clientWidth, box.clientHeight].map(function (size) { return Math.max(2, Math.round(ratio * size)); });
    if (canvas.width !== wide || canvas.height !== high) { canvas.width = wide; canvas.height = high; }
    const { right, up, eye } = directions(), [x0, y0, x1, y1, depth] = extents, away = Math.abs(right[2]), near = Math.abs(right[0]);
    const across = (x1 - x0) * near + 2 * depth * away, tall = (y1 - y0) * up[1] + ((x1 - x0) * away + 2 * depth * near) * Math.abs(eye[1]), reach = 2 * Math.hypot(x1 - x0, y1 - y0, 2 * depth) + Math.hypot(...view.shift);
    half = 0.53 * Math.max(tall, across * high / wide) / view.zoom;
    const light = [eye[0] + 0.5 * eye[2], eye[1] + 0.8, eye[2] - 0.5 * eye[0]], size = Math.hypot(...light);
    gl.viewport(0, 0, wide, high); gl.clearColor(0, 0, 0, 0); gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    items.forEach(function (item) {
      const { linked, where } = item.wire ? programs.wire : programs.solid;
      gl.useProgram(linked);
      gl.uniformMatrix3fv(where.axes, false, [...right, ...up, ...eye]);
      gl.uniform3f(where.middle, (x0 + x1) / 2 + view.shift[0], (y0 + y1) / 2 + view.shift[1], view.shift[2]);
      gl.uniform3f(where.scale, high / wide / half, 1 / half, -1 / reach);
      gl.uniform3f(where.pose, ...item.pose(place)); gl.uniform3f(where.plain, ...item.colour);
      gl.uniform3f(where.eye, ...eye); gl.uniform3f(where.light, ...light.map(function (part) { return part / size; })); gl.uniform1i(where.wire, item.wire ? 1 : 0);
      item.move(where, place, key);
      gl.bindVertexArray(item.mesh.array);
      gl.drawElements(gl.TRIANGLES, item.mesh.count, gl.UNSIGNED_INT, 0);
    });
  }
  function turn(sideways, upwards) { view.azimuth += sideways; view.elevation = Math.max(-1.5, Math.min(1.5, view.elevation + upwards)); changed(); }
  function pan(sideways, downwards) {
    const { right, up } = directions(), mm = 2 * half / (canvas.clientHeight || 1);
    view.shift = view.shift.map(function (part, axis) { return part + mm * (downwards * up[axis] - sideways * right[axis]); });
    changed();
  }
  function zoom(factor) { view.zoom = Math.max(0.5, Math.min(20, view.zoom * factor)); changed(); }
  function whole() { extents = extent(one); Object.assign(view, home); changed(); }
  listen(canvas, turn, pan, zoom, whole);
  canvas.addEventListener("webglcontextlost", function (event) { event.preventDefault(); });
  canvas.addEventListener("webglcontextrestored", function () { build(); changed(); });
  box.append(canvas);
  return {
    canvas: canvas, turn: turn, zoom: zoom, whole: whole, draw: draw,
    look: function (box) { if (box[2] > box[0]) { extents = box; Object.assign(view, { zoom: 1, shift: [0, 0, 0] }); changed(); } },
    show: function (run) {
      clear();
      one = run; home.azimuth = one.bodies.length ? 0.32 : 0.45; home.elevation = one.bodies.length ? 0.2 : 0.3;
      build(); whole();
    },
    move: function (to, colour, aim) { place = to; key = colour; mode = aim; },  // "rest", "play" or "film"
    destroy: function () { clear(); const lose = gl.getExtension("WEBGL_lose_context"); if (lose) { lose.loseContext(); } },
  };
}
