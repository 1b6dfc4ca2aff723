#!/usr/bin/env python3
"""The official npm client of foxglove.websocket.v1 connects, subscribes and receives the poses. Skipped
without node or the client.

usage: test_foxglove.py --program PATH
"""
import json
import os
import shutil
import subprocess

from viewed_run import SOURCE, Stream, ViewedRun, arguments, skip

ARGS = arguments()
MODULES = os.path.join(SOURCE, ".cache", "view", "node_modules")
CLIENT = """
const { FoxgloveClient } = require("@foxglove/ws-protocol");
const Socket = globalThis.WebSocket;
const client = new FoxgloveClient({ ws: new Socket(process.argv[1], [FoxgloveClient.SUPPORTED_SUBPROTOCOL]) });
const topics = new Map(), seen = { frames: 0, updates: [] };
// The run is done when this many updates came and, where a distance in m is given, a net is so far from its first place along an axis.
const wanted = Number(process.argv[2]), distance = Number(process.argv[3] ?? 0);
const points = (entities) => entities.filter((entity) => entity.id.startsWith("net ")).flatMap((net) => net.triangles[0].points);
const moved = (first, last) => points(last).some((p, i) => ["x", "y", "z"].some((axis) => Math.abs(p[axis] - points(first)[i][axis]) > distance));
const enough = () => seen.updates.length >= wanted && seen.frames >= 20 && (distance === 0 || moved(seen.updates[0], seen.updates.at(-1)));
client.on("serverInfo", (info) => { seen.server = info.name; });
client.on("error", (error) => { console.error(String(error?.message ?? error)); process.exit(1); });
client.on("advertise", (channels) => { for (const channel of channels) { JSON.parse(channel.schema); topics.set(client.subscribe(channel.id), channel); } });
client.on("message", ({ subscriptionId, data }) => {
  const { topic, schemaName } = topics.get(subscriptionId), message = JSON.parse(new TextDecoder().decode(data));
  if (schemaName === "foxglove.SceneUpdate") seen.updates.push(message.entities);
  else { seen.frames++; seen.transforms = message.transforms; }
  if (seen.done || !enough()) return;
  seen.done = true;
  process.stdout.write(JSON.stringify(seen), () => process.exit(0));
});
setTimeout(() => { console.error("not enough came: " + JSON.stringify(seen)); process.exit(1); }, 20000);
"""


def main():
    node = shutil.which("node")
    if not node:
        skip("no node")
    if not os.path.isdir(os.path.join(MODULES, "@foxglove", "ws-protocol")):
        skip("no @foxglove/ws-protocol: ./dev setup view")
    if subprocess.run([node, "-e", "process.exit(globalThis.WebSocket ? 0 : 1)"], check=False).returncode != 0:
        node_options = ["--experimental-websocket"]
        if subprocess.run([node, *node_options, "-e", "process.exit(globalThis.WebSocket ? 0 : 1)"], check=False, capture_output=True).returncode != 0:
            skip("this node has no WebSocket of its own")
    else:
        node_options = []
    with ViewedRun(ARGS.program, "run", "sim/scenes/wall.toml", "--view", "--duration", "120") as run:
        address = f"ws://{run.host}:{run.port}/stream"
        environment = dict(os.environ, NODE_PATH=MODULES)
        call = lambda url, *wanted: subprocess.run([node, *node_options, "-e", CLIENT, url, *map(str, wanted or (1,))], env=environment,
                                                   capture_output=True, text=True, timeout=60, check=False)
        result = call(f"{address}?token={run.token}")
        assert result.returncode == 0, result.stderr
        seen = json.loads(result.stdout)
        assert seen["server"] == "godobject"
        frames = {t["child_frame_id"]: t for t in seen["transforms"]}
        assert set(frames) == {"peg", "peg/device"} and all(t["parent_frame_id"] == "world" for t in frames.values()), frames
        entities = {entity["id"].split(" ", 1)[1]: entity for entity in seen["updates"][0]}
        assert entities["peg"]["frame_id"] == "peg" and entities["peg"]["cubes"][0]["size"] == {"x": 0.03, "y": 0.03, "z": 0.08}
        assert entities["wall"]["frame_id"] == "world" and entities["post"]["cylinders"], entities["post"]
        assert call(address).returncode != 0, "not without the token"

        stream = Stream(run, Sec_WebSocket_Protocol="foxglove.websocket.v1", Origin="https://elsewhere.example")
        assert stream.status == 101
        assert [json.loads(stream.message()[1])["op"] for _ in range(2)] == ["serverInfo", "advertise"]
        for nonsense in (b"x", b"[]", b'{"op":1}', b'{"op":"subscribe","subscriptions":[{"id":1,"channelId":9}]}', b'{"op":"subscribe","subscriptions":[7]}'):
            stream.send(nonsense, 1)
            assert json.loads(stream.message()[1])["op"] == "status", nonsense
        stream.close()

    # under a sanitizer a step of 25 nodes takes most of a millisecond, and a run that misses too many periods
    # is held; the second scene has joints, whose values are after the nodes
    for scene in ("net-small", "flexible-tip"):
        with ViewedRun(ARGS.program, "run", f"sim/scenes/{scene}.toml", "--bus", "direct", "--view", "--duration", "120", "--step", "0.01") as run:
            result = call(f"ws://{run.host}:{run.port}/stream?token={run.token}", 12, 1e-3)
            assert result.returncode == 0, result.stderr[-2000:]
            about = run.stream().scene()
            surface = about["surfaces"][0]
            name = "net " + surface["name"]
            first, *_, last = json.loads(result.stdout)["updates"]
            assert len(first) > 1 and [entity["id"] for entity in last] == [name], "solids once, nets again and again"
            nets = [next(entity for entity in update if entity["id"] == name) for update in (first, last)]
            places = []
            for net in nets:
                mesh, = net["triangles"]
                assert net["frame_id"] == "world" and mesh["indices"] == surface["triangles"] and len(mesh["points"]) == surface["num_vertices"]
                places.append([[point[axis] for axis in "xyz"] for point in mesh["points"]])
            low, high = surface["bounds"]
            assert all(a - 0.1 < x < b + 0.1 for place in places[0] + places[1] for x, a, b in zip(place, low, high)), "where the scene has it"


main()
