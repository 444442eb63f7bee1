// The nodes of a search that is stepped through: rings around those that may be next, and g, h and f
// of the one that is pointed at, in the scene or in the table. Positions are those of the clouds.
window.abiNodes = {
  REACH: {mouse: 14, touch: 26},  // [px] from a node within which it is meant
  KINDS: ["closed", "open"],
  numbers: null,  // as app/layers/search_step.py sends them
  pointer: null,  // where the pointer is over the scene [px], and its reach
  row: null,  // place [unit] of the node of the row that is pointed at
  pointed: "",  // place of the node that is told of, as a text

  show(numbers) {
    const decode = text => new Float32Array(Uint8Array.from(atob(text), letter => letter.charCodeAt(0)).buffer);
    for (const kind of numbers ? this.KINDS : []) numbers[kind] = decode(numbers[kind]);
    this.numbers = numbers;
    this.draw();
  },

  // Each drawn node: its number, kind, place [unit], place on the screen [px] and depth.
  *each() {
    const {nodeRefFromName, camera, canvas} = window.__viserMutable, nodes = window.__viserSceneTree.getState();
    const view = canvas.getBoundingClientRect();
    for (const kind of this.KINDS) {
      const cloud = nodes[`/theatre/${kind}`], group = nodeRefFromName[`/theatre/${kind}`];
      const points = cloud?.message.props.points;
      // numbers may come a moment before the points that they are of
      if (!group || !points || 2 * points.length !== 3 * this.numbers[kind].length) continue;
      const vector = group.position.clone();
      for (let k = 0; 3 * k < points.length; k++) {
        const place = points.subarray(3 * k, 3 * k + 3);
        group.localToWorld(vector.set(...place)).project(camera);
        if (vector.z > 1) continue;
        const x = view.width * (1 + vector.x) / 2, y = view.height * (1 - vector.y) / 2;
        yield {kind, k, place, x, y, depth: vector.z, view};
      }
    }
  },

  pointerMoved(event) {
    if (!this.numbers || event.buttons > 1 || (event.type === "pointermove" && event.buttons)) return;
    const row = event.target.closest?.("tr")?.querySelector("[data-place]");
    this.row = row ? this.place(row) : null;
    const {canvas} = window.__viserMutable, view = canvas.getBoundingClientRect();
    this.pointer = event.target !== canvas ? null : {
      x: event.clientX - view.left, y: event.clientY - view.top, reach: this.REACH[event.pointerType] ?? this.REACH.mouse,
    };
    this.draw();
  },

  place(part) { return part.dataset.place.split(" ").map(Number); },
  same(place, other) { return place.every((x, axis) => Math.abs(x - other[axis]) <= 1e-4 * (1 + Math.abs(x))); },

  // The node of the row, or, of several near the pointer, the one in front.
  meant(nodes) {
    // of a node that both ends have reached, the one that waits
    if (this.row) return nodes.filter(node => this.same(this.row, node.place)).at(-1);
    if (!this.pointer) return undefined;
    const {x, y, reach} = this.pointer, away = node => Math.hypot(node.x - x, node.y - y);
    const near = nodes.filter(node => away(node) <= reach), least = Math.min(...near.map(away));
    return near.filter(node => away(node) <= Math.max(2 * least, reach / 3)).sort((a, b) => a.depth - b.depth)[0];
  },

  // The row of the node that is told of.
  mark(node) {
    const pointed = node ? String(node.place) : "";
    if (pointed === this.pointed && !document.querySelector("[data-place]:not([data-marked])")) return;
    this.pointed = pointed;
    for (const part of document.querySelectorAll("[data-place]")) {
      part.dataset.marked = "";
      part.closest("tr").classList.toggle("abi-pointed", Boolean(node && this.same(this.place(part), node.place)));
    }
  },

  // Again after each picture: the camera may have turned.
  draw() {
    const root = document.getElementById("abi-overlay");
    if (!root) return;
    let svg = root.querySelector(".abi-rings"), card = root.querySelector(".abi-node");
    if (!this.numbers) {
      svg?.remove();
      card?.remove();
      return;
    }
    if (!svg) {
      root.insertAdjacentHTML("afterbegin", `<svg class="abi-rings"></svg><div class="abi-node abi-card" hidden></div>`);
      [svg, card] = [root.querySelector(".abi-rings"), root.querySelector(".abi-node")];
    }
    const ringed = new Set(this.numbers.ringed), nodes = [...this.each()], pointed = this.meant(nodes);
    const circles = nodes.filter(node => node.kind === "open" && ringed.has(node.k)).map(node => this.circle(node, ""));
    this.mark(pointed);
    if (pointed) circles.push(this.circle(pointed, "abi-pointed"));
    svg.innerHTML = circles.join("");
    card.hidden = !pointed;
    if (!pointed) return;
    const text = this.text(pointed);
    if (card.innerHTML !== text) card.innerHTML = text;
    const {width, height} = card.getBoundingClientRect();
    // at the other side of the scene: beside the node it would cover its neighbours
    const left = pointed.x > pointed.view.width / 2 ? 10 : pointed.view.width - width - 10;
    const top = Math.min(Math.max(pointed.y - height / 2, 4), pointed.view.height - height - 4);
    card.style.transform = `translate(${left}px, ${top}px)`;
  },

  circle({x, y, place, view}, kind) {
    const {camera, nodeRefFromName} = window.__viserMutable, group = nodeRefFromName["/theatre/open"];
    const away = group.localToWorld(group.position.clone().set(...place)).distanceTo(camera.position);
    const scale = view.height / (2 * Math.tan(camera.fov * Math.PI / 360) * away);
    const radius = Math.max(this.numbers.size * scale / 2 + (kind ? 6 : 3), 7);
    return `<circle class="${kind}" cx="${x.toFixed(1)}" cy="${y.toFixed(1)}" r="${radius.toFixed(1)}"/>`;
  },

  text({kind, k}) {
    const {formula, factors, ringed, unit} = this.numbers, [g, h] = this.numbers[kind].subarray(2 * k, 2 * k + 2);
    const written = x => x.toFixed(3).replace("-", "\u2212");
    const rows = [["g so far", written(g)], ["h to go", written(h)]];
    if (factors) rows.push([`f = ${formula}`, written(factors[0] * g + factors[1] * h)]);
    const state = kind === "closed" ? "visited" : ringed.includes(k) ? "waits, may be next" : "waits";
    const lines = rows.map(([name, number]) => `<tr><td>${name}</td><td>${number}</td></tr>`);
    return `<b>${state}</b> [${unit}]<table>${lines.join("")}</table>`;
  },
};
window.abiNodes.draw();
for (const name of ["pointermove", "pointerdown"]) {
  const options = {capture: true, passive: true, signal: window.abiListeners.signal};
  document.addEventListener(name, event => window.abiNodes.pointerMoved(event), options);
}
