"use strict";
const sections = [...document.querySelectorAll("section.gaze")];
const stacks = [...document.querySelectorAll(".stack")];

// A full picture does not depend on the gaze: it is embedded once and shown in the sections that follow.
let full = "";
for (const image of document.querySelectorAll("img.under")) {
  if (image.hasAttribute("src")) full = image.src;
  else image.src = full;
}

// One position for all sections, so that changing the gaze keeps the slider where it is.
function place(at) {
  for (const stack of stacks) {
    stack.style.setProperty("--at", at + "%");
    stack.querySelector("input").value = at;
  }
}
for (const stack of stacks) stack.querySelector("input").addEventListener("input", e => place(e.target.value));

const names = { foveated: "foveated", difference: "difference ×4", rings: "foveated, with rings" };
const chosen = {
  gaze: value => sections.forEach(section => { section.hidden = section.dataset.gaze !== value; }),
  view: value => {
    document.querySelectorAll("img.over").forEach(image => { image.hidden = image.dataset.view !== value; });
    document.querySelectorAll(".tag.right").forEach(tag => { tag.textContent = names[value]; });
  },
  layout: value => document.body.classList.toggle("side", value === "side"),
};
for (const input of document.querySelectorAll(".controls input")) {
  input.addEventListener("change", () => chosen[input.name](input.value));
  // Browsers restore choices when a page is loaded again.
  if (input.checked) chosen[input.name](input.value);
}
place(50);
