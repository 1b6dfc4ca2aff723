// Rasterises triangles: a depth buffer, one light beside the camera, four samples a pixel.
#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "platform/view/picture/picture.h"

namespace godobject {
namespace {

constexpr std::uint32_t samples = 2;     // per side of a pixel
constexpr double field_of_view = 0.698;  // rad, vertical
constexpr Colour back{0xf4, 0xf5, 0xf7}, edge_colour{0x2a, 0x34, 0x42};

/// Screen point: x right, y down, in samples; z: inverse distance, larger if nearer.
struct Point {
  double x = 0, y = 0, z = 0;
};

class Camera {
 public:
  Camera(const Picture& picture, double width, double height)
      : half_width_(0.5 * width), half_height_(0.5 * height) {
    back_ = Vec3(-0.38, -0.8, 0.46).normalized();
    right_ = Vec3::UnitZ().cross(back_).normalized();
    up_ = back_.cross(right_);
    scale_ = half_height_ / std::tan(0.5 * field_of_view);
    near_ = 0.05 * picture.extent;
    fit(picture);
    light_ = (back_ + 0.5 * up_ + 0.35 * right_).normalized();
  }
  double depth(const Vec3& p) const { return (eye_ - p).dot(back_); }
  double near() const { return near_; }
  Point seen(const Vec3& p) const {
    const Vec3 d = p - eye_;
    const double z = 1 / depth(p);
    return {
        .x = half_width_ + scale_ * d.dot(right_) * z, .y = half_height_ - scale_ * d.dot(up_) * z, .z = z};
  }
  /// Returns the share of light that a surface with this normal reflects; both sides alike.
  double shade(const Vec3& n) const { return 0.5 + 0.5 * std::abs(n.dot(light_)); }

 private:
  /// Sets the eye as in the page: the outline fills the picture, and is in its middle.
  void fit(const Picture& picture) {
    constexpr double margin = 1.05;
    constexpr int num_rounds = 3;  // the middle depends on the distance
    const double wide = margin * scale_ / half_width_, high = margin * scale_ / half_height_;
    Vec3 target = picture.centre;
    for (int round = 0; round < num_rounds; ++round) {
      double distance = 2 * near_;
      for (const Vec3& p : picture.outline) {
        const Vec3 d = p - target;
        const double across = std::max(wide * std::abs(d.dot(right_)), high * std::abs(d.dot(up_)));
        distance = std::max(distance, d.dot(back_) + across);
      }
      eye_ = target + distance * back_;
      Eigen::AlignedBox2d seen;
      for (const Vec3& p : picture.outline)
        seen.extend(Eigen::Vector2d((p - target).dot(right_), (p - target).dot(up_)) / depth(p));
      target += distance * (seen.center().x() * right_ + seen.center().y() * up_);
    }
  }

  double half_width_, half_height_, scale_ = 1, near_ = 0;
  Vec3 eye_, back_, right_, up_, light_;
};

class Canvas {
 public:
  Canvas(std::uint32_t width, std::uint32_t height)
      : width_(width),
        height_(height),
        pixels_(std::size_t{width} * height, back),
        depth_(pixels_.size(), 0) {}

  void triangle(const Point& a, const Point& b, const Point& c, const Colour& colour) {
    const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (!(std::abs(area) > 0)) return;
    const int left = clamped(std::min({a.x, b.x, c.x}), width_),
              right = clamped(std::max({a.x, b.x, c.x}) + 1, width_);
    const int top = clamped(std::min({a.y, b.y, c.y}), height_),
              bottom = clamped(std::max({a.y, b.y, c.y}) + 1, height_);
    for (int y = top; y < bottom; ++y)
      for (int x = left; x < right; ++x) {
        const double px = x + 0.5, py = y + 0.5;
        const double u = ((b.x - px) * (c.y - py) - (b.y - py) * (c.x - px)) / area;
        const double v = ((c.x - px) * (a.y - py) - (c.y - py) * (a.x - px)) / area;
        const double w = 1 - u - v;
        if (u >= 0 && v >= 0 && w >= 0) put(x, y, u * a.z + v * b.z + w * c.z, colour);
      }
  }
  /// Draws a band of this width, in samples.
  void line(const Point& a, const Point& b, double width, const Colour& colour) {
    const double dx = b.x - a.x, dy = b.y - a.y, length = std::hypot(dx, dy);
    if (!(length > 0)) return;
    const double nx = -0.5 * width * dy / length, ny = 0.5 * width * dx / length;
    const Point a1{a.x + nx, a.y + ny, a.z}, a2{a.x - nx, a.y - ny, a.z}, b1{b.x + nx, b.y + ny, b.z},
        b2{b.x - nx, b.y - ny, b.z};
    triangle(a1, a2, b1, colour);
    triangle(b1, a2, b2, colour);
  }
  /// Sets the opacity of all further drawing.
  void set_opacity(double opacity) { opacity_ = opacity; }
  /// Draws all further items in front of the present picture.
  void clear_depth() { std::ranges::fill(depth_, 0.0); }

