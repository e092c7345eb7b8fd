// The websocket to the program that serves the page, opened again when it is lost; STOP by button and space bar.
const PING_MS = 1000, RECONNECT_MS = 700, SILENT_MS = 1000;
let socket = null, heardMs = 0;

export const $ = (id) => document.getElementById(id);
export const isSilent = () => performance.now() - heardMs > SILENT_MS;
export const whileSilent = (show) => setInterval(() => isSilent() && show(), SILENT_MS);

export function connect(receive, lost) {
  socket = new WebSocket(`ws://${location.host}/ws`);
  socket.onmessage = (event) => {
    heardMs = performance.now();
    const message = JSON.parse(event.data);
    receive(message);
    if (message.type === "status") send({ type: "seen" }); // only then the next one comes
  };
  socket.onclose = () => {
    lost();
    setTimeout(() => connect(receive, lost), RECONNECT_MS);
  };
}

// Switch off the controls that can't act now; ``whyNot`` returns the reason, which becomes the title, "" for one that can.
export function allow(controls, whyNot) {
  for (const id of controls) {
    const why = whyNot(id);
    $(id).disabled = why !== "";
    $(id).title = why;
  }
}

export function send(message) {
  if (socket && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
}

export function stop(timeStamp) {
  send({ type: "stop", t_ms: performance.timeOrigin + (timeStamp || performance.now()) });
}

const button = $("stop");
button.addEventListener("pointerdown", (event) => stop(event.timeStamp));
button.addEventListener("click", (event) => event.detail === 0 && stop(event.timeStamp));
addEventListener("keydown", (event) => {
  if (event.code !== "Space" || event.target.matches("input[type=search]")) return;
  if (!event.repeat) stop(event.timeStamp);
  event.preventDefault(); // also on a focused button: space always stops, Enter presses buttons
});
addEventListener("keyup", (event) => event.code === "Space" && event.preventDefault());
setInterval(() => send({ type: "ping", t_ms: performance.now() }), PING_MS);
