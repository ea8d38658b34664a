// Numbers beside a figure's mark (pointer or arrow keys), tables that are sorted by a click on a head,
// and tables that are wider than the page: lists on a phone, or a hint below.
"use strict";
(() => {
  const reach = 24; // px
  const tip = document.createElement("div");
  tip.className = "tip";
  tip.hidden = true;
  document.body.append(tip);

  const beside = (point, note) => {
    const box = point.getBoundingClientRect();
    tip.textContent = note;
    tip.hidden = false;
    const wide = document.documentElement.clientWidth;
    const left = Math.max(4, Math.min(box.right + 10, wide - tip.offsetWidth - 4));
    const above = box.top - tip.offsetHeight - 10;
    tip.style.left = `${left + window.scrollX}px`;
    tip.style.top = `${(above < 0 ? box.bottom + 10 : above) + window.scrollY}px`;
  };

  for (const plot of document.querySelectorAll("svg.plot")) {
    const points = [...plot.querySelectorAll(".point")];
    const notes = points.map((point) => {
      const title = point.querySelector("title");
      title.remove();
      point.setAttribute("role", "img");
      point.setAttribute("aria-label", title.textContent);
      point.setAttribute("tabindex", "-1");
      return title.textContent;
    });
    let at = -1;
    const show = (next) => {
      if (at >= 0) points[at].classList.remove("pointed");
      at = next;
      tip.hidden = at < 0;
      if (at < 0) return;
      points[at].classList.add("pointed");
      beside(points[at], notes[at]);
    };
    const nearest = (event) => {
      let best = -1;
      let least = reach * reach;
      points.forEach((point, i) => {
        const box = point.getBoundingClientRect();
        const dx = box.x + box.width / 2 - event.clientX;
        const dy = box.y + box.height / 2 - event.clientY;
        if (dx * dx + dy * dy < least) [best, least] = [i, dx * dx + dy * dy];
      });
      return best;
    };
    plot.addEventListener("pointermove", (event) => show(nearest(event)));
    plot.addEventListener("pointerdown", (event) => show(nearest(event)));
    plot.addEventListener("pointerleave", () => show(-1));
    plot.addEventListener("focusout", () => show(-1));
    plot.addEventListener("keydown", (event) => {
      const last = points.length - 1;
      const next = { ArrowRight: Math.min(at + 1, last), ArrowLeft: Math.max(at - 1, 0), Home: 0, End: last, Escape: -1 };
      if (!(event.key in next) || last < 0) return;
      event.preventDefault();
      (points[next[event.key]] ?? plot).focus();
      show(next[event.key]);
    });
  }
  document.querySelector(".pointing").hidden = !document.querySelector("svg.plot .point");

  const value = (cell, numeric) => {
    const text = cell.textContent.trim();
    if (!numeric) return text;
    const match = text.replaceAll("\u2212", "-").match(/[-+]?\d[\d.]*(e[-+]?\d+)?/i);
    return match ? Number(match[0]) : "";
  };
  const compare = (a, b, way) => {
    if (a === "" || b === "") return (a === "") - (b === ""); // unknown values come last
    const words = typeof a === "string" ? a.localeCompare(b, "en", { numeric: true }) : a - b;
    return way * words;
  };
  for (const table of document.querySelectorAll("table.sortable")) {
    const heads = [...table.tHead.rows[0].cells];
    const body = table.tBodies[0];
    const how = document.createElement("p");
    how.className = "how";
    how.textContent = "Click on a column's head to sort by it; a second click reverses the order.";
    table.closest(".scroll").before(how);
    heads.forEach((head, column) => {
      const button = document.createElement("button");
      button.type = "button";
      button.title = "Sort by this column";
      button.append(...head.childNodes);
      head.append(button);
      button.addEventListener("click", () => {
        const way = head.getAttribute("aria-sort") === "ascending" ? -1 : 1;
        for (const other of heads) other.removeAttribute("aria-sort");
        head.setAttribute("aria-sort", way > 0 ? "ascending" : "descending");
        const numeric = head.classList.contains("n");
        const rows = [...body.rows].map((row) => [value(row.cells[column], numeric), row]);
        rows.sort((a, b) => compare(a[0], b[0], way));
        body.append(...rows.map(([, row]) => row));
      });
    });
  }

  // A short table that is wider than a phone becomes a list: each cell with its column's head.
  const phone = window.matchMedia("(max-width: 560px)");
  const most = (table) => table.querySelector(".flag") ? 24 : 12; // rows; a verdict is not to be hidden
  const list = (table) => {
    const heads = table.tHead.rows[0].cells;
    table.classList.add("listed");
    for (const cell of table.querySelectorAll("tbody td:is(.n, :not(:first-child))")) {
      if (!cell.textContent.trim()) continue;
      const head = document.createElement("span");
      head.className = "head";
      head.append(...heads[cell.cellIndex].cloneNode(true).childNodes);
      cell.prepend(head);
    }
  };

  const hint = (scroller) => {
    const table = scroller.querySelector("table:not(.sortable, .listed)");
    if (phone.matches && table && table.tBodies[0].rows.length <= most(table) && scroller.scrollWidth > scroller.clientWidth) list(table);
    const hidden = scroller.scrollWidth - scroller.clientWidth - scroller.scrollLeft;
    scroller.classList.toggle("more", hidden > 2);
  };
  const resized = new ResizeObserver((entries) => entries.forEach((entry) => hint(entry.target)));
  for (const scroller of document.querySelectorAll(".scroll, .canvas")) {
    resized.observe(scroller);
    scroller.addEventListener("scroll", () => hint(scroller), { passive: true });
  }

  const unfold = () => document.getElementById(decodeURIComponent(location.hash.slice(1)))?.closest("details")?.setAttribute("open", "");
  window.addEventListener("hashchange", unfold);
  unfold();

  const folded = () => document.querySelectorAll("details:not([open])");
  let opened = [];
  window.addEventListener("beforeprint", () => {
    opened = [...folded()];
    for (const one of opened) one.open = true;
  });
  window.addEventListener("afterprint", () => {
    for (const one of opened) one.open = false;
  });
})();
