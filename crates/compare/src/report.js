"use strict";
const byId = (id) => document.getElementById(id);
const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

// What the pictures are: all of one size, the display window
const size = JSON.parse(byId("report-data").textContent).display_window;
const frames = [...document.querySelectorAll(".frame")];
const stage = byId("stage");

// One view for all frames: a picture point p, as a share of the picture, stands at x + zoom * p of every frame
const view = { zoom: 1, x: 0, y: 0 };
const most = Math.max(4, Math.min(size.width, size.height) / 6);

// Pixels are drawn as squares where one is more than this many screen pixels wide
const CRISP = 2;

function draw() {
  view.x = clamp(view.x, 1 - view.zoom, 0);
  view.y = clamp(view.y, 1 - view.zoom, 0);
  const style = document.documentElement.style;
  style.setProperty("--zoom", view.zoom);
  style.setProperty("--x", 100 * view.x + "%");
  style.setProperty("--y", 100 * view.y + "%");
  for (const frame of frames) {
    frame.classList.toggle("crisp", view.zoom * frame.clientWidth > CRISP * size.width);
    frame.classList.toggle("near", view.zoom > 1);
  }
  byId("zoom").textContent = view.zoom.toFixed(1) + " ×";
}

/// Zooms by a factor; what stands at the given place of the frame stays there.
function zoom(factor, at) {
  const zoom = clamp(view.zoom * factor, 1, most);
  view.x = at.x - (at.x - view.x) * zoom / view.zoom;
  view.y = at.y - (at.y - view.y) * zoom / view.zoom;
  view.zoom = zoom;
  draw();
}

function pan(x, y) {
  view.x += x;
  view.y += y;
  draw();
}

// The pixel that is read out, and a canvas of one pixel to read it with
let pixel = null;
const reader = new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true });
reader.imageSmoothingEnabled = false;

function read(image) {
  reader.drawImage(image, pixel.x, pixel.y, 1, 1, 0, 0, 1, 1);
  return [...reader.getImageData(0, 0, 1, 1).data].slice(0, 3);
}

function probe(x, y) {
  pixel = { x: clamp(Math.floor(x), 0, size.width - 1), y: clamp(Math.floor(y), 0, size.height - 1) };
  const style = document.documentElement.style;
  style.setProperty("--pixel-x", (pixel.x + 0.5) / size.width);
  style.setProperty("--pixel-y", (pixel.y + 0.5) / size.height);
  style.setProperty("--pixel", 100 / size.width + "%");
  document.body.classList.add("probing");
  byId("position").textContent = `x ${size.x + pixel.x}, y ${size.y + pixel.y}`;
  for (const output of document.querySelectorAll("[data-of]")) {
    const value = read(byId(output.dataset.of));
    output.textContent = value.join(" ");
    output.style.setProperty("--value", `rgb(${value})`);
  }
}

const probeAt = (at) =>
  probe(size.width * (at.x - view.x) / view.zoom, size.height * (at.y - view.y) / view.zoom);

// The seam between the two pictures on the stage
const cut = () => stage.style.setProperty("--cut", byId("cut").value + "%");
function seamTo(share) {
  byId("cut").value = 100 * share;
  cut();
}

/// Whether a finger or mouse that goes down here takes the seam along; it always does where nothing can be panned.
function onSeam(frame, at) {
  const REACH = 22; // screen pixels, half a fingertip
  const away = Math.abs(at.x - byId("cut").value / 100) * frame.clientWidth;
  return frame === stage && (view.zoom === 1 || away < REACH);
}

