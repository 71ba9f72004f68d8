"""Random drags on the live page, by pointer events inside of it, so that no round trip to the driver is measured."""

# Takes the target, the peg or the base, moves it to a place around its home, lets go, waits for the picture, and now and then
# takes the change back. `dragged` holds the milliseconds of each drag, and what the page complained of.
DRAGS = """
  const [count, seconds, seed] = arguments;
  let state = seed;
  const chance = () => (state = (state * 1103515245 + 12345) % 2147483648) / 2147483648;
  const around = (size) => (2 * chance() - 1) * size;
  const canvas = live.viewer.canvas;
  canvas.setPointerCapture = () => {};  // of a pointer that is none
  window.homes = window.homes || new Map(live.handles().map((h) => [h.name, h.at]));
  const sizes = { target: 0.02, "obstacle 1": 0.004, base: 0.004 };
  const settled = () => new Promise((done) => {
    const look = () => (!live.pending && live.shown === live.asked ? done() : setTimeout(look, 0));
    look();
  });
  const point = (kind, at) => {
    const box = canvas.getBoundingClientRect();
    const p = live.viewer.to_screen(at);
    canvas.dispatchEvent(new PointerEvent(kind, { clientX: box.left + p[0], clientY: box.top + p[1], pointerId: 1 }));
  };
  const run = async () => {
    const { times, told } = (window.dragged = { times: [], told: [] });
    const end = performance.now() + 1000 * seconds;
    while (times.length < count && performance.now() < end) {
      while (window.paused) await new Promise((done) => setTimeout(done, 20));
      const names = Object.keys(sizes);
      const name = names[Math.floor(chance() * names.length)];
      const from = live.handles().find((h) => h.name === name).at;
      const to = Tendril.plus(homes.get(name), [around(sizes[name]), around(sizes[name])]);
      const begin = performance.now();
      point("pointerdown", from);
      if (!live.held || live.held.name !== name) { told.push(`${name} cannot be taken`); live.held = null; }
      point("pointermove", to);
      point("pointerup", to);
      await settled();
      times.push(performance.now() - begin);
      if (live.trouble.textContent) told.push(live.trouble.textContent);
      if (times.length % 25 === 0) { live.undo(); await settled(); }
    }
    return window.dragged;
  };"""


def drags(browser, count, seed):
    """Milliseconds of each of `count` drags, and what the page complained of."""
    found = browser.run(DRAGS + "return run();", count, 1e6, seed)
    return found["times"], found["told"]


def begin_drags(browser, seconds, seed):
    """Drags for so long, while other things can be asked for."""
    browser.run(DRAGS + "run();", 1e9, seconds, seed)


def drags_since(browser):
    """As drags(), of those since the last call, and what the page's scripts then hold, at rest."""
    found = browser.run("window.paused = true; return { times: dragged.times.splice(0), told: dragged.told.splice(0) };")
    browser.wait("return !live.pending && live.shown === live.asked")
    memory = page_memory(browser)
    browser.run("window.paused = false")
    return found["times"], found["told"], memory


def server_memory(live):
    """KiB of the server that are in memory."""
    with open(f"/proc/{live.process.pid}/status", encoding="utf-8") as status:
        return int(next(line for line in status if line.startswith("VmRSS")).split()[1])


def page_memory(browser):
    """KiB that the page's scripts hold."""
    browser.command("HeapProfiler.collectGarbage")
    metrics = browser.command("Performance.getMetrics")["metrics"]
    return round(next(m["value"] for m in metrics if m["name"] == "JSHeapUsedSize") / 1024)
