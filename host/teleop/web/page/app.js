// The page: one websocket; sends the sticks when they change and ten times a second while they are in use.
import { Keys, Pad, Stick, still } from "/inputs.js";
import { $, allow, connect, isSilent, send, stop, whileSilent } from "/link.js";
import { askForPairing } from "/pairing.js";
import { Plots, STATUS } from "/plots.js";
import { View } from "/view.js";

const AGAIN_MS = 100; // a third of the robot's dead-man time
const POSES = [
  ["x", "Ahead", "m"], ["y", "Left", "m"], ["z", "Up", "m"], ["roll", "Roll", "rad"], ["pitch", "Nose down", "rad"], ["yaw", "Turn left", "rad"],
];
const LEGS = ["FR", "FL", "RR", "RL"];
const HOT_SHARE = 0.9;
const DIFFERS = 0.25; // of the speed told: less is the robot's own rhythm
const SWAY_M = 0.02, SHARE = 0.05; // of a status, 20 a second: walked speeds are evened over a second
const evened = [0, 0, 0];
const FIRM_MS = 2500; // so long a speed may take to come about
const HOLD_MS = 700; // a choice just made here is not overwritten by a status that does not know of it yet

let chosenMs = -HOLD_MS;
let hello = null, status = null, sentMs = 0;
const sticks = [
  new Stick($("walk"), { right: ["left", -1], up: ["forward", 1] }, changed),
  new Stick($("turn"), { right: ["turn", -1], up: ["pitch", 1] }, changed),
];
const view = new View($("view")), plots = new Plots($("plot-pick"), $("plot-clear"), $("plot-list"), STATUS, (news) => news.time_s, 20);
let walked_m = 0, place = null, ground = "", agreedMs = 0;
const keys = new Keys(changed);
const pad = new Pad(changed, { 1: stop, 8: () => send({ type: "reset" }), 9: () => posture("stand") });

function lost() {
  hello = status = null;
  show();
  askForPairing(told);
}

function told(answer) {
  $("unpair").hidden = !answer.kept;
  show();
}

function receive(message) {
  if (message.type === "hello") begin(message);
  else if (message.type === "pong") $("latency").textContent = `${(performance.now() - message.t_ms).toFixed(0)} ms`;
  else if (message.type === "status") {
    status = message;
    follow();
    plots.push(status);
    plots.paint();
    show();
  }
}

