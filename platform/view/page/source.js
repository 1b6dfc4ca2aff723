// Where frames come from: the stream of a run, or a recording as a whole.
import { decodeFrame } from "./wire.js";

const RETRY_MS = 400;
const token = new URLSearchParams(location.search).get("token") ?? "";
const address = (path) => `${path}?token=${encodeURIComponent(token)}`;

// on: { scene(json), frame(frame), lost(why) }. Comes back by itself. Returns send(buffer).
function stream(on) {
  let socket = null;
  const open = () => {
    socket = new WebSocket(new URL(address("/stream"), location.href.replace(/^http/, "ws")), ["godobject.view.v1"]);
    socket.binaryType = "arraybuffer";
    socket.onmessage = ({ data }) => {
      if (typeof data === "string") on.scene(JSON.parse(data));
      else on.frame(decodeFrame(data));
    };
    socket.onclose = ({ reason }) => {
      on.lost(reason || "the connection to the run is lost");
      setTimeout(open, RETRY_MS);
    };
  };
  open();
  return (buffer) => { if (socket?.readyState === WebSocket.OPEN && socket.bufferedAmount === 0) socket.send(buffer); };
}

async function recording(scene, on) {
  const buffer = await (await fetch(address("/frames"))).arrayBuffer();
  const frames = [];
  for (let at = 0; at < buffer.byteLength;) {
    const frame = decodeFrame(buffer, at);
    frames.push(frame);
    at = frame.end;
  }
  on.recording(frames);
}

export async function connect(on) {
  const answer = await fetch(address("/scene")).catch(() => null);
  if (answer && !answer.ok) {
    on.lost((await answer.text()).trim());
    return () => {};
  }
  const scene = answer && await answer.json();
  if (!scene || scene.live) return stream(on);
  on.scene(scene);
  await recording(scene, on);
  return () => {};
}
