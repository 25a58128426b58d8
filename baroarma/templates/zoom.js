"use strict";
// Zooms figures.  Shapes are stretched, marks moved, long lines and ticks drawn anew, from the view that
// `baroarma.zoomable` left in data-view.  Places are in units of the drawing: x to the right, y down.

const STEPS_X = 2 ** 24, STEPS_Y = 30000, NO_SAMPLE = -32768, COLUMNS = 700, CLOSEST = 1e-5;
const HINT = matchMedia("(pointer: coarse)").matches ? "pinch to zoom" : "drag to zoom, double-click for all";

async function decode(code) {
  const bytes = Uint8Array.from(atob(code), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const data = new DataView(await new Response(stream).arrayBuffer()), n = data.byteLength / 6;
  const x = new Float64Array(n), y = new Float64Array(n);
  for (let k = 0, sum = 0; k < n; k++) {
    x[k] = (sum += data.getInt32(4 * k, true)) / STEPS_X;
    const step = data.getInt16(4 * n + 2 * k, true);
    y[k] = step === NO_SAMPLE ? NaN : step / STEPS_Y;
  }
  return { x, y };
}

// Least and greatest of each column where there are many samples; a pen up where one is missing.
function outline({ x, y }, [from, to], place) {
  const after = (v) => { let a = 0, b = x.length; while (a < b) { const m = (a + b) >> 1; x[m] < v ? a = m + 1 : b = m; } return a; };
  const first = Math.max(after(from) - 1, 0), last = Math.min(after(to) + 1, x.length);
  const size = last - first > 2 * COLUMNS ? Math.ceil((last - first) / COLUMNS) : 1;
  let d = "", pen = "M";
  for (let k = first; k < last; k += size) {
    const group = y.subarray(k, Math.min(k + size, last));
    for (const v of size > 1 ? [Math.min(...group), Math.max(...group)] : group) {
      if (isNaN(v)) { pen = "M"; continue; }
      d += pen + place(x[k], v).map((p) => p.toFixed(2)).join(" ");
      pen = "L";
    }
  }
  return d;
}

// Round numbers from lo to hi, about as many as asked for, with their labels.
function ticks(lo, hi, log, count) {
  if (log && hi > 8 * lo) {
    const factors = hi > 100 * lo ? [1] : [1, 2, 5], found = [];
    for (let e = Math.floor(Math.log10(lo)); e <= Math.log10(hi); e++) {
      found.push(...factors.map((f) => f * 10 ** e).filter((v) => v >= lo && v <= hi));
    }
    return found.map((v) => [v, label(Number(v.toPrecision(1)).toString())]);
  }
  const least = (hi - lo) / count, ten = 10 ** Math.floor(Math.log10(least));
  const step = ten * [1, 2, 5, 10].find((f) => f * ten >= least * 0.999);
  const digits = Math.max(0, -Math.floor(Math.log10(step * 1.001))), found = [];
  for (let k = Math.ceil(lo / step); k * step <= hi; k++) found.push([k * step, label((k * step).toFixed(digits))]);
  return found;
}

const label = (text) => text.replace(/^-/, "\u2212").replace(/^\u2212(0(\.0*)?)$/, "$1");

function zoomable(figure) {
  const svg = figure.querySelector("svg"), view = JSON.parse(figure.dataset.view);
  const [left, top, width, height] = view.box, ends = { x: [left, left + width], y: [top, top + height] };
  const fingers = new Map();
  let shown = { ...ends }, start = null;

  const make = (tag, attributes) => {
    const element = document.createElementNS(svg.namespaceURI, tag);
    for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
    return element;
  };
  const shapes = [...svg.querySelectorAll("[clip-path]:not([class|=tick])")].map((shape) => {
    const clip = make("g", { "clip-path": shape.getAttribute("clip-path") });
    shape.removeAttribute("clip-path");
    shape.replaceWith(clip);
    clip.append(shape);
    const curve = clip.closest("[data-curve]"), marks = [...shape.querySelectorAll("use")];
    return { shape, still: shape.getAttribute("d"), code: curve && view.curves[curve.dataset.curve],
      marks: marks.map((mark) => ({ mark, x: +mark.getAttribute("x"), y: +mark.getAttribute("y") })) };
  });
  const samples = {}; // of each axis, what new ticks are made of
  for (const axis of ["x", "y"]) {
    samples[axis] = ["text", "use", "path[clip-path]"].map((s) => svg.querySelector(`${s}.tick-${axis}`));
    samples[axis].room = Math.max(0, ...[...svg.querySelectorAll(`text.tick-${axis}`)].map((t) => t.getBBox().width));
  }
  const fresh = svg.appendChild(make("g", {})), mark = svg.appendChild(make("path", { class: "mark", d: "" }));

  // Where a place of the whole drawing is now, and what is at a place now; a value's place and back.
  const now = (axis, p) => ends[axis][0] + (p - shown[axis][0]) * (span(ends[axis]) / span(shown[axis]));
  const behind = (axis, p, range = shown) => range[axis][0] + (p - ends[axis][0]) * (span(range[axis]) / span(ends[axis]));
  const span = ([a, b]) => b - a;
  const zoomed = () => ["x", "y"].some((axis) => span(shown[axis]) < span(ends[axis]) * 0.9999);
  const scaled = (axis) => view[axis].limits.map((v) => (view[axis].log ? Math.log10(v) : v));
  const value = (axis, p) => {
    const [lo, hi] = scaled(axis), part = (p - ends[axis][0]) / span(ends[axis]);
    const v = lo + (hi - lo) * (axis === "x" ? part : 1 - part);
    return view[axis].log ? 10 ** v : v;
  };
  const place = (axis, v) => {
    const [lo, hi] = scaled(axis), part = ((view[axis].log ? Math.log10(v) : v) - lo) / (hi - lo);
    return ends[axis][0] + span(ends[axis]) * (axis === "x" ? part : 1 - part);
  };
  const range = (axis) => shown[axis].map((p) => value(axis, p)).sort((a, b) => a - b);

  function show(wanted) {
    shown = {};
    for (const axis of ["x", "y"]) {
      const [lo, hi] = ends[axis], size = Math.min(Math.max(span(wanted[axis]), CLOSEST * (hi - lo)), hi - lo);
      const a = Math.min(Math.max(wanted[axis][0], lo), hi - size);
      shown[axis] = [a, a + size];
    }
    figure.classList.toggle("zoomed", zoomed());
    shapes.forEach(redraw);
    fresh.replaceChildren(...(zoomed() ? ["x", "y"].flatMap(newTicks) : []));
    for (const words of fresh.querySelectorAll("text.y")) narrow(words, samples.y.room);
    for (const button of buttons) button.disabled = button.dataset.whole !== "" && !zoomed();
    figure.dataset.shown = JSON.stringify({ x: range("x"), y: range("y") });
    says.textContent = zoomed() ? ["x", "y"].map((axis) => told(axis, ...range(axis))).join(", ") : HINT;
  }

  function redraw(entry) {
    const { shape, still, code, marks } = entry;
    for (const { mark, x, y } of marks) { mark.setAttribute("x", now("x", x)); mark.setAttribute("y", now("y", y)); }
    if (marks.length) return;
    const [sx, sy] = ["x", "y"].map((axis) => span(ends[axis]) / span(shown[axis]));
    if (still) shape.setAttribute("d", still);
    shape.setAttribute("transform", `matrix(${sx} 0 0 ${sy} ${now("x", 0)} ${now("y", 0)})`);
    if (!zoomed()) shape.removeAttribute("transform");
    else if (code) redrawFine(entry, shown);
  }

  async function redrawFine(entry, current) {
    try {
      const curve = await (entry.curve ??= decode(entry.code));
      if (shown !== current) return;
      const at = (x, y) => [now("x", left + x * width), now("y", top + (1 - y) * height)];
      entry.shape.setAttribute("d", outline(curve, shown.x.map((p) => (p - left) / width), at));
      entry.shape.removeAttribute("transform");
    } catch { /* an old browser: the still picture's line, stretched */ }
  }

  function newTicks(axis) {
    if (samples[axis].includes(null)) return [];
    const wanted = axis === "x" ? width / 55 : height / 32;
    return ticks(...range(axis), view[axis].log, wanted).flatMap(([v, text]) => {
      const parts = samples[axis].map((part) => part.cloneNode(true)), [words, dash, line] = parts;
      const p = now(axis, place(axis, v)), shift = p - dash.getAttribute(axis);
      for (const part of parts) part.setAttribute("class", axis);
      words.textContent = text;
      words.removeAttribute("transform");
      words.setAttribute(axis, +words.getAttribute(axis) + shift);
      dash.setAttribute(axis, p);
      line.setAttribute("d", axis === "x" ? `M${p} ${top}v${height}` : `M${left} ${p}h${width}`);
      return parts;
    });
  }

  // Two values of an axis, or one, with its name and unit, as exactly as the zoom lets them be read.
  function told(axis, ...values) {
    const [, name, unit] = view[axis].label.match(/^(.*?)(?: \((.*)\))?$/s), [lo, hi] = range(axis);
    const digits = Math.max(0, Math.ceil(-Math.log10((hi - lo) / 300)));
    const text = (v) => (view[axis].log ? Number(v.toPrecision(3)).toString() : v.toFixed(Math.min(digits, 9)));
    return `${name} ${values.map((v) => label(text(v))).join(" to ")} ${unit ?? ""}`.trim();
  }

  const bar = figure.insertBefore(document.createElement("div"), svg.nextSibling);
  bar.className = "zoom";
  const says = bar.appendChild(document.createElement("output"));
  const middle = () => (shown.x[0] + shown.x[1]) / 2;
  const stretched = (factor, about) => ({ ...shown, x: shown.x.map((p) => about + (p - about) * factor) });
  const moved = (x, y = 0, from = shown) => ({ x: from.x.map((p) => p + x), y: from.y.map((p) => p + y) });
  const buttons = [
    ["+", "Zoom in", () => stretched(1 / 2, middle()), ""],
    ["\u2212", "Zoom out", () => stretched(2, middle())],
    ["\u2190", "Move left", () => moved(-span(shown.x) / 4)],
    ["\u2192", "Move right", () => moved(span(shown.x) / 4)],
    ["all", "Show all", () => ends],
  ].map(([text, title, wanted, whole]) => {
    const button = bar.appendChild(document.createElement("button"));
    Object.assign(button, { type: "button", textContent: text, title, onclick: () => show(wanted()) });
    button.setAttribute("aria-label", `${title}: ${svg.getAttribute("aria-label")}`);
    if (whole !== undefined) button.dataset.whole = whole; // of use when all is shown, too
    return button;
  });

  const clamp = (axis, p) => Math.min(Math.max(p, ends[axis][0]), ends[axis][1]);
  function spot(event) {
    const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    return { x: clamp("x", x), y: clamp("y", y) };
  }
  function point({ x, y }) {
    mark.setAttribute("d", `M${x} ${top}v${height}M${left} ${y}h${width}`);
    says.textContent = `${told("x", value("x", behind("x", x)))}, ${told("y", value("y", behind("y", y)))}`;
  }
  // Two fingers keep what is under them, along the axis along which they lie.
  function pinch() {
    const [[a, b], [c, d]] = [start.spots, [...fingers.values()]];
    const axis = Math.abs(a.x - b.x) > Math.abs(a.y - b.y) ? "x" : "y";
    const [u, v] = [a, b].map((p) => behind(axis, p[axis], start.shown));
    const slope = (v - u) / (d[axis] - c[axis]);
    if (slope > 0) show({ ...start.shown, [axis]: ends[axis].map((p) => u + (p - c[axis]) * slope) });
  }
  // The rectangle from where the drag began; one that is nearly a line spans the other axis.
  function chosen(end) {
    const [w, h] = ["x", "y"].map((axis) => Math.abs(end[axis] - start.spots[0][axis]));
    const sides = (axis, size) => (size < 8 ? ends[axis] : [end[axis], start.spots[0][axis]].sort((p, q) => p - q));
    return w < 8 && h < 8 ? null : { x: sides("x", w), y: sides("y", h) };
  }
  function begin(event) {
    if (event.button) return;
    fingers.set(event.pointerId, spot(event));
    start = { spots: [...fingers.values()], shown, drags: event.pointerType === "mouse" && !event.shiftKey };
    if (event.pointerType === "mouse") svg.setPointerCapture(event.pointerId);
    point(spot(event));
  }
  function move(event) {
    const at = spot(event), down = fingers.has(event.pointerId);
    if (down) fingers.set(event.pointerId, at);
    if (!down) return point(at);
    if (fingers.size === 2) return pinch();
    if (!start.drags) {
      const [x, y] = ["x", "y"].map((a) => (start.spots[0][a] - at[a]) * (span(start.shown[a]) / span(ends[a])));
      return show(moved(x, event.pointerType === "mouse" ? y : 0, start.shown));
    }
    const box = chosen(at);
    if (box) mark.setAttribute("d", `M${box.x[0]} ${box.y[0]}H${box.x[1]}V${box.y[1]}H${box.x[0]}Z`);
  }
  function end(event) {
    const box = fingers.delete(event.pointerId) && event.type === "pointerup" && start.drags && chosen(spot(event));
    if (box) show({ x: box.x.map((p) => behind("x", p)), y: box.y.map((p) => behind("y", p)) });
    start = { spots: [...fingers.values()], shown, drags: false };
    mark.setAttribute("d", "");
  }
  function wheel(event) {
    if (!event.ctrlKey) return;
    event.preventDefault();
    show(stretched(Math.exp(Math.max(-1, Math.min(1, event.deltaY / 100))), behind("x", spot(event).x)));
  }
  const on = (names, act) => names.split(" ").forEach((name) => svg.addEventListener(name, act, { passive: false }));
  on("pointerdown", begin);
  on("pointermove", move);
  on("pointerup pointercancel", end);
  on("pointerleave", () => mark.setAttribute("d", ""));
  on("dblclick", () => show(ends));
  on("wheel", wheel);
  figure.classList.add("zoomable");
  show(ends);
}

// Text may be drawn narrower than it is, not into its neighbour.
function narrow(words, room) {
  const { width } = words.getBBox();
  if (width > room) words.style.fontSize = `${(parseFloat(getComputedStyle(words).fontSize) * room) / width}px`;
}

document.querySelectorAll("figure[data-view]").forEach(zoomable);