function begin(message) {
  hello = message;
  askForPairing(told);
  document.title = message.simulated ? `${message.robot}, simulation` : message.robot;
  $("robot").textContent = message.robot;
  $("sim").hidden = !message.simulated;
  walked_m = 0;
  place = null;
  $("pairing").hidden = true;
  const gaits = Object.entries(message.gaits); // name: why it is not advised for this robot, or ""
  $("gait").replaceChildren(...gaits.map(([name, why]) => new Option(why ? `${name} (not advised)` : name, name)));
  const grounds = Object.keys(message.grounds || {});
  $("grounds").hidden = grounds.length === 0;
  $("ground").replaceChildren(...grounds.map((name) => new Option(name, name)));
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

const mine = () => Boolean(hello && status && status.driver && status.driver[0] === "web" && status.driver[1] === hello.page);
const free = () => Boolean(status && (!status.driver || mine()));

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

// The inputs' command, in SI. A page that may not drive sends none.
function changed(timeStamp) {
  if (!hello || !free()) return;
  const now = shares(), share = $("share").value / 100, [vx, vy, wz] = status.fastest; // of the gait
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
  const silent = !status || isSilent();
  $("state").className = silent || status.stop || status.fault ? "halted" : status.reason ? "" : "moves";
  const paired = $("pairing").hidden;
  $("word").textContent = !silent ? status.state : paired ? "no connection" : "not paired";
  $("reason").textContent = !silent ? status.reason || "moving as commanded" : paired
    ? "the robot does not answer; it stops by itself" : "this page can't drive or stop the robot yet: enter the code below";
  $("stop").classList.toggle("dead", silent);
  allow(ACTING, (id) => whyNot(id, silent));
  for (const stick of sticks) stick.element.setAttribute("aria-disabled", String(whyNot("stick", silent) !== ""));
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
  if (status.place && performance.now() - chosenMs > HOLD_MS && document.activeElement !== $("ground")) $("ground").value = status.ground;
  // On a simulated ground the robot is drawn where it is, else where odometry has it.
  if (status.view && status.place) view.draw(status.view, [status.place[0], status.place[1], status.place[3]], hello.grounds[status.ground], status.place[2]);
  else if (status.view) view.draw(status.view, status.odometry);
}

// Add up the way on the ground, without the body's swaying.
function follow() {
  if (status.ground !== ground) {
    ground = status.ground; // the robot has been put down there
    walked_m = 0;
    place = null;
  }
  status.odometry.slice(3).forEach((speed, i) => (evened[i] += (speed - evened[i]) * SHARE)); // a body sways at each step
  const [x, y] = status.odometry, way = place ? Math.hypot(x - place[0], y - place[1]) : SWAY_M;
  if (way < SWAY_M) return;
  if (place) walked_m += way;
  place = [x, y];
}

const ACTING = ["take", "stand", "sit", "rest", "reset", "gait", "balance", "level", "ground"];
const UP = ["standing up", "standing", "walking", "crawling", "lifted"];

// Why a control can't act now, "" if it can.
function whyNot(id, silent) {
  if (silent) return "no connection to the robot";
  if (!free()) return `${status.driver.filter(Boolean).join(" ")} drives`;
  if (id === "reset") return status.stop || status.fault ? "" : "nothing to reset";
  if (id === "stand") return status.stop || status.fault ? "reset first" : UP.includes(status.state) ? "the robot already stands" : "";
  if (id === "sit") return UP.includes(status.state) ? "" : "the robot does not stand";
  if (id === "rest") return status.armed ? "" : "the joints are already off";
  if (id === "ground") return status.armed ? "switch the joints off first: the robot is put down there" : "";
  if (id === "stick" || id === "level") return UP.includes(status.state) ? "" : "stand up first";
  return "";
}

// Commanded and walked speeds, and why they differ.
function speeds(shown) {
  const [vx, vy, wz] = status.speed, now = evened;
  const said = (told, is) => `${shown(told, 2)} → ${shown(is, 2)}`;
  $("speed").textContent = `ahead ${said(vx, now[0])} m/s, left ${said(vy, now[1])} m/s, turning ${said(wz, now[2])} rad/s`;
  const off = Math.hypot(now[0] - vx, now[1] - vy), told = Math.hypot(vx, vy);
  if (status.state !== "walking" && status.state !== "crawling" || off <= DIFFERS * told + 0.005) agreedMs = performance.now();
  const long = performance.now() - agreedMs > FIRM_MS;
  $("why").textContent = status.slower || (long ? "its feet slip, or something holds it up" : "");
}

function facts() {
  const shown = (value, digits) => value.toFixed(digits).replace(/^-(0\.?0*)$/, "$1"); // no "-0"
  const degrees = (angle) => `${shown((angle * 180) / Math.PI, 1)}°`;
  const [x, y, yaw] = status.odometry, [xx, , , , yy, , , , turned] = status.covariance.map((square) => 2 * Math.sqrt(Math.abs(square)));
  $("walked").textContent = `${shown(walked_m, 2)} m`;
  $("place").textContent = `ahead ${shown(x, 2)} m, left ${shown(y, 2)} m, turned ${degrees(yaw)} (± ${shown(Math.max(xx, yy), 2)} m, ${degrees(turned)})`;
  speeds(shown);
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
  if (event.code === "Space" || event.ctrlKey || event.altKey || event.metaKey || event.target.matches("input:not([type=range],[type=checkbox]), select")) return;
  if (keys.press(event)) event.preventDefault();
  else if (event.code in SHORT && !event.repeat) SHORT[event.code]();
});
document.addEventListener("visibilitychange", () => document.hidden && mine() && send({ type: "release" }));

function level() {
  for (const [name] of POSES) {
    $(`pose-${name}`).value = 0;
    $(`pose-${name}`).dispatchEvent(new Event("input"));
  }
}

$("take").addEventListener("click", () => send({ type: mine() ? "release" : "take" }));
$("reset").addEventListener("click", () => send({ type: "reset" }));
$("level").addEventListener("click", level);
$("gait").addEventListener("change", () => {
  choose({ type: "gait", gait: $("gait").value });
  show();
});
$("ground").addEventListener("change", () => choose({ type: "ground", ground: $("ground").value }));
$("balance").addEventListener("change", () => choose({ type: "balance", on: $("balance").checked }));
$("share").addEventListener("input", () => ($("share-now").textContent = `${$("share").value} %`));
for (const button of document.querySelectorAll("[data-camera]")) {
  button.addEventListener("click", () => view.look(button.dataset.camera));
}
for (const button of document.querySelectorAll("[data-posture]")) {
  button.addEventListener("click", () => posture(button.dataset.posture));
}
$("unpair").addEventListener("click", () => fetch("/unpair", { method: "POST" }));

setInterval(again, AGAIN_MS);
whileSilent(show);
(function frame(timeStamp) {
  pad.poll(timeStamp);
  requestAnimationFrame(frame);
})(performance.now());
for (const id of ACTING) $(id).disabled = true; // until the robot has been heard
connect(receive, lost);
