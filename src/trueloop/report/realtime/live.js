// The live trace: bands of the last minute on a canvas, and texts by their id, as the server tells them.
const layout = JSON.parse(document.getElementById("panels").textContent);
const canvas = document.getElementById("live");
const MARGIN = { left: 70, right: 12, top: 10, bottom: 34 };
const PANEL = 150;
const GAP = 18;
const stretches = [];

function roundStep(span, about) {
  const power = 10 ** Math.floor(Math.log10(span / about));
  return [1, 2, 5, 10].map((m) => m * power).find((step) => step >= (span / about) * (1 - 1e-9));
}

function range(panel) {
  let low = panel.zero ? 0 : Infinity;
  let high = panel.zero ? 0 : -Infinity;
  for (const stretch of stretches) {
    for (const [name] of panel.lines) {
      if (stretch.low[name] === null) continue;
      low = Math.min(low, stretch.low[name]);
      high = Math.max(high, stretch.high[name]);
    }
  }
  if (low > high) [low, high] = [0, 0];
  const pad = 0.08 * Math.max(high - low, 0.1);
  return [low - pad, high + pad];
}

function axes(pen, panel, box, scale) {
  pen.strokeStyle = "#e6eaee";
  pen.fillStyle = "#1d2733";
  pen.lineWidth = 1;
  pen.textAlign = "right";
  const step = roundStep(scale.high - scale.low, 5);
  for (let k = Math.ceil(scale.low / step); k * step <= scale.high; k++) {
    const y = scale.y(k * step);
    pen.beginPath();
    pen.moveTo(box.left, y);
    pen.lineTo(box.left + box.width, y);
    pen.stroke();
    pen.fillText(String(Number((k * step).toPrecision(8))).replace("-", "−"), box.left - 8, y + 4);
  }
  pen.save();
  pen.translate(14, box.top + box.height / 2);
  pen.rotate(-Math.PI / 2);
  pen.textAlign = "center";
  pen.fillText(panel.title, 0, 0);
  pen.restore();
  pen.strokeStyle = "#aab4be";
  pen.strokeRect(box.left, box.top, box.width, box.height);
}

function bands(pen, panel, box, scale) {
  pen.save();
  pen.beginPath();
  pen.rect(box.left, box.top, box.width, box.height);
  pen.clip();
  pen.fillStyle = layout.alarm + "24";
  for (const stretch of stretches) {
    if (stretch.alarm) pen.fillRect(scale.x(stretch.from), box.top, scale.x(stretch.to) - scale.x(stretch.from), box.height);
  }
  for (const [name, colour] of panel.lines) {
    pen.fillStyle = colour;
    for (const stretch of stretches) {
      if (stretch.low[name] === null) continue;
      const top = scale.y(stretch.high[name]);
      const height = Math.max(1.6, scale.y(stretch.low[name]) - top);
      pen.fillRect(scale.x(stretch.from), top - 0.8, Math.max(1, scale.x(stretch.to) - scale.x(stretch.from)), height);
    }
  }
  pen.restore();
}

function draw() {
  const height = MARGIN.top + MARGIN.bottom + layout.panels.length * (PANEL + GAP) - GAP;
  const ratio = window.devicePixelRatio || 1;
  canvas.width = 1000 * ratio;
  canvas.height = height * ratio;
  const pen = canvas.getContext("2d");
  pen.scale(ratio, ratio);
  pen.font = "13px system-ui, sans-serif";
  if (!stretches.length) return;
  const end = Math.max(stretches[stretches.length - 1].to, stretches[0].from + 5);
  const begin = Math.max(stretches[0].from, end - layout.window_s);
  layout.panels.forEach((panel, k) => {
    const box = { left: MARGIN.left, top: MARGIN.top + k * (PANEL + GAP), width: 1000 - MARGIN.left - MARGIN.right, height: PANEL };
    const [low, high] = range(panel);
    const scale = {
      low,
      high,
      x: (time) => box.left + (box.width * (time - begin)) / (end - begin),
      y: (value) => box.top + (box.height * (high - value)) / (high - low),
    };
    axes(pen, panel, box, scale);
    bands(pen, panel, box, scale);
  });
  pen.fillStyle = "#1d2733";
  pen.textAlign = "center";
  const step = roundStep(end - begin, 10);
  for (let k = Math.ceil(begin / step); k * step <= end; k++) {
    const x = MARGIN.left + ((1000 - MARGIN.left - MARGIN.right) * (k * step - begin)) / (end - begin);
    pen.fillText(`${Number((k * step).toPrecision(8))} s`, x, height - 14);
  }
}

function take(tick) {
  for (const [id, text] of Object.entries(tick.said)) {
    const place = document.getElementById(id);
    if (place) place.textContent = text;
  }
  document.getElementById("state").style.borderLeftColor = tick.alarm ? layout.alarm : "";
  if (!("from" in tick)) return;
  stretches.push(tick);
  while (stretches[0].to < tick.to - layout.window_s) stretches.shift();
}

const source = new EventSource("events");
let due = false;
source.onmessage = (message) => {
  for (const tick of JSON.parse(message.data)) take(tick);
  if (due) return;
  due = true;
  requestAnimationFrame(() => {
    due = false;
    draw();
  });
};
source.addEventListener("end", (message) => {
  source.close();
  document.getElementById("state").textContent = message.data;
});
source.onerror = () => {
  if (source.readyState !== EventSource.CLOSED) document.getElementById("state").textContent = "the recorder does not answer";
};
