// What the server asks of a page and viser has no message for; app/ui/page.py sends it to every tab.
window.abi?.clear?.();
if (window.abi) window.abi.motion = null;  // of the server before
window.abi = {
  KEY: "abi-tab",
  LESSONS: "abi-lessons",
  TEACH: "abi-teach",
  STUDENT: "abi-student",
  LONGEST: 3_000_000,  // letters of a state that the server takes

  // Set a widget as a hand would.
  send(uuid, value) {
    window.__viserMutable.sendMessage({type: "GuiUpdateMessage", uuid, updates: {value}});
  },

  // Check if the browser draws without a graphics card: there each kind of surface takes half a second
  // at first, and several with shadows and surroundings.
  drawsInSoftware() {
    const gl = window.__viserMutable.canvas?.getContext("webgl2");
    const names = gl?.getExtension("WEBGL_debug_renderer_info");
    return !!names && /swiftshader|llvmpipe|softpipe|software|basic render/i.test(gl.getParameter(names.UNMASKED_RENDERER_WEBGL));
  },

  // Answer with what the tab remembers and what its address asks for. A link's state is taken out
  // of the address: from then on the tab remembers it, and a reload keeps what was changed since.
  // So is the teacher's secret, which a projector would show to the class.
  report(uuid) {
    const url = new URL(location.href), link = url.searchParams.get("state");
    const query = Object.fromEntries(url.searchParams);
    delete query.state;
    let state = null, lessons = null, student = "";
    try {
      state = sessionStorage.getItem(this.KEY);
      lessons = localStorage.getItem(this.LESSONS);
      query.teach ??= sessionStorage.getItem(this.TEACH) ?? "";
      sessionStorage.setItem(this.TEACH, query.teach);
      student = localStorage.getItem(this.STUDENT) ??
        Array.from(crypto.getRandomValues(new Uint32Array(4)), part => part.toString(36)).join("");
      localStorage.setItem(this.STUDENT, student);
      url.searchParams.delete("teach");
    } catch {}
    url.searchParams.delete("state");
    if (url.href !== location.href) history.replaceState(history.state, "", url);
    if (link !== null) this.remember(link);
    const kept = link ?? state ?? "", fits = kept.length <= this.LONGEST;
    this.send(uuid, JSON.stringify({
      state: fits ? kept : "",
      oversize: fits ? 0 : kept.length,
      student,
      lessons: lessons ?? "",
      query,
      dark: matchMedia("(prefers-color-scheme: dark)").matches,
      software: this.drawsInSoftware(),
    }));
  },

  // Tell the server what panels and text leave to the scene, and whether the tab with the plots has
  // been opened: see app/ui/page_area.py.
  watch([uuid, label, plots]) {
    this.watched = {uuid, label, plots, told: ""};
    this.tellArea();
  },
  tellArea() {
    this.foldSheet();
    this.liftScene();
    const canvas = window.__viserMutable?.canvas?.getBoundingClientRect();
    if (!this.watched || !canvas?.height) return;
    const edges = (part, edge) => [...document.querySelectorAll(`#abi-overlay .abi-${part} > *`)]
      .map(each => each.getBoundingClientRect()).filter(box => box.height > 0).map(box => box[edge]);
    const covered = part => Math.min(Math.max(part / canvas.height, 0), 1).toFixed(2);
    this.plots ||= [...document.querySelectorAll("[role=tab][aria-selected=true]")]
      .some(tab => tab.textContent === this.watched.plots);
    const area = JSON.stringify({
      hidden: document.hidden,
      plots: this.plots,
      width: innerWidth,
      height: Math.round(canvas.height),
      left: Math.max(Math.round(canvas.left), 0),
      right: Math.max(Math.round(innerWidth - canvas.right), 0),
      above: covered(Math.max(canvas.top, ...edges("top", "bottom")) - canvas.top),
      below: covered(canvas.bottom - Math.min(canvas.bottom, ...edges("bottom", "top"))),
    });
    if (area === this.watched.told) return;
    this.watched.told = area;
    this.send(this.watched.uuid, area);
  },

  // Keep a text for as long as the tab lives, whatever becomes of page and server.
  remember(text) {
    try { sessionStorage.setItem(this.KEY, text); } catch {}
  },

  // Keep the progress in lessons past the tab's end.
  rememberLessons(text) {
    try { localStorage.setItem(this.LESSONS, text); } catch {}
  },

  // Put a link to the page with this state on the clipboard; where that is forbidden, show it.
  async copyLink(text) {
    const url = new URL(location.href);
    url.searchParams.delete("teach");
    url.searchParams.set("state", text);
    try { await navigator.clipboard.writeText(url.href); }
    catch { prompt("Copy this link:", url.href); }
  },

  // The layer over the scene: text and a few controls, between which the mouse reaches the scene.
  // Made again, with all that it showed, wherever viser makes the scene's element again.
  parts: {},
  time: 0,  // of the motion, as it is shown, [s]
  playing: false,
  overlay() {
    let root = document.getElementById("abi-overlay");
    if (root) return root;
    let host = window.__viserMutable.canvas;
    while (host !== document.body && getComputedStyle(host).position !== "absolute") {
      host = host.parentElement;
    }
    root = document.createElement("div");
    root.id = "abi-overlay";
    root.innerHTML = `<div class="abi-top"><div data-part="message"></div>
      <div data-part="tools"></div><div data-part="contact"></div><div data-part="tour"></div>
      <div data-part="challenge"></div><div data-part="class"></div></div>
      <div class="abi-bottom"><div data-part="lecture"></div>
      <div data-part="numbers"></div><div data-part="player"></div>
      <div data-part="marks"></div></div>`;
    for (const [part, html] of Object.entries(this.parts)) {
      root.querySelector(`[data-part=${part}]`).innerHTML = html;
    }
    root.addEventListener("click", event => {
      const button = event.target.closest("[data-press]");
      if (button) this.send(button.dataset.press, true);
    });
    root.addEventListener("input", event => {
      const uuid = event.target.dataset.set;
      if (uuid) this.send(uuid, Number(event.target.value));
    });
    host.append(root);
    this.edges?.disconnect();
    this.edges = new ResizeObserver(() => this.placeNotices(root));
    for (const part of [root, ...root.querySelectorAll(".abi-top, .abi-bottom")]) this.edges.observe(part);
    return root;
  },
  // Notices lie between what is written over the scene above and below.
  placeNotices(root) {
    const edges = (part, edge) => [...root.querySelectorAll(`.abi-${part} > *`)]
      .map(each => each.getBoundingClientRect()).filter(box => box.height > 0).map(box => box[edge]);
    const above = Math.max(0, ...edges("top", "bottom")) + 6;
    const below = innerHeight - Math.min(innerHeight, ...edges("bottom", "top")) + 6;
    const {style} = document.documentElement;
    style.setProperty("--abi-above", `${Math.round(above)}px`);
    style.setProperty("--abi-below", `${Math.round(below)}px`);
    style.setProperty("--abi-width", `${root.clientWidth}px`);
  },
  show(part, html) {
    document.documentElement.classList.remove("abi-loading");
    this.parts[part] = html;
    this.overlay().querySelector(`[data-part=${part}]`).innerHTML = html;
  },
  // A card in a panel, or a table's row, sets a widget that is hidden itself.
  cardPressed({target}) {
    const card = target.closest?.("[data-choose]") ?? target.closest?.("tr")?.querySelector("[data-choose]");
    if (card) this.send(card.dataset.choose, card.dataset.value);
  },

  // Frame what the tour speaks of: "scene" an obstacle, "left" and "right" the panels, "player", or
  // tabs by their names; null for nothing.
  spotlight: null,
  pointOut(parts) {
    this.spotlight = parts;
    this.drawSpotlight();
  },
  spotlit(part) {
    if (part === "player") return document.querySelector("#abi-overlay .abi-player");
    if (part !== "left" && part !== "right") return [...document.querySelectorAll("[role=tab]")].find(tab => tab.textContent === part);
    const phone = innerWidth <= this.PHONE && document.querySelector(this.SHEET);
    if (phone) return phone;
    const middle = part === "left" ? 40 : innerWidth - 40;
    return document.elementsFromPoint(middle, innerHeight / 2).filter(each => each.matches(".mantine-Paper-root")).at(-1);
  },
  drawSpotlight() {
    const boxes = (this.spotlight ?? []).flatMap(part => {
      if (part === "scene") return this.obstacleBox();
      const box = this.spotlit(part)?.getBoundingClientRect();
      return box?.width ? [box] : [];
    });
    const wanted = boxes.map(({left, top, width, height}) =>
      `left:${left}px;top:${top}px;width:${width}px;height:${height}px`);
    const frames = [...document.querySelectorAll(".abi-spotlight")];
    frames.slice(wanted.length).forEach(frame => frame.remove());
    wanted.forEach((style, k) => {
      const frame = frames[k] ?? document.body.appendChild(Object.assign(document.createElement("div"), {className: "abi-spotlight"}));
      if (frame.style.cssText !== style) frame.style.cssText = style;
    });
  },
  obstacleBox() {
    const {nodeRefFromName, camera, canvas} = window.__viserMutable;
    const node = Object.entries(nodeRefFromName).find(([name, node]) => node && /^\/obstacle_\d+$/.test(name))?.[1];
    if (!node) return [];
    const place = node.localToWorld(node.position.clone().set(0, 0, 0)).project(camera), view = canvas.getBoundingClientRect();
    const size = 0.22 * Math.min(view.width, view.height);
    const left = view.left + view.width * (1 + place.x) / 2 - size / 2, top = view.top + view.height * (1 - place.y) / 2 - size / 2;
    return [{left, top, width: size, height: size}];
  },

  // What assets/page/nodes.js tells of a search's nodes; null for none.
  showNodes(numbers) { window.abiNodes.show(numbers); },
  clear() {
    this.parts = {};
    document.getElementById("abi-overlay")?.remove();
  },

  // A click into a plot over time goes to that time; a drag stays uplot's.
  pressed: null,
  plotPressed(event) {
    const over = event.target.closest?.(".u-over");
    this.pressed = over ? {over, x: event.clientX} : null;
  },
  plotClicked(event) {
    const over = event.target.closest(".u-over"), slider = document.querySelector("#abi-overlay input[type=range]");
    if (!over || !slider || this.pressed === null || Math.abs(event.clientX - this.pressed.x) > 3) return;
    const box = over.getBoundingClientRect(), left = event.clientX - box.left;
    const chart = this.charts().find(chart => chart.over === over);
    if (chart && chart.series[0].label !== "t") return;
    const part = chart ? chart.posToVal(left, "x") : left / box.width * Number(slider.max);
    const time = chart ? this.before + Math.max(part, 0) : part;
    this.send(slider.dataset.set, Math.min(Math.max(time, 0), Number(slider.max)));
  },

  // viser keeps the part of a chart that was seen, also where nobody chose one: data that come twice
  // in a moment leave a part, and a chart made anew in a bad moment has no scale at all. Here a chart
  // shows all of its data until a hand has drawn a part of it out, and again after a double click.
  zoomed: new WeakSet(),
  plotReleased(event) {
    if (this.pressed === null) return;
    const chart = this.charts().find(({over}) => over === this.pressed.over);
    if (chart && Math.abs(event.clientX - this.pressed.x) > 3) this.zoomed.add(chart);
  },
  plotReset(event) {
    const over = event.target.closest?.(".u-over");
    this.zoomed.delete(this.charts().find(chart => chart.over === over));
  },

  // What the lines of a plot are worth at the pointer. uplot writes it into the legend, which would
  // grow by it; so it is hidden there, and shown beside the pointer.
  plotHovered({target, clientX}) {
    const over = target.closest?.(".u-over");
    for (const card of document.querySelectorAll(".abi-read")) {
      if (card.parentElement !== over) card.remove();
    }
    if (over) requestAnimationFrame(() => this.tellValues(over, clientX));
  },
  tellValues(over, x) {
    const rows = [...over.closest(".uplot").querySelectorAll(".u-series:not(.u-off, :last-child)")]
      .map(row => ["label", "value"].map(part => row.querySelector(`.u-${part}`).textContent))
      .map(([name, value]) => name === "t" ? [`at ${value} s`] : [name, value]);
    over.querySelector(".abi-read")?.remove();
    if (rows.length === 0 || rows.flat().some(text => text.includes("--"))) return;
    const card = document.createElement("div"), {left, width} = over.getBoundingClientRect();
    card.className = "abi-read";
    card.classList.toggle("abi-left", x > left + width / 2);
    card.textContent = rows.map(row => row.join(" ").replace(" -", " \u2212")).join("\n");
    over.append(card);
  },
  charts() {
    return Object.values(window.__viserTestpoints?.uplots ?? {}).map(({chart}) => chart).filter(Boolean);
  },
  mendCharts() {
    for (const chart of this.charts()) {
      const [first, last] = [chart.data[0]?.[0], chart.data[0]?.at(-1)], {min, max} = chart.scales.x;
      if (first === undefined || (min != null && this.zoomed.has(chart))) continue;
      if (min == null) chart.setData(chart.data);
      else if (last > first && (min !== first || max !== last)) chart.setScale("x", {min: first, max: last});
    }
    this.mark();
  },

  // The upright line at the time shown, in every plot over time that is seen.
  mark() {
    for (const chart of this.charts()) {
      if (chart.series[0].label !== "t" || !chart.over.clientWidth) continue;
      let line = chart.over.querySelector(".abi-now");
      if (!line) {
        line = document.createElement("div");
        line.className = "abi-now";
        chart.over.append(line);
      }
      const place = chart.valToPos(this.time, "x");
      line.hidden = !(place >= 0 && place <= chart.over.clientWidth);
      if (!line.hidden) line.style.transform = `translateX(${place}px)`;
    }
  },

  // On a page that is a phone's, or becomes one, the panels are one sheet over the scene: fold it,
  // unless a hand was there first.
  folded: window.abi?.folded ?? false,
  foldSheet() {
    if (innerWidth > this.PHONE) this.folded = false;
    const sheet = !this.folded && innerWidth <= this.PHONE && document.querySelector(this.SHEET);
    if (!sheet || !(sheet.querySelector(".mantine-ScrollArea-viewport")?.clientHeight > 60)) return;
    const heading = [...sheet.querySelectorAll("div, span, p")]
      .find(part => part.childElementCount === 0 && part.textContent === this.watched?.label);
    this.folded = heading !== undefined;
    heading?.click();
  },

  // Above that sheet, open or folded, is the scene: both are seen at once.
  liftScene() {
    const sheet = innerWidth <= this.PHONE && document.querySelector(this.SHEET);
    const height = sheet ? Math.round(sheet.getBoundingClientRect().height) : 0;
    if (height === this.sheet) return;
    this.sheet = height;
    document.documentElement.style.setProperty("--abi-sheet", `${height}px`);
    this.overlay().classList.toggle("abi-squeezed", height > 100);
  },
  SHEET: '.mantine-Paper-root[style*="max-height: 60%"]',

  // Open a tab of the panels; a phone's sheet unfolds first, and then the tabs in it.
  openTab(label) {
    const leaf = fits => [...document.querySelectorAll(`${this.SHEET} :is(div, span, p)`)]
      .find(part => part.childElementCount === 0 && fits(part.textContent));
    const sheet = innerWidth <= this.PHONE && document.querySelector(this.SHEET);
    const click = part => part?.click();
    // viser listens for what could begin to drag a tab
    const press = tab => ["pointerdown", "pointerup", "click"].forEach(name => tab?.dispatchEvent(
      new PointerEvent(name, {bubbles: true, pointerId: 1, isPrimary: true, buttons: 1})));
    const tab = () => [...document.querySelectorAll("[role=tab]")].find(tab => tab.textContent === label);
    const steps = [[tab, () => press(tab())]];
    if (sheet) {
      const tabs = () => leaf(text => text.startsWith("Result · "));
      steps.unshift([() => tabs() || tab(), () => click(tabs())]);
      this.folded = true;  // it is the hand's from now on
      if (!(sheet.querySelector(".mantine-ScrollArea-viewport")?.clientHeight > 60)) {
        steps.unshift([() => true, () => click(leaf(text => text === this.watched?.label))]);
      }
    }
    // each once what it clicks is there, which on a slow machine takes a while
    let tries = 50;
    const go = () => {
      if (steps[0][0]()) steps.shift()[1]();
      if (steps.length && tries--) setTimeout(go, 400);
    };
    go();
  },

  // Scroll the heading of a stage, which begins with that number, into sight beside a lesson. On a
  // phone, where both are in one sheet, a button of the lesson does, and unfolds the stage.
  showStage(number) {
    if (innerWidth > this.PHONE) this.stage(number)?.scrollIntoView({block: "nearest"});
  },
  stage(number) {
    const heading = [...document.querySelectorAll(".mantine-ScrollArea-content .mantine-Paper-root")]
      .find(each => each.style.cursor === "pointer" && each.textContent.startsWith(`${number} · `));
    if (heading) heading.style.scrollMargin = "14px 0 6px";
    return heading;
  },
  stageAsked({target}) {
    const heading = target.dataset?.stage && this.stage(target.dataset.stage);
    if (!heading) return;
    this.showSoon(null, []);
    if (!(heading.nextElementSibling?.offsetHeight > 20)) heading.click();
    heading.style.scrollMargin = "4em 0 6px";  // the sheet's own heading stays
    heading.scrollIntoView({block: "start"});
  },

  // A tab of the panels is chosen once all have heard of the click.
  tabClicked({target}) {
    if (target.closest?.("[role=tab]")) setTimeout(() => this.tellArea());
  },

  // A folder that is opened unfolds into sight, from its heading on if it is taller than its panel.
  folderClicked({target}) {
    const heading = target.closest?.(".mantine-Paper-root"), folder = heading?.parentElement;
    if (heading?.style.cursor !== "pointer" || folder.firstElementChild !== heading) return;
    folder.style.scrollMargin = "14px 0 6px";  // the heading stands on the folder's edge
    const panel = folder.closest(".mantine-ScrollArea-viewport");
    const show = () => folder.scrollIntoView({block: folder.offsetHeight + 20 > panel?.clientHeight ? "start" : "nearest"});
    // at the end of its unfolding, and not later, when a hand may have gone on; at once if nothing moves
    const ended = ({propertyName}) => {
      if (propertyName !== "height") return;
      folder.removeEventListener("transitionend", ended);
      show();
    };
    folder.addEventListener("transitionend", ended);
    if (matchMedia("(prefers-reduced-motion: reduce)").matches) requestAnimationFrame(show);
  },

  // In a phone's sheet the tabs are below the stages, in one line first: what is chosen of them, or a
  // lesson's page that is turned to, comes into sight, and stays there while it unfolds.
  sheetClicked({target, isTrusted}) {
    this.folded ||= isTrusted && target.closest?.(this.SHEET) !== null;
    const turned = /^(Next|Back)/.test(target.closest?.("[role=tabpanel] button")?.textContent);
    const chosen = target.closest?.("[role=tab], .abi-cards") || turned || target.textContent?.startsWith("Result · ");
    if (innerWidth > this.PHONE || !chosen) return;
    const show = () => document.querySelector("[role=tablist]")?.scrollIntoView({block: "start"});
    this.showSoon(show, [300, 600, 1000, 2000]);
  },
  // Scroll once the page has drawn what a click asked for; the last click counts.
  showSoon(show, delays) {
    this.showing.forEach(clearTimeout);
    this.showing = delays.map(delay => setTimeout(show, delay));
  },
  showing: [],
  PHONE: 600,  // [px]: the greatest width of one

  // The hint of a control comes up for its name, too; viser shows it over the control alone.
  nameHovered({target, type}) {
    const row = target.closest?.("label[for]")?.closest(".mantine-Flex-root");
    row?.lastElementChild.firstElementChild
      ?.dispatchEvent(new MouseEvent(type === "mouseover" ? "mouseenter" : "mouseleave"));
  },

  // The hint of a control in a panel stands over the scene, beside the panel: over the panel it would
  // cover the heading or the control above. viser puts it there.
  hintSided({clientX}) {
    const scene = window.__viserMutable?.canvas?.getBoundingClientRect(), {dataset, style} = document.documentElement;
    const side = !scene || scene.width < 260 ? "" : clientX < scene.left ? "left" : clientX > scene.right ? "right" : "";
    if (dataset.abiHint !== side) dataset.abiHint = side;
    if (side) style.setProperty("--abi-hint", `${Math.round(scene[side])}px`);
  },

  // "?" as H, for the sheet of keys, and Escape or a click beside the sheet as its own button: viser
  // leaves a sheet open until the server closes it.
  keyPressed(event) {
    if (event.key === "Escape") this.closeSheet();
    if (event.key !== "?" || event.target.closest?.("input, textarea")) return;
    document.documentElement.dispatchEvent(
      new KeyboardEvent("keydown", {key: "h", code: "KeyH", bubbles: true}));
  },
  besideClicked(event) {
    if (event.target.matches?.(".mantine-Modal-inner, .mantine-Modal-overlay")) this.closeSheet();
  },
  // A box ticked with the mouse would keep the keys to itself.
  boxTicked({target}) {
    if (target.matches?.("input[type=checkbox]") && !target.matches(":focus-visible")) target.blur();
  },
  // After a lesson's page is turned, what comes to lie under the pointer looks as all others do until
  // the hand moves: an answer would look chosen.
  pageTurned({target}) {
    if (/^(Next|Back)/.test(target.closest?.(".mantine-Button-root")?.textContent)) document.documentElement.classList.add("abi-turned");
  },
  // On a phone what a lesson says to an answer, and the button to go on, come into sight.
  answered({target}) {
    const sheet = innerWidth <= this.PHONE && target.closest?.(`${this.SHEET} .mantine-Button-root`);
    if (!sheet || /^(Next|Back)/.test(sheet.textContent)) return;
    const next = () => [...document.querySelectorAll(`${this.SHEET} .mantine-Button-root`)]
      .find(each => /^Next/.test(each.textContent) && each.offsetHeight);
    this.showSoon(() => next()?.scrollIntoView({block: "nearest"}), [400, 1200]);
  },
  handMoved({movementX, movementY}) {
    if (movementX || movementY) document.documentElement.classList.remove("abi-turned");
  },
  closeSheet() { document.querySelector(".mantine-Modal-body button")?.click(); },

  // Large letters for the last row of a hall.
  lecture(on) { this.overlay().classList.toggle("abi-lecture", on); },

  // The time of all motions and their end, [s], and when that which is shown begins; a slider that is
  // held stays with the hand.
  clock(time, end, playing, before) {
    this.playing = playing;
    this.shown = null;  // where the page's own clock runs, it says its time at once
    [this.end, this.before] = [end, before];
    this.face(time);
  },
  before: 0,
  end: 0,
  face(time) {
    const end = this.end;
    const root = this.overlay(), slider = root.querySelector("input[type=range]");
    if (!slider) return;
    slider.max = end;
    slider.disabled = end <= 0.01;
    if (!slider.matches(":active")) slider.value = time;
    this.time = time - this.before;
    this.mark();
    root.querySelector("output").textContent = `${time.toFixed(2)} of ${end.toFixed(2)} s`;
    root.querySelector(".abi-play").textContent = this.playing ? "Pause" : "Play";
  },

  // Play a motion by this page's clock until it is to stand: again and again, or once.
  play(motion) {
    const bytes = Uint8Array.from(atob(motion.samples), letter => letter.charCodeAt(0));
    motion.samples = new Float32Array(bytes.buffer);
    motion.begin = performance.now() - 1000 * motion.time / motion.rate;
    const idle = !this.motion;
    this.motion = motion;
    this.playing = true;
    if (idle) this.tick(); else this.step();
  },

  // Go on from a time [s] of the motion that plays.
  seek(time) {
    if (!this.motion) return;
    this.motion.begin = performance.now() - 1000 * time / this.motion.rate;
    this.step();
  },

  // Move bodies with the motion that plays, by their places at its samples; null for none.
  follow(bodies) {
    this.bodies = bodies;
    if (!bodies) return;
    const bytes = Uint8Array.from(atob(bodies.places), letter => letter.charCodeAt(0));
    bodies.places = new Float32Array(bytes.buffer);
  },

  // Stand still at a time [s] of the motion that plays.
  stand(time) {
    const motion = this.motion;
    this.motion = null;
    if (!motion) return;
    this.pose(motion, time);
    this.cut(motion.trace, Infinity);
  },

  PAUSE: 0.8,  // [s] of real time at the end of a motion

  tick() {
    if (!this.motion) return;
    this.step();
    requestAnimationFrame(() => this.tick());
  },

  // Show the motion that plays as it is now.
  step() {
    const motion = this.motion, {samples, columns, rate, again} = motion;
    const duration = samples[samples.length - columns];
    const played = rate * (performance.now() - motion.begin) / 1000;
    const round = duration + this.PAUSE * rate;
    const time = Math.min(again ? played % round : played, duration);
    this.cut(motion.trace, this.pose(motion, time));
    // once the server has said the time at which it stands, the motion's end is on its way
    if (this.playing && Math.abs(time - (this.shown ?? -1)) >= 0.05) {
      this.shown = time;
      this.face(this.before + time);
    }
  },

  // Pose every joint at a time; the number of whole steps between samples up to then.
  pose({samples, columns, joints}, time) {
    const last = samples.length / columns - 1;
    let row = 0;
    while (row < last - 1 && samples[(row + 1) * columns] <= time) row++;
    const [low, high] = [row * columns, Math.min(row + 1, last) * columns];
    const step = samples[high] - samples[low];
    const part = step > 0 ? Math.min(Math.max((time - samples[low]) / step, 0), 1) : 0;
    const viser = window.__viserMutable;
    for (const {name, column, wxyz: [a, b, c, d], position, axis: [x, y, z], prismatic} of joints) {
      const node = viser.nodePoseData[name];
      if (!node) continue;
      const value = samples[low + column] + part * (samples[high + column] - samples[low + column]);
      if (prismatic) {
        node.position = [position[0] + value * x, position[1] + value * y, position[2] + value * z];
      } else {
        const [w, s] = [Math.cos(value / 2), Math.sin(value / 2)];
        const [i, j, k] = [s * x, s * y, s * z];
        node.wxyz = [
          a * w - b * i - c * j - d * k, a * i + b * w + c * k - d * j,
          a * j - b * k + c * w + d * i, a * k + b * j - c * i + d * w,
        ];
      }
      node.poseUpdateState = "needsUpdate";
    }
    this.place(row, Math.min(row + 1, last), part);
    viser.requestRender();
    return time >= samples[last * columns] ? last : row;
  },

  // Place bodies a part of the way from a sample to another; far away where they are not there.
  place(low, high, part) {
    if (!this.bodies) return;
    const {names, places} = this.bodies, width = 7 * names.length;
    if ((high + 1) * width > places.length) return;  // of the motion before this one
    const poses = window.__viserMutable.nodePoseData;
    names.forEach((name, body) => {
      const node = poses[name];
      if (!node) return;
      const [first, next] = [low * width + 7 * body, high * width + 7 * body];
      const at = [...Array(7).keys()].map(k => places[first + k] + part * (places[next + k] - places[first + k]));
      const there = !at.some(Number.isNaN), length = Math.hypot(...at.slice(3));
      node.position = there ? at.slice(0, 3) : [0, 0, -1e7];
      node.wxyz = there ? at.slice(3).map(number => number / length) : [1, 0, 0, 0];
      node.poseUpdateState = "needsUpdate";
    });
  },

  // Draw only the first segments of a line.
  cut(name, count) {
    window.__viserMutable.nodeRefFromName[name]?.traverse(part => {
      const line = part.geometry;
      const segments = line?.isInstancedBufferGeometry && line.attributes.instanceStart?.count;
      if (segments) line.instanceCount = Math.min(count, segments);
    });
  },

  // A slider takes a finger for itself as soon as it is down, and nothing scrolls: it hears of it only
  // once the finger has gone sideways. One that taps comes as a mouse.
  sliderTouched(event) {
    const [touch] = event.changedTouches;
    if (event.type === "touchstart" && event.isTrusted) {
      const slider = event.touches.length === 1 && event.target.closest?.(".mantine-Slider-root");
      this.touched = slider ? {target: event.target, x: touch.clientX, y: touch.clientY} : null;
      if (slider) event.stopPropagation();
    } else if (event.type === "touchmove" && this.touched) {
      const {target, x, y} = this.touched, right = Math.abs(touch.clientX - x), down = Math.abs(touch.clientY - y);
      if (Math.max(right, down) < 4) return;
      this.touched = null;
      if (right <= down) return;
      const {touches, targetTouches, changedTouches} = event;
      target.dispatchEvent(new TouchEvent("touchstart", {bubbles: true, cancelable: true, touches, targetTouches, changedTouches}));
    } else if (event.isTrusted) this.touched = null;
  },
};