function listen(frame) {
  const held = new Map(); // what is down on this frame: where each pointer was last
  let seam = false; // whether they move the seam, and not the view
  const place = (event) => {
    const box = frame.getBoundingClientRect();
    return { x: (event.clientX - box.left) / box.width, y: (event.clientY - box.top) / box.height };
  };
  const apart = (a, b) => Math.hypot((a.x - b.x) * frame.clientWidth, (a.y - b.y) * frame.clientHeight);

  frame.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    const at = place(event);
    seam = held.size === 0 && onSeam(frame, at);
    held.set(event.pointerId, at);
    frame.setPointerCapture(event.pointerId);
    probeAt(at);
  });
  frame.addEventListener("pointermove", (event) => {
    const at = place(event);
    const before = held.get(event.pointerId);
    if (before && held.size === 2) {
      const [other] = [...held].filter(([id]) => id !== event.pointerId).map(([, where]) => where);
      zoom(apart(at, other) / Math.max(apart(before, other), 1), other);
    } else if (before && seam) {
      seamTo(at.x);
    } else if (before) {
      pan(at.x - before.x, at.y - before.y);
    }
    if (before) held.set(event.pointerId, at);
    probeAt(at);
  });
  for (const end of ["pointerup", "pointercancel"]) {
    frame.addEventListener(end, (event) => {
      if (!held.delete(event.pointerId) || end === "pointercancel") return;
      if (seam) seamTo(place(event).x);
      frame.focus({ preventScroll: true });
    });
  }

  // The wheel scrolls the page until a frame was clicked, and past the whole picture it does again
  frame.addEventListener("wheel", (event) => {
    const asked = event.ctrlKey || document.activeElement === frame;
    if (!asked || (!event.ctrlKey && event.deltaY > 0 && view.zoom === 1)) return;
    event.preventDefault();
    const LINE = 16, DOUBLED = 200; // screen pixels of wheel: in a line of text, for twice the zoom
    zoom(2 ** (-event.deltaY * (event.deltaMode ? LINE : 1) / DOUBLED), place(event));
    probeAt(place(event));
  }, { passive: false });

  frame.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (!step || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    const by = event.shiftKey ? Math.ceil(size.width / view.zoom / 8) : 1;
    const from = pixel ?? { x: size.width / 2, y: size.height / 2 };
    probe(from.x + by * step[0], from.y + by * step[1]);
    view.x = 0.5 - view.zoom * (pixel.x + 0.5) / size.width;
    view.y = 0.5 - view.zoom * (pixel.y + 0.5) / size.height;
    draw();
  });

  for (const image of frame.querySelectorAll("img")) image.draggable = false;
  frame.tabIndex = frame === stage ? 0 : -1;
}

// Keys and buttons zoom about the pixel that is read out, or else the middle
const middle = { x: 0.5, y: 0.5 };
function centre() {
  if (!pixel) return middle;
  const at = {
    x: view.x + view.zoom * (pixel.x + 0.5) / size.width,
    y: view.y + view.zoom * (pixel.y + 0.5) / size.height,
  };
  return at.x >= 0 && at.x <= 1 && at.y >= 0 && at.y <= 1 ? at : middle;
}
const acts = { closer: () => zoom(1.5, centre()), farther: () => zoom(1 / 1.5, centre()), whole: () => zoom(0, middle) };
const keys = { "+": "closer", "=": "closer", "-": "farther", "0": "whole" };
for (const [id, act] of Object.entries(acts)) byId(id).addEventListener("click", act);
addEventListener("keydown", (event) => {
  const here = event.target.closest?.(".frame, .viewer") && event.target.tagName !== "SELECT";
  if (here && keys[event.key] && !event.ctrlKey && !event.metaKey && !event.altKey) acts[keys[event.key]]();
});

function show(image, choice) {
  const chosen = byId(byId(choice).value);
  byId(image).src = chosen.src;
  byId(image).alt = chosen.alt;
}
for (const [image, choice] of [["under", "left"], ["over", "right"]]) {
  byId(choice).addEventListener("change", () => show(image, choice));
  show(image, choice);
}
byId("cut").addEventListener("input", cut);
addEventListener("resize", draw);
byId("viewer").hidden = false;
frames.forEach(listen);
cut();
draw();
