// The joints' page: parameters of one joint as a tree, its signals as plots, steps of its goal.
import { $, allow, connect, isSilent, send, whileSilent } from "/link.js";
import { askForPairing } from "/pairing.js";
import { Plots } from "/plots.js";

const SIGNALS = new Map(["goal °", "angle °", "speed °/s", "current A", "winding °C", "supply V"].map((text, i) => {
  const [name, unit] = text.split(" ");
  return [name, [(sample) => sample[i + 1], unit]];
}));
const plots = new Plots($("plot-pick"), $("plot-clear"), $("plot-list"), SIGNALS, (sample) => sample[0], 4);
const rows = new Map(); // name: {row, input, output, of}
let hello = null, status = null, values = { values: {} }, taken_s = 0;

function lost() {
  hello = status = null;
  askForPairing(show);
  show();
}

function receive(message) {
  if (message.type === "hello") begin(message);
  else if (message.type === "values") values = message;
  else if (message.type === "status") {
    status = message;
    for (const sample of status.samples) {
      if (sample[0] > taken_s) plots.push(sample);
    }
    taken_s = status.samples.length ? status.samples.at(-1)[0] : taken_s;
    plots.paint();
    show();
  }
}

function begin(message) {
  hello = message;
  taken_s = 0;
  askForPairing(show);
  document.title = `${message.robot}, joints`;
  $("robot").textContent = message.robot;
  $("sim").hidden = !message.simulated;
  $("joint").replaceChildren(...message.joints.map((name, i) => new Option(name, i + 1)));
  rows.clear();
  const groups = [...new Set(message.parameters.map((of) => of[1]))];
  $("tree").replaceChildren(...groups.map((name) => group(name, message.parameters.filter((of) => of[1] === name))));
  if (!plots.shown.size) ["angle", "current"].forEach((name) => plots.add(name));
}

function group(name, all) {
  const details = document.createElement("details"), summary = document.createElement("summary"), table = document.createElement("table");
  summary.textContent = `${name} (${all.length})`;
  details.append(summary, table);
  for (const of of all) parameter(table.insertRow(), of);
  return details;
}

function parameter(row, [name, , unit, meaning, low, high, access, stored]) {
  const head = document.createElement("th"), said = document.createElement("small");
  head.scope = "row";
  head.textContent = name;
  said.textContent = meaning;
  head.append(said);
  row.append(head);
  const cell = row.insertCell(), limits = document.createElement("small");
  const input = document.createElement("input");
  Object.assign(input, { type: "number", step: "any", min: low, max: high, readOnly: access === "measured" });
  input.setAttribute("aria-label", name);
  input.addEventListener("change", () => send({ type: "parameter", node: status.node, name, value: Number(input.value) }));
  cell.append(input, ` ${unit}`, limits);
  limits.textContent = access === "measured" ? "measured" : `${number(low)} to ${number(high)}${access === "disarmed" ? ", while disarmed" : ""}${stored ? "" : ", not saved"}`;
  rows.set(name, { row, input, access, text: `${name} ${meaning}`.toLowerCase() });
}

const number = (value) => Number(value.toPrecision(6)).toString();

const ACTING = ["joint", "arm", "clear", "step", "keep"];

function show() {
  const silent = !status || isSilent(), paired = $("pairing").hidden;
  const state = silent ? "" : status.joints[status.node - 1];
  $("state").className = silent ? "halted" : status.armed ? "moves" : "";
  $("word").textContent = silent ? (paired ? "no connection" : "not paired") : status.armed ? "armed" : "disarmed";
  $("reason").textContent = silent ? (paired ? "the program on the bus does not answer" : "enter the code below") : `${status.joints.filter((one) => one !== "not there").length} of 12 joints answer`;
  $("stop").classList.toggle("dead", silent);
  allow(ACTING, (id) => whyNot(id, silent));
  if (silent) return;
  $("arm").textContent = status.armed ? "Let go" : "Arm all joints";
  $("joint-state").textContent = state;
  $("told").textContent = status.told;
  if (document.activeElement !== $("joint")) $("joint").value = status.node;
  const at = values.node === status.node ? values.values : {}, known = Object.keys(at).length;
  $("progress").textContent = known < rows.size ? `read ${known} of ${rows.size}` : "";
  for (const [name, { input, access }] of rows) {
    input.disabled = access === "disarmed" && status.armed;
    if (document.activeElement !== input) input.value = name in at ? number(at[name]) : "";
  }
}

// Why a control can't act now, "" if it can.
function whyNot(id, silent) {
  if (silent) return "no connection to the bus";
  if (id === "step") return !status.armed ? "arm first" : status.stepping ? "a step is running" : "";
  if (id === "clear") return status.armed ? "let go first" : "";
  if (id === "joint") return status.stepping ? "a step is running" : "";
  return "";
}

$("arm").addEventListener("click", () => send({ type: "arm", on: !status.armed }));
$("clear").addEventListener("click", () => send({ type: "clear" }));
$("keep").addEventListener("click", () => send({ type: "keep", node: status.node }));
$("joint").addEventListener("change", () => {
  plots.forget();
  send({ type: "joint", node: Number($("joint").value) });
  $("joint").blur();
});
$("step-form").addEventListener("submit", (event) => {
  event.preventDefault();
  send({ type: "step", node: status.node, deg: Number($("step-deg").value), seconds: Number($("step-s").value) });
});
$("find").addEventListener("input", () => {
  const words = $("find").value.toLowerCase();
  for (const { row, text } of rows.values()) row.hidden = !text.includes(words);
  for (const details of $("tree").children) {
    const found = [...details.querySelectorAll("tr")].some((row) => !row.hidden);
    details.hidden = !found;
    details.open = found && words !== "";
  }
});
whileSilent(show);
for (const id of ACTING) $(id).disabled = true; // until the program on the bus has been heard
connect(receive, lost);
