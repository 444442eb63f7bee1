// Part of the page's file, so that it runs before the server has said anything through a websocket:
// where none comes about, it asks the server why, and says so over the page. Until the server has shown
// something, viser's own panel lists the scene's nodes, which says nothing to a visitor: it is hidden.
(() => {
  document.documentElement.classList.add("abi-loading");
  document.head.insertAdjacentHTML("beforeend", `<style>
    .abi-loading .mantine-Paper-root { visibility: hidden !important; }
    .abi-loading body::after {
      content: "ABI path planning is loading \u2026"; position: fixed; inset: 45% 0 auto; text-align: center;
      font: 16px/1.4 system-ui, sans-serif; color: #777; pointer-events: none;
    }
    .abi-unconnected body::after, .abi-unconnected .mantine-Notification-root { display: none !important; }
  </style>`);
  const PERIOD = 4000, SLOW = 3;  // milliseconds between two looks; looks after which none is to be expected
  const LOST = "This page's server does not answer. It may have stopped; the page goes on trying.";
  const CUT = "The server answers, but this page's websocket does not reach it. What is in between, such as a proxy, " +
    "has to pass websockets on (in nginx: proxy_http_version 1.1, and the headers Upgrade and Connection).";
  let card = null, looks = 0;
  const reason = async () => {
    try {
      const answer = await fetch(`connection?origin=${encodeURIComponent(location.origin)}`, {cache: "no-store"});
      if (answer.status >= 500) return LOST;
      if (!answer.ok || !answer.headers.get("Content-Type")?.startsWith("text/plain")) return "";
      return (await answer.text()).trim() || (looks >= SLOW ? CUT : "");
    } catch {
      return LOST;
    }
  };
  const show = text => {
    if (card === null) {
      card = document.createElement("div");
      card.setAttribute("role", "alert");
      card.id = "abi-connecting";
      card.style = "position:fixed;top:1em;left:50%;transform:translateX(-50%);z-index:9999;box-sizing:border-box;" +
        "width:min(40em,94vw);padding:.8em 1em;border-radius:8px;border-left:6px solid #c92a2a;overflow-wrap:anywhere;" +
        "background:#fff;color:#1a1a1a;font:15px/1.45 system-ui,sans-serif;box-shadow:0 2px 12px #0005";
      document.body.append(card);
    }
    card.textContent = text;
    card.hidden = text === "";
    document.documentElement.classList.toggle("abi-unconnected", !card.hidden);
  };
  const look = async () => {
    looks += 1;
    const text = window.abi ? "" : await reason();
    if (window.abi) {
      card?.remove();
      document.documentElement.classList.remove("abi-unconnected");
    } else {
      show(text);
      setTimeout(look, PERIOD);
    }
  };
  setTimeout(look, PERIOD);
})();
