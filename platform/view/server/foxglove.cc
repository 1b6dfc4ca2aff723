#include "platform/view/server/server.h"

#include <algorithm>
#include <cstring>

#include <nlohmann/json.hpp>

#include "platform/view/frame.h"

namespace godobject {
namespace {

using Json = nlohmann::ordered_json;

/// Interval of updates of nets, because their JSON is long.
constexpr std::uint64_t net_period_ns = 100'000'000;

enum Channel : std::uint32_t { transforms_channel, scene_channel, num_channels };

// Used parts of Foxglove's own schemas.
Json number() { return {{"type", "number"}}; }
Json object(Json properties) { return {{"type", "object"}, {"properties", std::move(properties)}}; }
Json list(Json items) { return {{"type", "array"}, {"items", std::move(items)}}; }
Json time_schema() { return object({{"sec", {{"type", "integer"}}}, {"nsec", {{"type", "integer"}}}}); }
Json vector_schema() { return object({{"x", number()}, {"y", number()}, {"z", number()}}); }
Json quaternion_schema() {
  return object({{"x", number()}, {"y", number()}, {"z", number()}, {"w", number()}});
}
Json text_schema() { return {{"type", "string"}}; }
Json colour_schema() { return object({{"r", number()}, {"g", number()}, {"b", number()}, {"a", number()}}); }
Json pose_schema() { return object({{"position", vector_schema()}, {"orientation", quaternion_schema()}}); }

Json transforms_schema() {
  Json transform = object({{"timestamp", time_schema()},
                           {"parent_frame_id", text_schema()},
                           {"child_frame_id", text_schema()},
                           {"translation", vector_schema()},
                           {"rotation", quaternion_schema()}});
  transform["title"] = "foxglove.FrameTransform";
  Json schema = object({{"transforms", list(std::move(transform))}});
  schema["title"] = "foxglove.FrameTransforms";
  return schema;
}

Json scene_schema() {
  const Json cube = object({{"pose", pose_schema()}, {"size", vector_schema()}, {"color", colour_schema()}});
  Json cylinder = cube, mesh = object({{"pose", pose_schema()},
                                       {"points", list(vector_schema())},
                                       {"color", colour_schema()},
                                       {"indices", list({{"type", "integer"}})}});
  cylinder["properties"]["bottom_scale"] = cylinder["properties"]["top_scale"] = number();
  Json entity = object({{"timestamp", time_schema()},
                        {"frame_id", text_schema()},
                        {"id", text_schema()},
                        {"lifetime", time_schema()},
                        {"frame_locked", {{"type", "boolean"}}},
                        {"metadata", list(object({{"key", text_schema()}, {"value", text_schema()}}))},
                        {"cubes", list(cube)},
                        {"spheres", list(cube)},
                        {"cylinders", list(cylinder)},
                        {"triangles", list(mesh)}});
  for (const char* none : {"arrows", "lines", "texts", "models"})
    entity["properties"][none] = list(object(Json::object()));
  entity["title"] = "foxglove.SceneEntity";
  Json schema = object(
      {{"deletions",
        list(object({{"timestamp", time_schema()}, {"type", {{"type", "integer"}}}, {"id", text_schema()}}))},
       {"entities", list(std::move(entity))}});
  schema["title"] = "foxglove.SceneUpdate";
  return schema;
}

Json channel(std::uint32_t id, const char* topic, const char* schema_name, const Json& schema) {
  return {{"id", id},
          {"topic", topic},
          {"encoding", "json"},
          {"schemaName", schema_name},
          {"schema", schema.dump()},
          {"schemaEncoding", "jsonschema"}};
}

Json time_of(std::uint64_t ns) { return {{"sec", ns / 1'000'000'000}, {"nsec", ns % 1'000'000'000}}; }
Json vector_of(const Json& a, std::size_t first = 0) {
  return {{"x", a[first]}, {"y", a[first + 1]}, {"z", a[first + 2]}};
}
Json pose_of(const Json& pose) {
  return {{"position", vector_of(pose)},
          {"orientation", {{"x", pose[3]}, {"y", pose[4]}, {"z", pose[5]}, {"w", pose[6]}}}};
}
Json size_of(double x, double y, double z) { return {{"x", x}, {"y", y}, {"z", z}}; }

float float_at(std::span<const std::uint8_t> frame, std::size_t place) noexcept {
  float value = 0;
  ByteReader(frame.subspan(place)).get(value);
  return value;
}

/// Returns a pose of a frame as a transform.
Json transform_of(std::span<const std::uint8_t> frame, std::size_t place, const std::string& child,
                  const Json& time) {
  std::array<float, 7> x{};
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = float_at(frame, place + 4 * i);
  return {{"timestamp", time},
          {"parent_frame_id", "world"},
          {"child_frame_id", child},
          {"translation", {{"x", x[0]}, {"y", x[1]}, {"z", x[2]}}},
          {"rotation", {{"x", x[3]}, {"y", x[4]}, {"z", x[5]}, {"w", x[6]}}}};
}

/// Returns opcode, subscription, time and text as one message.
FoxgloveClient::Bytes message(std::uint32_t subscription, std::uint64_t now_ns, const std::string& text) {
  constexpr std::size_t head_bytes = 13;
  constexpr std::uint8_t message_data = 1;
  auto bytes = std::make_shared<std::vector<std::uint8_t>>(head_bytes + text.size());
  ByteWriter(*bytes).put(message_data).put(subscription).put(now_ns);
  std::memcpy(bytes->data() + head_bytes, text.data(), text.size());
  return bytes;
}

}  // namespace

struct FoxgloveClient::Scene {
  std::vector<std::string> bodies;
  std::vector<std::size_t> driven;
  Json about;

