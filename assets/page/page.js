// What the server asks of a page and viser has no message for; app/page.py sends it to every tab.
window.abi = {
  KEY: "abi-tab",

  // Set a widget as a hand would.
  send(uuid, value) {
    window.__viserMutable.sendMessage({type: "GuiUpdateMessage", uuid, updates: {value}});
  },

  // Answer with what the tab remembers and what its address asks for. A link's state is taken out
  // of the address: from then on the tab remembers it, and a reload keeps what was changed since.
  report(uuid) {
    const url = new URL(location.href), link = url.searchParams.get("state");
    let state = null;
    try { state = sessionStorage.getItem(this.KEY); } catch {}
    if (link !== null) {
      url.searchParams.delete("state");
      history.replaceState(history.state, "", url);
      this.remember(link);
    }
    this.send(uuid, JSON.stringify({
      state: link ?? state ?? "",
      query: Object.fromEntries(url.searchParams),
      dark: matchMedia("(prefers-color-scheme: dark)").matches,
    }));
  },

  // Keep a text for as long as the tab lives, whatever becomes of page and server.
  remember(text) {
    try { sessionStorage.setItem(this.KEY, text); } catch {}
  },

  // Put a link to the page with this state on the clipboard; where that is forbidden, show it.
  async copyLink(text) {
    const url = new URL(location.href);
    url.searchParams.set("state", text);
    try { await navigator.clipboard.writeText(url.href); }
    catch { prompt("Copy this link:", url.href); }
  },
};
