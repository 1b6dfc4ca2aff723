#include "hal/canopen/pdo_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace godobject::test_pdo_map {
namespace {

using canopen::ObjectAddress;

PdoProfile status_pdo() {
  PdoProfile pdo{.direction = PdoDirection::transmit, .number = 1, .transmission = {.value = 1, .line = 31}};
  for (const char* name : {"statusword", "position", "torque"}) {
    MappedObject object = parse_mapped_object(name).value();
    object.line = 32;
    pdo.map.push_back(object);
  }
  pdo.line = 30;
  return pdo;
}

std::vector<SdoStep> steps_of(const PdoProfile& pdo) {
  std::vector<SdoStep> steps;
  append_map_steps(pdo, 4, pdo.transmission.value, steps);
  return steps;
}

TEST(PdoMap, SixStepsInTheirOrderThenReadBack) {
  const std::vector<SdoStep> steps = steps_of(status_pdo());
  struct Expected {
    SdoAction action;
    ObjectAddress address;
    std::int64_t value;
  };
  const std::vector<Expected> expected{
      {SdoAction::switch_off, {0x1800, 1}, 0},     {SdoAction::write, {0x1A00, 0}, 0},
      {SdoAction::write, {0x1A00, 1}, 0x60410010}, {SdoAction::write, {0x1A00, 2}, 0x60640020},
      {SdoAction::write, {0x1A00, 3}, 0x60770010}, {SdoAction::write, {0x1A00, 0}, 3},
      {SdoAction::write, {0x1800, 2}, 1},          {SdoAction::switch_on, {0x1800, 1}, 0x184},
      {SdoAction::check, {0x1A00, 1}, 0x60410010}, {SdoAction::check, {0x1A00, 2}, 0x60640020},
      {SdoAction::check, {0x1A00, 3}, 0x60770010}, {SdoAction::check, {0x1A00, 0}, 3},
      {SdoAction::check, {0x1800, 2}, 1},          {SdoAction::check, {0x1800, 1}, 0x184},
  };
  ASSERT_EQ(steps.size(), expected.size());
  for (std::size_t i = 0; i < steps.size(); ++i) {
    EXPECT_EQ(steps[i].action, expected[i].action) << i;
    EXPECT_EQ(steps[i].address, expected[i].address) << i;
    EXPECT_EQ(steps[i].low, expected[i].value) << i;
    EXPECT_NE(steps[i].line, 0u) << i << ": the profile's line goes with it";
  }
}

TEST(PdoMap, TimesAreWrittenWhileThePdoIsOff) {
  PdoProfile pdo = status_pdo();
  pdo.inhibit_100us = {.value = 5, .line = 33};
  pdo.timer_ms = {.value = 20, .line = 34};
  const std::vector<SdoStep> steps = steps_of(pdo);
  const auto at = [&](SdoAction action, ObjectAddress address) {
    const auto found = std::ranges::find_if(
        steps, [&](const SdoStep& s) { return s.action == action && s.address == address; });
    return found - steps.begin();
  };
  const auto on = at(SdoAction::switch_on, {0x1800, 1});
  EXPECT_LT(at(SdoAction::write, {0x1800, 3}), on);
  EXPECT_LT(at(SdoAction::write, {0x1800, 5}), on);
  EXPECT_GT(at(SdoAction::check, {0x1800, 5}), on);
  EXPECT_EQ(steps[static_cast<std::size_t>(at(SdoAction::write, {0x1800, 5}))].line, 34u);
}

TEST(PdoMap, ReceivePdosHaveTheirOwnRecordsAndIdentifiers) {
  PdoProfile pdo{.direction = PdoDirection::receive, .number = 2, .transmission = {.value = 1, .line = 1}};
  pdo.map = {parse_mapped_object("controlword").value()};
  std::vector<SdoStep> steps;
  append_map_steps(pdo, 4, 1, steps);
  EXPECT_EQ(steps[0].address, (ObjectAddress{0x1401, 1}));
  EXPECT_EQ(steps[1].address, (ObjectAddress{0x1601, 0}));
  EXPECT_EQ(steps.back().low, 0x304);
}

TEST(PdoMap, TransmitPdosThatAreNotMappedAreSwitchedOff) {
  std::vector<SdoStep> steps;
  append_switch_off_steps({status_pdo()}, steps);
  ASSERT_EQ(steps.size(), 3u);
  EXPECT_EQ(steps[0].address, (ObjectAddress{0x1801, 1}));
  EXPECT_EQ(steps[2].address, (ObjectAddress{0x1803, 1}));
  EXPECT_EQ(steps[2].action, SdoAction::switch_off_if_there);
}

TEST(PdoMap, ObjectsByNameAndByNumber) {
  const auto by_name = parse_mapped_object("encoder_speed");
  ASSERT_TRUE(by_name);
  EXPECT_EQ(mapping_entry(*by_name), 0x60300110u);
  const auto by_number = parse_mapped_object("2030h:0A:32");
  ASSERT_TRUE(by_number);
  EXPECT_EQ(mapping_entry(*by_number), 0x20300A20u);
  for (const char* wrong : {"", "torq", "2030:0A:32", "2030h:0A", "2030h:0A:7", "2030h:0A:32 ", "10000h:0:8",
                            "2030h:100:8", "h:0:8", "2030h::8", "-1h:0:8"})
    EXPECT_FALSE(parse_mapped_object(wrong)) << wrong;
}

TEST(PdoMap, WhatAPdoCannotCarryIsAnError) {
  PdoProfile pdo = status_pdo();
  EXPECT_EQ(map_error(pdo), "");
  pdo.map.push_back(parse_mapped_object("mode").value());
  EXPECT_THAT(map_error(pdo), testing::HasSubstr("72 bits"));
  pdo.map.clear();
  EXPECT_THAT(map_error(pdo), testing::HasSubstr("maps no object"));
  pdo.map.assign(9, parse_mapped_object("mode").value());
  EXPECT_THAT(map_error(pdo), testing::HasSubstr("9 objects"));
}

}  // namespace
}  // namespace godobject::test_pdo_map
