#include "sim/fault/verb.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

namespace godobject::test_fault_verb {
namespace {

TEST(FaultVerb, TableIsInTheOrderOfTheEnum) {
  for (std::size_t i = 0; i < num_fault_verbs; ++i) {
    const FaultVerbText& text = fault_verb_texts()[i];
    EXPECT_EQ(text.verb, static_cast<FaultVerb>(i));
    EXPECT_EQ(&text_of(text.verb), &text);
    EXPECT_EQ(fault_verb_named(text.name), text.verb);
  }
  EXPECT_FALSE(fault_verb_named("dorp"));
}

TEST(FaultVerb, DefaultIsAdmissibleAndNotTheZeroThatStandsForIt) {
  for (const FaultVerbText& text : fault_verb_texts()) {
    if (text.value.empty()) continue;
    EXPECT_NE(text.default_value, 0) << text.name;
    EXPECT_GE(text.default_value, text.min) << text.name;
    EXPECT_LE(text.default_value, text.max) << text.name;
  }
}

TEST(FaultVerb, DocumentHoldsTheGeneratedTable) {
  std::ifstream file(GODOBJECT_SOURCE_DIR "/docs/faults.md");
  std::ostringstream text;
  text << file.rdbuf();
  const std::string expected =
      "<!-- fault verbs: begin -->\n\n" + fault_reference_markdown() + "\n<!-- fault verbs: end -->";
  EXPECT_THAT(text.str(), testing::HasSubstr(expected))
      << "paste the table of fault_reference_markdown() between the markers";
}

}  // namespace
}  // namespace godobject::test_fault_verb
