// The live page: changes to a scene on the left, what the server makes of them on the right. Uses Tendril of drawing.js.
"use strict";

class LivePage {
  constructor(root, data) {
    this.data = data;
    this.viewer = new Tendril.Viewer(root, data.drawing);
    this.settings = {};
    this.past = [];
    this.future = [];
    this.asked = 0;   // number of the request that was wanted last
    this.shown = 0;   // number of the one whose answer is shown
    this.pending = 0; // requests on their way
    this.inputs = null; // what the actuators are told, SI; not known before the first answer
    this.action = data.plans ? "plan" : "execute";
    this.history = [];
    this.rows = new Map();
    this.build();
    this.viewer.overlays.push((pen, colors) => this.paint_handles(pen, colors));
    this.take_pointer();
    document.addEventListener("keydown", (event) => {
      if (!(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== "z") return;
      event.preventDefault();
      event.shiftKey ? this.redo() : this.undo();
    });
    this.first = true;
    this.ask();
  }

  // Elements

  build() {
    const { element } = Tendril;
    const button = (text, title, act) => element("button", { type: "button", title, onclick: act }, text);
    this.actions = new Map([["plan", "Plan"], ["follow", "Follow"], ["execute", "Execute"]]
      .filter(([action]) => action === "execute" || (this.data.plans && (action === "plan" || this.data.follows)))
      .map(([action, text]) => [action, button(text, { plan: "search from the scene's start, as tendril plan does", follow: "lead on from the plan that is shown", execute: "what the rod does under the inputs below" }[action], () => this.set_action(action))]));
    this.undo_button = button("Undo", "take the last change back (Ctrl Z)", () => this.undo());
    this.redo_button = button("Redo", "(Ctrl Shift Z)", () => this.redo());
    this.busy = element("p", { class: "notes busy", role: "status" });
    this.trouble = element("p", { class: "message trouble", role: "alert" });
    this.ways = element("table", { class: "ways" });
    this.strip = element("canvas", { class: "chart", "aria-label": "contact force over the last plans" });
    const controls = element("div", { class: "controls" });
    for (const control of this.data.controls) controls.append(this.row(control));
    this.input_rows = element("div", {});
    this.input_box = element("div", {}, element("h2", {}, "Inputs to execute"), this.input_rows);
    const side = this.viewer.side;
    side.prepend(element("div", { class: "bar" }, ...this.actions.values(), this.undo_button, this.redo_button), this.busy, this.trouble,
      this.input_box, element("h2", {}, "Scene"), controls);
    side.insertBefore(element("div", {}, element("h2", {}, "Ways of contact"), this.ways, element("h2", {}, "Force over the last plans"), this.strip), this.viewer.legend);
    this.record_button = button("Record", "record what happens on the screen, until it is pressed again", () => this.record());
    this.viewer.footer.append(this.record_button, button("Save scene", "as a scene file", () => this.save("scene", "scene.toml", { settings: this.settings })),
      button("Save result", "as tendril plan --json writes it", () => this.save("result", "result.json", { number: this.number })));
    this.set_action(this.action, false);
    this.show_settings();
  }

  row(control) {
    const { element } = Tendril;
    const name = element("span", { class: "name" }, control.key);
    const row = element("label", { class: "row", "data-key": control.key }, name);
    const fields = [];
    const add = (attributes, read) => {
      const field = element(attributes.kind, attributes.of || {}, ...(attributes.children || []));
      field.addEventListener("input", () => this.change(control.key, read(field), false));
      field.addEventListener("change", () => this.change(control.key, read(field), true));
      fields.push(field);
      row.append(field);
      return field;
    };
    if (control.kind === "choice") {
      add({ kind: "select", children: control.choices.map((c) => element("option", { value: c }, c)) }, (field) => field.value);
    } else if (control.kind === "flag") {
      add({ kind: "input", of: { type: "checkbox" } }, (field) => field.checked);
    } else if (control.kind === "points") {
      control.value.forEach((_, i) => [0, 1].forEach((k) => add({ kind: "input", of: { type: "number", step: "any", "aria-label": `${control.key}, ${"xy"[k]} of point ${i + 1}` } }, (field) => {
        const points = this.value(control).map((p) => [...p]);
        if (field.value !== "") points[i][k] = Number(field.value);
        return points;
      })));
    } else {
      const [low, high] = LivePage.range(control);
      const step = control.kind === "whole" ? 1 : "any";
      const read = (field) => (field.value === "" ? this.value(control) : Number(field.value));
      add({ kind: "input", of: { type: "range", min: low, max: high, step, "aria-label": control.key } }, read);
      add({ kind: "input", of: { type: "number", step, "aria-label": control.key } }, read);
    }
    if (control.unit) row.append(element("span", { class: "unit" }, control.unit));
    const trouble = element("span", { class: "message" });
    row.append(trouble);
    this.rows.set(control.key, { control, fields, trouble });
    return row;
  }

  // A slider's ends: around what the scene says.
  static range(control) {
    const value = control.value;
    if (control.unit === "rad") return [-Math.PI, Math.PI];
    if (control.unit === "deg") return [-180, 180];
    const size = value === 0 ? 1 : 3 * Math.abs(value);
    const high = control.kind === "whole" ? Math.max(Math.ceil(size), 4) : size;
    return [control.minimum !== null && control.minimum >= 0 ? control.minimum : -high, high];
  }

  // A slider and a field for what an actuator is told: a moment, a pressure, a tension.
  input_row(input, i) {
    const { element } = Tendril;
    const length = this.data.drawing.length_unit;
    const [unit, size, least] = { "N m": [`N ${length.name}`, length.size, 1], Pa: ["kPa", 1e3, 10] }[input.unit] || [input.unit, 1, 1];
    const high = Math.max((3 * Math.abs(input.value)) / size, least);
    const name = `${input.finger ? `${input.finger} ` : ""}${input.kind} ${i + 1}`;
    const fields = ["range", "number"].map((type) => element("input", { type, step: "any", "aria-label": name, ...(type === "range" ? { min: input.unit === "N" ? 0 : -high, max: high } : {}) }));
    for (const field of fields) {
      field.value = input.value / size;
      field.addEventListener("input", () => {
        if (field.value === "") return;
        this.inputs[i] = Number(field.value) * size;
        for (const other of fields) if (other !== field) other.value = field.value;
        this.ask();
      });
    }
    return element("label", { class: "row" }, element("span", { class: "name" }, name), ...fields, element("span", { class: "unit" }, unit));
  }

  set_inputs(inputs) {
    this.inputs = inputs.map((input) => input.value);
    this.input_rows.replaceChildren(...inputs.map((input, i) => this.input_row(input, i)));
  }

  // Changes

  value(control) { return this.settings[control.key] ?? control.value; }

  // `final`: the mouse was let go; only then there is something to take back.
  change(key, value, final) {
    this.before = this.before || { ...this.settings };
    this.settings[key] = value;
    if (final) this.remember();
    this.show_settings();
    this.ask();
  }

  remember() {
    if (!this.before) return;
    this.past.push(this.before);
    if (this.past.length > 1000) this.past.shift();
    this.future = [];
    this.before = null;
  }

  undo() { this.go(this.past, this.future); }
  redo() { this.go(this.future, this.past); }
  go(from, to) {
    this.remember();
    if (!from.length) return;
    to.push({ ...this.settings });
    this.settings = from.pop();
    this.show_settings();
    this.ask();
  }

  set_action(action, ask = true) {
    if (action === "execute" && this.action !== "execute" && this.planned) this.set_inputs(this.planned);
    this.action = action;
    for (const [name, node] of this.actions) node.setAttribute("aria-pressed", name === action);
    this.input_box.hidden = action !== "execute";
    if (ask) this.ask();
  }

  show_settings() {
    for (const { control, fields } of this.rows.values()) {
      const value = this.value(control);
      fields.forEach((field, i) => {
        if (control.kind === "flag") field.checked = value;
        else {
          const text = String(control.kind === "points" ? value[Math.floor(i / 2)][i % 2] : value);
          if (field !== document.activeElement || field.type === "range") field.value = text;
        }
      });
    }
    this.undo_button.disabled = !this.past.length;
    this.redo_button.disabled = !this.future.length;
    this.viewer.paint();
  }

  // Requests: one is on its way at a time, a second one only if it takes long. What is asked for last wins.

  ask() {
    ++this.asked;
    if (!this.pending || performance.now() - this.sent > 400) this.send();
  }

  async send() {
    const number = this.asked;
    ++this.pending;
    this.sent = performance.now();
    this.watch();
    let body = null;
    try {
      const answer = await fetch("run", { method: "POST", headers: { "Content-Type": "application/json" },
        body: JSON.stringify({ action: this.action, settings: this.settings, ...(this.action === "execute" && this.inputs ? { inputs: this.inputs } : {}) }) });
      body = answer.status === 429 ? null : await answer.json();
      if (answer.status === 429) await new Promise((done) => setTimeout(done, 50));
      if (answer.status === 409) body = null;
    } catch (error) {
      body = { error: `tendril does not answer (${error.message}); is it still running?` };
    }
    --this.pending;
    if (body && number > this.shown) this.show(number, body);
    else if (!body && number === this.asked && !this.pending) ++this.asked;
    if (this.asked > number && !this.pending) this.send();
  }

  watch() {
    clearInterval(this.clock);
    this.clock = setInterval(() => {
      const seconds = (performance.now() - this.sent) / 1000;
      if (!this.pending) {
        clearInterval(this.clock);
        return;
      }
      const solver = this.rows.get("solver.plugin");
      if (seconds > 0.3) this.busy.textContent = `${this.action === "execute" ? "executing" : `planning with ${solver ? this.value(solver.control) : "the solver"}`}, ${seconds.toFixed(1)} s; the last one is shown`;
    }, 100);
  }

  show(number, body) {
    this.shown = number;
    for (const { trouble } of this.rows.values()) trouble.textContent = "";
    const row = this.rows.get(body.key);
    this.trouble.textContent = body.error || "";  // its place may be out of sight
    if (row) row.trouble.textContent = body.error;
    document.documentElement.dataset.shown = number;
    if (body.error) return;
    this.number = body.number;
    if (body.inputs && this.action !== "execute") this.planned = body.inputs;
    else if (body.inputs && !this.inputs) this.set_inputs(body.inputs);
    this.viewer.set_drawing(body.drawing);
    if (this.first) this.viewer.fit();
    this.first = false;
    if (body.drawing.frames.length > 1 && this.action === "execute") this.viewer.go(body.drawing.frames.length - 1);
    this.viewer.notes.textContent = [...body.drawing.notes, ...body.dropped].join("; ");
    this.busy.textContent = `${this.action === "execute" ? "executed" : "planned"} in ${Tendril.quantity(body.seconds, "s", this.data.drawing.length_unit, 3)}`;
    const { element } = Tendril;
    this.ways.replaceChildren(...(body.modes || []).map((m) => element("tr", {}, element("td", {}, m.mode), element("td", { class: "outcome" }, m.outcome))));
    this.history.push(body.drawing.frames[this.viewer.index].contacts.reduce((sum, c) => sum + (c.force || 0), 0));
    if (this.history.length > 300) this.history.shift();
    this.paint_strip();
  }

  paint_strip() {
    const box = this.strip.getBoundingClientRect();
    this.strip.width = box.width;
    this.strip.height = box.height;
    const context = this.strip.getContext("2d");
    const most = Math.max(...this.history) || 1;
    const colors = getComputedStyle(document.documentElement);
    context.strokeStyle = colors.getPropertyValue("--wrong");
    context.lineWidth = 2;
    context.beginPath();
    this.history.forEach((force, i) => context.lineTo(4 + ((box.width - 8) * i) / Math.max(this.history.length - 1, 1), box.height - 4 - ((box.height - 22) * force) / most));
    context.stroke();
    context.fillStyle = colors.getPropertyValue("--soft");
    context.font = "12px sans-serif";
    context.fillText(`up to ${Tendril.quantity(most, "N", this.data.drawing.length_unit, 3)}`, 4, 12);
  }

  // Dragging

  // Where something can be taken: the middle of its points, SI; of a line of many the one that is nearest to it, which lies on it.
  handles() {
    const moved = new Map();
    for (const { control } of this.rows.values()) {
      if (!control.moves) continue;
      const points = this.value(control).map((p) => Tendril.times(p, control.size));
      moved.set(control.moves, [...(moved.get(control.moves) || []), ...points]);
    }
    return [...moved].map(([name, points]) => {
      const middle = Tendril.times(points.reduce(Tendril.plus), 1 / points.length);
      const nearest = (a, b) => (Tendril.distance(b, middle) < Tendril.distance(a, middle) ? b : a);
      return { name, at: points.length > 2 ? points.reduce(nearest) : middle };
    });
  }

  paint_handles(pen, colors) {
    for (const { name, at } of this.handles()) {
      const p = this.viewer.to_screen(at);
      const held = this.held && this.held.name === name;
      pen.disc(p, held ? 13 : 10, { stroke: name === "target" ? colors.target : colors.soft, width: held ? 3 : 1.5 });
      if (held) pen.text(Tendril.plus(p, [0, -22]), name, { fill: colors.ink, align: "center", halo: colors.ground });
    }
  }

  take_pointer() {
    const viewer = this.viewer;
    const free = { down: viewer.on_down.bind(viewer), move: viewer.on_move.bind(viewer), up: viewer.on_up.bind(viewer) };
    viewer.on_down = (event) => {
      const at = viewer.place(event);
      const near = this.handles().map((h) => ({ ...h, far: Tendril.distance(viewer.to_screen(h.at), at) })).sort((a, b) => a.far - b.far)[0];
      if (!near || near.far > 16) return free.down(event);
      viewer.canvas.setPointerCapture(event.pointerId);
      this.held = { name: near.name, from: viewer.to_world(at), start: { ...this.settings } };
      viewer.paint();
    };
    viewer.on_move = (event) => {
      if (!this.held) return free.move(event);
      this.move(Tendril.plus(viewer.to_world(viewer.place(event)), Tendril.times(this.held.from, -1)));
    };
    viewer.on_up = (event) => {
      if (!this.held) return free.up(event);
      this.held = null;
      this.remember();
      this.show_settings();
    };
  }

  // By so much from where it was taken, SI, rounded to what a hand can mean.
  move(by) {
    const steps = 10 ** Math.ceil(4 - Math.log10(this.data.drawing.length));
    this.before = this.before || { ...this.held.start };
    for (const { control } of this.rows.values()) {
      if (control.moves !== this.held.name) continue;
      const places = steps * control.size;
      const start = this.held.start[control.key] ?? control.value;
      this.settings[control.key] = start.map((p) => p.map((v, k) => Number((Math.round((v + by[k] / control.size) * places) / places).toPrecision(12))));
    }
    this.show_settings();
    this.ask();
  }

  // Files

  async save(what, name, request) {
    const answer = await fetch(what, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(request) });
    const body = await answer.json();
    if (body.error) this.trouble.textContent = body.error;
    else Tendril.save(name, body.text, "text/plain");
  }

  record() {
    if (this.stop_recording) {
      this.stop_recording();
      return;
    }
    this.record_button.setAttribute("aria-pressed", true);
    this.viewer.record(() => new Promise((done) => { this.stop_recording = done; })).then(() => {
      this.stop_recording = null;
      this.record_button.setAttribute("aria-pressed", false);
    });
  }
}

if (Tendril.suits()) window.live = new LivePage(document.getElementById("tendril"), JSON.parse(document.getElementById("live").textContent));
