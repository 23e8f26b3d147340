"use strict";
const byId = (id) => document.getElementById(id);
const show = (image, choice) => { byId(image).src = byId(byId(choice).value).src; };
const cut = () => byId("stage").style.setProperty("--cut", byId("cut").value + "%");
for (const [image, choice] of [["under", "left"], ["over", "right"]]) {
  byId(choice).addEventListener("change", () => show(image, choice));
  show(image, choice);
}
byId("cut").addEventListener("input", cut);
const drag = (event) => {
  if (!event.buttons) return;
  const box = byId("stage").getBoundingClientRect();
  byId("cut").value = 100 * (event.clientX - box.left) / box.width;
  cut();
};
for (const kind of ["pointerdown", "pointermove"]) byId("stage").addEventListener(kind, drag);
for (const image of ["under", "over"]) byId(image).draggable = false;
cut();
byId("viewer").hidden = false;
