// Shows the maps of the part that is chosen: flat ones by the fill of their marks, the one in space by its traces.
"use strict";

const choice = document.getElementById("choice");
const space = document.querySelector("#space .plot");
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
    const trace = space.data.findIndex((one) => one.name === name);
    const [x, y, z] = part.xyz ?? [];
    Plotly.restyle(space, part.xyz ? { x: [x], y: [y], z: [z], "marker.color": [error] } : { surfacecolor: [error] }, [trace]);
    Plotly.relayout(space, { [`updatemenus[0].buttons[${trace}].label`]: title });
  }
}

const select = choice.querySelector("select");
select.addEventListener("change", () => show(parts[select.selectedIndex]));
