// A CAN adapter on USB for the kernel's esd_usb driver. dummy_hcd is the cable, the kernel's gadget side
// (configfs, FunctionFS) the device's USB controller, and this class its firmware. Unlike slcan that driver
// supports restart.
// Messages: linux drivers/net/can/usb/esd_usb.c.
#pragma once

#include <fcntl.h>
#include <linux/usb/ch9.h>
#include <linux/usb/functionfs.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <thread>

#include "tests/socketcan/can_test.h"

namespace godobject::test {

/// Needs the modules dummy_hcd, libcomposite, usb_f_fs, esd_usb, and root.
class UsbCanAdapter {
 public:
  enum class State : std::uint8_t { active = 0x00, warning = 0x40, passive = 0x80, bus_off = 0xC0 };

  static bool possible() { return std::system("modprobe -qa dummy_hcd libcomposite usb_f_fs esd_usb") == 0; }

  /// Plugs it in.
  UsbCanAdapter() {
    run("modprobe configfs && (mountpoint -q /sys/kernel/config || mount -t configfs none "
        "/sys/kernel/config)");
    run("mkdir -p " + gadget + "/strings/0x409 " + gadget + "/configs/c.1 " + gadget + "/functions/ffs.can " +
        folder);
    run("cd " + gadget +
        " && echo 0x0ab4 > idVendor && echo 0x0010 > idProduct && ln -s functions/ffs.can configs/c.1" +
        " && mount -t functionfs can " + folder);
    control_ = open_file("ep0");
    describe();
    from_driver_ = open_file("ep2");
    to_driver_ = open_file("ep1");
    firmware_ = std::thread([this] { serve(); });
    run("echo dummy_udc.0 > " + gadget + "/UDC");
  }
  ~UsbCanAdapter() {
    run("echo > " + gadget + "/UDC");
    firmware_.join();
    for (const int file : {from_driver_, to_driver_, control_}) close(file);
    run("umount " + folder + " && cd " + gadget +
        " && rm configs/c.1/ffs.can && rmdir configs/c.1 functions/ffs.can" +
        " strings/0x409 && cd / && rmdir " + gadget);
  }
  UsbCanAdapter(const UsbCanAdapter&) = delete;
  UsbCanAdapter& operator=(const UsbCanAdapter&) = delete;

  /// Returns the name of the network interface; empty if the driver has made none within 20 s.
  std::string interface() const {
    namespace fs = std::filesystem;
    for (int waited_ms = 0; waited_ms < 20'000; waited_ms += 10, pause_ms(10)) {
      std::error_code none;
      for (const fs::directory_entry& device : fs::directory_iterator("/sys/bus/usb/drivers/esd_usb", none))
        for (const fs::directory_entry& net : fs::directory_iterator(device.path() / "net", none))
          return net.path().filename();
    }
    return {};
  }
  void report(State state, std::uint8_t receive_errors = 0, std::uint8_t transmit_errors = 0) {
    constexpr std::uint32_t event = 0x4000'0000, error_extended = 2;
    std::array<std::uint32_t, 5> message{header(5, can_receive, 8), 0, event | error_extended};
    const std::array<std::uint8_t, 4> data{static_cast<std::uint8_t>(state), 0, receive_errors,
                                           transmit_errors};
    std::memcpy(&message[3], data.data(), data.size());
    send(message.data(), sizeof message);
  }

 private:
  inline static const std::string gadget = "/sys/kernel/config/usb_gadget/can", folder = "/run/usb_can";
  enum Command : std::uint8_t { version = 1, can_receive = 2, can_transmit = 3 };

  /// words: length of the whole message in words of 32 bits. last: fourth byte, with a meaning by command.
  static std::uint32_t header(std::uint8_t words, Command command, std::uint8_t last = 0) {
    return words | std::uint32_t{command} << 8 | std::uint32_t{last} << 24;
  }
  static int open_file(const std::string& name) {
    const int file = ::open((folder + "/" + name).c_str(), O_RDWR);
    EXPECT_GE(file, 0) << name << ": " << std::strerror(errno);
    return file;
  }

  /// Describes one interface with bulk endpoints 1 in and 2 out, at full and at high speed.
  void describe() const {
    struct [[gnu::packed]] Endpoints {
      usb_interface_descriptor interface;
      usb_endpoint_descriptor_no_audio in, out;
    };
    const auto endpoints = [](std::uint16_t packet) {
      const auto bulk = [packet](std::uint8_t address) {
        return usb_endpoint_descriptor_no_audio{USB_DT_ENDPOINT_SIZE,   USB_DT_ENDPOINT, address,
                                                USB_ENDPOINT_XFER_BULK, packet,          0};
      };
      return Endpoints{{USB_DT_INTERFACE_SIZE, USB_DT_INTERFACE, 0, 0, 2, USB_CLASS_VENDOR_SPEC, 0, 0, 1},
                       bulk(USB_DIR_IN | 1),
                       bulk(USB_DIR_OUT | 2)};
    };
    const struct [[gnu::packed]] {
      usb_functionfs_descs_head_v2 head;
      std::uint32_t full_count = 3, high_count = 3;
      Endpoints full, high;
    } descriptors{{FUNCTIONFS_DESCRIPTORS_MAGIC_V2, sizeof descriptors,
                   FUNCTIONFS_HAS_FS_DESC | FUNCTIONFS_HAS_HS_DESC},
                  3,
                  3,
                  endpoints(64),
                  endpoints(512)};
    const struct [[gnu::packed]] {
      usb_functionfs_strings_head head;
      std::uint16_t language = 0x409;
      char name[4] = "can";
    } strings{{FUNCTIONFS_STRINGS_MAGIC, sizeof strings, 1, 1}};
    EXPECT_EQ(write(control_, &descriptors, sizeof descriptors), ssize_t{sizeof descriptors});
    EXPECT_EQ(write(control_, &strings, sizeof strings), ssize_t{sizeof strings});
  }

  /// Serves until the plug is pulled. Accepts bit rate and filters, and sends every frame at once.
  void serve() {
    std::array<std::uint32_t, 128> message{};
    while (read(from_driver_, message.data(), sizeof message) > 0) {
      const auto command = static_cast<std::uint8_t>(message[0] >> 8);
      if (command == version) {
        constexpr std::uint8_t words = 9, nets = 1;
        const std::array<std::uint32_t, words> reply{header(words, version) | nets << 16, 0x0001'0000};
        send(reply.data(), sizeof reply);
      } else if (command == can_transmit) {
        const std::array<std::uint32_t, 3> done{header(3, can_transmit), message[1]};
        send(done.data(), sizeof done);
      }
    }
  }
  void send(const void* message, std::size_t size) {
    const std::lock_guard lock(mutex_);
    EXPECT_EQ(write(to_driver_, message, size), static_cast<ssize_t>(size)) << std::strerror(errno);
  }

  int control_ = -1, from_driver_ = -1, to_driver_ = -1;
  std::mutex mutex_;
  std::thread firmware_;
};

}  // namespace godobject::test
