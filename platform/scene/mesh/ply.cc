// PLY, text and binary: a header that describes elements and their properties, then the numbers.
#include <bit>
#include <cmath>
#include <cstring>

#include "platform/scene/mesh/file.h"
#include "platform/scene/text/diagnostics.h"

namespace godobject {
namespace {

enum class Type : std::uint8_t { i8, u8, i16, u16, i32, u32, f32, f64 };

std::optional<Type> type_named(std::string_view name) {
  static constexpr std::array<std::string_view, 8> names{"char", "uchar", "short", "ushort",
                                                         "int",  "uint",  "float", "double"};
  static constexpr std::array<std::string_view, 8> sized{"int8",  "uint8",  "int16",   "uint16",
                                                         "int32", "uint32", "float32", "float64"};
  for (std::size_t i = 0; i < names.size(); ++i)
    if (name == names[i] || name == sized[i]) return static_cast<Type>(i);
  return std::nullopt;
}

struct Property {
  std::string_view name;
  Type type = Type::f32;
  std::optional<Type> count{};  // type of a list's length
};

struct Element {
  std::string_view name;
  std::uint64_t number = 0;
  std::vector<Property> properties{};
};

/// Reads the numbers after the header. After the last, or an invalid one, wrong() has the error.
class Numbers {
 public:
  enum class Form : std::uint8_t { text, little_endian, big_endian };

  Numbers(std::string_view file, Form form) : form_(form), text_(file), bytes_(file) {}

  double next(Type type) {
    switch (type) {
      case Type::i8: return next<std::int8_t>();
      case Type::u8: return next<std::uint8_t>();
      case Type::i16: return next<std::int16_t>();
      case Type::u16: return next<std::uint16_t>();
      case Type::i32: return next<std::int32_t>();
      case Type::u32: return next<std::uint32_t>();
      case Type::f32: return next<float>();
      case Type::f64: return next<double>();
    }
    return 0;
  }
  const std::string& wrong() const { return wrong_; }

 private:
  template <class T>
  double next() {
    if (form_ == Form::text) return next_word();
    std::array<char, sizeof(T)> bytes{};
    if (bytes_.size() < bytes.size()) return ended();
    std::ranges::copy(bytes_.substr(0, bytes.size()), bytes.begin());
    bytes_.remove_prefix(bytes.size());
    const bool native = (form_ == Form::little_endian) == (std::endian::native == std::endian::little);
    if (!native) std::ranges::reverse(bytes);
    return static_cast<double>(std::bit_cast<T>(bytes));
  }
  double next_word() {
    const std::string_view word = text_.word();
    if (word.empty()) return ended();
    const std::optional<double> number = number_of<double>(word);
    if (!number && wrong_.empty()) wrong_ = excerpt(word) + " is not a number";
    return number.value_or(0);
  }
  double ended() {
    if (wrong_.empty()) wrong_ = "the file ends too early: export it again";
    return 0;
  }

