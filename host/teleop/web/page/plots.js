// Live plots of what the user picks: one small chart each, the last SECONDS of it, with the newest value.
const SECONDS = 20, MOST = 6;
const LEGS = ["FR", "FL", "RR", "RL"], JOINTS = ["hip", "thigh", "calf"];
const DEGREES = 180 / Math.PI;

// Name: the value of a status, and its unit.
const CHOICES = new Map([
  ["speed told", [(status) => status.speed[0], "m/s"]],
  ["speed walked", [(status) => status.odometry[3], "m/s"]],
  ["turning told", [(status) => status.speed[2], "rad/s"]],
  ["turning walked", [(status) => status.odometry[5], "rad/s"]],
  ["roll", [(status) => status.attitude_rad && DEGREES * status.attitude_rad[0], "°"]],
  ["pitch", [(status) => status.attitude_rad && DEGREES * status.attitude_rad[1], "°"]],
  ["stability margin", [(status) => status.margin_m === null ? null : 1000 * status.margin_m, "mm"]],
  ["battery", [(status) => status.battery_V, "V"]],
  ["hottest joint", [(status) => Math.max(...status.temperature_C.filter((heat) => heat !== null)), "°C"]],
  ["bus errors", [(status) => status.bus_errors, ""]],
]);
LEGS.forEach((leg, i) => JOINTS.forEach((joint, j) => {
  CHOICES.set(`${leg} ${joint} angle`, [(status) => DEGREES * status.joints_rad[3 * i + j], "°"]);
  CHOICES.set(`${leg} ${joint} load`, [(status) => 100 * status.load[3 * i + j], "%"]);
}));

export class Plots {
  constructor(pick, clear, list) {
    this.pick = pick;
    this.list = list;
    this.shown = new Map(); // name: {canvas, value, points}
    pick.replaceChildren(new Option("pick a value", ""), ...[...CHOICES.keys()].map((name) => new Option(name, name)));
    pick.addEventListener("change", () => {
      this.add(pick.value);
      pick.value = "";
    });
    clear.addEventListener("click", () => this.clear());
  }

  add(name) {
    if (!CHOICES.has(name) || this.shown.has(name)) return;
    if (this.shown.size >= MOST) this.remove(this.shown.keys().next().value);
    const figure = document.createElement("figure"), canvas = document.createElement("canvas"), caption = document.createElement("figcaption");
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `${name} over the last ${SECONDS} s`);
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

  take(status) {
    for (const [name, plot] of this.shown) {
      const [of, unit] = CHOICES.get(name), value = of(status);
      plot.points.push([status.time_s, value]);
      while (plot.points[0][0] < status.time_s - SECONDS) plot.points.shift();
      plot.caption.textContent = `${name}: ${value === null ? "unknown" : value.toFixed(unit === "m/s" || unit === "rad/s" ? 3 : 1)} ${unit}`;
      draw(plot.canvas, plot.points, status.time_s);
    }
  }
}

function draw(canvas, points, now) {
  const ratio = devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  const context = canvas.getContext("2d"), style = getComputedStyle(document.documentElement);
  const known = points.filter((point) => point[1] !== null).map((point) => point[1]);
  if (known.length < 2) return;
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  const low = Math.min(...known), high = Math.max(...known);
  const room = (high - low || 1) * 0.08;
  const at = ([time, value]) => [width * (1 - (now - time) / SECONDS), height * (1 - (value - low + room) / (high - low + 2 * room))];
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
