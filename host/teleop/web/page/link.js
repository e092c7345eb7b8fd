// The websocket to the program that serves the page, opened again when it is lost; STOP by button and space bar.
const PING_MS = 1000, RECONNECT_MS = 700;
let socket = null;

export function connect(receive, lost) {
  socket = new WebSocket(`ws://${location.host}/ws`);
  socket.onmessage = (event) => receive(JSON.parse(event.data));
  socket.onclose = () => {
    lost();
    setTimeout(() => connect(receive, lost), RECONNECT_MS);
  };
}

export function send(message) {
  if (socket && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
}

export function stop(timeStamp) {
  send({ type: "stop", t_ms: performance.timeOrigin + (timeStamp || performance.now()) });
}

const button = document.getElementById("stop");
button.addEventListener("pointerdown", (event) => stop(event.timeStamp));
button.addEventListener("click", (event) => event.detail === 0 && stop(event.timeStamp));
addEventListener("keydown", (event) => {
  if (event.code !== "Space" || event.target.matches("input[type=search]")) return;
  if (!event.repeat) stop(event.timeStamp);
  event.preventDefault(); // also on a focused button: space always stops, Enter presses buttons
});
addEventListener("keyup", (event) => event.code === "Space" && event.preventDefault());
setInterval(() => send({ type: "ping", t_ms: performance.now() }), PING_MS);
