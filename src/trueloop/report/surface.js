// Shows the maps of the part that is chosen: flat ones by the fill of their marks, the one in space drawn anew.
"use strict";

const choice = document.getElementById("choice");
const { range, stops, parts } = JSON.parse(choice.querySelector("script").textContent);

function colour(error) {
  if (error === null || Number.isNaN(error)) return "#c8ced4";
  const share = Math.min(1, Math.max(0, (error / range + 1) / 2));
  const k = Math.min(stops.findLastIndex(([at]) => at <= share), stops.length - 2);
  const [[low, from], [high, to]] = [stops[k], stops[k + 1]];
  const mixed = from.map((a, i) => Math.round(a + ((to[i] - a) * (share - low)) / (high - low)));
  return `rgb(${mixed.join(",")})`;
}

function dots(figure, uv) {
  const frame = figure.querySelector("svg .frame");
  const [x, y, wide, high] = ["x", "y", "width", "height"].map((name) => Number(frame.getAttribute(name)));
  const marks = figure.querySelector("svg .marks");
  const dot = marks.firstElementChild;
  marks.replaceChildren(...uv[0].map((u, i) => {
    const one = dot.cloneNode();
    one.setAttribute("cx", x + uv[1][i] * wide);
    one.setAttribute("cy", y + (1 - u) * high);
    return one;
  }));
}

function show(part) {
  for (const { name, title, said, error } of part.maps) {
    const figure = document.getElementById(name);
    if (part.uv) dots(figure, part.uv);
    const marks = figure.querySelector("svg .marks").children;
    error.flat().forEach((value, i) => marks[i].setAttribute("fill", colour(value)));
    figure.querySelector("figcaption").innerHTML = said;
    space.repaint(name, title, error.flat(), part.xyz);
  }
}

const select = choice.querySelector("select");
select.addEventListener("change", () => show(parts[select.selectedIndex]));

// The surface in space: parallel projection, farthest first. Heights are drawn as they are, in the scale of the sides.
const space = (() => {
  const figure = document.getElementById("space");
  const canvas = figure.querySelector("canvas");
  const pen = canvas.getContext("2d");
  const list = figure.querySelector("select");
  const { places, maps } = JSON.parse(figure.querySelector("script").textContent);
  for (const map of maps) Object.assign(map, places[map.at]);
  let [turn, tilt] = [-0.5, 0.95];
  let drawn = [];

  function frameOf({ xyz }) {
    const widened = ([low, high], a) => [Math.min(low, a), Math.max(high, a)];
    const ends = xyz.map((along) => along.reduce(widened, [Infinity, -Infinity]));
    const middle = ends.map(([low, high]) => (low + high) / 2);
    return { middle, half: Math.hypot(...ends.map(([low, high]) => high - low)) / 2, ends };
  }

  function projection({ middle, half }) {
    const scale = (0.42 * Math.min(canvas.width, 1.9 * canvas.height)) / (half || 1);
    const [ct, st, ci, si] = [Math.cos(turn), Math.sin(turn), Math.cos(tilt), Math.sin(tilt)];
    return (x, y, z) => {
      const [a, b, c] = [x - middle[0], y - middle[1], z - middle[2]];
      const [right, away] = [a * ct - b * st, a * st + b * ct];
      return [canvas.width / 2 + scale * right, canvas.height / 2 - scale * (away * ci + c * si), away * si - c * ci];
    };
  }

  function patches({ rows, xyz, error }, at) {
    drawn = xyz[0].map((x, i) => at(x, xyz[1][i], xyz[2][i]));
    if (!rows) return drawn.map((corner, i) => ({ far: corner[2], corners: [corner], error: error[i] }));
    const columns = drawn.length / rows;
    const found = [];
    for (let i = 0; i + 1 < rows; i++) {
      for (let j = 0; j + 1 < columns; j++) {
        const four = [i * columns + j, i * columns + j + 1, (i + 1) * columns + j + 1, (i + 1) * columns + j];
        const mean = (of) => four.reduce((sum, k) => sum + of(k), 0) / 4;
        const known = four.every((k) => error[k] !== null);
        const corners = four.map((k) => drawn[k]);
        found.push({ far: mean((k) => drawn[k][2]), corners, error: known ? mean((k) => error[k]) : null });
      }
    }
    return found;
  }

  function axes({ ends: [[x0, x1], [y0, y1], [z0]] }, at) {
    pen.strokeStyle = pen.fillStyle = "#6b7885";
    pen.font = "26px sans-serif";
    pen.lineWidth = 2;
    for (const [name, end, low, high] of [["x", [x1, y0], x0, x1], ["y", [x0, y1], y0, y1]]) {
      const [a, b] = [at(x0, y0, z0), at(...end, z0)];
      pen.beginPath();
      pen.moveTo(a[0], a[1]);
      pen.lineTo(b[0], b[1]);
      pen.stroke();
      pen.fillText(`${name} ${low.toFixed(1)} … ${high.toFixed(1)}`, (a[0] + b[0]) / 2 + 10, (a[1] + b[1]) / 2 + 36);
    }
  }

  function draw() {
    const map = maps[list.selectedIndex];
    const frame = frameOf(map);
    const at = projection(frame);
    pen.clearRect(0, 0, canvas.width, canvas.height);
    axes(frame, at);
    pen.lineWidth = 1;
    for (const { corners, error } of patches(map, at).sort((a, b) => b.far - a.far)) {
      pen.fillStyle = pen.strokeStyle = colour(error);
      pen.beginPath();
      if (corners.length === 1) pen.arc(corners[0][0], corners[0][1], 6, 0, 2 * Math.PI);
      else corners.forEach(([x, y], k) => (k ? pen.lineTo(x, y) : pen.moveTo(x, y)));
      pen.closePath();
      pen.fill();
      pen.stroke();
    }
  }

  function say(event) {
    const box = canvas.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top].map((px) => (px * canvas.width) / box.width);
    const { xyz, error } = maps[list.selectedIndex];
    let [best, least] = [-1, (20 * canvas.width) / box.width];
    drawn.forEach(([a, b, far], i) => {
      const apart = Math.hypot(a - x, b - y) + 1e-6 * far;
      if (apart < least) [best, least] = [i, apart];
    });
    if (best < 0) return showTip("", event);
    const place = ["x", "y", "z"].map((axis, k) => `${axis} ${xyz[k][best].toFixed(3)}`).join(" ");
    showTip(`${place} mm\n${error[best] === null ? "not measured" : `${error[best].toFixed(2)} µm`}`, event);
  }

  function turned(by, up) {
    turn += by;
    tilt = Math.min(Math.PI / 2, Math.max(0.05, tilt + up));
    draw();
  }

  canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener("pointermove", (event) => {
    if (event.buttons) turned(event.movementX / 150, -event.movementY / 150);
    else say(event);
  });
  canvas.addEventListener("pointerleave", (event) => showTip("", event));
  canvas.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] }[event.key];
    if (!step) return;
    event.preventDefault();
    turned(...step);
  });
  list.addEventListener("change", draw);
  draw();

  return {
    repaint(name, title, error, xyz) {
      const k = maps.findIndex((one) => one.name === name);
      maps[k].error = error;
      if (xyz) maps[k].xyz = xyz;
      list.options[k].innerHTML = title;
      draw();
    },
  };
})();
