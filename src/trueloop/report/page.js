// What only a screen can do for a still picture: values when pointed at, and a closer look at what is dragged over.
"use strict";

const NEAR_PX = 14;
const tip = document.body.appendChild(Object.assign(document.createElement("div"), { id: "tip", hidden: true }));

function showTip(words, event) {
  tip.hidden = !words;
  if (!words) return;
  tip.textContent = words;
  const left = Math.min(event.clientX + 14, document.documentElement.clientWidth - tip.offsetWidth - 8);
  tip.style.left = `${Math.max(8, left)}px`;
  tip.style.top = `${Math.max(8, event.clientY - tip.offsetHeight - 10)}px`;
}

function nearest(marks, event) {
  let best = null;
  let least = NEAR_PX;
  for (const mark of marks) {
    const box = mark.getBoundingClientRect();
    const apart = Math.hypot(event.clientX - (box.left + box.right) / 2, event.clientY - (box.top + box.bottom) / 2);
    if (apart < least) [best, least] = [mark, apart];
  }
  return best;
}

function inPicture(svg, event) {
  return new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
}

function lookCloser(svg) {
  const whole = svg.getAttribute("viewBox");
  let from = null;
  let frame = null;
  const rectangle = (to) => [Math.min(from.x, to.x), Math.min(from.y, to.y), Math.abs(from.x - to.x), Math.abs(from.y - to.y)];
  const end = () => {
    frame?.remove();
    from = frame = null;
  };
  svg.addEventListener("pointerdown", (event) => {
    if (event.pointerType !== "mouse" || event.button !== 0) return;
    event.preventDefault();
    svg.setPointerCapture(event.pointerId);
    from = inPicture(svg, event);
    frame = svg.appendChild(document.createElementNS("http://www.w3.org/2000/svg", "rect"));
    frame.setAttribute("class", "drag");
  });
  svg.addEventListener("pointermove", (event) => {
    if (!from) return;
    ["x", "y", "width", "height"].forEach((name, k) => frame.setAttribute(name, rectangle(inPicture(svg, event))[k]));
  });
  svg.addEventListener("pointerup", (event) => {
    if (!from) return;
    const box = rectangle(inPicture(svg, event));
    if (box[2] > 8 && box[3] > 8) svg.setAttribute("viewBox", box.join(" "));
    end();
  });
  svg.addEventListener("pointercancel", end);
  svg.addEventListener("dblclick", () => svg.setAttribute("viewBox", whole));
}

for (const svg of document.querySelectorAll("svg.still")) {
  const marks = [...svg.querySelectorAll("title")].map((title) => {
    const mark = title.parentNode;
    mark.dataset.tip = title.textContent;
    mark.setAttribute("aria-label", title.textContent);
    title.remove();
    return mark;
  });
  const say = (event) => showTip(nearest(marks, event)?.dataset.tip, event);
  svg.addEventListener("pointermove", say);
  svg.addEventListener("click", say);
  svg.addEventListener("pointerleave", (event) => showTip("", event));
  lookCloser(svg);
}
document.documentElement.classList.add("drawn");
