// Input logs, as they are and with checksums that are right: each is refused with a reason, or read to an
// end.
#include <cstdlib>
#include <string>

#include "hal/base/crc32.h"
#include "platform/trace/input_log.h"
#include "tests/fuzz/decode.h"

namespace {

using namespace godobject;

void read(std::string_view file) {
  InputLogReader reader(file);
  if (!reader.why_not().empty()) return;
  for (const std::uint64_t from : {std::uint64_t{0}, std::uint64_t{3}}) {
    static_cast<void>(reader.continue_at(from));
    for (InputLogReader::Item item{};
         item != InputLogReader::Item::end && item != InputLogReader::Item::cut;) {
      item = reader.next();
      if (item == InputLogReader::Item::state && reader.state().bytes.size() != reader.head().snapshot_bytes)
        std::abort();
      if (item == InputLogReader::Item::row && reader.row().samples.size() != reader.head().sizes.bodies)
        std::abort();
    }
  }
}

void put(std::string& out, std::uint32_t number) {
  for (int shift = 0; shift < 32; shift += 8) out += static_cast<char>(number >> shift & 0xff);
}

/// Appends a chunk with these contents and its checksum, behind the marker.
void put_chunk(std::string& out, std::string_view marker, std::uint32_t kind, std::string_view payload) {
  out += marker;
  const std::size_t begin = out.size();
  put(out, kind);
  put(out, static_cast<std::uint32_t>(payload.size()));
  out += payload;
  put(out, crc32(std::string_view(out).substr(begin)));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  read(std::string_view(reinterpret_cast<const char*>(data), size));

  fuzz::Input in(data, size);
  std::string file;
  const CycleRecord start = record_of(
      {.bodies = in.byte() % 3u, .targets = in.byte() % 3u, .device_q = 1, .drives = 1, .joint_q = 1});
  InputLogHead head;
  head.snapshot_bytes = 8u * (in.byte() % 9u);
  InputLogWriter writer(head, start, [&](const InputLogWriter::Chunk& chunk) { file += chunk.bytes; });
  if (in.byte() % 8 == 0) file.resize(8);  // the magic alone: the head is from the input, too
  while (!in.empty()) {
    const std::uint32_t kind = in.byte() % (static_cast<std::uint32_t>(InputLogKind::links) + 1);
    const auto payload = in.bytes(in.byte());
    put_chunk(file, "CHNK", kind, {reinterpret_cast<const char*>(payload.data()), payload.size()});
  }
  read(file);
  return 0;
}