  Image image() const {
    Image image{.width = width_ / samples, .height = height_ / samples, .rgb = {}};
    for (std::uint32_t y = 0; y < image.height; ++y)
      for (std::uint32_t x = 0; x < image.width; ++x)
        for (std::size_t channel = 0; channel < 3; ++channel) {
          unsigned sum = 0;
          for (std::uint32_t i = 0; i < samples * samples; ++i) {
            const std::size_t row = y * samples + i / samples, column = x * samples + i % samples;
            sum += pixels_[row * width_ + column][channel];
          }
          image.rgb.push_back(static_cast<std::uint8_t>(sum / (samples * samples)));
        }
    return image;
  }

 private:
  static int clamped(double x, std::uint32_t size) {
    return static_cast<int>(std::clamp(x, 0.0, static_cast<double>(size)));
  }
  void put(int x, int y, double z, const Colour& colour) {
    const std::size_t i = static_cast<std::size_t>(y) * width_ + static_cast<std::size_t>(x);
    if (z < depth_[i]) return;
    depth_[i] = z;
    for (std::size_t k = 0; k < colour.size(); ++k)
      pixels_[i][k] = static_cast<std::uint8_t>(opacity_ * colour[k] + (1 - opacity_) * pixels_[i][k]);
  }

  std::uint32_t width_, height_;
  double opacity_ = 1;
  std::vector<Colour> pixels_;
  std::vector<double> depth_;
};

/// Draws a line, clipped in front of the camera.
void draw_line(const Camera& camera, Vec3 a, Vec3 b, double width, double nearer, const Colour& colour,
               Canvas& canvas) {
  if (camera.depth(a) < camera.depth(b)) std::swap(a, b);
  const double far = camera.depth(a), near = camera.depth(b);
  if (far <= camera.near()) return;
  if (near < camera.near()) b = a + (b - a) * ((far - camera.near()) / (far - near));
  Point p = camera.seen(a), q = camera.seen(b);
  p.z *= nearer;
  q.z *= nearer;
  canvas.line(p, q, width, colour);
}

/// Draws a triangle, clipped in front of the camera.
void draw_triangle(const Camera& camera, const std::array<Vec3, 3>& corners, const Colour& colour,
                   Canvas& canvas) {
  std::vector<Point> kept;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 &a = corners[i], &b = corners[(i + 1) % 3];
    const double da = camera.depth(a) - camera.near(), db = camera.depth(b) - camera.near();
    if (da > 0) kept.push_back(camera.seen(a));
    if ((da > 0) != (db > 0)) kept.push_back(camera.seen(a + (b - a) * (da / (da - db))));
  }
  for (std::size_t i = 2; i < kept.size(); ++i) canvas.triangle(kept[0], kept[i - 1], kept[i], colour);
}

void draw_mesh(const Camera& camera, const PictureMesh& item, Canvas& canvas) {
  for (const TriangleIndices& t : item.mesh.triangles) {
    const std::array corners{item.mesh.vertices[t[0]], item.mesh.vertices[t[1]], item.mesh.vertices[t[2]]};
    const Vec3 n = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
    Colour colour = item.colour;
    if (!item.in_front)
      for (std::uint8_t& channel : colour) channel = static_cast<std::uint8_t>(camera.shade(n) * channel);
    draw_triangle(camera, corners, colour, canvas);
  }
  constexpr double lift = 1.002;  // moves edges in front of their own faces
  if (!item.has_edges) return;
  for (std::uint32_t face = 0; face + 4 <= item.mesh.vertices.size(); face += 4)
    for (std::uint32_t i = 0; i < 4; ++i)
      draw_line(camera, item.mesh.vertices[face + i], item.mesh.vertices[face + (i + 1) % 4], 1.2, lift,
                edge_colour, canvas);
}

}  // namespace

Image drawn(const Picture& picture, std::uint32_t width, std::uint32_t height) {
  Canvas canvas(width * samples, height * samples);
  const Camera camera(picture, width * samples, height * samples);
  for (const PictureMesh& mesh : picture.meshes)
    if (!mesh.in_front) draw_mesh(camera, mesh, canvas);
  canvas.clear_depth();
  constexpr double wire_width = 2.6;
  for (const PictureWires& wires : picture.wires) {
    canvas.set_opacity(wires.opacity);
    for (const auto& [a, b] : wires.lines) draw_line(camera, a, b, wire_width, 1, wires.colour, canvas);
  }
  canvas.set_opacity(1);
  canvas.clear_depth();
  for (const PictureMesh& mesh : picture.meshes)
    if (mesh.in_front) draw_mesh(camera, mesh, canvas);
  return canvas.image();
}

}  // namespace godobject
