// SDO server of a simulated node (CiA 301 7.2.4.3): expedited and segmented transfers, one client, no block
// transfer.
#pragma once

#include <optional>

#include "sim/node/canopen/object_dictionary.h"

namespace godobject {

class SdoServer {
 public:
  static constexpr std::size_t capacity = 256;  // bytes per transfer

  explicit SdoServer(ObjectDictionary& objects) noexcept : objects_(objects) {}

  /// Returns the answer to a client's message; none to an abort.
  std::optional<sdo::Message> answer(const sdo::Message& request) noexcept;
  /// Drops a running transfer.
  void reset() noexcept { transfer_ = Transfer::none; }

 private:
  enum class Transfer : std::uint8_t { none, download, upload };

  sdo::Message initiate_download(const sdo::Message& request) noexcept;
  sdo::Message download_segment(const sdo::Message& request) noexcept;
  sdo::Message initiate_upload() noexcept;
  sdo::Message upload_segment(const sdo::Message& request) noexcept;
  sdo::Message abort(sdo::AbortCode code) noexcept;

  ObjectDictionary& objects_;
  Transfer transfer_ = Transfer::none;
  sdo::ObjectAddress address_;
  std::array<std::uint8_t, capacity> data_{};
  std::size_t size_ = 0, position_ = 0;
  sdo::Initiation announced_;
  bool toggle_ = false;
};

}  // namespace godobject
