// Draws the robot from the side and from above: legs, feet, support polygon, centre of mass. Metres in, pixels out.
const NEAR = [0, 2]; // FR and RR are nearer to somebody who looks from the right
const ORDER = [1, 3, 0, 2];

export function draw(view, canvases) {
  const style = getComputedStyle(document.documentElement);
  const colour = (name) => style.getPropertyValue(name).trim();
  const legs = view.legs;
  const reach = Math.max(...legs.flat().map((point) => Math.max(Math.abs(point[0]), Math.abs(point[1]))), 0.1) * 1.2;
  const lowest = view.ground_m;
  const middle = lowest / 2;
  paint(canvases.side, reach, (p) => [p[0], p[2] - middle], (pen) => {
    pen.line([[-2 * reach, 0, lowest], [2 * reach, 0, lowest]], colour("--soft"), 1);
    body(pen, legs, colour);
    pen.dot(view.com, 5, colour("--stop"));
  });
  paint(canvases.top, reach, (p) => [p[0], p[1]], (pen) => {
    pen.area(view.standing.map((leg) => legs[leg][3]), colour("--area"), colour("--good"));
    body(pen, legs, colour);
    legs.forEach((leg, i) => pen.dot(leg[3], 4, view.standing.includes(i) ? colour("--good") : colour("--soft")));
    pen.dot(view.com, 5, colour("--stop"));
  });
}

function body(pen, legs, colour) {
  for (const leg of ORDER) {
    pen.line(legs[leg], NEAR.includes(leg) ? colour("--right") : colour("--left"), 3);
  }
  pen.line([0, 1, 3, 2, 0].map((leg) => legs[leg][0]), colour("--text"), 4);
}

function paint(canvas, reach, flat, work) {
  const ratio = devicePixelRatio || 1;
  const width = canvas.clientWidth, height = canvas.clientHeight;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  const scale = Math.min(width / (2 * reach), height / (1.7 * reach));
  const at = (point) => {
    const [x, y] = flat(point);
    return [width / 2 + scale * x, height / 2 - scale * y];
  };
  work(pen(context, at));
}

function pen(context, at) {
  const path = (points) => {
    context.beginPath();
    points.forEach((point, i) => (i ? context.lineTo(...at(point)) : context.moveTo(...at(point))));
  };
  return {
    line(points, colour, width) {
      path(points);
      context.strokeStyle = colour;
      context.lineWidth = width;
      context.lineJoin = context.lineCap = "round";
      context.stroke();
    },
    area(points, fill, edge) {
      if (points.length < 2) return;
      path(points);
      context.closePath();
      context.fillStyle = fill;
      context.fill();
      context.strokeStyle = edge;
      context.lineWidth = 1;
      context.stroke();
    },
    dot(point, radius, colour) {
      context.beginPath();
      context.arc(...at(point), radius, 0, 2 * Math.PI);
      context.fillStyle = colour;
      context.fill();
    },
  };
}
