import type uPlot from "uplot";

import { number } from "../format";
import { heightOf, type Colour, type Line, type Plot } from "./plot";

const DOT_PX = 4;
const SIXTH = "2a"; // opacity, after a colour of six hexadecimal digits
const WIDTH_PX = 7.5; // of a digit
const FONT = "13px system-ui, sans-serif";

/** The colour of a meaning as it is now, dark or light. */
function ink(colour: Colour | "text" | "body"): string {
  const name = colour === "text" || colour === "body" ? `--mantine-color-${colour}` : `--${colour}`;
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/** Values of a plot in the shape that uPlot takes: of a line with a band, its two edges come after it. */
export function dataOf(plot: Plot): uPlot.AlignedData {
  const edge = (line: Line, sign: number) =>
    line.values.map((value, k) => (value === null || line.band?.[k] == null ? null : value + sign * (line.band[k] ?? 0)));
  const columns = plot.lines.flatMap((line) => (line.band ? [line.values, edge(line, 1), edge(line, -1)] : [line.values]));
  return [plot.x, ...columns] as uPlot.AlignedData;
}

/** How uPlot is to show a plot; `now` gives the plot as it is when it is drawn. */
export function optionsOf(now: () => Plot, width: number, height: number, told: (at: number | null) => void): uPlot.Options {
  const plot = now();
  const series: uPlot.Series[] = [{}];
  const bands: uPlot.Band[] = [];
  for (const line of plot.lines) {
    series.push(seriesOf(line));
    if (!line.band) continue;
    bands.push({ series: [series.length, series.length + 1], fill: `${ink(line.colour)}${SIXTH}` });
    series.push({ ...NO_LINE }, { ...NO_LINE });
  }
  return {
    width,
    height,
    series,
    bands,
    legend: { show: false },
    cursor: { points: { size: 9 }, drag: { x: true, y: false } },
    scales: {
      x: { time: plot.time ?? false, range: (_, low, high) => widened(low, high) },
      y: { range: () => heightOf(now()) },
    },
    axes: [plot.time ? timeAxis(plot.xName) : axisOf(plot.xName, plot.xText, plot.whole), axisOf(plot.yName)],
    hooks: {
      drawClear: [(one) => below(one, now())],
      draw: [(one) => above(one, now())],
      setCursor: [(one) => told(one.cursor.idx ?? null)],
    },
  };
}

const NO_LINE: uPlot.Series = { width: 0, points: { show: false } };

function seriesOf({ colour, line = true, dots, dash, joined = false }: Line): uPlot.Series {
  const stroke = ink(colour);
  return {
    stroke,
    width: line ? 2 : 0,
    spanGaps: joined,
    pxAlign: 0,
    ...(dash ? { dash: [6, 4] } : {}),
    ...(line ? {} : { paths: () => null }),
    points: dots
      ? { show: true, size: 2 * DOT_PX, stroke, width: 2, fill: dots === "full" ? stroke : ink("body") }
      : { show: false },
  };
}

function widened(low: number, high: number): [number, number] {
  const air = 0.02 * (high - low) || 0.5;
  return [low - air, high + air];
}

function axisOf(name: string, say?: (at: number) => string, whole = false): uPlot.Axis {
  const grid = { stroke: ink("line"), width: 1 };
  const digits = (step: number) => Math.max(0, Math.min(7, -Math.floor(Math.log10(step))));
  return {
    label: name,
    labelFont: FONT,
    font: FONT,
    stroke: ink("text"),
    grid,
    ticks: grid,
    ...(whole ? { incrs: [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000] } : {}),
    ...(say ? { space: 70 } : { size: (_, said) => Math.max(56, 24 + WIDTH_PX * Math.max(0, ...(said ?? []).map((one) => one.length))) }),
    values: (_, places, __, ___, step) => places.map((at) => (say ? say(at) : number(at, digits(step)))),
  };
}

function timeAxis(name: string): uPlot.Axis {
  const form = new Intl.DateTimeFormat(document.documentElement.lang === "de" ? "de-DE" : "en-GB", { timeStyle: "short" });
  return { ...axisOf(name), values: (_, places) => places.map((at) => form.format(new Date(at * 1000))) };
}

/** Under the lines: what nobody has seen, and where something was wrong. */
function below(one: uPlot, plot: Plot): void {
  const { ctx, bbox } = one;
  ctx.save();
  const stretches = [...(plot.unseen ?? []).map((one) => [...one, "line"] as const), ...(plot.shaded ?? []).map((one) => [...one, "bad"] as const)];
  for (const [from, to, colour] of stretches) {
    ctx.globalAlpha = colour === "bad" ? 0.18 : 0.35;
    ctx.fillStyle = ink(colour);
    const left = Math.max(one.valToPos(from, "x", true), bbox.left);
    const right = Math.min(one.valToPos(to, "x", true), bbox.left + bbox.width);
    if (right > left) ctx.fillRect(left, bbox.top, right - left, bbox.height);
  }
  ctx.restore();
}

/** Over the lines: limits, what happened, and dots that stand by themselves. */
function above(one: uPlot, plot: Plot): void {
  const { ctx, bbox } = one;
  const px = devicePixelRatio;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  ctx.font = `${13 * px}px system-ui, sans-serif`;
  ctx.textAlign = "left";
  ctx.textBaseline = "alphabetic";
  ctx.lineWidth = 1.5 * px;
  for (const { at, name, colour = "bad" } of plot.levels ?? []) {
    const y = one.valToPos(at, "y", true);
    stroke(ctx, ink(colour), [6 * px, 4 * px], [bbox.left, y, bbox.left + bbox.width, y]);
    ctx.fillStyle = ink(colour);
    ctx.fillText(name, bbox.left + 6 * px, y - 4 * px);
  }
  for (const { at, name } of plot.uprights ?? []) {
    const x = one.valToPos(at, "x", true);
    stroke(ctx, ink("text"), [2 * px, 4 * px], [x, bbox.top, x, bbox.top + bbox.height]);
    ctx.fillStyle = ink("text");
    ctx.fillText(name, x + 4 * px, bbox.top + 14 * px);
  }
  for (const { x, y, colour, shape } of plot.marks ?? []) {
    const [left, top] = [one.valToPos(x, "x", true), one.valToPos(y, "y", true)];
    ctx.strokeStyle = ctx.fillStyle = ink(colour);
    ctx.setLineDash([]);
    ctx.beginPath();
    if (shape === "alarm") triangle(ctx, left, top, 9 * px);
    else ctx.arc(left, top, (shape === "open" ? 3 : 2.2) * px, 0, 2 * Math.PI);
    if (shape === "full") ctx.fill();
    else ctx.stroke();
  }
  ctx.restore();
}

function stroke(ctx: CanvasRenderingContext2D, colour: string, dash: number[], [x, y, toX, toY]: number[]): void {
  ctx.strokeStyle = colour;
  ctx.setLineDash(dash);
  ctx.beginPath();
  ctx.moveTo(x ?? 0, y ?? 0);
  ctx.lineTo(toX ?? 0, toY ?? 0);
  ctx.stroke();
}

function triangle(ctx: CanvasRenderingContext2D, x: number, y: number, size: number): void {
  ctx.moveTo(x, y - size);
  ctx.lineTo(x + size, y + size * 0.8);
  ctx.lineTo(x - size, y + size * 0.8);
  ctx.closePath();
}
