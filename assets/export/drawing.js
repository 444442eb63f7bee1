// Draws a plan in three dimensions on a canvas, without a library or a graphics card.
const canvas = document.getElementById("canvas"), pen = canvas.getContext("2d");
const state = { step: 0, share: 0, playing: false, turn: -0.48, tilt: 0.38, zoom: 1, draw: [], search: null, drawn: 0 };
window.abiPage = state;

let centre, size;
function fit() {
  const [low, high] = plan.box;
  centre = low.map((x, i) => (x + high[i]) / 2); size = Math.hypot(...high.map((x, i) => x - low[i]));
}

function project(p) {
  const x = p[0] - centre[0], y = p[1] - centre[1], z = p[2] - centre[2];
  const c = Math.cos(state.turn), s = Math.sin(state.turn), u = Math.cos(state.tilt), v = Math.sin(state.tilt);
  const right = -s * x + c * y, depth = c * x + s * y, up = u * z - v * depth;
  const away = 1.5 * size / state.zoom - (u * depth + v * z);
  const scale = 1.25 * Math.min(canvas.width, canvas.height) / Math.max(away, 0.05 * size);
  return [canvas.width / 2 + right * scale, canvas.height / 2 - up * scale, away, scale];
}

// Everything drawn is a line, a dot or a face; the farthest comes first.
const items = [];
function line(a, b, colour, width, alpha = 1) {
  const p = project(a), q = project(b);
  items.push([(p[2] + q[2]) / 2, () => {
    pen.globalAlpha = alpha; pen.strokeStyle = colour; pen.lineWidth = width * (width < 0 ? -(p[3] + q[3]) / 2 : devicePixelRatio);
    pen.lineCap = "round"; pen.beginPath(); pen.moveTo(p[0], p[1]); pen.lineTo(q[0], q[1]); pen.stroke();
  }]);
}
function lines(points, colour, width) { for (let k = 1; k < points.length; k++) line(points[k - 1], points[k], colour, width); }
function dot(a, colour, radius) {
  const p = project(a);
  items.push([p[2], () => { pen.globalAlpha = 1; pen.fillStyle = colour; pen.beginPath(); pen.arc(p[0], p[1], radius * p[3], 0, 7); pen.fill(); }]);
}
function face(a, b, c) {
  const p = project(a), q = project(b), r = project(c);
  const n = [0, 1, 2].map(i => (b[(i + 1) % 3] - a[(i + 1) % 3]) * (c[(i + 2) % 3] - a[(i + 2) % 3]) - (b[(i + 2) % 3] - a[(i + 2) % 3]) * (c[(i + 1) % 3] - a[(i + 1) % 3]));
  const light = 0.55 + 0.45 * Math.abs((0.5 * n[0] - 0.3 * n[1] + 0.8 * n[2]) / (Math.hypot(...n) || 1));
  items.push([(p[2] + q[2] + r[2]) / 3, () => {
    pen.globalAlpha = 0.62; pen.fillStyle = `rgb(${205 * light},${117 * light},${79 * light})`;
    pen.beginPath(); pen.moveTo(p[0], p[1]); pen.lineTo(q[0], q[1]); pen.lineTo(r[0], r[1]); pen.fill();
  }]);
}
function box() {
  const corner = k => [0, 1, 2].map(i => (k >> i) & 1 ? plan.workspace[1][i] : plan.workspace[0][i]);
  for (let a = 0; a < 8; a++) for (const bit of [1, 2, 4]) if (!(a & bit)) line(corner(a), corner(a | bit), "#808a96", 1.2);
}
function rainbow(share) {
  const stops = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [240, 210, 40]];
  const place = share * 4, k = Math.min(Math.floor(place), 3), part = place - k;
  return `rgb(${stops[k].map((x, i) => Math.round(x + part * (stops[k + 1][i] - x)))})`;
}

const draws = {
  obstacles() { for (const [a, b, c] of plan.faces) face(a, b, c); },
  edges() { for (const [a, b] of plan.edges) line(plan.nodes[a], plan.nodes[b], "#7890ac", 0.8, 0.45); },
  nodes() { for (const p of plan.nodes) dot(p, "#7890ac", 0.005 * size); },
  removed() { for (const p of plan.removed) dot(p, "#966048", 0.006 * size); },
  mesh() { draws.edges(); draws.removed(); },
  search() {
    if (state.search && state.share === state.search.share && state.share < 1) { draws.step(); return; }
    const { order, path } = state.search || plan, count = Math.round(state.share * order.length);
    for (let k = 0; k < count; k++) dot(order[k], rainbow(k / order.length), 0.009 * size);
    if (count === order.length) lines(path, "#1f84d6", 4);
  },
  step() {
    const { visited, waiting, trail } = state.search;
    for (const p of visited) dot(p, "#546e9e", 0.009 * size);
    waiting.forEach((p, k) => { const share = k / waiting.length; dot(p, `rgb(${236 * (1 - share)},${178 - 66 * share},${84 * share})`, 0.009 * size); });
    lines(trail, "#c908f6", 4); if (trail.length) dot(trail[trail.length - 1], "#c908f6", 0.012 * size);
  },
  a_star() { lines(plan.a_star, "#1f84d6", 4); },
  dijkstra() { lines(plan.dijkstra, "#2d9c6c", 4); },
  bellman_ford() { lines(plan.bellman_ford, "#c98a1b", 4); },
  path() { lines(plan.path, "#1f84d6", 4); },
  taut() { lines(plan.taut, "#00b2c8", 4); },
  bspline() { lines(plan.bspline, "#e0409a", 5); draws.control(); },
  control() { for (const p of plan.control) dot(p, "#e0409a", 0.006 * size); },
  tool() { lines(plan.arm.tool, "#6e757d", 2); },
  quadratic() { lines(plan.quadratic, "#7c4dff", 5); },
  arm() {
    const times = plan.arm.time, time = state.share * times[times.length - 1];
    let k = 0; while (k < times.length - 1 && times[k + 1] <= time) k++;
    lines(plan.arm.tool.slice(0, k + 1), "#6e757d", 3);
    plan.arm.links[k].forEach((link, i) => line(link[0], link[1], plan.arm.touching[k].includes(i) ? "#d64541" : i % 2 ? "#5c6b7a" : "#76869a", -2 * plan.arm.radii[i]));
  },
};

function draw() {
  const ratio = devicePixelRatio || 1;
  canvas.width = canvas.clientWidth * ratio; canvas.height = canvas.clientHeight * ratio;
  items.length = 0; box();
  dot(plan.start, "#3fa34d", 0.012 * size); dot(plan.goal, "#d64541", 0.012 * size);
  for (const name of state.draw) draws[name]();
  items.sort((a, b) => b[0] - a[0]).forEach(item => item[1]());
  state.drawn = items.length;
}

canvas.onpointerdown = e => { canvas.setPointerCapture(e.pointerId); };
canvas.onpointermove = e => { if (e.buttons) { state.turn -= e.movementX / 180; state.tilt = Math.max(-1.5, Math.min(1.5, state.tilt + e.movementY / 180)); draw(); } };
canvas.addEventListener("wheel", e => { e.preventDefault(); state.zoom = Math.max(0.3, Math.min(6, state.zoom * Math.exp(-e.deltaY / 700))); draw(); }, { passive: false });
addEventListener("resize", draw);
