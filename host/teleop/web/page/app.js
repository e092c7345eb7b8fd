// The page: one websocket; sends the sticks when they change and ten times a second while they are in use.
import { Keys, Pad, Stick, still } from "/inputs.js";
import { draw } from "/view.js";

const AGAIN_MS = 100; // a third of the robot's dead-man time
const PING_MS = 1000;
const RECONNECT_MS = 700;
const SILENT_MS = 1000;
const POSES = [
  ["x", "Ahead", "m"], ["y", "Left", "m"], ["z", "Up", "m"], ["roll", "Roll", "rad"], ["pitch", "Nose down", "rad"], ["yaw", "Turn left", "rad"],
];
const LEGS = ["FR", "FL", "RR", "RL"];
const HOT_SHARE = 0.9;
const $ = (id) => document.getElementById(id);

const HOLD_MS = 700; // a choice just made here is not overwritten by a status that does not know of it yet

let chosenMs = -HOLD_MS;
let socket = null, hello = null, status = null, heardMs = 0, sentMs = 0;
const sticks = [
  new Stick($("walk"), { right: ["left", -1], up: ["forward", 1] }, changed),
  new Stick($("turn"), { right: ["turn", -1], up: ["pitch", 1] }, changed),
];
const keys = new Keys(changed);
const pad = new Pad(changed, { 1: stop, 8: () => send({ type: "reset" }), 9: () => posture("stand") });

function connect() {
  socket = new WebSocket(`ws://${location.host}/ws`);
  socket.onmessage = (event) => receive(JSON.parse(event.data));
  socket.onclose = () => {
    hello = status = null;
    show();
    askForPairing();
    setTimeout(connect, RECONNECT_MS);
  };
}

async function askForPairing() {
  try {
    const answer = await (await fetch("/paired")).json();
    $("pairing").hidden = answer.paired;
    show();
  } catch {
    $("pairing").hidden = true; // the robot is not there: the state says so
  }
}

function receive(message) {
  heardMs = performance.now();
  if (message.type === "hello") begin(message);
  else if (message.type === "pong") $("latency").textContent = `${(performance.now() - message.t_ms).toFixed(0)} ms`;
  else if (message.type === "status") {
    status = message;
    show();
  }
}

function begin(message) {
  hello = message;
  document.title = message.robot;
  $("pairing").hidden = true;
  const gaits = Object.entries(message.gaits); // name: why it is not advised for this robot, or ""
  $("gait").replaceChildren(...gaits.map(([name, why]) => new Option(why ? `${name} (not advised)` : name, name)));
  $("sliders").replaceChildren(...POSES.flatMap(slider));
}

function slider([name, label, unit], index) {
  const limit = hello.pose_limits[index], shown = unit === "m" ? 1000 : 180 / Math.PI;
  const text = document.createElement("label"), input = document.createElement("input"), output = document.createElement("output");
  text.textContent = label;
  text.htmlFor = input.id = `pose-${name}`;
  Object.assign(input, { type: "range", min: -limit, max: limit, step: limit / 50, value: 0 });
  const tell = () => (output.textContent = `${(input.value * shown).toFixed(0)} ${unit === "m" ? "mm" : "°"}`);
  input.addEventListener("input", (event) => {
    tell();
    changed(event.timeStamp);
  });
  tell();
  return [text, input, output];
}

