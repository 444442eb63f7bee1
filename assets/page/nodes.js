// The nodes of a search that is stepped through: rings around those that may be next, letters at those
// to compare where one is asked, and g, h and f of the one that is pointed at, in the scene or in the
// table. Positions are those of the clouds.
window.abiNodes = {
  REACH: {mouse: 14, touch: 26},  // [px] from a node within which it is meant
  KINDS: ["closed", "open"],
  MOST_KEPT_FREE: 150,  // waiting nodes that no letter covers; of more there is no place for one
  numbers: null,  // as app/layers/search_step.py sends them
  pointer: null,  // where the pointer is over the scene [px], and its reach
  row: null,  // place [unit] of the node of the row that is pointed at
  pointed: "",  // place of the node that is told of, as a text

  show(numbers) {
    const decode = text => new Float32Array(Uint8Array.from(atob(text), letter => letter.charCodeAt(0)).buffer);
    for (const kind of numbers ? this.KINDS : []) numbers[kind] = decode(numbers[kind]);
    if (numbers?.line) numbers.line = decode(numbers.line);
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
      if (!group || !points || points.length !== this.numbers[kind].length) continue;
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
    const row = event.target.closest?.("tr, .abi-letter"), place = row?.matches("tr") ? row.querySelector("[data-place]") : row;
    this.row = place ? this.place(place) : null;
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
      part.closest("tr, .abi-letter").classList.toggle("abi-pointed", Boolean(node && this.same(this.place(part), node.place)));
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
      this.showLetters(root, []);
      return;
    }
    if (!svg) {
      root.insertAdjacentHTML("afterbegin", `<svg class="abi-rings"></svg><div class="abi-node abi-card" hidden></div>`);
      [svg, card] = [root.querySelector(".abi-rings"), root.querySelector(".abi-node")];
    }
    const ringed = new Set(this.numbers.ringed), nodes = [...this.each()], pointed = this.meant(nodes);
    const circles = nodes.filter(node => node.kind === "open" && ringed.has(node.k)).map(node => this.circle(node, ""));
    circles.push(...this.placeLetters(root));
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

  // One button for each letter, the same one while letters and numbers stay: a click has to end on it.
  showLetters(root, letters) {
    const html = letters.map(({letter, number, place}) => `<button class="abi-letter abi-card" data-place="${place.join(" ")}"
      data-choose="${this.numbers.answer}" data-value="${letter}"><b>${letter}</b> ${number}</button>`).join("");
    let box = root.querySelector(".abi-letters");
    if (box?.shown === html || (!box && !html)) return box;
    if (!box) root.prepend(box = Object.assign(document.createElement("div"), {className: "abi-letters"}));
    [box.innerHTML, box.shown] = [html, html];
    return box;
  },

  // Put the letters beside their nodes, where they cover neither each other nor a node; lines lead there.
  placeLetters(root) {
    const {letters} = this.numbers, buttons = [...this.showLetters(root, letters)?.children ?? []];
    if (!buttons.length) return [];
    const {nodeRefFromName, camera, canvas} = window.__viserMutable, group = nodeRefFromName["/theatre/open"];
    const view = canvas.getBoundingClientRect(), {abiLabels} = window;
    if (!group) return [];
    const taken = abiLabels.written(view);
    for (const {box: [a, b, c, d], shift: [x, y] = [0, 0]} of abiLabels.seen(view)) taken.push([a + x, b + y, c + x, d + y]);
    const nodes = [...this.each()].filter(node => node.kind === "open").map(({x, y}) => [x - 6, y - 6, x + 6, y + 6]);
    if (nodes.length <= this.MOST_KEPT_FREE) taken.push(...nodes);
    return letters.map(({place}, k) => {
      const seen = group.localToWorld(group.position.clone().set(...place)).project(camera);
      const x = view.width * (1 + seen.x) / 2, y = view.height * (1 - seen.y) / 2;
      const {offsetWidth: width, offsetHeight: height} = buttons[k], left = x + 12, top = y - height / 2;
      const [right, down] = abiLabels.free({box: [left, top, left + width, top + height]}, taken, view);
      const [a, b] = [left + right, top + down];
      taken.push([a - 3, b - 3, a + width + 3, b + height + 3]);
      buttons[k].style.transform = `translate(${a.toFixed(1)}px, ${b.toFixed(1)}px)`;
      const [u, v] = [Math.min(Math.max(x, a), a + width), Math.min(Math.max(y, b), b + height)];
      return `<line x1="${x.toFixed(1)}" y1="${y.toFixed(1)}" x2="${u.toFixed(1)}" y2="${v.toFixed(1)}"/>`;
    });
  },

  circle({x, y, place, view}, kind) {
    const {camera, nodeRefFromName} = window.__viserMutable, group = nodeRefFromName["/theatre/open"];
    const away = group.localToWorld(group.position.clone().set(...place)).distanceTo(camera.position);
    const scale = view.height / (2 * Math.tan(camera.fov * Math.PI / 360) * away);
    const radius = Math.max(this.numbers.size * scale / 2 + (kind ? 6 : 3), 7);
    return `<circle class="${kind}" cx="${x.toFixed(1)}" cy="${y.toFixed(1)}" r="${radius.toFixed(1)}"/>`;
  },

  text({kind, k}) {
    const {formula, decimals, line, ringed, unit} = this.numbers, [g, h, f] = this.numbers[kind].subarray(3 * k, 3 * k + 3);
    const written = x => x.toFixed(decimals).replace("-", "\u2212");
    const rows = [["g so far", written(g)], ["h to go", written(h)]];
    if (formula && formula !== "g") rows.push([`f = ${formula}`, written(f)]);
    if (line && kind === "open") rows.push(["no. in line", String(line[k])]);
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
