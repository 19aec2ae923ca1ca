"use strict";
const all = (selector, root = document) => [...root.querySelectorAll(selector)];

// What is chosen decides what is shown; without this script one chart and all sizes are.
const chosen = {};
function show() {
  for (const part of all("[data-size]")) part.hidden = part.dataset.size !== (chosen.size ?? "0");
  for (const part of all(".chart")) {
    part.hidden = part.dataset.time !== chosen.time || part.dataset.error !== chosen.error;
  }
}
for (const form of all("form.controls")) {
  form.hidden = false;
  form.addEventListener("submit", event => event.preventDefault());
}
for (const input of all(".controls input")) {
  input.addEventListener("change", () => { chosen[input.name] = input.value; show(); });
  // Browsers restore choices when a page is loaded again.
  if (input.checked) chosen[input.name] = input.value;
}
show();

// The panel beside the front: a copy of a setting's card. A click pins it until the next click.
const kinds = { setting: "Setting", difference: "Difference ×4", reference: "Reference" };
for (const view of all(".front-view")) {
  const panel = view.querySelector(".panel");
  if (!view.querySelector("a.point")) continue;
  let pinned = null;
  panel.dataset.shows = "setting";

  function mark(key) {
    for (const point of all("a.point", view)) point.classList.toggle("shown", point.dataset.key === key);
  }
  function buttons(copy) {
    const row = document.createElement("div");
    row.className = "shows";
    for (const [kind, name] of Object.entries(kinds)) {
      if (!copy.querySelector(`[data-kind="${kind}"]`)) continue;
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = name;
      button.dataset.kind = kind;
      button.addEventListener("click", () => { panel.dataset.shows = kind; press(); });
      row.append(button);
    }
    return row;
  }
  function press() {
    for (const button of all("button[data-kind]", panel)) {
      button.setAttribute("aria-pressed", button.dataset.kind === panel.dataset.shows);
    }
  }
  function fill(key) {
    const card = document.getElementById(key);
    if (!card) return;
    const copy = card.cloneNode(true);
    copy.removeAttribute("id");
    const reference = document.querySelector(`#r${key.match(/\d+/)[0]} figure`);
    if (reference && !key.startsWith("r")) {
      const figure = reference.cloneNode(true);
      figure.dataset.kind = "reference";
      copy.querySelector(".pair").append(figure);
    }
    const row = buttons(copy);
    if (row.children.length < 2) panel.dataset.shows = "setting";
    else copy.querySelector(".pair").after(row);
    const hint = document.createElement("p");
    hint.className = "hint";
    hint.textContent = pinned ? "Pinned: choose the point again to let go." : "Click or press Enter to pin.";
    panel.replaceChildren(copy, hint);
    panel.hidden = false;
    view.classList.add("with-panel");
    press();
    mark(key);
  }
  for (const point of all("a[data-key]", view)) {
    const key = point.dataset.key;
    const preview = () => { if (!pinned) fill(key); };
    point.addEventListener("pointerenter", preview);
    point.addEventListener("focus", preview);
    point.addEventListener("click", event => {
      event.preventDefault();
      pinned = pinned === key ? null : key;
      fill(key);
    });
  }
  // Where there is room beside the chart, the panel is there from the start.
  const first = view.querySelector("table.front a[data-key]");
  if (first && matchMedia("(min-width: 60.01rem)").matches) fill(first.dataset.key);
}

function sorted(table, column, descending) {
  const value = row => {
    const cell = row.cells[column];
    return cell.dataset.value === undefined ? cell.textContent : Number(cell.dataset.value);
  };
  const order = (a, b) => {
    const [x, y] = [value(a), value(b)];
    if (typeof x !== typeof y) return typeof x === "number" ? -1 : 1;
    const less = typeof x === "number" ? x - y : x.localeCompare(y, "en", { numeric: true });
    return descending ? -less : less;
  };
  const body = table.tBodies[0];
  body.append(...[...body.rows].sort(order));
}
for (const table of all("table[data-sortable]")) {
  for (const [column, head] of [...table.tHead.rows[0].cells].entries()) {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    head.append(button);
    button.addEventListener("click", () => {
      const descending = head.getAttribute("aria-sort") === "ascending";
      for (const other of table.tHead.rows[0].cells) other.removeAttribute("aria-sort");
      head.setAttribute("aria-sort", descending ? "descending" : "ascending");
      sorted(table, column, descending);
    });
  }
}
