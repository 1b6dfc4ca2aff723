#include "platform/simulated/truth.h"

namespace godobject {

SimulatedTruth::SimulatedTruth(const SceneConfig& scene, std::shared_ptr<const Hand> hand,
                               const SimLink* link)
    : scene_(scene),
      hand_(std::move(hand)),
      link_(link),
      driven_(driven_bodies(scene)),
      handle_(driven_.size()),
      takes_hold_(takes_hold(scene)) {
  if (link_ == nullptr) return;
  const std::vector<std::optional<std::size_t>> by_handle = driven_by_handles(scene);
  for (std::size_t k = 0; k < by_handle.size(); ++k)
    if (by_handle[k]) handle_[*by_handle[k]] = k;
  joints_ = LedJoints(scene);
}

void SimulatedTruth::start(std::span<const BodySample> samples) {
  samples_.assign(samples.begin(), samples.end());
  std::string why_not;
  engine_ = make_engine(scene_, samples_, why_not);
}

/// Where what moves this driven body really is; where nothing does, the hand's target.
Target SimulatedTruth::handle(std::size_t driven, double t) const noexcept {
  const std::size_t target = takes_hold_ ? 0 : driven;
  if (handle_[target]) return link_->rig().handle(*handle_[target]);
  return hand_->target(target, t);
}

void SimulatedTruth::step(double t, std::span<const BodySample> samples) noexcept {
  std::ranges::copy(samples, samples_.begin());
  for (BodySample& sample : samples_) sample.valid = true;
  for (std::size_t i = 0; i < driven_.size(); ++i) {
    const Target target = handle(i, t);
    samples_[driven_[i]].X_WD = target.X_WD;
    samples_[driven_[i]].V_WD = target.V_WD;
  }
  if (link_ != nullptr) joints_.lead(link_->rig().joints(), true, samples_);
  for (std::size_t i = 0; i < samples_.size(); ++i) samples_[i].engaged = samples[i].engaged;
  static_cast<void>(engine_->step(samples_));
}

void SimulatedTruth::measure(std::span<const BodySample> samples, CycleRecord& record) const noexcept {
  const bool relative = scene_.device->kind == DeviceKind::relative;
  const bool offset = relative || takes_hold_;  // between handle and target
  record.following = record.sensing = record.exact_following = record.encoders = {};
  for (const std::size_t body : driven_) {
    if (takes_hold_ && record.held != body) continue;
    const BodyView& view = record.bodies[body];
    const BodyView exact = engine_->view(body);
    const Pose& X_WH = samples_[body].X_WD;
    record.following = worst(record.following, difference(view.X_WB, offset ? view.target.X_WD : X_WH));
    record.sensing = worst(record.sensing, difference(samples[body].X_WD, X_WH));
    record.exact_following =
        worst(record.exact_following, difference(exact.X_WB, offset ? exact.target.X_WD : X_WH));
    record.encoders = worst(record.encoders, difference(view.X_WB, exact.X_WB));
  }
}

std::vector<double> SimulatedTruth::bus_load_percent() const {
  std::vector<double> loads;
  if (link_ != nullptr)
    for (std::size_t i = 0; i < scene_.device->rig->buses.size(); ++i)
      loads.push_back(link_->load_percent(i));
  return loads;
}

}  // namespace godobject
