// Source of frames: the stream of a run, or a complete recording.
import { decodeFrame } from "./wire.js";

const RETRY_MS = 400, RUN_ENDED = "the run has ended";  // the server's reason for closing
const token = new URLSearchParams(location.search).get("token") ?? "";
const address = (path) => `${path}?token=${encodeURIComponent(token)}`;

async function recording(on) {
  const buffer = await (await fetch(address("/frames"))).arrayBuffer();
  const frames = [];
  for (let at = 0; at < buffer.byteLength;) {
    const frame = decodeFrame(buffer, at);
    frames.push(frame);
    at = frame.end;
  }
  on.recording(frames);
}

// Returns the server's reason for a refusal; empty if it accepts or is not reachable.
async function refusal() {
  const answer = await fetch(address("/scene")).catch(() => null);
  return answer && !answer.ok ? (await answer.text()).trim() : "";
}

// Connects, and reconnects after a loss. on: { scene(json), frame(frame), lost(why), ended(),
// recording(frames) }.
// Returns send(buffer, always); without always a message is left out while others wait.
export function connect(on) {
  let socket = null;
  const open = () => {
    let scene = null;
    socket = new WebSocket(new URL(address("/stream"), location.href.replace(/^http/, "ws")), ["godobject.view.v1"]);
    socket.binaryType = "arraybuffer";
    socket.onmessage = ({ data }) => {
      if (typeof data !== "string") return on.frame(decodeFrame(data));
      scene = JSON.parse(data);
      on.scene(scene);
      if (scene.live) return;
      socket.close();
      recording(on);
    };
    socket.onclose = async ({ reason }) => {
      if (scene && !scene.live) return;
      if (scene && reason === RUN_ENDED) on.ended();
      const refused = scene ? "" : await refusal();
      if (!scene || reason !== RUN_ENDED) on.lost(refused || `${reason || "the connection to the run is lost"}: trying again`);
      if (!refused) setTimeout(open, RETRY_MS);
    };
  };
  open();
  return (buffer, always = false) => {
    if (socket?.readyState === WebSocket.OPEN && (always || socket.bufferedAmount === 0)) socket.send(buffer);
  };
}
