// Vocabulary of scenes for the folders of their parts: None in place of a missing part, its empty members,
// and the optional parts by name. core/scene.h has the rules, parameters and state of a scene.
#pragma once

#include <cstddef>
#include <type_traits>

#include "core/math/types.h"

namespace godobject {

// Parameters and state of a scene, defined in core/scene.h.
template <class S>
struct Params;
template <class S>
struct State;

struct Empty {};

/// Part that a scene does not have.
struct None {
  using Params = Empty;
  using State = Empty;
  template <class>
  using StateOf = Empty;
  using Input = Empty;
  using Output = Empty;
  using BodyOutput = Empty;
  static constexpr std::size_t max_contacts = 0;
  static constexpr bool between_bodies = false;
};

/// Empty member of a part that a scene does not have. The type differs per slot, because two empty members of
/// one type need two addresses, and so storage.
template <int slot>
struct Absent {};
template <int slot>
constexpr Real sum(const Absent<slot>&) noexcept {
  return 0;
}
template <class T, int slot>
using Slot = std::conditional_t<std::is_empty_v<T>, Absent<slot>, T>;

template <class Part>
inline constexpr bool uses = !std::is_same_v<Part, None>;

/// Part that a scene lists under this name; None if it lists none.
template <class S, template <class> class Named>
struct ListedPart {
  using type = None;
};
template <class S, template <class> class Named>
requires requires { typename Named<S>; }
struct ListedPart<S, Named> {
  using type = Named<S>;
};

template <class S>
using NamedContacts = typename S::Contacts;
template <class S>
using ContactsOf = typename ListedPart<S, NamedContacts>::type;
template <class S>
using NamedTerms = typename S::Terms;
template <class S>
using TermsOf = typename ListedPart<S, NamedTerms>::type;
template <class S>
using NamedNet = typename S::Net;
template <class S>
using NetOf = typename ListedPart<S, NamedNet>::type;

}  // namespace godobject
