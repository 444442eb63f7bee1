// Files on their way to the server. viser takes one of each choice and sends it as it reads it: where
// reading fails, or the server takes no such file, its button stays shut and its notice turns for ever.
// So a file is looked at and read here first, and handed over once it is in memory. Several meshes are
// handed over one by one, the next once the server has the last.
window.abi.UPLOADS = "input[type=file][id^=file_upload_]";
window.abi.MESHES = 'input[type=file][accept*=".stl"]';
window.abi.read = new WeakSet();
window.abi.waiting = [];
window.abi.busy = false;  // whether a mesh is on its way

// Where to type what files are refused, and the most bytes of one: see app/tab/refused_files.py.
window.abi.hearFiles = (uuid, most) => { window.abi.refusals = {uuid, most, count: 0}; };
window.abi.refuse = (file, why, kinds) => {
  const {uuid} = window.abi.refusals, count = ++window.abi.refusals.count;
  window.abi.send(uuid, JSON.stringify({name: file.name.slice(0, 200), why, kinds, count}));
};

window.abi.choose = (input, files) => {
  if (!input.matches(window.abi.MESHES)) return void window.abi.hand(input, files[0]);
  window.abi.waiting.push(...[...files].map(file => [input, file]));
  if (!window.abi.busy) window.abi.next();
};
window.abi.next = async () => {
  window.abi.busy = true;
  while (window.abi.waiting.length) {
    if (await window.abi.hand(...window.abi.waiting.shift())) return;  // until the server has it
  }
  window.abi.busy = false;
};
// Read a file and hand it over; whether that was possible.
window.abi.hand = async (input, file) => {
  const kinds = input.accept.split(",");
  if (!kinds.some(kind => file.name.toLowerCase().endsWith(kind))) {
    window.abi.refuse(file, "kind", input.accept);
    return false;
  }
  if (file.size > window.abi.refusals.most) {
    window.abi.refuse(file, "size", "");
    return false;
  }
  let whole;
  try { whole = new File([await file.arrayBuffer()], file.name, {type: file.type}); }
  catch {
    window.abi.refuse(file, "unreadable", "");
    return false;
  }
  // while its button is shut the last file's notice is not done, and would stay for ever
  const button = document.getElementById(input.id.replace("file_upload_", ""));
  do { await new Promise(done => setTimeout(done, 100)); } while (button?.disabled);
  window.abi.read.add(whole);
  const one = new DataTransfer();
  one.items.add(whole);
  input.files = one.files;
  input.dispatchEvent(new Event("change", {bubbles: true}));
  return true;
};
document.abiFiles ??= (() => {
  document.addEventListener("click", event => {
    if (event.target.matches?.(window.abi.MESHES)) event.target.multiple = true;
  }, true);
  document.addEventListener("change", event => {
    const input = event.target;
    if (!input.matches?.(window.abi.UPLOADS) || window.abi.read.has(input.files[0])) return;
    event.stopImmediatePropagation();
    if (input.files.length) window.abi.choose(input, input.files);
  }, true);
  document.addEventListener("dragover", event => event.preventDefault());
  document.addEventListener("drop", event => {
    event.preventDefault();
    const input = document.querySelector(window.abi.MESHES);
    if (input && event.dataTransfer.files.length) window.abi.choose(input, event.dataTransfer.files);
  });
  return true;
})();
