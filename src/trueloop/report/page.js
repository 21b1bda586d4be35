// Draws each figure from the specification that stands beside it, as wide as its place; still pictures go to paper only.
"use strict";

const CONFIG = { displaylogo: false, displayModeBar: "hover", modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"] };

function size(plot, paper) {
  const width = plot.clientWidth;
  const equalScale = paper.yaxis.scaleanchor !== undefined;
  return { width, height: equalScale ? Math.round((width * paper.height) / paper.width) : paper.height };
}

document.documentElement.classList.add("drawn");
for (const figure of document.querySelectorAll("figure:not(.map)")) {
  const plot = figure.querySelector(".plot");
  const { data, layout } = JSON.parse(figure.querySelector("script").textContent);
  const paper = { width: layout.width, height: layout.height, yaxis: { scaleanchor: layout.yaxis.scaleanchor } };
  Plotly.newPlot(plot, data, { ...layout, ...size(plot, paper) }, CONFIG);
  window.addEventListener("resize", () => Plotly.relayout(plot, size(plot, paper)));
}
