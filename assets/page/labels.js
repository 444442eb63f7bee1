// Labels in the scene keep apart on the screen, from wherever one looks: one that would lie over
// another, over the curve that the arm follows or its ends, or below what is written over the scene,
// stands a little beside its place.
window.abiLabels = {
  EM: 12,  // [px] of a label of scale 1, and its font: viser's
  FONT: '16px -apple-system, BlinkMacSystemFont, "Segoe UI", "Roboto", "Helvetica Neue", Arial, sans-serif',
  PADDING: 0.2,  // of a line's height, around the text
  GAP: [16, 6],  // [px] between two labels, beside and above each other: less, and two read as one
  STEP: [9, 6],  // [px] between two places that are tried
  FARTHEST: 14,  // steps to each side
  KEPT_FREE: 3,  // [px] to each side of a point of the curve
  STAYS: 12,  // [px] by which a label may be farther from its place than it need be, so that it rests

  placed: new Map(),  // by name: position as the server gave it, as it was set here, and shift [px]
  sizes: new Map(),

  // Ground and letters of labels, as viser draws them and on the dark page.
  LIGHT: ["vec4(1.0, 1.0, 1.0, 0.85 * vAlpha)", "vec4(0.0, 0.0, 0.0, a)"],
  DARK: ["vec4(0.15, 0.15, 0.15, 0.85 * vAlpha)", "vec4(0.92, 0.92, 0.92, a)"],

  // What draws labels: the only meshes with their table of places.
  materials() {
    let root = window.__viserMutable.nodeRefFromName[""];
    while (root?.parent) root = root.parent;
    return (root?.children ?? []).flatMap(group => group.children.map(part => part.material))
      .filter(material => material?.uniforms?.uLabelData);
  },

  // Labels are dark on the dark page, as everything else there.
  tint() {
    const isDark = document.documentElement.dataset.mantineColorScheme === "dark";
    const [from, to] = isDark ? [this.LIGHT, this.DARK] : [this.DARK, this.LIGHT];
    let changed = false;
    for (const material of this.materials()) {
      const shader = from.reduce((text, colour, k) => text.replace(colour, to[k]), material.fragmentShader);
      if (shader === material.fragmentShader) continue;
      material.fragmentShader = shader;
      material.needsUpdate = changed = true;
    }
    if (changed) window.__viserMutable.requestRender();
  },

  // Width and height [px] of a label's background.
  size(text, scale) {
    const key = `${scale} ${text}`;
    if (!this.sizes.has(key)) {
      if (this.sizes.size > 500) this.sizes.clear();
      this.context ??= document.createElement("canvas").getContext("2d");
      this.context.font = this.FONT;
      const factor = this.EM * scale / 16, lines = text.split("\n");
      const probe = this.context.measureText("Mgj");
      const line = factor * (probe.fontBoundingBoxAscent + probe.fontBoundingBoxDescent);
      const width = Math.max(...lines.map(part => factor * this.context.measureText(part).width));
      this.sizes.set(key, [width + this.PADDING * line, line * (lines.length + this.PADDING)]);
    }
    return this.sizes.get(key);
  },

  // Places to try, the nearest first.
  get shifts() {
    const found = [], far = this.FARTHEST, [dx, dy] = this.STEP;
    for (let i = -far; i <= far; i++) {
      for (let j = -far; j <= far; j++) found.push([dx * i, dy * j]);
    }
    found.sort((a, b) => this.cost(a) - this.cost(b));
    Object.defineProperty(this, "shifts", {value: found});
    return found;
  },

  // What stays where it is goes first: numbers of obstacles, start and goal, then the others.
  order(name) {
    return name.endsWith("/number") ? 0 : /^\/(start|goal)\//.test(name) ? 1 : 2;
  },

  // The labels that are seen: name, box at the server's place, and the place in the scene.
  seen(view) {
    const {nodePoseData, nodeRefFromName, camera} = window.__viserMutable;
    const found = [];
    for (const [name, node] of Object.entries(window.__viserSceneTree.getState())) {
      if (node?.message?.type !== "LabelMessage" || !node.effectiveVisibility) continue;
      const {text, anchor, font_screen_scale: scale} = node.message.props;
      const pose = nodePoseData[name], parent = nodeRefFromName[name.slice(0, name.lastIndexOf("/"))];
      if (!text || !pose || !parent) continue;
      const known = this.placed.get(name);
      const base = known && known.set === pose.position ? known.base : pose.position;
      const place = parent.localToWorld(parent.position.clone().set(...base)).project(camera);
      if (place.z > 1) continue;
      const [width, height] = this.size(text, scale), [vertical, horizontal] = anchor.split("-");
      const x = view.width * (1 + place.x) / 2 - width * {left: 0, center: 0.5, right: 1}[horizontal];
      const y = view.height * (1 - place.y) / 2 - height * {top: 0, center: 0.5, bottom: 1}[vertical];
      if (x > view.width || y > view.height || x + width < 0 || y + height < 0) continue;
      found.push({name, pose, parent, place, base, shift: known?.shift, box: [x, y, x + width, y + height]});
    }
    return found.sort((a, b) => this.order(a.name) - this.order(b.name));
  },

  // Boxes of what is written over the scene, [px] from its corner.
  written(view) {
    const parts = [...document.querySelectorAll("#abi-overlay [data-part] > *")];
    return parts.map(part => part.getBoundingClientRect()).filter(box => box.width > 0)
      .map(box => [box.left - view.left, box.top - view.top, box.right - view.left, box.bottom - view.top]);
  },

  // Boxes around points of the curve that the arm follows, and around its ends, [px].
  curve(view) {
    const {nodeRefFromName: nodes, camera} = window.__viserMutable, far = this.KEPT_FREE;
    const [ends, along] = window.abiSight?.targets(nodes, window.__viserSceneTree.getState()) ?? [[], []];
    return [...ends.slice(0, 2), ...along].map(point => {
      const {x, y} = point.project(camera), left = view.width * (1 + x) / 2, top = view.height * (1 - y) / 2;
      return [left - far, top - far, left + far, top + far];
    });
  },

  // Again after each picture that is drawn, since a camera that turns or a name that is new would
  // leave two over each other until the next round.
  watch({scene}) {
    if (!scene || scene === this.scene) return;
    this.scene = scene;
    scene.onAfterRender = () => (window.abiLabels.place(), window.abiNodes.draw());
  },

  place() {
    const viser = window.__viserMutable;
    if (!viser?.camera || !viser.canvas || !window.__viserSceneTree) return;
    this.watch(viser);
    this.tint();
    const view = viser.canvas.getBoundingClientRect();
    viser.camera.updateMatrixWorld();
    const labels = this.seen(view), taken = this.written(view), kept = this.curve(view);
    let moved = false;
    for (const label of labels) {
      const shift = this.free(label, taken, view, kept);
      const [a, b, c, d] = label.box, [x, y] = shift;
      const [beside, above] = this.GAP;
      taken.push([a + x - beside, b + y - above, c + x + beside, d + y + above]);
      moved = this.move(label, shift, view) || moved;
    }
    if (moved) viser.requestRender();
  },

  // Distance of a shift [px]; sideways counts less, since text is wide.
  cost([x, y]) { return Math.hypot(0.8 * x, y); },

  // The least shift to where nothing is, nor what is to be kept free if that goes, too; the last one
  // while none is much less.
  free({box: [a, b, c, d], shift}, taken, view, kept = []) {
    const beside = boxes => ([x, y]) => boxes.every(([e, f, g, h]) => c + x <= e || g <= a + x || d + y <= f || h <= b + y);
    const [apart, clear] = [beside(taken), beside(kept)];
    const fits = ([x, y]) => a + x >= 0 && c + x <= view.width && b + y >= 0 && d + y <= view.height && apart([x, y]);
    let least;
    for (const place of [[0, 0], ...this.shifts]) {
      if (!fits(place)) continue;
      const open = clear(place);
      if (open || !least) least = {place, open};
      if (open) break;
    }
    if (!least) return [0, 0];
    const stays = shift && this.cost(shift) <= this.cost(least.place) + this.STAYS && fits(shift) && (clear(shift) || !least.open);
    return stays && this.cost(least.place) > 0 ? shift : least.place;
  },

  // Put a label beside its place; whether that is news.
  move({name, pose, parent, place, base, shift: before}, shift, view) {
    const [x, y] = shift;
    if (x === 0 && y === 0) {
      this.placed.delete(name);
      if (pose.position === base) return false;
      Object.defineProperty(pose, "position", {value: base, writable: true, enumerable: true, configurable: true});
    } else {
      const moved = place.clone();
      moved.x += 2 * x / view.width;
      moved.y -= 2 * y / view.height;
      const set = parent.worldToLocal(moved.unproject(window.__viserMutable.camera)).toArray();
      if (pose.position !== base && set.every((value, k) => Math.abs(value - pose.position[k]) < 1e-6)) return false;
      this.placed.set(name, {base, set, shift});
      this.follow(name, pose);
    }
    pose.poseUpdateState = "needsUpdate";
    return true;
  },

  // Have a shifted label keep its shift when the server moves it, until all are placed anew: it would
  // lie over another for a moment.
  follow(name, pose) {
    const {placed} = this;
    let position = placed.get(name).set;
    const move = place => {
      const known = window.abiLabels === this && placed.get(name);
      position = place;
      if (!known) return;
      position = place.map((value, k) => value + known.set[k] - known.base[k]);
      placed.set(name, {base: place, set: position, shift: known.shift});
    };
    Object.defineProperty(pose, "position", {get: () => position, set: move, enumerable: true, configurable: true});
  },
};
clearInterval(window.abiPlacing);
window.abiPlacing = setInterval(() => window.abiLabels.place(), 120);
window.abiLabels.place();