window.abiListeners?.abort();
window.abiListeners = new AbortController();
for (const name of ["touchstart", "touchmove", "touchend", "touchcancel"]) {
  const options = {capture: true, passive: true, signal: window.abiListeners.signal};
  document.addEventListener(name, event => window.abi.sliderTouched(event), options);
}
for (const [name, call] of [
  ["pointerdown", "plotPressed"], ["pointerup", "plotReleased"], ["click", "plotClicked"],
  ["dblclick", "plotReset"], ["mousemove", "plotHovered"], ["click", "sheetClicked"], ["click", "tabClicked"], ["click", "folderClicked"],
  ["mouseover", "hintSided"], ["mouseover", "nameHovered"], ["mouseout", "nameHovered"], ["keydown", "keyPressed"],
  ["mousedown", "besideClicked"], ["click", "boxTicked"], ["click", "cardPressed"], ["click", "stageAsked"],
  ["click", "pageTurned"], ["click", "answered"], ["mousemove", "handMoved"],
]) {
  const options = {capture: true, signal: window.abiListeners.signal};
  document.addEventListener(name, event => window.abi[call](event), options);
}
// viser says of a file that has arrived that it was "uploaded successfully", even where it is refused;
// what became of it is told under its button, or in a notice of its own.
window.abiNotices?.disconnect();
// And of what is told again, as of the same wrong file, only the last notice stays.
window.abiNotices = new MutationObserver(() => {
  const told = new Map();
  for (const notice of document.querySelectorAll(".mantine-Notification-root")) {
    told.get(notice.textContent)?.querySelector("button")?.click();
    told.set(notice.textContent, notice);
  }
  for (const notice of document.querySelectorAll(".mantine-Notification-description")) {
    if (notice.textContent !== "File uploaded successfully.") continue;
    notice.closest(".mantine-Notification-root").style.display = "none";
  }
});
window.abiNotices.observe(document.body, {childList: true, subtree: true, characterData: true});
clearInterval(window.abiMending);
window.abiMending = setInterval(() => document.hidden || (abi.mendCharts(), abi.tellArea(), abi.drawSpotlight()), 400);
document.addEventListener("visibilitychange", () => abi.tellArea(), {signal: window.abiListeners.signal});
window.addEventListener("resize", () => abi.tellArea(), {signal: window.abiListeners.signal});