function send(message) {
  if (socket && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
}

const mine = () => Boolean(hello && status && status.driver && status.driver[0] === "web" && status.driver[1] === hello.page);
const free = () => Boolean(status && (!status.driver || mine()));

function stop(timeStamp) {
  send({ type: "stop", t_ms: performance.timeOrigin + (timeStamp || performance.now()) });
}

function choose(message) {
  chosenMs = performance.now();
  send(message);
}

function posture(name) {
  if (free()) send({ type: "posture", posture: name });
}

function shares() {
  const sum = still();
  for (const source of [...sticks, keys, pad]) {
    for (const [axis, value] of Object.entries(source.shares())) sum[axis] += value;
  }
  for (const axis of Object.keys(sum)) sum[axis] = Math.max(-1, Math.min(1, sum[axis]));
  return sum;
}

// What the inputs say, in SI. A page that may not drive stays silent.
function changed(timeStamp) {
  if (!hello || !free()) return;
  const now = shares(), share = $("share").value / 100, [vx, vy, wz] = hello.speed_limits;
  const pose = POSES.map(([name], i) => {
    const held = name === "pitch" ? now.pitch * hello.pose_limits[i] : 0;
    const sum = Number($(`pose-${name}`).value) + held;
    return Math.max(-hello.pose_limits[i], Math.min(hello.pose_limits[i], sum));
  });
  sentMs = performance.now();
  const message = { type: "drive", vx_m_s: now.forward * share * vx, vy_m_s: now.left * share * vy, wz_rad_s: now.turn * share * wz, pose };
  if (timeStamp !== undefined) message.t_ms = performance.timeOrigin + timeStamp;
  send(message);
}

function again() {
  if (document.hidden || !mine()) return;
  if (performance.now() - sentMs >= AGAIN_MS * 0.9) changed();
}

function show() {
  const silent = !status || performance.now() - heardMs > SILENT_MS;
  $("state").className = silent || status.stop || status.fault ? "halted" : status.reason ? "" : "moves";
  const paired = $("pairing").hidden;
  $("word").textContent = !silent ? status.state : paired ? "no connection" : "not paired";
  $("reason").textContent = !silent ? status.reason || "moving as told" : paired
    ? "the robot does not answer; it stops by itself" : "this page can't drive or stop the robot yet: type the code below";
  $("stop").classList.toggle("dead", silent);
  for (const id of ["take", "stand", "sit", "rest", "reset", "gait", "balance", "level"]) $(id).disabled = silent || !free();
  for (const stick of sticks) stick.element.setAttribute("aria-disabled", String(silent || !free()));
  $("remark").textContent = silent ? "" : [status.remark, status.attitude_note].filter(Boolean).join("; ");
  const gait = $("gait").value, why = hello && hello.gaits[gait];
  $("advice").textContent = why ? `${gait} is not advised: ${why}` : "";
  if (silent) return;
  $("take").textContent = mine() ? "You drive: let go" : "Take the controls";
  $("take").setAttribute("aria-pressed", String(mine()));
  $("driver").textContent = mine() ? "you" : status.driver ? status.driver.filter(Boolean).join(" ") : "nobody";
  if (performance.now() - chosenMs > HOLD_MS) {
    if (document.activeElement !== $("gait")) $("gait").value = status.gait;
    $("balance").checked = status.balance;
  }
  facts();
  if (status.view) draw(status.view, { side: $("side"), top: $("top") });
}

function facts() {
  const shown = (value, digits) => value.toFixed(digits).replace(/^-(0\.?0*)$/, "$1"); // no "-0"
  const degrees = (angle) => `${shown((angle * 180) / Math.PI, 1)}°`;
  $("roll").textContent = status.attitude_rad ? degrees(status.attitude_rad[0]) : "unknown";
  $("pitch").textContent = status.attitude_rad ? degrees(status.attitude_rad[1]) : "unknown";
  $("margin").textContent = status.margin_m === null ? "–" : `${shown(1000 * status.margin_m, 0)} mm`;
  $("battery").textContent = status.battery_V === null ? "unknown" : `${status.battery_V.toFixed(1)} V`;
  $("missed").textContent = `${status.timing.missed} of ${status.timing.ticks}`;
  const table = $("joints");
  if (table.rows.length === 0) {
    for (const leg of LEGS) table.insertRow().innerHTML = `<th scope="row">${leg}</th><td></td><td></td><td></td>`;
  }
  status.load.forEach((load, i) => {
    const cell = table.rows[Math.floor(i / 3)].cells[1 + (i % 3)];
    cell.textContent = `${shown(100 * load, 0)} % ${(status.temperature_C[i] ?? 0).toFixed(0)} °C`;
    cell.className = Math.abs(load) > HOT_SHARE ? "high" : "";
  });
}

const SHORT = {
  KeyT: () => posture("stand"), KeyG: () => posture("sit"), KeyX: () => posture("rest"), KeyR: () => send({ type: "reset" }), KeyH: level,
};

addEventListener("keydown", (event) => {
  if (event.code === "Space") {
    if (!event.repeat) stop(event.timeStamp);
    event.preventDefault(); // also on a focused button: space always stops, Enter presses buttons
    return;
  }
  if (event.ctrlKey || event.altKey || event.metaKey || event.target.matches("input:not([type=range],[type=checkbox]), select")) return;
  if (keys.press(event)) event.preventDefault();
  else if (event.code in SHORT && !event.repeat) SHORT[event.code]();
});
addEventListener("keyup", (event) => event.code === "Space" && event.preventDefault());
document.addEventListener("visibilitychange", () => document.hidden && mine() && send({ type: "release" }));

function level() {
  for (const [name] of POSES) {
    $(`pose-${name}`).value = 0;
    $(`pose-${name}`).dispatchEvent(new Event("input"));
  }
}

$("stop").addEventListener("pointerdown", (event) => stop(event.timeStamp));
$("stop").addEventListener("click", (event) => event.detail === 0 && stop(event.timeStamp));
$("take").addEventListener("click", () => send({ type: mine() ? "release" : "take" }));
$("reset").addEventListener("click", () => send({ type: "reset" }));
$("level").addEventListener("click", level);
$("gait").addEventListener("change", () => {
  choose({ type: "gait", gait: $("gait").value });
  show();
});
$("balance").addEventListener("change", () => choose({ type: "balance", on: $("balance").checked }));
$("share").addEventListener("input", () => ($("share-now").textContent = `${$("share").value} %`));
for (const button of document.querySelectorAll("[data-posture]")) {
  button.addEventListener("click", () => posture(button.dataset.posture));
}
$("pair-form").addEventListener("submit", async (event) => {
  event.preventDefault();
  const answer = await fetch("/pair", { method: "POST", body: $("code").value });
  $("pair-answer").textContent = answer.ok ? "" : (await answer.text()).trim();
});

setInterval(again, AGAIN_MS);
setInterval(() => send({ type: "ping", t_ms: performance.now() }), PING_MS);
setInterval(() => performance.now() - heardMs > SILENT_MS && show(), SILENT_MS);
(function frame(timeStamp) {
  pad.poll(timeStamp);
  requestAnimationFrame(frame);
})(performance.now());
connect();