  Form form_;
  TextScanner text_;
  std::string_view bytes_;
  std::string wrong_{};
};

struct Header {
  Numbers::Form form = Numbers::Form::text;
  std::vector<Element> elements{};
};

std::string read_property(std::string_view line, std::vector<Element>& elements) {
  if (elements.empty()) return "a property before the first element";
  Property property;
  std::string_view type = TextScanner::first_word(line);
  if (type == "list") {
    const std::string_view count = TextScanner::first_word(line);
    property.count = type_named(count);
    if (!property.count || *property.count >= Type::f32) return excerpt(count) + " is not a type of a count";
    type = TextScanner::first_word(line);
  }
  const std::optional<Type> known = type_named(type);
  if (!known) return excerpt(type) + " is not a type of PLY";
  property.type = *known;
  property.name = TextScanner::first_word(line);
  elements.back().properties.push_back(property);
  return "";
}

std::string read_element(std::string_view line, std::vector<Element>& elements) {
  const std::string_view name = TextScanner::first_word(line), count = TextScanner::first_word(line);
  const std::optional<std::uint64_t> number = number_of<std::uint64_t>(count);
  if (!number) return excerpt(count) + " is not a number of elements";
  elements.push_back({.name = name, .number = *number});
  return "";
}

std::string read_format(std::string_view line, Header& header) {
  static constexpr std::array<std::string_view, 3> forms{"ascii", "binary_little_endian",
                                                         "binary_big_endian"};
  const std::string_view form = TextScanner::first_word(line);
  const auto* const found = std::ranges::find(forms, form);
  if (found == forms.end()) return excerpt(form) + " is not a format of PLY";
  header.form = static_cast<Numbers::Form>(found - forms.begin());
  return "";
}

/// Reads up to the line "end_header"; `text` is then at the first number.
std::string read_header(TextScanner& text, Header& header) {
  bool has_format = false;
  while (!text.rest().empty()) {
    const std::size_t number = text.line();
    std::string_view line = text.rest_of_line();
    const std::string_view word = TextScanner::first_word(line);
    std::string wrong;
    if (word == "end_header") return has_format ? "" : "the header has no line \"format\"";
    if (word == "format") {
      wrong = read_format(line, header);
      has_format = true;
    } else if (word == "element") {
      wrong = read_element(line, header.elements);
    } else if (word == "property") {
      wrong = read_property(line, header.elements);
    } else if (word != "ply" && word != "comment" && word != "obj_info" && !word.empty()) {
      wrong = excerpt(word) + " is not a word of a PLY header";
    }
    if (!wrong.empty()) return "line " + std::to_string(number) + ": " + wrong;
  }
  return "the header has no line \"end_header\": export the file again";
}

const Property* property_named(const Element& element, std::string_view name) {
  const auto found = std::ranges::find(element.properties, name, &Property::name);
  return found == element.properties.end() ? nullptr : &*found;
}

const Property* corners_of(const Element& face) {
  const Property* const indices = property_named(face, "vertex_indices");
  const Property* const corners = indices ? indices : property_named(face, "vertex_index");
  return corners && corners->count ? corners : nullptr;
}

/// Reads the elements one by one, and keeps corners and faces.
class Body {
 public:
  Body(Numbers numbers, MeshBuilder& mesh) : numbers_(std::move(numbers)), mesh_(mesh) {}

  std::string read(const Element& element) {
    const Property* const corners = element.name == "face" ? corners_of(element) : nullptr;
    std::array<const Property*, 3> axes{};
    if (element.name == "vertex")
      axes = {property_named(element, "x"), property_named(element, "y"), property_named(element, "z")};
    const bool is_vertex = element.name == "vertex", is_face = element.name == "face";
    if (is_vertex && std::ranges::any_of(axes, [](const Property* p) { return !p || p->count; }))
      return "vertices have no x, y and z";
    if (is_face && !corners) return "faces have no list vertex_indices";
    if (element.properties.empty() && element.number > 0)
      return "element " + excerpt(element.name) + " has no properties";
    for (std::uint64_t i = 0; i < element.number; ++i) {
      std::array<double, 3> p{};
      for (const Property& property : element.properties) {
        read_values(property, &property == corners);
        for (std::size_t axis = 0; axis < 3; ++axis)
          if (&property == axes[axis]) p[axis] = value_;
        if (!numbers_.wrong().empty()) return place(element, i) + numbers_.wrong();
      }
      std::string wrong;
      if (is_vertex) wrong = mesh_.add_vertex(p);
      if (is_face) wrong = mesh_.add_face(corners_, i);
      if (!wrong.empty()) return place(element, i) + wrong;
    }
    return "";
  }

 private:
  static std::string place(const Element& element, std::uint64_t i) {
    return shortened(element.name) + " " + std::to_string(i) + ": ";
  }

  /// Reads a number into value_, or the list of corners into corners_; other lists are skipped.
  void read_values(const Property& property, bool keep) {
    if (!property.count) {
      value_ = numbers_.next(property.type);
      return;
    }
    const double count = numbers_.next(*property.count);
    if (keep) corners_.clear();
    for (double k = 0; k < count && numbers_.wrong().empty(); ++k) {
      const double value = numbers_.next(property.type);
      if (keep) corners_.push_back(index_of(value));
    }
  }
  /// Returns the index, or an invalid one for a value that is not an index.
  static std::int64_t index_of(double value) {
    return value >= 0 && value < 4294967296.0 && value == std::floor(value) ? static_cast<std::int64_t>(value)
                                                                            : -1;
  }

  Numbers numbers_;
  MeshBuilder& mesh_;
  double value_ = 0;
  std::vector<std::int64_t> corners_;
};

}  // namespace

std::string read_ply(std::string_view file, MeshBuilder& mesh) {
  TextScanner text(file);
  if (!file.starts_with("ply")) return "does not begin with \"ply\"";
  Header header;
  std::string wrong = read_header(text, header);
  if (!wrong.empty()) return wrong;
  Body body(Numbers(text.rest(), header.form), mesh);
  for (const Element& element : header.elements) {
    const std::string problem = body.read(element);
    if (!problem.empty()) return problem;
  }
  return "";
}

}  // namespace godobject
