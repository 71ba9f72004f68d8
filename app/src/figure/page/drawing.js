// Shows what docs/drawing.md describes: one frame at a time, on a canvas or as SVG. No library, no request.
"use strict";

const Tendril = (() => {
  // Colours that stay apart for every kind of colour vision (Okabe and Ito), on a light and on a dark ground.
  const themes = {
    light: { ground: "#ffffff", ink: "#1c1c1c", soft: "#5c5c5c", grid: "#e8e8e6", obstacle: "#d5d5d3", edge: "#707070",
      rods: ["#0072b2", "#3d94c9"], body: "#bfdcec", force: "#d55e00", target: "#00835f", start: "#8a8a8a", doubt: "#8a8a8a", tips: "#b0588a", cone: "#f6d3bd", measured: "#9a6a00" },
    dark: { ground: "#14171a", ink: "#e9ebec", soft: "#a7adb1", grid: "#2a3035", obstacle: "#454c52", edge: "#8d959b",
      rods: ["#56b4e9", "#8fcdf2"], body: "#234a60", force: "#ff8a3c", target: "#1fc995", start: "#8d959b", doubt: "#8d959b", tips: "#e29ac4", cone: "#5a3520", measured: "#f0c04a" },
  };
  const font = 'system-ui, "DejaVu Sans", sans-serif';
  const frames_per_second = 12;

  const plus = (a, b) => [a[0] + b[0], a[1] + b[1]];
  const times = (a, s) => [a[0] * s, a[1] * s];
  const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);

  // Numbers -------------------------------------------------------------------------------------------------------

  const digits = (value, count = 5) => {
    if (value === 0) return "0";
    const size = Math.abs(value);
    return size >= 1e-3 && size < 1e6 ? String(Number(value.toPrecision(count))) : value.toExponential(Math.min(count - 1, 3));
  };

  const prefixes = [[1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "µ"], [1e-9, "n"]];

  // A quantity in the unit that suits it; lengths and moments in that of the drawing.
  function quantity(value, unit, length, count = 5) {
    if (unit === "") return digits(value, count);
    if (unit === "m") return `${digits(value / length.size, count)} ${length.name}`;
    if (unit === "1/m") return `${digits(value * length.size, count)} 1/${length.name}`;
    if (unit === "N m") return `${digits(value / length.size, count)} N ${length.name}`;
    if (unit === "rad") return `${digits(value, count)} rad (${digits((value * 180) / Math.PI, 4)}°)`;
    const [size, prefix] = prefixes.find(([s]) => Math.abs(value) >= s) || (value === 0 ? [1, ""] : [1e-9, "n"]);
    return `${digits(value / size, count)} ${prefix}${unit}`;
  }

  // Pens: the same strokes on a canvas and in an SVG file -----------------------------------------------------------

  class CanvasPen {
    constructor(context) { this.context = context; }
    path(points, style) { this.paths([points], style); }
    // Filled is what lies within an odd number of the lines.
    paths(lines, { stroke, width = 1, fill, dash = [], closed = false }) {
      const c = this.context;
      c.beginPath();
      for (const points of lines) {
        points.forEach((p, i) => (i ? c.lineTo(p[0], p[1]) : c.moveTo(p[0], p[1])));
        if (closed) c.closePath();
      }
      if (fill) { c.fillStyle = fill; c.fill("evenodd"); }
      if (!stroke) return;
      c.strokeStyle = stroke;
      c.lineWidth = width;
      c.lineJoin = c.lineCap = "round";
      c.setLineDash(dash);
      c.stroke();
      c.setLineDash([]);
    }
    disc(p, radius, { fill, stroke, width = 1 }) {
      const c = this.context;
      c.beginPath();
      c.arc(p[0], p[1], radius, 0, 2 * Math.PI);
      if (fill) { c.fillStyle = fill; c.fill(); }
      if (stroke) { c.strokeStyle = stroke; c.lineWidth = width; c.stroke(); }
    }
    text(p, string, { fill, align = "left", size = 14, halo }) {
      const c = this.context;
      c.font = `${size}px ${font}`;
      c.textAlign = align;
      c.textBaseline = "middle";
      if (halo) { c.strokeStyle = halo; c.lineWidth = 4; c.lineJoin = "round"; c.strokeText(string, p[0], p[1]); }
      c.fillStyle = fill;
      c.fillText(string, p[0], p[1]);
    }
  }

  class SvgPen {
    constructor() { this.parts = []; }
    static escape(text) { return text.replace(/[&<>"]/g, (c) => `&#${c.charCodeAt(0)};`); }
    path(points, style) { this.paths([points], style); }
    paths(lines, { stroke, width = 1, fill, dash = [], closed = false }) {
      const d = lines.map((points) => points.map((p, i) => `${i ? "L" : "M"}${p[0].toFixed(2)} ${p[1].toFixed(2)}`).join("") + (closed ? "Z" : "")).join("");
      this.parts.push(`<path d="${d}" fill="${fill || "none"}" fill-rule="evenodd" stroke="${stroke || "none"}" stroke-width="${width}"` +
        ` stroke-linejoin="round" stroke-linecap="round"${dash.length ? ` stroke-dasharray="${dash.join(" ")}"` : ""}/>`);
    }
    disc(p, radius, { fill, stroke, width = 1 }) {
      this.parts.push(`<circle cx="${p[0].toFixed(2)}" cy="${p[1].toFixed(2)}" r="${radius}" fill="${fill || "none"}"` +
        ` stroke="${stroke || "none"}" stroke-width="${width}"/>`);
    }
    text(p, string, { fill, align = "left", size = 14, halo }) {
      const anchor = { left: "start", center: "middle", right: "end" }[align];
      this.parts.push(`<text x="${p[0].toFixed(2)}" y="${p[1].toFixed(2)}" fill="${fill}" font-size="${size}" text-anchor="${anchor}"` +
        ` dominant-baseline="central"${halo ? ` stroke="${halo}" stroke-width="4" stroke-linejoin="round" paint-order="stroke"` : ""}>` +
        `${SvgPen.escape(string)}</text>`);
    }
    document(width, height) {
      return `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}"` +
        ` font-family="sans-serif">${this.parts.join("\n")}</svg>\n`;
    }
  }

  // The window ------------------------------------------------------------------------------------------------------

  const shapes_of = (drawing, frame) => [...drawing.obstacles, ...(frame.obstacles || [])];
  const pressed = (frame) => frame.contacts.filter((c) => c.force > 0 && c.normal);

  // Metres per newton of the arrows: the largest force of all frames is a fixed share of the rod.
  function arrow_size(drawing) {
    const most = Math.max(0, ...drawing.frames.flatMap((f) => pressed(f).map((c) => c.force)));
    return most > 0 ? (0.16 * drawing.length) / most : 0;
  }

  // Around an object, how far forces on it are held, in the size of the arrows of contact forces.
  const hold_line = ({ hold }, arrow) => (hold ? hold.forces.map((f) => plus(hold.center, times(f, arrow))) : []);

  // What every frame needs; of obstacles only what is near.
  function bounds_of(drawing) {
    const low = [Infinity, Infinity];
    const high = [-Infinity, -Infinity];
    const add = (p) => { for (const k of [0, 1]) { low[k] = Math.min(low[k], p[k]); high[k] = Math.max(high[k], p[k]); } };
    const arrow = arrow_size(drawing);
    for (const frame of drawing.frames) {
      for (const rod of frame.rods) { rod.line.forEach(add); (rod.body || []).forEach(add); (rod.band || []).forEach(add); }
      if (frame.target && frame.target.position) add(frame.target.position);
      for (const c of pressed(frame)) add(plus(c.surface, times(c.normal, 1.25 * arrow * c.force)));
      for (const list of ["palm", "measured", "tips", "path"]) (frame[list] || []).forEach(add);
      hold_line(frame, arrow).forEach(add);
    }
    (drawing.start || []).forEach(add);
    if (low[0] > high[0]) { add([0, 0]); add([drawing.length, 0]); }
    const near = 0.35 * drawing.length;
    const edges = [low.map((v) => v - near), high.map((v) => v + near)];
    for (const frame of drawing.frames) {
      for (const shape of shapes_of(drawing, frame)) {
        for (const p of shape.outlines.flat()) add([0, 1].map((k) => Math.min(Math.max(p[k], edges[0][k]), edges[1][k])));
      }
    }
    const margin = 0.07 * drawing.length;
    return { low: low.map((v) => v - margin), high: high.map((v) => v + margin) };
  }

  function fitted(bounds, width, height) {
    const scale = Math.min(width / (bounds.high[0] - bounds.low[0]), height / (bounds.high[1] - bounds.low[1]));
    return { scale, center: times(plus(bounds.low, bounds.high), 0.5) };
  }

  // Painting --------------------------------------------------------------------------------------------------------

  function paint(pen, scene) {
    const { drawing, frame, index, view, width, height, colors } = scene;
    const at = (p) => [width / 2 + (p[0] - view.center[0]) * view.scale, height / 2 - (p[1] - view.center[1]) * view.scale];
    const doubtful = frame.status !== undefined && frame.status !== "solved";
    pen.path([[0, 0], [width, 0], [width, height], [0, height]], { fill: colors.ground, closed: true });
    paint_axes(pen, scene, at);
    for (const shape of shapes_of(drawing, frame)) {
      const ignored = shape.ignored || frame.ignored;
      pen.paths(shape.outlines.map((line) => line.map(at)), { fill: ignored ? undefined : colors.obstacle, stroke: colors.edge, width: 1.4, dash: ignored ? [4, 4] : [], closed: true });
    }
    if (drawing.start) pen.path(drawing.start.map(at), { stroke: colors.start, width: 2, dash: [7, 6] });
    for (const p of frame.path || drawing.path || []) if (p) pen.disc(at(p), 2.2, { fill: colors.target });
    if (drawing.ordered) paint_tips(pen, drawing, index, at, colors);
    if (frame.palm) pen.path(frame.palm.map(at), { stroke: colors.edge, width: 4 });
    for (const c of pressed(frame)) paint_cone(pen, scene, c, at);
    frame.rods.forEach((rod) => { if (rod.band) pen.path(rod.band.map(at), { fill: colors.cone, closed: true }); });
    frame.rods.forEach((rod) => { if (rod.body) pen.path(rod.body.map(at), { fill: colors.body, stroke: colors.edge, width: 0.7, closed: true }); });
    frame.rods.forEach((rod, i) => {
      paint_clamp(pen, rod, at, colors);
      const color = doubtful ? colors.doubt : colors.rods[Math.min(i, 1)];
      pen.path(rod.line.map(at), { stroke: color, width: frame.rods.length > 2 ? 1.6 : rod.body ? 2.5 : 5, dash: doubtful ? [12, 8] : [] });
    });
    if (frame.hold) pen.path(hold_line(frame, scene.arrow).map(at), { stroke: colors.tips, width: 1.8, dash: [7, 4], closed: true });
    for (const p of frame.measured || []) pen.disc(at(p), 4.5, { stroke: colors.measured, width: 1.8 });
    for (const p of frame.tips || []) pen.disc(at(p), 3.5, { stroke: colors.tips, width: 1.6 });
    paint_contacts(pen, scene, at);
    if (frame.target && frame.target.position) paint_target(pen, frame.target, at, colors);
    if (drawing.gravity) paint_gravity(pen, drawing.gravity, width, colors);
  }

  function paint_axes(pen, { drawing, view, width, height, colors }, at) {
    const unit = drawing.length_unit;
    const rough = (90 / view.scale) / unit.size;
    const power = 10 ** Math.floor(Math.log10(rough));
    const step = power * [1, 2, 5, 10].find((k) => k * power >= rough);
    const label = (value) => String(Number(value.toPrecision(6)));
    for (const k of [0, 1]) {
      const half = (k ? height : width) / 2 / view.scale;
      const first = Math.ceil((view.center[k] - half) / unit.size / step);
      const last = Math.floor((view.center[k] + half) / unit.size / step);
      for (let i = first; i <= last && i - first < 200; ++i) {
        const world = [...view.center];
        world[k] = i * step * unit.size;
        const p = at(world);
        pen.path(k ? [[0, p[1]], [width, p[1]]] : [[p[0], 0], [p[0], height]], { stroke: colors.grid, width: 1 });
        if (k === 0 && p[0] > 100 && p[0] < width - 30) pen.text([p[0], height - 12], label(i * step), { fill: colors.soft, align: "center", size: 12 });
        if (k === 1 && p[1] > 12 && p[1] < height - 30) pen.text([6, p[1] - 9], label(i * step), { fill: colors.soft, size: 12 });
      }
    }
    pen.text([6, height - 12], `x, y in ${unit.name}`, { fill: colors.soft, size: 12 });
  }

  function paint_tips(pen, drawing, index, at, colors) {
    const tips = drawing.frames.map((f) => f.rods.length === 1 && f.rods[0].line.length ? f.rods[0].line[f.rods[0].line.length - 1] : null);
    for (let i = 1; i < tips.length; ++i) {
      if (tips[i - 1] && tips[i]) pen.path([at(tips[i - 1]), at(tips[i])], { stroke: colors.tips, width: i <= index ? 2 : 0.8 });
    }
  }

  // Where a rod is held: a line across it, with strokes behind it.
  function paint_clamp(pen, rod, at, colors) {
    if (rod.line.length < 2) return;
    const base = at(rod.line[0]);
    const next = at(rod.line[1]);
    const angle = rod.along ? -rod.along[0][1] : Math.atan2(next[1] - base[1], next[0] - base[0]);
    const along = [Math.cos(angle), Math.sin(angle)];
    const across = [-along[1], along[0]];
    const place = (u, v) => plus(base, plus(times(across, u), times(along, v)));
    pen.path([place(-24, 0), place(24, 0)], { stroke: colors.soft, width: 2 });
    for (let u = -24; u < 24; u += 8) pen.path([place(u + 8, 0), place(u, -8)], { stroke: colors.soft, width: 1.2 });
  }

  function paint_arrow(pen, from, to, color, width) {
    const size = distance(from, to);
    if (size < 1) return;
    const along = times(plus(to, times(from, -1)), 1 / size);
    const across = [-along[1], along[0]];
    const head = Math.min(11, size);
    const neck = plus(to, times(along, -head));
    pen.path([from, neck], { stroke: color, width });
    pen.path([to, plus(neck, times(across, head * 0.4)), plus(neck, times(across, -head * 0.4))], { fill: color, closed: true });
  }

  // What the force of a contact may be under friction.
  function paint_cone(pen, { arrow, colors }, c, at) {
    if (!c.friction) return;
    const top = plus(c.surface, times(c.normal, arrow * c.force));
    const half = times(c.tangent, arrow * c.force * c.friction);
    pen.path([c.surface, plus(top, half), plus(top, times(half, -1))].map(at), { fill: colors.cone, stroke: colors.force, width: 0.8, dash: [3, 3], closed: true });
  }

  function paint_contacts(pen, { drawing, frame, arrow, colors }, at) {
    for (const c of frame.contacts) {
      if (c.force === undefined) pen.disc(at(c.surface), 3.5, { fill: colors.force });
    }
    for (const c of pressed(frame)) {
      const from = at(c.surface);
      const to = at(plus(c.surface, times(c.normal, arrow * c.force)));
      pen.disc(from, 4.5, { fill: colors.force, stroke: colors.ground, width: 1.2 });
      paint_arrow(pen, from, to, colors.force, 2.6);
      if (c.tangential_force) paint_arrow(pen, from, at(plus(c.surface, times(c.tangent, arrow * c.tangential_force))), colors.force, 1.8);
      const side = c.normal[0] > 0.5 ? "left" : c.normal[0] < -0.5 ? "right" : "center";
      const beside = plus(to, [c.normal[0] * 12, -c.normal[1] * 12]);
      pen.text(beside, quantity(c.force, "N", drawing.length_unit, 3), { fill: colors.force, align: side, size: 14, halo: colors.ground });
    }
  }

  function paint_target(pen, target, at, colors) {
    const p = at(target.position);
    pen.path([[p[0] - 8, p[1]], [p[0] + 8, p[1]]], { stroke: colors.target, width: 3 });
    pen.path([[p[0], p[1] - 8], [p[0], p[1] + 8]], { stroke: colors.target, width: 3 });
    if (target.angle === undefined) return;
    paint_arrow(pen, p, [p[0] + 46 * Math.cos(target.angle), p[1] - 46 * Math.sin(target.angle)], colors.target, 1.6);
  }

  function paint_gravity(pen, gravity, width, colors) {
    const size = Math.hypot(gravity[0], gravity[1]);
    if (!(size > 0)) return;
    const along = [gravity[0] / size, -gravity[1] / size];
    const middle = [width - 34, 40];
    paint_arrow(pen, plus(middle, times(along, -18)), plus(middle, times(along, 18)), colors.soft, 1.6);
    pen.text(plus(middle, [along[1] ? -14 : 0, along[1] ? 0 : -14]), "g", { fill: colors.soft, align: "center", size: 14 });
  }

  // Elements --------------------------------------------------------------------------------------------------------

  function element(kind, attributes = {}, ...children) {
    const node = document.createElement(kind);
    for (const [name, value] of Object.entries(attributes)) {
      if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
      else if (value === true) node.setAttribute(name, "");
      else if (value !== false && value !== undefined) node.setAttribute(name, value);
    }
    node.append(...children);
    return node;
  }

  function save(name, content, type) {
    const link = element("a", { href: URL.createObjectURL(content instanceof Blob ? content : new Blob([content], { type })), download: name });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  // The page --------------------------------------------------------------------------------------------------------

  class Viewer {
    // `root`: an empty element. `drawing` may change later, with show().
    constructor(root, drawing) {
      this.overlays = [];
      this.index = 0;
      this.theme = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
      this.build(root);
      this.set_theme(this.theme);
      this.set_drawing(drawing);
      this.fit();
      new ResizeObserver(() => { this.resize(); }).observe(this.stage);
      document.addEventListener("keydown", (event) => this.on_key(event));
    }

    build(root) {
      this.title = element("h1");
      this.status = element("span", { class: "status", role: "status" });
      this.message = element("span", { class: "message" });
      this.notes = element("p", { class: "notes" });
      this.header = element("header", {}, this.title, this.status, this.message, this.notes);
      this.canvas = element("canvas", { role: "img", tabindex: 0 });
      this.tip = element("div", { class: "tip", hidden: true });
      this.stage = element("div", { class: "stage" }, this.canvas, this.tip);
      this.numbers = element("table");
      this.chart = element("canvas", { class: "chart", "aria-label": "contact force of each frame" });
      this.chart_title = element("h2", {}, "Contact force along the way");
      this.legend = element("p", { class: "keys" });
      this.keys = element("p", { class: "keys" }, "Keys: ← → steps, Home End, space plays, + − 0 zoom, drag or Shift and arrows move, D dark or light.");
      this.side = element("aside", { "aria-label": "numbers" }, element("h2", {}, "Numbers"), this.numbers, this.chart_title, this.chart, this.legend, this.keys);
      const button = (text, title, act) => element("button", { type: "button", title, onclick: act }, text);
      this.play_button = button("▶ Play", "play the frames (space)", () => this.play());
      this.slider = element("input", { type: "range", min: 0, value: 0, class: "grow", "aria-label": "frame", oninput: () => this.go(Number(this.slider.value)) });
      this.label = element("span", { class: "label" });
      this.footer = element("footer", {}, this.play_button, this.slider, this.label,
        button("Fit", "show everything (0)", () => this.fit()),
        button("Dark / light", "D", () => this.set_theme(this.theme === "dark" ? "light" : "dark")),
        button("PNG", "save a picture", () => this.save_png()),
        button("SVG", "save a picture to edit", () => this.save_svg()),
        (this.movie_button = button("Movie", "record the frames as they play", () => this.save_movie())));
      root.replaceChildren(this.header, this.stage, this.side, this.footer);
      this.canvas.addEventListener("wheel", (event) => { event.preventDefault(); this.zoom(Math.exp(-event.deltaY * 0.0015), this.place(event)); }, { passive: false });
      this.canvas.addEventListener("pointerdown", (event) => this.on_down(event));
      this.canvas.addEventListener("pointermove", (event) => this.on_move(event));
      for (const end of ["pointerup", "pointercancel"]) this.canvas.addEventListener(end, (event) => this.on_up(event));
      this.canvas.addEventListener("pointerleave", () => { this.tip.hidden = true; });
      this.chart.addEventListener("click", (event) => {
        const box = this.chart.getBoundingClientRect();
        this.go(Math.round(((event.clientX - box.left) / box.width) * (this.drawing.frames.length - 1)));
      });
    }

    // State

    set_drawing(drawing) {
      this.drawing = drawing;
      this.arrow = arrow_size(drawing);
      this.title.textContent = drawing.title || "tendril";
      this.notes.textContent = drawing.notes.join("; ");
      const several = drawing.frames.length > 1;
      for (const node of [this.play_button, this.slider, this.movie_button]) node.hidden = !several;
      this.slider.max = drawing.frames.length - 1;
      const forces = several && drawing.frames.some((f) => pressed(f).length);
      this.chart.hidden = this.chart_title.hidden = !forces;
      this.explain();
      this.go(Math.min(this.index, drawing.frames.length - 1));
    }

    frame() { return this.drawing.frames[this.index]; }

    go(index) {
      this.index = Math.min(Math.max(index, 0), this.drawing.frames.length - 1);
      const frame = this.frame();
      this.slider.value = this.index;
      this.label.textContent = frame.label;
      this.label.hidden = !frame.label;
      this.status.textContent = frame.status || "";
      this.status.className = "status" + (frame.status && frame.status !== "solved" ? " doubt" : "");
      this.message.textContent = frame.message || "";
      this.numbers.replaceChildren(...frame.numbers.map((n) => {
        const cell = element("td", { "data-value": n.value, "data-name": n.name }, n.text === undefined ? quantity(n.value, n.unit, this.drawing.length_unit) : n.text);
        if (n.value !== undefined) cell.title = `${n.value} ${n.unit}`;
        if (n.note) cell.append(element("span", { class: "note" }, n.note));
        return element("tr", {}, element("td", {}, n.name), cell);
      }));
      const tip = frame.numbers.filter((n) => n.name.startsWith("tip") || n.name.startsWith("force")).map((n) => `${n.name} ${quantity(n.value, n.unit, this.drawing.length_unit)}`);
      this.canvas.setAttribute("aria-label", [frame.label, frame.status, ...tip].filter(Boolean).join(", "));
      this.paint();
    }

    play() {
      if (this.timer) {
        clearInterval(this.timer);
        this.timer = null;
      } else {
        if (this.index === this.drawing.frames.length - 1) this.go(0);
        this.timer = setInterval(() => { this.index < this.drawing.frames.length - 1 ? this.go(this.index + 1) : this.play(); }, 1000 / frames_per_second);
      }
      this.play_button.textContent = this.timer ? "❚❚ Pause" : "▶ Play";
    }

    set_theme(theme) {
      this.theme = theme;
      document.documentElement.dataset.theme = theme;
      if (this.drawing) this.explain();
      this.paint();
    }

    // What the colours and signs mean.
    explain() {
      const colors = themes[this.theme];
      const frames = this.drawing.frames;
      const entries = [["▬ rod", colors.rods[0], true], ["▬ other finger", colors.rods[1], frames.some((f) => f.rods.length === 2)],
        ["● ➝ contact, its force", colors.force, frames.some((f) => f.contacts.length)], ["◁ friction cone", colors.force, frames.some((f) => f.contacts.some((c) => c.friction))],
        ["○ tip under friction", colors.tips, frames.some((f) => f.tips)], ["╍ forces held", colors.tips, frames.some((f) => f.hold)], ["○ measured", colors.measured, frames.some((f) => f.measured)], ["✚ target", colors.target, frames.some((f) => f.target && f.target.position)],
        ["╍ start", colors.start, this.drawing.start], ["─ way of the tip", colors.tips, this.drawing.ordered]];
      this.legend.replaceChildren(...entries.filter((e) => e[2]).flatMap(([text, color]) => {
        const entry = element("span", { class: "sign" }, text);
        entry.style.color = color;
        return [entry, " "];
      }));
    }

    // Window

    resize() {
      const box = this.stage.getBoundingClientRect();
      const ratio = devicePixelRatio || 1;
      this.width = Math.max(box.width, 1);
      this.height = Math.max(box.height, 1);
      this.canvas.width = Math.round(this.width * ratio);
      this.canvas.height = Math.round(this.height * ratio);
      if (this.fits) this.fit();
      else this.paint();
    }

    fit() {
      if (!this.width) this.resize();
      this.view = fitted(bounds_of(this.drawing), this.width, this.height);
      this.fits = true;
      this.paint();
    }

    zoom(factor, about = [this.width / 2, this.height / 2]) {
      const before = this.to_world(about);
      this.view = { ...this.view, scale: this.view.scale * factor };
      const after = this.to_world(about);
      this.view.center = plus(this.view.center, plus(before, times(after, -1)));
      this.fits = false;
      this.paint();
    }

    pan(by) {
      this.view = { ...this.view, center: plus(this.view.center, [-by[0] / this.view.scale, by[1] / this.view.scale]) };
      this.fits = false;
      this.paint();
    }

    place(event) {
      const box = this.canvas.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    }
    to_world(p) {
      return [this.view.center[0] + (p[0] - this.width / 2) / this.view.scale, this.view.center[1] - (p[1] - this.height / 2) / this.view.scale];
    }
    to_screen(p) {
      return [this.width / 2 + (p[0] - this.view.center[0]) * this.view.scale, this.height / 2 - (p[1] - this.view.center[1]) * this.view.scale];
    }

    scene() {
      return { drawing: this.drawing, frame: this.frame(), index: this.index, view: this.view, width: this.width, height: this.height, colors: themes[this.theme], arrow: this.arrow };
    }

    paint() {
      if (!this.view || !this.drawing) return;
      const context = this.canvas.getContext("2d");
      const ratio = this.canvas.width / this.width;
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      const pen = new CanvasPen(context);
      paint(pen, this.scene());
      for (const overlay of this.overlays) overlay(pen, themes[this.theme]);
      if (!this.chart.hidden) this.paint_chart();
    }

    paint_chart() {
      const box = this.chart.getBoundingClientRect();
      const ratio = devicePixelRatio || 1;
      this.chart.width = Math.round(box.width * ratio);
      this.chart.height = Math.round(box.height * ratio);
      const context = this.chart.getContext("2d");
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      const pen = new CanvasPen(context);
      const colors = themes[this.theme];
      const names = [...new Set(this.drawing.frames.flatMap((f) => pressed(f).map((c) => c.obstacle || "contact")))];
      const series = names.map((name) => this.drawing.frames.map((f) => pressed(f).filter((c) => (c.obstacle || "contact") === name).reduce((sum, c) => sum + c.force, 0)));
      const most = Math.max(...series.flat());
      const at = (i, force) => [6 + ((box.width - 12) * i) / (this.drawing.frames.length - 1), box.height - 6 - ((box.height - 26) * force) / most];
      pen.path([at(0, 0), at(this.drawing.frames.length - 1, 0)], { stroke: colors.edge });
      series.forEach((values, k) => pen.path(values.map((v, i) => at(i, v)), { stroke: colors.force, width: 2, dash: [[], [7, 5], [2, 4]][k % 3] }));
      pen.path([at(this.index, 0), at(this.index, most)], { stroke: colors.soft, width: 1.5 });
      pen.text([6, 9], `up to ${quantity(most, "N", this.drawing.length_unit, 3)}: ${names.join(", ")}`, { fill: colors.soft, size: 12 });
    }

    // Hovering and moving

    on_down(event) {
      this.canvas.setPointerCapture(event.pointerId);
      this.held = { at: this.place(event) };
    }
    on_move(event) {
      const at = this.place(event);
      if (!this.held) return this.hover(at);
      this.pan(plus(at, times(this.held.at, -1)));
      this.held.at = at;
    }
    on_up() { this.held = null; }

    hover(at) {
      const text = this.under(at);
      this.tip.hidden = !text;
      if (!text) return;
      this.tip.textContent = text;
      this.tip.style.left = `${Math.min(at[0] + 14, Math.max(0, this.width - this.tip.offsetWidth - 4))}px`;
      this.tip.style.top = `${Math.min(at[1] + 14, Math.max(0, this.height - this.tip.offsetHeight - 4))}px`;
    }

    // What lies under a place of the canvas, in words; empty: nothing.
    under(at) {
      const frame = this.frame();
      const unit = this.drawing.length_unit;
      const near = (p, reach) => distance(this.to_screen(p), at) < reach;
      const point = (p) => `(${digits(p[0] / unit.size)}, ${digits(p[1] / unit.size)}) ${unit.name}`;
      for (const c of frame.contacts) {
        if (!near(c.surface, 10)) continue;
        const lines = [`contact${c.obstacle ? ` with ${c.obstacle}` : ""}${c.at_tip ? " at the tip" : ""}`, point(c.surface)];
        if (c.force !== undefined) lines.push(`force ${quantity(c.force, "N", unit)}`);
        if (c.tangential_force) lines.push(`along the surface ${quantity(c.tangential_force, "N", unit)}`);
        if (c.arc_length !== undefined) lines.push(`arc length ${quantity(c.arc_length, "m", unit)}`);
        if (c.gap !== undefined) lines.push(`gap ${quantity(c.gap, "m", unit)}`);
        return lines.join("\n");
      }
      if (frame.target && frame.target.position && near(frame.target.position, 10)) return `target\n${point(frame.target.position)}`;
      let best = 14;
      let text = "";
      for (const rod of frame.rods) {
        rod.line.forEach((p, i) => {
          const d = distance(this.to_screen(p), at);
          if (d >= best) return;
          best = d;
          text = `${rod.name}\n${point(p)}`;
          if (rod.along) text += `\narc length ${quantity(rod.along[i][0], "m", unit)}\nangle ${quantity(rod.along[i][1], "rad", unit)}\ncurvature ${quantity(rod.along[i][2], "1/m", unit)}`;
        });
      }
      if (text) return text;
      const world = this.to_world(at);
      const shape = shapes_of(this.drawing, frame).find((s) => inside(world, s.outlines));
      return shape ? shape.name : "";
    }

    on_key(event) {
      if (event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName) && event.target !== this.slider) return;
      const step = { ArrowLeft: [40, 0], ArrowRight: [-40, 0], ArrowUp: [0, 40], ArrowDown: [0, -40] }[event.key];
      if (step && event.shiftKey) this.pan(step);
      else if (event.key === "ArrowLeft") this.go(this.index - 1);
      else if (event.key === "ArrowRight") this.go(this.index + 1);
      else if (event.key === "Home") this.go(0);
      else if (event.key === "End") this.go(this.drawing.frames.length - 1);
      else if (event.key === " " && event.target.tagName !== "BUTTON" && this.drawing.frames.length > 1) this.play();
      else if (event.key === "+" || event.key === "=") this.zoom(1.25);
      else if (event.key === "-") this.zoom(0.8);
      else if (event.key === "0") this.fit();
      else if (event.key === "d" || event.key === "D") this.set_theme(this.theme === "dark" ? "light" : "dark");
      else return;
      event.preventDefault();
    }

    // Files

    save_png() { this.canvas.toBlob((blob) => save("tendril.png", blob)); }

    svg() {
      const pen = new SvgPen();
      paint(pen, this.scene());
      return pen.document(Math.round(this.width), Math.round(this.height));
    }
    save_svg() { save("tendril.svg", this.svg(), "image/svg+xml"); }

    // Plays the frames once and records the canvas.
    save_movie() {
      if (!this.canvas.captureStream || !window.MediaRecorder) { this.notes.textContent = "this browser cannot record a movie"; return; }
      if (this.timer) this.play();
      this.record(() => new Promise((done) => {
        this.go(0);
        const timer = setInterval(() => {
          if (this.index < this.drawing.frames.length - 1) this.go(this.index + 1);
          else { clearInterval(timer); setTimeout(done, 300); }
        }, 1000 / frames_per_second);
      }));
    }

    async record(while_running) {
      const recorder = new MediaRecorder(this.canvas.captureStream(30));
      const pieces = [];
      recorder.ondataavailable = (event) => pieces.push(event.data);
      const stopped = new Promise((done) => { recorder.onstop = done; });
      recorder.start();
      await while_running();
      recorder.stop();
      await stopped;
      const kind = recorder.mimeType.includes("mp4") ? "mp4" : "webm";
      save(`tendril.${kind}`, new Blob(pieces, { type: recorder.mimeType }));
    }
  }

  function inside(p, outlines) {
    let within = false;
    for (const outline of outlines) {
      for (let i = 0, j = outline.length - 1; i < outline.length; j = i++) {
        const [a, b] = [outline[i], outline[j]];
        if (a[1] > p[1] !== b[1] > p[1] && p[0] < ((b[0] - a[0]) * (p[1] - a[1])) / (b[1] - a[1]) + a[0]) within = !within;
      }
    }
    return within;
  }

  // What a page cannot do without, beside the language itself.
  const suits = () => Boolean(window.ResizeObserver && window.PointerEvent && HTMLCanvasElement.prototype.toBlob && Element.prototype.replaceChildren);


  return { Viewer, suits, element, quantity, save, plus, times, distance };
})();

// A browser that is too old keeps what the page says without its scripts.
if (document.getElementById("drawing") && Tendril.suits()) {
  new Tendril.Viewer(document.getElementById("tendril"), JSON.parse(document.getElementById("drawing").textContent));
}
