// Text of a CAN frame, by CANopen or by the protocol of the scene's drives on the bus.
#pragma once

#include <array>
#include <string>

#include "hal/drive/link.h"
#include "hal/rig/params.h"

namespace godobject {

struct MessageText {
  std::string name;   // "TPDO1 of base encoder"; empty: not a message of the bus's protocol
  std::string value;  // "0.1234 rad"; empty: not decoded
};

class MessageDecoder {
 public:
  /// Decodes CANopen (CiA 301), without names of nodes.
  MessageDecoder() = default;
  /// Decodes the messages of bus `bus` of the rig with the names of its nodes. The rig must outlive the
  /// decoder.
  MessageDecoder(const RigParams& rig, std::size_t bus);

  /// Decodes any frame.
  MessageText decode(const CanFrame& frame) const;

 private:
  struct Node {
    const EncoderParams* encoder = nullptr;
    const DriveParams* drive = nullptr;
    const ButtonParams* button = nullptr;
  };

  std::string node_name(std::uint8_t id) const;
  MessageText decode_drive_protocol(const CanFrame& frame) const;
  MessageText decode_node_message(const CanFrame& frame, std::uint8_t node) const;
  std::string decode_tpdo(const CanFrame& frame, int number, std::uint8_t id) const;
  std::string decode_drive(const CanFrame& frame, int number, const DriveParams& drive) const;
  std::string coordinate(std::int64_t counts, const Calibration& calibration, const std::string& joint) const;

  const RigParams* rig_ = nullptr;
  std::array<Node, canopen::max_node_id + 1> nodes_{};
  std::uint8_t host_ = 0;                             // node id; 0: unknown
  DriveText (*describe_)(const CanFrame&) = nullptr;  // protocol of the bus's drives; null: CANopen
};

}  // namespace godobject
