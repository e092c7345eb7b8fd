// Sticks, keys and gamepad as shares -1 .. 1 of forward, left, turn left and pitch. Each reports its changes.
const DEAD_ZONE = 0.08;
const KEYS = {
  KeyW: ["forward", 1], KeyS: ["forward", -1], KeyA: ["turn", 1], KeyD: ["turn", -1], KeyQ: ["left", 1], KeyE: ["left", -1],
};
export const still = () => ({ forward: 0, left: 0, turn: 0, pitch: 0 });

export class Stick {
  // ``axes``: the share that grows to the right and the one that grows upward, with their signs.
  constructor(element, axes, changed) {
    this.element = element;
    this.knob = element.firstElementChild;
    this.axes = axes;
    this.changed = changed;
    this.x = this.y = 0;
    this.pointer = null;
    element.addEventListener("pointerdown", (event) => this.grab(event));
    element.addEventListener("pointermove", (event) => event.pointerId === this.pointer && this.move(event));
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      element.addEventListener(end, (event) => event.pointerId === this.pointer && this.release(event));
    }
  }

  grab(event) {
    if (this.pointer !== null) return;
    this.pointer = event.pointerId;
    this.element.setPointerCapture(event.pointerId);
    this.move(event);
    event.preventDefault();
  }

  move(event) {
    const box = this.element.getBoundingClientRect(), radius = box.width * 0.36;
    const x = (event.clientX - box.left - box.width / 2) / radius;
    const y = -(event.clientY - box.top - box.height / 2) / radius;
    const length = Math.max(1, Math.hypot(x, y));
    this.set(x / length, y / length, event);
  }

  release(event) {
    this.pointer = null;
    this.set(0, 0, event);
  }

  set(x, y, event) {
    this.x = Math.abs(x) < DEAD_ZONE ? 0 : x;
    this.y = Math.abs(y) < DEAD_ZONE ? 0 : y;
    const radius = this.element.clientWidth * 0.36;
    this.knob.style.transform = `translate(${x * radius}px, ${-y * radius}px)`;
    this.changed(event.timeStamp);
  }

  shares() {
    const shares = still();
    shares[this.axes.right[0]] += this.axes.right[1] * this.x;
    shares[this.axes.up[0]] += this.axes.up[1] * this.y;
    return shares;
  }
}

export class Keys {
  constructor(changed) {
    this.down = new Set();
    this.changed = changed;
    addEventListener("keyup", (event) => this.release(event));
    addEventListener("blur", (event) => this.releaseAll(event));
  }

  press(event) {
    if (!(event.code in KEYS) || event.repeat) return event.code in KEYS;
    this.down.add(event.code);
    this.changed(event.timeStamp);
    return true;
  }

  release(event) {
    if (this.down.delete(event.code)) this.changed(event.timeStamp);
  }

  releaseAll(event) {
    if (this.down.size === 0) return;
    this.down.clear();
    this.changed(event.timeStamp);
  }

  shares() {
    const shares = still();
    for (const code of this.down) shares[KEYS[code][0]] += KEYS[code][1];
    return shares;
  }
}

export class Pad {
  // Standard mapping: axes 0, 1 left stick, 2, 3 right stick; buttons 1 B, 4 left shoulder, 8 select, 9 start.
  constructor(changed, buttons) {
    this.changed = changed;
    this.buttons = buttons;
    this.last = "";
    this.pressed = new Set();
    this.now = still();
  }

  poll(timeStamp) {
    const pad = (navigator.getGamepads ? [...navigator.getGamepads()] : []).find((each) => each && each.connected);
    this.listen(pad, timeStamp);
    const held = pad && pad.buttons[4] && pad.buttons[4].pressed;
    const axis = (i) => (!held || Math.abs(pad.axes[i] || 0) < DEAD_ZONE ? 0 : -pad.axes[i]);
    this.now = { forward: axis(1), left: axis(0), turn: axis(2), pitch: axis(3) };
    const text = JSON.stringify(this.now);
    if (text !== this.last && this.last !== "") this.changed(timeStamp);
    this.last = text;
  }

  listen(pad, timeStamp) {
    for (const [number, act] of Object.entries(this.buttons)) {
      const pressed = Boolean(pad && pad.buttons[number] && pad.buttons[number].pressed);
      if (pressed && !this.pressed.has(number)) act(timeStamp);
      if (pressed) this.pressed.add(number);
      else this.pressed.delete(number);
    }
  }

  shares() {
    return this.now;
  }
}
