"use strict";
// The parts of the page that react: a chart of columns, maps of steps, figures, tables.

const data = JSON.parse(document.getElementById("data").textContent);

function element(name, attributes = {}, text = "") {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.textContent = text;
  return made;
}

function headed(column) {
  return column.unit ? `${column.label} (${column.unit})` : column.label;
}

function short(value) {
  return Number(value.toPrecision(5)).toString().replace("-", "\u2212");
}

function withUnit(value, unit) {
  return value === null || Number.isNaN(value) ? "not known" : `${short(value)} ${unit}`.trim();
}

function save(parts, name, type) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob(parts, { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

function csv(heads, rows) {
  const quoted = heads.map(head => `"${head.replaceAll('"', '""')}"`);
  return [quoted, ...rows].map(row => row.map(value => value ?? "nan").join(",")).join("\n") + "\n";
}

// Save text of SVG as a picture of pixels.
function savePng(text, { width, height }, name) {
  const image = new Image();
  image.onload = () => {
    const canvas = document.createElement("canvas");
    Object.assign(canvas, { width: 3 * width, height: 3 * height });
    const context = canvas.getContext("2d");
    context.fillStyle = "white";
    context.fillRect(0, 0, canvas.width, canvas.height);
    context.drawImage(image, 0, 0, canvas.width, canvas.height);
    canvas.toBlob(blob => save([blob], name, "image/png"));
  };
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(text)}`;
}

// Text of SVG for a file.
function pictureText(svg, { width, height }) {
  const attributes = { xmlns: "http://www.w3.org/2000/svg", width, height, "font-family": "sans-serif", "font-size": 13 };
  for (const [key, value] of Object.entries(attributes)) svg.setAttribute(key, value);
  return new XMLSerializer().serializeToString(svg);
}

// Round numbers between two limits, about `count`.
function ticks(low, high, count) {
  const rough = (high - low) / count, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].find(each => each * power >= rough) * power, found = [];
  for (let k = Math.ceil(low / step); k * step <= high + 1e-9 * step; k++) found.push(k * step);
  return found;
}

// Coordinates of ticks, and their values: powers of ten on a logarithmic axis.
function labelled(low, high, count, log) {
  if (!log) return ticks(low, high, count).map(value => [value, value]);
  if (high - low < 1)
    return ticks(10 ** low, 10 ** high, count).filter(value => value > 0).map(value => [Math.log10(value), value]);
  const every = Math.ceil((high - low) / count);
  return ticks(low, high, count).filter(power => power % every === 0).map(power => [power, 10 ** power]);
}

// Whether values are positive and differ by more than a factor of 100.
function spansDecades(values) {
  const known = values.filter(value => value !== null);
  return known.length > 0 && Math.min(...known) > 0 && Math.max(...known) > 100 * Math.min(...known);
}

class Chart {
  // Columns against each other, with errors, and theory where there is one.
  size = { width: 640, height: 400, left: 75, right: 15, top: 15, bottom: 50 };

  constructor(root) {
    this.root = root;
    this.filters = (data.filters ?? []).map(({ label, values }) => {
      const select = document.createElement("select"), words = document.createElement("label");
      for (const value of ["all", ...new Set(values)]) if (value) select.add(new Option(value));
      words.append(`${label} `, select);
      root.querySelector(".filters").append(words, " ");
      select.addEventListener("change", () => this.reset());
      return { select, values };
    });
    this.svg = root.querySelector("svg");
    this.output = root.querySelector("output");
    this.selects = { x: root.querySelector("[name=x]"), y: root.querySelector("[name=y]") };
    this.logs = { x: root.querySelector("[name=log-x]"), y: root.querySelector("[name=log-y]") };
    for (const axis of ["x", "y"]) {
      const select = this.selects[axis], log = this.logs[axis];
      for (const column of data.columns) select.add(new Option(headed(column), column.name));
      select.value = data[axis];
      const suits = () => { log.checked = spansDecades(this.column(axis).values); };
      suits();
      select.addEventListener("change", () => { suits(); this.reset(); });
      log.addEventListener("change", () => this.reset());
    }
    const press = (name, action) =>
      root.querySelector(`[name=${name}]`).addEventListener("click", action);
    press("closer", () => this.zoom(0.5, this.chosenPlace()));
    press("wider", () => this.zoom(2, this.chosenPlace()));
    press("whole", () => this.reset());
    press("csv", () => save([this.csv()], `${this.name()}.csv`, "text/csv"));
    press("svg", () => save([this.picture()], `${this.name()}.svg`, "image/svg+xml"));
    press("png", () => savePng(this.picture(), this.size, `${this.name()}.png`));
    this.svg.addEventListener("wheel", event => {
      if (document.activeElement !== this.svg) return; // the page moves
      event.preventDefault();
      this.zoom(event.deltaY < 0 ? 0.8 : 1.25, this.place(event));
    }, { passive: false });
    this.svg.addEventListener("pointerdown", event => this.begin(event));
    this.svg.addEventListener("pointermove", event => this.move(event));
    this.svg.addEventListener("pointerup", event => this.end(event));
    this.svg.addEventListener("pointercancel", () => { this.from = null; this.draw(); });
    this.svg.addEventListener("dblclick", () => this.reset());
    this.svg.addEventListener("keydown", event => this.key(event));
    this.reset();
    new ResizeObserver(() => this.draw()).observe(root);
  }

  column(axis) {
    return data.columns.find(column => column.name === this.selects[axis].value);
  }

  name() {
    return `${this.column("y").name}-${this.column("x").name}`;
  }

  // The whole range of both columns.
  reset() {
    this.points = [];
    const [x, y] = [this.column("x"), this.column("y")];
    x.values.forEach((value, row) => {
      const inside = axis => Number.isFinite(this.coordinate(axis, this.column(axis).values[row]));
      const wanted = this.filters.every(({ select, values }) => ["all", values[row]].includes(select.value));
      if (wanted && value !== null && y.values[row] !== null && inside("x") && inside("y"))
        this.points.push({ row, x: value, y: y.values[row], error: y.errors?.[row] ?? 0 });
    });
    const { theory } = data;
    this.lines = theory && theory.x === x.name && theory.y === y.name ? theory.lines : [];
    const range = (axis, values) => {
      values = values.map(value => this.coordinate(axis, value)).filter(Number.isFinite);
      let low = Math.min(...values), high = Math.max(...values);
      if (!values.length) [low, high] = [0, 1];
      const margin = 0.05 * (high - low || Math.abs(high) || 1);
      return [low - margin, high + margin];
    };
    const along = range("x", this.points.map(each => each.x));
    const beside = this.lines.flatMap(line => line.y.filter((_, i) => {
      const place = this.coordinate("x", line.x[i]);
      return along[0] <= place && place <= along[1];
    }));
    const found = this.points.flatMap(each => [each.y - each.error, each.y + each.error]);
    this.range = { x: along, y: range("y", [...found, ...beside.filter(value => value !== null)]) };
    this.unconverged = new Set(data.failed);
    this.chosen = -1;
    this.output.value = "";
    this.draw();
  }

  // Coordinate of a value along an axis: its logarithm on a logarithmic one.
  coordinate(axis, value) {
    if (value === null || !this.logs[axis].checked) return value;
    return value > 0 ? Math.log10(value) : NaN;
  }

  // Position of a coordinate in the picture.
  at(axis, coordinate) {
    const { width, height, left, right, top, bottom } = this.size;
    const [low, high] = this.range[axis], part = (coordinate - low) / (high - low);
    return axis === "x" ? left + part * (width - left - right)
      : height - bottom - part * (height - top - bottom);
  }

  // Position of a value in the picture, limited to its surroundings.
  of(axis, value) {
    const position = this.at(axis, this.coordinate(axis, value)), far = 1e4;
    return Number.isNaN(position) ? far : Math.min(Math.max(position, -far), far);
  }

  // Coordinates at the pointer.
  place(event) {
    const { width, height, left, right, top, bottom } = this.size;
    const box = this.svg.getBoundingClientRect();
    const parts = {
      x: ((event.clientX - box.left) * width / box.width - left) / (width - left - right),
      y: (height - bottom - (event.clientY - box.top) * height / box.height) / (height - top - bottom),
    };
    const place = {};
    for (const axis of ["x", "y"]) {
      const [low, high] = this.range[axis];
      place[axis] = low + Math.min(Math.max(parts[axis], 0), 1) * (high - low);
    }
    return place;
  }

  // Coordinates of the marked point, if there is one.
  chosenPlace() {
    const point = this.points[this.chosen];
    return point && { x: this.coordinate("x", point.x), y: this.coordinate("y", point.y) };
  }

  zoom(factor, about) {
    for (const axis of ["x", "y"]) {
      const [low, high] = this.range[axis], middle = about ? about[axis] : (low + high) / 2;
      this.range[axis] = [middle + factor * (low - middle), middle + factor * (high - middle)];
    }
    this.draw();
  }

  begin(event) {
    this.from = this.place(event);
    this.svg.setPointerCapture(event.pointerId);
  }

  move(event) {
    const here = this.place(event);
    if (this.from) {
      this.draw();
      const [x, y] = ["x", "y"].map(axis => [this.at(axis, this.from[axis]), this.at(axis, here[axis])]);
      this.svg.append(element("rect", {
        x: Math.min(...x), y: Math.min(...y), width: Math.abs(x[0] - x[1]), height: Math.abs(y[0] - y[1]),
        fill: "#0072b2", "fill-opacity": 0.15,
      }));
      return;
    }
    const distance = each =>
      Math.hypot(this.of("x", each.x) - this.at("x", here.x), this.of("y", each.y) - this.at("y", here.y));
    const distances = this.points.map(distance);
    this.choose(distances.indexOf(Math.min(...distances)));
  }

  end(event) {
    const here = this.place(event), from = this.from;
    this.from = null;
    const far = axis => Math.abs(this.at(axis, here[axis]) - this.at(axis, from[axis])) > 8;
    if (from && far("x") && far("y"))
      for (const axis of ["x", "y"])
        this.range[axis] = [from[axis], here[axis]].sort((a, b) => a - b);
    this.draw();
  }

  key(event) {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key], count = this.points.length;
    if (!step || !count) return;
    event.preventDefault();
    this.choose((this.chosen < 0 ? (step > 0 ? 0 : count - 1) : this.chosen + step + count) % count);
    const place = this.chosenPlace();
    for (const axis of ["x", "y"]) {
      const [low, high] = this.range[axis], half = (high - low) / 2;
      if (place[axis] < low || place[axis] > high) this.range[axis] = [place[axis] - half, place[axis] + half];
    }
    this.draw();
  }

  failed(row) {
    return this.unconverged.has(row);
  }

  // Mark a point and print its values.
  choose(number) {
    const point = this.points[number];
    if (!point) return;
    this.chosen = number;
    const [x, y] = [this.column("x"), this.column("y")];
    const error = point.error ? ` \u00b1 ${Number(point.error.toPrecision(2))}` : "";
    const row = data.labels?.[point.row] ?? `${data.rows} ${point.row}`;
    this.output.value = `${row}: ${x.label} ${withUnit(point.x, x.unit)}, ` +
      `${y.label} ${short(point.y)}${error} ${y.unit}${this.failed(point.row) ? ", not converged" : ""}`;
    this.draw();
  }

  draw() {
    const failed = this.points.filter(({ row }) => this.failed(row)).length;
    const marks = this.lines.length ? ["simulation"] : [];
    if (failed) marks.push("not converged");
    this.size.width = Math.round(Math.max(this.svg.getBoundingClientRect().width, 300));
    this.size.top = 15 + 17 * (this.lines.length + marks.length);
    this.size.height = 385 + this.size.top;
    const { width, height, left, right, top, bottom } = this.size;
    this.svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.svg.replaceChildren();
    const add = (name, attributes, text) => {
      const made = element(name, attributes, text);
      this.svg.append(made);
      return made;
    };
    const clip = add("clipPath", { id: "inside" });
    const frame = { x: left, y: top, width: width - left - right, height: height - top - bottom };
    clip.append(element("rect", frame));
    add("rect", { ...frame, fill: "white", stroke: "#666" });
    for (const [coordinate, value] of labelled(...this.range.x, Math.ceil(width / 110), this.logs.x.checked)) {
      const x = this.at("x", coordinate);
      add("line", { x1: x, x2: x, y1: top, y2: height - bottom, stroke: "#e4e4e4" });
      add("text", { x, y: height - bottom + 16, "text-anchor": "middle" }, short(value));
    }
    for (const [coordinate, value] of labelled(...this.range.y, 6, this.logs.y.checked)) {
      const y = this.at("y", coordinate);
      add("line", { x1: left, x2: width - right, y1: y, y2: y, stroke: "#e4e4e4" });
      add("text", { x: left - 5, y: y + 4, "text-anchor": "end" }, short(value));
    }
    add("text", { x: (left + width - right) / 2, y: height - 10, "text-anchor": "middle" }, headed(this.column("x")));
    const middle = (top + height - bottom) / 2;
    add("text", { x: 14, y: middle, "text-anchor": "middle", transform: `rotate(-90 14 ${middle})` }, headed(this.column("y")));
    const inside = add("g", { "clip-path": "url(#inside)" });
    const path = (x, y, attributes) => {
      const points = x.map((value, i) => [value, y[i]]).filter(([, each]) => each !== null);
      const text = points.map(([a, b]) => `${this.of("x", a)},${this.of("y", b)}`).join(" ");
      inside.append(element("polyline", { points: text, fill: "none", ...attributes }));
    };
    const colours = ["#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"], dashes = ["", "6 3", "2 3", "8 3 2 3"];
    this.lines.forEach((line, i) => {
      path(line.x, line.y, { stroke: colours[i % 5], "stroke-dasharray": dashes[i % 4], "stroke-width": 1.5 });
    });
    if (data.lines) path(this.points.map(p => p.x), this.points.map(p => p.y), { stroke: "#0072b2" });
    this.points.forEach((point, number) => {
      const [x, y] = [this.of("x", point.x), this.of("y", point.y)];
      if (point.error) {
        const ends = { y1: this.of("y", point.y - point.error), y2: this.of("y", point.y + point.error) };
        inside.append(element("line", { x1: x, x2: x, ...ends, stroke: "#0072b2" }));
      }
      const marked = number === this.chosen, colour = marked ? "#d55e00" : "#0072b2";
      const fill = this.failed(point.row) ? "white" : colour;
      inside.append(element("circle", { cx: x, cy: y, r: marked ? 6 : 3.5, fill, stroke: colour, "stroke-width": 1.5 }));
    });
    // the legend is above the frame
    marks.forEach((label, i) => {
      const fill = label === "simulation" ? "#0072b2" : "white";
      add("path", { d: `M${left + 18.5} ${13 + 17 * i} a3.5 3.5 0 1 0 7 0 a3.5 3.5 0 1 0 -7 0`, fill, stroke: "#0072b2", "stroke-width": 1.5 });
      add("text", { x: left + 42, y: 17 + 17 * i }, label);
    });
    this.lines.forEach((line, i) => {
      const y = 17 + 17 * (marks.length + i);
      add("line", { x1: left + 8, x2: left + 36, y1: y - 4, y2: y - 4, stroke: colours[i % 5], "stroke-dasharray": dashes[i % 4], "stroke-width": 1.5 });
      add("text", { x: left + 42, y }, line.label);
    });
  }

  csv() {
    const [x, y] = [this.column("x"), this.column("y")], heads = [data.rows, headed(x), headed(y)];
    if (y.errors) heads.push(headed({ ...y, label: `error of ${y.label}` }));
    if (data.failed) heads.push("converged");
    const rows = this.points.map(({ row }) => {
      const found = [row, x.values[row], y.values[row]];
      if (y.errors) found.push(y.errors[row]);
      if (data.failed) found.push(this.failed(row) ? 0 : 1);
      return found;
    });
    return csv(heads, rows);
  }

  picture() {
    return pictureText(this.svg.cloneNode(true), this.size);
  }
}

function bytes(text) {
  return Uint8Array.from(atob(text), character => character.charCodeAt(0));
}

class Maps {
  // Fields on the surface at some steps, on one colour scale for all steps.
  constructor(root) {
    this.root = root;
    this.canvas = root.querySelector("canvas");
    this.slider = root.querySelector("[type=range]");
    this.field = root.querySelector("[name=field]");
    this.title = root.querySelector(".title");
    this.output = root.querySelector(".value");
    this.mark = root.querySelector(".plane span");
    this.colours = bytes(data.maps.colours);
    this.fields = {};
    for (const { name } of data.maps.fields)
      if (data.maps.frames.every(frame => frame[name])) this.field.add(new Option(name.replaceAll("_", " "), name));
    this.slider.max = data.maps.frames.length - 1;
    this.slider.value = data.maps.shown;
    this.slider.parentElement.hidden = data.maps.frames.length < 2;
    this.slider.addEventListener("input", () => this.show());
    this.field.addEventListener("change", () => this.show());
    for (const name of ["pointermove", "pointerdown"])
      this.canvas.addEventListener(name, event => this.point(event));
    this.canvas.addEventListener("keydown", event => this.key(event));
    root.querySelector("[name=csv]").addEventListener("click", () => save([this.csv()], `${this.name()}.csv`, "text/csv"));
    root.querySelector("[name=svg]").addEventListener("click", () => save([this.picture()], `${this.name()}.svg`, "image/svg+xml"));
    root.querySelector("[name=png]").addEventListener("click", () => savePng(this.picture(), this.pictureSize, `${this.name()}.png`));
    this.show();
  }

  get frame() {
    return data.maps.frames[this.slider.value];
  }

  get unit() {
    return data.maps.fields.find(field => field.name === this.field.value).unit;
  }

  name() {
    return data.maps.frames.length < 2 ? this.field.value : `${this.field.value}-step-${this.frame.step}`;
  }

  // Values of all frames, and their limits, read once for each field.
  get all() {
    const name = this.field.value;
    if (!this.fields[name]) {
      const frames = data.maps.frames.map(frame => this.values(frame, name));
      const limit = (choose, start) =>
        frames.reduce((found, values) => values.reduce((a, b) => Number.isFinite(b) ? choose(a, b) : a, found), start);
      const zero = data.maps.from_zero ? 0 : undefined;
      const low = limit(Math.min, zero ?? Infinity), high = limit(Math.max, zero ?? -Infinity);
      this.fields[name] = { frames, low, high: high > low ? high : low + 1 };
    }
    return this.fields[name];
  }

  values(frame, name) {
    const raw = bytes(frame[name]), count = frame.x[2] * frame.y[2];
    if (name === "contact") return Array.from({ length: count }, (_, i) => (raw[i >> 3] >> (i & 7)) & 1);
    return Array.from(new Float32Array(raw.buffer), value => value / data.maps.scales[name]);
  }

  show() {
    const { frame, canvas } = this, [width, height] = [frame.x[2], frame.y[2]];
    const { frames, low, high } = this.all;
    Object.assign(this, { shown: frames[this.slider.value], low, high });
    Object.assign(canvas, { width, height });
    const context = canvas.getContext("2d"), image = context.createImageData(width, height);
    const blank = this.field.value === "pressure"; // nothing acts where it is zero
    for (let row = 0; row < height; row++) {
      for (let column = 0; column < width; column++) {
        const value = this.shown[this.index(column, row)], pixel = 4 * (row * width + column);
        if (!Number.isFinite(value) || (value === 0 && blank)) continue;
        const part = (value - this.low) / (this.high - this.low);
        const colour = 3 * Math.round(255 * Math.min(Math.max(part, 0), 1));
        image.data.set(this.colours.subarray(colour, colour + 3), pixel);
        image.data[pixel + 3] = 255;
      }
    }
    context.putImageData(image, 0, 0);
    this.title.value = frame.label;
    this.slider.setAttribute("aria-valuetext", frame.label);
    this.output.value = frame.every > 1 ? `one of ${frame.every} points along x and y; "ase-roughcontact maps" writes all` : "";
    const { width: side, height: other } = this.size;
    canvas.parentElement.style.maxWidth = `${side}px`;
    canvas.style.aspectRatio = `${side} / ${other}`;
    this.scale();
    if (this.at?.[0] < width && this.at?.[1] < height) this.read(...this.at);
  }

  // Lengths along x and y, with half a spacing on each side.
  get extent() {
    const spacing = ([first, last, count]) => count > 1 ? Math.abs(last - first) / (count - 1) : 0;
    const { x, y } = this.frame, steps = [spacing(x), spacing(y)];
    return [x[2] * (steps[0] || steps[1] || 1), y[2] * (steps[1] || steps[0] || 1)];
  }

  // Size of the map in pixels of the page.
  get size() {
    const [width, height] = this.extent, longest = Math.max(width, height);
    return { width: 416 * width / longest, height: 416 * height / longest };
  }

  get pictureSize() {
    return { width: 416, height: this.size.height + 90 };
  }

  // The map with its title, colours and scale, as text of SVG.
  picture() {
    const { width, height } = this.size, svg = element("svg"), below = element("g", { transform: `translate(0 ${height + 30})` });
    below.append(...[...this.root.querySelector(".scale").childNodes].map(each => each.cloneNode(true)));
    svg.append(
      element("text", { x: 0, y: 16 }, this.frame.label),
      element("rect", { y: 24, width, height, fill: "#f4f4f4" }),
      element("image", { y: 24, width, height, href: this.canvas.toDataURL(), preserveAspectRatio: "none", style: "image-rendering: pixelated" }),
      below,
    );
    return pictureText(svg, this.pictureSize);
  }

  // Index of the value at a place of the picture, whose first row is at the top.
  index(column, row) {
    const [width, height] = [this.frame.x[2], this.frame.y[2]];
    const y = data.maps.upward ? height - 1 - row : row;
    const x = data.maps.rightward ? column : width - 1 - column;
    return y * width + x;
  }

  scale() {
    const svg = this.root.querySelector(".scale"), parts = [], { width } = this.size;
    svg.setAttribute("viewBox", "0 0 416 56");
    for (let i = 0; i < 64; i++) {
      const colour = this.colours.subarray(12 * i, 12 * i + 3);
      parts.push(element("rect", { x: 3 * i, y: 2, width: 3.5, height: 12, fill: `rgb(${[...colour].join()})` }));
    }
    const ends = this.field.value === "contact" ? ["none", "", "contact"]
      : [0, 0.5, 1].map(part => short(Number((this.low + part * (this.high - this.low)).toPrecision(3))));
    ["start", "middle", "end"].forEach((anchor, i) => {
      parts.push(element("text", { x: 96 * i, y: 29, "text-anchor": anchor }, ends[i]));
    });
    const name = this.field.value.replaceAll("_", " ");
    parts.push(element("text", { x: 202, y: 13 }, this.unit ? `${name} (${this.unit})` : name));
    const [length] = this.extent, bar = ticks(0, length / 2, 3)[1];
    parts.push(element("rect", { x: 0, y: 44, width: width * bar / length, height: 4 }));
    parts.push(element("text", { x: width * bar / length + 8, y: 50 }, `${short(bar)} ${data.maps.length}`));
    svg.replaceChildren(...parts);
  }

  point(event) {
    const box = this.canvas.getBoundingClientRect(), { width, height } = this.canvas;
    this.read(
      Math.min(Math.floor((event.clientX - box.left) * width / box.width), width - 1),
      Math.min(Math.floor((event.clientY - box.top) * height / box.height), height - 1),
    );
  }

  key(event) {
    const moves = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const move = moves[event.key], { width, height } = this.canvas;
    if (!move) return;
    event.preventDefault();
    const [column, row] = this.at ?? [Math.floor(width / 2), Math.floor(height / 2)];
    this.read(
      Math.min(Math.max(column + move[0], 0), width - 1),
      Math.min(Math.max(row + move[1], 0), height - 1),
    );
  }

  place(axis, number) {
    const [first, last, count] = this.frame[axis];
    return count > 1 ? first + (last - first) * number / (count - 1) : first;
  }

  read(column, row) {
    this.at = [column, row];
    const index = this.index(column, row), width = this.frame.x[2];
    const x = this.place("x", index % width), y = this.place("y", Math.floor(index / width));
    const value = this.shown[index], { length } = data.maps;
    const text = this.field.value === "contact" ? ["no contact", "contact"][value] : withUnit(value, this.unit);
    this.output.value = `x ${short(x)} ${length}, y ${short(y)} ${length}: ${text}`;
    const part = (number, count) => `${100 * (number + 0.5) / count}%`;
    Object.assign(this.mark.style, { left: part(column, width), top: part(row, this.frame.y[2]) });
    this.mark.hidden = false;
  }

  csv() {
    const { frame } = this, width = frame.x[2], name = this.field.value;
    const rows = this.shown.map((value, index) =>
      [this.place("x", index % width), this.place("y", Math.floor(index / width)), value]);
    const { length } = data.maps;
    return csv([`x (${length})`, `y (${length})`, this.unit ? `${name} (${this.unit})` : name], rows);
  }
}

// Let a click on a heading sort the rows of a table by its column.
function sortable(table) {
  const [head, ...rows] = table.rows;
  [...head.cells].forEach((cell, column) => {
    const button = document.createElement("button");
    button.append(...cell.childNodes);
    cell.append(button);
    button.addEventListener("click", () => {
      const direction = cell.getAttribute("aria-sort") === "ascending" ? -1 : 1;
      for (const other of head.cells) other.removeAttribute("aria-sort");
      cell.setAttribute("aria-sort", direction > 0 ? "ascending" : "descending");
      const text = row => row.cells[column].textContent.replaceAll("\u2212", "-");
      const compare = (one, other) =>
        parseFloat(text(one)) - parseFloat(text(other)) || text(one).localeCompare(text(other), "en", { numeric: true });
      table.tBodies[0].append(...[...rows].sort((a, b) => direction * compare(a, b)));
    });
  });
}

// Let a slider show one of several pictures at a time.
function sliding(figure) {
  const images = [...figure.querySelectorAll("img")], label = figure.querySelector("label");
  const slider = label.querySelector("input"), output = label.querySelector("output");
  const show = () => {
    images.forEach((image, number) => image.classList.toggle("shown", number == slider.value));
    output.value = images[slider.value].dataset.depth;
    slider.setAttribute("aria-valuetext", output.value);
  };
  slider.value = images.findIndex(image => image.classList.contains("shown"));
  slider.addEventListener("input", show);
  figure.classList.add("sliding");
  label.hidden = false;
  show();
}

// Give a figure a button that saves its picture.
function savable(figure) {
  const button = document.createElement("button");
  button.textContent = "save PNG";
  button.addEventListener("click", () => {
    const image = figure.querySelector("img.shown") ?? figure.querySelector("img");
    save([bytes(image.src.split(",")[1])], image.dataset.name, "image/png");
  });
  figure.querySelector("figcaption").append(" ", button);
}

document.querySelectorAll(".needs-script").forEach(part => part.hidden = false);
if (data) new Chart(document.querySelector(".chart"));
if (data?.maps) new Maps(document.querySelector(".maps"));
document.querySelectorAll(".depths").forEach(sliding);
document.querySelectorAll("figure").forEach(savable);
document.querySelectorAll("table.steps").forEach(sortable);
addEventListener("beforeprint", () => document.querySelectorAll("details").forEach(part => part.open = true));
