// Puts the panes together: choices, sliders, keyboard.

const MODES = [["contexts", "schedule"], ["cycles", "run"], ["heat", "heat"]];
const MANY_INPUTS = 40;

function setRegion(index) {
  state.region = index;
  state.slot = 0;
  state.zoom = 0;
  state.bound = state.highlights && tells(region()) ? region().binds : null;
  byId("binding").checked = state.bound !== null;
  marks.pinned = marks.hover = null;
  state.inputs = region().nodes.length <= MANY_INPUTS;
  byId("inputs").checked = state.inputs;
  const card = document.querySelector(`input[name="region"][value="${index}"]`);
  if (card) card.checked = true;
  showGraph();
  showSource();
  showTable();
  showBounds();
  setSlot(0);
  showFirstLine();
  reveal(byId("graph"), ".node.binds");
}

// Whether highlighting what binds says something: it is not just about everything.
function tells(one) {
  if (one.binds === null) return false;
  const placed = one.nodes.filter((node) => !node.source).length;
  return placed < 16 || one.bounds[one.binds].nodes.length < 0.6 * placed;
}

// The first line of the region, a few lines from the pane's top.
function showFirstLine() {
  const pane = byId("source");
  const line = pane.querySelector(".here");
  if (!line) return;
  pane.scrollTop += line.getBoundingClientRect().top - pane.getBoundingClientRect().top - pane.clientHeight / 4;
}

function setSlot(slot) {
  const { length } = region().slots;
  state.slot = Math.max(0, Math.min(slot, length - 1));
  const slider = byId("slot");
  slider.max = Math.max(0, length - 1);
  slider.value = state.slot;
  slider.disabled = length < 2;
  byId("slot-text").textContent = length ? `${state.slot} of ${length}` : "none";
  slider.setAttribute("aria-valuetext", `context ${state.slot} of ${length}`);
  showArray();
  showTableSlot();
  paint();
}

function setCycle(cycle) {
  state.cycle = Math.max(run.first, Math.min(cycle, run.end - 1));
  const sample = sampleAt.get(state.cycle);
  if (sample && sample[1] !== state.region) {
    const kept = state.cycle;
    setRegion(sample[1]);
    state.cycle = kept;
  }
  const slider = byId("cycle");
  slider.value = state.cycle;
  const how = stalled.has(state.cycle) ? ", stalled" : sample ? "" : ", between regions";
  byId("cycle-text").textContent = `${state.cycle}${how}`;
  slider.setAttribute("aria-valuetext", `cycle ${state.cycle}${how}`);
  const x = ((state.cycle - run.first + 0.5) / (run.end - run.first)) * STRIP.width;
  const cursor = byId("cursor");
  cursor.setAttribute("x1", x);
  cursor.setAttribute("x2", x);
  setSlot(sample ? sample[2] : state.slot);
}

function setMode(mode) {
  state.mode = mode;
  byId("slot-control").hidden = mode !== "contexts";
  byId("cycle-control").hidden = mode !== "cycles";
  if (mode === "cycles") setCycle(state.cycle);
  else setSlot(state.slot);
}

function nextStall() {
  const later = run.stalled.find((cycle) => cycle > state.cycle);
  setCycle(later === undefined ? run.stalled[0] : later);
}

function setBound(index) {
  state.bound = index;
  for (const button of byId("bounds").querySelectorAll("[data-bound]"))
    button.setAttribute("aria-pressed", Number(button.dataset.bound) === index);
  byId("binding").checked = index !== null;
  paint();
}

function prepareRun() {
  const shown = run ? MODES : MODES.slice(0, 1);
  byId("modes").replaceChildren(...shown.map(([mode, text]) => make("label", {},
    make("input", { type: "radio", name: "mode", value: mode, checked: mode === state.mode }), make("span", { text }))));
  byId("modes").hidden = !run;
  if (!run) return;
  const slider = byId("cycle");
  slider.min = run.first;
  slider.max = run.end - 1;
  byId("stall").disabled = !run.stalled.length;
  showStrip();
  showRun();
}

function listen() {
  byId("regions").addEventListener("change", (event) => setRegion(Number(event.target.value)));
  byId("modes").addEventListener("change", (event) => setMode(event.target.value));
  byId("slot").addEventListener("input", (event) => setSlot(Number(event.target.value)));
  byId("cycle").addEventListener("input", (event) => setCycle(Number(event.target.value)));
  byId("stall").addEventListener("click", nextStall);
  byId("inputs").addEventListener("change", (event) => {
    state.inputs = event.target.checked;
    showGraph();
    paint();
  });
  byId("binding").addEventListener("change", (event) => {
    state.highlights = event.target.checked;
    setBound(state.highlights ? region().binds : null);
  });
  byId("bounds").addEventListener("click", (event) => {
    const button = event.target.closest("[data-bound]");
    if (!button) return;
    const index = Number(button.dataset.bound);
    setBound(state.bound === index ? null : index);
    reveal(byId("graph"), ".node.binds");
  });
  const zoom = (step) => () => {
    state.zoom = step ? state.zoom + step : 0;
    scale();
  };
  byId("larger").addEventListener("click", zoom(1));
  byId("smaller").addEventListener("click", zoom(-1));
  byId("fit").addEventListener("click", zoom(0));
  window.addEventListener("resize", scale);
  interactive(byId("graph"), graphStep);
  interactive(byId("source"), lineStep);
  interactive(byId("table"), tableStep);
  interactive(byId("array"), null);
  draggable(byId("graph"));
}

// The region where the cycles go, as far as it is known.
function hottest() {
  const weight = (one, index) => (run && run.cycles ? run.regions[index].cycles
    : one.operations + (one.kind === "loop" ? 1e6 : 0));
  return data.regions.reduce((best, one, index) =>
    (weight(one, index) > weight(data.regions[best], best) ? index : best), 0);
}

function start() {
  byId("title").textContent = data.name;
  byId("summary").textContent = data.summary;
  const figures = [[data.fabric.name, "fabric"], [data.regions.length, "regions"]];
  if (run && run.cycles !== null) figures.push([run.cycles.toLocaleString("en"), "cycles"]);
  if (run && run.cycles) {
    const stalls = run.regions.reduce((sum, one) => sum + one.stalls, 0);
    figures.push([stalls.toLocaleString("en"), "stalled"]);
  }
  byId("figures").replaceChildren(...figures.map(([value, name]) =>
    make("li", {}, make("b", { text: value }), make("span", { text: name }))));
  byId("about").textContent = [
    data.nests ? "On an accelerator its nests of loops run on all tiles; the page shows the program of one tile." : "",
    ...data.warnings].filter(Boolean).join(" ");
  prepareRun();
  showRegions();
  listen();
  setRegion(hottest());
  if (run) {
    const radio = document.querySelector('input[name="mode"][value="contexts"]');
    radio.checked = true;
  }
  setMode("contexts");
}

start();
