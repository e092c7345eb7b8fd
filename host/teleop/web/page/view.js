// Draws the robot on its ground in perspective; dragging turns the camera. Metres in, pixels out.
const ORDER = [0, 1, 3, 2, 0]; // legs around the body: FR, FL, RL, RR
const RIGHT = [0, 2];
const THICK_M = 0.025; // half the height of the drawn body
const SQUARE_M = 0.1, SQUARES = 8; // of the ground's grid, to either side
const CAMERAS = { space: [-2.2, 0.42], side: [-Math.PI / 2, 0.03], top: [-Math.PI / 2, Math.PI / 2 - 0.001] };
const NEAREST_RAD = 0.02;

export class View {
  constructor(canvas) {
    this.canvas = canvas;
    this.grabbed = null;
    this.last = null;
    this.look("space");
    canvas.addEventListener("pointerdown", (event) => {
      this.grabbed = [event.clientX, event.clientY];
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => this.grabbed && this.turn(event));
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => (this.grabbed = null));
  }

  // Show one of the named views.
  look(name) {
    [this.azimuth, this.elevation] = CAMERAS[name];
    if (this.last) this.draw(...this.last);
  }

  turn(event) {
    const [x, y] = this.grabbed;
    this.grabbed = [event.clientX, event.clientY];
    this.azimuth -= (event.clientX - x) / 120;
    this.elevation = Math.max(NEAREST_RAD, Math.min(Math.PI / 2 - 0.001, this.elevation + (event.clientY - y) / 120));
    if (this.last) this.draw(...this.last);
  }

  // ``view``: the robot level, in its own axes; ``at``: its x, y and yaw on the ground. ``line``: the (x, z) of a ground
  // that is not flat, on which the robot's middle is ``height`` above z = 0.
  draw(view, at, line = null, height = 0) {
    this.last = [view, at, line, height];
    const pen = this.pen(view);
    const style = getComputedStyle(document.documentElement);
    const colour = (name) => style.getPropertyValue(name).trim();
    const surface = line ? (wx) => along(line, wx) - height : () => view.ground_m;
    grid(pen, surface, line || [], at, colour("--line"), colour("--soft"));
    const feet = view.standing.map((leg) => view.legs[leg][3]);
    pen.area(feet, colour("--area"), colour("--good"));
    pen.line([view.com, [view.com[0], view.com[1], surface(at[0])]], colour("--stop"), 1);
    const parts = view.legs.map((leg, i) => [depth(pen, leg), () => limb(pen, leg, RIGHT.includes(i) ? colour("--right") : colour("--left"),
      view.standing.includes(i) ? colour("--good") : colour("--soft"))]);
    parts.push([depth(pen, view.legs.map((leg) => leg[0])), () => trunk(pen, view.legs, colour("--trunk"), colour("--text"))]);
    for (const [, paint] of parts.sort((a, b) => b[0] - a[0])) paint();
    pen.dot(view.com, 5, colour("--stop"));
  }

  pen(view) {
    const canvas = this.canvas, ratio = devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    const context = canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    const reach = Math.max(...view.legs.flat().map((point) => Math.hypot(point[0], point[1])), 0.1);
    return new Pen(context, camera(this.azimuth, this.elevation, reach, view.ground_m / 2, width, height));
  }
}

// Return a point in pixels and its distance, m; null behind the camera.
function camera(azimuth, elevation, reach, middle, width, height) {
  const away = 6 * reach, scale = 0.36 * Math.min(width, 1.35 * height) / reach * away;
  const ca = Math.cos(azimuth), sa = Math.sin(azimuth), ce = Math.cos(elevation), se = Math.sin(elevation);
  return ([x, y, z]) => {
    const right = -sa * x + ca * y, ahead = ca * x + sa * y, up = z - middle;
    const far = away - (ce * ahead + se * up);
    return far < 0.05 * away ? null : [width / 2 + (scale * right) / far, height / 2 - (scale * (ce * up - se * ahead)) / far, far];
  };
}

const depth = (pen, points) => points.reduce((sum, point) => sum + (pen.at(point) || [0, 0, 0])[2], 0) / points.length;

// Return the height of a polyline at x; at a riser, that of its far end.
function along(line, x) {
  const after = line.findIndex((point) => point[0] > x);
  if (after < 1) return line[after < 0 ? line.length - 1 : 0][1];
  const [[x0, z0], [x1, z1]] = [line[after - 1], line[after]];
  return z0 + ((z1 - z0) * (x - x0)) / (x1 - x0);
}

// The ground's squares stay in place while the robot walks over them. Corners of the ground have lines of their own.
function grid(pen, surface, line, [x, y, yaw], colour, edge) {
  const c = Math.cos(yaw), s = Math.sin(yaw), around = SQUARES * SQUARE_M;
  const seen = (wx, wy, z) => [c * (wx - x) + s * (wy - y), -s * (wx - x) + c * (wy - y), z];
  const firstX = Math.round(x / SQUARE_M) * SQUARE_M, firstY = Math.round(y / SQUARE_M) * SQUARE_M;
  const near = line.filter((point) => Math.abs(point[0] - firstX) < around);
  const zero = line.length ? surface(x) - along(line, x) : 0; // of the picture's heights to the ground's
  const way = [[firstX - around, surface(firstX - around)], ...near.map(([wx, z]) => [wx, z + zero]), [firstX + around, surface(firstX + around)]];
  for (let i = -SQUARES; i <= SQUARES; i++) {
    const wx = firstX + i * SQUARE_M, wy = firstY + i * SQUARE_M;
    pen.line([seen(wx, firstY - around, surface(wx)), seen(wx, firstY + around, surface(wx))], colour, 1);
    pen.line(way.map(([px, z]) => seen(px, wy, z)), colour, 1);
  }
  for (const [wx, z] of near) pen.line([seen(wx, firstY - around, z + zero), seen(wx, firstY + around, z + zero)], edge, 1.5);
}

function limb(pen, leg, colour, foot) {
  pen.line(leg, colour, 4);
  pen.dot(leg[3], 4, foot);
}

function trunk(pen, legs, fill, edge) {
  const hips = ORDER.map((leg) => legs[leg][0]);
  const [below, above] = [-THICK_M, THICK_M].map((off) => hips.map(([x, y, z]) => [x, y, z + off]));
  for (const face of [below, above]) pen.area(face, fill, edge);
  below.forEach((corner, i) => i && pen.area([below[i - 1], corner, above[i], above[i - 1]], fill, edge));
}

class Pen {
  constructor(context, at) {
    this.context = context;
    this.at = at;
  }

  path(points) {
    const seen = points.map(this.at);
    if (seen.includes(null)) return false;
    this.context.beginPath();
    seen.forEach(([x, y], i) => (i ? this.context.lineTo(x, y) : this.context.moveTo(x, y)));
    return true;
  }

  line(points, colour, width) {
    if (!this.path(points)) return;
    Object.assign(this.context, { strokeStyle: colour, lineWidth: width, lineJoin: "round", lineCap: "round" });
    this.context.stroke();
  }

  area(points, fill, edge) {
    if (points.length < 2 || !this.path(points)) return;
    this.context.closePath();
    Object.assign(this.context, { fillStyle: fill, strokeStyle: edge, lineWidth: 1 });
    this.context.fill();
    this.context.stroke();
  }

  dot(point, radius, colour) {
    const seen = this.at(point);
    if (!seen) return;
    this.context.beginPath();
    this.context.arc(seen[0], seen[1], radius, 0, 2 * Math.PI);
    this.context.fillStyle = colour;
    this.context.fill();
  }
}
