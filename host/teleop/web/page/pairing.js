// Pairing: trades the code from the terminal for a token that the browser keeps.
import { $ } from "/link.js";

let scanned = /^#\d{6}$/.test(location.hash) ? location.hash.slice(1) : ""; // the QR code in the terminal has it
history.replaceState(null, "", location.pathname);

export async function askForPairing(done) {
  try {
    const answer = await (await fetch("/paired")).json();
    $("pairing").hidden = answer.paired;
    done(answer);
    if (!answer.paired && scanned) pair(scanned);
  } catch {
    $("pairing").hidden = true; // the robot is not there: the state says so
  }
}

async function pair(code) {
  scanned = "";
  const answer = await fetch("/pair", { method: "POST", body: code });
  $("pair-answer").textContent = answer.ok ? "" : (await answer.text()).trim();
}

$("pair-form").addEventListener("submit", (event) => {
  event.preventDefault();
  pair($("code").value);
});