document.getElementById("abi-style")?.remove();
document.head.insertAdjacentHTML("beforeend", `<style id="abi-style">
#abi-overlay {
  position: absolute; inset: 0; pointer-events: none; container-type: inline-size;
  display: flex; flex-direction: column; justify-content: space-between;
  color: var(--mantine-color-text); font: 14px/1.35 var(--mantine-font-family);
}
#abi-overlay .abi-top, #abi-overlay .abi-bottom { padding: 8px 10px; display: flex; gap: 6px; }
#abi-overlay .abi-top { flex-wrap: wrap; justify-content: space-between; }
#abi-overlay [data-part=message] { flex: 1 1 200px; }
/* below sentence and buttons, in the fewest lines: what it lies over should be seen */
#abi-overlay [data-part=contact]:not(:empty) { flex: 1 0 100%; }
#abi-overlay [data-part=contact] .abi-card { width: fit-content; }
#abi-overlay .abi-bottom { flex-direction: column; }
#abi-overlay .abi-card {
  background: color-mix(in srgb, var(--mantine-color-body) 88%, transparent);
  border-radius: 6px; padding: 5px 9px; text-wrap: pretty;
}
#abi-overlay .abi-error { border-left: 4px solid #e03131; }
#abi-overlay button, #abi-overlay input { pointer-events: auto; font: inherit; }
#abi-overlay button {
  color: inherit; background: var(--mantine-color-body); cursor: pointer; padding: 3px 9px;
  border: 1px solid rgba(128, 128, 128, .55); border-radius: 5px;
}
#abi-overlay [data-part=tools] button { padding-inline: 7px; }
#abi-overlay summary { pointer-events: auto; cursor: pointer; width: fit-content; }
#abi-overlay button:hover { border-color: currentColor; }
#abi-overlay button:disabled {
  color: color-mix(in srgb, currentColor 40%, var(--mantine-color-body)); border-color: rgba(128, 128, 128, .22);
  cursor: default;
}
#abi-overlay button:focus-visible { outline: 2px solid #1f84d6; }
#abi-overlay .abi-buttons { display: flex; flex-wrap: wrap; gap: 6px; }
#abi-overlay .abi-numbers { display: inline-flex; gap: 4px 18px; flex-wrap: wrap; }
#abi-overlay .abi-numbers > div { pointer-events: auto; }
#abi-overlay .abi-numbers b {
  display: block; font-size: clamp(16px, min(4.4cqw, 4.6vh), 34px); line-height: 1.15;
  font-variant-numeric: tabular-nums; white-space: nowrap;
}
#abi-overlay .abi-numbers span { font-size: clamp(11px, min(2.3cqw, 2.5vh), 16px); }
#abi-overlay .abi-numbers > div > span { display: block; max-width: 12em; line-height: 1.2; }
#abi-overlay .abi-old { opacity: .55; }
#abi-overlay [data-part=numbers] { align-self: flex-start; }
#abi-overlay .abi-player { display: flex; flex-wrap: wrap; align-items: center; gap: 4px 8px; }
#abi-overlay .abi-track { flex: 1 1 90px; min-width: 0; padding: 6px 0; }
#abi-overlay .abi-track input { display: block; width: 100%; margin: 0; accent-color: light-dark(#1f84d6, #5aaef0); }
#abi-overlay [data-part=tour], #abi-overlay [data-part=tour]:empty, #abi-overlay [data-part=class] { flex: 1 0 100%; }
#abi-overlay [data-part=class] * { font-size: inherit !important; }
#abi-overlay [data-part=class] .abi-card > div { margin-inline: 0 !important; }
/* a lecture: letters for a hall, in rows that leave the height to the scene */
#abi-overlay.abi-lecture { font-size: clamp(16px, min(2.8vh, 3vw), 26px); }
body:has(#abi-overlay.abi-lecture) .mantine-Modal-body { font-size: clamp(16px, min(2.8vh, 3vw), 26px); }
#abi-overlay.abi-lecture .abi-numbers { column-gap: 1.1em; }
#abi-overlay.abi-lecture .abi-numbers b { font-size: clamp(22px, min(5vh, 5cqw), 60px); }
#abi-overlay.abi-lecture .abi-numbers span { font-size: clamp(14px, min(2.6vh, 3cqw), 26px); }
#abi-overlay.abi-lecture .abi-bottom { flex-flow: row wrap; align-items: end; padding-block: 0 6px; }
#abi-overlay.abi-lecture [data-part=lecture] { flex: 1 0 100%; display: flex; flex-wrap: wrap; gap: 6px; }
#abi-overlay.abi-lecture [data-part=player] { flex: 1 1 16em; }
#abi-overlay.abi-lecture .abi-card { padding-block: 3px; }
#abi-overlay.abi-lecture .abi-bottom button { padding-block: 2px; }
#abi-overlay [data-part=lecture] .abi-buttons { display: inline-flex; align-items: center; }
#abi-overlay [data-part=lecture] b { min-width: 7.5em; text-align: center; }
#abi-overlay [data-part=lecture] span { width: 12px; }
#abi-overlay [data-part=marks] { display: none; }
@media (min-width: 601px) { .abi-phone { display: none; } }
#abi-overlay .abi-tour { max-width: 34em; border-left: 4px solid #1f84d6; }
#abi-overlay .abi-player output { white-space: nowrap; font-variant-numeric: tabular-nums; }
#abi-overlay .abi-play { min-width: 4.6em; }
/* a search that is stepped through has its buttons where the hidden arm's were */
#abi-overlay:not(.abi-lecture) .abi-bottom:has([data-part=lecture]:not(:empty)) {
  [data-part=lecture] { order: 1; }
  [data-part=player] { display: none; }
}
/* viser's grey labels, blue buttons and tabs, dark enough to be read (WCAG 2.1, 1.4.3) */
:root[data-mantine-color-scheme] {
  --mantine-color-dimmed: light-dark(#5c646c, #a3a3a3);
  --mantine-color-blue-filled: #1a6fc0; --mantine-color-blue-filled-hover: #15609f;
  --mantine-color-gray-filled: #5c646c; --mantine-color-gray-filled-hover: #495057;
  --mantine-color-blue-outline: light-dark(#1a6fc0, #74b8f5);
}
.abi-turned .mantine-Button-root { --button-hover: var(--button-bg) !important; }
[role=tab][aria-selected=true] * { color: light-dark(#1a6fc0, #74b8f5) !important; }
/* the numbers at its ends below a slider's knob */
.mantine-Slider-markLabel { color: var(--mantine-color-dimmed); padding-top: 4px; }
/* a finger that goes up or down scrolls, also where it begins on a slider */
.mantine-Slider-root { touch-action: pan-y; }
/* a checkbox before its label, which viser squeezes into the column of the others */
.mantine-Flex-root:has(> div:last-child .mantine-Checkbox-root) {
  flex-direction: row-reverse; justify-content: flex-end; gap: 8px;
}
.mantine-Flex-root:has(> div:last-child .mantine-Checkbox-root) > div {
  width: auto !important; flex: 0 1 auto !important;
}
.mantine-Flex-root > div:last-child:has(> div > .mantine-Checkbox-root) { display: flex; }
[role=button]:focus-visible { outline: 2px solid #1f84d6; }
/* a heading is nearer to its own text than to the one before */
.mantine-ScrollArea-content p ~ :is(h3, h4).mantine-Title-root { margin-top: .6em; }
.mantine-ScrollArea-content p + p, .mantine-Modal-body :is(p, ol) + :is(p, ol) { margin-top: .5em; }
.mantine-ScrollArea-content h3.mantine-Title-root { font-size: 17px; text-wrap: balance; }
@media (max-height: 760px) {  /* nothing scrolls on a small laptop, or at 200 % on a large screen */
  .mantine-ScrollArea-content .mantine-Paper-root:not(.mantine-Paper-root *) { margin-block: 7px; }
  .mantine-ScrollArea-content div:has(> .mantine-Flex-root) { padding-bottom: 3.4px !important; }
}
@media (max-width: 600px) {
  /* a tab that is chosen moves the sheet below the pointer: what opens so would stay open */
  .mantine-Tooltip-tooltip { display: none !important; }
  /* the scene ends where the sheet begins */
  div:has(> #abi-overlay) { bottom: var(--abi-sheet, 56px) !important; }
  #abi-overlay.abi-squeezed [data-part=numbers] { display: none; }
  /* in a lesson, what the plan took; the scene needs the place */
  #abi-overlay.abi-squeezed [data-part=message] > .abi-buttons + .abi-card:not(.abi-error) { display: none; }
  #abi-overlay .abi-numbers { gap: 4px 10px; }
  .mantine-Paper-root[style*="max-height: 60%"] { max-height: 50% !important; }
  /* the sheet of the panels, which viser makes two thirds as wide as a phone */
  .mantine-Paper-root[style*="max-height: 60%"],
  .mantine-Paper-root[style*="max-height: 60%"] .mantine-ScrollArea-content,
  .mantine-Paper-root[style*="max-height: 60%"] .mantine-ScrollArea-content > div {
    width: 100% !important; min-width: 0 !important;
  }
  /* its heading, which folds it, stays when it is scrolled */
  .mantine-Paper-root[style*="max-height: 60%"] .mantine-ScrollArea-content > div > div:first-child {
    position: sticky !important; top: 0; z-index: 5; background: var(--mantine-color-body);
  }
  /* what is under that heading while it is folded */
  .mantine-Paper-root[style*="max-height: 60%"] .mantine-ScrollArea-content > div > div:first-child:has(+ [aria-hidden=true])::after {
    content: "stages and results ▴"; color: var(--mantine-color-dimmed); white-space: nowrap;
  }
  [role=tablist] { scroll-margin-top: 3.5em; }
  /* large enough for a finger: at least 24 px (WCAG 2.2, 2.5.8) */
  #abi-overlay button { min-width: 36px; min-height: 34px; }
  #abi-overlay .abi-track input { height: 34px; }
  .mantine-Button-root { height: 34px !important; }
  .mantine-Input-input { height: 34px !important; min-height: 34px !important; }
  .mantine-Checkbox-root { --checkbox-size: 26px !important; }
  .mantine-ActionIcon-root { min-width: 34px; min-height: 34px; }
  [role=tab] { min-height: 36px; }
  .mantine-Flex-root:has(> .mantine-Slider-root) { align-items: center; }
  .mantine-Slider-thumb::after { content: ""; position: absolute; inset: -13px; }
  .mantine-Paper-root[role=button]::after { content: ""; position: absolute; inset: -8px 0; }
  #abi-overlay .abi-wide { display: none; }
}
/* viser's scroll bar lies over what it scrolls, and its notices over the sentence and the buttons */
.mantine-ScrollArea-root:has(> .mantine-ScrollArea-scrollbar[data-orientation=vertical][data-state=visible])
  > .mantine-ScrollArea-viewport { padding-inline-end: 9px; }
.mantine-ScrollArea-scrollbar[data-orientation=vertical] { width: 9px !important; padding: 1px; }
.mantine-Notification-description { color: var(--mantine-color-dimmed) !important; }
.mantine-Notifications-root {
  top: var(--abi-above, 92px) !important; bottom: auto; overflow-y: auto; scrollbar-width: thin;
  max-height: max(100px, 100vh - var(--abi-above, 92px) - var(--abi-below, 60px));
  max-width: calc(var(--abi-width, 100vw) - 20px);
}
/* a hint that has been read lies over what changes while one types or drags */
body:has(:is(:active, .mantine-NumberInput-input:focus:hover)) .mantine-Tooltip-tooltip { display: none !important; }
[data-abi-hint=left] .mantine-Tooltip-tooltip { left: calc(var(--abi-hint) + 6px) !important; }
[data-abi-hint=right] .mantine-Tooltip-tooltip { left: calc(var(--abi-hint) - 6px) !important; translate: -100% 0; }
:is([data-abi-hint=left], [data-abi-hint=right]) .mantine-Tooltip-arrow { display: none; }
.mantine-Notification-root { max-height: none !important; }  /* it would cut what is longer; they scroll as one */
/* a search that is stepped through: its legend, rings around nodes, and the node that is pointed at */
#abi-overlay .abi-legend { display: flex; flex-wrap: wrap; gap: 2px 14px; align-self: flex-start; font-size: 13px; }
#abi-overlay [data-part=lecture] .abi-legend span { width: auto; }
#abi-overlay.abi-lecture .abi-legend { font-size: inherit; }
.abi-disc { display: inline-block; width: 9px; height: 9px; border-radius: 50%; margin-right: 4px; }
.abi-ring { width: 7px; height: 7px; border: 2px solid light-dark(#111, #fff); margin-right: 4px; vertical-align: -1px; }
.abi-scale { display: inline-block; width: 44px; height: 9px; border-radius: 4px; margin: 0 3px; }
.abi-rings { position: absolute; inset: 0; width: 100%; height: 100%; pointer-events: none; }
.abi-rings circle { fill: none; stroke: light-dark(#111, #fff); stroke-width: 2; }
.abi-rings circle.abi-pointed { stroke: #1f84d6; stroke-width: 3; }
.abi-rings line { stroke: light-dark(#111, #fff); stroke-width: 1.5; }
.abi-letters { position: absolute; inset: 0; pointer-events: none; }
#abi-overlay .abi-letter {
  position: absolute; left: 0; top: 0; width: auto; min-width: 0; min-height: 0; padding: 1px 5px; cursor: pointer;
  pointer-events: auto; font-size: 12px; white-space: nowrap; font-variant-numeric: tabular-nums;
  border: 1px solid rgba(128, 128, 128, .6); border-radius: 5px;
}
#abi-overlay .abi-letter.abi-pointed { border-color: #1f84d6; box-shadow: 0 0 0 1px #1f84d6; }
#abi-overlay .abi-node {
  position: absolute; left: 0; top: 0; z-index: 1; pointer-events: none; font-size: 13px; white-space: nowrap;
  border: 1px solid rgba(128, 128, 128, .5); font-variant-numeric: tabular-nums;
}
.abi-node td { padding: 0 8px 0 0; }
.abi-node td:last-child { padding: 0; text-align: right; }
.abi-table tr.abi-pointed { background: color-mix(in srgb, #1f84d6 22%, transparent); }
.abi-table tr:has([data-place]) { cursor: pointer; }
/* lists of lessons and scenes; of scenes the one chosen is seen, where there is room two more */
.abi-cards.abi-few { max-height: 150px; overflow-y: auto; }
@media (max-height: 880px) { .abi-cards.abi-few { max-height: 58px; } }
/* on a small laptop the tab would scroll for it */
@media (max-height: 760px) and (min-width: 601px) { .abi-cards.abi-few { display: none; } }
.abi-cards { margin: 0 8px 6px; display: grid; gap: 4px; scrollbar-width: thin; }
.abi-cards button {
  display: grid; grid-template-columns: 84px 1fr; gap: 9px; align-items: center; text-align: left; width: 100%;
  padding: 3px; border: 1px solid rgba(128, 128, 128, .35); border-radius: 6px; background: none; color: inherit;
  font: 12.5px/1.3 var(--mantine-font-family); cursor: pointer;
}
.abi-cards button:not(:has(img)) { grid-template-columns: 1fr; padding: 6px 9px; }
.abi-cards button:is(:hover, :focus-visible) { border-color: #1f84d6; }
.abi-cards button[aria-pressed=true] { border-color: #1f84d6; background: color-mix(in srgb, #1f84d6 12%, transparent); }
.abi-go {
  padding: 6px 12px; border: 1px solid #1f84d6; border-radius: 6px; background: none; color: inherit; font: inherit; min-height: 34px;
}
.abi-cards img { width: 84px; height: 52px; border-radius: 4px; object-fit: cover; background: rgba(128, 128, 128, .2); }
.abi-spotlight {
  position: fixed; z-index: 90; pointer-events: none; border: 3px solid #1f84d6; border-radius: 8px;
  box-shadow: 0 0 0 4px rgba(31, 132, 214, .25);
}
.abi-now {
  position: absolute; top: 0; bottom: 0; left: 0; width: 1px; background: #868e96;
  pointer-events: none;
}
.abi-read {
  position: absolute; top: 0; right: 0; z-index: 101; padding: 1px 5px; border-radius: 4px; white-space: pre;
  pointer-events: none; font: 11px/1.25 var(--mantine-font-family); font-variant-numeric: tabular-nums;
  background: color-mix(in srgb, var(--mantine-color-body) 88%, transparent);
}
.abi-read.abi-left { right: auto; left: 0; }
/* a plot's legend shows each line with its dashes: those of app/layers/result/time_plot.py */
.u-legend .u-marker { width: 20px !important; height: 0 !important; border-width: 2px 0 0 !important; }
.u-legend .u-series:nth-child(3) .u-marker { mask: repeating-linear-gradient(90deg, #000 0 8px, #0000 0 12px); }
.u-legend .u-series:nth-child(4) .u-marker { mask: repeating-linear-gradient(90deg, #000 0 2px, #0000 0 5px); }
.u-legend .u-series:nth-child(5) .u-marker {
  mask: repeating-linear-gradient(90deg, #000 0 12px, #0000 0 16px, #000 0 18px, #0000 0 20px);
}
.u-legend .u-series:nth-child(6) .u-marker {
  mask: repeating-linear-gradient(90deg, #000 0 5px, #0000 0 8px, #000 0 9px, #0000 0 12px);
}
.u-legend .u-series > * { padding: 4px 3px; }
.u-legend { margin-top: -3px !important; }  /* below the name of the axis */
/* the time, the line that only spans a plot's scale, and what abi.tellValues shows */
.u-legend .u-series:is(:first-child, :last-child), .u-legend .u-value { display: none; }
.u-legend .u-series th::after { content: none !important; }
</style>`);
