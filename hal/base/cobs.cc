#include "hal/base/cobs.h"

namespace godobject {

std::optional<std::size_t> cobs_encode(std::span<const std::uint8_t> payload,
                                       std::span<std::uint8_t> out) noexcept {
  if (out.size() < cobs_size(payload.size())) return std::nullopt;
  std::size_t code = 0, size = 1;
  out[code] = 1;
  for (std::size_t i = 0; i < payload.size(); ++i) {
    if (payload[i] != 0) {
      out[size++] = payload[i];
      ++out[code];
    }
    const bool full = out[code] == 0xFF && i + 1 < payload.size();
    if (payload[i] == 0 || full) {
      code = size++;
      out[code] = 1;
    }
  }
  out[size++] = 0;
  return size;
}

CobsDecoder::Result CobsDecoder::push(std::uint8_t byte) noexcept {
  if (complete_) {
    complete_ = false;
    size_ = 0;
  }
  if (byte == 0) return finish();
  if (left_ == 0) {
    // The byte is a code byte, so the previous block was not the last of the frame.
    if (zero_pending_ && !store(0)) overflow_ = true;
    left_ = static_cast<std::uint8_t>(byte - 1);
    zero_pending_ = byte != 0xFF;
    started_ = true;
    return Result::more;
  }
  --left_;
  if (!store(byte)) overflow_ = true;
  return Result::more;
}

CobsDecoder::Result CobsDecoder::finish() noexcept {
  Result result = Result::more;
  if (started_) result = overflow_ ? Result::too_large : left_ > 0 ? Result::cut_off : Result::frame;
  if (result == Result::frame) complete_ = true;
  if (!complete_) size_ = 0;
  left_ = 0;
  zero_pending_ = started_ = overflow_ = false;
  return result;
}

bool CobsDecoder::store(std::uint8_t byte) noexcept {
  if (size_ == payload_.size()) return false;
  payload_[size_++] = byte;
  return true;
}

}  // namespace godobject