  /// Returns an empty entity of this id in this coordinate frame.
  static Json empty_entity(const Json& time, const Json& frame, const std::string& id) {
    Json entity{{"timestamp", time},
                {"frame_id", frame},
                {"id", id},
                {"lifetime", time_of(0)},
                {"frame_locked", true}};
    for (const char* part :
         {"metadata", "arrows", "cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models"})
      entity[part] = Json::array();
    return entity;
  }

  /// Returns a net as triangles between its nodes, which are in the world. vertices: the net's own vertices
  /// in a frame.
  static Json net_entity(const Json& time, const Json& surface, std::span<const std::uint8_t> vertices) {
    Json entity = empty_entity(time, "world", "net " + surface["name"].get<std::string>());
    Json points = Json::array();
    for (std::size_t at = 0; at < vertices.size(); at += frame_vertex_bytes)
      points.push_back(
          size_of(float_at(vertices, at), float_at(vertices, at + 4), float_at(vertices, at + 8)));
    entity["triangles"].push_back({{"pose", pose_of({0, 0, 0, 0, 0, 0, 1})},
                                   {"points", std::move(points)},
                                   {"color", {{"r", 0.84}, {"g", 0.27}, {"b", 0.17}, {"a", 1.0}}},
                                   {"colors", Json::array()},
                                   {"indices", surface["triangles"]}});
    return entity;
  }

