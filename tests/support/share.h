// Selects the cases of a sweep: all of them, or every k-th if GODOBJECT_SHARE is k in the environment.
#pragma once

#include <cstdlib>

namespace godobject::test {

class Share {
 public:
  /// Returns true for the first call and every k-th after it. Called once a case, after its random numbers.
  bool takes() { return count_++ % share_ == 0; }
  bool is_all() const { return share_ == 1; }

 private:
  static unsigned long share() {
    const char* const text = std::getenv("GODOBJECT_SHARE");
    const unsigned long value = text ? std::strtoul(text, nullptr, 10) : 1;
    return value > 0 ? value : 1;
  }

  unsigned long share_ = share(), count_ = 0;
};

}  // namespace godobject::test
