// Point at a mark of a figure, or walk its marks with the arrow keys: its numbers stand beside it.
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