  /// Returns a solid as an entity, in the frame of its body or in the world.
  Json entity(const Json& time, std::size_t number, const Json& solid) const {
    const bool on_body = !solid["body"].is_null(),
               is_tool =
                   on_body && std::ranges::find(driven, solid["body"].get<std::size_t>()) != driven.end();
    const Json colour = !on_body  ? Json{{"r", 0.66}, {"g", 0.64}, {"b", 0.58}, {"a", 0.8}}
                        : is_tool ? Json{{"r", 0.84}, {"g", 0.27}, {"b", 0.17}, {"a", 1.0}}
                                  : Json{{"r", 0.49}, {"g", 0.62}, {"b", 0.78}, {"a", 1.0}};
    Json entity =
        empty_entity(time, on_body ? Json(bodies.at(solid["body"].get<std::size_t>())) : Json("world"),
                     std::to_string(number) + " " + solid["name"].get<std::string>());
    const std::string kind = solid["kind"];
    const double a = solid["size"][0], b = solid["size"][1], c = solid["size"][2];
    Json shape{{"pose", pose_of(solid["pose"])}, {"color", colour}};
    constexpr double plane_size = 2, plane_thickness = 1e-4;
    if (kind == "box") shape["size"] = size_of(2 * a, 2 * b, 2 * c);
    else if (kind == "plane") shape["size"] = size_of(plane_size, plane_size, plane_thickness);
    else if (kind == "sphere") shape["size"] = size_of(2 * a, 2 * a, 2 * a);
    else if (kind != "mesh") shape["size"] = size_of(2 * a, 2 * a, 2 * b + (kind == "capsule" ? 2 * a : 0));
    if (kind == "cylinder" || kind == "capsule") {
      shape["bottom_scale"] = shape["top_scale"] = 1.0;
      entity["cylinders"].push_back(std::move(shape));
    } else if (kind == "mesh") {
      const Json& mesh = about["meshes"][solid["mesh"].get<std::size_t>()];
      shape["points"] = Json::array();
      for (std::size_t i = 0; i + 2 < mesh["vertices"].size(); i += 3)
        shape["points"].push_back(vector_of(mesh["vertices"], i));
      shape["colors"] = Json::array();
      shape["indices"] = mesh["triangles"];
      entity["triangles"].push_back(std::move(shape));
    } else {
      entity[kind == "sphere" ? "spheres" : "cubes"].push_back(std::move(shape));
    }
    return entity;
  }
};

std::string foxglove_transforms_schema() { return transforms_schema().dump(); }

FoxgloveClient::FoxgloveClient() = default;
FoxgloveClient::~FoxgloveClient() = default;

std::vector<std::string> FoxgloveClient::greeting(const std::string& scene) {
  scene_ = std::make_unique<Scene>();
  scene_->about = Json::parse(scene);
  for (const Json& body : scene_->about["bodies"]) scene_->bodies.push_back(body["name"]);
  for (const Json& body : scene_->about["driven"]) scene_->driven.push_back(body);
  const Json info{{"op", "serverInfo"},
                  {"name", "godobject"},
                  {"capabilities", Json::array()},
                  {"supportedEncodings", {"json"}},
                  {"metadata", Json::object()}};
  const Json channels{{"op", "advertise"},
                      {"channels",
                       {channel(transforms_channel, "/tf", "foxglove.FrameTransforms", transforms_schema()),
                        channel(scene_channel, "/scene", "foxglove.SceneUpdate", scene_schema())}}};
  return {info.dump(), channels.dump()};
}

std::string FoxgloveClient::take(bool is_text, std::span<const std::uint8_t> message) {
  const auto complaint = [](const char* why) {
    return Json{{"op", "status"}, {"level", 2}, {"message", why}}.dump();
  };
  if (!is_text) return complaint("this server accepts no binary messages");
  const Json json = Json::parse(message.begin(), message.end(), nullptr, false);
  if (!json.is_object() || !json.contains("op") || !json["op"].is_string())
    return complaint("not a message of foxglove.websocket.v1");
  if (json["op"] == "subscribe" && json.contains("subscriptions") && json["subscriptions"].is_array()) {
    for (const Json& wanted : json["subscriptions"]) {
      if (!wanted.is_object() || !wanted.contains("id") || !wanted["id"].is_number_unsigned() ||
          !wanted.contains("channelId") || !wanted["channelId"].is_number_unsigned() ||
          wanted["channelId"] >= num_channels)
        return complaint("subscribe: unknown channel");
      subscriptions_.at(wanted["channelId"].get<std::size_t>()) = wanted["id"].get<std::uint32_t>();
      if (wanted["channelId"] == scene_channel) solids_due_ = true;
    }
  } else if (json["op"] == "unsubscribe" && json.contains("subscriptionIds") &&
             json["subscriptionIds"].is_array()) {
    for (auto& subscription : subscriptions_)
      for (const Json& id : json["subscriptionIds"])
        if (subscription && id == *subscription) subscription.reset();
  }
  return "";
}

/// Sends entities that are due: solids once, nets ten times a second. They stay due while the client is busy.
void FoxgloveClient::show_entities(std::span<const std::uint8_t> frame, std::uint64_t now_ns,
                                   const std::function<bool(Bytes)>& send) {
  const Json& surfaces = scene_->about["surfaces"];
  const bool nets_due = !surfaces.empty() && now_ns - nets_sent_ns_ >= net_period_ns;
  if (!subscriptions_[scene_channel] || (!solids_due_ && !nets_due)) return;
  const Json time = time_of(now_ns);
  Json update{{"deletions", Json::array()}, {"entities", Json::array()}};
  std::size_t number = 0;
  if (solids_due_)
    for (const Json& solid : scene_->about["solids"])
      if (solid["role"] != "contact") update["entities"].push_back(scene_->entity(time, number++, solid));
  // bytes from a net's first vertex to the end of the frame, where the values are
  std::size_t left = scene_->about["values"].size() * frame_value_bytes;
  for (const Json& surface : surfaces)
    left += surface["num_vertices"].get<std::size_t>() * frame_vertex_bytes;
  if (left > frame.size()) return;
  for (const Json& surface : surfaces) {
    const std::size_t size = surface["num_vertices"].get<std::size_t>() * frame_vertex_bytes;
    update["entities"].push_back(Scene::net_entity(time, surface, frame.last(left).first(size)));
    left -= size;
  }
  if (!send(message(*subscriptions_[scene_channel], now_ns, update.dump()))) return;
  solids_due_ = false;
  nets_sent_ns_ = now_ns;
}

void FoxgloveClient::show(std::span<const std::uint8_t> frame, std::uint64_t now_ns,
                          const std::function<bool(Bytes)>& send) {
  if (!scene_ || frame.size() < frame_header_bytes + scene_->bodies.size() * frame_body_bytes +
                                    scene_->driven.size() * frame_driven_bytes)
    return;
  show_entities(frame, now_ns, send);
  if (!subscriptions_[transforms_channel]) return;
  const Json time = time_of(now_ns);
  Json transforms = Json::array();
  for (std::size_t i = 0; i < scene_->bodies.size(); ++i)
    transforms.push_back(
        transform_of(frame, frame_header_bytes + i * frame_body_bytes, scene_->bodies[i], time));
  const std::size_t targets = frame_header_bytes + scene_->bodies.size() * frame_body_bytes;
  for (std::size_t i = 0; i < scene_->driven.size(); ++i)
    transforms.push_back(transform_of(frame, targets + i * frame_driven_bytes,
                                      scene_->bodies.at(scene_->driven[i]) + "/device", time));
  static_cast<void>(send(message(*subscriptions_[transforms_channel], now_ns,
                                 Json{{"transforms", std::move(transforms)}}.dump())));
}

}  // namespace godobject
