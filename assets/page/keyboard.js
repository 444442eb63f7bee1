// What viser leaves out for those who use keys or hear the page: its folders are no buttons, and most
// of its boxes and sliders have no name. Only what is new on the page is looked at.
window.abiKeyboard = {
  // A folder's heading, and the one of a phone's sheet; what it folds is the next element.
  HEADINGS: `.mantine-Paper-root > .mantine-Paper-root:first-child,
    .mantine-Paper-root[style*="max-height: 60%"] .mantine-ScrollArea-content > div > div:first-child`,
  LABELS: ".mantine-Flex-root > div > p > label[for]",
  BOXES: "input:not([type=hidden]):not([type=checkbox]), [role=slider]",
  ICONS: {"list-search": "Commands", "adjustments": "Connection"},
  CONTROLS: "button, input, [role=button], [role=slider], [role=tab]",
  KEPT: /^( |Enter|Arrow\w+|Page\w+)$/,  // keys that a control keeps to itself
  AXES: /^(start|goal|base|position|size|rotation|region \w+)\b/,  // vectors along x, y and z

  heading(heading) {
    const folded = heading.nextElementSibling?.getAttribute("aria-hidden");
    if (folded == null) return;
    heading.setAttribute("role", "button");
    heading.tabIndex = 0;
    heading.setAttribute("aria-expanded", folded === "false");
  },

  // Each box of a row by the row's label, or by its part of "pedestal, column [cm]".
  name(label) {
    const row = label.closest(".mantine-Flex-root"), boxes = [...row.querySelectorAll(this.BOXES)];
    const text = label.textContent.trim(), [, names, unit] = text.match(/^(.*?)(\s*\[.*)?$/);
    const parts = names.split(", ");
    for (const [k, box] of boxes.entries()) {
      let name = text;
      if (boxes.length > 1 && !row.querySelector("[role=slider]")) {
        const axis = this.AXES.test(names) ? "xyz"[k] : k + 1;
        name = (parts.length === boxes.length ? parts[k] : `${names} ${axis}`) + (unit ?? "");
      }
      box.setAttribute("aria-label", name);
    }
  },

  look(part) {
    const below = selector => [part, ...part.querySelectorAll(selector)].filter(one => one.matches(selector));
    for (const heading of below(this.HEADINGS)) this.heading(heading);
    const labels = new Set(below(this.LABELS));
    const row = part.closest(".mantine-Flex-root:has(> div > p > label)");
    if (row) labels.add(row.querySelector("label"));
    for (const label of labels) this.name(label);
    for (const icon of below("svg")) {
      const button = icon.closest("button:not([aria-label])");
      const [, name] = Object.entries(this.ICONS).find(([kind]) => icon.matches(`.tabler-icon-${kind}`)) ?? [];
      if (button && name) button.setAttribute("aria-label", name);
    }
  },

  changed(changes) {
    for (const {type, target, addedNodes} of changes) {
      if (type === "attributes") {
        const heading = target.previousElementSibling;
        if (heading?.matches(this.HEADINGS)) this.heading(heading);
        continue;
      }
      for (const node of addedNodes) if (node.nodeType === Node.ELEMENT_NODE) this.look(node);
      const label = (target.nodeType === Node.TEXT_NODE ? target.parentElement : target)?.closest("label[for]");
      if (label?.matches(this.LABELS)) this.name(label);
    }
  },

  // A heading folds as a button does.
  press(event) {
    const heading = event.target;
    if (![" ", "Enter"].includes(event.key) || !heading.matches?.(this.HEADINGS)) return;
    event.preventDefault();
    heading.click();
  },

  // Keys that a control uses move neither camera nor arm as well: viser asks only whether one types.
  keep(event) {
    const {key, target} = event;
    if (this.KEPT.test(key) && !event.ctrlKey && target.closest?.(this.CONTROLS)) event.stopPropagation();
  },

  // After a click those keys are the page's: a button pressed by the mouse would be pressed again.
  release({detail, target}) {
    if (detail > 0) target.closest?.("button, #abi-overlay input")?.blur();
  },
};

window.abiNames?.disconnect();
window.abiNames = new MutationObserver(changes => window.abiKeyboard.changed(changes));
window.abiNames.observe(document.body, {
  childList: true, subtree: true, characterData: true, attributes: true, attributeFilter: ["aria-hidden"],
});
window.abiKeyboard.look(document.body);
for (const [name, call, capture] of [
  ["keydown", "press", true], ["keydown", "keep", false], ["click", "release", false],
]) {
  const options = {capture, signal: window.abiListeners.signal};
  document.body.addEventListener(name, event => window.abiKeyboard[call](event), options);
}
