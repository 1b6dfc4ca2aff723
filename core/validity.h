// Rule that a parameter set breaks, the body or other element that breaks it, and both as text.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace godobject {

/// First rule that a parameter set breaks.
enum class Invalid : std::uint8_t {
  nothing,
  step_not_positive,
  gravity,          // not finite
  too_many_bodies,  // more than the scene's max_bodies, or none
  mass_not_positive,
  inertia_not_positive,  // not symmetric, or an eigenvalue not above zero
  anisotropy_too_small,  // below sqrt(I_max / I_min): make the parameters with rigid_body()
  gain_negative,         // a stiffness, damping, limit or ramp below zero or not finite
  parent_not_before,     // a joint's parent is not a body before its child
  joint_frame,           // a joint's frame is not finite or not a rotation
  stop,                  // a stop with its ends crossed, negative gains or no width
  contact_sphere,        // a sphere without radius, of no body or material, or not in the order of the bodies
  contact_surface,  // a shape that is not valid, of no body or material, or not in the order of the bodies
  contact_law,      // a negative stiffness, damping or friction, or a law that is not that of b and a
  net,             // too many nodes or springs, a node without mass or body, carriers or springs out of order
  net_attachment,  // too many, of no node or body, to the node's own carrier, out of order, or negative
  term,            // between missing bodies, or with a negative or non-finite number
  not_imposable,   // a prescribed joint of a kind without coordinates of its own: free, fixed or ball
};

/// Returns the rule as a sentence.
constexpr const char* text_of(Invalid rule) noexcept {
  switch (rule) {
    case Invalid::nothing: return "all parameters are valid";
    case Invalid::step_not_positive: return "the step h must be finite and above 0 s";
    case Invalid::gravity: return "gravity must be finite";
    case Invalid::too_many_bodies: return "num_bodies must be 1 to the scene's max_bodies";
    case Invalid::mass_not_positive: return "the mass must be finite and above 0 kg";
    case Invalid::inertia_not_positive: return "the inertia must be symmetric and positive definite";
    case Invalid::anisotropy_too_small: return "the anisotropy must be that of the inertia: use rigid_body()";
    case Invalid::gain_negative: return "stiffness, damping, limits and ramp must be finite and at least 0";
    case Invalid::parent_not_before: return "the joint's parent must be the world or an earlier body";
    case Invalid::joint_frame: return "the joint's frames must be finite, their matrices rotations";
    case Invalid::stop:
      return "a stop needs lower below upper, gains of at least 0 and a "
             "width";
    case Invalid::contact_sphere:
      return "the sphere needs a radius above 0 m, a body and a material, and the order of the bodies";
    case Invalid::contact_surface:
      return "the surface needs a valid shape, a body or the world, a material, and the order of the bodies";
    case Invalid::contact_law:
      return "contact laws need gains of at least 0, a tangent where there is friction, and symmetry";
    case Invalid::net:
      return "nets must fit into the scene's room, nodes with a mass, carriers and springs in order";
    case Invalid::net_attachment:
      return "an attachment needs a node, another body than its carrier, gains of at least 0, and the order";
    case Invalid::term: return "a term needs bodies that are there, and numbers of at least 0";
    case Invalid::not_imposable:
      return "an imposed joint needs coordinates of its own: no fixed or ball joint";
  }
  return "unknown rule";
}

/// First rule that a parameter set breaks and the element that breaks it. Compares as the rule.
struct Validity {
  static constexpr std::size_t none = ~std::size_t{0};
  Invalid rule = Invalid::nothing;
  std::size_t index =
      none;  // index of the body, or of the sphere or surface that the rule is about; none: no element

  // NOLINTNEXTLINE(google-explicit-constructor)
  constexpr Validity(Invalid broken = Invalid::nothing, std::size_t at = none) noexcept
      : rule(broken), index(at) {}
  // NOLINTNEXTLINE(google-explicit-constructor)
  constexpr operator Invalid() const noexcept { return rule; }

  /// Returns a text such as "body 2: the mass must be finite and above 0 kg", zero-terminated.
  constexpr std::array<char, 160> text() const noexcept {
    std::array<char, 160> text{};
    std::size_t end = 0;
    const auto add = [&](const char* part) {
      for (; *part != 0 && end + 1 < text.size(); ++part) text[end++] = *part;
    };
    if (index != none) {
      add(rule == Invalid::contact_sphere    ? "sphere "
          : rule == Invalid::contact_surface ? "surface "
                                             : "body ");
      std::array<char, 21> digits{};
      std::size_t first = digits.size() - 1, rest = index;
      do digits[--first] = static_cast<char>('0' + rest % 10);
      while ((rest /= 10) > 0);
      add(&digits[first]);
      add(": ");
    }
    add(text_of(rule));
    return text;
  }
};

}  // namespace godobject
