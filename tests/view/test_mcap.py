#!/usr/bin/env python3
"""npm's @mcap/core reads exported files by their index and as a stream, and checks every CRC. Skipped without
node or the library.

usage: test_mcap.py --program PATH
"""
import json
import os
import shutil
import subprocess
import tempfile

from viewed_run import SOURCE, arguments, skip

ARGS = arguments()
MODULES = os.path.join(SOURCE, ".cache", "view", "node_modules")
READER = """
const { McapIndexedReader, McapStreamReader } = require("@mcap/core");
const bytes = new Uint8Array(require("fs").readFileSync(process.argv[1]));
const readable = { size: async () => BigInt(bytes.length), read: async (at, size) => bytes.slice(Number(at), Number(at + size)) };
const json = (data) => JSON.parse(new TextDecoder().decode(data));
const count = (counts, topic) => { counts[topic] = (counts[topic] ?? 0) + 1; };
(async () => {
  const seen = { indexed: {}, streamed: {}, schemas: {}, last: {}, times: [] };
  const reader = await McapIndexedReader.Initialize({ readable });
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    const { topic, schemaId } = reader.channelsById.get(message.channelId), schema = reader.schemasById.get(schemaId);
    count(seen.indexed, topic);
    seen.schemas[topic] = [schema.name, json(schema.data).type];
    seen.last[topic] = json(message.data);
    if (topic === "/tool") seen.times.push(Number(message.logTime));
  }
  const stream = new McapStreamReader({ validateCrcs: true }), topics = new Map();
  stream.append(bytes);
  for (let record; (record = stream.nextRecord()) != null;) {
    if (record.type === "Channel") topics.set(record.id, record.topic);
    if (record.type === "Message") count(seen.streamed, topics.get(record.channelId));
  }
  seen.done = stream.done();
  seen.messages = Number(reader.statistics.messageCount);
  console.log(JSON.stringify(seen));
})().catch((error) => { console.error(error); process.exit(1); });
"""


def read(path):
    result = subprocess.run(["node", "-e", READER, path], env=dict(os.environ, NODE_PATH=MODULES), capture_output=True,
                            text=True, timeout=60, check=False)
    return result.returncode, result.stdout + result.stderr


def main():
    if not shutil.which("node"):
        skip("no node")
    if not os.path.isdir(os.path.join(MODULES, "@mcap", "core")):
        skip("no @mcap/core: ./dev setup view")
    with tempfile.TemporaryDirectory() as folder:
        path = lambda name: os.path.join(folder, name)
        call = lambda *words: subprocess.run([ARGS.program, *words], cwd=SOURCE, check=True, timeout=60, capture_output=True)
        call("run", "sim/scenes/rigid.toml", "--duration", "1", "--quiet", "--trace", path("run.csv"), "--record", path("bus.log"))
        call("export", path("run.csv"), "--mcap", path("run.mcap"))
        call("export", path("bus.log"), "--mcap", path("bus.mcap"))
        with open(path("run.csv"), encoding="utf-8") as file:
            names, *rows = [line.strip().split(",") for line in file]
        code, text = read(path("run.mcap"))
        assert code == 0, text
        seen = json.loads(text)
        assert seen["done"] and seen["indexed"] == seen["streamed"], seen
        assert seen["messages"] == sum(seen["indexed"].values())
        assert set(seen["indexed"].values()) == {len(rows)}, seen["indexed"]
        assert seen["schemas"]["/tf"] == ["foxglove.FrameTransforms", "object"], seen["schemas"]
        last = dict(zip(names, map(float, rows[-1])))
        assert seen["last"]["/tool"]["x"] == last["tool.x"]
        assert seen["last"]["/tf"]["transforms"][0]["translation"]["z"] == last["tool.z"]
        assert [round(1e9 * float(row[names.index("t_bus")])) for row in rows] == seen["times"]
        code, text = read(path("bus.mcap"))
        assert code == 0, text
        with open(path("bus.log"), encoding="utf-8") as file:
            frames = [line.split()[1] for line in file]
        assert json.loads(text)["indexed"] == {"/" + bus: frames.count(bus) for bus in set(frames)}, text
        # The reader does find damage.
        with open(path("run.mcap"), "r+b") as file:
            file.seek(os.path.getsize(path("run.mcap")) // 2)
            byte = file.read(1)
            file.seek(-1, os.SEEK_CUR)
            file.write(bytes([byte[0] ^ 1]))
        code, text = read(path("run.mcap"))
        assert code != 0 and "crc" in text.lower(), text
    print("run and log are read by @mcap/core")


if __name__ == "__main__":
    main()
