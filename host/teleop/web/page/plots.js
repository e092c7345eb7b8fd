// Live plots of what the user picks: one small chart each, the last seconds of it, with the newest value.
const MOST = 6;
const LEGS = ["FR", "FL", "RR", "RL"], JOINTS = ["hip", "thigh", "calf"];
const DEGREES = 180 / Math.PI;

// Name: the value of a status, and its unit.
export const STATUS = new Map([
  ["commanded speed", [(status) => status.speed[0], "m/s"]],
  ["walked speed", [(status) => status.odometry[3], "m/s"]],
  ["commanded turning", [(status) => status.speed[2], "rad/s"]],
  ["walked turning", [(status) => status.odometry[5], "rad/s"]],
  ["roll", [(status) => status.attitude_rad && DEGREES * status.attitude_rad[0], "°"]],
  ["pitch", [(status) => status.attitude_rad && DEGREES * status.attitude_rad[1], "°"]],
  ["stability margin", [(status) => status.margin_m === null ? null : 1000 * status.margin_m, "mm"]],
  ["battery", [(status) => status.battery_V, "V"]],
  ["hottest joint", [(status) => Math.max(...status.temperature_C.filter((heat) => heat !== null)), "°C"]],
  ["bus errors", [(status) => status.bus_errors, ""]],
]);
LEGS.forEach((leg, i) => JOINTS.forEach((joint, j) => {
  STATUS.set(`${leg} ${joint} angle`, [(status) => DEGREES * status.joints_rad[3 * i + j], "°"]);
  STATUS.set(`${leg} ${joint} load`, [(status) => 100 * status.load[3 * i + j], "%"]);
}));

// ``choices``: name: [value of a status, unit]; ``time``: its time, s; ``seconds``: the length of a plot.
export class Plots {
  constructor(pick, clear, list, choices, time, seconds) {
    this.pick = pick;
    this.list = list;
    this.choices = choices;
    this.time = time;
    this.seconds = seconds;
    this.now = 0;
    this.shown = new Map(); // name: {figure, canvas, caption, points}
    pick.replaceChildren(new Option("pick a value", ""), ...[...choices.keys()].map((name) => new Option(name, name)));
    pick.addEventListener("change", () => {
      this.add(pick.value);
      pick.value = "";
    });
    clear.addEventListener("click", () => this.clear());
  }

  add(name) {
    if (!this.choices.has(name) || this.shown.has(name)) return;
    if (this.shown.size >= MOST) this.remove(this.shown.keys().next().value);
    const figure = document.createElement("figure"), canvas = document.createElement("canvas"), caption = document.createElement("figcaption");
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `${name} over the last ${this.seconds} s`);
    figure.append(caption, canvas);
    this.list.append(figure);
    this.shown.set(name, { figure, canvas, caption, points: [] });
  }

  remove(name) {
    this.shown.get(name).figure.remove();
    this.shown.delete(name);
  }

  clear() {
    for (const name of [...this.shown.keys()]) this.remove(name);
  }

  forget() {
    for (const plot of this.shown.values()) plot.points.length = 0;
  }

  push(news) {
    this.now = this.time(news);
    for (const [name, { points }] of this.shown) {
      points.push([this.now, this.choices.get(name)[0](news)]);
      while (points[0][0] < this.now - this.seconds) points.shift();
    }
  }

  paint() {
    for (const [name, plot] of this.shown) {
      const unit = this.choices.get(name)[1], value = plot.points.length ? plot.points.at(-1)[1] : null;
      plot.caption.textContent = `${name}: ${value === null ? "unknown" : value.toFixed(unit === "m/s" || unit === "rad/s" ? 3 : 1)} ${unit}`;
      draw(plot.canvas, plot.points, this.now, this.seconds);
    }
  }
}

function draw(canvas, points, now, seconds) {
  const ratio = devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  const context = canvas.getContext("2d"), style = getComputedStyle(document.documentElement);
  const known = points.filter((point) => point[1] !== null).map((point) => point[1]);
  if (known.length < 2) return;
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  const low = Math.min(...known), high = Math.max(...known);
  const room = (high - low || 1) * 0.08;
  const at = ([time, value]) => [width * (1 - (now - time) / seconds), height * (1 - (value - low + room) / (high - low + 2 * room))];
  context.fillStyle = style.getPropertyValue("--soft");
  context.font = "11px system-ui";
  context.fillText(high.toPrecision(3), 2, 11);
  context.fillText(low.toPrecision(3), 2, height - 3);
  context.strokeStyle = style.getPropertyValue("--accent");
  context.lineWidth = 1.5;
  context.beginPath();
  let joined = false;
  for (const point of points) {
    if (point[1] !== null) context[joined ? "lineTo" : "moveTo"](...at(point));
    joined = point[1] !== null;
  }
  context.stroke();
}
