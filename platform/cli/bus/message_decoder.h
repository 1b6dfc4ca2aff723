// What a CAN frame says, in words: by the rules of CANopen, or of the drives that the scene has on the bus.
#pragma once

#include <array>
#include <string>

#include "hal/drive/link.h"

namespace godobject {

struct MessageText {
  std::string name;   // "TPDO1 of base encoder"; empty: not a message of the bus's protocol
  std::string value;  // "0.1234 rad"; empty: nothing is known of the data
};

class MessageDecoder {
 public:
  /// Knows CANopen (CiA 301) and nothing of the nodes.
  MessageDecoder() = default;
  /// Knows the nodes of bus `bus` of the rig, too. The rig must outlive it.
  MessageDecoder(const RigParams& rig, std::size_t bus);

  /// Any frame.
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
  std::uint8_t host_ = 0;                             // node id; 0: not known
  DriveText (*describe_)(const CanFrame&) = nullptr;  // of the bus's drives; null: CANopen
};

}  // namespace godobject
